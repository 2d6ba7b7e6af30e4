"""The synthetic board in many sizes: large squares, and one smoothing for all."""

from chapters.ch03_planar_grids.s1_2_celect.trials import boards
from chapters.shared.synthetic_board import SyntheticBoard
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SQUARES_ACROSS = (20, 15, 12, 10, 8, 6, 5)


def square_trial(condition, rng):
    """The synthetic board with larger squares under strong distortion."""
    board = SyntheticBoard(
        square_px=1000 / condition["squares_across"], fov_deg=condition["fov_deg"]
    )
    return boards.clicked_score(board, boards.NOISE_SD, rng)


@experiment("exp_c3_big_square", artefact="sec_3_1_2", shards={"full": 2})
def big_squares(effort):
    """Sizes of square at three wide fields of view."""
    across = SQUARES_ACROSS[::6] if effort == "quick" else SQUARES_ACROSS
    conditions = [
        {"squares_across": n, "fov_deg": fov} for fov in boards.BIG_FOVS for n in across
    ]
    return Plan(square_trial, conditions, {"quick": 1, "full": 12}[effort])
