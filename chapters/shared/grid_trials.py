"""The trials of 3.3.2: one picture, four detectors, their corners scored."""

from __future__ import annotations

import numpy as np

from chapters.shared.grid_scoring import (
    DONE,
    HALF_WINDOW,
    MOST_STEPS,
    PRECISION_PX,
    cause_of,
    distances,
    errors_of,
    from_smallest,
    in_order_of,
    is_right,
)
from chapters.shared.grid_views import (
    CLICKS,
    IMAGES,
    SETS,
    grid_view,
    outer,
    rig_named,
    stream,
)
from raxel.errors import InputError
from raxel.features import DETECTORS
from raxel.features.celect import CelectSettings, celect

SEEDS = (1, 2, 3)
CLICK_SD_PX = 0.614
CELECT, OPENCV = "celect", "findChessboardCorners"
OPENCV_SB, CLICKLESS = "findChessboardCornersSB", "raxel"
LINEAR, FINE, BOTH = "celect-linear", "celect-fine", "celect-linear-fine"
CLICKED = (CELECT, LINEAR, FINE, BOTH)
METHODS = (OPENCV, OPENCV_SB, *CLICKED, CLICKLESS)
# Harris detector of the variants: smoothed and averaged as little as can be.
FINER = CelectSettings(smoothing_limits_px=(0.5, 0.7))
# What may be wiped off the mirror of a set where CELECT has failed.
BLEMISHES = {
    "spherical": ("spots",),
    "hyperboloidal": ("spots", "glare"),
}
# An independent detector's find counts within this distance.
INDEPENDENT_PX = 3.0
PICTURE_MARGIN_PX, PICTURE_SIZE_PX = 40, 420


def settings_of(set_name):
    """What an experiment's result says about its set."""
    rigs = [(rig_named(name), count) for name, count in SETS[set_name]]
    return {
        "set": set_name,
        "rigs": [f"data/rigs/{rig.name}.yaml" for rig, _ in rigs],
        "camera": rigs[0][0].summary,
        "image_px": [rigs[0][0].camera.width, rigs[0][0].camera.height],
        "grids": [[rig.target.columns, rig.target.rows] for rig, _ in rigs],
        "pitch_mm": [rig.target.pitch_mm for rig, _ in rigs],
        "images": [count for _, count in rigs],
        "seeds": list(SEEDS),
        "click_sd_px": CLICK_SD_PX,
        "localiser": {
            "function": "cornerSubPix",
            "half_window_px": HALF_WINDOW,
            "precision_px": PRECISION_PX,
            "most_steps": MOST_STEPS,
        },
        "variants": {
            LINEAR: "the sRGB tone curve undone before CELECT",
            FINE: "smoothing at most 0.7 px, tensor averaged by as much",
            BOTH: "both",
        },
        "opencv_flags": "adaptive threshold, normalised image; "
        "sector-based: exhaustive, accurate",
    }


def conditions_of(set_name, effort):
    """One condition per picture: every one of three seeds, or one for a look."""
    images, seeds = (1, SEEDS[:1]) if effort == "quick" else (IMAGES, SEEDS)
    return [
        {"set": set_name, "image": image, "seed": seed}
        for seed in seeds
        for image in range(images)
    ]


def grid_trial(condition, rng):
    """One picture and what the detectors make of it.

    Its draws are those of the picture (`grid_views`), so that others can have
    the same one; `rng` is not used. CELECT is given the picture, simulated
    clicks and the counts; the others the picture and the counts.
    """
    where = condition["set"], condition["image"], condition["seed"]
    view = grid_view(*where)
    values = {
        name: no_clicks(name, view) for name in METHODS if name != CELECT
    }
    lattice = from_smallest(
        view.corners.reshape(view.rows, view.columns, 2)
    )
    clicks = outer(lattice) + stream(*where, CLICKS).normal(
        0, CLICK_SD_PX, (4, 2)
    )
    result, values[CELECT] = run_celect(view.image, clicks, lattice)
    linear = tone_undone(view.image)
    for name, image, settings in (
        (LINEAR, linear, CelectSettings()),
        (FINE, view.image, FINER),
        (BOTH, linear, FINER),
    ):
        _, values[name] = run_celect(image, clicks, lattice, settings)
    if not values[CELECT]["success"]:
        for blemish in BLEMISHES.get(condition["set"], ()):
            clean = grid_view(*where, without=blemish)
            _, again = run_celect(clean.image, clicks, lattice)
            values[CELECT][f"right_without_{blemish}"] = again["success"]
    if not values[OPENCV]["success"]:
        values["independent"] = share_found(view.image, view.corners)
    if condition["seed"] == SEEDS[0]:
        values |= drawn(view, result)
    steps = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    return values | {"corners": len(view.corners), "least_px": steps.min()}


def tone_undone(image):
    """A grey picture (H, W) uint8 as it was before the tone curve of sRGB."""
    grey = np.arange(256) / 255
    light = np.where(
        grey <= 0.04045, grey / 12.92, ((grey + 0.055) / 1.055) ** 2.4
    )
    return np.rint(255 * light).astype(np.uint8)[image]


def run_celect(image, clicks, lattice, settings=None):
    """(CelectResult or None, scores) of one run, against the true lattice."""
    rows, columns = lattice.shape[:2]
    settings = settings or CelectSettings()
    try:
        result = celect(image, clicks, columns, rows, settings=settings)
    except InputError as fault:
        return None, {"success": False, "cause": str(fault)}
    truth = lattice.reshape(-1, 2)
    corners = result.corners.reshape(-1, 2)
    if result.found and is_right(corners, truth):
        scores = {"success": True, "cause": DONE}
        return result, scores | errors_of(image, corners, truth)
    scores = {"success": False, "cause": cause_of(result, lattice)}
    if result.failures:
        first = result.failures[0]
        scores |= {"contour": first.contour, "stage": first.stage}
    return result, scores


def no_clicks(name, view):
    """Scores of a detector that is told the counts alone."""
    corners = returned(name, view.image, view.columns, view.rows)
    if corners is None:
        return {"success": False, "returned": False}
    corners = in_order_of(view.corners, corners, view.columns, view.rows)
    if not is_right(corners, view.corners):
        return {"success": False, "returned": True}
    scores = {"success": True, "returned": True}
    return scores | errors_of(view.image, corners, view.corners)


def returned(name, image, columns, rows):
    """Corners (N, 2) as a detector returns them; None where it refuses."""
    import cv2

    if name == CLICKLESS:
        seen = DETECTORS["raxel"](image, columns, rows)
        return seen.corners if seen.found else None
    if name == OPENCV:
        flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
        found, corners = cv2.findChessboardCorners(
            image, (columns, rows), flags=flags
        )
    else:
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(
            image, (columns, rows), flags=flags
        )
    if not found or len(corners) != columns * rows:
        return None
    return np.asarray(corners, float).reshape(-1, 2)


def share_found(image, truth):
    """Share of the true corners (N, 2) that a Harris detector sees.

    OpenCV's goodFeaturesToTrack, on the part of the picture with the board.
    """
    import cv2

    low = np.maximum(truth.min(axis=0).astype(int) - PICTURE_MARGIN_PX, 0)
    high = truth.max(axis=0).astype(int) + PICTURE_MARGIN_PX
    part = np.ascontiguousarray(image[low[1] : high[1], low[0] : high[0]])
    seen = cv2.goodFeaturesToTrack(
        part, 4 * len(truth), 0.01, 3, useHarrisDetector=True
    )
    seen = np.empty((0, 2)) if seen is None else seen.reshape(-1, 2) + low
    nearest = distances(truth, seen).min(axis=1)
    return float((nearest <= INDEPENDENT_PX).mean())


def drawn(view, result):
    """Arrays for Figs 3.12 and 3.13: the picture's part, and CELECT's corners.

    picture: (h, w[, 3]) uint8, made smaller by a whole factor; place: (3,)
    pixel (u, v) of its corner, and that factor; lattice: (rows, columns, 2),
    NaN where CELECT has no corner; detected: (m, 2) corners as detected.
    """
    import cv2

    low = view.corners.min(axis=0).astype(int) - PICTURE_MARGIN_PX
    low = np.maximum(low, 0)
    high = view.corners.max(axis=0).astype(int) + PICTURE_MARGIN_PX
    part = view.colour[low[1] : high[1], low[0] : high[0]]
    factor = max(1, int(np.ceil(max(part.shape[:2]) / PICTURE_SIZE_PX)))
    size = part.shape[1] // factor, part.shape[0] // factor
    part = part[: size[1] * factor, : size[0] * factor]
    small = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
    arrays = {"picture": small, "place": np.array([*low, factor], float)}
    if result is None:
        return arrays
    seen = [c.candidates for c in result.contours] or [np.empty((0, 2))]
    return arrays | {"lattice": result.corners, "detected": np.vstack(seen)}
