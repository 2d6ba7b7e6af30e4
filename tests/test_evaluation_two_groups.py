"""Two groups of photographs: told where they are, as often by chance as is said."""

import numpy as np
import pytest

from raxel.evaluation.two_groups import two_groups

COUNT, SIZE = 10, 3
DIRECTION = np.array([1.0, -0.5, 2.0])


def equations(rng, apart=0.0, first=(), scale=1.0):
    """(normal, right) of photographs of which some ask for `apart` more along the
    direction; scale: of what moves their corners."""
    rows = rng.normal(size=(COUNT, 8, SIZE)) * rng.uniform(0.5, 2, (COUNT, 1, 1))
    own = np.array([0.3, 2.0, -1.0]) + apart * np.outer(
        np.isin(np.arange(COUNT), first), DIRECTION
    )
    seen = np.einsum("nmk,nk->nm", rows, own) + scale * rng.normal(size=(COUNT, 8))
    return np.einsum("nmi,nmj->nij", rows, rows), np.einsum("nmi,nm->ni", rows, seen)


@pytest.mark.parametrize("first", [(1, 4, 5, 8), (7,)])
def test_groups_are_found_in_any_order(first):
    rng = np.random.default_rng(1)
    found, p_value = two_groups(*equations(rng, 3.0, first), DIRECTION)
    group = set(np.flatnonzero(found))
    assert set(first) in (group, set(range(COUNT)) - group)
    assert p_value < 1e-3


def test_the_p_value_is_an_upper_bound_whatever_the_scatter():
    rng = np.random.default_rng(2)
    found = np.array(
        [two_groups(*equations(rng, scale=9.0), DIRECTION)[1] for _ in range(1500)]
    )
    for level in (0.02, 0.1, 0.3):
        assert np.mean(found < level) < level + 2 * np.sqrt(level / len(found))
    # And not far above, or it would tell of little.
    assert np.mean(found < 0.3) > 0.05


def test_what_all_share_divides_nobody_and_three_are_no_groups():
    normal, right = equations(np.random.default_rng(3))
    shared = normal @ np.array([5.0, -2.0, 7.0])
    first, p_value = two_groups(normal, right, DIRECTION)
    again, same = two_groups(normal, right + shared, DIRECTION)
    assert np.array_equal(first, again)
    assert same == pytest.approx(p_value)
    assert two_groups(normal[:3], right[:3], DIRECTION) == (None, 1.0)
