"""The nearest pinhole: exact for pinholes, unmoved by motions."""

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera
from raxel.errors import InputError
from raxel.geometry import apply_homography, inverse_pose, transform
from raxel.multiview.pinhole_fit import mapped, nearest_pinhole, pinhole_jacobian
from tests.mirror_scenes import posed

K = [[900.0, 0, 320], [0, 910, 240], [0, 0, 1]]
T = posed([20, -30, 10], [15, -8, 400])


@pytest.fixture
def points():
    return np.random.default_rng(2).uniform([-90, -70, -10], [90, 70, 10], (30, 3))


def shown(points, radial=()):
    camera = PerspectiveCamera(K, list(radial), 640, 480)
    return camera.project(transform(T, points)).pixels


def test_a_pinhole_is_found_from_what_it_shows(points):
    fit = nearest_pinhole(points, shown(points))
    assert fit.rms < 1e-8
    np.testing.assert_allclose(fit.centre, inverse_pose(T)[:3, 3], atol=1e-5)
    more = np.random.default_rng(4).uniform(-50, 50, (20, 3))
    np.testing.assert_allclose(mapped(fit.P, more), shown(more), atol=1e-6)


@pytest.mark.parametrize("turn", range(8))
def test_what_a_pinhole_sees_has_a_depth_above_zero(points, turn):
    # The sign of twelve numbers of length 1 is not told by where they map to.
    about = posed([0, 45 * turn, 0], [0, 0, 0])
    fit = nearest_pinhole(transform(about, points), shown(points))
    ahead = transform(about, points) @ fit.P[2, :3] + fit.P[2, 3]
    assert (ahead > 0).all()


def test_only_what_is_no_perspective_is_left(points):
    pixels = shown(points, [-0.3])
    fit = nearest_pinhole(points, pixels)
    assert 0.1 < fit.rms < 5
    assert fit.rms == pytest.approx(np.sqrt(np.mean(np.sum(fit.residuals**2, axis=1))))
    moved = nearest_pinhole(transform(posed([40, 3, 9], [300, 2, -90]), points), pixels)
    np.testing.assert_allclose(moved.residuals, fit.residuals, atol=1e-4)
    # Any homography of a perspective picture is one.
    H = np.array([[1.1, 0.1, 20], [-0.2, 0.9, 8], [1e-4, -2e-4, 1]])
    assert nearest_pinhole(points, apply_homography(H, shown(points))).rms < 1e-8


def test_derivatives_agree_with_differences(points):
    P = nearest_pinhole(points, shown(points)).P
    J = pinhole_jacobian(P, points)
    for k, step in enumerate(1e-9 * np.eye(12)):
        ahead, back = (mapped(P + s * step.reshape(3, 4), points) for s in (1, -1))
        slope = (ahead - back) / 2e-9
        np.testing.assert_allclose(J[:, :, k], slope, rtol=1e-4, atol=1e-3 * np.ptp(J))


@pytest.mark.parametrize(
    ("chosen", "said"),
    [
        (lambda p: (p[:5], shown(p[:5])), "5 points; 6 or more"),
        (lambda p: (p * [1, 1, 0], shown(p * [1, 1, 0])), "lie on one plane"),
        (lambda p: (p, shown(p)[:7]), r"give arrays \(N, 3\) and \(N, 2\)"),
        (lambda p: (p, shown(p) * np.nan), "30 of 30 points or pixels are not finite"),
    ],
)
def test_points_that_tell_no_pinhole_are_refused(points, chosen, said):
    with pytest.raises(InputError, match=said):
        nearest_pinhole(*chosen(points))
