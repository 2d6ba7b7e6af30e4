"""The tables of an image set's page."""

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
# Two focal lengths, principal point, and two radial terms or four.
CAMERA_PARAMETERS = {"zhang": 6, PEER: 8}

EVERY_CORNER = (
    "Model",
    "Kept out: RMS (px)",
    "Median (px)",
    "Corners with a ray (%)",
    "Parts without a camera",
    "Terms",
    "Entrance pupil",
)


@table("ext_models", needs=("photograph_study",), evidence="photograph", per_set=BOARDS)
def ext_models(results):
    """Every model: size, errors where fitted and where kept out, coverage."""
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
        "The models on the same photographs. Shared corners are those that "
        "both Zhang and the general camera have a ray for. Fitted: all "
        "photographs for calibration, poses fitted again. Kept out: medians "
        "over photographs with 95 % intervals."
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
        "Kept out: RMS (px)": _median(errors),
        "Kept out: angle (deg)": _median(degrees),
        "Photographs": int(np.isfinite(errors).sum()),
        "Corners scored (%)": cell(100 * np.nansum(corners) / all_corners)
        if all_corners
        else None,
        "Picture with a ray (%)": cell(100 * study.fit(f"{model}.image_with_ray")),
    }


@table(
    "ext_every_corner",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_every_corner(results):
    """Every model on every corner that was kept out, the smallest error first."""
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
        "All models on every corner of the photographs kept out. A corner "
        f"that a model has no ray for counts as {MISSED_PX:g} px. The lens "
        "formulas (Kannala-Brandt, unified sphere) choose their terms by the "
        "photographs they are fitted to; whether their pupil moves is asked "
        "of a test, of boards kept out within these, and of both formulas.",
    )


def _pupil(study, model):
    """What became of the test for an entrance pupil that moves."""
    moves = study.fit(f"{model}.pupil.moves")
    if not np.isfinite(moves):
        return ""
    p_value = study.fit(f"{model}.pupil.p_value")
    chance = "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"
    said = "moves" if moves else "stands still"
    if study.fit(f"{model}.pupil.undecided") == 1:
        said = "undecided, taken to stand still"
    return f"{said} ({chance})"


def _median(values):
    values = values[np.isfinite(values)]
    return Measured(*median_interval(values)[:3]) if len(values) else None


def _whole(number):
    return int(number) if np.isfinite(number) else None
