"""Sections 2.2.2, 2.3 and 2.4: what the experiments compute, and how claims decide."""

from dataclasses import replace

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s2_camera_models import claims as s2_claims
from chapters.ch02_general_camera_model.s2_camera_models.trials import planes
from chapters.ch02_general_camera_model.s3_general_camera import claims as s3_claims
from chapters.ch02_general_camera_model.s3_general_camera import (
    exercises as s3_exercises,
)
from chapters.ch02_general_camera_model.s3_general_camera import page as s3_page
from chapters.ch02_general_camera_model.s3_general_camera.figures import (
    grids as s3_grid_figures,
)
from chapters.ch02_general_camera_model.s3_general_camera.figures import (
    ray_tables as s3_table_figures,
)
from chapters.ch02_general_camera_model.s3_general_camera.trials import (
    drawn_rays,
    known_motion,
    lines,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose import (
    claims as s4_1_claims,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose import (
    exercises as s4_1_exercises,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose import page as s4_page
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials import (
    quadrics as three_quadrics,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials import (
    stage as linear_trials,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials import (
    systems as linear_systems,
)
from chapters.shared import algorithm_1, general_cameras
from raxel.calibration import linear_as_printed
from raxel.cameras.base import pixel_grid
from raxel.geometry import pluecker_matrix_of_rays
from repro.run.experiment import run_trials
from repro.run.results import Result, gather


class Trials:
    """Stands for a Result: values by name and condition; arrays by name."""

    trials_per_condition = 1

    def __init__(self, values):
        self.values = values

    def column(self, name, **condition):
        found = self.values(name, condition) if callable(self.values) else None
        found = self.values[name] if found is None else found
        return np.atleast_1d(np.asarray(found, float))

    def arrays(self, name, **condition):
        found = self.values(name, condition)
        return [] if found is None else [found]


def ran(trial, conditions, seed=0):
    """A Trials of one real trial per condition, values nested by points."""
    made = [(c, flat(trial(c, np.random.default_rng(seed)))) for c in conditions]

    def values(name, condition):
        fits = [v for c, v in made if condition.items() <= c.items()]
        assert len(fits) == 1
        return fits[0].get(name)

    return Trials(values)


def flat(values, prefix=""):
    out = {}
    for key, value in values.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{key}.")
        else:
            out[prefix + key] = value
    return out


def verdict(judge, experiment, values):
    (reading,) = judge({experiment: Trials(values)})
    return reading.verdict


# Cameras and drawings


@pytest.mark.parametrize("name", general_cameras.CAMERAS)
def test_a_ray_of_each_camera_comes_back_to_its_pixel(name):
    camera = general_cameras.CAMERAS[name](24, 18)
    pixels = pixel_grid(24, 18)
    rays = camera.rays(pixels)
    assert rays.valid.all()
    ahead = np.sign(rays.directions[:, 2])
    assert np.all(ahead == known_motion.AHEAD[name])
    back = camera.project(rays.origins + 500 * rays.directions)
    np.testing.assert_allclose(back.pixels, pixels, atol=1e-9)


def test_mirrors_meet_at_their_edges_and_rays_jump_there():
    camera = general_cameras.faceted(24, 18)
    corners = [
        np.column_stack([outline, np.zeros(4)]) @ T[:3, :3].T + T[:3, 3]
        for T, outline in zip(camera.T_viewer_facets, camera.outlines, strict=True)
    ]
    np.testing.assert_allclose(corners[0][3], corners[1][3], atol=1e-9)
    np.testing.assert_allclose(corners[1][1], corners[2][1], atol=1e-9)
    assert known_motion.largest_jump(camera) > 20
    assert known_motion.largest_jump(general_cameras.fisheye(24, 18)) < 10


def test_any_camera_is_judged_on_the_faceted_one():
    conditions = [{"camera": name} for name in ("pinhole", "faceted")]
    found = ran(known_motion.known_motion_trial, conditions)
    (reading,) = s3_claims.judge_nonparametric({"exp_c2_nonparam_any": found})
    assert reading.verdict == "reproduced"
    good = {"angle_rad": 1e-12, "gap_mm": 1e-12, "share": 1.0, "jump_deg": 20.0}
    for change in ({"angle_rad": 1e-6}, {"gap_mm": 1e-3}, {"share": 0.9}):
        values = good | change
        assert (
            verdict(s3_claims.judge_nonparametric, "exp_c2_nonparam_any", values)
            == "differs"
        )


def test_figure_2_1_draws_the_table_and_notices_a_moved_ray():
    conditions = [{"camera": name} for name in ("fisheye", "faceted")]
    results = {"fig_2_1_tables": ran(drawn_rays.table_trial, conditions)}
    drawing = s3_table_figures.fig_2_1(results)
    assert drawing.check.holds
    assert drawing.scene is not None
    assert len(set(drawing.data["camera"])) == 2
    table = s3_table_figures.Table(results["fig_2_1_tables"], "faceted")
    rays = pluecker_matrix_of_rays(table.origins, table.directions)
    np.testing.assert_allclose(table.matrices, rays, atol=1e-12)
    assert np.ptp(table.origins, axis=0).min() > 10
    table.ends = table.ends + [0.0, 1e-6, 0.0]
    assert table.gap() > s3_table_figures.TOLERANCE_MM


def test_figure_2_2_has_its_points_on_rays_and_grids():
    conditions = [{"method": name} for name in ("general", "generic")]
    results = {"fig_2_2_grids": ran(s3_page.grids_trial, conditions)}
    drawing = s3_grid_figures.fig_2_2(results)
    assert drawing.check.holds
    found = results["fig_2_2_grids"]
    for method in ("general", "generic"):
        assert found.column("pose_error_mm", method=method).max() < 1e-6
        assert found.column("ray_error", method=method).max() < 1e-9
    grids = s3_grid_figures.Grids(found, "generic")
    grids.meetings = grids.meetings + [0.0, 0.0, 1e-6]
    assert grids.gap() > s3_grid_figures.TOLERANCE_MM
    found.column = lambda name, **condition: np.array([1e-3])
    assert not s3_grid_figures.fig_2_2(results).check.holds


def test_a_matrix_is_printed_without_negative_zeros():
    text = s3_table_figures.matrix_text(np.array([[-1e-9, 2.0], [-3.456, 0.0]]))
    assert text == " 0.00 2.00\n-3.46 0.00"


# Claims of 2.2.2 and 2.3


@pytest.mark.parametrize(("fov", "feasible"), [(90, True), (179, True), (180, False)])
def test_a_plane_lies_before_all_rays_below_180_degrees_only(fov, feasible):
    found = planes.plane_trial({"fov_deg": fov}, np.random.default_rng(0))
    assert found["feasible"] is feasible
    assert found["rim"] == planes.RIM


def fov_verdict(law):
    return verdict(
        s2_claims.judge_fov180, "exp_c2_fov180", lambda name, c: law(c["fov_deg"])
    )


def test_fov180_is_judged_both_ways():
    assert fov_verdict(lambda fov: [fov < 180] * 2) == "reproduced"
    assert fov_verdict(lambda fov: [fov < 200] * 2) == "differs"
    assert fov_verdict(lambda fov: [fov < 180, fov < 100]) == "differs"
    assert fov_verdict(lambda fov: [np.nan]) == "undecided"


def test_a_refuted_fov180_shows_its_shares():
    values = Trials(lambda name, c: [True, c["fov_deg"] < 180])
    (reading,) = s2_claims.judge_fov180({"exp_c2_fov180": values})
    assert "0.50 at 180 deg" in reading.reason
    assert "no solution" not in reading.reason


def test_pluecker_claims_hold_and_can_fail():
    rng = np.random.default_rng(1)
    pairs = {"exp_c2_pluecker_invariant": lines.two_pairs_trial({}, rng)}
    through = {"exp_c2_pluecker_origin": lines.origin_trial({}, rng)}
    for judge, values in (
        (s3_claims.judge_pluecker_invariant, pairs),
        (s3_claims.judge_pluecker_origin, through),
    ):
        (experiment,) = values
        assert verdict(judge, experiment, values[experiment]) == "reproduced"
    bad = {"difference": 1e-9, "asymmetry": 0.0}
    judge = s3_claims.judge_pluecker_invariant
    assert verdict(judge, "exp_c2_pluecker_invariant", bad) == "differs"
    judge = s3_claims.judge_pluecker_origin
    for ratios in ((1e-9, 0.5), (1e-16, 0.0)):
        bad = {
            "through_origin": ratios[0],
            "beside_origin": ratios[1],
            "least_distance_m": 0.1,
        }
        assert verdict(judge, "exp_c2_pluecker_origin", bad) == "differs"


def two_pose(law):
    def values(name, condition):
        level = float(name.removeprefix("ray_deg."))
        return law(level) * np.linspace(0.8, 1.2, 30)

    return verdict(s3_claims.judge_two_pose_needs_motion, "fig_2_2_error", values)


def test_two_pose_error_is_judged_by_its_straight_line():
    assert two_pose(lambda level: 0.1 * level) == "reproduced"
    assert two_pose(lambda level: 0.1 * level**4) == "differs"
    assert two_pose(lambda level: -0.1 * level) == "differs"


def test_a_shift_turns_rays_as_far_as_its_triangle_says():
    rng = np.random.default_rng(2)
    found = flat(s3_page.wrong_motion_trial({"kind": "translation"}, rng))
    assert found["ray_deg.0"] < 1e-9
    most = s3_exercises.angle_per_shift(1.0, found["step_mm"])
    assert 0.2 * most < found["ray_deg.1"] < 1.2 * most


def test_exercises_of_2_3():
    direction = s3_exercises.ray_of_pixel()
    np.testing.assert_allclose(direction / direction[2], [0.15, -0.1, 1.0])
    vector = s3_exercises.vector_through()
    a, b = np.array(s3_exercises.A_MM), np.array(s3_exercises.B_MM)
    np.testing.assert_allclose(vector / 2, [*(b - a), *-np.cross(a, b)])
    assert s3_exercises.bytes_of_table(3008, 2000) == 770_048_000


# The linear stage


@pytest.mark.parametrize("seed", range(4))
def test_true_unknowns_solve_both_systems(seed):
    points, centre, poses = linear_systems.scene_points(np.random.default_rng(seed))
    coefficients = linear_systems.scaled_coefficients(points)
    A, x = linear_systems.matrix_a(coefficients)
    scales = [coefficients[2 * k][3] / poses[k + 1][2, 0] for k in range(2)]
    u = list(centre[:2])
    for T, scale in zip(poses[1:], scales, strict=True):
        factor = scale * centre[2]
        u += [factor * (T[k, 3] - centre[k]) for k in range(2)]
        u += [factor * T[i, j] for i in range(2) for j in range(2)]
    u = np.array(u)
    np.testing.assert_allclose(A @ u, x, atol=1e-9 * np.abs(A * u).max())
    a, basis = linear_systems.solution_space(A, x)
    D, y = linear_systems.matrix_d(a, basis, coefficients)
    l1, l2 = np.linalg.lstsq(basis.T, u - a, rcond=None)[0]
    squares = [(scale * centre[2]) ** 2 for scale in scales]
    v = np.array([l1, l2, l1 * l2, l1**2, l2**2, centre[2] ** 2, *squares])
    np.testing.assert_allclose(D @ v, y, atol=1e-8 * np.abs(D * v).max())


def test_chapter_and_library_solve_the_same_systems():
    points, _, _ = linear_systems.scene_points(np.random.default_rng(5))
    u, coefficients = linear_systems.solve_u(points)
    square = linear_systems.depth_squared(u, coefficients, printed=False)
    centre = linear_as_printed(*points, tz="corrected").centre
    np.testing.assert_allclose([*u[:2], -np.sqrt(square)], centre, rtol=1e-7)


def test_rank_claims_hold_in_a_scene_and_can_fail():
    rng = np.random.default_rng(6)
    found = flat(linear_trials.rank_a_trial({}, rng))
    judge = s4_1_claims.judge_rank_a
    assert verdict(judge, "exp_c2_rank_A", found) == "reproduced"
    assert verdict(judge, "exp_c2_rank_A", found | {"rank": [12, 11]}) == "differs"
    found = flat(linear_trials.rank_d_trial({}, rng))
    judge = s4_1_claims.judge_rank_d
    assert verdict(judge, "exp_c2_rank_D", found) == "reproduced"
    for change in ({"orthonormal.rank": 6}, {"orthonormal.null_entry": 1e-3}):
        assert verdict(judge, "exp_c2_rank_D", found | change) == "differs"


def test_rank_and_null_entries_of_a_known_matrix():
    matrix = np.eye(6, 8)
    matrix[5] = 0.0
    matrix[:, 2] = 0.0
    assert linear_systems.rank_of(linear_systems.singular_values(matrix)) == 4
    matrix = np.zeros((6, 8))
    matrix[[0, 1, 2, 3, 4], [0, 1, 5, 6, 7]] = 1.0
    matrix[2, [3, 4]] = 2.0
    assert linear_systems.null_entries(matrix) < 1e-12
    matrix[0, 3] = 1.0
    assert linear_systems.null_entries(matrix) > 0.1


def test_exactness_needs_right_formulas_and_a_wrong_printed_depth():
    found = flat(linear_trials.exact_trial({}, np.random.default_rng(7)))
    judge = s4_1_claims.judge_linear_exact
    assert found["corrected_depth_mm"] < 1e-6
    assert verdict(judge, "exp_c2_linear_exact", found) == "reproduced"
    for change in (
        {"corrected.centre_mm": 1e-3},
        {"corrected.rotation_rad": np.nan},
        {"printed_depth_mm": 1e-9},
    ):
        assert verdict(judge, "exp_c2_linear_exact", found | change) == "differs"


def test_no_motion_claim_holds_and_can_fail():
    found = flat(linear_trials.no_motion_trial({}, np.random.default_rng(8)))
    judge = s4_1_claims.judge_generic_no_motion
    assert verdict(judge, "exp_c2_generic_no_motion", found) == "reproduced"
    for change in ({"pose_mm": 1e-3}, {"two_pose_deg.wrong": 0.0}):
        values = found | change
        assert verdict(judge, "exp_c2_generic_no_motion", values) == "differs"


# Three points


@pytest.mark.parametrize("anchors", ["common", "distinct"])
def test_solutions_solve_the_equations_and_hold_the_truth(anchors):
    rng = np.random.default_rng(9)
    for _ in range(10):
        starts, directions, points, depths = three_quadrics.draw_triplet(rng, anchors)
        found = three_quadrics.real_solutions(starts, directions, points)
        assert 2 <= len(found) <= 8
        assert len(found) % 2 == 0
        corners = starts + found[..., None] * directions
        for i, j in three_quadrics.PAIRS:
            gaps = np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
            wanted = np.linalg.norm(points[i] - points[j])
            np.testing.assert_allclose(gaps, wanted, rtol=1e-8)
        assert np.abs(found - depths).max(axis=1).min() < 1e-4
        paired = three_quadrics.paired_share(found)
        assert paired == (1.0 if anchors == "common" else 0.0)


def test_solutions_move_with_the_frame_and_scale():
    rng = np.random.default_rng(10)
    starts, directions, points, _ = three_quadrics.draw_triplet(rng, "distinct")
    found = three_quadrics.real_solutions(starts, directions, points)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moved = three_quadrics.real_solutions(
        10 * starts @ R.T + 7.0, directions @ R.T, 10 * points
    )
    assert three_quadrics.agreement(moved, 10 * found)


def test_eight_solutions_are_judged_both_ways():
    conditions = [{"anchors": name} for name in ("common", "distinct")]
    found = ran(three_quadrics.triplet_trial, conditions)
    judge = s4_1_claims.judge_pose_eight
    assert judge({"exp_c2_pose_eight": found})[0].verdict == "reproduced"
    good = {"solutions": [4, 8], "paired_share": [1.0, 1.0]}
    for change in ({"solutions": [4, 10]}, {"paired_share": [1.0, 0.75]}):
        values = good | change
        assert verdict(judge, "exp_c2_pose_eight", values) == "differs"


def test_exercises_of_2_4():
    assert s4_1_exercises.freedom_of_a() == 2
    assert s4_1_exercises.solutions_of_triangle() == 8
    depth = s4_1_exercises.depth_of_triangle()
    directions, points = s4_1_exercises.triangle()
    corners = depth * directions
    side = np.linalg.norm(corners[0] - corners[1])
    np.testing.assert_allclose(side, s4_1_exercises.SIDE_MM)
    np.testing.assert_allclose(np.linalg.norm(points[0] - points[1]), side)
    assert s4_1_exercises.nearer_depth() < depth


# Algorithm 1


def test_algorithm_1_reproduces_the_rays_of_a_pinhole():
    found = flat(s4_page.run_trial({"camera": "pinhole"}, np.random.default_rng(11)))
    assert found["table.largest_deg"] < 1e-6
    assert found["linear.pose_mm"] < 1e-6
    assert found["others.boards"] == algorithm_1.BOARDS - 3
    assert found["table.matrices"] == round(
        found["table.share"] * algorithm_1.SIZE_PX**2
    )


def result_of(tmp_path, name, plan):
    """The result of a small run of an experiment."""
    pairs = [(c, t) for c in range(len(plan.conditions)) for t in range(plan.trials)]
    records, arrays = run_trials("sec_2_4_1", plan, pairs)
    path = tmp_path / f"{name}.json"
    identity = {"experiment": name, "artefact": "sec_2_4_1", "effort": "quick"}
    gather(identity, plan, records, arrays, path)
    return Result(path)


def test_the_numbers_of_2_4_are_read_from_what_the_trials_give(tmp_path):
    made = {
        name: result_of(tmp_path, name, replace(plan, trials=3))
        for name, plan in {
            "exp_c2_rank_A": linear_trials.rank_of_a("quick"),
            "exp_c2_rank_D": linear_trials.rank_of_d("quick"),
        }.items()
    }
    values = s4_1_claims.values_of_ranks(made)
    assert values["s2_4_1_rankA"].value == 12
    assert values["s2_4_1_rankD"].value == 5
