"""Tables of an image set's page."""

import numpy as np

from chapters.shared.photographs.reading import (
    ALL_NAMES,
    BOARDS,
    EVERY,
    PEER,
    Study,
    column,
    counted,
    pooled_rms,
)
from raxel.evaluation.comparison import MISSED_PX
from repro.judge.statistics import median_interval
from repro.page.wording import literal
from repro.run.columns import cell, columns, in_columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

SHARED = "shared corners"
# Two focal lengths, principal point, and two or four radial terms.
CAMERA_PARAMETERS = {"zhang": 6, PEER: 8}

EVERY_CORNER = (
    "Model",
    "Held-out: RMS (px)",
    "Median (px)",
    "Corners with a ray (%)",
    "Parts without a camera",
    "Terms",
    "Entrance pupil",
)


@table("ext_models", needs=("photograph_study",), evidence="photograph", per_set=BOARDS)
def ext_models(results):
    """Tabulate size, fitted and held-out errors, and coverage of every model."""
    study = Study(results["photograph_study"])
    rows = [
        ("zhang", "own", "all corners"),
        (PEER, "own", "all corners"),
        ("zhang", "same", SHARED),
        (PEER, "same", SHARED),
        ("general", "same", SHARED),
    ]
    refused = [
        f"{name}: {literal(study.refusal(model))}."
        for model, name in ALL_NAMES.items()
        if study.refusal(model)
    ]
    caption = (
        "Errors and coverage of the models on the same images. Shared corners: "
        "corners with a ray of both Zhang and the general camera. Fitted: all images "
        "for calibration, poses fitted again. Held-out: medians over images with 95 % "
        "intervals."
    )
    return Table(
        in_columns(_model_row(study, *row) for row in rows),
        " ".join([caption, *refused]),
    )


def _model_row(study, model, kind, scored_on):
    parameters = CAMERA_PARAMETERS.get(model, 2 * study.fit("general.rays"))
    errors, degrees, corners = (
        column(study.held_out, kind, model, quantity)
        for quantity in ("rms_px", "mean_deg", "corners")
    )
    all_corners = sum(row.corners for row in study.held_out)
    return {
        "Model": ALL_NAMES[model],
        "Scored on": scored_on,
        "Parameters": None if study.refusal(model) else _whole(parameters),
        "Fitted: RMS (px)": cell(pooled_rms(study.in_sample, kind, model)),
        "Held-out: RMS (px)": _median(errors),
        "Held-out: angle (deg)": _median(degrees),
        "Images": int(np.isfinite(errors).sum()),
        "Corners scored (%)": cell(100 * np.nansum(corners) / all_corners)
        if all_corners
        else None,
        "Image with a ray (%)": cell(100 * study.fit(f"{model}.image_with_ray")),
    }


@table(
    "ext_every_corner",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_every_corner(results):
    """Tabulate every model on every held-out corner, smallest error first."""
    study = Study(results["photograph_study"])
    rows = [
        (
            name,
            found["rms_px"],
            found["median_px"],
            100 * found["share"],
            found["parts"],
            _whole(study.fit(f"{model}.terms")),
            _pupil(study, model),
        )
        for model, name in EVERY.items()
        if (found := counted(study, model)) is not None
    ]
    rows.sort(key=lambda row: row[1])
    return Table(
        columns(EVERY_CORNER, rows),
        "Errors of all models on every corner of the held-out images. A corner "
        f"without a ray counts as {MISSED_PX:g} px. The parametric models "
        "(Kannala-Brandt, unified sphere) select their terms from the fitted images. "
        "The entrance-pupil shift is decided by a test and by held-out boards within "
        "these images, jointly for both models.",
    )


def _pupil(study, model):
    """Return the outcome of the test for an entrance-pupil shift."""
    moves = study.fit(f"{model}.pupil.moves")
    if not np.isfinite(moves):
        return ""
    p_value = study.fit(f"{model}.pupil.p_value")
    level = "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"
    outcome = "moves" if moves else "fixed"
    if study.fit(f"{model}.pupil.undecided") == 1:
        outcome = "undecided, taken as fixed"
    return f"{outcome} ({level})"


def _median(values):
    values = values[np.isfinite(values)]
    return Measured(*median_interval(values)[:3]) if len(values) else None


def _whole(number):
    return int(number) if np.isfinite(number) else None
