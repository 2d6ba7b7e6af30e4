"""Detectors side by side on an image set: Tables 3.4 to 3.7 for photographs.

Right is, as in 3.3.2, a board with every corner within 8 px of its place and nearer to
it than to any other. The places are the set's reference corners, of which the uncertain
ones do not count; a set without them has only boards that are returned or not.
"""

from __future__ import annotations

import numpy as np

from chapters.shared.grid_detectors import (
    CELECT,
    CLICK_SD_PX,
    CLICKLESS,
    OPENCV,
    OPENCV_SB,
    is_right,
    localised,
    returned,
)
from chapters.shared.lattices import clockwise, outer
from raxel.errors import InputError
from raxel.features import symmetries
from raxel.features.celect import celect
from raxel.features.detector import as_8_bit
from raxel.sets import Chessboard, load_set, read_image
from raxel.sets.reference import load_reference
from repro.run.outcomes import Table

ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    CLICKLESS: "without clicks (ext.)",
}
QUICK_VIEWS = 3
NONE = "–"
UNSUITED = "the set has no chessboard of known size"


def detector_conditions(image_set, effort):
    """One condition per image, or the first few; one alone for an unsuited set."""
    target = image_set.target
    if not isinstance(target, Chessboard) or target.columns is None:
        return [{"view": -1, "image": UNSUITED}]
    views = image_set.views[: QUICK_VIEWS if effort == "quick" else None]
    return [
        {"view": index, "image": view.label}
        for index, view in enumerate(views)
    ]


def detector_trial(folder, condition, rng):
    """What every detector makes of one image, and how far off its corners are."""
    if condition["view"] < 0:
        return {"reason": UNSUITED}
    image_set = load_set(folder)
    view = image_set.views[condition["view"]]
    size = image_set.target.columns, image_set.target.rows
    image = as_8_bit(read_image(image_set, view))
    reference = load_reference(image_set).get(view.image)
    values = {"judged": reference is not None}
    for name in (OPENCV, OPENCV_SB, CLICKLESS):
        corners = returned(name, image, *size)
        values[name] = score(image, corners, size, reference)
    clicks = clicks_of(view, size, reference, rng)
    values["clicked"] = clicks is not None
    if clicks is not None:
        corners = read_by_celect(image, clicks, size)
        values[CELECT] = score(image, corners, size, reference)
    return values


def clicks_of(view, size, reference, rng):
    """Outer corners (4, 2) as a user clicks them; None where nobody knows them.

    Those of set.yaml, or the reference's with the error of the thesis's author.
    """
    if view.outer_corners is not None:
        return np.array(view.outer_corners, float)
    if reference is None or (reference.columns, reference.rows) != size:
        return None
    columns, rows = size
    lattice = clockwise(reference.corners.reshape(rows, columns, 2))
    clicks = outer(lattice) + rng.normal(0, CLICK_SD_PX, (4, 2))
    return clicks if np.isfinite(clicks).all() else None


def read_by_celect(image, clicks, size):
    """Corners (N, 2) of a CELECT run; None where it fails."""
    try:
        result = celect(image, clicks, *size)
    except InputError:
        return None
    return result.corners.reshape(-1, 2) if result.found else None


def score(image, corners, size, reference):
    """Whether corners (N, 2) or None came back and are right, and errors (N,) px."""
    values = {"returned": corners is not None, "right": False}
    if corners is None or reference is None:
        return values
    certain = reference.certain
    truth = reference.corners[certain]
    for order, order_size in symmetries(corners, *size):
        if order_size != (reference.columns, reference.rows):
            continue
        if is_right(order[certain], truth):
            after = localised(image, order)[certain]
            return values | {
                "right": True,
                "before": np.linalg.norm(order[certain] - truth, axis=1),
                "after": np.linalg.norm(after - truth, axis=1),
            }
    return values


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
        for column, cell in zip(columns.values(), row, strict=True):
            column.append(cell)
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
