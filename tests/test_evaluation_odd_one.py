"""One photograph that tells of another camera than all others do."""

import numpy as np
import pytest

from raxel.evaluation.odd_one import odd_one
from tests.test_evaluation_stability import CAMERA, COUNT, found_in, lens, views_of


def equations(rng, together=0.0, odd=0.0, boards=10, ways=6):
    """Of corrections that are nought, each board erring by `together` for itself, and
    the fourth by `odd`."""
    shapes = rng.normal(size=(boards, 40, ways))
    own = together * rng.normal(size=(boards, ways))
    own[3] += odd
    off = rng.normal(size=(boards, 40)) + np.einsum("nmk,nk->nm", shapes, own)
    normal = np.einsum("nmk,nml->nkl", shapes, shapes)
    return normal, np.einsum("nmk,nm->nk", shapes, off)


@pytest.mark.parametrize("together", [0.0, 1.0])
def test_no_photograph_is_odd_more_often_than_it_says(together):
    rng = np.random.default_rng(7)
    found = [odd_one(*equations(rng, together), 1.0).p_value for _ in range(60)]
    assert np.mean(np.less(found, 0.1)) < 0.2
    assert np.min(found) > 1e-4
    # Moved each way by six times what others are.
    far = [odd_one(*equations(rng, together, 6 * together + 1), 1.0) for _ in range(5)]
    assert [each.index for each in far] == 5 * [3]
    assert np.max([each.p_value for each in far]) < 1e-3


def test_what_it_moves_is_what_a_fit_without_it_says():
    normal, right = equations(np.random.default_rng(8), odd=3.0)
    found, rest = odd_one(normal, right, 1.0), np.arange(10) != 3
    whole, without = (
        np.linalg.solve(normal[part].sum(axis=0), right[part].sum(axis=0))
        for part in (slice(None), rest)
    )
    np.testing.assert_allclose(found.change, without - whole, atol=1e-9)
    inverse, of_rest = (
        np.linalg.inv(normal[part].sum(axis=0)) for part in (slice(None), rest)
    )
    np.testing.assert_allclose(found.spread, of_rest - inverse, atol=1e-9)


def test_photographs_that_tell_nothing_are_none():
    assert odd_one(np.zeros((6, 3, 3)), np.zeros((6, 3)), 1.0) is None


def test_a_photograph_by_another_zoom_is_named():
    cameras = 4 * [CAMERA] + [lens(371.0)] + (COUNT - 5) * [CAMERA]
    found = found_in(views_of(cameras, 1), CAMERA)
    assert found.odd.name == "4.png"
    assert found.odd.rays_px > 0.1
    assert not found.stable
