"""Corners that do not fit although their neighbours do.

A camera that does not fit, a pose that wrong corners pull aside, a shutter that rolls:
all move neighbours alike. A corner that a detector took for another one stands alone.
So each residual is held against the median of those around it on the lattice, or of
what these continue to where they have a slope, and the differences against their
scatter. What stands alone says nothing of the camera: it is counted and named, and what
is left says whether the camera fits.
"""

from typing import NamedTuple

import numpy as np

from raxel.evaluation.cross_validation import Evaluation, evaluate_camera

# Of the scatter, as robust fits of lenses take corners for wrong: that of differences,
# or that of the board's residuals where the camera does not fit it. No corner is known
# better than LEAST_PX.
WIDTH, LEAST_PX = 6.0, 0.01
RAYLEIGH = 1.1774  # median distance of two coordinates that scatter by 1
FEWEST_NEIGHBOURS = 3
AROUND = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
# Of a residual: what moves a corner alone does not move two of its neighbours so far
# the same way.
SHARED = 0.25
ROUNDS = 5  # until no further one is found: poses are better without the first


class WrongCorners(NamedTuple):
    """whole: the camera's Evaluation on all corners; views: those given, without wrong
    corners; evaluation: the Evaluation on these; wrong: [(name of the view, number of
    the corner, px off)]."""

    whole: Evaluation
    views: list
    evaluation: Evaluation
    wrong: list


def without_wrong_corners(camera, views, shape=None):
    """WrongCorners of a camera on BoardViews or DenseViews; shape: as of
    `evaluate_camera`."""
    whole = found = evaluate_camera(camera, views, shape)
    left, alone = list(views), {}
    for _ in range(ROUNDS):
        places = _standing_alone(found.images, left)
        if not any(own.any() for own in places):
            break
        for k, own in enumerate(places):
            off = np.linalg.norm(found.images[k].residuals_px, axis=1)
            alone |= {(k, int(n)): float(off[n]) for n in np.flatnonzero(own)}
            pixels = left[k].pixels.copy()
            pixels[own] = np.nan
            left[k] = left[k]._replace(pixels=pixels)
        found = evaluate_camera(camera, left, shape)
    wrong = [(views[k].name, n, px) for (k, n), px in sorted(alone.items())]
    return WrongCorners(whole, left, found, wrong)


def _standing_alone(scores, views):
    """(N,) bool of each view: corners far off where those around them are not."""
    found = [_beside_neighbours(*pair) for pair in zip(scores, views, strict=True)]
    typical = np.concatenate([off for off, _ in found])
    typical = typical[np.isfinite(typical)]
    if len(typical) == 0:
        return [shared & False for _, shared in found]
    single, alone = np.median(typical), []
    for (off, shared), score in zip(found, scores, strict=True):
        distances = np.linalg.norm(score.residuals_px, axis=1)
        own = np.nanmedian(distances) if np.isfinite(distances).any() else single
        widest = WIDTH * max(single / RAYLEIGH, own / RAYLEIGH, LEAST_PX)
        alone.append((np.fmin(off, distances) > widest) & ~shared)
    return alone


def _beside_neighbours(score, view):
    """Distances (N,) px of residuals from what those around them lead one to expect,
    NaN where there are too few; and (N,) bool: two of these go the same way."""
    lattice = score.residuals_px.reshape(view.rows, view.columns, 2)
    padded = np.pad(lattice, ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)

    def moved(i, j):
        return padded[2 + i : 2 + i + view.rows, 2 + j : 2 + j + view.columns]

    near = np.stack([moved(*step) for step in AROUND])
    on = np.stack([2 * moved(i, j) - moved(2 * i, 2 * j) for i, j in AROUND])
    off = [np.linalg.norm(lattice - _median(each), axis=2) for each in (near, on)]
    along = np.nan_to_num(np.sum(near * lattice, axis=3), nan=-np.inf)
    second = np.sort(along, axis=0)[-2]
    shared = second > SHARED * np.sum(lattice**2, axis=2)
    return np.fmin(*off).ravel(), shared.ravel()


def _median(around):
    """Median (rows, columns, 2) of those (8, rows, columns, 2) that are finite; NaN
    where they are fewer than FEWEST_NEIGHBOURS."""
    enough = np.isfinite(around[..., 0]).sum(axis=0) >= FEWEST_NEIGHBOURS
    middle = np.full(around.shape[1:], np.nan)
    middle[enough] = np.nanmedian(around[:, enough], axis=0)
    return middle
