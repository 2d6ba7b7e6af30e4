"""What the pictures of an active grid encode, in the form that the loops take."""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.layout import CodePlan
from raxel.sets.patterns import cell_width

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
    """Sines of one period, px of the monitor; steps: pictures by their place in the
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
    """What is there of one axis: pictures by their place in the stack.

    bits: (picture, inverse) from the coarsest, None where no inverse was taken; sines:
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
        """The pictures of the sines that places are read from, in their order."""
        return self.sines.steps if self.sines else ()

    @property
    def period(self):
        """Of these sines, px of the monitor; None where there are none."""
        return self.sines.period if self.sines else None


def read_coding(patterns, monitor_px):
    """The AxisCodes of the pictures whose Patterns these are, in the pictures' order.

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
        raise InputError(
            "patterns: none; give the pictures of a Gray code or of phases"
        )
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
    """The pictures concerned, as messages name them."""
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
    """((picture, inverse), ...) by bit, and the width of the finest cell; (), None."""
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
            f"patterns: axis {name}: Gray code lacks bit {gap}; give its picture"
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
            f"{', '.join(names.values())}; give its picture, or leave this code out"
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


def phase_weights(count, offset=0.0):
    """(3, N): of the steps for B sin phi, B cos phi and the mean level.

    Step k is m + B sin(phi + 2 pi (k / N + offset)).
    """
    angle = 2 * np.pi * (np.arange(count) / count + offset)
    waves = [2 * np.cos(angle), 2 * np.sin(angle), np.ones(count)]
    return np.round(waves, 12) / count
