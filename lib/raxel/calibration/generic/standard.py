"""Standard generic method for central cameras, complete: Algorithm 1 (section 2.4).

Input are chessboards in any pose, without a camera model. Points come from
interpolation between corners (in the thesis "homographic"; by default a smooth one for
bent cells) or from decoded pixels of an active grid. Steps: linear centre and poses of
three boards, bundle adjustment, the other boards one after the other by three-point
pose on the known rays, bundle adjustment over all, and a ray for every covered pixel.

Ground truth is not used. The first three boards are selected by how well they determine
the centre (margin of the linear stage), then by their results: the most boards that
agree, with the smallest angles between rays and points.

Sources: thesis section 2.4; P. Sturm and S. Ramalingam, ECCV 2004,
doi:10.1007/978-3-540-24671-8_1.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from raxel.calibration.generic.board_growth import (
    MIN_N_COMMON_SAMPLES,
    AdjustedBoards,
    GenericCalibration,
    Start,
    adjusted,
    completed,
    grown,
)
from raxel.calibration.linear.standard import (
    grid_pair,
    linear_as_printed,
    margins_of_pairs,
    normalising_similarity,
    solve_grid_pairs,
)
from raxel.calibration.views.correspondence import BoardView, check_view
from raxel.calibration.views.dense import BoardSamples, DenseView, sample_boards
from raxel.calibration.views.interpolation import interpolated_view
from raxel.errors import CalibrationError

MAX_N_OBSERVATIONS = 30_000  # pixel-board pairs of the final adjustment
COARSE_STEP = 2  # sampling step per axis during the selection of boards
MAX_N_BOARDS_PER_BASE = 12  # boards that are tried with one base
MAX_N_STARTS = 3  # first triples tried, each with another base


def calibrate_generic(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    *,
    rng: np.random.Generator,
    linear: str = "well conditioned",
    units: str = "mm",
    side: int = -1,
    interpolation: str = "by need",
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
    linear
        "well conditioned" or "as printed" (with t_z as corrected).
    units
        Unit of the points of the chessboard, "mm" or "pitch".
    side
        Sign of C_z in the frame of the base chessboard. -1 for corners ordered so that
        x turns clockwise into y in the image.
    interpolation
        Between corners: "homographic" as in the thesis, "smooth" or "by need". The last
        takes for each chessboard the one with the smaller error; see
        `raxel.calibration.views.interpolation`.

    Returns
    -------
    GenericCalibration
        Camera, poses and diagnostics.

    Raises
    ------
    CalibrationError
        Fewer than three chessboards overlap enough ("too-few-grids", "no-overlap"),
        chessboards are parallel, or the linear stage fails on all ("no-start"). The
        message has one line.
    InputError
        Counts of the views do not fit.

    References
    ----------
    Thesis section 2.4, Algorithm 1; P. Sturm and S. Ramalingam, ECCV 2004,
    doi:10.1007/978-3-540-24671-8_1.
    """
    boards = compared_boards(views, width, height, interpolation)
    return calibrate_compared(boards, rng=rng, linear=linear, units=units, side=side)


class ComparedBoards(NamedTuple):
    """Hold boards with points at pixels, and how well triples determine a centre.

    Attributes
    ----------
    views : list of BoardView or DenseView
        Views with points between the corners.
    interpolation : list of str
        Interpolation of each view.
    width, height : int
        Image size, px.
    samples, coarse : BoardSamples
        All samples, and those for the selection of boards.
    pairs : dict
        GridPair by (base, other).
    triples : list of tuple
        Triples (base, j, k) of each base, the best determined first.
    failures : list
        Reasons why other triples determine no centre.
    """

    views: tuple
    interpolation: tuple
    width: int
    height: int
    samples: BoardSamples
    coarse: BoardSamples
    pairs: dict
    triples: list
    failures: list


def compared_boards(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    interpolation: str = "by need",
) -> ComparedBoards:
    """Return the input of the linear stage, the same for all variants of Algorithm 1.

    Parameters
    ----------
    views, width, height, interpolation
        As `calibrate_generic`.

    Returns
    -------
    ComparedBoards
        Samples, pairs and ranked triples of chessboards.

    Raises
    ------
    CalibrationError, InputError
        As `calibrate_generic`.
    """
    views, chosen = filled_views(views, interpolation)
    samples = sample_boards(views, width, height, MAX_N_OBSERVATIONS)
    coarse = samples.thinned(COARSE_STEP)
    pairs = _grid_pairs(coarse)
    failures = []  # type: ignore[var-annotated]
    triples = [_ranked(pairs, base, failures) for base in range(len(views))]
    return ComparedBoards(
        views,  # type: ignore[arg-type]
        chosen,
        width,
        height,
        samples,
        coarse,
        pairs,
        triples,
        failures,
    )


def calibrate_compared(
    boards: ComparedBoards,
    *,
    rng: np.random.Generator,
    linear: str = "well conditioned",
    units: str = "mm",
    side: int = -1,
) -> GenericCalibration:
    """Return `calibrate_generic` of ComparedBoards, for one linear variant.

    Parameters
    ----------
    boards
        Result of `compared_boards`.
    rng, linear, units, side
        As `calibrate_generic`.

    Returns
    -------
    GenericCalibration
        Camera, poses and diagnostics.

    Raises
    ------
    CalibrationError
        As `calibrate_generic`.
    ValueError
        `linear` is neither of the two.
    """
    if linear not in ("well conditioned", "as printed"):
        raise ValueError(
            f"linear: found {linear!r}; give 'well conditioned' or 'as printed'"
        )
    growths, failures = [], []
    for start in _starts(boards, linear, side)[:MAX_N_STARTS]:
        try:
            growths.append(grown(boards.coarse, start, rng))
        except CalibrationError as error:
            failures.append(error)
    if not growths:
        raise CalibrationError(
            f"generic calibration: {failures[0]}", code=failures[0].code
        )
    best = max(growths, key=lambda g: (len(g.boards), -g.rms))
    centre = best.start.linear.centre
    samples = boards.samples
    poses, directions, _ = adjusted(
        samples, best.boards, centre, best.T_base_grid, tolerance=1e-9
    )
    found = AdjustedBoards(centre, poses, directions)
    return completed(
        boards.views,
        boards.width,
        boards.height,
        units,
        samples,
        best,
        found,
        boards.interpolation,
    )


def filled_views(views, interpolation):
    """Three views or more with points between their corners, and their
    interpolation."""
    views = [check_view(view) for view in views]
    if len(views) < 3:
        raise CalibrationError(
            f"generic calibration: found {len(views)} boards; give three or more that "
            "overlap at different tilts",
            code="too-few-grids",
        )
    filled = [interpolated_view(view, interpolation) for view in views]
    return zip(*filled, strict=True)


# ------------------------------------------------------------- the first three boards


def _starts(boards, linear, side):
    """Starts with different bases, the best determined first.

    Raises CalibrationError with the most frequent reason when there is none.
    """
    starts, failures = [], [*boards.failures]
    for triples in boards.triples:
        for triple in triples[:MAX_N_BOARDS_PER_BASE]:
            try:
                solution = _linear(boards, triple, linear, side)
            except CalibrationError as error:
                failures.append(str(error))
                continue
            starts.append(Start(triple, solution))
            break
    if not starts and not failures:
        raise CalibrationError(
            "generic calibration: no board overlaps two others in the image; take more "
            "images whose boards share an area",
            code="no-overlap",
        )
    if not starts:
        reason = max(set(failures), key=lambda text: (failures.count(text), text))
        raise CalibrationError(
            f"generic calibration: no three boards give a start ({reason}); take more "
            "images",
            code="no-start",
        )
    return sorted(starts, key=lambda start: -start.linear.margin)


def _ranked(pairs, base, failures):
    """Triples (base, j, k), the best determined centre first."""
    others = sorted(
        (k for b, k in pairs if b == base), key=lambda k: pairs[base, k].noise
    )[:MAX_N_BOARDS_PER_BASE]
    picks = list(itertools.combinations(range(len(others)), 2))
    if not picks:
        return []
    margins = margins_of_pairs([pairs[base, k] for k in others], picks)
    found = {}
    for (j, k), margin in zip(picks, margins, strict=True):
        triple = base, others[j], others[k]
        if np.isfinite(margin):
            found[triple] = margin
            continue
        try:
            _solved(pairs, triple)
        except CalibrationError as error:
            failures.append(str(error))
    return sorted(found, key=lambda triple: -found[triple])


def _linear(boards, triple, variant, side):
    """LinearSolution of three boards; as printed, with the margin of the other."""
    solution = _solved(boards.pairs, triple, side)
    if variant == "well conditioned":
        return solution
    points, seen = boards.coarse.points[[*triple]], boards.coarse.seen[[*triple]]
    printed = linear_as_printed(*points[:, seen.all(axis=0)], side=side, tz="corrected")
    return printed._replace(margin=solution.margin)


def _solved(pairs, triple, side=-1):
    base, j, k = triple
    return solve_grid_pairs([pairs[base, j], pairs[base, k]], side)


def _grid_pairs(samples):
    """{(base, other): GridPair} of all boards with enough common samples."""
    points, seen = samples.points, samples.seen
    similarities = [
        normalising_similarity(p[s]) if s.any() else None
        for p, s in zip(points, seen, strict=True)
    ]
    pairs = {}
    for a, b in itertools.permutations(range(len(points)), 2):
        both = seen[a] & seen[b]
        if np.count_nonzero(both) < MIN_N_COMMON_SAMPLES:
            continue
        try:
            pairs[a, b] = grid_pair(
                points[a][both], points[b][both], similarities[a], similarities[b]
            )
        except CalibrationError:
            continue  # a strip of points does not determine a homography
    return pairs
