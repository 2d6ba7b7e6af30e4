"""Central cameras by a synthetic pinhole, complete: CGSP (thesis chapter 4).

As Algorithm 1 of `raxel.calibration.generic.standard`, with another beginning: all
boards that overlap one of them, the base, are solved for at once by the linear stage of
`raxel.calibration.linear.cgsp`, which leaves out wrong points, and an adjustment moves
the centre too. Boards that do not overlap the base get their poses from the rays.

Source: thesis sections 4.1 and 4.2.
"""

import numpy as np

from raxel.calibration.adjust.bundle import ray_directions
from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.generic.board_growth import (
    MIN_COMMON,
    AdjustedBoards,
    Start,
    completed,
    grown,
)
from raxel.calibration.generic.standard import COARSE, OBSERVATIONS, filled_views
from raxel.calibration.linear.cgsp import ROUNDS, homography_to_base, solve_homographies
from raxel.calibration.views.parallel import refuse_parallel
from raxel.calibration.views.samples import sample_boards
from raxel.errors import CalibrationError

DENSE_OBSERVATIONS = 3_000_000  # pixel-grid pairs computed with, of active grids
BASES = 3  # boards compared as the base, those that overlap the most first


def calibrate_cgsp(
    views,
    width,
    height,
    *,
    rng,
    units="mm",
    side=-1,
    interpolation="by need",
    pinhole="sturm-maybank",
    adjust=True,
):
    """A general central camera from three or more overlapping views of a board.

    views: BoardViews or DenseViews; width, height: the image in px; rng: numpy
    Generator (RANSAC); units, side, interpolation: as `calibrate_generic`. pinhole: a
    name of `synthetic_pinhole.PINHOLE_METHODS`. adjust: whether centre, poses and rays
    are adjusted together in the end (`adjust_consistent`); False leaves the centre as
    the linear stage has it, as the thesis does.

    Returns GenericCalibration. Raises CalibrationError, in one line, when fewer than
    three boards overlap enough or boards are parallel; InputError for views whose
    counts do not fit.
    """
    views, chosen = filled_views(views, interpolation)
    dense = all(view.every_pixel for view in views)
    observations = DENSE_OBSERVATIONS if dense else OBSERVATIONS
    coarse = sample_boards(views, width, height, OBSERVATIONS).thinned(COARSE)
    samples = sample_boards(views, width, height, observations)
    start = _start(coarse, side, pinhole, rng)
    start = _linear(samples, start.boards, side, pinhole, rng)
    growth = grown(coarse, start, rng)
    refuse_parallel(growth.T_base_grid[:, :3, :3], "CGSP", needed=3)
    found = _adjusted(views, samples, growth) if adjust else _as_grown(samples, growth)
    return completed(views, width, height, units, samples, growth, found, chosen)


def _adjusted(views, samples, growth):
    """Centre, poses and rays together; wrong points count little."""
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
    """The Start whose base determines the centre best, of the bases tried."""
    common = samples.seen.astype(int) @ samples.seen.T
    np.fill_diagonal(common, 0)
    overlaps = common >= MIN_COMMON
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
        if len(starts) == BASES:
            break
    if not starts:
        raise CalibrationError(
            f"CGSP: no three boards begin: {failures[0]}", code=failures[0].code
        )
    return max(starts, key=lambda start: start.linear.margin)


def _linear(samples, boards, side, pinhole, rng):
    """Start from a base and the boards whose rays agree with one homography to it."""
    fits, kept, failures = [], [0], []
    points, seen = samples.points[list(boards)], samples.seen[list(boards)]
    for k in range(1, len(boards)):
        try:
            fits.append(homography_to_base(points, seen, k, "ransac", rng))
            kept.append(k)
        except CalibrationError as error:
            failures.append(error)
    if len(kept) < 3 and failures:
        raise failures[0]
    if len(kept) < 3:
        raise CalibrationError(
            "no board overlaps two others in the image; take more images whose boards"
            " share an area",
            code="no-overlap",
        )
    solution = solve_homographies(
        points[kept], fits, side=side, pinhole=pinhole, rounds=ROUNDS
    )
    return Start(tuple(boards[k] for k in kept), solution)
