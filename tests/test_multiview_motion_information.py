"""What a motion's information says of its parts."""

import numpy as np
import pytest

from raxel.multiview.motion_information import MotionInformation


def test_deviations_are_roots_of_summed_variances():
    told = np.diag(np.array([1.0, 2, 4, 5, 10, 20]) ** 2)
    found = MotionInformation(told, 10.0, np.zeros(3), 1.0)
    rotation = np.sqrt(1 + 1 / 4 + 1 / 16)
    direction = np.sqrt(1 / 25 + 1 / 100)
    assert found.rotation_sd == pytest.approx(rotation)
    assert found.direction_sd == pytest.approx(direction)
    assert found.scale_sd == pytest.approx(1 / 20)
    assert found.with_length == pytest.approx((rotation, direction))


@pytest.mark.parametrize("aside", [3, 4])
def test_a_length_that_is_known_tells_of_the_directions_it_is_mixed_up_with(aside):
    """Of a variance 1 / 0.64, shared with a number that becomes known, 1 is left."""
    told = np.eye(6)
    told[aside, 5] = told[5, aside] = 0.6
    found = MotionInformation(told, 10.0, np.zeros(3), 1.0)
    assert found.direction_sd == pytest.approx(np.sqrt(1 + 1 / 0.64))
    assert found.with_length == pytest.approx((np.sqrt(3), np.sqrt(2)))
