"""The lens against closed forms: falloff, point spread of an edge, colour fringes."""

import numpy as np
import pytest
from scipy.special import erf

from raxel.lab.optics import Crop, Optics, gaussian_blur, magnified
from raxel.lab.textures import LUMINANCE
from tests.raised import raises_line


def edge(height, width, at, slope):
    """Exact coverage of pixels right of the line u = at + slope v (averaged in v)."""
    v = np.arange(height)[:, None] + np.linspace(-0.5, 0.5, 101)
    position = (at + slope * v)[:, None, :]
    u = np.arange(width)[:, None]
    return np.clip(u + 0.5 - position, 0, 1).mean(axis=-1).astype(np.float32)


def box_erf(x, sd):
    """A step smeared by a Gaussian and by a pixel, at x (N,) from the step."""
    fine = x[:, None] + np.linspace(-0.5, 0.5, 101)
    return (0.5 + 0.5 * erf(fine / (sd * np.sqrt(2)))).mean(axis=1)


@pytest.mark.parametrize(
    ("sd", "most"), [(0.6, 0.085), (1.0, 0.045), (2.5, 0.006), (5.0, 0.0015)]
)
def test_blurred_edge_is_error_function(sd, most):
    height, width, at, slope = 121, 101, 50.0, 0.05
    blurred = Optics(blur_sd_px=(sd, sd)).apply(edge(height, width, at, slope))
    inner = slice(40, 81)
    v, u = np.mgrid[inner, :width]
    across = (u - (at + slope * v)) / np.hypot(1, slope)
    error = blurred[inner].ravel() - box_erf(across.ravel(), sd)
    # A pixel keeps the share of an edge inside it, but not its place there: the edge
    # comes out a little narrower or wider than the truth, which fades as blur grows.
    assert np.abs(error).max() < most


@pytest.mark.parametrize("sd", [0.3, 0.6, 1.7])
def test_point_spread_keeps_variance_and_light(sd):
    point = np.zeros((41, 41), np.float32)
    point[20, 20] = 1
    spread = gaussian_blur(point, sd**2)
    away = np.arange(41) - 20
    assert spread.sum() == pytest.approx(1, abs=1e-5)
    assert spread.sum(axis=0) @ away**2 == pytest.approx(sd**2, rel=2e-4)


def test_blur_grows_with_squared_radius():
    optics = Optics(blur_sd_px=(0.6, 1.4))
    size = 241
    half_diagonal = np.hypot(size, size) / 2
    away = np.arange(size)
    for position in (120, 160, 200, 225):
        point = np.zeros((size, size), np.float32)
        point[position, position] = 1
        across = optics.apply(point).sum(axis=0)
        mean = away @ across / across.sum()
        expected = 0.36 + (1.96 - 0.36) * (2 * (position - 120) ** 2 / half_diagonal**2)
        variance = (away - mean) ** 2 @ across / across.sum()
        # Each pixel gathers with its own width: a point's spread is a little uneven.
        assert variance == pytest.approx(expected, rel=0.01, abs=2e-3)


def test_pinhole_falloff_is_cosine_fourth():
    focal, width, height = 300.0, 400, 300
    light = Optics(exit_pupil_px=focal).vignetting(width, height)
    v, u = np.mgrid[:height, :width]
    angle = np.arctan(np.hypot(u - 199.5, v - 149.5) / focal)
    np.testing.assert_allclose(light, np.cos(angle) ** 4, rtol=1e-6)


def test_falloff_dims_image():
    optics = Optics(exit_pupil_px=60.0)
    light, rng = optics.vignetting(60, 40), np.random.default_rng(3)
    for shape in ((40, 60), (40, 60, 3)):
        image = rng.uniform(0, 1, shape).astype(np.float32)
        shares = optics.apply(image) / image
        np.testing.assert_allclose(
            shares.reshape(40, 60, -1).T,
            [light.T] * (shape[2] if len(shape) == 3 else 1),
            rtol=1e-5,
        )


def test_chromatic_scales_shift_colours():
    size, scales = 401, (1.002, 1.0, 0.997)
    image = np.repeat(
        gaussian_blur(edge(size, size, 350.0, 0.0), 0.5)[..., None], 3, axis=-1
    )
    image_of = Optics(chromatic_scale=scales).apply(image)
    positions = size - 0.5 - image_of[200].astype(float).sum(axis=0)
    expected = 200 + (350 - 200) * np.array(scales) / (LUMINANCE @ scales)
    np.testing.assert_allclose(positions, expected, atol=2e-3)


def test_magnified_smooth_image_is_exact():
    v, u = np.mgrid[:80, :100].astype(float)

    def wave(u, v):
        return np.sin(u / 5) * np.cos(v / 7)

    larger = magnified(wave(u, v).astype(np.float32), 1.01, np.array([40.0, 30.0]))
    truth = wave(40 + (u - 40) / 1.01, 30 + (v - 30) / 1.01)
    assert np.abs(larger - truth)[4:-4, 4:-4].max() < 2e-3


def test_perfect_lens_changes_nothing():
    image = np.random.default_rng(1).random((20, 30, 3)).astype(np.float32)
    np.testing.assert_array_equal(Optics().apply(image), image)


@pytest.mark.parametrize(
    ("field", "values"),
    [
        ("blur_sd", {"blur_sd_px": (-0.1, 1)}),
        ("exit_pupil", {"exit_pupil_px": 0}),
        ("falloff", {"falloff": ((0, 5), (1, 0.5, 0.2))}),
        ("falloff", {"falloff": ((0, 5), (1, 1.5))}),
        ("chromatic_scale", {"chromatic_scale": (1, 0, 1)}),
    ],
)
def test_invalid_lens_is_rejected(field, values):
    with raises_line(f"^field '{field}': "):
        Optics(**values)


@pytest.mark.parametrize("fineness", [2, 3])
def test_blur_is_symmetric_for_any_subpixels(fineness):
    optics = Optics(blur_sd_px=(0.3, 3.0))
    rng = np.random.default_rng(fineness)
    quarter = rng.random((24 * fineness, 31 * fineness), np.float32)
    half = np.hstack([quarter, quarter[:, ::-1]])
    blurred = optics.apply(np.vstack([half, half[::-1]]), fineness)
    np.testing.assert_allclose(blurred[:, ::-1], blurred, atol=1e-5)
    np.testing.assert_allclose(blurred[::-1], blurred, atol=1e-5)


def test_falloff_curve_multiplies_pupil_falloff():
    curve = ((0, 50, 100), (1.0, 0.8, 0.2))
    both = Optics(exit_pupil_px=90.0, falloff=curve).vignetting(60, 40)
    each = [
        Optics(exit_pupil_px=90.0).vignetting(60, 40),
        Optics(falloff=curve).vignetting(60, 40),
    ]
    np.testing.assert_allclose(both, each[0] * each[1], rtol=1e-6)


def test_windowed_optics_use_image_position():
    optics = Optics(exit_pupil_px=60.0)
    part = Crop(30, 20, 16, 12, 64, 48)
    found = optics.apply(np.ones((12, 16), np.float32), window=part)
    np.testing.assert_array_equal(found, optics.vignetting(64, 48)[part.place])
