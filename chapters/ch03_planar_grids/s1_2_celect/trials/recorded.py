"""Recorded runs of CELECT: every step, or the order of the code's stages."""

import sys

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.boards import NOISE_SD
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import board_view
from chapters.shared.lattices import outer
from chapters.shared.scoring import scored
from chapters.shared.synthetic_board import SyntheticBoard, clicks
from raxel.features.celect import celect
from raxel.features.celect.algorithm import snapped
from raxel.features.celect.hough import peaks_of, vote
from raxel.features.celect.layers import Layers
from raxel.features.celect.processing import processed
from raxel.features.celect.trace import (
    Tracer,
    first_line,
    near_lines,
    next_anchor,
    next_line,
)
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


def recorded(result):
    """Arrays of a recorded run: contours end to end, and every step.

    steps (n, 9): contour, u, v and radius of the window, R and theta of its
    line, u and v of the next anchor, number of lines. corners (m, 3): step,
    u, v. edges (k, 3): the same of the edge pixels.
    """
    steps = [
        (number, step)
        for number, contour in enumerate(result.contours)
        for step in contour.steps
    ]

    def seen(what):
        """Rows of one attribute of every step, the step's number first."""
        rows = [
            [here, *one]
            for here, (_, step) in enumerate(steps)
            for one in getattr(step, what)
        ]
        return np.array(rows, float)

    walked = [
        [
            number,
            *step.centre,
            step.radius,
            *step.lines[step.chosen],
            *step.anchor,
            len(step.lines),
        ]
        for number, step in steps
    ]
    merged = [
        [number, *c]
        for number, contour in enumerate(result.contours)
        for c in contour.merged
    ]
    return {
        "steps": np.array(walked, float),
        **{what: seen(what) for what in ("corners", "edges", "lines")},
        "merged": np.array(merged, float),
        "outer": result.outer_corners,
        "grid": result.corners,
        "s": np.array([c.s for c in result.contours]),
    }


def drawn_run(condition, rng):
    """One recorded run for a figure: the first random view that is correct."""
    for tried in range(1, condition["views"] + 1):  # noqa: B007
        view = board_view(
            condition["camera"], condition["size_px"], condition["least_px"], rng
        )
        rows, columns = view.lattice.shape[:2]
        where = clicks(outer(view.lattice), rng)
        result = celect(view.image, where, columns, rows, record=True)
        if result.found:
            break
    seen = {"image": view.image, "tried": tried}
    return scored(result, view.lattice) | recorded(result) | seen


@experiment("fig_3_1_run", artefact="fig_3_1")
def run_on_fisheye(effort):
    """Run for a figure: windows, lines, candidates of every step."""
    condition = {"camera": "fisheye", "size_px": 600, "least_px": 22, "views": 10}
    return Plan(drawn_run, [condition], 1)


@experiment("fig_3_4_run", artefact="fig_3_4")
def run_on_mirror(effort):
    """Run on a mirror image for a figure."""
    condition = {"camera": "hyperboloid", "size_px": 900, "least_px": 18, "views": 10}
    return Plan(drawn_run, [condition], 1)


STAGES = {
    "snap": snapped,
    "window": Layers.edges,
    "hough": vote,
    "peaks": peaks_of,
    "near": near_lines,
    "first line": first_line,
    "next line": next_line,
    "anchor": next_anchor,
    "corners": Layers.corners,
    "arrived": Tracer._arrived,
    "process": processed,
}


def stage_trial(condition, rng):
    """Count how often each stage of the code follows another one in a run.

    Keys "a > b". Calls within the snapping of the clicks count as snapping; the
    choice of a first line is one stage.
    """
    board = SyntheticBoard()
    image = board.image(1.0, NOISE_SD, rng)
    where = clicks(board.outer_corners, rng)
    names = {f.__code__: name for name, f in STAGES.items()}
    whole = {snapped.__code__, first_line.__code__}
    order, within = [], []

    def note(frame, event, _):
        code = frame.f_code
        if event == "call" and code in names and not within:
            order.append(names[code])
        if code in whole and event == "call":
            within.append(code)
        elif code in whole and event == "return":
            within.pop()

    sys.setprofile(note)
    try:
        result = celect(image, where, board.columns, board.rows)
    finally:
        sys.setprofile(None)
    counts = {"found": result.found, "contours": len(result.contours)}
    for pair in zip(["start", *order], [*order, "end"], strict=True):
        key = " > ".join(pair)
        counts[key] = counts.get(key, 0) + 1
    return counts


@experiment("fig_3_3_stages", artefact="fig_3_3")
def stages(effort):
    """Transitions between stages of the code, counted in a run."""
    return Plan(stage_trial, [{}], 1)
