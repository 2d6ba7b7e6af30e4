"""Section 3.1.3: the tests of its claims, on residuals whose answer is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch03_planar_grids.s1_3_localisation import report
from chapters.ch03_planar_grids.s1_3_localisation.experiment import neighbour_distances
from chapters.ch03_planar_grids.s3_1_robustness.claims import judge_localise_converges
from chapters.shared.grids.detectors import (
    START_ERRORS_PX,
    farthest_start,
    worst_within,
)
from chapters.shared.grids.synthetic_board import SyntheticBoard
from repro.run.outcomes import Plan
from tests.judged_claims import readings_of
from tests.made_results import written

WINDOWS = [5, 15, 25, 35]
BLURS = [1.0, 2.0, 3.0]
SQUARES = (50, 100, 150, 200)


def swept(name, scale):
    """Residuals |N(0, scale(distance))| of 200 corners an image, 12 to 168 px apart.

    scale: distances (N,) -> (N, windows[, blurs]).
    """

    def trial(condition, rng):
        distance = rng.uniform(12, 168, 200)
        size = scale(distance)
        error = np.abs(rng.normal(size=size.shape)) * size
        return {"error": error, "distance": distance}

    extra = {"blurs": BLURS} if scale(np.ones(1)).ndim == 3 else {}
    conditions = [{"square_px": s, "windows": WINDOWS} | extra for s in SQUARES]
    return written(Plan(trial, conditions, 4), name)


def alike(distance):
    return np.tile(np.array([0.1, 1.0, 2.0, 3.0]), (len(distance), 1))


def growing(distance):
    """The best window grows with the distance, and a wrong one is ten times worse."""
    best = np.digitize(distance, [50, 90, 130])
    return np.where(np.arange(4) == best[:, None], 0.1, 1.0)


def with_blur(factor):
    def scale(distance):
        return alike(distance)[:, :, None] * np.array(factor)

    return scale


def verdict(judge, **results):
    reading = judge({f"fig_3_5_{name}": r for name, r in results.items()})
    return reading.verdict


@pytest.mark.parametrize(
    ("scale", "relation", "small"),
    [(alike, "reproduced", "reproduced"), (growing, "differs", "differs")],
)
def test_relation_with_distance_is_detected(scale, relation, small):
    derivative = swept("fig_3_5_derivative", scale)
    saddle = swept("fig_3_5_saddle", with_blur([1.0, 0.1, 1.0]))
    both = {"derivative": derivative, "saddle": saddle}
    assert verdict(report.judge_no_relation, **both) == relation
    assert verdict(report.judge_derivative_small, derivative=derivative) == small


def test_repeated_images_of_corners_do_not_narrow_the_interval():
    rng = np.random.default_rng(5)
    corners, images = 60, 8
    distance, best = rng.random(corners), rng.random(corners)
    alone = SimpleNamespace(distance=distance, images_of=[np.arange(corners)[:, None]])
    copied = SimpleNamespace(
        distance=np.tile(distance, images),
        images_of=[np.arange(corners * images).reshape(images, corners).T],
    )
    one = report.rank_tie(alone, best)
    many = report.rank_tie(copied, np.tile(best, images))
    assert many.value == pytest.approx(one.value)
    assert many.high - many.low == pytest.approx(one.high - one.low, rel=1e-6)


def test_single_blur_claim_depends_on_its_cost():
    for costs, expected in (
        ([1.0, 0.3, 4.0], ("reproduced", "reproduced")),
        ([1.0, 3.0, 4.0], ("differs", "differs")),
    ):
        saddle = swept("fig_3_5_saddle", with_blur(costs))
        readings = readings_of(report.judge_saddle_blur, {"fig_3_5_saddle": saddle})
        assert tuple(r.verdict for r in readings) == expected
        assert verdict(report.judge_saddle_window, saddle=saddle) == "reproduced"


def test_best_blur_is_searched_inside_the_sweep():
    flat = np.array([[1.0, 0.2, 0.9, 0.8, 0.1]])
    assert report.best_blur(flat, 5, [2]) == 2
    assert report.best_blur(flat, 5, [1, 2, 3]) == 1
    # A window of its own in every bin: the blur's best counts.
    two = np.array([[1.0, 0.2, 0.9], [0.1, 0.5, 0.15]])
    assert report.best_blur(two, 3, [1, 2]) == 2


def test_entropy_is_compared_at_equal_counts():
    def wide_near(distance):
        near = (distance < 30)[:, None]
        return np.where(near, 1.0, alike(distance))

    derivative = swept("fig_3_5_derivative", wide_near)
    assert verdict(report.judge_derivative_dense, derivative=derivative) == "reproduced"
    derivative = swept("fig_3_5_derivative", alike)
    assert verdict(report.judge_derivative_dense, derivative=derivative) == "undecided"


def test_settings_are_scored_on_held_out_corners():
    one = report.Swept(swept("fig_3_5_saddle", with_blur([1.0, 1.0, 1.0])))
    lucky = one.error.reshape(len(one.error), -1).min(axis=1)
    scored = one.scored(report.per_bin(np.mean))
    assert scored.mean() > 1.5 * lucky.mean()
    assert one.mid_range_blurs("middle of the sweep") == [1]
    assert np.isin(one.best_window, WINDOWS).all()
    assert np.isin(one.best_blur, BLURS).all()


def test_convergence_basin_ends_at_the_first_lost_corner():
    def trial(condition, rng):
        start = condition["start_px"]
        return {
            "full window.max_px": 0.1 if start <= 3 else start,
            "full window.left_share": float(start > 3),
            "half window.max_px": 0.2,
            "half window.left_share": 0.0,
        }

    conditions = [{"start_px": start} for start in START_ERRORS_PX["full"]]
    plan = Plan(trial, conditions, 3, {"half_windows": {"full window": 4}})
    result = written(plan, "fig_3_11_localised")
    assert farthest_start(result, "full window") == 3
    assert farthest_start(result, "half window") == 12
    assert worst_within(result, "full window") == 8
    readings = readings_of(judge_localise_converges, {"fig_3_11_localised": result})
    assert {r.reading["localiser_window"]: r.verdict for r in readings} == {
        "full window": "differs",
        "half window": "reproduced",
    }


def test_distances_are_those_to_neighbours():
    board = SyntheticBoard(square_px=200.0, fov_deg=1.0)
    # A narrow field bends nothing: all neighbours are one square away.
    assert np.allclose(neighbour_distances(board), 200, rtol=1e-3)
    bent = neighbour_distances(SyntheticBoard(square_px=100.0)).reshape(9, 9)
    assert bent[4, 4] == bent.max()
    assert np.allclose(bent, bent.T)
