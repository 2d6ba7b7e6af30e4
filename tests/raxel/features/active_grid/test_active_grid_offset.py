"""Sines that begin elsewhere than at the monitor's border, as cosines do."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.diagnostics import examine
from raxel.sets import plan_of_cells
from tests.active_grids import drawn

MONITOR = 200, 144


@pytest.mark.parametrize("offset", [0.25, -0.4])
@pytest.mark.parametrize("steps", [3, 4, 5])
def test_offset_does_not_change_positions(steps, offset):
    one = drawn(plan=plan_of_cells(MONITOR, 8, steps, offset), noise=1.0, blur=1.0)
    found = decode(one.images, one.patterns, one.grid)
    error = np.abs(found.location - one.true)[found.mask]
    # Pixels at a cell's edge are half a period or more off where the phase is.
    assert np.max(error / found.sigma[found.mask]) < 6
    assert found.mask.mean() > 0.45
    assert examine(one.images, one.patterns, one.grid, found).diagnostics == []
