"""Central models of section 2.2: Jacobians, inverses, fits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    BrownCamera,
    KannalaBrandtCamera,
    PerspectiveCamera,
    TardifCamera,
)
from raxel.cameras.lenses.brown import BrownMap
from raxel.cameras.lenses.fit import fit_camera, radii_of
from raxel.cameras.lenses.kannala_brandt import AsymmetricMap
from raxel.cameras.lenses.polar_polynomial import PolarMap
from raxel.cameras.lenses.rational import CubicMap, LiftedMap
from raxel.cameras.lenses.rising import invert_rising, smallest_positive_root
from raxel.errors import InputError
from tests.camera_zoo import CUBIC, KB_K, KB_ODD, KB_TURN, SHAH, SIZE, ZOO, K

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
def test_any_brown_camera_goes_round(radial, tangential, seed):
    camera = BrownCamera(K, radial, tangential, *SIZE)
    points = np.random.default_rng(seed).normal(0, 1, (200, 3))
    pixels, valid = camera.project(points)
    rays = camera.rays(pixels[valid])
    assert rays.valid.all()
    again = camera.project(rays.directions)
    np.testing.assert_allclose(again.pixels, pixels[valid], rtol=1e-12, atol=1e-9)


@given(
    st.floats(-1, 3), st.floats(-0.5, 0.5), st.floats(0.1, 5), st.integers(0, 2**32 - 1)
)
@settings(max_examples=25, deadline=None)
def test_a_rising_cubic_is_inverted(cube, square, line, seed):
    slope = [line, 2 * square, 3 * cube]
    high = min(smallest_positive_root(slope), 10.0)
    x = np.random.default_rng(seed).uniform(0, 0.99 * high, 50)
    poly = np.polynomial.Polynomial([0, line, square, cube])
    found = invert_rising(poly, poly.deriv(), poly(x), high)
    np.testing.assert_allclose(poly(found), poly(x), rtol=1e-13, atol=1e-14)
    assert (found <= high).all()


@pytest.mark.parametrize("high", [3.0, np.inf])
def test_zero_comes_back_at_once_and_exactly(high):
    calls = []

    def slope(x):
        calls.append(x)
        return 1 + x**2

    found = invert_rising(lambda x: x + x**3 / 3, slope, np.zeros(2), high)
    assert np.array_equal(found, [0.0, 0.0])
    assert len(calls) <= 1


FITS = [
    (ZOO["micusik rational"], {"a": 0.0063, "b": 1e-6}, 2),
    (ZOO["micusik sine"], {"a": 200, "b": 0.4}, 2),
    (ZOO["kannala-brandt 9"], {"k": [1.1, 0, 0, 0, 0]}, 5),
    (ZOO["tardif"], {"coefficients": [200, 0, -1e-3, 0, 0, 0]}, 6),
    (ZOO["division, three terms"], {"coefficients": [-0.1, 0, 0]}, 4),
    (ZOO["field of view, radial"], {"omega": 1.1, "radial": [0, 0]}, 4),
    (ZOO["sphere, beyond"], {"xi": 1.1}, 2),
]


@pytest.mark.parametrize(("truth", "start", "free"), FITS)
def test_a_radial_law_is_found_again_from_its_own_radii(truth, start, free):
    angles = np.linspace(0, 1.2, 60)
    fields = {k: v for k, v in truth._fields().items() if k != "max_angle"}
    for name in ("xi", "omega", "a", "b", "law"):
        if name in fields:
            fields[name] = fields[name].item()
    fields |= {"width": 640, "height": 480} | start
    found = fit_camera(type(truth)(**fields), angles, radii_of(truth, angles))
    assert found.free == free
    assert found.rms_px < 1e-6
    between = np.linspace(0.01, 1.19, 77)
    np.testing.assert_allclose(
        radii_of(found.camera, between), radii_of(truth, between), atol=1e-5
    )


def test_more_terms_never_fit_worse_even_where_the_plane_model_wants_to_fold():
    angles = np.radians(np.linspace(0, 70, 80))
    square = np.diag([300.0, 300, 1])
    rms = [
        fit_camera(PerspectiveCamera(square, [0.0] * n, *SIZE), angles, 300 * angles)
        for n in range(4)
    ]
    sizes = [fit.rms_px for fit in rms]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 10 * sizes[3]
    assert not np.isnan([fit.residuals_px for fit in rms]).any()


def test_fits_that_cannot_be_are_refused():
    angles = np.linspace(0, 1.2, 30)
    cases = [
        (ZOO["brown"], angles, "not radially symmetric"),
        (ZOO["kannala-brandt 23"], angles, "not radially symmetric"),
        (ZOO["rational cubic"], angles, "not radially symmetric"),
        (ZOO["division"], np.linspace(0, 1.6, 30), "does not see 1 of the angles"),
        (ZOO["tardif"], angles[:3], "at least 6"),
    ]
    for camera, given_angles, text in cases:
        with pytest.raises(InputError, match=text) as caught:
            fit_camera(camera, given_angles, 100 * given_angles)
        assert "\n" not in str(caught.value)


def test_a_fit_leaves_the_centre_of_k_where_it_is():
    K = np.array([[500.0, 2, 310], [0, 480, 235], [0, 0, 1]])
    angles = np.linspace(0.02, 0.6, 30)
    found = fit_camera(PerspectiveCamera(K, [0.0], *SIZE), angles, 650 * np.tan(angles))
    np.testing.assert_allclose(found.camera.K[:, 2], K[:, 2])
    np.testing.assert_allclose(found.camera.K[:2, :2], 1.3 * K[:2, :2], rtol=1e-6)


def test_a_decentring_next_to_none_changes_next_to_nothing():
    given = [2.0, -0.05, 0.004], (150.0, 149.0), (318.0, 241.0), *SIZE
    none = KannalaBrandtCamera(*given)
    some = KannalaBrandtCamera(*given, tangential=(1e-9, 0))
    points = np.random.default_rng(3).normal(size=(200, 3)) + [0, 0, 2]
    np.testing.assert_allclose(
        some.project(points).pixels, none.project(points).pixels, atol=1e-5
    )


def test_a_focal_length_that_grows_with_the_radius_ends_at_an_angle():
    camera = TardifCamera([300.0, 0.5], (320, 240), *SIZE)
    far = camera.rays(np.array([[320 + 1e9, 240.0]])).directions[0]
    assert camera.max_angle == pytest.approx(np.arctan2(far[0], far[2]), abs=1e-6)
