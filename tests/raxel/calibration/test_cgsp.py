"""Linear stage of CGSP: exactness, invariance, outliers, rejected input."""

import numpy as np
import pytest

from raxel.calibration.linear.cgsp import (
    PINHOLE_METHODS,
    image_noise_weights,
    linear_cgsp,
)
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector
from tests.calibration_scenes import meet_grids, scene
from tests.raised import raises_code
from tests.raxel.calibration.test_linear import CENTRES, assert_recovered


@pytest.mark.parametrize("pinhole", PINHOLE_METHODS)
@pytest.mark.parametrize("centre", CENTRES)
@pytest.mark.parametrize("robust", [None, "ransac"])
def test_exact_points_give_exact_centre(pinhole, centre, robust):
    centre, T, _, points = scene(1, centre)
    rng = np.random.default_rng(0)
    side = np.sign(centre[2])
    solution = linear_cgsp(points, side=side, pinhole=pinhole, robust=robust, rng=rng)
    assert_recovered(solution, centre, T, length=1e-8, angle=1e-10)
    assert solution.inliers.all()


def test_linear_stage_accepts_missing_rays():
    centre, T, _, points = scene(7, grids=6, count=500)
    seen = np.random.default_rng(7).random(points.shape[:2]) < 0.5
    seen[0] = True
    points = np.where(seen[..., None], points, np.nan)
    solution = linear_cgsp(points, side=1)
    assert_recovered(solution, centre, T)
    np.testing.assert_array_equal(solution.inliers[1:], seen[1:])


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("pinhole", PINHOLE_METHODS)
def test_grid_parallel_to_base_is_harmless_among_others(pinhole, noise):
    centre, _, _, points = scene(6, count=500)
    # The base's own points, seen from the centre on a plane behind it.
    behind = centre[:2] + 1.3 * (points[0] - centre[:2])
    rng = np.random.default_rng(6)
    seen = np.concatenate([points, behind[None]])
    seen = seen + noise * rng.standard_normal(seen.shape)
    without = linear_cgsp(seen[:3], side=1, pinhole=pinhole).centre
    found = linear_cgsp(seen, side=1, pinhole=pinhole).centre
    assert np.linalg.norm(found - without) < max(1e-8, 0.02 * noise)


@pytest.mark.parametrize(
    ("nonsense", "message"),
    [({"side": 0}, "side: found 0"), ({"pinhole": "none"}, "'none'")],
)
def test_unknown_side_or_method_is_rejected(nonsense, message):
    _, _, _, points = scene(1)
    with pytest.raises(ValueError, match=message):
        linear_cgsp(points, **{"side": 1} | nonsense)


def test_other_side_is_reflection_in_base_plane():
    centre, T, _, points = scene(2)
    mirrored = linear_cgsp(points, side=-1)
    flip = np.array([1.0, 1.0, -1.0])
    assert np.abs(mirrored.centre - flip * centre).max() < 1e-6
    assert np.abs(mirrored.T_base_grid[:, :3, 3] - flip * T[:, :3, 3]).max() < 1e-6
    axes = flip[:, None] * T[:, :3, :2]
    assert np.abs(mirrored.T_base_grid[:, :3, :2] - axes).max() < 1e-8
    assert np.allclose(np.linalg.det(mirrored.T_base_grid[:, :3, :3]), 1.0)


@pytest.mark.parametrize("pinhole", PINHOLE_METHODS)
def test_linear_cgsp_is_invariant_to_frames_and_unit(pinhole):
    _, _, _, points = scene(5)
    points = points + 0.1 * np.random.default_rng(5).normal(size=points.shape)
    before = linear_cgsp(points, side=1, pinhole=pinhole)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, s], [-s, c]])
    moved = points.copy()
    moved[0] = 3.0 * (points[0] @ turn + [5000.0, -700.0])
    moved[1] = 3.0 * (points[1] @ turn.T + [300.0, -40.0])
    moved[2] = 3.0 * points[2]
    after = linear_cgsp(moved, side=1, pinhole=pinhole).centre / 3.0
    expected = before.centre.copy()
    expected[:2] = before.centre[:2] @ turn + [5000.0, -700.0]
    assert np.linalg.norm(after - expected) < 1e-6


def test_linear_cgsp_rejects_outliers():
    centre, _, _, points = scene(8, count=2000)
    rng = np.random.default_rng(8)
    points = points + 0.2 * rng.normal(size=points.shape)
    wrong = rng.random(points.shape[:2]) < 0.15
    spoilt = points + wrong[..., None] * rng.uniform(-80, 80, points.shape)
    clean = np.linalg.norm(linear_cgsp(points, side=1).centre - centre)
    for robust in ("ransac", 0.35):
        found = linear_cgsp(spoilt, side=1, robust=robust, rng=rng, subset=500)
        assert np.linalg.norm(found.centre - centre) < 3 * clean
        right = ~(wrong[0] | wrong[1:])
        # A wrong pair that lies within the noise, or an unlucky right one.
        assert np.mean(found.inliers[1:] == right) > 0.98
    assert np.linalg.norm(linear_cgsp(spoilt, side=1).centre - centre) > 10 * clean


def test_majority_of_outliers_is_rejected():
    _, _, _, points = scene(9, count=2000)
    rng = np.random.default_rng(9)
    points = points + 0.2 * rng.normal(size=points.shape)
    wrong = rng.random(points.shape[1]) < 0.6
    points[2] += wrong[:, None] * rng.uniform(-80, 80, points[2].shape)
    for robust in ("ransac", 0.35):
        with pytest.raises(CalibrationError, match=r"grid 2 .*: 1[12].. of 2000"):
            linear_cgsp(points, side=1, robust=robust, rng=rng)


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize(
    ("vectors", "message"),
    [
        (([0, 0, 0], [0.3, 0.2, 0.1]), "grid 1"),
        (([0.3, 0.2, 0.1], [0, 0, 0.5]), "grid 2"),
        (([0.3, 0.2, 0.1], [0.3, 0.2, 0.1]), "grids"),
    ],
)
def test_parallel_grids_are_rejected_by_name(vectors, message, noise):
    centre = np.array([10.0, -20.0, 600.0])
    _, T, directions, _ = scene(3)
    shifts = np.array([[20.0, 30.0, -60.0], [-30.0, 10.0, 90.0]])
    T[1:] = pose(rotation_from_vector(np.array(vectors, float)), shifts)
    points, _ = meet_grids(centre, directions, T)
    points += noise * np.random.default_rng(0).normal(size=points.shape)
    with pytest.raises(CalibrationError, match=message):
        linear_cgsp(points, side=1)


def test_linear_cgsp_rejects_degenerate_input():
    _, _, _, points = scene(0)
    apart = points.copy()
    apart[2, 2:] = np.nan
    line = points.copy()
    line[..., 1] = 2 * line[..., 0]
    for rejected, wrong in (
        (raises_code("too-few-grids"), points[:2]),
        (raises_code("no-overlap"), apart),
        (pytest.raises(CalibrationError, match="grid 1"), line),
    ):
        with rejected:
            linear_cgsp(wrong, side=1)


def test_image_noise_weights_match_derivatives():
    centre, _, directions, points = scene(4, count=50)
    H = linear_cgsp(points, side=1).homographies[1]
    weights = image_noise_weights(points[0], points[1], H, centre)
    step = 1e-6
    turned = directions + step * np.random.default_rng(4).normal(
        size=(4000, *directions.shape)
    )
    heights = points[1] @ H[2, :2] + H[2, 2]
    meets = centre[:2] - turned[..., :2] * centre[2] / turned[..., 2:]
    spread = np.sqrt(np.mean(np.sum((meets - points[0]) ** 2, axis=2), axis=0) / 2)
    # 4000 draws of two numbers give a standard deviation to 0.8 %, six times over.
    np.testing.assert_allclose(weights * spread * abs(heights), step, rtol=0.05)
