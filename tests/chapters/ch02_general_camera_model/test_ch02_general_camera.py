"""Sections 2.2 and 2.3: general cameras, their drawings and claims."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s2_camera_models import experiment as planes
from chapters.ch02_general_camera_model.s2_camera_models import report as s2_claims
from chapters.ch02_general_camera_model.s3_general_camera import (
    exercises,
    experiment,
    page,
    report,
)
from chapters.shared.general import cameras as general_cameras
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import pluecker_matrix_of_rays
from tests.judged_claims import readings, verdict
from tests.made_results import flat, of_seed

# Cameras and drawings


@pytest.mark.parametrize("name", general_cameras.CAMERAS)
def test_a_ray_of_each_camera_comes_back_to_its_pixel(name):
    camera = general_cameras.CAMERAS[name](24, 18)
    pixels = pixel_grid(24, 18)
    rays = camera.rays(pixels)
    assert rays.valid.all()
    ahead = np.sign(rays.directions[:, 2])
    assert np.all(ahead == experiment.AHEAD[name])
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
    assert experiment.largest_jump(camera) > 20
    assert experiment.largest_jump(general_cameras.fisheye(24, 18)) < 10


def test_any_camera_is_judged_on_the_faceted_one():
    conditions = [{"camera": name} for name in ("pinhole", "faceted")]
    found = of_seed(experiment.known_motion_trial, conditions)
    reading = report.judge_nonparametric({"exp_c2_nonparam_any": found})
    assert reading.verdict == "reproduced"
    good = {"angle_rad": 1e-12, "gap_mm": 1e-12, "share": 1.0, "jump_deg": 20.0}
    for change in ({"angle_rad": 1e-6}, {"gap_mm": 1e-3}, {"share": 0.9}):
        values = good | change
        assert (
            verdict(report.judge_nonparametric, "exp_c2_nonparam_any", values)
            == "differs"
        )


def test_figure_2_1_draws_the_table_and_notices_a_moved_ray():
    conditions = [{"camera": name} for name in ("fisheye", "faceted")]
    results = {"fig_2_1_tables": of_seed(experiment.table_trial, conditions)}
    drawing = report.fig_2_1(results)
    assert drawing.check.holds
    assert drawing.scene is not None
    assert len(set(drawing.data["camera"])) == 2
    table = report.RayTableOfCamera(results["fig_2_1_tables"], "faceted")
    rays = pluecker_matrix_of_rays(table.origins, table.directions)
    np.testing.assert_allclose(table.matrices, rays, atol=1e-12)
    assert np.ptp(table.origins, axis=0).min() > 10
    table.ends = table.ends + [0.0, 1e-6, 0.0]
    assert table.gap() > report.TOLERANCE_MM


def test_figure_2_2_has_its_points_on_rays_and_grids():
    conditions = [{"method": name} for name in ("general", "generic")]
    results = {"fig_2_2_grids": of_seed(page.grids_trial, conditions)}
    drawing = report.fig_2_2(results)
    assert drawing.check.holds
    found = results["fig_2_2_grids"]
    for method in ("general", "generic"):
        assert found.column("pose_error_mm", method=method).max() < 1e-6
        assert found.column("ray_error", method=method).max() < 1e-9
    grids = report.Grids(found, "generic")
    grids.meetings = grids.meetings + [0.0, 0.0, 1e-6]
    assert grids.gap() > report.TOLERANCE_MM

    def off(condition, rng):
        return page.grids_trial(condition, rng) | {"pose_error_mm": 1e-3}

    results = {"fig_2_2_grids": of_seed(off, conditions)}
    assert not report.fig_2_2(results).check.holds


def test_a_matrix_is_printed_without_negative_zeros():
    text = report.matrix_text(np.array([[-1e-9, 2.0], [-3.456, 0.0]]))
    assert text == " 0.00 2.00\n-3.46 0.00"


# Claims of 2.2.2 and 2.3


@pytest.mark.parametrize(("fov", "feasible"), [(90, True), (179, True), (180, False)])
def test_a_plane_lies_before_all_rays_below_180_degrees_only(fov, feasible):
    found = planes.plane_trial({"fov_deg": fov}, np.random.default_rng(0))
    assert found["feasible"] is feasible
    assert found["rim"] == planes.RIM


def fov_reading(law):
    def values(condition):
        return {"feasible": law(condition["fov_deg"])}

    (reading,) = readings(s2_claims.judge_fov180, "exp_c2_fov180", values)
    return reading


def test_fov180_is_judged_both_ways():
    for law, expected in (
        (lambda fov: [fov < 180] * 2, "reproduced"),
        (lambda fov: [fov < 200] * 2, "differs"),
        (lambda fov: [fov < 180, fov < 100], "differs"),
        (lambda fov: [np.nan], "undecided"),
    ):
        assert fov_reading(law).verdict == expected


def test_a_refuted_fov180_shows_its_shares():
    reading = fov_reading(lambda fov: [True, fov < 180])
    assert "0.50 at 180 deg" in reading.reason
    assert "no solution" not in reading.reason


def test_pluecker_claims_hold_and_can_fail():
    rng = np.random.default_rng(1)
    pairs = {"exp_c2_pluecker_invariant": experiment.two_pairs_trial({}, rng)}
    through = {"exp_c2_pluecker_origin": experiment.origin_trial({}, rng)}
    for judge, values in (
        (report.judge_pluecker_invariant, pairs),
        (report.judge_pluecker_origin, through),
    ):
        (name,) = values
        assert verdict(judge, name, values[name]) == "reproduced"
    bad = {"difference": 1e-9, "asymmetry": 0.0}
    judge = report.judge_pluecker_invariant
    assert verdict(judge, "exp_c2_pluecker_invariant", bad) == "differs"
    judge = report.judge_pluecker_origin
    for ratios in ((1e-9, 0.5), (1e-16, 0.0)):
        bad = {
            "through_origin": ratios[0],
            "beside_origin": ratios[1],
            "least_distance_m": 0.1,
        }
        assert verdict(judge, "exp_c2_pluecker_origin", bad) == "differs"


def two_pose(law):
    values = {
        f"ray_deg.{level:g}": law(level) * np.linspace(0.8, 1.2, 30)
        for level in report.LEVELS
    }
    return verdict(report.judge_two_pose_needs_motion, "fig_2_2_error", values)


def test_two_pose_error_is_judged_by_its_straight_line():
    assert two_pose(lambda level: 0.1 * level) == "reproduced"
    assert two_pose(lambda level: 0.1 * level**4) == "differs"
    assert two_pose(lambda level: -0.1 * level) == "differs"


def test_a_shift_turns_rays_as_far_as_its_triangle_says():
    rng = np.random.default_rng(2)
    found = flat(page.wrong_motion_trial({"kind": "translation"}, rng))
    assert found["ray_deg.0"] < 1e-9
    most = exercises.angle_per_shift(1.0, found["step_mm"])
    assert 0.2 * most < found["ray_deg.1"] < 1.2 * most


def test_exercises_of_2_3():
    direction = exercises.ray_of_pixel()
    np.testing.assert_allclose(direction / direction[2], [0.15, -0.1, 1.0])
    vector = exercises.VECTOR
    a, b = np.array(exercises.A_MM), np.array(exercises.B_MM)
    np.testing.assert_allclose(vector / 2, [*(b - a), *-np.cross(a, b)])
    assert exercises.BYTES_OF_TABLE == 770_048_000
