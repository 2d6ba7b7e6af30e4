"""Patterns of an active grid: one plan for simulator, decoder and command line.

Monitor pixel i covers [i, i + 1), so lengths in px count from the left or upper border
of the lit area. A Gray code of `of` bits counts 2^of cells from there. It may be longer
than the monitor, whose border then truncates it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raxel.errors import InputError
from raxel.sets.model import MonitorChessboard, Pattern

WHITE, BLACK, CHESSBOARD = "white.png", "black.png", "chessboard.png"
MIN_CELL_PX = 4  # narrower ones do not resolve a sinusoid
MAX_STEPS = 64
MIN_SQUARE_PX = 4


@dataclass(frozen=True)
class PatternPlan:
    """Plan the patterns that an active grid shows: (along x, along y), 0 for none.

    Attributes
    ----------
    gray_bits : tuple of int
        Bits of the Gray code.
    gray_inverse : bool
        Whether each Gray pattern has its inverse.
    phase_steps : int
        Number of phase steps.
    phase_periods : tuple of float
        Sinusoidal periods across the monitor.
    cell_px : tuple of float
        Width of the cells of the Gray code, monitor px; 0 where its 2^bits cells fill
        the monitor.
    phase_offset : float
        Phase of the first step, in periods; 0.25 for cosines.
    """

    gray_bits: tuple[int, int] = (0, 0)
    gray_inverse: bool = False
    phase_steps: int = 6
    phase_periods: tuple[float, float] = (0.0, 0.0)
    cell_px: tuple[float, float] = (0.0, 0.0)
    phase_offset: float = 0.0


def plan_of_cells(
    monitor_px: tuple[int, int],
    cells: int | Sequence[int] = 8,
    phase_steps: int = PatternPlan.phase_steps,
    offset: float = 0.0,
) -> PatternPlan:
    """Return the plan of 3.2.2: Gray code with inverse, one sine period for each cell.

    Cells are whole pixels wide, so that the edges of the code are where sinusoids
    begin. The last cell may exceed the border of the monitor. With four steps these are
    the 20 patterns of the thesis. Orders m N +- 1 of a non-linear response disturb N
    steps (Appendix A). Four steps are disturbed by the third order, which every monitor
    has. Six steps are disturbed from the fifth order on, which usual monitors hardly
    have.

    Parameters
    ----------
    monitor_px : tuple of int
        (width, height) of the monitor, px.
    cells : int or sequence of int
        Cells along both axes, or (along x, along y).
    phase_steps : int
        Number of phase steps.
    offset : float
        Phase of the first step, in periods.

    Returns
    -------
    PatternPlan
        The plan.

    Raises
    ------
    InputError
        If cells are too narrow, there is none, or there are fewer than three steps.

    References
    ----------
    Thesis 3.2.2 and Appendix A.

    Examples
    --------
    >>> from raxel.sets import patterns_of, plan_of_cells
    >>> plan = plan_of_cells((1920, 1080), phase_steps=4)
    >>> plan.gray_bits, plan.cell_px
    ((3, 3), (240, 135))
    >>> len(patterns_of(plan))
    20
    """
    if not 3 <= phase_steps <= MAX_STEPS:
        raise InputError(
            f"steps: {phase_steps} phase steps; give 3 to {MAX_STEPS} (4 as in the "
            "thesis, 6 or more for a nonlinear monitor)"
        )
    counts: Any = (cells, cells) if np.isscalar(cells) else tuple(cells)  # type: ignore[arg-type]
    bits, widths = [], []
    limits = " and ".join(
        f"{pixels // MIN_CELL_PX} along {axis}"
        for axis, pixels in zip("xy", monitor_px, strict=True)
    )
    for axis, count, pixels in zip("xy", counts, monitor_px, strict=True):
        if not 1 <= count * MIN_CELL_PX <= pixels:
            raise InputError(
                f"cells: {count} along {axis} on {pixels} px of the monitor; give 1 "
                f"to {limits}, each {MIN_CELL_PX} px or more"
            )
        widths.append(math.ceil(pixels / count))
        bits.append((count - 1).bit_length())
    periods = [size / w for size, w in zip(monitor_px, widths, strict=True)]
    both = tuple(periods), tuple(widths)
    return PatternPlan(tuple(bits), True, phase_steps, *both, float(offset))


def patterns_of(plan: PatternPlan) -> list[Pattern]:
    """Return the coded patterns of a plan, in file order.

    Parameters
    ----------
    plan : PatternPlan
        The plan.

    Returns
    -------
    list of Pattern
        The patterns.
    """
    patterns = []
    for axis, bits, width in zip("xy", plan.gray_bits, plan.cell_px, strict=True):
        for bit in range(bits):
            for inverse in (False, True)[: 1 + plan.gray_inverse]:
                name = f"gray-{axis}-{bit:02d}{'-inverse' * inverse}.png"
                code: dict[str, Any] = {"bit": bit, "of": bits, "inverse": inverse}
                code["cell_px"] = float(width) or None
                patterns.append(Pattern(name, axis, "gray", **code))
    for axis, periods in zip("xy", plan.phase_periods, strict=True):
        if periods:
            for step in range(plan.phase_steps):
                code = {"step": step, "of": plan.phase_steps, "periods": periods}
                code["offset"] = float(plan.phase_offset)
                name = f"phase-{axis}-{step}.png"
                patterns.append(Pattern(name, axis, "phase", **code))
    return patterns


def chessboard_of_corners(monitor_px, columns, rows):
    """Return the largest chessboard of so many corners, in the middle of the monitor.

    monitor_px: (width, height). Squares are whole pixels wide and as many around the
    corners as between them, so 15 x 15 corners take 16 x 16 squares. Raises InputError
    for too few corners, and for squares of less than MIN_SQUARE_PX.
    """
    squares = np.array([columns, rows]) + 1
    pitch = int(min(np.array(monitor_px) // squares))
    if min(columns, rows) < 3 or pitch < MIN_SQUARE_PX:
        raise InputError(
            f"chessboard: {columns} x {rows} corners on {monitor_px[0]} x "
            f"{monitor_px[1]} px of the monitor; give 3 or more along each axis, and "
            f"squares of {MIN_SQUARE_PX} px or more"
        )
    origin = (np.array(monitor_px) - pitch * squares) // 2 + pitch
    return MonitorChessboard(columns, rows, float(pitch), tuple(map(float, origin)))


def chessboard_image(
    board: MonitorChessboard, monitor_px: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return the image that the monitor receives for a chessboard.

    Parameters
    ----------
    board : MonitorChessboard
        The chessboard.
    monitor_px : tuple of int
        (width, height) of the monitor, px.

    Returns
    -------
    ndarray of uint8, shape (height, width)
        The image, 0 or 255.
    """
    place = [
        np.floor((np.arange(size) + 0.5 - first) / board.pitch_px).astype(int) + 1
        for size, first in zip(monitor_px, board.origin_px, strict=True)
    ]
    on = [
        (number >= 0) & (number <= count)
        for number, count in zip(place, (board.columns, board.rows), strict=True)
    ]
    black = np.add.outer(place[1], place[0]) % 2 == 1
    black &= np.logical_and.outer(on[1], on[0])
    return np.where(black, 0, 255).astype(np.uint8)


def cell_width(pattern: Pattern, monitor_px: tuple[int, int]) -> float:
    """Return the width of the cells of a Gray code, monitor px along its axis."""
    return pattern.cell_px or monitor_px["xy".index(pattern.axis)] / 2**pattern.of


def advance(pattern: Pattern) -> float:
    """Return the phase of a sine at the left or upper border, in periods."""
    return pattern.step / pattern.of + pattern.offset  # type: ignore[operator]


def pattern_image(pattern: Pattern, monitor_px: tuple[int, int]) -> NDArray[np.uint8]:
    """Return the image that the monitor receives for a pattern.

    Each pixel has the value of its centre. Values are linear in the sine; the response
    of the monitor is not included.

    Parameters
    ----------
    pattern : Pattern
        The pattern.
    monitor_px : tuple of int
        (width, height) of the monitor, px.

    Returns
    -------
    ndarray of uint8, shape (height, width)
        The image, 0 to 255.

    Examples
    --------
    >>> from raxel.sets import Pattern, pattern_image
    >>> gray = Pattern("gray.png", "x", "gray", of=2, bit=1)
    >>> pattern_image(gray, (8, 2))[0].tolist()
    [0, 0, 255, 255, 255, 255, 0, 0]
    """
    width, height = monitor_px
    size = width if pattern.axis == "x" else height
    place = np.arange(size) + 0.5
    if pattern.kind == "gray":
        cell = (place / cell_width(pattern, monitor_px)).astype(int)
        value = (cell ^ (cell >> 1)) >> (pattern.of - 1 - pattern.bit) & 1  # type: ignore[operator]
        value = 1 - value if pattern.inverse else value
    else:
        turns = pattern.periods * place / size  # type: ignore[operator]
        value = 0.5 + 0.5 * np.sin(2 * np.pi * (turns + advance(pattern)))
    line = np.rint(255 * value).astype(np.uint8)
    line = line[None, :] if pattern.axis == "x" else line[:, None]
    return np.ascontiguousarray(np.broadcast_to(line, (height, width)))


# Checks of the patterns in the set.yaml of an active grid.


# Of a monitor pixel, for widths that are not binary fractions.
MIN_CELL_WIDTH_PX = 1 - 1e-9


def pattern_faults(path, patterns, grid):
    """Yield the faults of one view as (path of the field, problem and what to do).

    path: of its list of patterns; grid: the set's ActiveGrid.
    """
    yield from _numbers(path, patterns)
    yield from _several_codes(path, patterns)
    yield from _gaps(path, patterns)
    yield from _inverses_alone(path, patterns)
    for index, pattern in enumerate(patterns):
        yield from _extent((*path, index), pattern, grid.monitor_px)


def _number(pattern):
    return pattern.bit if pattern.kind == "gray" else pattern.step


def _numbers(path, patterns):
    """Yield faults of bits and steps beyond their count, and of repeated patterns."""
    first = {}
    for index, pattern in enumerate(patterns):
        number, key = _number(pattern), "bit" if pattern.kind == "gray" else "step"
        if number >= pattern.of:
            fault = f"{number} is not one of 0 to {pattern.of - 1}"
            yield (*path, index, key), f"{fault}; correct {key} or of"
        code = pattern.axis, pattern.kind, pattern.of, pattern.inverse, pattern.periods
        earlier = first.setdefault((*code, number), index)
        if earlier != index:
            fault = f"same pattern as patterns[{earlier}]"
            yield (*path, index), f"{fault}; correct axis, {key} or inverse"


def _gaps(path, patterns):
    """Yield a fault for a bit missing above a present one, or a missing phase step.

    Gray code is decoded from the most significant bit down: fine bits may be omitted,
    but bits below a gap cannot be decoded.
    """
    groups = {}
    for pattern in patterns:
        code = pattern.axis, pattern.kind, pattern.of, pattern.periods
        groups.setdefault(code, set()).add(_number(pattern))
    for (axis, kind, of, _), present in groups.items():
        needed = range(max(present) + 1) if kind == "gray" else range(of)
        gap = next((number for number in needed if number not in present), None)
        if gap is not None:
            name = "bit" if kind == "gray" else "step"
            fault = f"{kind} code of axis {axis} lacks {name} {gap} of {of}"
            yield path, f"{fault}; add its image or remove this code"


def _inverses_alone(path, patterns):
    gray = [pattern for pattern in patterns if pattern.kind == "gray"]
    upright = {(pattern.axis, pattern.bit) for pattern in gray if not pattern.inverse}
    for index, pattern in enumerate(patterns):
        alone = pattern.kind == "gray" and (pattern.axis, pattern.bit) not in upright
        if alone:
            fault = f"bit {pattern.bit} of axis {pattern.axis} has only its inverse"
            yield (*path, index), f"{fault}; add the image with inverse: false"


def _several_codes(path, patterns):
    """Yield faults of several codes along one axis.

    Two Gray codes, or sinusoids of one period with different steps or offsets.
    """
    first = {}
    for index, pattern in enumerate(patterns):
        fields = {"of": pattern.of}
        if pattern.kind == "gray":
            fields["cell_px"] = pattern.cell_px
        else:
            fields["offset"] = pattern.offset
        code = pattern.axis, pattern.kind, pattern.periods
        earlier, before = first.setdefault(code, (index, fields))
        for key in (key for key in fields if fields[key] != before[key]):
            fault = (
                f"{_number_text(fields[key])} differs from {_number_text(before[key])}"
            )
            where = f"patterns[{earlier}] of the same code"
            yield (*path, index, key), f"{fault} in {where}; give one code per axis"


def _number_text(value):
    return "none" if value is None else f"{value:g}"


def _extent(path, pattern, monitor_px):
    """Yield a fault for a code too fine for the monitor, or narrower than it."""
    pixels = monitor_px["xy".index(pattern.axis)]
    if pattern.kind == "phase":
        if 2 * pattern.periods > pixels:
            fault = f"{pattern.periods:g} periods on {pixels} px of the monitor"
            advice = f"give at most {pixels // 2}, or correct target.monitor_px"
            yield (*path, "periods"), f"{fault}; {advice}"
        return
    cell = cell_width(pattern, monitor_px)
    if cell < MIN_CELL_WIDTH_PX:
        fault = f"{2**pattern.of} cells of {cell:.3g} px on {pixels} px of the monitor"
        advice = "correct of, or give cell_px: 1 if the code counts pixels"
        yield (*path, "of"), f"{fault}; {advice}"
    elif cell * 2**pattern.of < MIN_CELL_WIDTH_PX * pixels:
        fault = f"{2**pattern.of} cells of {cell:g} px do not cover {pixels} px of the"
        advice = "correct cell_px, of or target.monitor_px"
        yield (*path, "cell_px"), f"{fault} monitor; {advice}"
