"""What phases are at the edges of their Gray code, where the cells make them known."""

import numpy as np

from raxel.features.active_grid.checks.sample import Doubt, neighbours

MIN_EDGES = 100  # pixels
SMOOTH = 3  # times the usual change from pixel to pixel
BREAK = 1.0  # rad
# Periods, standard deviations by noise, and shares of the blur, which draws edges and
# sines apart where a surface bends: what is beyond all three has moved.
MOVED, BEYOND_NOISE, DRAWN = 0.006, 6, 0.1
# Of what sines keep of a pixel's contrast where they keep most, 0.95 quantile. Where
# blur washes finer ones out, their phase is that of coarser ones beside them.
CLEAR = 0.25


def moved_doubts(sample, axis, blur_px):
    """A Doubt or none: did something move between Gray code and phases of an axis?

    blur_px: its standard deviation, or None. To be asked where the steps agree, as one
    that is brighter shifts the phase as well.
    """
    code = sample.codes[axis]
    # Of four steps and more, and edges midway between picture and inverse, the response
    # shifts none where they meet.
    if len(code.steps) < 4 or any(dark is None for _, dark in code.bits):
        return
    phase, due, along = phases_at_edges(sample, axis, code.steps)
    if not len(along):
        return
    off = phase * np.conj(due)
    mean = off.mean()
    turn = abs(np.angle(mean))
    spread = np.std(np.angle(off * np.conj(mean))) / np.sqrt(len(off))
    px = turn / np.median(np.abs(along))
    limit = max(BEYOND_NOISE * spread, 2 * np.pi * MOVED)
    if turn > limit and px > DRAWN * (blur_px or 0.0):
        files = f"{sample.names[code.steps[0]]} to {sample.names[code.steps[-1]]}"
        yield Doubt(
            "moved-code-phase",
            False,
            f"the sines along {'xy'[code.axis]} ({files}) begin "
            f"{turn / (2 * np.pi):.2g} periods, about {px:.1f} px, off the cells of "
            "its Gray code: something moved between them; camera and monitor must be "
            "at rest: take the pictures again",
        )


def phases_at_edges(sample, axis, pictures):
    """Of E edges that `_at_edges` finds, phases and what the code makes them, complex
    (E,) of unit length, and how much they grow towards higher cells, rad; all empty
    where these cannot be told. pictures: in the place of the axis' steps."""
    code, none = sample.codes[axis], (np.empty(0),) * 3
    if not code.bits:
        return none
    apart = np.array([sample.apart(axis, bit) for bit in range(len(code.bits))])
    phase = sample.wave_of(code.sines, pictures)[0]
    lit = sample.lit & _clear(sample, np.abs(phase))
    phase = phase / np.maximum(np.abs(phase), 1e-9)
    cells = _cells(apart)
    found = [
        _at_edges(code, apart, phase, cells, lit, *slices) for slices in neighbours(1)
    ]
    *told, breaks = (np.concatenate(parts) for parts in zip(*found, strict=True))
    # Among many breaks between surfaces, some look like edges.
    return told if len(told[0]) >= max(MIN_EDGES, breaks.sum()) else none


def _clear(sample, amplitudes):
    """Where sines keep enough of the contrast for their phase to be their own."""
    kept = amplitudes / np.maximum(sample.high - sample.low, 1e-6)
    return kept > CLEAR * np.quantile(kept[sample.lit], 0.95)


def _at_edges(code, apart, phase, cells, lit, first, second):
    """Where one bit changes on one surface: complex (E,) twice, (E,) and a count (1,).

    The phase there, interpolated to where picture and inverse are equal, and what the
    cells make it; how much it grows towards higher cells, rad; how often it breaks.
    """
    turn = np.angle(phase[second] * np.conj(phase[first]))
    lit = lit[first] & lit[second]
    up = cells[second] - cells[first]
    changed = (apart[(slice(None), *first)] > 0) != (apart[(slice(None), *second)] > 0)
    usual = np.median(np.abs(turn[lit])) if lit.any() else 0.0
    edge = lit & (np.abs(up) == 1) & (changed.sum(axis=0) == 1)
    edge &= np.abs(turn) < SMOOTH * max(usual, 0.01)
    breaks = np.count_nonzero(lit & (np.abs(turn) > max(SMOOTH * usual, BREAK)))
    bit = np.argmax(changed, axis=0)[None]
    before = np.take_along_axis(apart[(slice(None), *first)], bit, 0)[0][edge]
    after = np.take_along_axis(apart[(slice(None), *second)], bit, 0)[0][edge]
    share = before / (before - after)
    there = (1 - share) * phase[first][edge] + share * phase[second][edge]
    number = np.maximum(cells[first], cells[second])[edge]
    due = np.exp(2j * np.pi * number * code.cell / code.period)
    return there / np.abs(there).clip(1e-9), due, turn[edge] * up[edge], [breaks]


def _cells(apart):
    """The cell of each pixel, by the signs of picture less inverse."""
    value = np.zeros(apart[0].shape, bool)
    cells = np.zeros(apart[0].shape, np.int32)
    for bit in apart:
        value = value ^ (bit > 0)
        cells = 2 * cells + value
    return cells
