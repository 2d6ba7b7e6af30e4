"""Tables of an active grid's page."""

import numpy as np

from chapters.photographs.active_grid.results import MODELS, STUDY, GridStudy, noises
from raxel.features.active_grid import REASONS
from repro.page.wording import literal
from repro.run.columns import cell
from repro.run.experiment import table
from repro.run.outcomes import Table

NEEDS = ("active_grid_study",)
KINDS = ("active_grid",)


@table("ext_grid_views", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_views(results):
    """Tabulate decoded and excluded pixels, noise and standard deviations by view."""
    study = GridStudy(results[STUDY])
    columns = {"View": study.names}
    for why in REASONS.values():
        shares = 100 * study.views.column(f"share.{why}")
        if max(shares) > 0:
            columns[f"{why.capitalize()} (%)"] = list(map(cell, shares))
    columns["Noise at grey value 100 (grey values)"] = list(map(cell, noises(study)))
    for axis in study.axes:
        for name, words in (("median", "median"), ("high", "90 % below")):
            found = study.views.column(f"spread.{axis}.{name}")
            title = f"σ {axis}, {words} ({study.settings['unit']})"
            columns[title] = list(map(cell, found))
        columns |= _of_response(study, axis)
    of_views = zip(study.reasons, study.views.texts("warnings"), strict=True)
    remarks = ["; ".join(filter(None, both)) for both in of_views]
    if any(remarks):
        columns["Remark"] = remarks
    return Table(
        columns,
        "Decoded and excluded pixels of every view, noise of a grey value of 100, and "
        "predicted standard deviation σ of a position. Shift by the response: effect "
        "of the nonlinear monitor and camera without correction (RMS). Left of it: "
        "after correction. A remark may reject a view.",
        texts=("View", "Remark"),
    )


def _of_response(study, axis):
    """Return columns of the response along an axis, none where it is not measured."""
    columns = {}
    for name, words in (("shift", "shift by the response"), ("left", "left of it")):
        found = study.views.column(f"response.{axis}.{name}")
        if np.isfinite(found).any():
            title = f"{words.capitalize()} {axis} ({study.settings['unit']})"
            columns[title] = list(map(cell, found))
    return columns


@table("ext_grid_camera", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_camera(results):
    """Tabulate the held-out errors of cameras from these views."""
    study = GridStudy(results[STUDY])
    caption = "Errors in held-out views of cameras from the decoded positions."
    if study.refusal():
        caption = f"{caption} None: {literal(study.refusal())}."
    columns = {"Model": list(MODELS.values())}
    for name, words in (
        ("rms_px", "RMS (px)"),
        ("median_px", "Median (px)"),
        ("mean_deg", "Mean angle (deg)"),
    ):
        found = (study.camera.column(f"{model}.{name}") for model in MODELS)
        columns[words] = [cell(*one) for one in found]
    return Table(columns, caption)
