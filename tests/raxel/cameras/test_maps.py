"""Central models of section 2.2: Jacobians, inverses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import BrownCamera, KannalaBrandtCamera, TardifCamera
from raxel.cameras.lenses.azimuthal import invert_rising, smallest_positive_root
from raxel.cameras.lenses.fisheye import AsymmetricMap
from raxel.cameras.lenses.perspective import BrownMap
from raxel.cameras.lenses.polynomials import PolarMap
from raxel.cameras.lenses.rational import CubicMap, LiftedMap
from tests.camera_zoo import CUBIC, KB_K, KB_ODD, KB_TURN, SHAH, SIZE, K

MAPS = {
    "brown": BrownMap(np.array([-0.2, 0.03]), np.array([0.01, -0.02]), 1.0),
    "kannala-brandt": AsymmetricMap(*map(np.array, (KB_K, *KB_ODD, *KB_TURN)), 2.0),
    "cubic": CubicMap(CUBIC, 0.8),
    "shah-aggarwal": PolarMap(*SHAH, 1.0),
    "lifted": LiftedMap(np.random.default_rng(15).normal(0, 1, (3, 6)), 0.5),
}


@pytest.mark.parametrize("name", MAPS)
def test_jacobians_agree_with_differences(name):
    warp, h = MAPS[name], 1e-6
    p = np.random.default_rng(16).uniform(-0.4, 0.4, (100, 2))
    J = warp.jacobian(p)
    for k, step in enumerate(h * np.eye(2)):
        slope = (warp.value(p + step) - warp.value(p - step)) / (2 * h)
        np.testing.assert_allclose(
            J[:, :, k], slope, atol=1e-7 * np.abs(J).max(), rtol=1e-6
        )


coefficient = st.integers(-200, 200).map(lambda n: n / 1000)


@given(
    st.lists(coefficient, max_size=3),
    st.tuples(coefficient, coefficient).map(lambda p: np.array(p) / 10),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=25, deadline=None)
def test_brown_camera_roundtrip(radial, tangential, seed):
    camera = BrownCamera(K, radial, tangential, *SIZE)
    pixels, valid = camera.project(np.random.default_rng(seed).normal(0, 1, (200, 3)))
    rays = camera.rays(pixels[valid])
    assert rays.valid.all()
    again = camera.project(rays.directions)
    np.testing.assert_allclose(again.pixels, pixels[valid], rtol=1e-12, atol=1e-9)


@given(
    st.floats(-1, 3), st.floats(-0.5, 0.5), st.floats(0.1, 5), st.integers(0, 2**32 - 1)
)
@settings(max_examples=25, deadline=None)
def test_rising_cubic_is_inverted(cube, square, line, seed):
    high = min(smallest_positive_root([line, 2 * square, 3 * cube]), 10.0)
    x = np.random.default_rng(seed).uniform(0, 0.99 * high, 50)
    poly = np.polynomial.Polynomial([0, line, square, cube])
    found = invert_rising(poly, poly.deriv(), poly(x), high)
    np.testing.assert_allclose(poly(found), poly(x), rtol=1e-13, atol=1e-14)
    assert (found <= high).all()


@pytest.mark.parametrize("high", [3.0, np.inf])
def test_zero_is_inverted_exactly(high):
    calls = []

    def slope(x):
        calls.append(x)
        return 1 + x**2

    found = invert_rising(lambda x: x + x**3 / 3, slope, np.zeros(2), high)
    assert np.array_equal(found, [0.0, 0.0])
    assert len(calls) <= 1


def test_tiny_decentring_has_tiny_effect():
    given = [2.0, -0.05, 0.004], (150.0, 149.0), (318.0, 241.0), *SIZE
    none = KannalaBrandtCamera(*given)
    some = KannalaBrandtCamera(*given, tangential=(1e-9, 0))
    points = np.random.default_rng(3).normal(size=(200, 3)) + [0, 0, 2]
    np.testing.assert_allclose(
        some.project(points).pixels, none.project(points).pixels, atol=1e-5
    )


def test_growing_focal_length_has_angle_limit():
    camera = TardifCamera([300.0, 0.5], (320, 240), *SIZE)
    far = camera.rays(np.array([[320 + 1e9, 240.0]])).directions[0]
    assert camera.max_angle == pytest.approx(np.arctan2(far[0], far[2]), abs=1e-6)
