"""Section 4.2: estimators on one scene, planes, samples, and how claims are judged."""

import numpy as np
import pytest

from chapters.ch04_central_generic.s2_pose import claims, experiment, page
from chapters.ch04_central_generic.s2_pose.experiment import (
    SIZES,
    TILTS_DEG,
    all_estimates,
    errors_of,
    plane_trial,
    size_trial,
)
from raxel.geometry import pose, rotation_from_vector
from tests.bench_noises import EVERY_NOISE
from tests.judged_claims import readings, readings_of
from tests.made_results import flat, of_columns, of_seed

PRIMARY = {"domain": "px", "rays": "exact", "unit": "angle"}


def test_every_estimator_is_exact_without_noise():
    condition = PRIMARY | {"noise": 1e-4}
    found = page.noise_trial(condition, np.random.default_rng(0))
    assert list(found) == ["three_points", "standard", "cgsp", "cgsp_ransac", "angular"]
    for errors in found.values():
        assert errors["rotation_deg"] < 1e-3
        assert errors["translation_mm"] < 1e-2


def test_rejected_pose_reports_its_code():
    rays = np.tile([[0.0, 0.0, 1.0]], (10, 1))
    found = all_estimates(rays, np.ones((10, 2)), np.random.default_rng(0), 1.0)
    assert set(found.values()) == {"bad-input", "no-pose"}


def test_plane_claims_hold_and_fail():
    exact = flat(plane_trial({"noise": 0.0}, np.random.default_rng(1)))
    judge = claims.judge_free
    assert readings(judge, "exp_c4_plane_free", exact)[0].verdict == "reproduced"
    worse = exact | {"own.30.translation_mm": 1e-6}
    assert readings(judge, "exp_c4_plane_free", worse)[0].verdict == "differs"
    rng = np.random.default_rng(2)
    values = {}
    for kind in ("common", "own"):
        for tilt in TILTS_DEG:
            for measure in ("rotation_deg", "translation_mm"):
                noise = np.exp(0.1 * rng.standard_normal(60))
                values[f"{kind}.{tilt}.{measure}"] = (1 + tilt / 60) * noise
    judge = claims.judge_orientation
    for best, verdict in ((0, "reproduced"), (60, "differs")):
        if best:
            for kind in ("common", "own"):
                for measure in ("rotation_deg", "translation_mm"):
                    a, b = f"{kind}.0.{measure}", f"{kind}.60.{measure}"
                    values[a], values[b] = values[b], values[a]
        found = readings(judge, "exp_c4_plane_orientation", values)
        assert [r.verdict for r in found] == [verdict] * 2


def test_sampling_claims_hold_and_fail():
    counts = {f"{kind}.without": [9] * 100 for kind in experiment.APART}
    judge = claims.judge_no_solution
    name = "exp_c4_3pt_no_solution"
    assert {r.verdict for r in readings(judge, name, counts)} == {"reproduced"}
    few = {name: [1] * 100 for name in counts}
    assert {r.verdict for r in readings(judge, name, few)} == {"differs"}
    four = {"finite.of_4_24": [100, 99], "finite.facing": [100, 100]}
    found = readings(claims.judge_linear_always, "exp_c4_linear_always", four)
    assert [r.verdict for r in found] == ["differs", "reproduced"]
    rng = np.random.default_rng(4)
    for factor, verdict in ((10.0, "reproduced"), (1.5, "differs")):
        errors = {
            f"{kind}.{measure}": size * np.exp(0.1 * rng.standard_normal(80))
            for kind, size in (("close together", factor), ("far apart", 1.0))
            for measure in ("rotation_deg", "translation_mm")
        }
        found = readings(claims.judge_sensitive, "exp_c4_3pt_sensitive", errors)
        assert found[0].verdict == verdict


def test_linear_pose_solves_one_system_and_refinement_several():
    found = [
        flat(experiment.solves_trial({"points": count}, np.random.default_rng(count)))
        for count in (40, 900)
    ]
    assert [one["linear.systems"] for one in found] == [1, 1]
    assert found[0]["linear.calls"] == found[1]["linear.calls"]
    assert min(one["refined.systems"] for one in found) > 1
    assert min(one["three_points.polynomials"] for one in found) >= 64


@pytest.mark.parametrize(
    ("change", "verdicts"),
    [
        ({}, ["reproduced", "reproduced"]),
        ({"linear.systems": [1] * 59 + [2]}, ["differs", "differs"]),
        ({"linear.calls": [7] * 59 + [8]}, ["differs", "differs"]),
        ({"refined.systems": [2] * 60}, ["differs", "reproduced"]),
        ({"three_points.polynomials": [1] * 60}, ["reproduced", "differs"]),
    ],
)
def test_fast_claim_requires_one_system_without_iteration(change, verdicts):
    values = {
        "linear.systems": [1] * 60,
        "linear.calls": [7] * 60,
        "refined.systems": [9] * 60,
        "three_points.polynomials": [64] * 60,
    }
    made = values | change
    found = readings(claims.judge_fast, "exp_c4_pose_linear_fast", made)
    assert [r.verdict for r in found] == verdicts


def test_counted_solvers_are_restored():
    before = np.linalg.solve
    with experiment.counted() as solved:
        np.linalg.solve(np.eye(2), np.ones(2))
        np.linalg.svd(np.ones((5, 3, 2)))
    assert solved == [("solve", (2, 2)), ("svd", (5, 3, 2))]
    assert np.linalg.solve is before


def scenes(sizes):
    """Trials of Table 4.1 whose errors have these medians, by estimator."""
    rng = np.random.default_rng(5)
    values = {
        f"errors.{noise}.0.3 %.{name}.{measure}": errors
        for name, size in sizes.items()
        for measure in ("rotation_deg", "translation_mm")
        for errors in [size * np.exp(0.1 * rng.standard_normal(60))]
        for noise in EVERY_NOISE
    }
    return {"table_4_1_redrawn": of_columns(({}, values))}


@pytest.mark.parametrize(
    ("sizes", "order", "needed", "well"),
    [
        ((1.5, 1.5, 4.0, 1.0), "reproduced", "reproduced", "reproduced"),
        ((1.0, 3.0, 1.2, 1.3), "differs", "differs", "reproduced"),
        ((3.0, 3.0, 4.0, 1.0), "reproduced", "reproduced", "differs"),
    ],
)
def test_table_4_1_claims_hold_and_fail(sizes, order, needed, well):
    names = ("standard", "three_points", "cgsp", "cgsp_ransac")
    results = scenes(dict(zip(names, sizes, strict=True)))
    for judge, verdict in (
        (claims.judge_order, order),
        (claims.judge_ransac_needed, needed),
        (claims.judge_fairly_well, well),
    ):
        assert readings_of(judge, results)[0].verdict == verdict


def test_smaller_distant_grid_is_harder():
    found = of_seed(size_trial)
    judge = claims.judge_real_larger
    rng = np.random.default_rng(6)
    values = {
        f"{size}.{name}.{measure}": (1 + 3 * k) * np.exp(0.1 * rng.normal(size=60))
        for k, size in enumerate(SIZES)
        for name in ("standard", "cgsp_ransac")
        for measure in ("rotation_deg", "translation_mm")
    }
    assert readings(judge, "exp_c4_real_larger", values)[0].verdict == "reproduced"
    assert found.column("usual.cgsp_ransac.rotation_deg")[0] < 0.2


@pytest.mark.parametrize("shift", [(3.0, 0, 0), (0, 3.0, 0), (0, 0, 3.0), (2, 1, -2)])
def test_translation_error_is_its_length_in_any_direction(shift):
    true = pose(rotation_from_vector([0.1, 0.2, -0.3]), [10.0, 20.0, 500.0])
    found = pose(true[:3, :3], true[:3, 3] + shift)
    errors = errors_of(found, true)
    assert errors["translation_mm"] == pytest.approx(3)
    assert errors["rotation_deg"] == pytest.approx(0, abs=1e-6)
