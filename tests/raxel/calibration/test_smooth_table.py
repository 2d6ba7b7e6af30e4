"""Smooth rays from noisy ones: least noise, honest uncertainty, the trend elsewhere."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.smooth import boards as smooth_trend
from raxel.calibration.smooth import table as smooth_module
from raxel.calibration.smooth.boards import trend_of_rays
from raxel.calibration.smooth.equations import (
    FieldSums,
    band_of,
    band_product,
    free_polynomials,
    node_places,
    penalty_matrix,
)
from raxel.calibration.smooth.table import smoothed_rays
from raxel.cameras.tables.interpolation import field_at, shares
from raxel.geometry.poses import pose, rotation_from_vector
from tests.raised import raises_code
from tests.smooth_fields import (
    LENS,
    SHAPE,
    SPACING,
    H,
    W,
    bent,
    misfit_px,
    noisy_rays,
    positions,
    rms,
)

TREND = LENS, np.eye(4)


def test_field_sums_equal_least_squares():
    rng = np.random.default_rng(1)
    pixels, values = positions(rng, 700), rng.normal(size=(700, 2))
    weights, part = rng.uniform(0, 2, 700), rng.integers(0, 3, 700)
    sums = FieldSums(W, H, SPACING, 3)
    sums.add(pixels, values, weights, part)
    index, share = shares(pixels, SHAPE, SPACING)
    design = np.zeros((700, np.prod(SHAPE)))
    np.put_along_axis(design, index, share, axis=1)
    for p in range(3):
        own = design[part == p]
        normal = own.T @ (weights[part == p, None] * own)
        band = sums.band([p])
        np.testing.assert_allclose(band_product(band, np.eye(len(normal))), normal)
        right = own.T @ (weights[part == p, None] * values[part == p])
        np.testing.assert_allclose(sums.right[p].reshape(-1, 2), right, atol=1e-12)
        control = rng.normal(size=(len(normal), 2))
        off = values[part == p] - own @ control
        np.testing.assert_allclose(
            sums.quadratic(p, control), np.sum(weights[part == p, None] * off**2)
        )


def test_penalty_ignores_cubic_polynomials():
    free, matrix = (free_polynomials(SHAPE), penalty_matrix(SHAPE))
    band = band_of(matrix, 3 * SHAPE[1] + 4)
    np.testing.assert_allclose(band_product(band, free), matrix @ free, atol=1e-12)
    # A plane bends nowhere: only the tie to zero counts.
    plane = free[:, [0, 1, 4]] @ [1.0, 2.0, 3.0]
    np.testing.assert_allclose(matrix @ plane, plane / 4, atol=1e-12)
    # Their fields are polynomials: degree 3 in the middle of the image's columns.
    control = np.stack([free[:, 3].reshape(SHAPE)] * 2, axis=2)
    pixels = np.column_stack([np.arange(0, W, 10.0), np.full(32, 50.0)])
    values = field_at(pixels, control, SPACING)[0][:, 0]
    x = ((pixels[:, 0] + 0.5) / SPACING + 1 - (SHAPE[1] - 1) / 2) / (SHAPE[1] - 1) * 2
    np.testing.assert_allclose(values, x**3, atol=1e-12)


def test_smooth_table_recovers_exact_rays():
    camera = bent()
    rng = np.random.default_rng(2)
    pixels, directions = noisy_rays(camera, rng, 3000, 0)
    found = smoothed_rays(pixels, directions, W, H, trend=TREND)
    fresh = positions(rng, 2000)
    assert rms(found.camera.displacement(fresh) - camera.displacement(fresh)) < 1e-6
    assert found.left_out == {"beyond the trend": 0, "gross error": 0}
    back = found.camera.project(50 * found.camera.rays(fresh).directions).pixels
    np.testing.assert_allclose(back, fresh, atol=1e-9)


def test_smooth_table_reduces_noise():
    """Normalised squared errors over ten draws, of cameras outside the prior."""
    errors, normalised, residuals = [], [], []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        camera = bent(seed=seed)
        pixels, directions = noisy_rays(camera, rng, 1000, 0.5)
        found = smoothed_rays(pixels, directions, W, H)
        fresh = positions(rng, 300)
        off = camera.project(found.camera.rays(fresh).directions).pixels - fresh
        stated = found.camera.pixel_covariance(fresh)
        errors.append(rms(off))
        normalised.append(np.mean(off**2 / stated[:, [0, 1], [0, 1]]))
        residuals.append(found.sd_px)
    assert np.median(errors) < 0.5 / 4
    assert 0.5 < np.mean(normalised) < 1.5
    np.testing.assert_allclose(np.mean(residuals), 0.5, rtol=0.05)


def test_correlated_errors_are_counted_once():
    """A table whose noise is alike in squares of 6 px: as if it had 36 times fewer."""
    camera, rng = bent(), np.random.default_rng(3)
    noise = 0.3 * rng.standard_normal((H // 6, W // 6 + 1, 2)).repeat(6, 0).repeat(6, 1)
    pixels = np.stack(np.meshgrid(np.arange(W), np.arange(H)), axis=-1)
    shifted = (pixels + noise[:, :W]).reshape(-1, 2).astype(float)
    directions = camera.rays(shifted).directions.reshape(H, W, 3)
    places = pixels.reshape(-1, 2).astype(float)
    found = smoothed_rays(places, directions.reshape(-1, 3), W, H)
    assert 15 < found.sharing < 60
    fresh = positions(rng, 2000)
    off = camera.project(found.camera.rays(fresh).directions).pixels - fresh
    stated = found.camera.pixel_covariance(fresh)[:, 0, 0].mean()
    assert 0.4 < rms(off) / np.sqrt(stated) < 1.6
    assert rms(off) < 0.05


def test_smooth_table_equals_trend_without_rays():
    camera, rng = bent(2.0), np.random.default_rng(4)
    pixels = positions(rng, 2000, width=W // 3)
    off = 0.01 * rng.standard_normal(pixels.shape)
    directions = camera.rays(pixels + off).directions
    found = smoothed_rays(pixels, directions, W, H, trend=TREND).camera
    far = np.column_stack([np.full(9, W - 10.0), np.linspace(5, H - 5, 9)])
    here, there = (np.abs(found.displacement(p)).max() for p in (pixels, far))
    assert there < 0.1 * here
    assert np.abs(camera.displacement(far)).max() > 1
    assert not found.covers(far).any()
    assert found.covers(pixels).all()
    near = found.pixel_covariance(pixels)[:, 0, 0].max()
    assert found.pixel_covariance(far)[:, 0, 0].min() > 100 * near


def test_smooth_table_rejects_and_counts_wrong_rays():
    camera, rng = bent(), np.random.default_rng(5)
    pixels, directions = noisy_rays(camera, rng, 3000, 0.2)
    directions[:90] = camera.rays(pixels[:90] + rng.uniform(10, 40, (90, 2))).directions
    kept = np.isfinite(directions[:, 0])
    found = smoothed_rays(pixels[kept], directions[kept], W, H)
    wrong = np.count_nonzero(kept[:90])
    assert wrong <= found.left_out["gross error"] <= wrong + 5
    assert rms(misfit_px(found.camera, camera, positions(rng, 500))) < 0.06


def test_smooth_table_accepts_any_frame(monkeypatch):
    """Some ten arrays as large as the table come and go, and nothing larger."""
    monkeypatch.setattr(smooth_module, "CELLS", (4, 8))
    camera = bent()
    T = pose(rotation_from_vector([0.3, -0.2, 1.0]), [5.0, 6.0, 7.0])
    pixels = np.stack(np.meshgrid(np.arange(W), np.arange(H)), axis=-1).reshape(-1, 2)
    rays = camera.rays(pixels.astype(float)).directions @ T[:3, :3].T
    given = pixels.astype(float), rays
    tracemalloc.start()
    found = smoothed_rays(*given, W, H, centre=T[:3, 3]).camera
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 500 * H * W
    seen = found.rays(pixels[::7].astype(float))
    np.testing.assert_allclose(seen.origins[0], T[:3, 3])
    gap = np.linalg.norm(seen.directions - rays[::7], axis=1)
    assert gap.max() * 120 < 1e-2  # 120 px per radian


def test_ray_trend_recovers_lens():
    pixels = positions(np.random.default_rng(7), 500)
    R = rotation_from_vector([0.2, 0.1, -0.4])
    found = trend_of_rays(pixels, LENS.rays(pixels).directions @ R.T, W, H)
    np.testing.assert_allclose(found.R_rays_trend, R, atol=1e-6)
    np.testing.assert_allclose(found.camera.principal_point, (162, 118), atol=1e-4)
    assert found.scale_px < 1e-6


def test_ray_trend_estimates_pixel_sd():
    rng = np.random.default_rng(11)
    pixels = positions(rng, 300)
    directions = LENS.rays(pixels).directions
    noisy = pixels + rng.normal(0, 0.2, pixels.shape)
    noisy[:6] += 40.0
    assert trend_of_rays(noisy, directions, W, H).scale_px == pytest.approx(
        0.2, rel=0.15
    )


def test_too_few_rays_and_two_centres_are_rejected():
    pixels, directions = noisy_rays(bent(), np.random.default_rng(8), 30, 0)
    with raises_code("too-few-rays"):
        smoothed_rays(pixels, directions, W, H)
    with raises_code("too-few-rays"):
        smoothed_rays(pixels, directions, W, H, trend=TREND)


def test_gross_error_threshold_uses_weight():
    rng, count = np.random.default_rng(21), 400
    weights = np.where(np.arange(count) % 2, 1.0, 100.0)
    values = rng.standard_normal((count, 2)) / np.sqrt(weights)[:, None]
    sums = SimpleNamespace(spacing=SPACING)
    field = SimpleNamespace(control=np.zeros((*SHAPE, 2)), sums=sums)
    pixels, off = positions(rng, count), [3.0, 0.0]
    values[:2] = off
    near = smooth_module._near(field, pixels, values, weights)
    assert not near[0]
    assert near[1:].all()
    # Nothing is wrong by a twentieth of a pixel, of whatever weight.
    values = np.where(np.arange(count)[:, None] % 9, 1e-4, 0.05) * np.ones(2)
    assert smooth_module._near(field, pixels, values, weights).all()


def test_field_nodes_are_corners_and_midpoints():
    places = node_places(SHAPE, SPACING)
    # Pixels are squares about whole numbers: the first cell begins at -1/2.
    np.testing.assert_array_equal(places[0, 0], [-0.5, -0.5])
    _, share = shares(places[::2, ::2].reshape(-1, 2), SHAPE, SPACING)
    share = share.reshape(-1, 4, 4).sum(axis=1)
    np.testing.assert_allclose(np.sort(share), [[0, 1 / 6, 1 / 6, 4 / 6]] * len(share))
    _, share = shares(places[1::2, 1::2].reshape(-1, 2), SHAPE, SPACING)
    share = share.reshape(-1, 4, 4).sum(axis=1)
    np.testing.assert_allclose(share, [[1 / 48, 23 / 48, 23 / 48, 1 / 48]] * len(share))


def test_held_out_distance_uses_both_axes():
    """Without cells it is how far the trend is off by weights; with them, the noise."""
    rng = np.random.default_rng(6)
    pixels, directions = noisy_rays(bent(), rng, 600, 0.2)
    weights = rng.uniform(0.5, 2, 600)
    found = smoothed_rays(pixels, directions, W, H, trend=TREND, weights=weights)
    assert found.n_rays == 600
    squares = np.sum((LENS.project(directions).pixels - pixels) ** 2, axis=1)
    off = np.sqrt(np.average(squares, weights=weights))
    assert found.held_out_px[0] == pytest.approx(off, rel=1e-6)
    assert found.held_out_px[found.cells] == pytest.approx(0.2 * 2**0.5, rel=0.1)


def test_sharing_counts_correlated_neighbours():
    """Whatever the squares' own errors are; also where they are those of a field."""
    rng, side = np.random.default_rng(12), 8
    across = W // side, H // side
    pixels = np.stack(np.meshgrid(np.arange(W), np.arange(H)), axis=-1).reshape(-1, 2)
    square = pixels // side
    own = rng.normal(size=(*across, 2)) + 3.0
    weights = rng.uniform(1, 2, across)[square[:, 0], square[:, 1]]
    control = rng.normal(size=(*SHAPE, 2))
    field = SimpleNamespace(control=control, sums=SimpleNamespace(spacing=SPACING))
    values = field_at(pixels.astype(float), control, SPACING)[0]
    values += own[square[:, 0], square[:, 1]]
    sharing = smooth_module._sharing(field, pixels, values, weights, side)
    assert sharing == pytest.approx(side**2)


def test_smooth_table_noise_of_few_rays_is_unbiased():
    """Of 60 rays the field takes a third."""
    found, smoothness = [], 1e-3
    for seed in range(10):
        rng = np.random.default_rng(20 + seed)
        pixels, values = positions(rng, 60), 0.5 * rng.standard_normal((60, 2))
        sums = FieldSums(W, H, W / 4, 5)
        sums.add(pixels, values, np.ones(60), np.arange(60) % 5)
        normal = sums.band(slice(None)) + smooth_module._penalty(sums, smoothness)
        control = smooth_module._solved(normal, sums.right.sum(axis=0).reshape(-1, 2))
        control = control.reshape(*sums.shape, 2)
        field = smooth_module._Field(4, sums, smoothness, control, {})
        found.append(smooth_module._uncertainty(field)[0])
    # Of 800 numbers, the deviation is known to 2.5 %.
    assert rms(found) == pytest.approx(0.5, rel=0.07)


@pytest.mark.parametrize(("share", "passes"), [(0.9, False), (1.1, True)])
def test_trend_law_is_limited_to_pi(share, passes):
    """r = 50 (theta + theta^3 / 100) px from the middle, the corners so far away."""
    values = np.array([0, 0, 0, 7.0, 9.0, np.log(50), np.log(50), 1.0, 0.01])
    corner = share * 50 * (np.pi + np.pi**3 / 100)
    assert smooth_trend._passes_pi(values, np.array([[7.0, 9 + corner]])) == passes
