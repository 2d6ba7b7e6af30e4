"""One image that gives another camera than all others do."""

import numpy as np
import pytest

from raxel.evaluation.split_half import _difference
from tests.raxel.evaluation.test_split_half import (
    CAMERA,
    COUNT,
    found_in,
    lens,
    views_of,
)


def equations(rng, together=0.0, odd=0.0, boards=10, ways=6):
    """Of corrections that are nought, each board erring by `together` for itself, and
    the fourth by `odd`."""
    shapes = rng.normal(size=(boards, 40, ways))
    own = together * rng.normal(size=(boards, ways))
    own[3] += odd
    off = rng.normal(size=(boards, 40)) + np.einsum("nmk,nk->nm", shapes, own)
    normal = np.einsum("nmk,nml->nkl", shapes, shapes)
    return normal, np.einsum("nmk,nm->nk", shapes, off)


def p_values(rng, together, odd=0.0):
    """Of each image against all others."""
    normal, right = equations(rng, together, odd)
    alone = np.eye(len(right), dtype=bool)
    return [_difference(normal, right, first, 1.0)[-1] for first in alone]


@pytest.mark.parametrize("together", [0.0, 1.0])
def test_no_image_is_an_outlier_more_often_than_expected(together):
    rng = np.random.default_rng(7)
    found = [10 * min(p_values(rng, together)) for _ in range(60)]
    assert np.mean(np.less(found, 0.1)) < 0.2
    assert np.min(found) > 1e-4
    # Moved in each direction by six times what others are.
    far = [p_values(rng, together, 6 * together + 1) for _ in range(5)]
    assert np.argmin(far, axis=1).tolist() == 5 * [3]
    assert 10 * np.max(np.min(far, axis=1)) < 1e-3


def test_difference_is_that_of_two_fits():
    normal, right = equations(np.random.default_rng(8), odd=3.0)
    first = np.arange(10) == 3
    root, x, _, _ = _difference(normal, right, first, 1.0)
    one, others = (
        np.linalg.solve(normal[part].sum(axis=0), right[part].sum(axis=0))
        for part in (first, ~first)
    )
    np.testing.assert_allclose(root @ x, one - others, atol=1e-9)
    inverses = [np.linalg.inv(normal[part].sum(axis=0)) for part in (first, ~first)]
    np.testing.assert_allclose(root @ root.T, sum(inverses), atol=1e-9)


def test_images_without_information_give_no_difference():
    nothing = np.zeros((6, 3, 3)), np.zeros((6, 3))
    assert _difference(*nothing, np.arange(6) == 0, 1.0) is None


def test_outlier_image_with_another_zoom_is_named():
    cameras = 4 * [CAMERA] + [lens(371.0)] + (COUNT - 5) * [CAMERA]
    found = found_in(views_of(cameras, 1), CAMERA)
    assert found.outlier.name == "4.png"
    assert found.outlier.rays_px > 0.1
    assert not found.stable
