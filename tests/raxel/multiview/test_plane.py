"""Pictures laid out on the plane that an active grid lay in."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.geometry import pixel_cells
from raxel.geometry.pixel_cells import whole_cells
from raxel.multiview.views import _add_triangle, plane_scale, remap_to_plane

SIZE_MM = 60.0, 40.0
FINE, COARSE = 0.5, 4.0  # mm per px of the new image


def on_plane(width=120, height=90):
    """Points that a tilted, distorting camera sees: (H, W, 2) mm."""
    v, u = np.indices((height, width)) / width
    depth = 0.7 + 0.3 * u - 0.1 * v
    bend = 1 + 0.2 * ((u - 0.5) ** 2 + (v - 0.4) ** 2)
    return np.stack([80 * u * bend / depth - 6, 76 * v * bend / depth - 5], axis=-1)


def light(x, y):
    return 100 + 1.2 * x - 0.8 * y


def in_the_middle(result, mm_per_px):
    v, u = np.indices(result.shape[:2])
    return mm_per_px * (u + 0.5), mm_per_px * (v + 0.5)


@pytest.mark.parametrize("mm_per_px", [FINE, COARSE])
def test_remap_reproduces_linear_image(mm_per_px):
    location = on_plane()
    image = np.stack([light(*np.moveaxis(location, 2, 0)), location[..., 0]], axis=-1)
    result, seen = remap_to_plane(image, location, None, None, SIZE_MM, mm_per_px)
    assert result.shape == (40 / mm_per_px, 60 / mm_per_px, 2)
    assert seen.mean() > 0.95
    x, y = in_the_middle(result, mm_per_px)
    inside = seen & (np.minimum(x, SIZE_MM[0] - x) > COARSE)
    inside &= np.minimum(y, SIZE_MM[1] - y) > COARSE
    assert np.allclose(result[inside, 0], light(x, y)[inside], atol=1e-4)
    assert np.allclose(result[inside, 1], x[inside], atol=1e-4)
    assert not result[~seen].any()


def test_remap_averages_fine_pattern():
    location = on_plane(600, 450)
    stripes = 100 + 80 * np.sin(2 * np.pi * location[..., 0])
    result, seen = remap_to_plane(stripes, location, None, None, SIZE_MM, 1.0)
    assert np.abs(result[1:-1, 1:-1][seen[1:-1, 1:-1]] - 100).max() < 3


def test_remap_does_not_fill_unseen_areas():
    location = on_plane()
    mask = np.ones(location.shape[:2], bool)
    mask[30:50, 40:60] = False
    hole = location[30:50, 40:60].reshape(-1, 2)
    image = np.full(mask.shape, 200, np.uint8)
    result, seen = remap_to_plane(image, location, None, mask, (90.0, 40.0), FINE)
    assert result.dtype == np.uint8
    assert (result[seen] == 200).all()
    x, y = in_the_middle(result, FINE)
    for place in hole[:: len(hole) // 9]:
        assert not seen[np.hypot(x - place[0], y - place[1]) < 0.3].any()
    assert not seen[x > np.nanmax(location[..., 0])].any()
    masked = np.where(mask[..., None], location, np.nan)
    assert np.array_equal(
        seen, remap_to_plane(image, masked, None, None, (90.0, 40.0), FINE)[1]
    )


def test_plane_scale_limits_image_size():
    location = facets()
    size, mm_per_px = plane_scale(location)
    assert size == pytest.approx((24 + 0.6 * 49, 39.6))
    assert mm_per_px == pytest.approx(0.55, abs=0.051)  # 0.6 along u, 0.5 along v
    mask = np.arange(100) < 50
    assert plane_scale(location, np.tile(mask, (80, 1)))[0][0] == pytest.approx(29.7)
    size, mm_per_px = plane_scale(location * [1, 1e4])
    assert np.prod(size) / mm_per_px**2 == pytest.approx(4 * 80 * 100)


def facets():
    """Two adjacent facets: the right one sees its part of the plane mirrored,
    from 24 mm on, of which the left one sees up to 30."""
    v, u = np.indices((80, 100))
    x = np.where(u < 50, 0.6 * u + 0.3, 24 + 0.6 * (99 - u))
    return np.stack([x, 0.5 * v + 0.1], axis=-1)


def test_remap_averages_facets_by_sigma():
    location = facets()
    cells = whole_cells(location)
    assert not cells[:, 49].any()
    assert cells[:, :49].all()
    assert cells[:, 50:].all()
    sigma = np.full(location.shape, 0.01)
    sigma[:, 50:] = 0.02
    image = np.where(np.arange(100) < 50, 50.0, 100.0) * np.ones((80, 1))
    result, seen = remap_to_plane(image, location, sigma, None, (60.0, 40.0), 0.5)
    x, _ = in_the_middle(result, 0.5)
    only_left, both, only_right = x < 23.5, (x > 24.5) & (x < 29), x > 30.5
    assert np.allclose(result[seen & only_left], 50)
    assert np.allclose(result[seen & both], (4 * 50 + 100) / 5)
    assert np.allclose(result[seen & only_right], 100)
    assert seen[5:-5][:, 2:106].all()


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_whole_cells_are_independent_of_unit_and_blocks(unit, monkeypatch):
    rng = np.random.default_rng(6)
    location = on_plane()
    sigma = rng.uniform(0, 0.3, location.shape)
    location = location + rng.normal(0, 3, location.shape) * (
        rng.random(location.shape) < 0.1
    )
    cells = whole_cells(location, sigma)
    assert 0.1 < cells.mean() < 0.9
    monkeypatch.setattr(pixel_cells, "ROWS_PER_BLOCK", pixel_cells.TILE_PX)
    np.testing.assert_array_equal(whole_cells(unit * location, unit * sigma), cells)


def test_uncertain_pixel_makes_no_hole():
    location = on_plane()
    sigma = np.zeros(location.shape)
    location[20, 30] += 1.5 * np.median(np.diff(location[..., 0], axis=1)) * 3
    assert not whole_cells(location, sigma)[19:21, 29:31].any()
    sigma[20, 30] = np.ptp(location[20, 29:31])
    assert whole_cells(location, sigma)[19:21, 29:31].all()


def test_noise_makes_no_holes():
    rng = np.random.default_rng(5)
    location = on_plane()
    sigma = np.full(location.shape, 0.3)
    noisy = location + rng.normal(0, sigma)
    assert whole_cells(noisy, sigma).all()
    image = light(*np.moveaxis(location, 2, 0))
    result, seen = remap_to_plane(image, noisy, sigma, None, SIZE_MM, FINE)
    x, y = in_the_middle(result, FINE)
    assert seen[2:-2, 2:-2].all()
    assert np.sqrt(np.mean((result - light(x, y))[2:-2, 2:-2] ** 2)) < 0.5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"image": np.zeros((9, 9))}, "location: found 90 x 120 pixels"),
        ({"sigma": np.zeros((90, 9, 2))}, "sigma: found 90 x 9 pixels"),
        ({"mask": np.ones((9, 120), bool)}, "mask: found 9 x 120 pixels"),
        ({"mask": np.zeros((90, 120), bool)}, "no four neighbouring pixels"),
        ({"size_mm": (0.1, 40.0)}, "less than one pixel"),
    ],
)
def test_remap_rejects_invalid_input(change, message):
    given = {
        "image": np.zeros((90, 120)),
        "location": on_plane(),
        "sigma": None,
        "mask": None,
        "size_mm": SIZE_MM,
        "mm_per_px": FINE,
    }
    with pytest.raises(InputError, match=message):
        remap_to_plane(**given | change)


def test_triangle_weights_are_linear():
    places = np.array([[[0.0, 0.0], [8.0, 1.0]], [[1.0, 9.0], [9.0, 9.0]]])
    weights, values = places @ [0.5, 0.25] + 1, places[..., :1] - 2 * places[..., 1:]
    sums, hit = np.zeros((10, 10, 2)), np.zeros((10, 10), bool)
    _add_triangle(places, values, weights, ((0, 0), (0, 1), (1, 0)), 1, sums, hit)
    y, x = np.nonzero(hit)
    assert len(x) > 30
    np.testing.assert_allclose(sums[hit, 1], 0.5 * x + 0.25 * y + 1)
    np.testing.assert_allclose(sums[hit, 0], sums[hit, 1] * (x - 2.0 * y), atol=1e-9)
