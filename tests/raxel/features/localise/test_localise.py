"""Localisers: exact at a symmetric corner, with valid predicted deviations."""

import numpy as np
import pytest
from scipy.special import erf

from raxel.errors import InputError
from raxel.features.localise import (
    corner_subpix,
    derivative,
    opencv_subpix,
    saddle,
    saddle_point,
    subpix,
)
from raxel.features.localise.ridges import _columns, _offsets
from raxel.features.localise.saddle import _variance, fit_saddles, noise_variance

LOCALISERS = {
    "saddle-point": saddle_point,
    "derivative": derivative,
    "opencv": corner_subpix,
}
SIZE, PERIOD, BLUR = 420, 31.7, 1.5
MARGIN = 40
# Settings with which each localiser is asked what it can do.
FINE = {
    "saddle-point": {"window": 15, "blur_sd": 2.0},
    "derivative": {"window": 15},
    "opencv": {"half_window": 7, "termination_px": 1e-4},
}


def wave(x, sd):
    """A square wave of +-1 with an edge at every multiple of PERIOD, blurred."""
    count = int(np.abs(x).max() / PERIOD) + 2
    edges = np.arange(-count, count + 1)
    signs = np.where(edges % 2 == 0, 1.0, -1.0)
    return sum(
        s * erf((x - e * PERIOD) / (np.sqrt(2) * sd))
        for s, e in zip(signs, edges, strict=True)
    )


def board(angle=0.37, offset=(0.3, 0.1), sd=BLUR, low=38.0, high=218.0):
    """An endless blurred chessboard (SIZE, SIZE) float, and its corners inside."""
    v, u = np.mgrid[:SIZE, :SIZE].astype(float)
    cos, sin = np.cos(angle), np.sin(angle)
    x = cos * (u - offset[0]) + sin * (v - offset[1])
    y = cos * (v - offset[1]) - sin * (u - offset[0])
    grey = (high + low) / 2 + (high - low) / 2 * wave(x, sd) * wave(y, sd)
    k = PERIOD * np.arange(-30, 31)
    x, y = (grid.ravel() for grid in np.meshgrid(k, k))
    corners = np.column_stack([cos * x - sin * y, sin * x + cos * y]) + offset
    inside = ((corners > MARGIN) & (corners < SIZE - MARGIN)).all(axis=1)
    return grey, corners[inside]


@pytest.fixture(scope="module")
def clean():
    return board()


def started(corners, rng, sd=0.7):
    return corners + rng.normal(0, sd, corners.shape)


# What interpolation and pixels leave: OpenCV's bilinear sampling leaves most.
@pytest.mark.parametrize(
    ("name", "left"), [("saddle-point", 2e-3), ("derivative", 3e-3), ("opencv", 2e-2)]
)
def test_localiser_finds_clean_corners(clean, name, left):
    image, truth = clean
    found = LOCALISERS[name](
        image, started(truth, np.random.default_rng(1)), **FINE[name]
    )
    assert found.converged.all()
    assert np.abs(found.corners - truth).max() < left


@pytest.mark.parametrize("name", LOCALISERS)
@pytest.mark.parametrize("noise", [2.0, 6.0])
def test_localiser_sd_matches_errors(clean, name, noise):
    image, truth = clean
    rng = np.random.default_rng(7)
    scores, errors, predicted = [], [], []
    for _ in range(3):
        noisy = np.rint(image + rng.normal(0, noise, image.shape)).astype(np.uint8)
        found = LOCALISERS[name](noisy, started(truth, rng, 0.5), **FINE[name])
        assert found.converged.all()
        error = found.corners - truth
        scores.append(error / found.sd[:, None])
        errors.append(error)
        predicted.append(found.sd)
    scores = np.concatenate(scores)
    # About 660 scores: their SD is known to 3 %. It is estimated on the safe side.
    assert 0.85 < scores.std() < 1.08
    # 68 % of a Gaussian; the bias of OpenCV's sampling shows where noise is low.
    assert 0.6 < np.mean(np.abs(scores) < 1) < 0.78
    assert np.abs(scores.mean(axis=0)).max() < 0.2
    assert np.std(np.concatenate(predicted)) < 0.3 * np.mean(np.concatenate(predicted))


@pytest.mark.parametrize("window", [5, 9, 25])
@pytest.mark.parametrize("blur_sd", [0.0, 1.0, 4.0])
def test_saddle_point_sd_matches_errors_for_settings(clean, window, blur_sd):
    image, truth = clean
    rng = np.random.default_rng(3)
    noisy = np.rint(image + rng.normal(0, 4, image.shape)).astype(np.uint8)
    found = saddle_point(
        noisy, started(truth, rng, 0.3), window=window, blur_sd=blur_sd
    )
    good = found.converged
    assert good.mean() > 0.99
    scores = (found.corners - truth)[good] / found.sd[good, None]
    # About 220 scores: their SD is known to 5 %.
    assert 0.82 < scores.std() < 1.15


@pytest.mark.parametrize("apart_deg", [50, 70, 90, 110, 130])
@pytest.mark.parametrize("turn_deg", [0, 20, 45, 75])
def test_localiser_handles_oblique_edges(turn_deg, apart_deg):
    v, u = np.mgrid[:121, :121].astype(float)
    truth = np.array([[60.3, 59.8]])
    x, y = u - truth[0, 0], v - truth[0, 1]
    image = np.full(x.shape, 128.0)
    wave = 90.0
    for angle in np.radians([turn_deg, turn_deg + apart_deg]):
        wave = wave * erf((x * np.cos(angle) + y * np.sin(angle)) / 2)
    image += wave
    for name in ("saddle-point", "derivative"):
        found = LOCALISERS[name](image, truth + [[0.8, -0.6]], **FINE[name])
        assert found.converged.all()
        # The window of the ridges is about a whole pixel, not about the corner.
        assert np.abs(found.corners - truth).max() < 2e-2


@pytest.mark.parametrize("name", LOCALISERS)
def test_localiser_is_invariant_to_polarity_and_rotation(clean, name):
    image, truth = clean
    image, truth = image[:200, :200], truth[(truth < 150).all(axis=1)]
    start = started(truth, np.random.default_rng(5))
    first = LOCALISERS[name](image, start, **FINE[name])
    inverted = LOCALISERS[name](256 - image, start, **FINE[name])
    turned = LOCALISERS[name](image.T.copy(), start[:, ::-1], **FINE[name])
    assert np.allclose(inverted.corners, first.corners, atol=2e-3)
    assert np.allclose(turned.corners[:, ::-1], first.corners, atol=2e-3)
    assert np.allclose(turned.sd, first.sd, rtol=0.05, atol=1e-4)


@pytest.mark.parametrize("name", LOCALISERS)
@pytest.mark.parametrize("scene", ["flat", "edge", "noise"])
def test_localiser_without_corner_does_not_converge(name, scene):
    rng = np.random.default_rng(8)
    image = np.full((80, 80), 100, np.uint8)
    if scene == "edge":
        image[:, 40:] = 200
    if scene == "noise":
        image = rng.integers(0, 255, image.shape, dtype=np.uint8)
    start = np.array([[40.2, 39.7], [30.0, 41.0]])
    found = LOCALISERS[name](image, start, **FINE[name])
    back = ~found.converged
    assert (found.corners[back] == start[back]).all()
    assert np.isnan(found.sd[back]).all()
    if scene != "noise":
        # A point of a flat or one-edged window is no corner: none, or a wide SD.
        assert (back | (found.sd > 0.5) | ~np.isfinite(found.sd)).all()
    assert (np.abs(found.corners - start) <= 7.5).all()


@pytest.mark.parametrize("name", LOCALISERS)
def test_localiser_accepts_any_start(clean, name):
    image, truth = board(sd=0.8)
    image = np.rint(image)
    rng = np.random.default_rng(10)
    start = rng.uniform(-5, SIZE + 5, (400, 2))
    found = LOCALISERS[name](image, start, **FINE[name])
    back = ~found.converged
    assert (found.corners[back] == start[back]).all()
    assert (np.abs(found.corners - start) <= 7.5).all()
    assert (found.sd[found.converged] >= 0).all()
    # Where a localiser is sure it is right: all corners that far inside are listed.
    inside = ((found.corners > MARGIN) & (found.corners < SIZE - MARGIN)).all(axis=1)
    sure = found.corners[inside & found.converged & (found.sd < 0.02)]
    away = np.linalg.norm(sure[:, None] - truth, axis=2).min(axis=1)
    assert len(sure) > 20
    assert (away < 0.3).mean() > 0.9


@pytest.mark.parametrize("name", LOCALISERS)
def test_localiser_keeps_corners_at_image_border(clean, name):
    image, _ = clean
    start = np.array([[2.0, 3.0], [-50.0, 10.0], [1e9, 1e9], [np.nan, 5.0]])
    found = LOCALISERS[name](image, start, **FINE[name])
    assert not found.converged.any()
    assert np.array_equal(found.corners, start, equal_nan=True)


def test_window_size_limits_capture_range():
    """E-3.16: OpenCV discards what moved further than its half window."""
    image, truth = board(sd=1.0)
    at_8 = truth + 8 * np.array([np.cos(0.3), np.sin(0.3)])
    narrow = corner_subpix(image, at_8, half_window=4)
    assert not narrow.converged.any()
    wide = corner_subpix(image, at_8, half_window=9)
    assert wide.converged.all()
    assert np.abs(wide.corners - truth).max() < 0.1
    alone = opencv_subpix(image.astype(np.float32), at_8, half_window=9)
    np.testing.assert_array_equal(alone, wide.corners)
    left = opencv_subpix(image.astype(np.float32), at_8, half_window=4)
    np.testing.assert_array_equal(left, at_8.astype(np.float32))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda i, c: saddle_point(i, c, window=8), "window: "),
        (lambda i, c: derivative(i, c, window=3), "window: "),
        (lambda i, c: saddle_point(i, c, blur_sd=-1), "blur_sd"),
        (lambda i, c: saddle_point(np.dstack([i] * 3), c), "image: "),
        (lambda i, c: derivative(i, c.ravel()), r"\(N, 2\)"),
        (lambda i, c: corner_subpix(i, c, half_window=4, zero_zone=4), "zero_zone"),
    ],
)
def test_localiser_rejects_invalid_arguments(clean, call, message):
    with pytest.raises(InputError, match=rf"^.*{message}.*\Z"):
        call(*clean)


def test_ridge_derivatives_match_differences():
    rng = np.random.default_rng(2)
    ridges = np.array([[0.3, -0.4, 0.2, 1.6, 0.5, 0.7, 40.0, 35.0, 60.0, 2.0]])
    x, y = _offsets(5)
    values = rng.normal(20, 5, (1, len(x))).astype(np.float32)
    columns, _ = _columns(ridges, x, y, values)
    for k in range(10):
        step = np.zeros((1, 10))
        step[0, k] = 1e-3
        _, ahead = _columns(ridges + step, x, y, values)
        _, behind = _columns(ridges - step, x, y, values)
        # Single precision of values of about 20.
        assert np.allclose((behind - ahead) / 2e-3, columns[:, k], atol=2e-2)


def test_noise_variance_excludes_image_content(clean):
    image, truth = clean
    rng = np.random.default_rng(9)
    weights = np.ones((len(truth), 11, 11))
    # Corners half a pixel's rounding away: the image leaves less than 0.3 levels.
    assert np.sqrt(noise_variance(image, truth, weights)).max() < 0.3
    noisy = image + rng.normal(0, 5, image.shape)
    found = np.sqrt(noise_variance(noisy, truth, weights).mean())
    assert found == pytest.approx(5, rel=0.05)


def test_saddle_covariance_matches_pixel_sensitivity(monkeypatch):
    """Each pixel is brightened a little, and the saddle is localised again."""
    # Half a pixel is what a noisy image needs, and too far for a derivative.
    monkeypatch.setattr(saddle, "SHIFT_PX", 0.02)
    v, u = np.mgrid[:41, :41].astype(float)
    distances = [
        (v - 20.5) * np.cos(a) - (u - 20) * np.sin(a) for a in np.radians([5, 30])
    ]
    corner = 128 + 90 * np.prod([erf(d / (np.sqrt(2) * BLUR)) for d in distances], 0)
    start, window = np.array([[20.0, 20.5]]), 5
    found, converged = fit_saddles(corner, start, window)
    assert converged.all()
    moved = []
    for row, column in np.argwhere((np.abs(u - 20) < 8) & (np.abs(v - 20.5) < 8)):
        ends = []
        for change in (0.5, -0.5):
            image = corner.copy()
            image[row, column] += change
            ends.append(fit_saddles(image, start, window)[0][0])
        moved.append(ends[0] - ends[1])
    due = np.transpose(moved) @ moved
    noisy = corner + np.random.default_rng(0).normal(0, 2, corner.shape)
    predicted = _variance(noisy, corner, found, window, 0.0)[0]
    assert due[0, 0] > 3 * due[1, 1], "longer along the narrow corner"
    # Both are multiplied with the noise of a pixel.
    np.testing.assert_allclose(
        predicted / np.trace(predicted), due / np.trace(due), atol=0.002
    )


@pytest.mark.parametrize(("half", "zero_zone", "blur"), [(7, -1, 1.0), (4, 2, 1.5)])
def test_opencv_covariance_matches_pixel_sensitivity(
    monkeypatch, half, zero_zone, blur
):
    """Pixels are brightened one after the other.

    In windows whose gradients determine the corner, or whose centre is excluded;
    otherwise the corner follows the noise.
    """
    monkeypatch.setattr(subpix, "noise_variance", lambda *_: np.ones(1))
    v, u = np.mgrid[:37, :37].astype(float)
    tilted = [(u - 18.3) * np.cos(a) + (v - 17.8) * np.sin(a) for a in (0.2, 1.5)]
    corner = 128 + 90 * np.prod([erf(d / (np.sqrt(2) * blur)) for d in tilted], 0)
    start, how = np.array([[18.0, 18.0]]), {"half_window": half, "zero_zone": zero_zone}
    moved = []
    for row, column in np.argwhere(np.maximum(abs(u - 18), abs(v - 18)) < half + 3):
        ends = []
        for change in (1, -1):
            image = corner.astype(np.float32)
            image[row, column] += change
            ends.append(opencv_subpix(image, start, **how, termination_px=1e-6)[0])
        moved.append((ends[0] - ends[1]) / 2)
    predicted = corner_subpix(corner, start, **how, termination_px=1e-6).sd
    assert predicted[0] == pytest.approx(
        np.sqrt(np.sum(np.square(moved)) / 2), rel=0.04
    )


def test_ridge_fit_is_independent_of_start():
    """A fifth of the noise's own spread would be 5e-3."""
    image, truth = board()
    image = image + 4 * np.random.default_rng(3).normal(size=image.shape)
    found = [
        derivative(image, started(truth, np.random.default_rng(seed), 2.0))
        for seed in (1, 2)
    ]
    assert all(one.converged.all() for one in found)
    assert np.abs(found[0].corners - found[1].corners).max() < 1e-3


def test_noise_variance_is_unbiased_for_few_pixels():
    """The corner of least asymmetry takes two of the twelve pairs of 5 x 5 pixels."""
    count, tile = 400, 15
    place = np.arange(tile) - tile // 2
    saddle = 100.0 * np.outer(place, place)
    image = np.tile(saddle, (1, count))
    image += np.random.default_rng(22).normal(size=image.shape)
    middles = np.column_stack([tile * np.arange(count), np.zeros(count)]) + tile // 2
    weights = np.ones((count, 5, 5))
    step = 0.2

    def variance(*shift):
        return noise_variance(image, middles + step * np.array(shift), weights)

    # A quadratic in the shift, by six of its values.
    at = variance(0, 0)
    ends = [variance(*s) for s in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    a, c = (ends[0] + ends[1]) / 2 - at, (ends[2] + ends[3]) / 2 - at
    p, q = (ends[0] - ends[1]) / 2, (ends[2] - ends[3]) / 2
    b = variance(1, 1) - at - a - c - p - q
    least = at - (c * p**2 - b * p * q + a * q**2) / (4 * a * c - b**2)
    # Of 400 draws of a chi square with ten, the mean is known to 2 %.
    assert np.mean(least) == pytest.approx(1, abs=0.06)
