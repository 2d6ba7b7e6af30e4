"""The tables of an image set's page."""

from __future__ import annotations

import math

import numpy as np

from chapters.photographs.set.results import study_of
from chapters.photographs.set.trials.detectors import UNSUITED
from chapters.shared.grid_detectors import (
    CELECT,
    CLICK_SD_PX,
    CLICKLESS,
    OPENCV,
    OPENCV_SB,
)
from chapters.shared.photographs.reading import NAMES, column, pooled_rms
from repro.judge.statistics import median_interval
from repro.page.wording import literal
from repro.run.experiment import table
from repro.run.outcomes import Table

NONE = "–"
# Zhang: two focal lengths, principal point, two radial terms.
CAMERA_PARAMETERS = 6

ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    CLICKLESS: "without clicks (ext.)",
}


def models_table(study):
    """Both models: size, errors where fitted and where kept out."""
    rows = [
        ("zhang", "own", "all corners"),
        ("zhang", "same", "corners both have a ray for"),
        ("general", "same", "corners both have a ray for"),
    ]
    made = [_model_row(study, *row) for row in rows]
    refused = [
        f"{NAMES[model]}: {literal(study.refusal(model))}."
        for model in NAMES
        if study.refusal(model)
    ]
    caption = (
        "Both models on the same photographs. Fitted: all photographs for "
        "calibration, poses fitted again. Kept out: median over photographs with "
        "its 95 % interval."
    )
    return Table(
        {name: [row[name] for row in made] for name in made[0]},
        " ".join([caption, *refused]),
    )


def _model_row(study, model, kind, scored_on):
    parameters = CAMERA_PARAMETERS
    if model == "general":
        parameters = _whole(2 * study.fit("general.rays"))
    if study.refusal(model):
        parameters = NONE
    errors = column(study.held_out, kind, model, "rms_px")
    degrees = column(study.held_out, kind, model, "mean_deg")
    scored = np.nansum(column(study.held_out, kind, model, "corners"))
    all_corners = sum(row.corners for row in study.held_out)
    middle, interval = _median(errors)
    return {
        "Model": NAMES[model],
        "Scored on": scored_on,
        "Parameters": parameters,
        "Fitted: RMS (px)": _known(
            pooled_rms(study.in_sample, kind, model)
        ),
        "Kept out: RMS (px)": middle,
        "95 % interval (px)": interval,
        "Kept out: angle (deg)": _median(degrees)[0],
        "Photographs": int(np.isfinite(errors).sum()),
        "Share of corners (%)": _known(100 * scored / all_corners)
        if all_corners
        else NONE,
    }


def images_table(study):
    """Every photograph: whether the board was found, and its errors kept out."""
    held_out = {row.image.index: row for row in study.held_out}
    made = [
        _image_row(study, i, held_out.get(i.index)) for i in study.images
    ]
    names = list(_image_row(study, None, None))
    if not any(row["Remark"] for row in made):
        names.remove("Remark")
    return Table(
        {name: [row[name] for row in made] for name in names},
        "Every photograph. Errors are RMS residuals in px when the photograph was "
        "kept out of the calibration; shared corners are those that both models "
        "have a ray for.",
        texts=("Photograph", "Remark"),
    )


def _image_row(study, image, row):
    """Cells of one photograph; of none, for the names of the columns."""

    def error(kind, model, quantity="rms_px"):
        return (
            NONE
            if row is None
            else _known(column([row], kind, model, quantity)[0])
        )

    shared = error("same", "zhang", "corners")
    return {
        "Photograph": image.name if image else "",
        "Corners": int(np.count_nonzero(np.isfinite(image.corners[:, 0])))
        if image
        else 0,
        "Shared": NONE if shared == NONE else int(shared),
        "Zhang, all": error("own", "zhang"),
        "Zhang, shared": error("same", "zhang"),
        "General, shared": error("same", "general"),
        "Remark": _remark(study, image, row) if image else "",
    }


def _remark(study, image, row):
    """Why something is missing in this photograph, in words."""
    if not image.found:
        return image.reason
    remarks = []
    if image.use == "evaluate":
        remarks.append("only evaluates")
    if image.index in study.left_out:
        remarks.append(
            f"not in the general camera: {study.left_out[image.index]}"
        )
    if row is not None:
        remarks += [
            f"kept out, {NAMES[model]}: {score.reason}"
            for model, score in row.own.items()
            if score.reason
        ]
    return "; ".join(remarks)


def _median(values):
    values = values[np.isfinite(values)]
    if not len(values):
        return NONE, NONE
    middle = median_interval(values)
    places = (
        2 - math.floor(math.log10(middle.high)) if middle.high > 0 else 0
    )
    interval = [
        f"{end:.{max(places, 0)}f}" for end in (middle.low, middle.high)
    ]
    return middle.value, " to ".join(interval)


def _known(number):
    return float(number) if np.isfinite(number) else NONE


def _whole(number):
    return int(number) if np.isfinite(number) else NONE


@table(
    "ext_images",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_images(results):
    """Every photograph: corners found, errors, remarks."""
    return images_table(study_of(results))


@table(
    "ext_models",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_models(results):
    """Both models: parameters, fit, prediction, coverage."""
    return models_table(study_of(results))


def detectors_table(result):
    """Counts and errors of every detector on the images of a set.

    A column in which nothing can be told is left out.
    """
    trials = [c for c in result.conditions if c["view"] >= 0]
    columns = {
        name: []
        for name in (
            "Method",
            "Images",
            "Returned",
            "Right",
            *(
                f"{statistic} {when} (px)"
                for when in ("before", "after")
                for statistic in ("Mean", "Max", "SD")
            ),
        )
    }
    for method, name in ROWS.items():
        row = [name, *_counted(result, trials, method)]
        for when in ("before", "after"):
            row += _statistics(result, trials, f"{method}.{when}")
        for cells, cell in zip(columns.values(), row, strict=True):
            cells.append(cell)
    told = {
        name: cells
        for name, cells in columns.items()
        if any(cell != NONE for cell in cells)
    }
    return Table(told, _caption(result, trials))


def _counted(result, trials, method):
    """Images that the method was given, boards returned, boards right."""
    if method == CELECT:
        trials = [c for c in trials if result.column("clicked", **c)[0]]
    if not trials:
        return [0, NONE, NONE]
    count = [
        int(sum(result.column(f"{method}.{what}", **c)[0] for c in trials))
        for what in ("returned", "right")
    ]
    judged = any(result.column("judged", **c)[0] for c in trials)
    return [len(trials), count[0], count[1] if judged else NONE]


def _statistics(result, trials, name):
    """Mean, maximum and SD (px) of the errors of right boards, as cells."""
    right = name.partition(".")[0] + ".right"
    trials = [c for c in trials if np.nansum(result.column(right, **c)) > 0]
    if not trials:
        return [NONE] * 3
    errors = [e for c in trials for e in result.arrays(name, **c)]
    errors = np.concatenate(errors)
    values = errors.mean(), errors.max(), errors.std(ddof=1)
    return [f"{value:.4f}" for value in values]


def _caption(result, trials):
    start = (
        "Tables 3.4 to 3.7 on these photographs: boards returned and right"
    )
    if not trials:
        return f"{start}. Nothing to compare: {UNSUITED}."
    if not any(result.column("judged", **c)[0] for c in trials):
        return (
            f"{start}. The set has no reference corners, so right and wrong "
            "cannot be told. CELECT runs where outer_corners are given."
        )
    return (
        f"{start}, and the errors of the corners of right boards before and "
        "after cornerSubPix, against the set's reference corners. CELECT has "
        "four clicks: those of set.yaml, or the reference's outer corners with "
        f"an error of {CLICK_SD_PX} px (SD per axis)."
    )


@table(
    "ext_detectors",
    needs=("photograph_detectors",),
    evidence="photograph",
    per_set=True,
)
def ext_detectors(results):
    """Detectors side by side: boards returned and right, errors."""
    return detectors_table(results["photograph_detectors"])
