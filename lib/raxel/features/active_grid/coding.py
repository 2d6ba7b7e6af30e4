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


@dataclass(frozen=True)
class AxisCode:
    """What is there of one axis: pictures by their place in the stack.

    bits: (picture, inverse) from the coarsest, None where no inverse was taken; steps:
    pictures in the order of their phase; cell, period: px of the monitor.
    """

    axis: int
    bits: tuple[tuple[int, int | None], ...]
    steps: tuple[int, ...]
    cell: float
    period: float | None


def read_coding(patterns, monitor_px):
    """The AxisCodes of the pictures whose Patterns these are, in the pictures' order.

    monitor_px: (width, height). Of several phase codes of an axis the finest is taken
    whose periods the Gray code tells apart. Raises InputError for patterns that appear
    twice, for gaps, and for an axis whose periods cannot be told apart.
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
    cell = cell or float(size)
    phases = defaultdict(list)
    for i, pattern in own:
        if pattern.kind == "phase":
            phases[pattern.periods].append((i, pattern))
    if not phases:
        return AxisCode(axis, bits, (), cell, None)
    usable = [n for n in phases if size / n >= cell * (1 - SLACK)]
    if not usable:
        found = "no Gray code" if not bits else f"cells of {cell:g} px"
        raise InputError(
            f"patterns: axis {name}: found periods of {size / min(phases):g} px and "
            f"{found}, which do not tell them apart; add Gray code of at least as "
            "many cells as there are periods"
        )
    periods = max(usable)
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
    return AxisCode(axis, bits, steps, cell, size / periods)


def _gray(name, own, monitor_px):
    """((picture, inverse), ...) by bit, and the width of the finest cell; (), None."""
    if not own:
        return (), None
    found = {}
    for i, pattern in own:
        if (pattern.bit, pattern.inverse) in found:
            raise InputError(
                f"patterns: axis {name}: bit {pattern.bit} appears twice; leave one out"
            )
        found[pattern.bit, pattern.inverse] = i
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
    found = {}
    for i, pattern in own:
        if pattern.step in found:
            raise InputError(
                f"patterns: axis {name}: phase step {pattern.step} appears twice; "
                "leave one out"
            )
        found[pattern.step] = i
    of = own[0][1].of
    gap = next((k for k in range(of) if k not in found), None)
    if gap is not None:
        raise InputError(
            f"patterns: axis {name}: phase step {gap} of {of} is missing; give its "
            "picture, or leave this code out"
        )
    return tuple(found[k] for k in range(of))


def plan_arrays(codes, monitor_px, unit):
    """The CodePlan of the loops; all bits must have an inverse.

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
            for row, share in enumerate(phase_weights(used)):
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
    return CodePlan(pairs, steps, weights, *whole, *real)


def _even(count):
    return count + count % 2


def phase_weights(count):
    """(3, N): of the steps for B sin phi, B cos phi and the mean level.

    Step k is m + B sin(phi + 2 pi k / N).
    """
    angle = 2 * np.pi * np.arange(count) / count
    waves = [2 * np.cos(angle), 2 * np.sin(angle), np.ones(count)]
    return np.round(waves, 12) / count
