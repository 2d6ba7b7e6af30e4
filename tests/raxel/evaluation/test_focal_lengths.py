"""Images that differ more in one correction than in all others."""

import numpy as np
import pytest

from raxel.evaluation.misfit import focal_lengths

COUNT, WAYS = 14, 12


def equations(rng, own=0.0, together=1.0, count=COUNT):
    """Equations of images that each require a first correction of its own, of SD
    `own`; together: how many times as far as scatter explains all else differs."""
    slopes = rng.normal(size=(count, 40, WAYS)) * rng.uniform(0.3, 3, (count, 1, 1))
    asked = np.zeros((count, WAYS))
    asked[:, 0] = own * rng.normal(size=count)
    off = together * rng.normal(size=(count, 40)) + np.einsum(
        "nik,nk->ni", slopes, asked
    )
    return np.swapaxes(slopes, 1, 2) @ slopes, np.einsum("nik,ni->nk", slopes, off)


FIRST = np.eye(WAYS)[0]
NAMES = [f"{k}" for k in range(COUNT)]


def spread(normal, right, direction):
    return focal_lengths(normal, right, direction, 1.0, np.array(NAMES))


@pytest.mark.parametrize("together", [1.0, 3.0])
def test_focal_p_value_has_its_nominal_rate(together):
    """However far they differ, and not much more seldom."""
    rng = np.random.default_rng(1)
    found = [spread(*equations(rng, 0, together), FIRST) for _ in range(400)]
    p_values = np.array([each.p_value for each in found])
    for p in (0.1, 0.5):
        assert 0.3 < np.mean(p_values < p) / p < 1.1
    assert p_values.min() > 1e-4
    assert np.mean([each.times for each in found]) == pytest.approx(1, abs=0.1)


def test_focal_length_sd_is_estimated():
    rng = np.random.default_rng(2)
    found = [spread(*equations(rng, 0.5, 2.0), FIRST) for _ in range(100)]
    assert np.sqrt(np.mean([f.sd**2 for f in found])) == pytest.approx(0.5, rel=0.1)
    # In the unit of the direction.
    longer = spread(*equations(np.random.default_rng(3), 0.5), 2 * FIRST)
    once = spread(*equations(np.random.default_rng(3), 0.5), FIRST)
    assert longer.sd == pytest.approx(once.sd / 2)
    assert longer.p_value == pytest.approx(once.p_value)


def test_other_corrections_do_not_vary_the_focal_length():
    rng = np.random.default_rng(4)
    normal, right = equations(rng, 1.0)
    assert spread(normal, right, FIRST).p_value < 1e-12
    assert spread(normal, right, np.eye(WAYS)[1]).p_value > 1e-3
    normal, right = equations(rng)
    shared = right + 100 * normal @ FIRST
    alone, moved = (spread(normal, each, FIRST) for each in (right, shared))
    assert moved.p_value == pytest.approx(alone.p_value)
    assert spread(normal[:3], right[:3], FIRST) is None


def test_focal_length_groups_are_named():
    rng = np.random.default_rng(5)
    normal, right = equations(rng)
    long = [1, 4, 5, 11]
    right[long] += 2 * normal[long] @ FIRST
    found = spread(normal, right, FIRST)
    assert {int(name) for name in found.longer} == set(long)
    assert {*found.shorter, *found.longer} == set(NAMES)
