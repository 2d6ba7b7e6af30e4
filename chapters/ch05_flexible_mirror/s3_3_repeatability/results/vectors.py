"""Vectors of Fig. 5.13 at the edge of the board that is seen next to the clamp."""

from functools import lru_cache

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import PANELS
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, mirror_rig
from raxel.geometry import inverse_pose, transform

SAME_ROW_MM = 1e-6


def below_at_the_edge(runs):
    """Whether the error is below the mean next to the clamp in all panels, run by run,
    as `counterpart` uses it: a run without a panel does not count."""
    ratios = np.array([edge_ratios(runs, place) for place in PANELS])
    worst = ratios.max(axis=0)
    with np.errstate(invalid="ignore"):
        return worst < 1, worst, "x", "edge over all, the largest of four panels"


def edge_ratios(runs, place):
    """Mean error at the edge next to the clamp over the mean of all corners, (seeds,).

    The edge: in each row of the board the visible corner nearest to the clamp.
    """
    found = np.full(runs.seeds, np.nan)
    board, reached, errors = vectors_at(runs, place)
    for seed, own in zip(reached, errors, strict=True):
        size = np.linalg.norm(own, axis=1)
        edge = next_to_clamp(board, np.isfinite(size), way_to_clamp())
        found[seed] = size[edge].mean() / size[np.isfinite(size)].mean()
    return np.where(runs.goes_on(place), found, np.nan)


def vectors_at(runs, place):
    """The board's corners (N, 2) mm, the runs (n,) that reached this place, and their
    errors, n times (N, 2) mm, NaN where a corner was not visible."""
    reached = np.flatnonzero(np.isfinite(runs.raw(f"{place}.back_mm")))
    board = runs.result.arrays(f"{runs.bench}.board_mm")[0]
    errors = runs.result.arrays(f"{runs.bench}.{place}.own")
    return board, reached, errors


def next_to_clamp(board, seen, way):
    """Indices of the edge's corners: board (N, 2) mm, seen (N,), way: see
    `way_to_clamp`."""
    indices = np.flatnonzero(seen)
    rows = np.round(board[indices, 1] / SAME_ROW_MM)
    return np.array(
        [
            indices[rows == row][np.argmax(way * board[indices[rows == row], 0])]
            for row in np.unique(rows)
        ]
    )


@lru_cache(maxsize=1)
def way_to_clamp():
    """1 or -1: the sense of the board's x axis that the mirror shows towards its clamp,
    of boards as they are held before geometry A."""
    rig = mirror_rig("A")
    T = rig.board_pose(np.random.default_rng(0), BACK_PROJECTION_MM)
    camera, board = rig.camera(0.0), rig.board.points()
    pixels, seen = rig.corners(camera, T)
    mirror = transform(
        inverse_pose(camera.T_viewer_mirror), camera.rays(pixels).origins
    )
    along = np.corrcoef(board[seen, 0], mirror[seen, 0])[0, 1]
    return -int(np.sign(along))
