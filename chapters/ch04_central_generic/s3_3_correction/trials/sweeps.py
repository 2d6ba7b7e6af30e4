"""What is photographed, calibrated and drawn again for Figs 4.7 to 4.9."""

from functools import partial

from chapters.ch04_central_generic.s3_3_correction.trials.boards import seed_trial
from chapters.ch04_central_generic.s3_3_correction.trials.rigs import ALL_SETS, STEP
from chapters.ch04_central_generic.s3_3_correction.trials.scenes import (
    lines_trial,
    pictures_trial,
)
from chapters.shared.central_sets import GRID_SETS, RIGS, SEEDS, SMALL, grid_conditions
from chapters.shared.decoding_errors import DecodingErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# Of the vectors of Fig. 4.9; at the thesis's 15 times nothing would be seen.
MAGNIFIED = 40
LINES = {"quick": 2, "full": 50}
LINES_STEP = {"quick": 4, "full": 12}


@experiment("fig_4_9_boards", artefact="fig_4_9", rendered=ALL_SETS, shards={"full": 2})
def boards(effort):
    """Every rendered seed of both cameras: chessboards, corrected."""
    cases = [case | {"step": STEP[effort]} for case in grid_conditions(effort)]
    return Plan(seed_trial, cases, 1, {"step_px": STEP[effort], "magnified": MAGNIFIED})


@experiment(
    "fig_4_7_pictures", artefact="fig_4_7", rendered=GRID_SETS, shards={"full": 2}
)
def pictures(effort):
    """Two frames of a room by each camera, as taken and corrected."""
    cases = [
        {"camera": camera, "rig": name + SMALL[effort], "step": STEP[effort]}
        for camera, name in RIGS.items()
    ]
    return Plan(pictures_trial, cases, 1, {"step_px": STEP[effort]})


@experiment(
    "fig_4_7_lines",
    artefact="fig_4_7",
    rendered=GRID_SETS,
    shards={"full": 2},
    needs=("table_4_3_errors",),
)
def lines(effort, results):
    """Redrawn calibrations of both cameras: edges, and the field of view."""
    step = LINES_STEP[effort]
    cases = [
        {
            "camera": camera,
            "rig": name + SMALL[effort],
            "seeds": list(SEEDS[effort]),
            "step": step,
        }
        for camera, name in RIGS.items()
    ]
    errors = DecodingErrors.by_rig(results["table_4_3_errors"])
    trial = partial(lines_trial, errors=errors)
    return Plan(trial, cases, LINES[effort], {"step_px": step})
