"""The synthetic board in many sizes: large squares, and one smoothing for all."""

from chapters.ch03_planar_grids.s1_2_celect.trials import boards
from chapters.shared.synthetic_board import SyntheticBoard
from raxel.features.celect import CelectSettings
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SQUARES_ACROSS = (20, 15, 12, 10, 8, 6, 5)
SMOOTHING_PX = (None, 0.7, 1.0, 1.5)
LIMITS = ((10, 20.0), (10, 34.0), (15, 0.0), (20, 0.0), (25, 0.0))


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


def limit_trial(condition, rng):
    """The synthetic board, with one smoothing for all sizes of square."""
    board = SyntheticBoard(square_px=1000 / condition["squares_across"])
    smoothing = condition["smoothing_px"]
    fixed = {} if smoothing is None else {"smoothing_limits_px": (smoothing,) * 2}
    settings = CelectSettings(**fixed)
    return boards.clicked_score(board, condition["noise_sd"], rng, settings)


@experiment("ext_celect_limits", artefact="sec_3_1_2", shards={"full": 2})
def limits(effort):
    """One smoothing for all, against noise and against small squares."""
    pictures = LIMITS[1:4:2] if effort == "quick" else LIMITS
    rules = SMOOTHING_PX[:2] if effort == "quick" else SMOOTHING_PX
    conditions = [
        {"smoothing_px": rule, "squares_across": n, "noise_sd": noise}
        for rule in rules
        for n, noise in pictures
    ]
    return Plan(limit_trial, conditions, {"quick": 1, "full": 10}[effort])
