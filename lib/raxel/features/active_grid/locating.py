"""Locations alone, about as fast as memory hands over the pictures.

No pixel looks at another one here, so that pictures are worked through as flat pieces.
Written as `reading`; what is compiled in from `phases` is the angle.
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numba import njit

from raxel.errors import InputError
from raxel.features.active_grid.coding import plan_arrays, read_coding
from raxel.features.active_grid.phases import turns
from raxel.features.active_grid.stack import checked_pictures
from raxel.io.machine import processors

PIECE = 32768  # px whose intermediate values stay near the processor
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)


def locate(images, patterns, monitor, *, threads=None, into=None):
    """Where each pixel would see the monitor, whether or not it does.

    As `decode` without smoothing, for a preview, or where it is known which pixels can
    be trusted: no mask, no sigma, no rule for the edges of cells, where some pixels are
    a period off. images: (n, H, W), uint8 or uint16; patterns, monitor, threads: as
    there; into: an array that was handed back before, to write over.

    Returns (H, W, 2) float32, mm or px as there; NaN along an axis without patterns.
    Raises InputError as there, for bits without an inverse, and for sines that tell of
    periods in the place of bits.
    """
    stack = np.ascontiguousarray(checked_pictures(images, patterns))
    codes = read_coding(patterns, monitor.monitor_px)
    if any(inverse is None for code in codes for _, inverse in code.bits):
        raise InputError("patterns: Gray code without inverse; use decode")
    unit = np.divide(monitor.monitor_mm or monitor.monitor_px, monitor.monitor_px)
    if any(code.others for code in codes):
        raise InputError("patterns: sines without Gray code; use decode")
    plan = plan_arrays(codes, monitor.monitor_px, unit)
    count, height, width = stack.shape
    if into is None:
        into = np.moveaxis(np.empty((2, height, width), np.float32), 0, 2)
    planes = np.moveaxis(into, 2, 0)
    if len(codes) == 1:
        planes[1 - codes[0].axis] = np.nan
        planes = planes[codes[0].axis][None]
    out, flat = planes.reshape(len(codes), -1), stack.reshape(count, -1)
    parts = threads or processors()
    bounds = np.linspace(0, height * width, parts + 1).astype(int)
    kind = np.uint8 if plan.bits.max() <= 8 else np.uint16
    with ThreadPoolExecutor(parts) as pool:

        def part(ends):
            _locate(flat, *ends, plan, np.empty(PIECE, kind), out)

        list(pool.map(part, pairwise(bounds)))
    return into


@njit(cache=True, nogil=True, error_model="numpy")
def _cells(images, first, stop, pairs, code):
    code[:] = 0
    for k in range(len(pairs)):
        light = images[pairs[k, 0], first:stop]
        dark = images[pairs[k, 1], first:stop]
        for x in range(len(light)):
            code[x] = 2 * code[x] + ((code[x] & 1) ^ (light[x] > dark[x]))


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh(images, first, stop, steps, weights, out):
    """out: a weighted sum of the steps, two at a time; those that count come first."""
    for k in range(0, len(steps), 2):
        p, q = weights[k], weights[k + 1]
        if k and p == 0 and q == 0:
            break
        a, b = images[steps[k], first:stop], images[steps[k + 1], first:stop]
        if k == 0:
            for x in range(len(a)):
                out[x] = p * np.float32(a[x]) + q * np.float32(b[x])
        else:
            for x in range(len(a)):
                out[x] += p * np.float32(a[x]) + q * np.float32(b[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _places(sine, cosine, code, ratio, length, out):
    """The place with this phase that is nearest to the middle of the cell."""
    for x in range(len(out)):
        turn = turns(sine[x], cosine[x])
        middle = (np.float32(code[x]) + _HALF) * ratio
        out[x] = length * (np.ceil(middle - turn - _HALF) + turn)


@njit(cache=True, nogil=True, error_model="numpy")
def _locate(images, begin, end, plan, code, out):
    """images: (n, H W); begin, end: of a part of them; code: to work in; out: (A, H W).

    The type of code is as short as its bits allow.
    """
    sine, cosine = np.empty(PIECE, np.float32), np.empty(PIECE, np.float32)
    for first in range(begin, end, PIECE):
        stop = min(first + PIECE, end)
        for axis in range(len(plan.bits)):
            used, steps, share = plan.used[axis], plan.steps[axis], plan.weights[axis]
            _cells(images, first, stop, plan.pairs[axis, : plan.bits[axis]], code)
            if used:
                _weigh(images, first, stop, steps[0, :used], share[0], sine)
                _weigh(images, first, stop, steps[1, :used], share[1], cosine)
            else:
                sine[:], cosine[:] = _ZERO, -_ONE  # the middle of the cell
            piece = out[axis, first:stop]
            _places(sine, cosine, code, plan.ratio[axis], plan.length[axis], piece)
