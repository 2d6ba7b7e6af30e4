"""The plan of an active grid's patterns, and the images that a monitor is sent."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.lab import MonitorPattern
from raxel.lab.scenes import MonitorBoard
from raxel.sets import pattern_image, patterns_of, plan_of_cells
from raxel.sets.model import ActiveGrid, MonitorChessboard, Pattern
from raxel.sets.patterns import cell_width, chessboard_image, chessboard_of_corners


def read_code(images):
    """Cell numbers from Gray images, most significant first."""
    bits = np.cumsum([image > 127 for image in images], axis=0) % 2
    return sum(bit << (len(bits) - 1 - k) for k, bit in enumerate(bits))


def test_thesis_plan_has_twenty_patterns():
    patterns = patterns_of(plan_of_cells((1024, 768), phase_steps=4))
    assert len(patterns) == 20
    assert sum(p.kind == "gray" for p in patterns) == 12
    assert {p.periods for p in patterns if p.kind == "phase"} == {8}
    assert len({p.image for p in patterns}) == 20


@pytest.mark.parametrize("size", [(1024, 768), (1366, 773), (97, 61)])
@pytest.mark.parametrize("cells", [8, 5, (12, 3)])
def test_cells_and_sines_start_together(size, cells):
    """Whole pixels for each cell, a code longer than the monitor, any count."""
    plan = plan_of_cells(size, cells, 5)
    for axis, count in zip("xy", np.broadcast_to(cells, 2), strict=True):
        own = [p for p in patterns_of(plan) if p.axis == axis]
        gray = [p for p in own if p.kind == "gray" and not p.inverse]
        phase = [p for p in own if p.kind == "phase"]
        width = cell_width(gray[0], size)
        assert width == int(width)
        assert len(phase) == 5
        pixels = size["xy".index(axis)]
        assert pixels / phase[0].periods == pytest.approx(width)
        shown = read_code([pattern_image(p, size) for p in gray])
        line = shown[0] if axis == "x" else shown[:, 0]
        np.testing.assert_array_equal(line, np.arange(pixels) // int(width))
        assert line[-1] == np.ceil(pixels / width) - 1 <= count - 1
        assert 2 ** gray[0].of * width >= pixels


def test_pattern_image_matches_simulator():
    size = (97, 61)
    v, u = np.indices(size[::-1])
    uv = np.column_stack([u.ravel(), v.ravel()]) + 0.5
    for pattern in patterns_of(plan_of_cells(size, (5, 3), 6)):
        shown = MonitorPattern(size, None, pattern).radiance(uv, np.ones(len(uv)))
        sent = pattern_image(pattern, size)
        assert sent.dtype == np.uint8
        np.testing.assert_allclose(sent.ravel() / 255, shown, atol=0.501 / 255)


def test_quarter_offset_makes_cosines():
    size = (96, 64)
    plan = plan_of_cells(size, 4, 3, offset=0.25)
    own = [p for p in patterns_of(plan) if p.kind == "phase" and p.axis == "x"]
    x = 2 * np.pi * 4 * (np.arange(96) + 0.5) / 96
    for step, pattern in enumerate(own):
        expected = 0.5 + 0.5 * np.cos(x + 2 * np.pi * step / 3)
        sent = pattern_image(pattern, size)[0]
        np.testing.assert_allclose(sent / 255, expected, atol=0.501 / 255)
        uv = np.column_stack([np.arange(96) + 0.5, np.full(96, 9.0)])
        shown = MonitorPattern(size, None, pattern).radiance(uv, np.ones(96))
        np.testing.assert_allclose(shown, expected, atol=1e-9)


@pytest.mark.parametrize(
    ("cells", "steps", "message"),
    [
        (0, 4, "cells: 0 along x"),
        ((8, 200), 4, "cells: 200 along y on 480 px .* 160 along x and 120"),
        (8, 2, "steps: 2 phase steps; give 3 to 64"),
    ],
)
def test_invalid_plans_are_rejected(cells, steps, message):
    with pytest.raises(InputError, match=message):
        plan_of_cells((640, 480), cells, steps)


def test_chessboard_image_matches_simulator():
    """Also where lines are no borders of pixels: each has the colour of its middle."""
    size, board = (97, 61), MonitorChessboard(7, 5, 8.3, (20.23, 13.71))
    v, u = np.indices(size[::-1])
    uv = np.column_stack([u.ravel(), v.ravel()]) + 0.5
    shown = MonitorBoard(size, None, board).radiance(uv, np.ones(len(uv)))
    np.testing.assert_array_equal(chessboard_image(board, size).ravel(), 255 * shown)


@pytest.mark.parametrize("size", [(97, 61), (1366, 768)])
def test_largest_chessboard_is_centred(size):
    board = chessboard_of_corners(size, 7, 5)
    first = np.array(board.origin_px) - board.pitch_px
    last = np.array(size) - first - board.pitch_px * np.array([8, 6])
    assert (first >= 0).all()
    assert np.isin(last - first, [0, 1]).all()
    assert ((board.pitch_px + 1) * np.array([8, 6]) > size).any()


def test_chessboard_points_use_both_pixel_sizes():
    board = MonitorChessboard(4, 3, 10.0, (20.0, 30.0))
    ends = ActiveGrid((200, 100), (300.0, 125.0), board).chessboard_points()[[0, -1]]
    np.testing.assert_allclose(ends, [[30, 37.5], [75, 62.5]])
    ends = ActiveGrid((200, 100), None, board).chessboard_points()[[0, -1]]
    np.testing.assert_allclose(ends, [[20, 30], [50, 50]])


def test_default_cells_fill_monitor():
    """The most significant bit changes in the middle, the others in between."""
    for bit, edges in ((0, [32]), (1, [16, 48])):
        pattern = Pattern("", "y", "gray", bit=bit, of=3)
        sent = pattern_image(pattern, (96, 64))[:, 0].astype(int)
        np.testing.assert_array_equal(np.flatnonzero(np.diff(sent)) + 1, edges)
