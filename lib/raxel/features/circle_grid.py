"""Grids of circles: OpenCV orders the discs, this library localises their centres.

The centroid of the grey levels of a disc is not the image of its centre, in perspective
and under distortion of the lens. The difference follows from the positions of the
circles around it and from its radius, to second order, and is subtracted.
"""

import json
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from raxel.features.charuco import find_markers, other_target, with_other_target
from raxel.features.chessboard.grids import SAMPLING_SD_PX, predicted
from raxel.features.chessboard.saddles import noise_sd
from raxel.features.circles import circle_lattice
from raxel.features.detector import Detection, as_8_bit, rejected
from raxel.features.lattice import orders
from raxel.geometry.homography import apply_homography, homography_dlt

# Largest deviation of a circle from the position that its neighbours predict, and
# misfits of orders that count as equal, in distances of neighbours.
MAX_MISFIT_STEPS, ORDER_TOL_STEPS = 0.3, 0.2
# So many circles next to the grid are not clutter.
MIN_N_BEYOND = 2
# Circles around one, itself included, that determine the homography there.
N_AROUND = 9
# The window around a disc, in half distances of neighbours; outside the second limit it
# shows the ground.
WINDOW, GROUND = 0.95, 0.75


def find_circle_grid(image, target):
    """Detect the grid of circles `target` (`raxel.sets.CircleGrid`): a Detection.

    image: (height, width), uint8 or uint16. All circles must be visible. One whose
    window leaves the image is NaN.
    """
    grey = as_8_bit(image)
    lattice = circle_lattice(grey)
    if lattice is None:
        detection = rejected(target.columns, target.rows, "no grid of circles detected")
        return with_other_target(detection, other_target(grey, find_markers(grey)))
    centres = _ordered(lattice.centres, target)
    if centres is None:
        count = target.columns * target.rows
        reason = (
            f"{len(lattice.centres)} circles detected, but no grid of {target.columns} "
            f"x {target.rows} ({count}); check target.columns, rows and staggered"
        )
        detection = rejected(target.columns, target.rows, reason)
        return with_other_target(detection, _explanation(grey, lattice, target))
    levels = (grey if lattice.dark else 255 - grey).astype(np.float32)
    centres, sd = _localise(levels, centres, target)
    return Detection(True, centres, target.columns, target.rows, sd=sd)


def _explanation(grey, lattice, target):
    """Which other grid of circles an image shows, or ''."""
    if lattice.hexagonal:
        return other_target(grey, None)
    swapped = {"columns": target.rows, "rows": target.columns}
    other = {"staggered": not target.staggered}
    for change in (swapped, other, swapped | other):
        if _ordered(lattice.centres, replace(target, **change)) is not None:
            fields = ", ".join(
                f"target.{name}: {json.dumps(value)}" for name, value in change.items()
            )
            return f"the image shows another grid of circles; set {fields}"
    return ""


def _ordered(centres, target):
    """Centres (N, 2) px of the target's circles, row by row, or None."""
    import cv2

    size = target.columns, target.rows
    kind = (
        cv2.CALIB_CB_ASYMMETRIC_GRID
        if target.staggered
        else cv2.CALIB_CB_SYMMETRIC_GRID
    )
    candidates, tree = centres.astype(np.float32)[:, None], cKDTree(centres)
    for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
        found, ordered = cv2.findCirclesGrid(
            candidates, size, flags, None, cv2.CirclesGridFinderParameters()
        )
        # OpenCV returns rounded points, and merges some of them.
        index = tree.query(ordered.reshape(-1, 2))[1] if found else []
        if len(set(index)) == target.columns * target.rows:
            ordered = _standard_order(centres[index], target)
            if _is_whole(ordered, centres, target):
                return ordered
    return None


def _standard_order(ordered, target):
    """The order that fits the target, not mirrored, with x most to the right."""
    points = replace(target, pitch_mm=None).points()

    def cost(one):
        fitted = apply_homography(homography_dlt(one, points), one)
        misfit = np.sqrt(np.mean((fitted - points) ** 2))
        x, y = (one[k] - one[0] for k in (target.columns - 1, -target.columns))
        mirrored = x[0] * y[1] < x[1] * y[0]
        return mirrored, misfit // ORDER_TOL_STEPS, -x[0] / np.hypot(*x)

    size = target.columns, target.rows
    found = [ordered[order] for order, own in orders(*size) if own == size]
    return min(found, key=cost)


def _is_whole(ordered, centres, target):
    """Whether circles are where their neighbours predict them, and none continue."""
    grid = ordered.reshape(target.rows, target.columns, 2)
    tree, n_beyond = cKDTree(centres), 0
    for part in (grid[::2], grid[1::2]) if target.staggered else (grid,):
        padded = np.pad(part, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
        guess = predicted(padded)
        step = np.nanmedian(np.linalg.norm(np.diff(part, axis=1), axis=2))
        inside = np.isfinite(padded[..., 0])
        misfit = np.linalg.norm(guess - padded, axis=2)[inside]
        if np.nanmax(misfit, initial=0) > MAX_MISFIT_STEPS * step:
            return False
        beyond = guess[~inside & np.isfinite(guess[..., 0])]
        n_beyond += np.sum(tree.query(beyond)[0] < MAX_MISFIT_STEPS * step)
    return n_beyond < MIN_N_BEYOND


def _localise(grey, centres, target):
    """Images (N, 2) px of the centres of dark discs, and their SDs (N,) px.

    The centroid's SD is the noise of the pixels, propagated. It is too small where the
    noise of neighbouring pixels is correlated, as in coded images.
    """
    points = replace(target, pitch_mm=None).points()
    tree = cKDTree(points)
    near = tree.query(points, k=N_AROUND)[1]
    half = tree.query(points[0], k=2)[0][1] / 2
    around = points[near] - points[:, None]
    maps = [homography_dlt(*one) for one in zip(around, centres[near], strict=True)]
    found = np.array([_centroid(grey, H, half) for H in maps])
    centroid, variance, radius = found[:, :2], found[:, 2], np.nanmedian(found[:, 3])
    known = np.where(np.isfinite(centroid), centroid, centres)
    rest = known[near] - apply_homography(np.array(maps), around)
    shift = [_shift(*one, radius) for one in zip(maps, around, rest, strict=True)]
    sd = np.hypot(noise_sd(grey) * np.sqrt(variance), SAMPLING_SD_PX)
    return centroid - shift, sd


def _centroid(grey, H, half):
    """(u, v) px, variance over that of a pixel, and radius in the target's unit.

    H: from the target to the image, (0, 0) at the disc; half: half distance of
    neighbours. NaN where the window leaves the image.
    """
    ring = half * WINDOW * np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]])
    outline = apply_homography(H, ring)
    low, high = np.floor(outline.min(axis=0)), np.ceil(outline.max(axis=0)) + 1
    if low.min() < 0 or np.any(high > grey.shape[::-1]):
        return np.full(4, np.nan)
    v, u = np.mgrid[int(low[1]) : int(high[1]), int(low[0]) : int(high[0])]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    away = np.linalg.norm(apply_homography(np.linalg.inv(H), pixels), axis=1) / half
    pixels, away = pixels[away < WINDOW], away[away < WINDOW]
    level = grey[tuple(pixels.T[::-1].astype(int))]
    design = np.column_stack([pixels, np.ones(len(pixels))])
    outer = away > GROUND
    ground = design @ np.linalg.lstsq(design[outer], level[outer])[0]
    # Fraction of the light that the disc does not reflect.
    weight = 1 - level / ground
    centroid = weight @ pixels / weight.sum()
    spread = np.sum(((pixels - centroid) / ground[:, None]) ** 2) / 2
    area = weight.sum() / np.median(weight[weight > weight.max() / 2])
    scale = np.abs(np.linalg.det(H)) / np.abs(H[2, 2]) ** 3
    return *centroid, spread / weight.sum() ** 2, np.sqrt(area / (np.pi * scale))


def _shift(H, around, rest, radius):
    """The centroid of the image of a disc less the image of its centre, (2,) px.

    H: from the target to the image, (0, 0) at the disc; around, rest (N, 2): circles
    around it and their distances px from those of H. The image of x is m + J x + x' Q
    x / 2 to second order, and a part of the disc has an image 1 + g . x times as large
    as at the centre, g_j = tr(J^-1 Q_j). The mean over the disc, where x x' is radius^2
    / 4, is m + radius^2 (Q_xx + Q_yy) / 8 + radius^2 J g / 4.
    """
    H = H / H[2, 2]
    J = H[:2, :2] - np.outer(H[:2, 2], H[2, :2])
    Q = -np.einsum("ci,j->cij", J, H[2, :2])
    x, y = around.T
    terms = np.column_stack([np.ones(len(x)), x, y, x * x / 2, x * y, y * y / 2])
    q = np.linalg.lstsq(terms, rest)[0]
    Q = Q + Q.swapaxes(1, 2) + q[[[3, 4], [4, 5]]].transpose(2, 0, 1)
    J = J + q[1:3].T
    g = np.einsum("ic,cij->j", np.linalg.inv(J), Q)
    return radius**2 * ((Q[:, 0, 0] + Q[:, 1, 1]) / 8 + J @ g / 4)
