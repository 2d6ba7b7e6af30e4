"""Section 3.2.1: ways to interpolate, the formula of their bias, and its claims."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.s2_1_interpolation_bias import experiment, report
from chapters.ch03_planar_grids.s2_1_interpolation_bias.experiment import (
    FOUR,
    SIDE_MM,
    GridScene,
    by_enclosing_cell,
    by_nearest_four,
    lens,
    nearest_four,
    places_of,
    rms,
)
from raxel.cameras import BrownCamera, PerspectiveCamera
from raxel.cameras.core.base import pixel_grid
from raxel.geometry.planes import intersect_rays_plane
from raxel.geometry.poses import pose, rotation_from_vector
from repro.run.outcomes import Plan
from tests.judged_claims import readings_of
from tests.made_results import written

PINHOLE = PerspectiveCamera([[900, 0, 500], [0, 900, 500], [0, 0, 1]], (), 1000, 1000)
TILTED = GridScene(
    PINHOLE, pose(rotation_from_vector([0.3, -0.5, 0.2]), [-120, -160, 500])
)


def points_of(seed, count=400):
    return np.random.default_rng(seed).uniform(0, SIDE_MM, (count, 2))


@pytest.mark.parametrize("name", FOUR)
def test_interpolation_is_exact_for_a_pinhole(name):
    points, view = points_of(1), TILTED.view(30)
    found = FOUR[name](TILTED.pixels(points), view)
    assert np.isfinite(found).all()
    assert np.abs(found - points).max() < 1e-8


def test_bias_formula_matches_a_weak_lens():
    stated, points = lens(), points_of(3, 4000)
    K = [[680 / 0.3, 0, 499.5], [0, 680 / 0.3, 499.5], [0, 0, 1]]
    weak = GridScene(
        BrownCamera(K, (-0.008,), (0, 0), 1000, 1000), lens().T_camera_grid
    )
    # Of the stated lens k2 takes 5 % away, and the smaller scale at the edge adds 13.
    for scene, share, ratio in ((weak, 0.01, 1.0), (stated, 1, 1.08)):
        error = by_enclosing_cell(scene.pixels(points), scene.view(20)) - points
        assert rms(error) / (share * report.formula_mm(20)) == pytest.approx(
            ratio, rel=0.02
        )


def test_nearest_four_corners_are_never_collinear():
    scene, points = lens(), points_of(4)
    view = scene.view(20)
    places = places_of(view)
    four = places[nearest_four(scene.pixels(points), view.pixels, places)]
    for a, b, c in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)):
        u, v = four[:, b] - four[:, a], four[:, c] - four[:, a]
        assert (u[:, 0] * v[:, 1] != u[:, 1] * v[:, 0]).all()
    # Measured on the grid they are the corners of the square; in the image most are.
    flat = np.sort(nearest_four(points, view.points, places), axis=1)
    first = (points // 20).astype(int) @ [1, view.columns]
    ring = first[:, None] + [0, 1, view.columns, view.columns + 1]
    assert (flat == ring).all()
    seen = np.sort(nearest_four(scene.pixels(points), view.pixels, places), axis=1)
    assert 0.02 < np.mean((seen != ring).any(axis=1)) < 0.15


def test_nearest_four_needs_enough_corners():
    places = np.array([[0, 0], [1, 0], [2, 0], [0, 1]])
    assert (nearest_four(np.zeros((2, 2)), places * 10.0, places) == -1).all()


def test_interpolated_noise_has_the_stated_size():
    scene, points, rng = lens(0), points_of(6, 4000), np.random.default_rng(6)
    view = scene.view(10)
    noisy = view._replace(pixels=view.pixels + rng.normal(0, 0.1, view.pixels.shape))
    for find in (by_enclosing_cell, by_nearest_four):
        error = find(scene.pixels(points), noisy) - points
        assert rms(error) / 0.3 == pytest.approx(0.1 * np.sqrt(52 / 45), rel=0.05)


def test_interpolation_is_exact_at_a_known_ridge():
    camera = experiment.two_facets(1.5, 60)
    T = experiment.monitor_pose(np.random.default_rng(7))
    assert experiment.jump_mm(camera, T) == pytest.approx(40, abs=3)
    corners = experiment.chessboard_corners(camera, T)
    pixels = pixel_grid(camera.width, camera.height)
    near = pixels[experiment.ridge_distance(pixels) < 5]
    rays = camera.rays(near)
    seen = intersect_rays_plane(rays.origins, rays.directions, T)[0]
    known = experiment.interpolated(near, corners, camera.facet_of(near)) - seen
    assert np.abs(known).max() < 1e-8
    assert rms(experiment.interpolated(near, corners) - seen) > 1
    # A camera that does not break has no ridge to know.
    flat = experiment.two_facets(0, 60)
    corners = experiment.chessboard_corners(flat, T)
    rays = flat.rays(near)
    seen = intersect_rays_plane(rays.origins, rays.directions, T)[0]
    assert np.abs(experiment.interpolated(near, corners) - seen).max() < 1e-8


def made(name, conditions, trials, trial):
    """{name: the Result of a trial in these conditions}."""
    return {name: written(Plan(trial, conditions, trials), name)}


def vectors(along, across):
    """Errors along(radius) and across(radius), per reading, of 300 points."""

    def trial(condition, rng):
        points = rng.uniform(0, SIDE_MM, (300, 2))
        out = points - SIDE_MM / 2
        radius = np.linalg.norm(out, axis=1, keepdims=True)
        out, side = out / radius, (out / radius)[:, ::-1] * [-1, 1]
        found = {
            name: along(radius, rng) * out + across[k] * radius * side
            for k, name in enumerate(report.CHOICES)
        }
        return {"points": points} | found

    return made("fig_3_6_vectors", [{"pitch_mm": 20}], 12, trial)


def verdicts(judge, results):
    return [reading.verdict for reading in readings_of(judge, results)]


def test_radial_claims_hold_and_fail():
    grown = vectors(lambda r, rng: r, (0.3, 0.1))
    assert verdicts(report.judge_radial_growth, grown) == ["reproduced"] * 2
    assert verdicts(report.judge_radial_direction, grown) == ["reproduced"]
    # More sideways in the square than with the nearest four; then sideways anyhow.
    for across in ((0.1, 0.3), (2.0, 0.1)):
        turned = vectors(lambda r, rng: r, across)
        assert verdicts(report.judge_radial_direction, turned) == ["differs"]
    shrinking = vectors(lambda r, rng: 300 - r, (0.0, 0.0))
    assert verdicts(report.judge_radial_growth, shrinking) == ["differs"] * 2


@pytest.mark.parametrize(
    ("power", "expected"), [(2, "reproduced"), (3, "differs"), (-2, "differs")]
)
def test_pitch_claim_depends_on_the_slope(power, expected):
    def trial(condition, rng):
        size = condition["pitch_mm"] ** power * rng.uniform(0.99, 1.01)
        return {f"{name}.rms_mm": size for name in report.CHOICES}

    conditions = [{"pitch_mm": p} for p in (5, 10, 20, 40)]
    results = made("fig_3_7_pitches", conditions, 10, trial)
    assert verdicts(report.judge_pitch, results) == [expected] * 2


@pytest.mark.parametrize(
    ("at_none", "power", "expected"),
    [(1e-13, 1, "reproduced"), (1e-6, 1, "differs"), (1e-13, 2, "differs")],
)
def test_cause_claim_needs_zero_error_without_distortion(at_none, power, expected):
    def trial(condition, rng):
        share = condition["share"]
        size = share**power * rng.uniform(0.99, 1.01) if share else at_none
        return {f"{name}.rms_mm": size for name in report.CHOICES}

    conditions = [{"share": s} for s in (0, 0.1, 0.3, 1)]
    results = made("fig_3_6_distortion", conditions, 10, trial)
    assert verdicts(report.judge_cause, results) == [expected] * 2


def test_ridge_claim_has_four_readings():
    sizes = {"unknown": 9.0, "known": 0.1, "7 x 7": 1.0, "none": 0.5}

    def trial(condition, rng):
        values = {f"{n}.rms_mm": s * rng.uniform(0.99, 1) for n, s in sizes.items()}
        return values | {"trusted": 0.9}

    name = "exp_c3_interp_discontinuous"
    results = made(name, [{"facet_deg": 1.5}], 8, trial)
    found = verdicts(report.judge_discontinuous, results)
    assert found == ["differs", "reproduced", "differs", "differs"]
