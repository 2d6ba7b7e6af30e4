"""What a motion's information says of its parts."""

import numpy as np
import pytest

from raxel.multiview.generalised_motion import MotionInformation


def test_information_sds_are_roots_of_summed_variances():
    reported = np.diag(np.array([1.0, 2, 4, 5, 10, 20]) ** 2)
    found = MotionInformation(reported, 10.0, np.zeros(3), 1.0)
    rotation = np.sqrt(1 + 1 / 4 + 1 / 16)
    direction = np.sqrt(1 / 25 + 1 / 100)
    assert found.rotation_sd == pytest.approx(rotation)
    assert found.direction_sd == pytest.approx(direction)
    assert found.scale_sd == pytest.approx(1 / 20)
