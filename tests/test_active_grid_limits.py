"""How much it takes until pictures of an active grid are doubted, and how little."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.features.active_grid.checks import edges
from raxel.features.active_grid.checks.doubts import _mosaic, clipped_at
from raxel.features.active_grid.checks.frequencies import (
    _common_offset,
    _offset_doubts,
    _windows,
)
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.noise import Noise
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


@pytest.mark.parametrize(("apart", "told"), [(0.05, False), (0.15, True)])
@pytest.mark.parametrize("colours", [[[1, 0], [0, 0]], [[1, 1], [0, 0]]])
def test_neighbours_that_differ_by_a_seventh_are_of_a_mosaic(colours, apart, told):
    """By a twentieth, the stripes of a sine may make them differ."""
    light = 100 * (1 + apart * np.tile(colours, (20, 30)))
    codes = [SimpleNamespace(steps=(0, 1, 2))]
    decoded = SimpleNamespace(mask=np.ones(light.shape, bool))
    found = list(_mosaic([light] * 3, codes, decoded))
    assert len(found) == told
    assert not any(doubt.spoils for doubt in found)  # something was decoded


@pytest.mark.parametrize(
    ("off", "noise", "blur_px", "moved"),
    [
        (0.003, 0.001, None, False),  # so little a response may do
        (0.02, 0.001, 1.0, True),  # half a pixel
        (0.02, 0.001, None, True),
        (0.02, 0.1, 1.0, False),  # noise of the mean is a third of it
        (0.02, 0.02, 1.0, True),
        (0.02, 0.001, 8.0, False),  # blur draws edges and sines apart by more
    ],
)
def test_sines_may_begin_a_little_off_their_code_and_no_more(
    monkeypatch, off, noise, blur_px, moved
):
    """Periods of 25 px, at 300 edges; off and noise of one edge in periods."""
    one = drawn(steps=5)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    sample = SimpleNamespace(names=[p.image for p in one.patterns], codes=codes)
    turns = off + noise * np.random.default_rng(6).normal(size=300)
    seen = np.exp(2j * np.pi * turns), np.ones(300), np.full(300, 2 * np.pi / 25)
    monkeypatch.setattr(edges, "phases_at_edges", lambda *_: seen)
    found = list(edges.moved_doubts(sample, 0, blur_px))
    assert [("something moved" in doubt.text) for doubt in found] == [True] * moved


def test_a_phase_at_an_edge_is_taken_where_the_edge_lies():
    """Edges of cells of 8 px, 0.7 px behind the one pixel and 0.3 before the other."""
    x = np.arange(64) + 0.3
    cells = (x // 8).astype(np.int32)
    away = (x + 4) % 8 - 4
    up = np.cos(np.pi * cells)
    apart = np.clip(np.abs(away), 0, 1) * up
    code = SimpleNamespace(cell=8, period=32)
    seen = np.exp(2j * np.pi * x / 32)[None, None]
    sides = (np.s_[:, :, :-1], np.s_[:, :, 1:])
    lit = np.ones((1, 1, 64), bool)
    phase, due, along, breaks = edges._at_edges(
        code, apart[None, None, None], seen, cells[None, None], lit, *sides
    )
    assert len(phase) == 7
    assert breaks == [0]
    np.testing.assert_allclose(np.angle(phase * np.conj(due)), 0, atol=0.01)
    np.testing.assert_allclose(along, 2 * np.pi / 32)


def seen_sines(periods, begun, sd=0.002):
    """(turns, variances, periods) of 2000 pixels; the sines begin elsewhere."""
    rng, periods = np.random.default_rng(7), np.float32(periods)
    place = rng.uniform(0.1, 0.9, 2000)
    turns = place * periods[:, None] + np.reshape(begun, (-1, 1))
    turns = turns + sd * rng.normal(size=turns.shape)
    return np.float32(turns % 1), np.full(turns.shape, np.float32(sd**2)), periods


@pytest.mark.parametrize(
    ("periods", "begun", "doubted"),
    [
        ((8, 9), 0.03, False),  # a cell's thirtieth: ripples look like it
        ((8, 9), 0.06, True),
        ((20, 20.5), (0.0, -0.0015), False),  # of a mean of noise, 0.06 by these two
        ((20, 20.5), (0.0, -0.003), True),
    ],
)
def test_sines_may_begin_a_little_off_each_other_and_no_more(periods, begun, doubted):
    every = [SimpleNamespace(offset=0.0)] * 2
    found = list(_offset_doubts(every, *seen_sines(periods, begun), "x"))
    assert len(found) == doubted
    if np.ndim(begun) == 0 and doubted:
        offset = float(found[0].text.split("give offset: ")[1].split(" ")[0])
        assert offset == pytest.approx(begun, abs=0.005)


@pytest.mark.parametrize(("periods", "known"), [((8, 9), True), ((1, 16), False)])
def test_an_offset_is_advised_where_no_other_would_do(periods, known):
    """Of 1 and 16 periods any of fifteen offsets would make them fit."""
    every = [SimpleNamespace(offset=0.0)] * 2
    begun = 0.4 if known else 0.5 / 15
    found = list(_common_offset(every, *seen_sines(periods, begun)))
    assert len(found) == known
    assert all("give offset: 0.4 " in way for way in found)


def test_windows_know_the_phases_of_doubted_sines_49_times_as_well():
    """By propagation: 2 / N of a grey value's variance, over amplitude squared."""
    wave = np.full((30, 40), 40 * np.exp(1.2j), np.complex64)
    sample = SimpleNamespace(
        lit=np.ones(wave.size, bool),
        wave_of=lambda *_: (wave, np.full(wave.shape, np.float32(100))),
    )
    four = SimpleNamespace(steps=range(4))
    turns, variances = _windows(sample, [four], Noise(6.0))
    np.testing.assert_allclose(turns, 1.2 / (2 * np.pi), rtol=1e-5)
    due = 2 / 4 * 6.0 / 49 / 40**2 / (2 * np.pi) ** 2
    np.testing.assert_allclose(variances, due, rtol=1e-4)
