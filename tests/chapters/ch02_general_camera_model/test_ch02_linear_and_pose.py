"""Section 2.4: linear systems, pose from rays, Algorithm 1."""

from dataclasses import replace

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s4_1_linear_and_pose import (
    exercises,
    experiment,
    page,
    report,
)
from raxel.calibration import linear_as_printed
from tests.judged_claims import verdict
from tests.made_results import flat, of_seed, written

# The linear stage


@pytest.mark.parametrize("seed", range(4))
def test_true_unknowns_solve_both_systems(seed):
    points, centre, poses = experiment.scene_points(np.random.default_rng(seed))
    coefficients = experiment.scaled_coefficients(points)
    A, x = experiment.matrix_a(coefficients)
    scales = [coefficients[2 * k][3] / poses[k + 1][2, 0] for k in range(2)]
    u = list(centre[:2])
    for T, scale in zip(poses[1:], scales, strict=True):
        factor = scale * centre[2]
        u += [factor * (T[k, 3] - centre[k]) for k in range(2)]
        u += [factor * T[i, j] for i in range(2) for j in range(2)]
    u = np.array(u)
    np.testing.assert_allclose(A @ u, x, atol=1e-9 * np.abs(A * u).max())
    a, basis = experiment.solution_space(A, x)
    D, y = experiment.matrix_d(a, basis, coefficients)
    l1, l2 = np.linalg.lstsq(basis.T, u - a, rcond=None)[0]
    squares = [(scale * centre[2]) ** 2 for scale in scales]
    v = np.array([l1, l2, l1 * l2, l1**2, l2**2, centre[2] ** 2, *squares])
    np.testing.assert_allclose(D @ v, y, atol=1e-8 * np.abs(D * v).max())


def test_chapter_and_library_solve_the_same_systems():
    points, _, _ = experiment.scene_points(np.random.default_rng(5))
    u, coefficients = experiment.solve_u(points)
    square = experiment.depth_squared(u, coefficients, printed=False)
    centre = linear_as_printed(*points, tz="corrected").centre
    np.testing.assert_allclose([*u[:2], -np.sqrt(square)], centre, rtol=1e-7)


@pytest.mark.parametrize(
    ("judge", "trial", "wrong"),
    [
        (report.judge_rank_a, experiment.rank_a_trial, [{"rank": [12, 11]}]),
        (
            report.judge_rank_d,
            experiment.rank_d_trial,
            [{"orthonormal.rank": 6}, {"orthonormal.null_entry": 1e-3}],
        ),
        (
            report.judge_linear_exact,
            experiment.exact_trial,
            [
                {"corrected.centre_mm": 1e-3},
                {"corrected.rotation_rad": np.nan},
                {"printed_depth_mm": 1e-9},
            ],
        ),
        (
            report.judge_generic_no_motion,
            experiment.no_motion_trial,
            [{"pose_mm": 1e-3}, {"two_pose_deg.wrong": 0.0}],
        ),
    ],
)
def test_linear_stage_claim_holds_in_a_scene_and_fails(judge, trial, wrong):
    found = flat(trial({}, np.random.default_rng(6)))
    (name,) = judge.repro_marks[0]["needs"]
    assert verdict(judge, name, found) == "reproduced"
    for change in wrong:
        assert verdict(judge, name, found | change) == "differs"


def test_corrected_depth_is_exact():
    found = flat(experiment.exact_trial({}, np.random.default_rng(7)))
    assert found["corrected_depth_mm"] < 1e-6


def test_rank_and_null_entries_of_known_matrices():
    matrix = np.eye(6, 8)
    matrix[5] = 0.0
    matrix[:, 2] = 0.0
    assert experiment.rank_of(experiment.singular_values(matrix)) == 4
    matrix = np.zeros((6, 8))
    matrix[[0, 1, 2, 3, 4], [0, 1, 5, 6, 7]] = 1.0
    matrix[2, [3, 4]] = 2.0
    assert experiment.null_entries(matrix) < 1e-12
    matrix[0, 3] = 1.0
    assert experiment.null_entries(matrix) > 0.1


# Three points


@pytest.mark.parametrize("anchors", ["common", "distinct"])
def test_three_point_solutions_satisfy_equations_and_include_truth(anchors):
    rng = np.random.default_rng(9)
    for _ in range(10):
        starts, directions, points, depths = experiment.draw_triplet(rng, anchors)
        found = experiment.real_solutions(starts, directions, points)
        assert 2 <= len(found) <= 8
        assert len(found) % 2 == 0
        corners = starts + found[..., None] * directions
        for i, j in experiment.PAIRS:
            gaps = np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
            wanted = np.linalg.norm(points[i] - points[j])
            np.testing.assert_allclose(gaps, wanted, rtol=1e-8)
        assert np.abs(found - depths).max(axis=1).min() < 1e-4
        paired = experiment.paired_share(found)
        assert paired == (1.0 if anchors == "common" else 0.0)


def test_three_point_solutions_follow_frame_and_scale():
    rng = np.random.default_rng(10)
    starts, directions, points, _ = experiment.draw_triplet(rng, "distinct")
    found = experiment.real_solutions(starts, directions, points)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moved = experiment.real_solutions(
        10 * starts @ R.T + 7.0, directions @ R.T, 10 * points
    )
    assert experiment.agreement(moved, 10 * found)


def test_eight_solutions_claim_holds_and_fails():
    conditions = [{"anchors": name} for name in ("common", "distinct")]
    found = of_seed(experiment.triplet_trial, conditions)
    judge = report.judge_pose_eight
    assert judge({"exp_c2_pose_eight": found}).verdict == "reproduced"
    good = {"solutions": [4, 8], "paired_share": [1.0, 1.0]}
    for change in ({"solutions": [4, 10]}, {"paired_share": [1.0, 0.75]}):
        values = good | change
        assert verdict(judge, "exp_c2_pose_eight", values) == "differs"


def test_exercise_answers_of_2_4_are_correct():
    assert exercises.freedom_of_a() == 3
    solutions = exercises.solutions_of_triangle()
    assert len(solutions) == 8
    depth = exercises.DEPTH_MM
    directions, points = exercises.triangle()
    corners = depth * directions
    side = np.linalg.norm(corners[0] - corners[1])
    np.testing.assert_allclose(side, exercises.SIDE_MM)
    np.testing.assert_allclose(np.linalg.norm(points[0] - points[1]), side)
    assert np.abs(solutions).min() < depth


# Algorithm 1


def test_algorithm_1_reproduces_pinhole_rays():
    found = flat(page.run_trial({"camera": "pinhole"}, np.random.default_rng(11)))
    assert found["table.largest_deg"] < 1e-6
    assert found["linear.pose_mm"] < 1e-6
    assert found["others.boards"] == experiment.BOARDS - 3
    assert found["table.matrices"] == round(
        found["table.share"] * experiment.SIZE_PX**2
    )


def test_numbers_of_2_4_are_read_from_trials():
    made = {
        name: written(replace(plan, trials=3), name)
        for name, plan in {
            "exp_c2_rank_A": experiment.rank_of_a("quick"),
            "exp_c2_rank_D": experiment.rank_of_d("quick"),
        }.items()
    }
    values = report.values_of_ranks(made)
    assert (values["s2_4_1_rankA"].value, values["s2_4_1_rankD"].value) == (12, 5)
