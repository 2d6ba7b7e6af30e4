"""Planes, circles, conics and cylinders: exact, unmoved by motions, honest in doubt."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.geometry import inverse_pose, pose, rotation_from_vector, transform
from raxel.geometry.planes import on_plane, stepped
from raxel.multiview import fit_circle, fit_plane
from raxel.multiview.fits.conics import (
    _system,
    algebraic_conic,
    conic_distances,
    fit_conic,
    value,
)
from raxel.multiview.fits.cylinders import cylinder_system, fit_cylinder, turned_axis
from tests.raised import raises_line


@pytest.fixture
def rng():
    return np.random.default_rng(53)


MOVED = pose(rotation_from_vector([0.4, -0.8, 0.3]), [60.0, -30, 400])
TURN = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])


def flat_points(rng, count=40):
    return on_plane(rng.uniform([-60, -30], [60, 30], (count, 2)))


def arc(degrees, count, radius=87.21, centre=(0.0, 0.0)):
    angle = np.radians(np.linspace(0, degrees, count, endpoint=False))
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + centre


def ellipse_points(count=60, degrees=360):
    return arc(degrees, count, 1.0) * [300, 120] @ TURN.T + [1900, 1100]


def mantle(rng, degrees, count=40, radius=62.98):
    angle = np.radians(rng.uniform(-degrees / 2, degrees / 2, count))
    along = rng.uniform(-50, 50, count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), along])


def test_shape_fit_is_exact(rng):
    plane = fit_plane(transform(MOVED, flat_points(rng)))
    assert abs(plane.normal @ MOVED[:3, 2]) == pytest.approx(1, abs=1e-12)
    assert plane.normal @ MOVED[:3, 3] > 0
    circle = fit_circle(arc(100, 30, centre=(300, -40)))
    np.testing.assert_allclose(circle.centre, [300, -40], atol=1e-9)
    assert circle.radius == pytest.approx(87.21, abs=1e-9)
    ellipse = fit_conic(ellipse_points())
    assert np.abs(ellipse.residuals).max() < 1e-8
    assert np.abs(value(ellipse.coefficients, ellipse_points(7))).max() < 1e-14


@pytest.mark.parametrize("degrees", [60, 150, 360])
def test_cylinder_is_found_from_arc(rng, degrees):
    fit = fit_cylinder(transform(MOVED, mantle(rng, degrees)))
    assert fit.radius == pytest.approx(62.98, abs=1e-8)
    assert abs(fit.axis @ MOVED[:3, 2]) == pytest.approx(1, abs=1e-12)
    off = transform(inverse_pose(MOVED), fit.T_frame_cylinder[:3, 3])
    np.testing.assert_allclose(off[:2], 0, atol=1e-8)


def test_shape_fit_is_invariant_to_rigid_motion(rng):
    points = mantle(rng, 120) + 0.3 * rng.normal(size=(40, 3))
    still, moved = fit_cylinder(points), fit_cylinder(transform(MOVED, points))
    np.testing.assert_allclose(moved.residuals, still.residuals, atol=1e-7)
    assert abs(moved.axis @ MOVED[:3, :3] @ still.axis) == pytest.approx(1, abs=1e-12)
    points = flat_points(rng) + 0.3 * rng.normal(size=(40, 3))
    still, moved = fit_plane(points), fit_plane(transform(MOVED, points))
    np.testing.assert_allclose(
        np.abs(moved.residuals), np.abs(still.residuals), atol=1e-10
    )
    points = ellipse_points(degrees=200) + rng.normal(size=(60, 2))
    still = fit_conic(points)
    moved = fit_conic(points @ TURN.T + [-2500, 300])
    np.testing.assert_allclose(moved.residuals, still.residuals, atol=1e-7)


def test_hyperbolas_and_parabolas_are_fitted_too():
    t = np.linspace(-1, 1.5, 30)
    for points in (
        np.column_stack([np.cosh(t), 2 * np.sinh(t)]),
        np.column_stack([t, t**2]),
    ):
        assert np.abs(fit_conic(100 * points).residuals).max() < 1e-10


def test_conic_feet_are_nearest_points(rng):
    fit = fit_conic(ellipse_points())
    points = ellipse_points(40) + rng.normal(0, 10, (40, 2))
    distances, feet = conic_distances(fit.coefficients, points)
    outline = ellipse_points(60_000)
    for k in range(0, 40, 8):
        nearest = np.hypot(*(outline - points[k]).T).min()
        assert abs(distances[k]) == pytest.approx(nearest, abs=1e-3)
    assert np.abs(value(fit.coefficients, feet)).max() < 1e-14
    outside = np.sum(((points - [1900, 1100]) @ TURN / [300, 120]) ** 2, axis=1) > 1
    np.testing.assert_array_equal(distances > 0, outside)


def test_derivatives_agree_with_differences(rng):
    cylinder = np.array([3.0, -2, 1, 0.6, 0, 0.8, 40])
    points = rng.uniform(-60, 60, (12, 3))
    conic = algebraic_conic(arc(300, 12, 1.0) * [1.3, 0.8])
    flat = arc(300, 12, 1.0) * [1.3, 0.8] + 0.05 * rng.normal(size=(12, 2))
    for system, move, shape, places, size in [
        (cylinder_system, turned_axis, cylinder, points, 5),
        (_system, stepped, conic, flat, 5),
    ]:
        found = system(shape, places)[1]
        for k, step in enumerate(1e-6 * np.eye(size)):
            ahead, back = (system(move(shape, s * step), places)[0] for s in (1, -1))
            np.testing.assert_allclose(found[:, k], (ahead - back) / 2e-6, atol=1e-6)


def squares_over_unknowns(fit, points, sd, rng, draws):
    """Mean squared error over what the covariance says, per unknown; it should be 1."""
    found = []
    for _ in range(draws):
        error, covariance = fit(points + sd * rng.normal(size=points.shape))
        found.append(error @ np.linalg.solve(covariance, error) / len(error))
    return np.mean(found)


def plane_error(points):
    fit = fit_plane(points, 0.5)
    n = MOVED[:3, 2] @ fit.T_frame_plane[:3, :3]
    n = n * np.sign(n[2])
    # Of the true plane, abeam of the origin of the fitted one.
    shift = transform(inverse_pose(fit.T_frame_plane), MOVED[None, :3, 3])[0] @ n
    return np.array([-n[1], n[0], shift]), fit.covariance


def circle_error(points):
    fit = fit_circle(points, 0.5)
    return np.array([*fit.centre, fit.radius - 87.21]), fit.covariance


def cylinder_error(points):
    fit = fit_cylinder(points, 0.5)
    T = inverse_pose(fit.T_frame_cylinder) @ MOVED
    z = T[:3, 2] * np.sign(T[2, 2])
    off = T[:2, 3] - z[:2] / z[2] * T[2, 3]
    return np.array([-z[1], z[0], *off, 62.98 - fit.radius]), fit.covariance


@pytest.mark.parametrize("shape", ["plane", "circle", "cylinder"])
def test_covariance_predicts_errors(rng, shape):
    made = {
        "plane": (plane_error, transform(MOVED, flat_points(rng)), 3, 200),
        "circle": (circle_error, arc(150, 40), 3, 200),
        "cylinder": (cylinder_error, transform(MOVED, mantle(rng, 150)), 5, 40),
    }
    fit, points, unknowns, draws = made[shape]
    found = squares_over_unknowns(fit, points, 0.5, rng, draws)
    assert found == pytest.approx(1, abs=4 * np.sqrt(2 / unknowns / draws))


def test_conic_covariance_predicts_errors():
    """Each point is moved, and the conic fitted anew: errors that are independent add
    up, and of six numbers of length 1 none is along themselves."""
    points = (ellipse_points(12) - [1900, 1100]) / 100 + [1, -2]
    sd, step = 0.005, 1e-4
    by_point = []
    for k, axis in np.ndindex(points.shape):
        ahead, back = points.copy(), points.copy()
        ahead[k, axis] += step
        back[k, axis] -= step
        change = fit_conic(ahead).coefficients - fit_conic(back).coefficients
        by_point.append(change / (2 * step))
    by_point = np.array(by_point)
    fit = fit_conic(points, sd)
    wanted = sd**2 * by_point.T @ by_point
    scale = np.sqrt(np.diag(wanted))
    found = fit.covariance / np.outer(scale, scale)
    np.testing.assert_allclose(found, wanted / np.outer(scale, scale), atol=1e-4)
    assert np.abs(fit.covariance @ fit.coefficients).max() < 1e-9 * np.abs(wanted).max()


def test_plane_covariance_predicts_rotation(rng):
    # The far points along x are rough: what is known well is the turn about x alone.
    points = rng.uniform([-10, -8], [10, 8], (60, 2))
    sd = np.where(np.abs(points[:, 0]) > 4, 1.0, 0.02)
    squares = []
    for _ in range(300):
        fit = fit_plane(on_plane(points) + [0, 0, 50] + noise_along_z(rng, sd), sd)
        n = fit.T_frame_plane[2, :3]
        squares.append(np.array([-n[1], n[0]]) ** 2 / np.diag(fit.covariance)[:2])
    np.testing.assert_allclose(np.mean(squares, axis=0), 1, atol=4 * np.sqrt(2 / 300))


def noise_along_z(rng, sd):
    return np.outer(sd * rng.normal(size=len(sd)), [0, 0, 1])


@pytest.mark.parametrize("shape", ["circle", "conic"])
def test_shape_sigma_follows_from_scatter(rng, shape):
    fitted = {"circle": fit_circle, "conic": fit_conic}[shape]
    points = arc(360, 400) + 0.5 * rng.normal(size=(400, 2))
    measured, given = fitted(points), fitted(points, 0.5)
    assert measured.sigma == pytest.approx(0.5, rel=0.15)
    assert given.sigma == pytest.approx(1.0, rel=0.15)
    share = measured.covariance / given.covariance
    reported = np.abs(given.covariance) > 1e-6 * np.abs(given.covariance).max()
    np.testing.assert_allclose(share[reported], (measured.sigma / 0.5) ** 2, rtol=1e-6)
    assert np.isnan(fitted(arc(200, {"circle": 3, "conic": 5}[shape])).sigma)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: fit_plane(np.eye(3)[:2]), "2 points; give 3 or more"),
        (lambda: fit_plane(np.outer(np.arange(5.0), [1, 2, 3])), "collinear"),
        (lambda: fit_circle(np.outer(np.arange(5.0), [1, 2])), "collinear"),
        (lambda: fit_circle(np.full((4, 2), np.nan)), "4 of 4 points are not finite"),
        (lambda: fit_circle(arc(200, 9), np.zeros(9)), "sigma: found 0; give .* above"),
        (lambda: fit_plane(np.eye(3), -1), "sigma: found -1; give standard deviations"),
        (lambda: fit_circle(arc(200, 9), np.nan), "sigma: found nan; give"),
        (lambda: fit_conic(arc(200, 9), [1, 2]), r"sigma: found shape \(2,\); .* 9"),
        (lambda: fit_circle([["a", "b"]] * 4), "points: not numeric"),
        (lambda: fit_circle(np.eye(3)), r"give an array \(N, 2\)"),
        (lambda: fit_conic(arc(200, 4)), "4 points; give 5 or more"),
        (lambda: fit_conic(np.outer(np.arange(6.0), [1, 1])), "do not determine it"),
        (lambda: fit_conic(np.ones((6, 2))), "all points are equal"),
        (lambda: fit_cylinder(np.eye(3)), "3 points; give 7 or more"),
        (
            lambda: fit_cylinder(transform(MOVED, on_plane(arc(360, 20)))),
            "on one plane .undetermined radius",
        ),
    ],
)
def test_degenerate_shape_points_are_rejected(made, message):
    with raises_line(message):
        made()


def test_nearly_planar_cylinder_is_rejected(rng):
    points = mantle(rng, 10) + 0.5 * rng.normal(size=(40, 3))
    with pytest.raises(InputError, match="nearly on a plane"):
        fit_cylinder(points)


@pytest.mark.parametrize(("apart", "sure"), [(4.0, True), (2.5, False)])
def test_cylinder_radius_needs_three_sigmas(rng, apart, sure):
    points = mantle(rng, 120)
    sigma = 62.98 / (apart * np.sqrt(fit_cylinder(points, 1.0).covariance[4, 4]))
    if sure:
        assert fit_cylinder(points, sigma).radius == pytest.approx(62.98, abs=1e-6)
        return
    with pytest.raises(InputError, match="nearly on a plane"):
        fit_cylinder(points, sigma)
