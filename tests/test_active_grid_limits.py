"""How much it takes until pictures of an active grid are doubted, and how little."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.doubts import clipped_at, examine
from raxel.sets import plan_of_cells
from tests.active_grids import drawn


@pytest.mark.parametrize(("times", "clipped"), [(1, False), (3, False), (9, True)])
def test_values_that_are_many_times_as_frequent_are_where_a_camera_stops(
    times, clipped
):
    """Of a dark scene few pixels reach the top, and rounding makes them uneven."""
    values = np.repeat(np.arange(100, 201), 60)
    image = np.append(values, np.full(60 * (times - 1), 200)).astype(np.uint8)[None]
    found = clipped_at([image], [SimpleNamespace(kind="phase")])
    assert (found is not None) == clipped
    if clipped:
        assert found == (200, pytest.approx(60 * times / image.size))


@pytest.mark.parametrize(("offset", "moved"), [(0.003, False), (0.02, True)])
def test_sines_may_begin_a_little_off_their_code_and_no_more(offset, moved):
    """A fiftieth of a period is half a pixel here, and more than the blur explains."""
    plans = [plan_of_cells((200, 144), 8, 5, begin) for begin in (offset, 0.0)]
    one, stated = (
        drawn(plan=plan, size=(240, 180), noise=0.3, blur=1.0, seed=2) for plan in plans
    )
    found = decode(one.images, stated.patterns, one.grid)
    doubts = examine(one.images, stated.patterns, one.grid, found).doubts
    assert [("something moved" in doubt.text) for doubt in doubts] == 2 * [True] * moved
