"""The tables of an active grid's page."""

import numpy as np

from chapters.photographs.active_grid.results import MODELS, study_of
from raxel.features.active_grid import REASONS
from repro.page.wording import literal
from repro.run.columns import cell
from repro.run.experiment import table
from repro.run.outcomes import Table

NEEDS = ("active_grid_study",)
KINDS = ("active_grid",)


@table("ext_grid_views", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_views(results):
    """Every view: what became of its pixels, noise, standard deviations."""
    study = study_of(results)
    every = range(len(study.names))
    unit = study.settings["unit"]
    columns = {"View": list(study.names)}
    for why in REASONS.values():
        shares = [100 * study.number(f"share.{why}", k) for k in every]
        if max(shares) > 0:
            columns[f"{why.capitalize()} (%)"] = list(map(cell, shares))
    columns["Noise at grey 100 (1)"] = [_noise(study, k) for k in every]
    for axis in study.axes:
        for name, words in (("median", "median"), ("high", "90 % below")):
            columns[f"σ {axis}, {words} ({unit})"] = [
                cell(study.number(f"spread.{axis}.{name}", k)) for k in every
            ]
    remarks = [
        "; ".join(filter(None, (study.text("reason", k), study.text("warnings", k))))
        for k in every
    ]
    if any(remarks):
        columns["Remark"] = remarks
    return Table(
        columns,
        "Every view: shares of all its pixels by what became of them, the standard "
        "deviation of a grey value of 100, and that of a place. A view with a "
        "remark that refuses it goes no further.",
        texts=("View", "Remark"),
    )


def _noise(study, k):
    floor, slope = (study.number(f"noise.{name}", k) for name in ("floor", "slope"))
    return cell(np.sqrt(floor + 100 * slope))


@table("ext_grid_camera", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_grid_camera(results):
    """Cameras from these views, judged on views kept out."""
    study = study_of(results)
    why = study.refusal()
    caption = "Cameras from the decoded places, judged on views kept out."
    if why:
        caption = f"{caption} None: {literal(why)}."
    columns = {"Model": list(MODELS.values())}
    for name, words in (
        ("rms_px", "RMS (px)"),
        ("median_px", "Median (px)"),
        ("mean_deg", "Mean angle (deg)"),
    ):
        columns[words] = [cell(study.calibrated(f"{model}.{name}")) for model in MODELS]
    return Table(columns, caption)
