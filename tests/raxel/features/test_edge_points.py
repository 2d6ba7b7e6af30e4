"""Sub-pixel edge localisation: unbiased, with valid predicted deviations."""

import numpy as np
import pytest
from scipy.special import ndtr

from raxel.errors import InputError
from raxel.features.edge_profiles import edge_points

MIDDLE = np.array([30.3, 24.7])


def line_image(angle, off, blur=0.6, low=40.0, high=200.0, shape=(50, 60)):
    """Image of an edge `off` px from MIDDLE along its normal, and the normal.

    Grey levels are means over 5 x 5 samples of each pixel.
    """
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    normal = np.array([np.cos(angle), np.sin(angle)])
    steps = (np.arange(5) - 2) / 5
    total = np.zeros(shape)
    for across in steps:
        for down in steps:
            t = (u + across - MIDDLE[0]) * normal[0] + (v + down - MIDDLE[1]) * normal[
                1
            ]
            total += low + (high - low) * ndtr((t - off) / blur)
    return total / 25, normal


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.78, 2.0, 4.4])
@pytest.mark.parametrize("off", [-2.2, -0.4, 0.0, 1.7])
def test_edge_points_are_unbiased_at_any_angle(angle, off):
    image, normal = line_image(angle, off)
    for sense in (image, 255 - image):
        found = edge_points(sense, MIDDLE[None], 3 * normal[None])
        assert found.found.all()
        assert (found.pixels[0] - MIDDLE) @ normal == pytest.approx(off, abs=2e-3)
        # A pixel smooths by a twelfth of its area, whatever the lens does.
        assert found.blur[0] == pytest.approx(np.hypot(0.6, 12**-0.5), abs=0.02)


def test_edge_point_errors_match_sigma():
    rng = np.random.default_rng(8)
    image, normal = line_image(0.5, 0.3)
    along = np.array([-normal[1], normal[0]])
    places = MIDDLE + np.arange(-16, 17, 4)[:, None] * along
    pulls = []
    for _ in range(40):
        noisy = image + rng.normal(0, 4, image.shape)
        found = edge_points(noisy, places, np.tile(normal, (len(places), 1)))
        pulls.append(((found.pixels - places) @ normal - 0.3) / found.sigma)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.12)


def test_edge_points_without_edge_are_not_found():
    rng = np.random.default_rng(9)
    image, normal = line_image(0.2, 0.0)
    flat = 100 + rng.normal(0, 2, image.shape)
    normals = np.tile(normal, (4, 1))
    places = np.array([MIDDLE, [np.nan, 3], [1, 20], MIDDLE + 9 * normal])
    found = edge_points(image, places, normals)
    np.testing.assert_array_equal(found.found, [True, False, False, False])
    assert np.isnan(found.pixels[1:]).all()
    assert not edge_points(flat, places, normals).found.any()
    assert not edge_points(np.full((50, 60), 7), places, normals).found.any()
    assert len(edge_points(image, np.empty((0, 2)), np.empty((0, 2))).found) == 0


def test_edge_points_reject_invalid_input():
    places = np.array([MIDDLE])
    with pytest.raises(InputError, match=r"\(9, 9, 3\)"):
        edge_points(np.zeros((9, 9, 3)), places, places)
    with pytest.raises(InputError, match=r"\+-1 x"):
        edge_points(np.zeros((50, 60)), places, places, half_across=1)


def test_edge_points_sigma_holds_for_few_pixels():
    """With a dozen pixels, four parameters absorb a third of the noise."""
    rng = np.random.default_rng(10)
    image, normal = line_image(0.5, 0.3)
    along = np.array([-normal[1], normal[0]])
    places = MIDDLE + np.arange(-18, 19, 3)[:, None] * along
    normals, off, sigma = np.tile(normal, (len(places), 1)), [], []
    for _ in range(40):
        noisy = image + rng.normal(0, 4, image.shape)
        found = edge_points(noisy, places, normals, 2.5, 1.0)
        off.append(((found.pixels - places) @ normal - 0.3)[found.found])
        sigma.append(found.sigma[found.found])
    variances = [np.mean(np.square(np.concatenate(x))) for x in (off, sigma)]
    assert variances[0] / variances[1] == pytest.approx(1, abs=0.2)
