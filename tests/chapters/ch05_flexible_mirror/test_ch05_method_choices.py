"""Section 5.2: static grids and sizes of steps, as they are judged."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s2_method import claims, experiment
from chapters.ch05_flexible_mirror.s2_method.report import LOOPS, STATIC
from chapters.shared.mirror.levels import BENCHES
from chapters.shared.mirror.rigs import mirror_rig
from chapters.shared.mirror.runs import true_points
from tests.judged_claims import readings_of
from tests.made_results import as_planned, of_columns

SEEDS, STEPS = 60, ("step4", "step5", "step6")


def scattered(value, seed, relative=0.02):
    return value * (1 + relative * np.random.default_rng(seed).standard_normal(SEEDS))


def loops(changed):
    """Runs of Table 5.5 in which three steps are better than one, but for changes."""
    values = {}
    for bench in BENCHES:
        for place in STEPS:
            values[f"{bench}.{place}.common"] = scattered(120.0, 1)
        values[f"{bench}.single.common"] = scattered(90.0, 2)
        values[f"{bench}.step6.back_mm"] = scattered(0.5, 3)
        values[f"{bench}.single.back_mm"] = scattered(0.8, 4)
    return {LOOPS: of_columns(({"geometry": "A"}, values | changed))}


LOST = np.where(np.arange(SEEDS) < 40, np.nan, scattered(120.0, 1))


@pytest.mark.parametrize(
    ("changed", "verdict"),
    [
        ({}, "reproduced"),
        ({"laboratory.single.back_mm": scattered(0.4, 4)}, "differs"),
        ({"laboratory.single.common": scattered(130.0, 2)}, "differs"),
        # No difference on the whole.
        ({"laboratory.single.back_mm": scattered(0.5, 9, 0.2)}, "undecided"),
        # The thesis-matched level is reported and decides nothing.
        ({"bench.single.back_mm": scattered(0.1, 4)}, "reproduced"),
        # Rejected steps have no corners; a loop that did not end is the worst.
        ({f"laboratory.{step}.common": LOST for step in STEPS[:2]}, "differs"),
        ({"laboratory.step6.back_mm": np.full(SEEDS, np.nan)}, "differs"),
    ],
)
def test_small_steps_have_to_be_better_in_both_measures(changed, verdict):
    (found,) = readings_of(claims.judge_step_sizes, loops(changed))
    assert found.verdict == verdict


def surfaces(grid_mm, pixel_mm):
    both = np.random.default_rng(1).uniform(0.5, 1.5, 50)
    values = {"grid.refined_mm": 0.02, "pixel.refined_mm": 0.02}
    values |= {"grid.linear_mm": grid_mm * both, "pixel.linear_mm": pixel_mm * both}
    return {STATIC: as_planned(STATIC, values)}


@pytest.mark.parametrize(
    ("grid_mm", "verdict"),
    [(0.03, "reproduced"), (0.0201, "reproduced"), (0.019, "differs")],
)
def test_static_grid_claim_needs_the_larger_error(grid_mm, verdict):
    (found,) = readings_of(claims.judge_static_grids, surfaces(grid_mm, 0.02))
    assert found.verdict == verdict
    assert found.regenerated == pytest.approx(grid_mm / 0.02)


def test_corner_interpolation_of_a_flat_mirror_is_exact():
    rig = mirror_rig("A")
    camera = rig.camera(0.0)
    (T, _) = rig.monitor_poses()
    pixels = experiment.lattice(camera, 128)
    exact = true_points(rig, camera, pixels, T)
    board = experiment.chessboard(camera, T, exact)
    read = experiment.between_corners(board, pixels)
    known = np.isfinite(read[:, 0])
    assert known.mean() > 0.7
    # What is left is the lens's distortion within a square.
    np.testing.assert_allclose(read[known], exact[known], atol=0.02)


def test_exact_points_recover_the_surface():
    found = experiment.static_trial(
        {"geometry": "A", "aberration_um": 0.0}, np.random.default_rng(3)
    )
    assert max(found["pixel"][f"{n}_mm"] for n in ("linear", "refined")) < 0.02
