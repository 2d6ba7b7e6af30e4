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
def test_ray_of_each_camera_projects_to_its_pixel(name):
    camera = general_cameras.CAMERAS[name](24, 18)
    pixels = pixel_grid(24, 18)
    rays = camera.rays(pixels)
    assert rays.valid.all()
    ahead = np.sign(rays.directions[:, 2])
    assert np.all(ahead == experiment.AHEAD[name])
    back = camera.project(rays.origins + 500 * rays.directions)
    np.testing.assert_allclose(back.pixels, pixels, atol=1e-9)


def test_faceted_mirrors_meet_at_edges_where_rays_jump():
    camera = general_cameras.faceted(24, 18)
    corners = [
        np.column_stack([outline, np.zeros(4)]) @ T[:3, :3].T + T[:3, 3]
        for T, outline in zip(camera.T_viewer_facets, camera.outlines, strict=True)
    ]
    np.testing.assert_allclose(corners[0][3], corners[1][3], atol=1e-9)
    np.testing.assert_allclose(corners[1][1], corners[2][1], atol=1e-9)
    assert experiment.largest_jump(camera) > 20
    assert experiment.largest_jump(general_cameras.fisheye(24, 18)) < 10


def test_nonparametric_claim_is_judged_on_the_faceted_camera():
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


def test_figure_2_1_check_detects_a_moved_ray():
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


def test_figure_2_2_check_detects_wrong_points_and_poses():
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


def test_matrix_text_has_no_negative_zeros():
    text = report.matrix_text(np.array([[-1e-9, 2.0], [-3.456, 0.0]]))
    assert text == " 0.00 2.00\n-3.46 0.00"


# Claims of 2.2.2 and 2.3


@pytest.mark.parametrize(("fov", "feasible"), [(90, True), (179, True), (180, False)])
def test_plane_in_front_of_all_rays_exists_below_180_degrees_only(fov, feasible):
    found = planes.plane_trial({"fov_deg": fov}, np.random.default_rng(0))
    assert found["feasible"] is feasible
    assert found["rim"] == planes.RIM


@pytest.mark.parametrize(
    ("law", "expected", "reason"),
    [
        (lambda fov: [fov < 180] * 2, "reproduced", "no solution"),
        (lambda fov: [fov < 200] * 2, "differs", ""),
        (lambda fov: [fov < 180, fov < 100], "differs", ""),
        (lambda fov: [np.nan], "undecided", ""),
        (lambda fov: [True, fov < 180], "differs", "0.50 at 180 deg"),
    ],
)
def test_fov180_verdict_states_shares(law, expected, reason):
    (reading,) = readings(
        s2_claims.judge_fov180,
        "exp_c2_fov180",
        lambda condition: {"feasible": law(condition["fov_deg"])},
    )
    assert reading.verdict == expected
    assert reason in reading.reason
    assert expected == "reproduced" or "no solution" not in reading.reason


NO_PAIRS = {"through_origin": 1e-16, "beside_origin": 0.5, "least_distance_m": 0.1}


@pytest.mark.parametrize(
    ("judge", "trial", "wrong"),
    [
        (
            report.judge_pluecker_invariant,
            experiment.two_pairs_trial,
            [{"difference": 1e-9, "asymmetry": 0.0}],
        ),
        (
            report.judge_pluecker_origin,
            experiment.origin_trial,
            [
                NO_PAIRS | {"through_origin": 1e-9},
                {
                    "through_origin": 1e-16,
                    "beside_origin": 0.0,
                    "least_distance_m": 0.1,
                },
            ],
        ),
    ],
)
def test_pluecker_claim_holds_and_fails(judge, trial, wrong):
    (name,) = judge.repro_marks[0]["needs"]
    right = trial({}, np.random.default_rng(1))
    assert verdict(judge, name, right) == "reproduced"
    for values in wrong:
        assert verdict(judge, name, values) == "differs"


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (lambda level: 0.1 * level, "reproduced"),
        (lambda level: 0.1 * level**4, "differs"),
        (lambda level: -0.1 * level, "differs"),
    ],
)
def test_two_pose_error_is_judged_by_its_line_fit(law, expected):
    values = {
        f"ray_deg.{level:g}": law(level) * np.linspace(0.8, 1.2, 30)
        for level in report.LEVELS
    }
    judge = report.judge_two_pose_needs_motion
    assert verdict(judge, "fig_2_2_error", values) == expected


def test_translation_error_turns_rays_by_the_expected_angle():
    rng = np.random.default_rng(2)
    found = flat(page.wrong_motion_trial({"kind": "translation"}, rng))
    assert found["ray_deg.0"] < 1e-9
    most = exercises.angle_per_shift(1.0, found["step_mm"])
    assert 0.2 * most < found["ray_deg.1"] < 1.2 * most


def test_exercise_answers_of_2_3_are_correct():
    direction = exercises.ray_of_pixel()
    np.testing.assert_allclose(direction / direction[2], [0.15, -0.1, 1.0])
    vector = exercises.VECTOR
    a, b = np.array(exercises.A_MM), np.array(exercises.B_MM)
    np.testing.assert_allclose(vector / 2, [*(b - a), *-np.cross(a, b)])
    assert exercises.BYTES_OF_TABLE == 770_048_000
