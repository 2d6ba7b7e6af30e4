"""Central cameras by a synthetic pinhole, complete: CGSP (thesis chapter 4).

As Algorithm 1 of `raxel.calibration.generic.standard`, with another start: the linear
stage of `raxel.calibration.linear.cgsp` solves for all boards that overlap one of them,
the base, at once and excludes outliers, and an adjustment also moves the centre. Boards
that do not overlap the base get their poses from the rays. Source: thesis sections 4.1
and 4.2.
Source: thesis sections 4.1 and 4.2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.bundle import ray_directions, ray_point_distances
from raxel.calibration.adjust.consistent import (
    adjust_consistent,
    centroid_directions,
    relax_poses,
)
from raxel.calibration.generic.board_growth import (
    MIN_N_COMMON_SAMPLES,
    AdjustedBoards,
    GenericCalibration,
    Start,
    completed,
    grown,
)
from raxel.calibration.generic.standard import (
    COARSE_STEP,
    MAX_N_OBSERVATIONS,
    filled_views,
)
from raxel.calibration.linear.cgsp import (
    N_WEIGHTING_ROUNDS,
    CgspSolution,
    homography_to_base,
    solve_homographies,
)
from raxel.calibration.linear.standard import LinearSolution
from raxel.calibration.pose.three_point import RayPose
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.dense import DenseView, sample_boards
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

MAX_N_DENSE_OBSERVATIONS = 3_000_000  # pixel-grid pairs of active grids
MAX_N_BASE_BOARDS = 3  # boards compared as the base, those with the most overlap first


def calibrate_cgsp(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    *,
    rng: np.random.Generator,
    units: str = "mm",
    side: int = -1,
    interpolation: str = "by need",
    pinhole: str = "sturm-maybank",
    adjust: bool = True,
) -> GenericCalibration:
    """Return a general central camera from three or more overlapping chessboard views.

    Parameters
    ----------
    views
        BoardViews or DenseViews.
    width, height
        Size of the image, px.
    rng
        Random generator of numpy (RANSAC).
    units, side, interpolation
        As `calibrate_generic`.
    pinhole
        A name of PINHOLE_METHODS.
    adjust
        Whether centre, poses and rays are adjusted together in the end
        (`adjust_consistent`). False leaves the centre of the linear stage, as the
        thesis does.

    Returns
    -------
    GenericCalibration
        Camera, poses and diagnostics.

    Raises
    ------
    CalibrationError
        Fewer than three chessboards overlap enough ("too-few-grids", "no-overlap"), or
        chessboards are parallel. The message has one line.
    InputError
        Counts of the views do not fit.

    References
    ----------
    Thesis sections 4.1 and 4.2.
    """
    views, chosen = filled_views(views, interpolation)
    dense = all(view.every_pixel for view in views)
    observations = MAX_N_DENSE_OBSERVATIONS if dense else MAX_N_OBSERVATIONS
    coarse = sample_boards(views, width, height, MAX_N_OBSERVATIONS).thinned(
        COARSE_STEP
    )
    samples = sample_boards(views, width, height, observations)
    start = _start(coarse, side, pinhole, rng)
    start = _linear(samples, start.boards, side, pinhole, rng)
    growth = grown(coarse, start, rng)
    found = _adjusted(views, samples, growth) if adjust else _as_grown(samples, growth)
    return completed(views, width, height, units, samples, growth, found, chosen)


def _adjusted(views, samples, growth):
    """Centre, poses and rays together, with a small weight of outliers."""
    points, seen = samples.points[growth.boards], samples.seen[growth.boards]
    sigma = None
    if all(view.every_pixel for view in views):
        u, v = samples.pixels.T
        sigma = np.stack([views[k].sigma[v, u] for k in growth.boards])
    centre = growth.start.linear.centre
    result = adjust_consistent(
        points, seen, centre, growth.T_base_grid, sigma=sigma, loss="huber"
    )
    return AdjustedBoards(result.centre, result.T_base_grid, result.directions)


def _as_grown(samples, growth):
    centre = growth.start.linear.centre
    points, seen = samples.points[growth.boards], samples.seen[growth.boards]
    directions = ray_directions(points, seen, centre, growth.T_base_grid)
    return AdjustedBoards(centre, growth.T_base_grid, directions)


def _start(samples, side, pinhole, rng):
    """Start whose base determines the centre best, of the bases tried."""
    common = samples.seen.astype(int) @ samples.seen.T
    np.fill_diagonal(common, 0)
    overlaps = common >= MIN_N_COMMON_SAMPLES
    bases = sorted(
        range(len(common)), key=lambda k: (-overlaps[k].sum(), -common[k].sum())
    )
    starts, failures = [], []
    for base in bases:
        boards = (base, *np.flatnonzero(overlaps[base]).tolist())
        try:
            starts.append(_linear(samples, boards, side, pinhole, rng))
        except CalibrationError as error:
            failures.append(error)
        if len(starts) == MAX_N_BASE_BOARDS:
            break
    if not starts:
        raise CalibrationError(
            f"CGSP: no three boards give a start ({failures[0]}); take more images",
            code=failures[0].code,
        )
    return max(starts, key=lambda start: start.linear.margin)


def _linear(samples, boards, side, pinhole, rng):
    """Start from a base and the boards whose rays agree with one homography to it."""
    fits, retained, failures = [], [0], []
    points, seen = samples.points[list(boards)], samples.seen[list(boards)]
    for k in range(1, len(boards)):
        try:
            fits.append(homography_to_base(points, seen, k, "ransac", rng))
            retained.append(k)
        except CalibrationError as error:
            failures.append(error)
    if len(retained) < 3 and failures:
        raise failures[0]
    if len(retained) < 3:
        raise CalibrationError(
            "no board overlaps two others in the image; take more images whose boards "
            "share an area",
            code="no-overlap",
        )
    solution = solve_homographies(
        points[retained], fits, side=side, pinhole=pinhole, rounds=N_WEIGHTING_ROUNDS
    )
    return Start(tuple(boards[k] for k in retained), solution)


# Central camera from decoded grids, by the protocol of section 4.3.1. The first grids
# give the linear stage, and the standard method adjusts their poses with a fixed
# centre. Each further grid gets a pose from the known rays and extends the calibrated
# area. The order is that of the grids, without a search for a base
# (`raxel.calibration.generic.cgsp` and `standard` search).


# Distance of an inlier from its ray, over the usual distance.
INLIER_RATIO = 5.0
MIN_INLIER_THRESHOLD_MM = 0.5


class CentralCalibration(NamedTuple):
    """Hold the result of `calibrate_central`.

    Attributes
    ----------
    centre : ndarray, shape (3,)
        Camera centre in the frame of the first grid, mm.
    T_base_grid : ndarray, shape (n, 4, 4)
        Poses of the grids in the frame of the first one, mm.
    directions : ndarray, shape (N, 3)
        Unit directions, NaN for rays that see no grid in `used`.
    used : tuple of int
        Indices of the grids with a pose.
    failed : dict
        Reason by index of a grid without a pose.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    directions: np.ndarray
    used: list
    failed: dict


def relaxed_start(
    points: np.ndarray, start: LinearSolution | CgspSolution, most: int | None = None
) -> LinearSolution | CgspSolution:
    """Return the linear stage with its poses adjusted as in the thesis, centre kept.

    Parameters
    ----------
    points
        (n, N, 2), mm. NaN where a ray does not see a grid.
    start
        Linear solution of these grids.
    most
        Approximate number of rays used, of those that see two grids or more. None: all.

    Returns
    -------
    LinearSolution or CgspSolution
        The start with adjusted poses.
    """
    seen = np.isfinite(points[..., 0])
    shared = np.flatnonzero(np.sum(seen, axis=0) >= 2)
    chosen = shared if most is None else shared[:: max(1, len(shared) // most)]
    found = relax_poses(
        points[:, chosen], seen[:, chosen], start.centre, start.T_base_grid
    )
    return start._replace(T_base_grid=found.T_base_grid)


def calibrate_central(
    points: np.ndarray,
    start: LinearSolution | CgspSolution,
    place: Callable[..., RayPose],
    rng: np.random.Generator,
    *,
    weight: float = 1.0,
    threshold: float | None = None,
    most: int | None = None,
    join: bool = True,
) -> CentralCalibration:
    """Return centre, poses and rays from grids that are decoded in the same pixels.

    A grid whose pose cannot be estimated is excluded, with the reason.

    Parameters
    ----------
    points
        (n, N, 2) on n grids, mm. NaN where a ray does not see one.
    start
        Centre and T_base_grid (k, 4, 4) of the first k grids, such as a LinearSolution.
    place
        `grid_pose_ransac` (CGSP) or `pose_from_rays` (standard), called with rays,
        points, rng, threshold.
    rng
        Random generator of numpy.
    weight
        In a ray, of a point of the first k grids over one of a further grid (4.1.3).
    threshold
        Threshold of RANSAC, mm. None: five times the median ray-point distance of the
        first grids, and 0.5 at least.
    most
        Number of random rays that a pose is estimated from. None: all.
    join
        Whether a grid's points move the rays that give the next pose.

    Returns
    -------
    CentralCalibration
        Centre, poses, directions, used and failed grids.

    References
    ----------
    Thesis section 4.3.1.
    """
    centre, first = start.centre, len(start.T_base_grid)
    seen = np.isfinite(points[..., 0])
    placed, used, failed = list(start.T_base_grid), list(range(first)), {}

    def joined():
        weights = np.where(np.array(used) < first, weight, 1.0)
        return centroid_directions(
            points[used], seen[used], centre, np.stack(placed), weights
        )

    rays = joined()
    if threshold is None:
        usual = np.median(_distances(points[:first], seen[:first], start, rays))
        threshold = max(INLIER_RATIO * float(usual), MIN_INLIER_THRESHOLD_MM)
    for grid in range(first, len(points)):
        known = np.flatnonzero(np.isfinite(rays[:, 0] + points[grid, :, 0]))
        if most is not None and len(known) > most:
            known = np.sort(rng.choice(known, most, replace=False))
        try:
            found = place(rays[known], points[grid, known], rng, threshold)
        except CalibrationError as fault:
            failed[grid] = str(fault)
            continue
        T = found.T_camera_grid.copy()
        T[:3, 3] += centre
        placed.append(T)
        used.append(grid)
        if join:
            rays = joined()
    return CentralCalibration(centre, np.stack(placed), joined(), used, failed)


def _distances(points, seen, start, rays):
    """Distances (M,) mm of points from their rays, for rays that two grids share."""
    shared = seen & (np.sum(seen, axis=0) >= 2)
    return np.concatenate(
        [
            ray_point_distances(
                transform(T, on_plane(own[here])), start.centre, rays[here]
            )
            for own, T, here in zip(points, start.T_base_grid, shared, strict=True)
        ]
    )
