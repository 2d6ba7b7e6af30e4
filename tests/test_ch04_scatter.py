"""Section 4.3.2: what its claims of the scatter ask."""

import numpy as np
import pytest

from chapters.ch04_central_generic.s3_2_results import claims
from tests.judged_claims import verdict


@pytest.mark.parametrize(
    ("below", "outcome"), [(0, "reproduced"), (2, "undecided"), (12, "differs")]
)
def test_a_caustic_bounds_the_scatter_from_below(below, outcome):
    caustic = np.full(50, 0.2)
    scatter = np.where(np.arange(50) < below, 0.19, 0.7)
    found = {"scatter_mm": scatter, "caustic_mm": caustic}
    assert verdict(claims.judge_caustic, "exp_c4_caustic_floor", found) == outcome


def test_a_camera_without_a_caustic_has_no_bound():
    found = {"scatter_mm": np.full(50, 0.1), "caustic_mm": np.zeros(50)}
    with np.errstate(divide="ignore"):
        made = verdict(claims.judge_caustic, "exp_c4_caustic_floor", found)
    assert made == "differs"
