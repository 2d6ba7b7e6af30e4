"""Decoding an active grid: which point of the monitor does each pixel see?

Thesis 3.2.2. The Gray code gives the cell, each bit by comparing a picture with its
inverse (3.24), which puts an edge midway between where both show it; the phase of the
sines gives the place in it, in four quadrants (3.23).
"""

import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.bias import OF_NEIGHBOURS, OF_WINDOWS, squared_bias
from raxel.features.active_grid.breaks import EVERY, HALF, find_breaks, mark_breaks
from raxel.features.active_grid.coding import plan_arrays, read_coding
from raxel.features.active_grid.layout import (
    AHEAD,
    ALONE,
    BESIDE,
    BREAK,
    DARK,
    DECODED,
    FILLED,
    REACH,
    RIM,
    ROWS_A_CALL,
    SATURATED,
    UNREADABLE,
    empty_rows,
)
from raxel.features.active_grid.neighbours import (
    fill_holes,
    mark_rim,
    smooth_neighbours,
)
from raxel.features.active_grid.noise import Noise, estimate_noise
from raxel.features.active_grid.places import decode_rows
from raxel.features.active_grid.reading import LEAST_MODULATION, read_rows
from raxel.processors import processors

ROWS_AT_ONCE = 128
SPECK = 2  # px; so small, a spot without light is no rim
MARGIN_PX = 6  # three, and three times the blur of an ordinary lens
REASONS = {
    DECODED: "decoded",
    FILLED: "filled from neighbours",
    DARK: "too little contrast",
    SATURATED: "overexposed",
    UNREADABLE: "the code cannot be read",
    ALONE: "no neighbour agrees",
    BESIDE: "beside the monitor",
    RIM: "at the rim of the lit area",
    BREAK: "at a break of the surface",
}


@dataclass(frozen=True, eq=False)
class Decoded:
    """What each pixel sees.

    location: (H, W, 2) float32, `unit` from the upper left corner of the lit area, x
    right and y down; sigma: alike, standard deviation of each coordinate; NaN where
    `mask` is False, and along an axis without patterns. cells: (H, W, 2) int16, the
    period (of a code without phases the cell) of each axis, -1 just before the first;
    of no meaning where `mask` is False. status: (H, W) uint8, a key of REASONS.
    noise: the Noise that sigma was computed with.
    """

    location: np.ndarray
    sigma: np.ndarray
    cells: np.ndarray
    status: np.ndarray
    unit: str
    noise: Noise

    @property
    def mask(self):
        """(H, W) bool: where there is a location that can be trusted."""
        return self.status <= FILLED

    def counts(self):
        """{reason: number of pixels}, all of REASONS."""
        found = np.bincount(self.status.ravel(), minlength=len(REASONS))
        return {REASONS[k]: int(found[k]) for k in REASONS}


def decode(
    images, patterns, monitor, *,
    white=None, black=None, smooth=True, neighbours=False, fill=False,
    margin_px=MARGIN_PX, noise=None, saturated=None, blur_px=0.0, threads=None,
    into=None,
):  # fmt: skip
    """Decode the pictures of one view of an active grid.

    images: (n, H, W) or n pictures (H, W), uint8 or uint16; a stack in one piece of
    memory is used as it lies. patterns: n `raxel.sets.Pattern`, what each picture
    shows, in any order; one axis or both, Gray code or phases or both, three phase
    steps or more. monitor: `raxel.sets.ActiveGrid`; locations come out in mm where its
    size in mm is known, else in its pixels. white, black: (H, W), pictures of the
    monitor all white and black, for bits without an inverse; without them the mean of
    the phase steps is taken.

    smooth: average the sines over 7 x 7 pixels, where such a window holds no dark
    pixel and no two neighbours that are more than a quarter of a period apart; a
    pixel whose window does keeps its own value. neighbours: average locations over
    3 x 3 pixels under the same condition; fill: give pixels without a location the mean
    of their neighbours, where these lie on opposite sides and agree (both 3.2.2).
    margin_px: pixels so close to the rim of the lit area are left out, as a blurred one
    sees what is beside it, and those about so close to a jump of the surface that is
    seen. noise: standard deviation of a grey value, or a `Noise`; None: estimated from
    the pictures. saturated: the value from which a sine counts as clipped, by default
    the largest one. blur_px: standard deviation of the blur of lens and monitor, where
    it is known, for its part in sigma. threads: by default one per processor. into: a
    Decoded of an earlier view of this size and these patterns, whose arrays are written
    over and handed back: to get new memory takes its time.

    Returns Decoded. Its sigma says what noise does to a pixel, and the bias of windows
    and blur where phases bend (`bias`); neighbours that share a window share both. A
    response that is not linear is not in it: with four steps its third order shifts
    the phase. Raises InputError for pictures and patterns that do not fit together.
    """
    stack = checked_pictures(images, patterns)
    codes = read_coding(patterns, monitor.monitor_px)
    unit = np.ones(2)
    if monitor.monitor_mm:
        unit = np.divide(monitor.monitor_mm, monitor.monitor_px)
    stack = _Stack(stack, codes, white, black)
    limit = np.iinfo(stack.dtype).max if saturated is None else int(saturated)
    if noise is None:
        noise = estimate_noise(stack.for_noise(), limit)
    elif not isinstance(noise, Noise):
        noise = Noise(float(noise) ** 2)
    height, width = stack.shape
    plan = plan_arrays(stack.codes, monitor.monitor_px, unit)
    out = _arrays((len(codes), height, width), into)
    variance = tuple(map(np.float32, noise))
    limit = stack.dtype.type(limit)
    averaged = blur_px**2 + OF_WINDOWS * smooth + OF_NEIGHBOURS * neighbours
    least = LEAST_MODULATION * np.sqrt(noise.at(0))
    bias = squared_bias(images, codes, averaged, least)
    settings = plan, smooth, neighbours, limit, variance, bias

    parts = range(0, height, ROWS_AT_ONCE)
    with ThreadPoolExecutor(threads or processors()) as pool:
        kept = threading.local()

        def decode_part(first):
            if not hasattr(kept, "rows"):
                kept.rows = empty_rows(len(codes), width, stack.dtype)
            _decode_part(stack, first, settings, kept.rows, out)

        def trim_part(first):
            _trim(first, min(first + ROWS_AT_ONCE, height), margin_px, out)

        def find_part(first):
            stop = min(first + ROWS_AT_ONCE, height)
            find_breaks(*out[:2], plan.used, plan.length, first, stop, broken)

        def break_part(first):
            stop = min(first + ROWS_AT_ONCE, height)
            _leave_out(first, stop, margin_px, broken, out)

        tasks = (decode_part, trim_part, find_part, break_part)
        broken = np.empty((-(-height // EVERY), width), np.uint8)
        for task in tasks if margin_px else tasks[:1]:
            list(pool.map(task, parts))
    if margin_px:
        _trim_sides(margin_px, plan.extent[:, None, None], out)
    location, sigma, cells, status = out
    if neighbours:
        smooth_neighbours(location, sigma, status, plan.reach)
    if fill:
        fill_holes(location, sigma, cells, status, plan.reach, plan.length)
    return Decoded(
        *(_both_axes(array, codes) for array in (location, sigma, cells)),
        status,
        "mm" if monitor.monitor_mm else "px",
        noise,
    )


def _arrays(shape, into):
    """location, sigma, cells (A, H, W) and status (H, W) to write to."""
    if into is not None and shape[0] == 2 and into.status.shape == shape[1:]:
        both = (into.location, into.sigma, into.cells)
        return *(np.moveaxis(array, 2, 0) for array in both), into.status
    kinds = np.float32, np.float32, np.int16
    return *(np.empty(shape, kind) for kind in kinds), np.empty(shape[1:], np.uint8)


def _decode_part(stack, first, settings, rows, out):
    """Decode ROWS_AT_ONCE rows from `first`; rows: to work in, whatever they hold."""
    plan, smooth, mark, limit, variance, bias = settings
    stop = min(first + ROWS_AT_ONCE, stack.shape[0])
    pictures, start = stack.rows(first, stop)
    known, end = max(first - start - REACH, 0), pictures.shape[1]
    for y in range(first - start, stop - start, ROWS_A_CALL):
        after = min(y + ROWS_A_CALL, stop - start)
        ahead = min(after + AHEAD, end)
        read_rows(pictures, known, ahead, plan, limit, variance, rows)
        part, known = (y, after, y + start), ahead
        found = pictures, part, plan, smooth, mark
        decode_rows(*found, variance, bias, rows, out)


def checked_pictures(images, patterns):
    """The pictures, if they fit each other and the patterns."""
    if not len(images) or len(images) != len(patterns):
        raise InputError(
            f"images: found {len(images)} for {len(patterns)} patterns; give one for "
            "each, in the same order"
        )
    kinds = Counter((np.shape(image), image.dtype) for image in images)
    usual = kinds.most_common(1)[0][0]
    if len(kinds) > 1:
        k = next(k for k, i in enumerate(images) if (i.shape, i.dtype) != usual)
        found, dtype = images[k].shape, images[k].dtype
        raise InputError(
            f"{patterns[k].image}: found a picture {found} {dtype} among those "
            f"{usual[0]} {usual[1]}; give all of a view in one size and depth"
        )
    if len(usual[0]) != 2 or usual[1] not in (np.uint8, np.uint16):
        raise InputError(
            f"images: found pictures {usual[0]} {usual[1]}; give grey ones, uint8 or "
            "uint16"
        )
    return images


class _Stack:
    """The pictures as one stack in which every bit has an inverse, block by block."""

    def __init__(self, images, codes, white, black):
        self.images, self.made = images, []
        self.shape, self.dtype = np.shape(images[0]), images[0].dtype
        self.white, self.black = white, black
        self.codes = tuple(map(self._completed, codes))
        whole = isinstance(images, np.ndarray) and images.flags.c_contiguous
        self.as_it_lies = whole and not self.made

    def _completed(self, code):
        bits = []
        for picture, inverse in code.bits:
            if inverse is None:
                if not code.steps and (self.white is None or self.black is None):
                    raise InputError(
                        f"patterns: axis {'xy'[code.axis]}: Gray code without inverse; "
                        "give the inverse pictures, or those of white and black"
                    )
                inverse = len(self.images) + len(self.made)
                self.made.append((picture, code.steps))
            bits.append((picture, inverse))
        return type(code)(code.axis, tuple(bits), code.steps, code.cell, code.period)

    def rows(self, first, stop):
        """(stack, the picture's row where it begins) with what is needed around."""
        if self.as_it_lies:
            return self.images, 0
        start, end = max(0, first - REACH), min(self.shape[0], stop + AHEAD)
        block = np.empty(
            (len(self.images) + len(self.made), end - start, self.shape[1]), self.dtype
        )
        for k, image in enumerate(self.images):
            block[k] = image[start:end]
        for k, (picture, steps) in enumerate(self.made, len(self.images)):
            block[k] = self._inverse(block, picture, steps, slice(start, end))
        return block, start

    def _inverse(self, block, picture, steps, part):
        """What an inverse would have shown, as far from the middle."""
        if self.white is not None and self.black is not None:
            twice = self.white[part].astype(np.int32) + self.black[part]
        else:
            twice = np.rint(2 * np.mean(block[list(steps)], axis=0)).astype(np.int32)
        most = np.iinfo(self.dtype).max
        return np.clip(twice - block[picture], 0, most)

    def for_noise(self):
        """Pictures without many edges: the sines, else the coarsest bits."""
        sines = [k for code in self.codes for k in code.steps]
        coarse = [code.bits[0][0] for code in self.codes if code.bits]
        return [self.images[k] for k in sines[:8] or coarse]


def _trim(first, stop, margin, out):
    """Leave out what is within `margin` px of pixels without light; specks are none."""
    import cv2

    location, sigma, _, status = out
    around = SPECK + margin
    start, end = max(0, first - around), min(len(status), stop + around)
    unlit = cv2.LUT(status[start:end], _table(DARK, BESIDE))
    if not unlit.any():
        return
    # Beyond the picture it goes on as at its border, where strips are no specks.
    unlit = cv2.copyMakeBorder(unlit, *(SPECK,) * 4, cv2.BORDER_REPLICATE)
    unlit = cv2.erode(unlit, np.ones((SPECK + 1,) * 2, np.uint8))
    # What is left of a spot grows by what it lost, and by the margin.
    size = 2 * margin + SPECK + 1
    near = cv2.dilate(unlit, np.ones((size, size), np.uint8))
    near = near[SPECK + first - start :, SPECK:-SPECK]
    mark_rim(near, location[:, first:stop], sigma[:, first:stop], status[first:stop])


def _trim_sides(margin, extent, out):
    """Leave out pixels at the picture's border whose surroundings end beyond it.

    What lies `margin` px further out is not in the picture. It is where the surface
    seen there goes on; a blurred pixel sees the monitor's border if that is beyond.
    """
    location, sigma, _, status = out
    if min(status.shape) <= 2 * margin:
        return
    for turned in (False, True):
        for step in (1, -1):
            place, spread, own = (
                (np.swapaxes(a, -1, -2) if turned else a)[..., ::step, :]
                for a in (location, sigma, status)
            )
            outwards = place[:, margin] - place[:, 2 * margin]
            beyond = place[:, :margin] + outwards[:, None]
            inside = np.all((beyond >= 0) & (beyond <= extent), axis=0)
            rim = np.nonzero(~inside & (own[:margin] == DECODED))
            own[rim] = RIM
            place[:, *rim] = np.nan
            spread[:, *rim] = np.nan


def _leave_out(first, stop, margin, broken, out):
    """Leave out what is within `margin` px of a jump; broken: every EVERY-th row."""
    import cv2

    location, sigma, _, status = out
    # A jump was found HALF to either side of it, or in rows passed over a little less.
    grow = max(margin - HALF + EVERY, 0)
    start = max(0, first - grow) // EVERY
    end = -(-min(len(status), stop + grow) // EVERY)
    if not broken[start:end].any():
        return
    near = np.zeros(((end - start) * EVERY, status.shape[1]), np.uint8)
    near[::EVERY] = broken[start:end]
    near = cv2.dilate(near, np.ones((2 * grow + 1,) * 2, np.uint8))
    near, part = near[first - start * EVERY :], slice(first, stop)
    mark_breaks(near, location[:, part], sigma[:, part], status[part])


def _table(*members):
    """1 for each of these, else 0."""
    table = np.zeros(256, np.uint8)
    table[list(members)] = 1
    return table


def _both_axes(array, codes):
    """(A, H, W) as (H, W, 2), a view where both axes are there."""
    if len(codes) == 1:
        only = array[0]
        missing = np.nan if array.dtype.kind == "f" else 0
        array = np.full((2, *only.shape), missing, array.dtype)
        array[codes[0].axis] = only
    return np.moveaxis(array, 0, 2)
