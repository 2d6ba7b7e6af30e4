"""Share of a board in a partial detection, for any first corner."""

import numpy as np
import pytest

from raxel.evaluation.cross_validation import share_in_order
from raxel.features.detector import Partial

CORNERS = np.stack(np.meshgrid(np.arange(9), np.arange(6)), axis=-1).reshape(-1, 2)
CORNERS = 20.0 * CORNERS + 30.0
SHAPE = (200, 260)


def part(rows, columns, turned=False):
    """A Partial of these rows and columns of CORNERS."""
    i, j = (a.ravel() for a in np.meshgrid(rows, columns, indexing="ij"))
    indices = np.column_stack([i, j]) - [min(rows), min(columns)]
    if turned:
        indices = indices[:, ::-1] * [1, -1] + [0, max(rows)]
    return Partial(CORNERS[9 * i + j], indices)


@pytest.mark.parametrize("turned", [False, True])
def test_share_in_order_accepts_any_first_corner(turned):
    seen = part(range(6), range(1, 9), turned)
    share = share_in_order(seen, CORNERS, 9, SHAPE, 1.0)
    assert share == pytest.approx(48 / 54)


def test_share_in_order_excludes_wrong_order():
    seen = part(range(6), range(9))
    seen.indices[:9] += [0, 3]
    share = share_in_order(seen, CORNERS, 9, SHAPE, 1.0)
    assert share == pytest.approx(45 / 54)
    assert share_in_order(None, CORNERS, 9, SHAPE, 1.0) == 0


def test_share_in_order_requires_image_and_reach():
    seen = part(range(6), range(9))
    narrow = (200, 180)
    assert share_in_order(seen, CORNERS, 9, narrow, 1.0) == 1
    assert share_in_order(part(range(6), range(4)), CORNERS, 9, narrow, 1.0) == (
        pytest.approx(4 / 8)
    )
    seen.corners[5] += [1.1, 0]
    assert share_in_order(seen, CORNERS, 9, SHAPE, 1.0) == pytest.approx(53 / 54)
    assert share_in_order(seen, CORNERS + 500, 9, SHAPE, 1.0) == 0


def test_border_has_the_same_width_on_all_sides():
    """Corners 4 px from the outermost pixels need not be found, those farther in do."""
    frame = CORNERS - CORNERS[0] + [4.0, 4.0]
    shape = 100 + 4 + 4 + 1, 160 + 4 + 4 + 1
    inner = part(range(1, 5), range(1, 8))
    inner = Partial(inner.corners - CORNERS[0] + 4.0, inner.indices)
    assert share_in_order(inner, frame, 9, shape, 1.0) == 1
    # Of a side that moves in, all but both ends.
    for off, more in (([0.1, 0], 4), ([-0.1, 0], 4), ([0, 0.1], 7), ([0, -0.1], 7)):
        found = share_in_order(inner, frame + off, 9, shape, 1.0)
        assert found == pytest.approx(28 / (28 + more))
