"""Enough boards have to be tilted against each other, pairwise."""

import numpy as np
import pytest

from raxel.calibration.views.correspondence import check_tilts
from raxel.geometry import rotation_from_vector
from tests.raised import raises_code


def tilted(*degrees):
    """Boards turned about x by these angles, and about their own normal at random."""
    rng = np.random.default_rng(0)
    spins = rotation_from_vector(rng.uniform(0, 3, (len(degrees), 1)) * [[0, 0, 1.0]])
    return rotation_from_vector(np.radians(degrees)[:, None] * [[1.0, 0, 0]]) @ spins


@pytest.mark.parametrize(
    ("degrees", "needed", "rejected"),
    [
        ((0, 0.5, 1, 1.4), 2, True),
        ((0, 7, 1, 0.5), 2, False),
        ((0, 7, 1, 0.5), 3, True),
        ((0, 7, -7, 0.5), 3, False),
        ((0, 180, 179, 1), 3, True),
    ],
)
def test_tilt_check_counts_tilted_boards(degrees, needed, rejected):
    if rejected:
        with raises_code("parallel-grids"):
            check_tilts(tilted(*degrees), "method", needed)
    else:
        assert check_tilts(tilted(*degrees), "method", needed) is None
