"""Numbers as people read them."""

import math

import pytest

from repro.page.wording import rounded


@pytest.mark.parametrize(
    ("number", "interval", "text"),
    [
        (1.2345, (1.1, 1.4), "1.23 mm (1.10 to 1.40)"),
        (1.2327, (1.1834, math.inf), "1.23 mm (1.18 to no bound)"),
        (math.inf, (2.0, math.inf), "no bound (2 to no bound)"),
        (-0.5, (-math.inf, 3.25), "-0.5 mm (no bound to 3.25)"),
    ],
)
def test_infinite_end_is_no_bound(number, interval, text):
    assert rounded(number, interval, "mm") == text
