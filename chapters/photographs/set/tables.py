"""The tables of an image set's page."""

from __future__ import annotations

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
from chapters.shared.photographs.reading import (
    ALL_NAMES,
    BOARDS,
    EVERY,
    PEER,
    column,
    counted,
    pooled_rms,
)
from raxel.evaluation.comparison import MISSED_PX
from repro.judge.statistics import median_interval
from repro.page.wording import literal
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

SHARED = "shared corners"
# Two focal lengths, principal point, and two radial terms or four.
CAMERA_PARAMETERS = {"zhang": 6, PEER: 8}

ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    CLICKLESS: "without clicks (ext.)",
}


def models_table(study):
    """Every model: size, errors where fitted and where kept out, coverage."""
    rows = [
        ("zhang", "own", "all corners"),
        (PEER, "own", "all corners"),
        ("zhang", "same", SHARED),
        (PEER, "same", SHARED),
        ("general", "same", SHARED),
    ]
    made = [_model_row(study, *row) for row in rows]
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
        {name: [row[name] for row in made] for name in made[0]},
        " ".join([caption, *refused]),
    )


def _model_row(study, model, kind, scored_on):
    parameters = CAMERA_PARAMETERS.get(model)
    if model == "general":
        parameters = _whole(2 * study.fit("general.rays"))
    if study.refusal(model):
        parameters = None
    errors = column(study.held_out, kind, model, "rms_px")
    degrees = column(study.held_out, kind, model, "mean_deg")
    scored = np.nansum(column(study.held_out, kind, model, "corners"))
    all_corners = sum(row.corners for row in study.held_out)
    return {
        "Model": ALL_NAMES[model],
        "Scored on": scored_on,
        "Parameters": parameters,
        "Fitted: RMS (px)": _known(pooled_rms(study.in_sample, kind, model)),
        "Kept out: RMS (px)": _median(errors),
        "Kept out: angle (deg)": _median(degrees),
        "Photographs": int(np.isfinite(errors).sum()),
        "Corners scored (%)": _known(100 * scored / all_corners)
        if all_corners
        else None,
        "Picture with a ray (%)": _known(100 * study.fit(f"{model}.image_with_ray")),
    }


def every_corner_table(study):
    """Every model on every corner that was kept out, the smallest error first."""
    rows = [
        (name, found, study.fit(f"{model}.terms"), _pupil(study, model))
        for model, name in EVERY.items()
        if (found := counted(study, model)) is not None
    ]
    rows.sort(key=lambda row: row[1].rms_px)
    return Table(
        {
            "Model": [name for name, *_ in rows],
            "Kept out: RMS (px)": [found.rms_px for _, found, *_ in rows],
            "Median (px)": [found.median_px for _, found, *_ in rows],
            "Corners with a ray (%)": [100 * found.share for _, found, *_ in rows],
            "Parts without a camera": [found.parts for _, found, *_ in rows],
            "Terms": [_whole(terms) for *_, terms, _ in rows],
            "Entrance pupil": [pupil for *_, pupil in rows],
        },
        "All models on every corner of the photographs kept out. A corner "
        f"that a model has no ray for counts as {MISSED_PX:g} px. The lens "
        "formulas (Kannala-Brandt, unified sphere) choose their terms by the "
        "photographs they are fitted to; whether their pupil moves is asked "
        "of a test and of boards kept out within these.",
    )


def _pupil(study, model):
    """What became of the test for an entrance pupil that moves."""
    moves = study.fit(f"{model}.pupil.moves")
    if not np.isfinite(moves):
        return ""
    p_value = study.fit(f"{model}.pupil.p_value")
    said = "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"
    return f"{'moves' if moves else 'stands still'} ({said})"


def images_table(study):
    """Every photograph: whether the board was found, and its errors kept out."""
    held_out = {row.image.index: row for row in study.held_out}
    made = [_image_row(study, i, held_out.get(i.index)) for i in study.images]
    names = list(_image_row(study, None, None))
    if not any(row["Remark"] for row in made):
        names.remove("Remark")
    return Table(
        {name: [row[name] for row in made] for name in names},
        "Every photograph. Errors are RMS residuals in px when the photograph was "
        "kept out of the calibration; shared corners are those that Zhang and the "
        "general camera both have a ray for.",
        texts=("Photograph", "Remark"),
    )


def _image_row(study, image, row):
    """Cells of one photograph; of none, for the names of the columns."""

    def error(kind, model, quantity="rms_px"):
        return None if row is None else _known(column([row], kind, model, quantity)[0])

    shared = error("same", "zhang", "corners")
    return {
        "Photograph": image.name if image else "",
        "Corners": int(np.count_nonzero(np.isfinite(image.corners[:, 0])))
        if image
        else 0,
        "Shared": None if shared is None else int(shared),
        "Zhang, all": error("own", "zhang"),
        "OpenCV fisheye, all": error("own", PEER),
        "Zhang, shared": error("same", "zhang"),
        "OpenCV fisheye, shared": error("same", PEER),
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
        remarks.append(f"not in the general camera: {study.left_out[image.index]}")
    if row is not None:
        remarks += [
            f"kept out, {EVERY[model]}: {score.reason}"
            for model, score in row.own.items()
            if score.reason
        ]
    return "; ".join(remarks)


def _median(values):
    values = values[np.isfinite(values)]
    return Measured(*median_interval(values)[:3]) if len(values) else None


def _known(number):
    return float(number) if np.isfinite(number) else None


def _whole(number):
    return int(number) if np.isfinite(number) else None


@table("ext_images", needs=("photograph_study",), evidence="photograph", per_set=BOARDS)
def ext_images(results):
    """Every photograph: corners found, errors, remarks."""
    return images_table(study_of(results))


@table("ext_models", needs=("photograph_study",), evidence="photograph", per_set=BOARDS)
def ext_models(results):
    """Every model: parameters, fit, prediction, coverage."""
    return models_table(study_of(results))


@table(
    "ext_every_corner",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=BOARDS,
)
def ext_every_corner(results):
    """Every model on every corner kept out, none removed."""
    return every_corner_table(study_of(results))


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
        if any(cell is not None for cell in cells)
    }
    return Table(told, _caption(result, trials))


def _counted(result, trials, method):
    """Images that the method was given, boards returned, boards right."""
    if method == CELECT:
        trials = [c for c in trials if result.column("clicked", **c)[0]]
    if not trials:
        return [0, None, None]
    count = [
        int(sum(result.column(f"{method}.{what}", **c)[0] for c in trials))
        for what in ("returned", "right")
    ]
    judged = any(result.column("judged", **c)[0] for c in trials)
    return [len(trials), count[0], count[1] if judged else None]


def _statistics(result, trials, name):
    """Mean, maximum and SD (px) of the errors of right boards, as cells."""
    right = name.partition(".")[0] + ".right"
    trials = [c for c in trials if np.nansum(result.column(right, **c)) > 0]
    if not trials:
        return [None] * 3
    errors = [e for c in trials for e in result.arrays(name, **c)]
    errors = np.concatenate(errors)
    values = errors.mean(), errors.max(), errors.std(ddof=1)
    return [float(value) for value in values]


def _caption(result, trials):
    start = "Tables 3.4 to 3.7 on these photographs: boards returned and right"
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
    per_set=BOARDS,
)
def ext_detectors(results):
    """Detectors side by side: boards returned and right, errors."""
    return detectors_table(results["photograph_detectors"])
