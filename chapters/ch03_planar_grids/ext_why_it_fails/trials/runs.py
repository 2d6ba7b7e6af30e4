"""The trial of a case, the same random variation at all its levels; and its plans."""

from dataclasses import replace

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import (
    ARC_VARIES,
    CASES,
    CLICK_CAP_PX,
    CLICK_SD_PX,
    VARIATION,
    levels_of,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.sector_board import (
    SectorBoard,
    clicked_from,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import (
    DONE,
    between,
    lost_at,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.windows import (
    overview,
    window_at,
)
from chapters.shared.lattices import outer
from chapters.shared.synthetic_board import clicks
from raxel.features.celect import CelectSettings, celect
from raxel.features.celect.hough import angle_apart, orientation
from repro.run.experiment import experiments
from repro.run.outcomes import Plan

PUBLISHED = CelectSettings()
TRIALS = {"quick": 1, "full": 20}


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
            board, turn_deg=turn, shift_px=tuple(shift), arc_deg=board.arc_deg * arc
        )
        noise = np.random.default_rng(seed)
        image = board.image(level["blur_px"], level["noise_sd"], noise)
        settings = replace(PUBLISHED, **level["settings"])
        seen, lost, run = clicked(board, image, level, offsets, settings)
        values[label] = seen
        if label in drawn:
            where = lost.where if lost.where is not None else where
            values[label] |= overview(image, run, lost)
            values[label] |= window_at(image, run, where, lost, settings)
    return values


def clicked(board, image, level, offsets, settings):
    """One run of CELECT on a picture: (values, Lost, CelectResult)."""
    coordinates = clicked_from(board.coordinates, level["start"], level["clockwise"])
    rows, columns = coordinates.shape[:2]
    lattice = board.place(coordinates.reshape(-1, 2)).reshape(rows, columns, 2)
    where = outer(lattice) + offsets
    run = celect(image, where, columns, rows, settings=settings, record=True)
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
        _tangent(stops, place) for stops in (coordinates[0], coordinates[:, 0])
    )
    corners = place(coordinates[[0, 0, -1], [0, -1, 0]])
    L1, L4 = (orientation(corners[k] - corners[0]) for k in (1, 2))
    if angle_apart(right, L4) <= first_angle_deg:
        return True
    kept = angle_apart(wrong, L4) > first_angle_deg
    return bool(kept and angle_apart(wrong, L1) < angle_apart(right, L1))


def merged_ratio(lattice, merge=0.8, divisor=1.9):
    """Smallest square of the four sides over t8 of its side: merged below 1."""

    def ratio(corners):
        whole = np.linalg.norm(corners[-1] - corners[0])
        least = np.linalg.norm(np.diff(corners, axis=0), axis=1).min()
        return least * divisor * len(corners) / (merge * whole)

    sides = (lattice[0], lattice[:, -1], lattice[-1], lattice[:, 0])
    return float(min(map(ratio, sides)))


def _tangent(stops, place):
    """Orientation (deg) in which a contour leaves its first corner."""
    first = place(between(stops))[:2]
    return orientation(first[1] - first[0])


@experiments(
    {
        # How far the sheet goes on beyond the outermost corners.
        "ext_why_clearance": "ext_why_clearance",
        # The right contour of the first corner comes within t4 of L4.
        "ext_why_first_corner": "ext_why_first_corner",
        # The wrong contour of the first corner leaves t4 of L4, closer to L1.
        "ext_why_wrong_contour": "ext_why_wrong_contour",
        # Eight ways to click one picture.
        "ext_why_direction": "ext_why_direction",
        # The window's radius, times a factor.
        "ext_why_window": "ext_why_window",
        # The same bend with fewer and larger squares.
        "ext_why_curvature": "ext_why_curvature",
        # Squares that grow along a contour.
        "ext_why_size_variation": "ext_why_size_variation",
        # Blur, and noise.
        "ext_why_blur_noise": "ext_why_blur_noise",
    }
)
def cases(effort, identifier):
    """A case: all its levels in one trial."""
    case = identifier.removeprefix("ext_why_")
    condition = {"case": case, "levels": levels_of(case, effort)}
    return Plan(why_trial, [condition], TRIALS[effort], VARIATION)
