"""The reduced model of a bent mirror: exact on its own curves, honest beyond."""

import numpy as np
import pytest

from raxel.calibration.mirror.reduced import (
    DistanceCurve,
    HeightCurve,
    calibrate_reduced,
    place_row,
    ray_point_offsets,
    refine_reduced,
    viewing_rays,
)
from raxel.errors import CalibrationError
from tests.raised import raises_code

SPAN = (-0.4, 0.4)
FOOT, LENGTH = np.array([-160.0, 400.0]), 420.0
TILT = np.radians(67.5)
ALONG = np.array([np.sin(TILT), np.cos(TILT)])


def distance_curve(bend=1.0):
    return DistanceCurve(np.array([520.0, 90.0, 30.0 * bend, -4.0 * bend]), SPAN)


def height_curve(tip=-16.7):
    return HeightCurve(tip / 2 * np.array([0, 0, 3.0, -1.0]), FOOT, ALONG, LENGTH)


CURVES = {
    "distance": (distance_curve(), distance_curve(0.8)),
    "height": (height_curve(), height_curve(0.0)),
}


def clamp_of(curve):
    """The clamp as the viewer sees it: u and distance."""
    if isinstance(curve, DistanceCurve):
        u = curve.span[0]
        return u, float(curve.distances([u])[0])
    return FOOT[0] / FOOT[1], float(np.hypot(*FOOT))


def seen(curve, far, n=12):
    """Pixels, and points at ranges about ``far`` on their scene rays."""
    u = np.linspace(-0.35, 0.33, n)
    ranges = far * (1 + 0.1 * np.cos(np.arange(n)))
    return u, curve.points(u) + ranges[:, None] * curve.scene_rays(u)


@pytest.mark.parametrize("kind", CURVES)
def test_reduced_curve_is_recovered_exactly(kind):
    true, before = CURVES[kind]
    u, points = seen(true, 1500.0)
    # Directions of another curve: a start that is wrong, as near scenes make it.
    found = calibrate_reduced(before, u, before.scene_rays(u), points, clamp_of(true))
    assert found.converged
    assert np.abs(found.curve.points(u) - true.points(u)).max() < 1e-9
    assert np.abs(found.linear.points(u) - true.points(u)).max() > 1
    assert np.abs(found.residuals).max() < 1e-9


@pytest.mark.parametrize("kind", CURVES)
def test_curve_derivatives_equal_differences(kind):
    true, _ = CURVES[kind]
    u, points = seen(true, 700.0)
    points = points + 5.0
    _, jacobian = ray_point_offsets(true, u, points)
    steps = 1e-4 * np.eye(4)
    numeric = [
        (
            ray_point_offsets(true.replaced(true.coefficients + h), u, points)[0]
            - ray_point_offsets(true.replaced(true.coefficients - h), u, points)[0]
        )
        / 2e-4
        for h in steps
    ]
    np.testing.assert_allclose(jacobian, np.transpose(numeric), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("kind", CURVES)
def test_reduced_clamp_is_kept_under_noise(kind):
    true, before = CURVES[kind]
    rng = np.random.default_rng(0)
    u, points = seen(true, 1500.0)
    points = points + rng.normal(0, 3, points.shape)
    u_e, distance = clamp_of(true)
    found = calibrate_reduced(before, u, true.scene_rays(u), points, (u_e, distance))
    for curve in (found.linear, found.curve):
        assert curve.distances([u_e])[0] == pytest.approx(distance, abs=1e-7)


def test_reduced_covariance_predicts_scatter():
    true, _ = CURVES["distance"]
    rng = np.random.default_rng(1)
    u, points = seen(true, 1500.0, n=30)
    clamp, at = clamp_of(true), np.linspace(-0.3, 0.39, 5)
    errors = []
    for _ in range(150):
        noisy = points + rng.normal(0, 0.5, points.shape)
        found = refine_reduced(true, u, noisy, clamp)
        errors.append(found.curve.distances(at) - true.distances(at))
    ratio = np.std(errors, axis=0) / found.deviation(at)
    # The SD of 150 draws is known to 6 %, that of 30 residuals to 13 %.
    assert np.all((ratio > 0.65) & (ratio < 1.5))


@pytest.mark.parametrize("n", [5, 40])
def test_point_row_is_located(n):
    """By central and by non-central rays, and not behind the viewer."""
    places = np.linspace(-300, 300, n)
    way = np.array([np.cos(2.6), np.sin(2.6)])
    points = np.array([900.0, -300.0]) + places[:, None] * way
    true, _ = CURVES["height"]
    for origins in (np.zeros((n, 2)), true.points(np.linspace(-0.35, 0.35, n))):
        directions = points - origins
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        foot, found = place_row(origins, directions, places)
        np.testing.assert_allclose(foot + places[:, None] * found, points, atol=1e-6)


def rejected(kind="distance", **changed):
    true, before = CURVES[kind]
    u, points = seen(true, 1500.0)
    given = {"before": before, "u": u, "scene_rays": before.scene_rays(u),
             "points": points, "clamp": clamp_of(true)}  # fmt: skip
    given |= changed
    n = len(given["u"])
    given["points"], given["scene_rays"] = given["points"][:n], given["scene_rays"][:n]
    with pytest.raises(CalibrationError) as fault:
        calibrate_reduced(**given)
    assert "\n" not in str(fault.value)
    return str(fault.value)


def test_reduced_rejects_degenerate_input():
    u = np.linspace(-0.35, 0.33, 12)
    assert "found 3 features" in rejected(u=u[:3])
    assert "must be finite" in rejected(u=np.where(u > 0, np.nan, u))
    assert "no reflection" in rejected(scene_rays=viewing_rays(u)[0])
    assert "found 1 features" in rejected(u=np.full(12, 0.2))
    assert "too few different positions" in rejected(u=0.2 + 1e-9 * np.arange(12))
    true = CURVES["distance"][0]
    near = np.linspace(-0.39, -0.2, 12)
    points = true.points(near) + 900 * true.scene_rays(near)
    assert "reach 25%" in rejected(u=near, points=points)
    shorter = DistanceCurve(np.zeros(4), (-0.4, 0.2))
    assert "features are outside the mirror" in rejected(before=shorter)
    apart = np.array([[0.0, 1.0], [0.6, -0.8], [-0.6, 0.8]])
    for code, arguments in (
        ("too-few-features", (np.zeros((2, 2)), np.ones((2, 2)), np.arange(2.0))),
        (
            "parallel-rays",
            (np.zeros((3, 2)), np.tile([0.0, 1.0], (3, 1)), np.arange(3.0)),
        ),
        ("behind-camera", (np.zeros((3, 2)), apart, np.arange(3.0))),
    ):
        with raises_code(code):
            place_row(*arguments)
