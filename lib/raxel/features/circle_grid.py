"""Grids of circles: OpenCV orders the discs, this library localises their centres.

The grey levels of a disc have their centroid at the centre of its image, an ellipse. In
perspective this is not the image of the disc's centre. The difference follows from the
homography around the disc and from its radius, and is subtracted. Distortion of the
lens within a disc is not.
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
# smallest of another order, in distances of neighbours.
MAX_MISFIT_STEPS, ORDER_TOL_STEPS = 0.3, 0.1
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
    candidates = centres.astype(np.float32)[:, None]
    for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
        found, ordered = cv2.findCirclesGrid(
            candidates, size, flags, None, cv2.CirclesGridFinderParameters()
        )
        if found:
            # OpenCV returns rounded points, and merges some of them.
            ordered = centres[cKDTree(centres).query(ordered.reshape(-1, 2))[1]]
            ordered = _standard_order(ordered, target)
            if _is_whole(ordered, centres, target):
                return ordered
    return None


def _standard_order(ordered, target):
    """The order that fits the target, not mirrored, with x most to the right."""
    points = replace(target, pitch_mm=None).points()
    found = []
    for order, size in orders(target.columns, target.rows):
        one = ordered[order]
        if size != (target.columns, target.rows):
            continue
        H = homography_dlt(one, points)
        misfit = np.sqrt(np.mean((apply_homography(H, one) - points) ** 2))
        x, y = (one[k] - one[0] for k in (target.columns - 1, -target.columns))
        if x[0] * y[1] > x[1] * y[0]:
            found.append((misfit, -x[0] / np.hypot(*x), one))
    limit = min(found)[0] + ORDER_TOL_STEPS if found else 0
    fitting = [one for one in found if one[0] <= limit]
    return min(fitting, key=lambda one: one[1])[2] if fitting else ordered


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

    The centroid's SD is the noise of the pixels, propagated.
    """
    points = replace(target, pitch_mm=None).points()
    tree = cKDTree(points)
    near = tree.query(points, k=N_AROUND)[1]
    half = tree.query(points[0], k=2)[0][1] / 2
    maps = [homography_dlt(points[k] - points[k[0]], centres[k]) for k in near]
    found = np.array([_centroid(grey, H, half) for H in maps])
    centroid, variance, radius = found[:, :2], found[:, 2], np.nanmedian(found[:, 3])
    shift = np.array([ellipse_centre(H, radius) - H[:2, 2] / H[2, 2] for H in maps])
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


def ellipse_centre(H, radius):
    """Centre (2,) px of the image of a circle of this radius around (0, 0).

    The dual conic of the circle, diag(radius^2, radius^2, -1), maps to that of the
    ellipse, whose last column is the pole of the line at infinity: the centre.
    """
    dual = H @ np.diag([radius**2, radius**2, -1]) @ H.T
    return dual[:2, 2] / dual[2, 2]
