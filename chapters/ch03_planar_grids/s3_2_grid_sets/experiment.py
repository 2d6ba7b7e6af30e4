"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from chapters.shared.grids import (
    CELECT,
    CLICK_SD_PX,
    CLICKLESS,
    HALF_WINDOWS,
    HARD,
    LINEAR,
    LOST_PX,
    OPENCV,
    OPENCV_SB,
    PRECISION_PX,
    RIGS,
    SETS,
    WHOLE,
    clockwise,
    corner_areas,
    localised,
    outer,
    rig_of,
    wiped,
)
from chapters.shared.rigs import rig_named
from raxel.evaluation import distances
from raxel.features.celect import (
    OUTER_CORNER,
    TOO_FEW,
    TRACING,
    CelectSettings,
    along_contour,
    side_lengths,
)
from raxel.features.localise import ITERATIONS
from raxel.geometry import on_plane, transform
from raxel.lab import grey_of, light_of_board, saved
from repro.run import Plan, experiment

# Images of the grids of section 3.3.2, one at a time.
#
# An image depends only on its number, a seed and the range of poses. Pose, light, glare
# and noise are its own; the flaws of the mirror depend on the seed alone.


IMAGES = 15
# Streams of random numbers of a seed.
POSE, REST, SPECIMEN, CLICKS = 0, 1, 2, 3


class GridView(NamedTuple):
    """An image of a grid and its true corners.

    image: (H, W) uint8; corners: (rows * columns, 2) px, row by row, so that
    columns and rows turn clockwise in the image, also behind a mirror;
    outer_corners: (4, 2), clockwise in the image, the first (row 0, column 0);
    colour: the same image as saved by the camera, (H, W, 3) if coloured; pitch_mm:
    of the grid.
    """

    image: np.ndarray
    corners: np.ndarray
    columns: int
    rows: int
    outer_corners: np.ndarray
    colour: np.ndarray
    pitch_mm: float


def stream(set_name, image, seed, kind):
    """Return the numpy Generator of one kind of draw for one image."""
    number = list(SETS).index(set_name)
    return np.random.default_rng([seed, number, kind, image])


@lru_cache(maxsize=1)
def taken(set_name, image, seed, poses):
    """Return (rig, pose, light on its sensor, Generator for the rest) of an image."""
    rig = rig_of(set_name, image, poses)
    pose = rig.draw_poses(stream(set_name, image, seed, POSE), 1)[0]
    draws = stream(set_name, image, seed, REST)
    return rig, pose, light_of_board(rig, pose, draws), draws


def grid_view(set_name, image, seed, poses, without=None):
    """Render image number `image` (from 0) of a set from a seed: GridView.

    set_name: key of SETS; seed: whole number, 0 or more; poses: WHOLE or HARD of
    grid_rigs; without: None, or the blemish, a key of CLEANED, to omit with all
    else equal.
    """
    rig, pose, light, draws = taken(set_name, image, seed, poses)
    rig = wiped(rig, without)
    number = list(SETS).index(set_name)
    specimen = np.random.default_rng([seed, number, SPECIMEN])
    saved_image = saved(rig, light, deepcopy(draws), specimen)
    points = on_plane(rig.target.points())
    corners = rig.camera.project(transform(pose, points)).pixels
    columns, rows = rig.target.columns, rig.target.rows
    lattice = clockwise(corners.reshape(rows, columns, 2))
    return GridView(
        grey_of(saved_image),
        lattice.reshape(-1, 2),
        columns,
        rows,
        outer(lattice),
        saved_image,
        rig.target.pitch_mm,
    )


def from_smallest(lattice):
    """Return the lattice starting at the outer corner with the smallest square.

    lattice: (rows, columns, 2), clockwise in the image, as is the result. Its rows
    and columns are exchanged if it starts along the other side.
    """
    return np.rot90(lattice, int(corner_areas(lattice).argmin()))


# Scores of the grids of 3.3.2, causes of failures, and data kept for figures.


# Seeds of each range of poses.
SEEDS = {WHOLE: (1, 2, 3), HARD: (1,)}
FINE, BOTH = "celect-fine", "celect-linear-fine"
METHODS = (OPENCV, OPENCV_SB, CELECT, LINEAR, FINE, BOTH, CLICKLESS)
# Harris detector of the variants: minimal smoothing and averaging.
FINER = CelectSettings(smoothing_limits_px=(0.5, 0.7))
# CELECT and its variants: whether the tone curve is undone, and the settings.
CELECTS = {
    CELECT: (False, CelectSettings()),
    LINEAR: (True, CelectSettings()),
    FINE: (False, FINER),
    BOTH: (True, FINER),
}
# Methods that are also run on the ball without spots, and the seed of its images.
SPOTLESS, SPOTLESS_SEED = (OPENCV, OPENCV_SB, CELECT), 1
# Blemishes that are removed from the mirror of a set where CELECT fails.
BLEMISHES = {"hyperboloidal": ("spots", "glare")}
TRUTH, REFERENCE = "truth", "cornerSubPix from truth"
REFERENCES = (REFERENCE, TRUTH)
# Rows of the errors of a correct grid: stage, reference, window.
MEASURES = (
    ("before", TRUTH, None),
    *(
        (when, reference, window)
        for window in HALF_WINDOWS
        for when, reference in (
            ("before", REFERENCE),
            ("after", REFERENCE),
            ("after", TRUTH),
        )
    ),
)
# Causes of the end of a run of CELECT, from the contour that ended it.
DONE = "all corners right"
CONTOUR, SNAP = "contour lost", "outer corner not found"
MISSED, FALSE = "corner missed", "false corner"
MERGED, SPLIT = "corners merged", "corner split"
MISPLACED = "corner misplaced"
# A corner of an independent detector counts within this distance.
INDEPENDENT_PX = 3.0
CROP_MARGIN_PX, CROP_SIZE_PX = 40, 420


def settings_of(set_name):
    """Return the settings of a set, stored in an experiment's result."""
    rigs = [(rig_named(name), count) for name, count in SETS[set_name]]
    return {
        "set": set_name,
        "rigs": [f"data/rigs/{rig.name}.yaml" for rig, _ in rigs],
        "camera": rigs[0][0].summary,
        "image_px": [rigs[0][0].camera.width, rigs[0][0].camera.height],
        "grids": [[rig.target.columns, rig.target.rows] for rig, _ in rigs],
        "pitch_mm": [rig.target.pitch_mm for rig, _ in rigs],
        "images": [count for _, count in rigs],
        "seeds": {poses: list(seeds) for poses, seeds in SEEDS.items()},
        "seed_without_spots": SPOTLESS_SEED,
        "poses_deg": {poses: ranges_of(set_name, poses) for poses in SEEDS},
        "click_sd_px": CLICK_SD_PX,
        "localiser": {
            "function": "cornerSubPix",
            "half_window_px": HALF_WINDOWS,
            "precision_px": PRECISION_PX,
            "most_steps": ITERATIONS,
        },
        "variants": {
            LINEAR: "the sRGB tone curve undone before CELECT",
            FINE: "smoothing at most 0.7 px, tensor averaged by as much",
            BOTH: "both",
        },
        "opencv_flags": "adaptive threshold, normalised image; "
        "sector-based: exhaustive, accurate",
    }


def ranges_of(set_name, poses):
    """Return ranges of the poses of a set, degrees."""
    drawn = rig_of(set_name, 0, poses).poses
    ranges = {n: getattr(drawn, n) for n in ("polar", "tilt", "subtense")}
    return {n: np.rad2deg(ends).round(6).tolist() for n, ends in ranges.items()}


def errors_of(image, corners, truth):
    """Return errors (7, N) px of a correct grid, a row for each of MEASURES."""
    standards = {w: localised(image, truth, w) for w in HALF_WINDOWS}
    found = {w: localised(image, corners, w) for w in HALF_WINDOWS}
    off = [
        (corners if when == "before" else found[window])
        - (truth if reference == TRUTH else standards[window])
        for when, reference, window in MEASURES
    ]
    return np.linalg.norm(off, axis=2)


def stacked(errors, methods, count):
    """Return errors (methods, 7, count) of the grids returned; nan without a grid."""
    none = np.full((len(MEASURES), count), np.nan)
    return np.array([errors.get(method, none) for method in methods])


def min_step_over_merging(lattice):
    """Return the smallest step of each side over its t8, and t8 (px): two arrays (4,).

    lattice: true corners (rows, columns, 2) in the order of the clicks. CELECT
    merges corners of a side that are nearer to each other than t8.
    """
    rows, columns = lattice.shape[:2]
    settings = CelectSettings()
    reach = settings.merge * side_lengths(
        outer(lattice), columns, rows, settings.radius_divisor
    )
    sides = [along_contour(f"side {k}", lattice) for k in range(1, 5)]
    steps = [np.linalg.norm(np.diff(s, axis=0), axis=1).min() for s in sides]
    return np.array(steps) / reach, reach


def cause_of(result, lattice):
    """Return the cause of a failed run of CELECT, from its first failed contour.

    result: CelectResult; lattice: true corners (rows, columns, 2), in the order of
    the clicks.
    """
    if result.found:
        return MISPLACED
    failure = result.failures[0]
    if failure.stage == OUTER_CORNER:
        return SNAP
    if failure.stage == TRACING:
        return CONTOUR
    contour = next(c for c in result.contours if c.name == failure.contour)
    truth = along_contour(contour.name, lattice)
    near = nearness(truth)
    if failure.stage == TOO_FEW:
        seen = np.vstack([contour.inliers, contour.merged])
        missing = distances(truth, seen).min(axis=1) > near
        return MISSED if missing.any() else MERGED
    apart = distances(contour.merged, truth)
    strays = apart.min(axis=1) > near[apart.argmin(axis=1)]
    return FALSE if strays.any() else SPLIT


def nearness(truth):
    """Return the tolerance (n,) px around the true corners (n, 2) of a contour.

    8 px, or half the distance to the next corner of the contour.
    """
    steps = np.linalg.norm(np.diff(truth, axis=0), axis=1)
    least = np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    return np.minimum(LOST_PX, least / 2)


def share_found(image, truth):
    """Return the share of the true corners (N, 2) that a Harris detector finds.

    OpenCV's goodFeaturesToTrack, on the part of the image with the board.
    """
    import cv2

    low = np.maximum(truth.min(axis=0).astype(int) - CROP_MARGIN_PX, 0)
    high = truth.max(axis=0).astype(int) + CROP_MARGIN_PX
    part = np.ascontiguousarray(image[low[1] : high[1], low[0] : high[0]])
    seen = cv2.goodFeaturesToTrack(
        part, 4 * len(truth), 0.01, 3, useHarrisDetector=True
    )
    seen = np.empty((0, 2)) if seen is None else seen.reshape(-1, 2) + low
    nearest = distances(truth, seen).min(axis=1)
    return float((nearest <= INDEPENDENT_PX).mean())


def drawn(view, result):
    """Return arrays for Figs 3.12 and 3.13: a crop of the image, and CELECT's corners.

    image: (h, w[, 3]) uint8, reduced by a whole factor; place: (3,) pixel (u, v)
    of its corner, and that factor; lattice: (rows, columns, 2), NaN where CELECT
    has no corner; detected: (m, 2) corners as detected.
    """
    import cv2

    low = view.corners.min(axis=0).astype(int) - CROP_MARGIN_PX
    low = np.maximum(low, 0)
    high = view.corners.max(axis=0).astype(int) + CROP_MARGIN_PX
    part = view.colour[low[1] : high[1], low[0] : high[0]]
    factor = max(1, int(np.ceil(max(part.shape[:2]) / CROP_SIZE_PX)))
    size = part.shape[1] // factor, part.shape[0] // factor
    part = part[: size[1] * factor, : size[0] * factor]
    small = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
    arrays = {"picture": small, "place": np.array([*low, factor], float)}
    if result is None:
        return arrays
    seen = [c.candidates for c in result.contours] or [np.empty((0, 2))]
    return arrays | {"lattice": result.corners, "detected": np.vstack(seen)}


# Distances between neighbouring corners of the grids of section 3.3.2.


FOUR_SETS = ("spherical", "hyperboloidal", "fisheye", "flexible-mirror")


def spacing_trial(condition, rng):
    """Return the smallest distance (px) of two neighbouring corners of an image's grid.

    Nothing is rendered: the true corners follow from the pose, which is drawn with
    the image's seed. `rng` is not used.
    """
    set_name, image, seed, poses = (
        condition[k] for k in ("set", "image", "seed", "poses")
    )
    rig = rig_of(set_name, image, poses)
    pose = rig.draw_poses(stream(set_name, image, seed, POSE), 1)[0]
    points = transform(pose, on_plane(rig.target.points()))
    corners = rig.camera.project(points).pixels
    lattice = corners.reshape(rig.target.rows, rig.target.columns, 2)
    return {"least_px": min_spacing(lattice)}


def min_spacing(lattice):
    """Return the smallest distance (px) of neighbours in (rows, columns, 2)."""
    steps = (np.linalg.norm(np.diff(lattice, axis=k), axis=2) for k in (0, 1))
    return float(min(step.min() for step in steps))


@experiment("exp_c3_same_after_loc", artefact="table_3_4", inputs=RIGS)
def spacings(effort):
    """The grids of all images of the four tables."""
    images = 1 if effort == "quick" else IMAGES
    conditions = [
        {"set": set_name, "poses": poses, "image": image, "seed": seed}
        for set_name, (poses, seeds) in product(FOUR_SETS, SEEDS.items())
        for seed in (seeds[:1] if effort == "quick" else seeds)
        for image in range(images)
    ]
    return Plan(spacing_trial, conditions, 1)
