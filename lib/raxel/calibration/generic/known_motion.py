"""The general calibration method: grids in known poses, one line per pixel (2.3.3).

A pixel sees one point on each of two planar grids whose relative pose is known; the
join of the two points is its ray. Nothing is asked of the other pixels, so any optics
will do, central or not, smooth or in facets. The price is the motion: the rays are as
good as the poses.

Source: M. D. Grossberg and S. K. Nayar, ICCV 2001, doi:10.1109/ICCV.2001.937611.
"""

import itertools
from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import pluecker_matrix_of_rays
from raxel.geometry.poses import inverse_pose, transform

BLOCK = 1 << 16  # rays handled at once, which bounds the temporaries
RIGID = 1e-6  # largest error of R^T R of a pose that is taken as rigid
# Two points, or two planes, closer than this share of the grids' size are one.
COINCIDENT = 1e-9


class KnownMotionRays(NamedTuple):
    """One ray per pixel, in the frame of the poses' target (the base grid, say).

    origins (N, 3): the anchor points, on the first grid that the pixel sees, or next to
    its point there where three or more points leave a residual. directions (N, 3):
    unit, from the first grid that the pixel sees towards the last. valid (N,): whether
    two or more points gave a line; elsewhere the other three are NaN. rms (N,): root
    mean square distance of the pixel's points from the line; zero for two.
    """

    origins: np.ndarray
    directions: np.ndarray
    valid: np.ndarray
    rms: np.ndarray

    def pluecker(self):
        """Plücker matrices (N, 4, 4) of the rays (2.11), NaN where not valid."""
        return pluecker_matrix_of_rays(self.origins, self.directions)


def rays_from_known_motion(points, T_base_grid, seen=None):
    """Rays of N pixels from what each sees on n grids in known poses (2.3.3).

    points: (n, N, 2), n >= 2, in the grids' coordinates, unit of the poses (mm);
    T_base_grid: (n, 4, 4) poses of the grids in one frame, which becomes that of the
    rays; seen: (n, N) bool, default: where the points are finite.

    **The order of the grids gives the rays their sense**: list them from near to far.
    Light has no arrow in two points alone. Where two planes cross within the view, the
    pixels beyond the crossing see them in the other order, and get the opposite ray.

    Two points give their join, exactly. More give the line with the least sum of
    squared distances. The camera need not be central. Pixels that see fewer than two
    grids, or one point on the first and the last of them (where two planes cross), have
    no ray.

    Returns KnownMotionRays. Raises InputError for shapes that do not fit, poses that
    are not rigid, and two grids in one plane; CalibrationError where no pixel sees two
    grids.
    """
    points, T_base_grid, seen = _checked(points, T_base_grid, seen)
    count = points.shape[1]
    rays = KnownMotionRays(
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.empty(count, bool),
        np.empty(count),
    )
    for start in range(0, count, BLOCK):
        block = slice(start, start + BLOCK)
        flat = np.where(seen[:, block, None], points[:, block], 0.0)
        flat = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)
        joined = _join(transform(T_base_grid, flat), seen[:, block])
        for whole, part in zip(rays, joined, strict=True):
            whole[block] = part
    return rays


def _join(p, seen):
    """The line of each pixel through its points p (n, N, 3), as KnownMotionRays."""
    weight = seen.astype(float)[..., None]
    number = weight.sum(axis=0)
    middle = (weight * p).sum(axis=0) / np.maximum(number, 1.0)
    q = weight * (p - middle)
    # The direction of least squares is the dominant axis of the second moments.
    along = np.linalg.eigh(np.einsum("kni,knj->nij", q, q))[1][..., 2]
    first, last = _point_of(p, np.argmax(seen, axis=0)), _point_of(p, _last(seen))
    # Two points need no fit, and their difference has no rounding of moments.
    along = np.where(number == 2, last - first, along)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    size = np.sqrt((weight * p**2).sum(axis=(0, 2)))
    # Points of first and last grid in one place leave the sense of the ray open.
    spread = np.linalg.norm(last - first, axis=1)
    valid = (number[:, 0] >= 2) & (spread > COINCIDENT * size)
    along = along / np.where(valid[:, None], length, np.nan)
    along = along * np.sign(np.sum(along * (last - first), axis=1, keepdims=True))
    origins = middle + np.sum(along * (first - middle), axis=1, keepdims=True) * along
    origins = np.where(number == 2, np.where(valid[:, None], first, np.nan), origins)
    across = q - np.einsum("kni,ni->kn", q, along)[..., None] * along
    rms = np.sqrt((across**2).sum(axis=(0, 2)) / np.maximum(number[:, 0], 1.0))
    rms = np.where(number[:, 0] == 2, 0.0 * along[:, 0], rms)
    return KnownMotionRays(origins, along, valid, rms)


def _last(seen):
    return len(seen) - 1 - np.argmax(seen[::-1], axis=0)


def _point_of(p, grid):
    """Points (N, 3) of p (n, N, 3), each on the grid of its own number (N,)."""
    return p[grid, np.arange(p.shape[1])]


def _checked(points, T_base_grid, seen):
    points, poses = np.asarray(points, float), np.asarray(T_base_grid, float)
    if points.ndim != 3 or points.shape[2] != 2 or len(points) < 2:
        raise InputError(
            f"known motion: field 'points': shape {points.shape} found; (n, N, 2) with"
            " two or more grids needed"
        )
    if poses.shape != (len(points), 4, 4):
        raise InputError(
            f"known motion: field 'T_base_grid': shape {poses.shape} found;"
            f" {(len(points), 4, 4)} needed, one pose per grid"
        )
    _check_rigid(poses)
    finite = np.isfinite(points).all(axis=2)
    seen = finite if seen is None else np.asarray(seen)
    if seen.shape != finite.shape or seen.dtype != bool:
        raise InputError(
            f"known motion: field 'seen': {seen.dtype} {seen.shape} found; bool"
            f" {finite.shape} needed"
        )
    seen = seen & finite
    if not np.any(seen.sum(axis=0) >= 2):
        raise CalibrationError(
            "known motion: no pixel sees two grids; move the grids until they overlap"
            " in the image",
            code="no-overlap",
        )
    _check_apart(points, poses, seen)
    return points, poses, seen


def _check_rigid(poses):
    finite = np.isfinite(poses).all(axis=(1, 2))
    whole = np.where(finite[:, None, None], poses, 0.0)
    R = whole[:, :3, :3]
    skew = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
    last_row = np.abs(whole[:, 3] - [0, 0, 0, 1]).max(axis=1)
    good = (skew < RIGID) & (last_row < RIGID) & (np.linalg.det(R) > 0)
    if not good.all():
        raise InputError(
            f"known motion: field 'T_base_grid': pose {np.argmin(good)} is not rigid;"
            " give a rotation and a translation"
        )


def _check_apart(points, poses, seen):
    """Raise InputError where the points of one grid lie in the plane of another."""
    for i, j in itertools.combinations(range(len(poses)), 2):
        both = seen[i] & seen[j]
        if not both.any():
            continue
        x, y = points[j, both].T
        T = inverse_pose(poses[i]) @ poses[j]
        height = T[2, 0] * x + T[2, 1] * y + T[2, 3]
        size = max(np.abs(points[[i, j]][:, both]).max(), np.abs(T[:3, 3]).max())
        if np.abs(height).max() <= COINCIDENT * size:
            raise InputError(
                f"known motion: field 'T_base_grid': grids {i} and {j} lie in one"
                " plane, so their points give no ray; move one of them"
            )
