"""Patterns of an active grid: structured-light codes as arrays for compiled loops."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from raxel.errors import InputError
from raxel.sets.patterns import cell_width

# Shared by the compiled loops of the decoder: pixel states, a plan and row buffers.
# The buffers hold a few rows of the image as rings: row y is at y modulo their length.


DECODED, FILLED, DARK, SATURATED, UNREADABLE = range(5)
ALONE, OUTSIDE, BORDER, BREAK = range(5, 9)

UNKNOWN = 65535  # in CodePlan.orders: no cell
# Modulation, as a share of that of bright pixels: pixels below it are dark, where noise
# has harmonics of every order, or receive too little light.
MIN_MODULATION_SHARE, BRIGHT_PERCENTILE = 0.2, 99
WINDOW_RADIUS = 3  # of the smoothing window of 7 x 7 pixels
ROWS_AROUND = WINDOW_RADIUS + 1  # rows needed around a row: breaks need one more
BLOCK_PX = 32  # side of the blocks of the image within which a bias is constant
ROWS_PER_CALL = 16
RING_ROWS = 24  # rows in a ring: those of a call and ROWS_AROUND before and after them
# Images are decoded in strips of at most so many columns. The fields of one array have
# constant distances known at compile time, so that many arrays can run in one loop.
MAX_STRIP_COLUMNS = 2048
FIELD_PITCH = (
    MAX_STRIP_COLUMNS + 80
)  # distance between fields: multiples of 4096 bytes slow each other down
SINE, COSINE, VARIANCE = 0, FIELD_PITCH, 2 * FIELD_PITCH  # of Rows.waves
# Of Rows.greys.
LOWEST, SECOND, HIGHEST, DIFFERENCE = (0, FIELD_PITCH, 2 * FIELD_PITCH, 3 * FIELD_PITCH)
# Of Rows.marks.
BAD, RIGHT, BELOW, CROSSED = (0, FIELD_PITCH, 2 * FIELD_PITCH, 3 * FIELD_PITCH)
# Of Rows.work.
LEVEL, SINES, COSINES, TURN = (0, FIELD_PITCH, 2 * FIELD_PITCH, 3 * FIELD_PITCH)
SPREAD, PERIOD, CELL_OFFSET, POSITION = (
    4 * FIELD_PITCH,
    5 * FIELD_PITCH,
    6 * FIELD_PITCH,
    7 * FIELD_PITCH,
)
SIGMA, WORK = 8 * FIELD_PITCH, 9 * FIELD_PITCH
OWN, DOUBT, LOST = 0, FIELD_PITCH, 2 * FIELD_PITCH  # of Rows.flags
BREAKS, MIXED, STATUS = 0, FIELD_PITCH, 2 * FIELD_PITCH  # of Rows.common


class CodePlan(NamedTuple):
    """Hold what the images of a stack encode along A axes (`coding.plan_arrays`).

    pairs: (A, bits, 2), image and inverse of each bit; steps, weights: (A, 3, K), of
    the phase steps for sine, cosine and level, weights float32. int64 (A,): bits; used
    steps, rounded up to an even number; edges, the first edge after the last cell on
    the monitor; jump, difference of cells above which neighbours view different
    surfaces. float32 (A,): ratio of cell to period; length of a period and extent of
    the monitor in the unit of locations; spread 2 / N of N steps. unwrapped: (A,)
    int64, whether cells come from `orders`, (A, H, W) uint16, by multi-frequency phase
    unwrapping (`phase_unwrapping.period_cells`). uneven: (A,) bool, whether the
    variance of a phase changes within windows.
    """

    pairs: np.ndarray
    steps: np.ndarray
    weights: np.ndarray
    bits: np.ndarray
    used: np.ndarray
    edges: np.ndarray
    jump: np.ndarray
    ratio: np.ndarray
    length: np.ndarray
    extent: np.ndarray
    spread: np.ndarray
    unwrapped: np.ndarray
    orders: np.ndarray
    uneven: np.ndarray

    @property
    def reach(self):
        """(A,) float32: maximal distance between neighbours on one surface."""
        return self.length * self.ratio * self.jump.astype(np.float32) / 2


class Ripples(NamedTuple):
    """Hold the phase errors of A axes by the response (`lines.Ripple`).

    steps, times: (A,) int64, 0 without a correction; origin: (A, 2), share: (A, 6),
    terms: (A, 3) float32; across, down: float32, scale from columns and rows to image
    coordinates from 0 to 2.
    """

    steps: np.ndarray
    origin: np.ndarray
    times: np.ndarray
    share: np.ndarray
    terms: np.ndarray
    across: np.float32
    down: np.float32


class Rows(NamedTuple):
    """Hold rows of a strip, field after field, FIELD_PITCH apart.

    A field has at most MAX_STRIP_COLUMNS columns. P is FIELD_PITCH, R is RING_ROWS.

    Rings, with the row as first or second index. waves: (A, R, 3 P) float32: sine and
    cosine of unit length, and the variance of a pixel's phase in squared turns. codes:
    (A, R, P) uint16, the cell. greys: (A, R, 4 P), of the type of the images: least,
    second least and largest difference between an image and its inverse, the last one
    of all axes in axis 0; that of one image. marks: (R, 4 P) uint8: why a pixel is not
    decoded; whether there is a break to the right, and below; any of these.

    Rows to work in. work: (A, WORK) float32: the mean grey value; sums over seven rows;
    the phase and its variance; period; offset from the middle of the cell; position and
    its standard deviation. flags: (A, 3 P) uint8: the phase is that of one pixel; its
    period is in doubt; undetermined. common: (3 P,) uint8: breaks in seven rows and in
    a window; status. selected: (MAX_STRIP_COLUMNS,) int64, pixels picked out.
    """

    waves: np.ndarray
    codes: np.ndarray
    greys: np.ndarray
    marks: np.ndarray
    work: np.ndarray
    flags: np.ndarray
    common: np.ndarray
    selected: np.ndarray


class Strip(NamedTuple):
    """Hold columns of the image: those that are read, and those that are decoded."""

    start: int
    width: int
    first: int
    stop: int


def strips_of(width):
    """Return strips of equal width that cover an image, with ROWS_AROUND in common."""
    around = 2 * ROWS_AROUND
    count = max(1, -(-(width - around) // (MAX_STRIP_COLUMNS - around)))
    own = -(-(width + (count - 1) * around) // count)
    own = min(-(-own // 64) * 64, MAX_STRIP_COLUMNS, width)
    starts = [k * (width - own) // max(count - 1, 1) for k in range(count)]
    ends = [0, *(start + ROWS_AROUND for start in starts[1:]), width]
    return [Strip(starts[k], own, ends[k], ends[k + 1]) for k in range(count)]


def empty_rows(axes):
    """Return Rows for so many axes."""
    return Rows(
        np.zeros((axes, RING_ROWS, 3 * FIELD_PITCH), np.float32),
        np.zeros((axes, RING_ROWS, FIELD_PITCH), np.uint16),
        np.zeros((axes, RING_ROWS, 4 * FIELD_PITCH), np.uint16),
        np.zeros((RING_ROWS, 4 * FIELD_PITCH), np.uint8),
        np.zeros((axes, WORK), np.float32),
        np.zeros((axes, 3 * FIELD_PITCH), np.uint8),
        np.zeros(3 * FIELD_PITCH, np.uint8),
        np.zeros(MAX_STRIP_COLUMNS, np.int64),
    )


MAX_BITS = 15
# Code without phases: maximal difference between neighbours on one surface, as a share
# of the monitor.
MAX_NEIGHBOUR_SHARE = 1 / 32
WIDTH_TOL = 1e-6  # of a cell, for widths that are not binary fractions
# Cells per period in phase unwrapping: the position is known to a part of a period.
CELLS_PER_PERIOD = 4
MAX_PERIODS = 10_000  # without Gray code; their cells are counted in 16 bits
# Periods by which the sinusoids of two positions must differ: four grey levels of a
# sinusoid that has the full range of 8 bits.
MIN_PHASE_SEPARATION = 0.005


@dataclass(frozen=True)
class Sines:
    """Hold the phase steps of sinusoids of one period, px of the monitor.

    steps: indices of images in the stack, in the order of their phase; offset: of the
    first step, in periods.
    """

    steps: tuple[int, ...]
    period: float
    offset: float = 0.0

    @property
    def weights(self):
        """(3, N), see `phase_weights`."""
        return phase_weights(len(self.steps), self.offset)


@dataclass(frozen=True)
class AxisCode:
    """Hold the patterns of one axis; images are given by their index in the stack.

    bits: (image, inverse) from the coarsest, None without an inverse; sines: the
    sinusoids that give positions, None without any; others: sinusoids of other periods
    that determine the fringe order, in place of a Gray code; cell: px of the monitor.
    """

    axis: int
    bits: tuple[tuple[int, int | None], ...]
    sines: Sines | None
    cell: float
    others: tuple[Sines, ...] = ()

    @property
    def steps(self):
        """Images of the sinusoids that give positions, in their order."""
        return self.sines.steps if self.sines else ()

    @property
    def period(self):
        """Period of these sinusoids, px of the monitor; None without any."""
        return self.sines.period if self.sines else None


def read_coding(patterns, monitor_px):
    """Return the AxisCodes of images with these Patterns, in the order of the images.

    monitor_px: (width, height). Of several phase codes of an axis, the finest one whose
    periods the Gray code can distinguish is used. Without a Gray code all are used.
    Raises InputError for patterns that appear twice, for gaps, and for an axis whose
    periods cannot be distinguished.
    """
    codes = []
    for axis, name in enumerate("xy"):
        own = [(i, p) for i, p in enumerate(patterns) if p.axis == name]
        if own:
            codes.append(_axis_code(axis, own, monitor_px))
    if not codes:
        raise InputError("patterns: none; give the images of a Gray code or of phases")
    return tuple(codes)


def _axis_code(axis, own, monitor_px):
    name, size = "xy"[axis], monitor_px[axis]
    bits, cell = _gray(name, [(i, p) for i, p in own if p.kind == "gray"], monitor_px)
    phases = defaultdict(list)
    for i, pattern in own:
        if pattern.kind == "phase":
            phases[pattern.periods].append((i, pattern))
    if not phases:
        return AxisCode(axis, bits, None, cell)
    if not bits and len(phases) > 1:
        return _without_gray(axis, phases, size)
    cell = cell or float(size)
    usable = [n for n in phases if size / n >= cell * (1 - WIDTH_TOL)]
    if not usable:
        found = "no Gray code" if not bits else f"cells of {cell:g} px"
        raise InputError(
            f"patterns: axis {name}: ambiguous periods ({size / min(phases):g} px, "
            f"{found}{_files(own)}); add a Gray code with a cell per period"
            + " or sines of one period"
            * (not bits)
        )
    return AxisCode(axis, bits, _sines(name, phases, max(usable), size), cell)


def _without_gray(axis, phases, size):
    """Return the AxisCode of sinusoids for multi-frequency phase unwrapping."""
    name, finest = "xy"[axis], max(phases)
    others = [_sines(name, phases, n, size) for n in sorted(phases) if n != finest]
    sines = _sines(name, phases, finest, size)
    if finest > MAX_PERIODS:
        raise InputError(
            f"patterns: axis {name}: {finest:g} periods without Gray code; give at "
            f"most {MAX_PERIODS}"
        )
    periods = np.array([finest, *(size / one.period for one in others)])
    alike = np.flatnonzero(phase_separation(periods) < MIN_PHASE_SEPARATION)
    if len(alike):
        own = [one for some in phases.values() for one in some]
        periods = " and ".join(f"{size / n:g} px" for n in sorted(phases))
        raise InputError(
            f"patterns: axis {name}: sines of {periods} repeat after "
            f"{(alike[0] + 1) * sines.period:.4g} px of {size} px{_files(own)}; add "
            "sines of one period, or a Gray code"
        )
    return AxisCode(axis, (), sines, sines.period / CELLS_PER_PERIOD, tuple(others))


def phase_separation(periods):
    """(M,): distance between the phases of positions that are m = 1 to M periods apart.

    periods: (F,) across the monitor; M of the first ones fit on it. Result: length of
    the vector of phase differences, in periods, after the best change of position is
    subtracted.
    """
    first, others = periods[0], periods[1:]
    distances = np.arange(1, max(int(np.ceil(first * (1 - WIDTH_TOL))), 1))[:, None]
    residual = distances * others / first
    residual = residual - np.round(residual)
    explained = (residual @ others) ** 2 / np.sum(periods**2)
    return np.sqrt(np.maximum(np.sum(residual**2, axis=1) - explained, 0))


def _files(own):
    """Return the names of these images for messages."""
    names = [pattern.image for _, pattern in own]
    return f" ({names[0]} to {names[-1]})" if len(names) > 1 else f" ({names[0]})"


def _sines(name, phases, periods, size):
    """Return the Sines of so many periods. Raises InputError as `read_coding`."""
    try:
        steps = _steps(name, phases[periods])
    except InputError as fault:
        if len(phases) == 1:
            raise
        found = ", ".join(f"{n:g}" for n in sorted(phases))
        raise InputError(
            f"{fault} (axis {name} has periods {found}; those of one code must be "
            "the same)"
        ) from fault
    return Sines(steps, size / periods, phases[periods][0][1].offset)


def _gray(name, own, monitor_px):
    """Return ((image, inverse), ...) by bit and the finest cell width, or (), None."""
    if not own:
        return (), None
    found, names = {}, {}
    for i, pattern in own:
        key = pattern.bit, pattern.inverse
        if key in found:
            raise InputError(
                f"patterns: axis {name}: bit {pattern.bit} appears twice "
                f"({names[key]} and {pattern.image}); remove one"
            )
        found[key], names[key] = i, pattern.image
    count = 1 + max(bit for bit, _ in found)
    gap = next((b for b in range(count) if (b, False) not in found), None)
    if gap is not None:
        raise InputError(
            f"patterns: axis {name}: Gray code lacks bit {gap}; add its image"
        )
    if count > MAX_BITS:
        raise InputError(
            f"patterns: axis {name}: {count} bits; give at most {MAX_BITS}, and remove "
            "cells finer than a pixel of the monitor"
        )
    pattern = own[0][1]
    finest = cell_width(pattern, monitor_px) * 2.0 ** (pattern.of - count)
    return tuple((found[b, False], found.get((b, True))) for b in range(count)), finest


def _steps(name, own):
    found, names = {}, {}
    of, offset = own[0][1].of, own[0][1].offset
    for i, pattern in own:
        if pattern.step in found:
            raise InputError(
                f"patterns: axis {name}: phase step {pattern.step} appears twice "
                f"({names[pattern.step]} and {pattern.image}); remove one"
            )
        if (pattern.of, pattern.offset) != (of, offset):
            raise InputError(
                f"{pattern.image}: axis {name}: of {pattern.of}, offset "
                f"{pattern.offset:g} differ from {of}, {offset:g} in "
                f"{own[0][1].image}; give all steps of a code the same of and offset"
            )
        found[pattern.step], names[pattern.step] = i, pattern.image
    gap = next((k for k in range(of) if k not in found), None)
    if gap is not None:
        raise InputError(
            f"patterns: axis {name}: phase step {gap} of {of} is missing "
            f"(found {', '.join(names.values())}); add its image, or remove this code"
        )
    return tuple(found[k] for k in range(of))


def plan_arrays(codes, monitor_px, unit):
    """Return the CodePlan of the loops, without orders; all bits must have an inverse.

    unit: (2,) length of a monitor pixel along x and y in the unit of locations.
    """
    count = len(codes)
    max_bits = max(1, *(len(code.bits) for code in codes))
    max_steps = max(2, *(_even(len(code.steps)) for code in codes))
    pairs = np.zeros((count, max_bits, 2), np.int64)
    steps = np.zeros((count, 3, max_steps), np.int64)
    weights = np.zeros((count, 3, max_steps), np.float32)
    numbers = []
    for k, code in enumerate(codes):
        used, size = len(code.steps), monitor_px[code.axis]
        if code.bits:
            pairs[k, : len(code.bits)] = code.bits
        if used:
            for row, share in enumerate(code.sines.weights):
                # Nonzero weights come first, so that the loops can end early.
                order = np.argsort(share == 0, kind="stable")
                weights[k, row, :used] = share[order]
                steps[k, row] = code.steps[0]
                steps[k, row, :used] = np.array(code.steps)[order]
        period, length = code.period or code.cell, unit[code.axis]
        jump = period / code.cell if used else MAX_NEIGHBOUR_SHARE * size / code.cell
        edges = min(np.ceil(size / code.cell - WIDTH_TOL), 2 ** len(code.bits))
        numbers.append(
            (
                *(len(code.bits), _even(used), edges, max(1, round(jump))),
                *(code.cell / period, period * length, size * length, 2 / max(used, 1)),
            )
        )
    columns = list(zip(*numbers, strict=True))
    whole = (np.array(column, np.int64) for column in columns[:4])
    real = (np.array(column, np.float32) for column in columns[4:])
    unwrapped = np.array([bool(code.others) for code in codes], np.int64)
    orders = np.zeros((count, 0, 0), np.uint16)
    even = np.zeros(count, bool)
    return CodePlan(pairs, steps, weights, *whole, *real, unwrapped, orders, even)


def _even(count):
    return count + count % 2


def phase_weights(count: int, offset: float = 0.0) -> NDArray[np.float64]:
    """Return weights of the phase steps for B sin phi, B cos phi and the mean level.

    Step k is m + B sin(phi + 2 pi (k / N + offset)).

    Parameters
    ----------
    count : int
        Number N of phase steps.
    offset : float
        Offset of the first step in periods.

    Returns
    -------
    NDArray[np.float64]
        (3, N) weights.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.active_grid import phase_weights
    >>> phi = 0.3
    >>> steps = 100 + 50 * np.sin(phi + 2 * np.pi * np.arange(4) / 4)
    >>> sine, cosine, mean = phase_weights(4) @ steps
    >>> round(float(np.arctan2(sine, cosine)), 6), round(float(mean), 6)
    (0.3, 100.0)
    """
    angle = 2 * np.pi * (np.arange(count) / count + offset)
    waves = [2 * np.cos(angle), 2 * np.sin(angle), np.ones(count)]
    return np.round(waves, 12) / count


# The images of a view: checked against each other and stacked for the loops.


def checked_images(images, patterns):
    """Return the images if they match each other and the patterns, else raise."""
    if not len(images) or len(images) != len(patterns):
        raise InputError(
            f"images: found {len(images)} for {len(patterns)} patterns; give one per "
            "pattern, in the same order"
        )
    kinds = Counter((np.shape(image), image.dtype) for image in images)
    usual = kinds.most_common(1)[0][0]
    if len(kinds) > 1:
        k = next(k for k, i in enumerate(images) if (i.shape, i.dtype) != usual)
        found, dtype = images[k].shape, images[k].dtype
        raise InputError(
            f"{patterns[k].image}: {found} {dtype} differs from {usual[0]} {usual[1]} "
            "of the other images; save all images of a view in one size and depth"
        )
    if len(usual[0]) != 2 or usual[1] not in (np.uint8, np.uint16):
        raise InputError(
            f"images: found {usual[0]} {usual[1]}; give grey images, uint8 or uint16"
        )
    return images


class ImageStack:
    """Hold the images as one stack, block by block; every bit gets an inverse."""

    def __init__(self, images, patterns, monitor_px, white, black):
        """See `decode`; given_codes, codes: AxisCodes without and with inverses."""
        self.images, self.made = checked_images(images, patterns), []
        self.shape, self.dtype = np.shape(images[0]), images[0].dtype
        self.white, self.black = white, black
        self.names = [pattern.image for pattern in patterns]
        self.given_codes = read_coding(patterns, monitor_px)
        self.codes = tuple(map(self._completed, self.given_codes))
        whole = isinstance(images, np.ndarray) and images.flags.c_contiguous
        self.is_contiguous = whole and not self.made and self.dtype == np.uint16

    def _completed(self, code):
        bits = []
        for image, inverse in code.bits:
            if inverse is None:
                if not code.steps and (self.white is None or self.black is None):
                    alone = [k for k, other in code.bits if other is None]
                    files = ", ".join(self.names[k] for k in alone)
                    raise InputError(
                        f"patterns: axis {'xy'[code.axis]}: Gray code without inverse "
                        f"({files}); add the inverse images, or those of white and "
                        "black"
                    )
                inverse = len(self.images) + len(self.made)
                self.made.append((image, code.steps))
            bits.append((image, inverse))
        return replace(code, bits=tuple(bits))

    def rows(self, first, stop):
        """Return (stack, image row of its first row) with the rows that are needed.

        The stack is uint16 for images of either depth: one depth to compile loops for.
        """
        if self.is_contiguous:
            return self.images, 0
        start, end = (
            max(0, first - WINDOW_RADIUS),
            min(self.shape[0], stop + ROWS_AROUND),
        )
        block = np.empty(
            (len(self.images) + len(self.made), end - start, self.shape[1]), np.uint16
        )
        for k, image in enumerate(self.images):
            block[k] = image[start:end]
        for k, (image, steps) in enumerate(self.made, len(self.images)):
            block[k] = self._inverse(block, image, steps, slice(start, end))
        return block, start

    def _inverse(self, block, image, steps, part):
        """Return the inverse of an image: mirrored at the middle grey level."""
        if self.white is not None and self.black is not None:
            twice = self.white[part].astype(np.int32) + self.black[part]
        else:
            twice = np.rint(2 * np.mean(block[list(steps)], axis=0)).astype(np.int32)
        highest = np.iinfo(self.dtype).max
        return np.clip(twice - block[image], 0, highest)

    def difference(self, pair, where):
        """Return image minus inverse, float32, at an index into images."""
        light, inverse = pair
        value = self.images[light][where].astype(np.float32)
        if inverse < len(self.images):
            return value - self.images[inverse][where]
        if self.white is not None and self.black is not None:
            return 2 * value - self.white[where] - self.black[where]
        steps = self.made[inverse - len(self.images)][1]
        return 2 * value - 2 * np.mean([self.images[k][where] for k in steps], axis=0)

    def total(self, pair, where):
        """Return image plus inverse at an index, or None where no inverse was taken."""
        if pair[1] >= len(self.images):
            return None
        light, dark = (self.images[k][where].astype(np.float32) for k in pair)
        return light + dark

    def noise_images(self):
        """Return images with few edges: the sinusoids, else the coarsest bits."""

        sines = [k for code in self.codes for k in code.steps]
        coarse = [code.bits[0][0] for code in self.codes if code.bits]
        return [self.images[k] for k in sines[:8] or coarse]
