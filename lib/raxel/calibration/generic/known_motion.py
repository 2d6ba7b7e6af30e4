"""General calibration method: grids in known poses, one line per pixel (2.3.3).

A pixel sees one point on each of two planar grids with a known relative pose; the join
of the two points is its ray. Pixels are independent, so the optics may be non-central,
smooth or faceted. The price is the motion: the rays are as accurate as the poses.

Source: M. D. Grossberg and S. K. Nayar, ICCV 2001, doi:10.1109/ICCV.2001.937611.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import pluecker_matrix_of_rays
from raxel.geometry.poses import inverse_pose, transform

BLOCK = 1 << 16  # rays handled at once, which bounds the temporaries
ORTHOGONALITY_TOL = 1e-6  # largest entry of R^T R - I of a rigid pose
# Distance of two points or planes that count as one, over the grids' size.
COINCIDENCE_TOL = 1e-9


class KnownMotionRays(NamedTuple):
    """One ray per pixel, in the target frame of the poses (the base grid, say).

    Attributes
    ----------
    origins
        (N, 3), anchor points on the first grid that the pixel sees. Where three or more
        points leave a residual, they are next to its point there.
    directions
        (N, 3), unit, from the first grid that the pixel sees towards the last.
    valid
        (N,) bool, whether two or more points gave a line. Elsewhere the other three are
        NaN.
    rms
        (N,), root mean square distance of the pixel's points from the line. Zero for
        two points.
    """

    origins: np.ndarray
    directions: np.ndarray
    valid: np.ndarray
    rms: np.ndarray

    def pluecker(self) -> np.ndarray:
        """Return Plücker matrices (N, 4, 4) of the rays (2.11), NaN where not valid."""
        return pluecker_matrix_of_rays(self.origins, self.directions)


def rays_from_known_motion(
    points: ArrayLike, T_base_grid: ArrayLike, seen: np.ndarray | None = None
) -> KnownMotionRays:
    """Return the rays of N pixels from their points on n grids in known poses.

    **The order of the grids gives the rays their sense**: list them from near to far.
    Two points alone do not determine the sense of a ray. Where two planes cross within
    the view, pixels beyond the crossing see them in the other order, and get the
    opposite ray.

    Two points give their join, exactly. More give the line with the least sum of
    squared distances. The camera may be non-central. Pixels that see fewer than two
    grids have no ray. The same holds for one common point on the first and last grid
    (where two planes cross).

    Parameters
    ----------
    points
        (n, N, 2), n >= 2, in the coordinates of the grids, unit of the poses (mm).
    T_base_grid
        (n, 4, 4), poses of the grids in one frame, which becomes that of the rays.
    seen
        (n, N) bool. None: where the points are finite.

    Returns
    -------
    KnownMotionRays
        One ray for each pixel.

    Raises
    ------
    InputError
        Shapes do not fit, poses are not rigid, or two grids are in one plane.
    CalibrationError
        No pixel sees two grids ("no-overlap").

    References
    ----------
    Thesis section 2.3.3; M. D. Grossberg and S. K. Nayar, ICCV 2001,
    doi:10.1109/ICCV.2001.937611.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import rays_from_known_motion
    >>> poses = np.stack([np.eye(4), np.eye(4)])
    >>> poses[1, 2, 3] = 100.0
    >>> points = np.array([[[0.0, 0.0], [10.0, 0.0]], [[0.0, 0.0], [85.0, 0.0]]])
    >>> rays = rays_from_known_motion(points, poses)
    >>> rays.directions.round(2).tolist()
    [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]
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
    """Line of each pixel through its points p (n, N, 3), as KnownMotionRays."""
    weight = seen.astype(float)[..., None]
    number = weight.sum(axis=0)
    middle = (weight * p).sum(axis=0) / np.maximum(number, 1.0)
    q = weight * (p - middle)
    # The least-squares direction is the dominant axis of the second moments.
    along = np.linalg.eigh(np.einsum("kni,knj->nij", q, q))[1][..., 2]
    first, last = _point_of(p, np.argmax(seen, axis=0)), _point_of(p, _last(seen))
    # For two points, their difference avoids the rounding of moments.
    along = np.where(number == 2, last - first, along)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    size = np.sqrt((weight * p**2).sum(axis=(0, 2)))
    # Equal points of first and last grid leave the sense of the ray undetermined.
    spread = np.linalg.norm(last - first, axis=1)
    valid = (number[:, 0] >= 2) & (spread > COINCIDENCE_TOL * size)
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
    """Points (N, 3) of p (n, N, 3), each on the grid of its own index (N,)."""
    return p[grid, np.arange(p.shape[1])]


def _checked(
    points: ArrayLike, T_base_grid: ArrayLike, seen: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points, poses = np.asarray(points, float), np.asarray(T_base_grid, float)
    if points.ndim != 3 or points.shape[2] != 2 or len(points) < 2:
        raise InputError(
            f"known motion: field 'points': found shape {points.shape}; give (n, N, 2) "
            "with two or more grids"
        )
    if poses.shape != (len(points), 4, 4):
        raise InputError(
            f"known motion: field 'T_base_grid': found shape {poses.shape}; give "
            f"{(len(points), 4, 4)}, one pose per grid"
        )
    _check_rigid(poses)
    finite = np.isfinite(points).all(axis=2)
    seen = finite if seen is None else np.asarray(seen)
    if seen.shape != finite.shape or seen.dtype != bool:
        raise InputError(
            f"known motion: field 'seen': found {seen.dtype} {seen.shape}; give bool "
            f"{finite.shape}"
        )
    seen = seen & finite
    if not np.any(seen.sum(axis=0) >= 2):
        raise CalibrationError(
            "known motion: no pixel sees two grids; move the grids until they overlap "
            "in the image",
            code="no-overlap",
        )
    _check_distinct_planes(points, poses, seen)
    return points, poses, seen


def _check_rigid(poses):
    finite = np.isfinite(poses).all(axis=(1, 2))
    whole = np.where(finite[:, None, None], poses, 0.0)
    R = whole[:, :3, :3]
    skew = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
    last_row = np.abs(whole[:, 3] - [0, 0, 0, 1]).max(axis=1)
    good = (
        (skew < ORTHOGONALITY_TOL)
        & (last_row < ORTHOGONALITY_TOL)
        & (np.linalg.det(R) > 0)
    )
    if not good.all():
        raise InputError(
            f"known motion: field 'T_base_grid': pose {np.argmin(good)} is not rigid; "
            "give a rotation and a translation"
        )


def _check_distinct_planes(points, poses, seen):
    """Raise InputError where points of one grid are in the plane of another."""
    for i, j in itertools.combinations(range(len(poses)), 2):
        both = seen[i] & seen[j]
        if not both.any():
            continue
        x, y = points[j, both].T
        T = inverse_pose(poses[i]) @ poses[j]
        height = T[2, 0] * x + T[2, 1] * y + T[2, 3]
        size = max(np.abs(points[[i, j]][:, both]).max(), np.abs(T[:3, 3]).max())
        if np.abs(height).max() <= COINCIDENCE_TOL * size:
            raise InputError(
                f"known motion: field 'T_base_grid': grids {i} and {j} are in one "
                "plane (no rays); move one of them"
            )
