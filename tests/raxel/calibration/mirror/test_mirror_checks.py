"""Rejected mirror images: positions of the monitor, and clamps."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.mirror.stages import check_clamp_line, check_distinct_positions
from raxel.cameras import PerspectiveCamera
from raxel.errors import InputError
from tests.raised import raises_code

VIEWER = PerspectiveCamera([[100, 0, 0], [0, 100, 0], [0, 0, 1]], [], 100, 100)


def monitors():
    """Three images of a monitor; the first one lacks a corner."""
    points = np.array([[0.0, 0], [30, 0], [0, 60], [900, 900]])
    pixels = np.ones((4, 2))
    pixels[3] = np.nan
    return [
        SimpleNamespace(name=name, points=points, pixels=pixels)
        for name in ("near", "middle", "far")
    ]


@pytest.mark.parametrize(("apart_mm", "rejected"), [(9.9, True), (10.1, False)])
def test_monitor_positions_need_minimum_distance(apart_mm, rejected):
    asked = []

    def motion(first, second, point):
        asked.append(point)
        far = apart_mm if (first, second) == (0, 2) else 80.0
        return SimpleNamespace(distance=far)

    if rejected:
        with raises_code("same-place"):
            check_distinct_positions(SimpleNamespace(motion=motion), monitors())
    else:
        check_distinct_positions(SimpleNamespace(motion=motion), monitors())
        assert len(asked) == 3
    # In the middle of what is seen.
    np.testing.assert_allclose(asked, np.tile([10.0, 20.0], (len(asked), 1)))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("share", "hidden", "rejected"),
    [
        (0.01, False, False),
        (0.04, False, True),
        (0.12, True, False),
        (0.18, True, True),
    ],
)
def test_hidden_clamp_line_allows_more_mirror_beyond(share, hidden, rejected, turned):
    """A monitor that fills the image, clamped at its left or lower side."""
    u, v = np.meshgrid(np.arange(100.0), np.arange(100.0))
    view = SimpleNamespace(pixels=np.column_stack([u.ravel(), v.ravel()]))
    place = 99.5 - 100 * share if turned else 100 * share - 0.5
    along = np.array([[0.0, 99.0], [place, place]])
    ends = (along if turned else along[::-1]).T / 100
    line = SimpleNamespace(angle=np.pi / 2 if turned else 0.0, ends=ends)
    if rejected:
        with pytest.raises(InputError, match=f"{100 * share:.0f} % of the pixels"):
            check_clamp_line(line, VIEWER, [view], hidden)
    else:
        check_clamp_line(line, VIEWER, [view], hidden)
