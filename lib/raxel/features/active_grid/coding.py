"""What the images of an active grid encode, in the form that the loops take."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from raxel.errors import InputError
from raxel.sets.patterns import cell_width

# What the decoder's compiled loops share: kinds of pixels, a plan, rows kept. The
# loops keep what they found in a few rows of the image, in rings: row y lies at y
# modulo their length.


DECODED, FILLED, DARK, SATURATED, UNREADABLE = range(5)
ALONE, BESIDE, RIM, BREAK = range(5, 9)

UNKNOWN = 65535  # in CodePlan.orders: no cell
# Of the modulation of bright pixels: less is the dark beside the monitor, where noise
# has harmonics of every kind, or light that tells little.
LIT, BRIGHT = 0.2, 99
REACH = 3  # of the smoothing window, 7 x 7, to each side
AHEAD = REACH + 1  # rows read before one is decoded: breaks need one more
SQUARE = 32  # px; in each such square of the image a bias is taken as the same
ROWS_A_CALL = 16
KEPT = 24  # rows in a ring: those of a call, as many as AHEAD before and behind
# Images are decoded in strips of columns, at most so wide. Fields of one array lie at
# distances known when loops are compiled: only then many arrays can run in one loop.
STRIP = 2048
PITCH = STRIP + 80  # from field to field: multiples of 4096 bytes hinder each other
SINE, COSINE, VARIANCE = 0, PITCH, 2 * PITCH  # of Rows.waves
LOWEST, SECOND, HIGHEST, APART = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.greys
BAD, RIGHT, BELOW, CROSSED = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.marks
LEVEL, SINES, COSINES, TURN = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.work
SPREAD, PERIOD, OFF, PLACE = 4 * PITCH, 5 * PITCH, 6 * PITCH, 7 * PITCH
SIGMA, WORK = 8 * PITCH, 9 * PITCH
OWN, DOUBT, LOST = 0, PITCH, 2 * PITCH  # of Rows.flags
BREAKS, MIXED, STATUS = 0, PITCH, 2 * PITCH  # of Rows.common


class CodePlan(NamedTuple):
    """What the images of a stack encode along A axes (`coding.plan_arrays`).

    pairs: (A, bits, 2), image and inverse of each bit; steps, weights: (A, 3, K), of
    the phase steps for sine, cosine and level, weights float32. int64 (A,): bits; used
    steps, rounded up to an even number; edges, the first edge behind the last cell that
    is shown; jump, cells between neighbours above which they see different surfaces.
    float32 (A,): ratio of cell to period; length of a period and extent of the monitor
    in the unit of locations; spread 2 / N of N steps. told: (A,) int64, whether cells
    are those of `orders`, (A, H, W) uint16, told by sines (`orders.period_cells`).
    uneven: (A,) bool, whether the variance of a phase changes within windows.
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
    told: np.ndarray
    orders: np.ndarray
    uneven: np.ndarray

    @property
    def reach(self):
        """(A,) float32: how far apart neighbours may lie that see one surface."""
        return self.length * self.ratio * self.jump.astype(np.float32) / 2


class Ripples(NamedTuple):
    """By what phases of A axes are off (`response.Ripple`, `ripple`).

    steps, times: (A,) int64, 0 where nothing is; origin: (A, 2), share: (A, 6), terms:
    (A, 3) float32; across, down: float32, from columns and rows to the shares of the
    image, less 1.
    """

    steps: np.ndarray
    origin: np.ndarray
    times: np.ndarray
    share: np.ndarray
    terms: np.ndarray
    across: np.float32
    down: np.float32


class Rows(NamedTuple):
    """Rows of a strip, field after field of at most STRIP columns, PITCH apart.

    Rings, the row second or first. waves: (A, KEPT, 3 PITCH) float32: sine and cosine
    of unit length, and the variance of a pixel's phase in squared turns. codes:
    (A, KEPT, PITCH) uint16, the cell. greys: (A, KEPT, 4 PITCH), as the images:
    least, second least and most distance of an image from its inverse, the last one of
    all axes in axis 0; that of one image. marks: (KEPT, 4 PITCH) uint8: why a pixel
    is not decoded; whether it breaks with the next one to the right, and below; either
    or bad.

    Rows to work in. work: (A, WORK) float32: the mean grey value; sums over seven rows;
    the phase that is taken and its variance; period; by how much it is off; place and
    its standard deviation. flags: (A, 3 PITCH) uint8: set where a phase is that of one
    pixel; in doubt; lost. common: (3 PITCH,) uint8: breaks in seven rows and in a
    window; status. asked: (STRIP,) int64, pixels picked out.
    """

    waves: np.ndarray
    codes: np.ndarray
    greys: np.ndarray
    marks: np.ndarray
    work: np.ndarray
    flags: np.ndarray
    common: np.ndarray
    asked: np.ndarray


class Strip(NamedTuple):
    """Columns of the image: those that are read, and those that are decoded."""

    start: int
    width: int
    first: int
    stop: int


def strips_of(width):
    """[Strip, ...] of equal width that cover an image, AHEAD columns around each."""
    around = 2 * AHEAD
    count = max(1, -(-(width - around) // (STRIP - around)))
    own = -(-(width + (count - 1) * around) // count)
    own = min(-(-own // 64) * 64, STRIP, width)
    starts = [k * (width - own) // max(count - 1, 1) for k in range(count)]
    ends = [0, *(start + AHEAD for start in starts[1:]), width]
    return [Strip(starts[k], own, ends[k], ends[k + 1]) for k in range(count)]


def empty_rows(axes, dtype):
    """Rows for images of this type."""
    return Rows(
        np.zeros((axes, KEPT, 3 * PITCH), np.float32),
        np.zeros((axes, KEPT, PITCH), np.uint16),
        np.zeros((axes, KEPT, 4 * PITCH), dtype),
        np.zeros((KEPT, 4 * PITCH), np.uint8),
        np.zeros((axes, WORK), np.float32),
        np.zeros((axes, 3 * PITCH), np.uint8),
        np.zeros(3 * PITCH, np.uint8),
        np.zeros(STRIP, np.int64),
    )


MAX_BITS = 15
# Of a code without phases: cells between neighbours that see the same surface, as a
# share of the monitor.
NEIGHBOURS = 1 / 32
SLACK = 1e-6  # of a cell, for widths that are no binary fractions
# Cells of a period whose number other sines tell: a place is known to a part of it.
CELLS = 4
MAX_PERIODS = 10_000  # of such; their cells are counted in 16 bits
# Periods by which sines of two places must differ to be told apart: four grey levels of
# a sine that has all of 8 bits.
MIN_APART = 0.005


@dataclass(frozen=True)
class Sines:
    """Sines of one period, px of the monitor; steps: images by their place in the
    stack, in the order of their phase; offset: of the first step, in periods."""

    steps: tuple[int, ...]
    period: float
    offset: float = 0.0

    @property
    def weights(self):
        """(3, N): as `phase_weights`."""
        return phase_weights(len(self.steps), self.offset)


@dataclass(frozen=True)
class AxisCode:
    """What is there of one axis: images by their place in the stack.

    bits: (image, inverse) from the coarsest, None where no inverse was taken; sines:
    those that places are read from, None where there are none; others: whose periods,
    in the place of a Gray code, tell which period of these a pixel sees; cell: px of
    the monitor.
    """

    axis: int
    bits: tuple[tuple[int, int | None], ...]
    sines: Sines | None
    cell: float
    others: tuple[Sines, ...] = ()

    @property
    def steps(self):
        """The images of the sines that places are read from, in their order."""
        return self.sines.steps if self.sines else ()

    @property
    def period(self):
        """Of these sines, px of the monitor; None where there are none."""
        return self.sines.period if self.sines else None


def read_coding(patterns, monitor_px):
    """The AxisCodes of the images whose Patterns these are, in the images' order.

    monitor_px: (width, height). Of several phase codes of an axis the finest is taken
    whose periods the Gray code tells apart; without one, all are taken. Raises
    InputError for patterns that appear twice, for gaps, and for an axis whose periods
    cannot be told apart.
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
    usable = [n for n in phases if size / n >= cell * (1 - SLACK)]
    if not usable:
        found = "no Gray code" if not bits else f"cells of {cell:g} px"
        raise InputError(
            f"patterns: axis {name}: found periods of {size / min(phases):g} px and "
            f"{found}, which do not tell them apart{_files(own)}; add Gray code of at "
            "least as many cells as there are periods"
            + " or, in its place, a sine of one period"
            * (not bits)
        )
    return AxisCode(axis, bits, _sines(name, phases, max(usable), size), cell)


def _without_gray(axis, phases, size):
    """The AxisCode of sines that tell by themselves which period is seen."""
    name, finest = "xy"[axis], max(phases)
    others = [_sines(name, phases, n, size) for n in sorted(phases) if n != finest]
    sines = _sines(name, phases, finest, size)
    if finest > MAX_PERIODS:
        raise InputError(
            f"patterns: axis {name}: found {finest:g} periods without Gray code; give "
            f"at most {MAX_PERIODS}"
        )
    apart = places_apart(np.array([finest, *(size / one.period for one in others)]))
    alike = np.flatnonzero(apart < MIN_APART)
    if len(alike):
        own = [one for some in phases.values() for one in some]
        periods = " and ".join(f"{size / n:g} px" for n in sorted(phases))
        raise InputError(
            f"patterns: axis {name}: sines of {periods} look the same again after "
            f"{(alike[0] + 1) * sines.period:.4g} px of the monitor's {size}"
            f"{_files(own)}; add a sine of one period or Gray code, or give periods "
            "that meet again beyond the monitor"
        )
    return AxisCode(axis, (), sines, sines.period / CELLS, tuple(others))


def places_apart(periods):
    """(M,): by how much sines differ at places m = 1 to M of the first's periods apart.

    periods: (F,) across the monitor, M of the first ones fit on it. The length of what
    remains of the differences of phase, in periods, when a change of place has
    explained what it can.
    """
    first, others = periods[0], periods[1:]
    apart = np.arange(1, max(int(np.ceil(first * (1 - SLACK))), 1))[:, None]
    off = apart * others / first
    off = off - np.round(off)
    explained = (off @ others) ** 2 / np.sum(periods**2)
    return np.sqrt(np.maximum(np.sum(off**2, axis=1) - explained, 0))


def _files(own):
    """The images concerned, as messages name them."""
    names = [pattern.image for _, pattern in own]
    return f" ({names[0]} to {names[-1]})" if len(names) > 1 else f" ({names[0]})"


def _sines(name, phases, periods, size):
    """The Sines of so many periods. Raises InputError as `read_coding`."""
    try:
        steps = _steps(name, phases[periods])
    except InputError as fault:
        if len(phases) == 1:
            raise
        found = ", ".join(f"{n:g}" for n in sorted(phases))
        raise InputError(
            f"{fault} (periods of axis {name}: found {found}; those of one code are "
            "the same)"
        ) from fault
    return Sines(steps, size / periods, phases[periods][0][1].offset)


def _gray(name, own, monitor_px):
    """((image, inverse), ...) by bit, and the width of the finest cell; (), None."""
    if not own:
        return (), None
    found, names = {}, {}
    for i, pattern in own:
        key = pattern.bit, pattern.inverse
        if key in found:
            raise InputError(
                f"patterns: axis {name}: bit {pattern.bit} appears twice "
                f"({names[key]} and {pattern.image}); leave one out"
            )
        found[key], names[key] = i, pattern.image
    count = 1 + max(bit for bit, _ in found)
    gap = next((b for b in range(count) if (b, False) not in found), None)
    if gap is not None:
        raise InputError(
            f"patterns: axis {name}: Gray code lacks bit {gap}; give its image"
        )
    if count > MAX_BITS:
        raise InputError(
            f"patterns: axis {name}: found {count} bits; give at most {MAX_BITS}, and "
            "leave out what is finer than a pixel of the monitor"
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
                f"({names[pattern.step]} and {pattern.image}); leave one out"
            )
        if (pattern.of, pattern.offset) != (of, offset):
            raise InputError(
                f"{pattern.image}: axis {name}: found of: {pattern.of} and offset: "
                f"{pattern.offset:g}, but {of} and {offset:g} in {own[0][1].image}; "
                "steps of one code share both"
            )
        found[pattern.step], names[pattern.step] = i, pattern.image
    gap = next((k for k in range(of) if k not in found), None)
    if gap is not None:
        raise InputError(
            f"patterns: axis {name}: phase step {gap} of {of} is missing beside "
            f"{', '.join(names.values())}; give its image, or leave this code out"
        )
    return tuple(found[k] for k in range(of))


def plan_arrays(codes, monitor_px, unit):
    """The CodePlan of the loops, without orders; all bits must have an inverse.

    unit: (2,) length of a monitor pixel along x and y in the unit of locations.
    """
    count = len(codes)
    most_bits = max(1, *(len(code.bits) for code in codes))
    most_steps = max(2, *(_even(len(code.steps)) for code in codes))
    pairs = np.zeros((count, most_bits, 2), np.int64)
    steps = np.zeros((count, 3, most_steps), np.int64)
    weights = np.zeros((count, 3, most_steps), np.float32)
    numbers = []
    for k, code in enumerate(codes):
        used, size = len(code.steps), monitor_px[code.axis]
        if code.bits:
            pairs[k, : len(code.bits)] = code.bits
        if used:
            for row, share in enumerate(code.sines.weights):
                # Those that count come first, so that the loops can end there.
                order = np.argsort(share == 0, kind="stable")
                weights[k, row, :used] = share[order]
                steps[k, row] = code.steps[0]
                steps[k, row, :used] = np.array(code.steps)[order]
        period, length = code.period or code.cell, unit[code.axis]
        jump = period / code.cell if used else NEIGHBOURS * size / code.cell
        edges = min(np.ceil(size / code.cell - SLACK), 2 ** len(code.bits))
        numbers.append(
            (
                *(len(code.bits), _even(used), edges, max(1, round(jump))),
                *(code.cell / period, period * length, size * length, 2 / max(used, 1)),
            )
        )
    columns = list(zip(*numbers, strict=True))
    whole = (np.array(column, np.int64) for column in columns[:4])
    real = (np.array(column, np.float32) for column in columns[4:])
    told = np.array([bool(code.others) for code in codes], np.int64)
    orders = np.zeros((count, 0, 0), np.uint16)
    even = np.zeros(count, bool)
    return CodePlan(pairs, steps, weights, *whole, *real, told, orders, even)


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


# The images of a view: whether they fit each other, and in the form of the loops.


def checked_pictures(images, patterns):
    """The images, if they fit each other and the patterns."""
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
            f"{patterns[k].image}: found an image {found} {dtype} among those "
            f"{usual[0]} {usual[1]}; give all of a view in one size and depth"
        )
    if len(usual[0]) != 2 or usual[1] not in (np.uint8, np.uint16):
        raise InputError(
            f"images: found images {usual[0]} {usual[1]}; give grey ones, uint8 or "
            "uint16"
        )
    return images


class PictureStack:
    """The images as one stack in which every bit has an inverse, block by block."""

    def __init__(self, images, patterns, monitor_px, white, black):
        """As `decode.decode`; seen, codes: AxisCodes without and with what is made."""
        self.images, self.made = checked_pictures(images, patterns), []
        self.shape, self.dtype = np.shape(images[0]), images[0].dtype
        self.white, self.black = white, black
        self.names = [pattern.image for pattern in patterns]
        self.seen = read_coding(patterns, monitor_px)
        self.codes = tuple(map(self._completed, self.seen))
        whole = isinstance(images, np.ndarray) and images.flags.c_contiguous
        self.as_it_lies = whole and not self.made

    def _completed(self, code):
        bits = []
        for image, inverse in code.bits:
            if inverse is None:
                if not code.steps and (self.white is None or self.black is None):
                    alone = [k for k, other in code.bits if other is None]
                    files = ", ".join(self.names[k] for k in alone)
                    raise InputError(
                        f"patterns: axis {'xy'[code.axis]}: Gray code without inverse "
                        f"({files}); give the inverse images, or those of white and "
                        "black"
                    )
                inverse = len(self.images) + len(self.made)
                self.made.append((image, code.steps))
            bits.append((image, inverse))
        return replace(code, bits=tuple(bits))

    def rows(self, first, stop):
        """(stack, the image's row where it begins) with what is needed around."""
        if self.as_it_lies:
            return self.images, 0
        start, end = max(0, first - REACH), min(self.shape[0], stop + AHEAD)
        block = np.empty(
            (len(self.images) + len(self.made), end - start, self.shape[1]), self.dtype
        )
        for k, image in enumerate(self.images):
            block[k] = image[start:end]
        for k, (image, steps) in enumerate(self.made, len(self.images)):
            block[k] = self._inverse(block, image, steps, slice(start, end))
        return block, start

    def _inverse(self, block, image, steps, part):
        """What an inverse would have shown, as far from the middle."""
        if self.white is not None and self.black is not None:
            twice = self.white[part].astype(np.int32) + self.black[part]
        else:
            twice = np.rint(2 * np.mean(block[list(steps)], axis=0)).astype(np.int32)
        most = np.iinfo(self.dtype).max
        return np.clip(twice - block[image], 0, most)

    def apart(self, pair, where):
        """An image of `codes` less its inverse, float32, at an index into images."""
        light, inverse = pair
        value = self.images[light][where].astype(np.float32)
        if inverse < len(self.images):
            return value - self.images[inverse][where]
        if self.white is not None and self.black is not None:
            return 2 * value - self.white[where] - self.black[where]
        steps = self.made[inverse - len(self.images)][1]
        return 2 * value - 2 * np.mean([self.images[k][where] for k in steps], axis=0)

    def together(self, pair, where):
        """As `apart`, an image and its inverse, or None where none was taken."""
        if pair[1] >= len(self.images):
            return None
        light, dark = (self.images[k][where].astype(np.float32) for k in pair)
        return light + dark

    def for_noise(self):
        """Pictures without many edges: the sines, else the coarsest bits."""
        sines = [k for code in self.codes for k in code.steps]
        coarse = [code.bits[0][0] for code in self.codes if code.bits]
        return [self.images[k] for k in sines[:8] or coarse]
