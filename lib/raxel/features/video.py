"""Corners of a chessboard, from one image of a video to the next.

A board moves little between two images, so that a full search is unnecessary. Optical
flow predicts the position of each corner. The flow of all corners together, a smooth
function of the lattice, corrects wrong ones. The saddle points of the grey levels give
the exact positions. A corner is accepted only if the four squares around it are dark
and bright as before: its direct neighbours have the opposite pattern, so that corners
cannot be exchanged. Corners that enter the image are searched where the lattice,
extrapolated, predicts them. Source of the flow: Bouguet 2001, pyramidal Lucas-Kanade,
by OpenCV.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.errors import InputError
from raxel.features.lattice import misfit, spacing
from raxel.features.localise import saddle_point

# Windows of flow and of saddle points, as fractions of the corner spacing; limits in
# px.
FLOW_WINDOW_STEPS, FLOW_WINDOW_LIMITS_PX, N_FLOW_LEVELS = 0.9, (11, 61), 3
SADDLE_WINDOW_STEPS, SADDLE_WINDOW_LIMITS_PX, BLUR_SD_PX = 0.4, (7, 25), 1.0
# Largest deviation, as a fraction of the corner spacing: of a corner from the smooth
# flow or the lattice, and of the saddle point from its prediction.
MAX_FLOW_ERROR_STEPS, MAX_LATTICE_ERROR_STEPS = 0.3, 0.25
# Second neighbours have the same pattern of squares. A corner would have to move
# farther than this to be confused with one, after a true motion of half a square.
MAX_MOTION_STEPS = 0.7
# Positions at which the squares around a corner are sampled: to the end of its window
# and SAMPLE_MARGIN_PX more, but at most this fraction of a square. MIN_LIKENESS:
# smallest excess of positions with the expected tone, as a fraction of all.
SAMPLE_OFFSETS, SAMPLE_MARGIN_PX, MAX_SAMPLE_REACH_STEPS = (
    np.array([-1, -0.75, -0.5, -0.3, 0.3, 0.5, 0.75, 1]),
    3.0,
    0.4,
)
MIN_LIKENESS = 0.95
MIN_N_CORNERS, MAX_ROUNDS = 6, 3
N_SMOOTHING_ROUNDS = 8  # rounds of reweighting by the deviation from the smooth flow


class TrackedCorners(NamedTuple):
    """Corners of the second image.

    corners (N, 2) px, NaN where not found; sd (N,) px, see `raxel.features.localise`;
    lost, regained (N,) bool: found before and not after, and the reverse.
    """

    corners: np.ndarray
    sd: np.ndarray
    lost: np.ndarray
    regained: np.ndarray


def track_corners(before, after, corners, columns, rows):
    """Track corners from one image of a video to the next: `TrackedCorners`.

    before, after: (H, W) uint8, grey; corners: (rows * columns, 2) px in the image
    before, row by row, NaN where unknown. They may move by up to half a square: with a
    larger motion, a board may be confused with itself, shifted by one square along both
    axes. Raises InputError for images or corners of inconsistent shape, for fewer than
    six corners before, and where no two of them are neighbours.
    """
    before, after, corners = _checked(before, after, corners, columns, rows)
    visible = np.isfinite(corners[:, 0])
    step = _median_step(corners, columns, rows)
    lattice = np.indices((rows, columns)).reshape(2, -1).T
    sense = (-1.0) ** lattice.sum(axis=1)
    likeness = _likeness(before, corners, columns, rows, sense, step)
    sense = sense * (np.sign(np.nansum(likeness)) or 1.0)
    predicted = _flow_positions(before, after, corners, lattice, step)
    found, sd = np.full(corners.shape, np.nan), np.full(len(corners), np.nan)
    searched, extrapolated_once = (
        np.isfinite(predicted[:, 0]),
        np.zeros(len(corners), bool),
    )
    for _ in range(MAX_ROUNDS):
        if not searched.any():
            break
        found[searched], sd[searched] = _saddles(after, predicted[searched], step)
        wrong = ~_on_lattice(after, found, columns, rows, sense, step)
        wrong |= np.linalg.norm(found - corners, axis=1) > MAX_MOTION_STEPS * step
        found[wrong], sd[wrong] = np.nan, np.nan
        # Missing corners next to known ones, once each.
        predicted = extrapolated(found, columns, rows)
        searched = (
            np.isnan(found[:, 0]) & np.isfinite(predicted[:, 0]) & ~extrapolated_once
        )
        extrapolated_once |= searched
    now = np.isfinite(found[:, 0])
    return TrackedCorners(found, sd, visible & ~now, now & ~visible)


def _median_step(corners, columns, rows):
    """Median distance in px from a corner to its nearest neighbour, or InputError."""
    distance = spacing(corners, columns, rows)
    distance = distance[np.isfinite(distance)]
    if not len(distance):
        raise InputError(
            "video: no two corners of the image before are neighbours; detect the "
            "corners again"
        )
    return np.median(distance)


def extrapolated(corners, columns, rows):
    """Position (N, 2) px of each corner, extrapolated along its row and its column.

    A parabola through the next three corners, the mean over the sides that have three;
    NaN where none has.
    """
    grid = np.pad(
        corners.reshape(rows, columns, 2),
        ((3, 3), (3, 3), (0, 0)),
        constant_values=np.nan,
    )

    def neighbour(down, right):
        return grid[3 + down : 3 + down + rows, 3 + right : 3 + right + columns]

    sides = [
        3 * neighbour(a, b) - 3 * neighbour(2 * a, 2 * b) + neighbour(3 * a, 3 * b)
        for a, b in ((0, 1), (0, -1), (1, 0), (-1, 0))
    ]
    known = np.isfinite(sides)
    total = np.where(known, sides, 0.0).sum(axis=0)
    count = known.sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(-1, 2)


def _flow_positions(before, after, corners, lattice, step):
    """Positions of the known corners by optical flow, corrected by the smooth flow."""
    visible = np.flatnonzero(np.isfinite(corners[:, 0]))
    width = _odd_width(FLOW_WINDOW_STEPS * step, FLOW_WINDOW_LIMITS_PX)
    start = corners[visible].astype(np.float32)
    ends, known, _ = cv2.calcOpticalFlowPyrLK(
        before, after, start, None, winSize=(width, width), maxLevel=N_FLOW_LEVELS
    )
    motion = np.where(known == 1, ends - start, np.nan)
    smooth = _smooth(lattice[visible], motion)
    near = np.linalg.norm(motion - smooth, axis=1) <= MAX_FLOW_ERROR_STEPS * step
    predicted = np.full(corners.shape, np.nan)
    predicted[visible] = corners[visible] + np.where(near[:, None], motion, smooth)
    return predicted


def _smooth(lattice, motion):
    """Quadratic in lattice coordinates fitted to motion (n, 2), at all n.

    Least sum of distances; rows of NaN are ignored.
    """
    i, j = (lattice - lattice.mean(axis=0)).T / max(np.ptp(lattice), 1)
    A = np.column_stack([np.ones(len(i)), i, j, i * i, i * j, j * j])
    known = np.isfinite(motion[:, 0])
    weights = known.astype(float)
    motion = np.where(known[:, None], motion, 0.0)
    for _ in range(N_SMOOTHING_ROUNDS):
        root = np.sqrt(weights)[:, None]
        fitted = A @ np.linalg.lstsq(root * A, root * motion, rcond=None)[0]
        distance = np.linalg.norm(motion - fitted, axis=1)
        weights = known / np.maximum(distance, 0.1)
    return fitted


def _saddles(image, positions, step):
    """(corners (n, 2), sd (n,)) at the saddle points near positions, NaN without one.

    Only the part of the image around them is processed.
    """
    height, width = image.shape
    margin = int(step) + SADDLE_WINDOW_LIMITS_PX[1]
    low = np.floor(positions.min(axis=0)).astype(int) - margin
    u, v = np.clip(low, 0, [width - 1, height - 1])
    high = np.ceil(positions.max(axis=0)).astype(int) + margin
    part = image[v : max(high[1], v + 1), u : max(high[0], u + 1)]
    localised = saddle_point(
        part, positions - [u, v], window=_saddle_window(step), blur_sd=BLUR_SD_PX
    )
    valid = localised.converged & np.isfinite(localised.sd)
    moved = np.linalg.norm(localised.corners - (positions - [u, v]), axis=1)
    valid &= moved <= MAX_FLOW_ERROR_STEPS * step
    return (
        np.where(valid[:, None], localised.corners + [u, v], np.nan),
        np.where(valid, localised.sd, np.nan),
    )


def _on_lattice(image, corners, columns, rows, sense, step):
    """Which corners (N,) fit the lattice, with the expected squares around them."""
    error = misfit(corners, columns, rows)[0]
    like = _likeness(image, corners, columns, rows, sense, step)
    return ~(error > MAX_LATTICE_ERROR_STEPS) & (like >= MIN_LIKENESS)


def _likeness(image, corners, columns, rows, sense, step):
    """Agreement (N,) of the squares around each corner with `sense` (N,).

    Fraction of positions that are bright or dark as expected, less that of the others:
    1 where all agree, -1 where all are opposite, NaN where a corner or its neighbours
    are missing.
    """
    along, down = _directions(corners.reshape(rows, columns, 2))
    reach = min(
        (_saddle_window(step) // 2 + SAMPLE_MARGIN_PX) / step, MAX_SAMPLE_REACH_STEPS
    )
    a, b = (
        part.ravel()
        for part in np.meshgrid(reach * SAMPLE_OFFSETS, reach * SAMPLE_OFFSETS)
    )
    positions = (
        corners[:, None] + a[:, None] * along[:, None] + b[:, None] * down[:, None]
    )
    known = np.isfinite(positions).all(axis=(1, 2))
    at = np.where(known[:, None, None], positions, 0).astype(np.float32)
    grey = cv2.remap(image, at, None, cv2.INTER_LINEAR).astype(float)
    wanted = np.sign(a * b) * sense[:, None]
    bright = (grey * (wanted > 0)).sum(axis=1) / (wanted > 0).sum(axis=1)
    dark = (grey * (wanted < 0)).sum(axis=1) / (wanted < 0).sum(axis=1)
    level = (bright + dark)[:, None] / 2
    return np.where(known, np.mean(np.sign(grey - level) * wanted, axis=1), np.nan)


def _directions(lattice):
    """Steps (N, 2) of a lattice (rows, columns, 2) along rows and down columns.

    From neighbours on both sides, or on one.
    """
    found = []
    for axis in (1, 0):
        step = np.diff(lattice, axis=axis)
        pad = [(0, 0)] * 3
        pad[axis] = (1, 1)
        step = np.pad(step, pad, constant_values=np.nan)
        sides = np.stack([np.delete(step, -1, axis), np.delete(step, 0, axis)])
        known = np.isfinite(sides)
        total = np.where(known, sides, 0.0).sum(axis=0)
        count = known.sum(axis=0)
        mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        found.append(mean.reshape(-1, 2))
    return found


def _saddle_window(step):
    return _odd_width(SADDLE_WINDOW_STEPS * step, SADDLE_WINDOW_LIMITS_PX)


def _odd_width(size, ends):
    return 2 * int(np.clip(size, *ends) / 2) + 1


def _checked(before, after, corners, columns, rows):
    before, after = np.ascontiguousarray(before), np.ascontiguousarray(after)
    for name, image in (("before", before), ("after", after)):
        if image.ndim != 2 or image.dtype != np.uint8:
            raise InputError(
                f"video: image {name}: found {image.dtype} {image.shape}; give "
                "grey levels (H, W), uint8"
            )
    if before.shape != after.shape:
        raise InputError(
            f"video: images of {before.shape} and {after.shape}; give images of "
            "equal size"
        )
    corners = np.array(corners, float)
    if corners.shape != (rows * columns, 2):
        raise InputError(
            f"video: corners: found shape {corners.shape} for {columns} columns "
            f"and {rows} rows; give ({rows * columns}, 2), NaN where missing"
        )
    count = np.count_nonzero(np.isfinite(corners).all(axis=1))
    if count < MIN_N_CORNERS:
        raise InputError(
            f"video: {count} corners in the image before; give at least "
            f"{MIN_N_CORNERS}, detected in an image of the board"
        )
    corners[~np.isfinite(corners).all(axis=1)] = np.nan
    return before, after, corners
