"""One trial of a case: the same random variation at every level of the case."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import (
    ARC_VARIES,
    CASES,
    CLICK_CAP_PX,
    CLICK_SD_PX,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.sector_board import (
    SectorBoard,
    clicked_from,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import (
    DONE,
    UNSEEN,
    between,
    lost_at,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.windows import (
    no_window,
    overview,
    window_at,
)
from chapters.shared.robustness import LEVELS, board_of
from chapters.shared.scoring import LOST_PX
from chapters.shared.synthetic_board import clicks
from raxel.features.celect import CelectSettings, celect
from raxel.features.celect.hough import angle_apart, orientation
from raxel.geometry import transform

PUBLISHED = CelectSettings()


def why_trial(condition, rng):
    """All levels of a case, with one variation of the board and of the clicks.

    The levels that the case draws come first, with their pictures.
    """
    turn, shift = rng.uniform(0, 360), rng.uniform(-0.5, 0.5, 2)
    arc = 1 + rng.uniform(-ARC_VARIES, ARC_VARIES)
    offsets = clicks(np.zeros((4, 2)), rng, CLICK_SD_PX, CLICK_CAP_PX)
    seed = int(rng.integers(2**31))
    drawn = list(CASES[condition["case"]]["drawn"].values())
    levels = condition["levels"]
    values, where = {}, None
    for label in drawn + [name for name in levels if name not in drawn]:
        level = levels[label]
        board = SectorBoard(**level["board"])
        board = replace(
            board,
            turn_deg=turn,
            shift_px=tuple(shift),
            arc_deg=board.arc_deg * arc,
        )
        noise = np.random.default_rng(seed)
        image = board.image(level["blur_px"], level["noise_sd"], noise)
        settings = replace(PUBLISHED, **level["settings"])
        seen, lost, run = clicked(board, image, level, offsets, settings)
        values[label] = seen
        if label in drawn:
            where = lost.where if lost.where is not None else where
            values[label] |= overview(image, run, lost)
            if where is None:
                values[label] |= no_window()
            else:
                values[label] |= window_at(
                    image, run, where, lost, settings
                )
    return values


def clicked(board, image, level, offsets, settings):
    """One run of CELECT on a picture: (values, Lost, CelectResult)."""
    coordinates = clicked_from(
        board.coordinates, level["start"], level["clockwise"]
    )
    rows, columns = coordinates.shape[:2]
    lattice = board.place(coordinates.reshape(-1, 2)).reshape(
        rows, columns, 2
    )
    outer = lattice[[0, 0, -1, -1], [0, -1, -1, 0]] + offsets
    run = celect(
        image, outer, columns, rows, settings=settings, record=True
    )
    lost = lost_at(run, coordinates, board.place)
    values = {
        "stage": lost.stage,
        "contour": lost.contour,
        "returned": run.found,
        "silently_wrong": run.found and lost.stage != DONE,
        "first_line_wrong": wrong_first_line(coordinates, board.place),
        "merged_ratio": merged_ratio(lattice),
    }
    return values, lost, run


def wrong_first_line(coordinates, place, first_angle_deg=15.0):
    """Whether 3.1.2 foretells a wrong line at the first corner, for true contours.

    (a) the right contour is within t4 of L4, or (b) the wrong one is not, and is
    closer to L1 than the right one.
    """
    right, wrong = (
        _tangent(stops, place)
        for stops in (coordinates[0], coordinates[:, 0])
    )
    corners = place(coordinates[[0, 0, -1], [0, -1, 0]])
    L1, L4 = (orientation(corners[k] - corners[0]) for k in (1, 2))
    if angle_apart(right, L4) <= first_angle_deg:
        return True
    kept = angle_apart(wrong, L4) > first_angle_deg
    return bool(kept and angle_apart(wrong, L1) < angle_apart(right, L1))


def merged_ratio(lattice, merge=0.8, divisor=1.9):
    """Smallest square of the four sides over t8 of its side: merged below 1."""
    sides = (lattice[0], lattice[:, -1], lattice[-1], lattice[:, 0])
    ratios = []
    for corners in sides:
        whole = np.linalg.norm(corners[-1] - corners[0])
        least = np.linalg.norm(np.diff(corners, axis=0), axis=1).min()
        ratios.append(least * divisor * len(corners) / (merge * whole))
    return float(min(ratios))


def _tangent(stops, place):
    """Orientation (deg) in which a contour leaves its first corner."""
    first = place(between(stops))[:2]
    return orientation(first[1] - first[0])


def sweep_trial(condition, rng):
    """A trial of the sweeps of 3.3.1, with the stage that lost it."""
    board = board_of(condition)
    if np.isnan(board.corners).any():
        return {"stage": UNSEEN, "contour": "", "returned": False}
    y, x = np.mgrid[: board.rows, : board.columns].astype(float)
    coordinates = np.stack((x, y), axis=2)

    def place(points):
        flat = np.pad(board.square_px * points, ((0, 0), (0, 1)))
        return board.camera.project(
            transform(board.T_camera_board, flat)
        ).pixels

    image = board.image(
        condition["blur_px"],
        condition["noise_sd"],
        rng,
        LEVELS[condition["levels"]],
    )
    outer = clicks(board.outer_corners, rng)
    run = celect(image, outer, board.columns, board.rows)
    lost = lost_at(run, coordinates, place, LOST_PX)
    return {
        "stage": lost.stage,
        "contour": lost.contour,
        "returned": run.found,
    }
