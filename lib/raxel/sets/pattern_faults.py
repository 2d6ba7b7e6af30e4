"""Faults of the patterns that an active grid's set.yaml lists: what codes lack."""

from raxel.sets.patterns import cell_width

WHOLE = 1 - 1e-9  # of a monitor pixel, for widths that are no binary fractions


def pattern_faults(path, patterns, grid):
    """Faults of one view, as (path of the field, what was found and what to do).

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
    """Bits and steps beyond their count, and patterns that are there twice."""
    seen = {}
    for index, pattern in enumerate(patterns):
        number, key = _number(pattern), "bit" if pattern.kind == "gray" else "step"
        if number >= pattern.of:
            fault = (
                f"found {number}, but there are {pattern.of} (0 to {pattern.of - 1})"
            )
            yield (*path, index, key), f"{fault}; mend {key} or of"
        code = pattern.axis, pattern.kind, pattern.of, pattern.inverse, pattern.periods
        earlier = seen.setdefault((*code, number), index)
        if earlier != index:
            fault = (
                f"the same pattern as patterns[{earlier}]; mend axis, {key} or inverse"
            )
            yield (*path, index), fault


def _gaps(path, patterns):
    """A bit that is missing above a present one, or a missing phase step.

    Gray code is decoded from the most significant bit down: fine bits may be left out,
    but nothing can be read below a gap.
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
            yield path, f"{fault}; add its image or leave that code out"


def _inverses_alone(path, patterns):
    gray = [pattern for pattern in patterns if pattern.kind == "gray"]
    upright = {(pattern.axis, pattern.bit) for pattern in gray if not pattern.inverse}
    for index, pattern in enumerate(patterns):
        alone = pattern.kind == "gray" and (pattern.axis, pattern.bit) not in upright
        if alone:
            fault = f"bit {pattern.bit} of axis {pattern.axis} has only its inverse"
            yield (*path, index), f"{fault}; add the picture with inverse: false"


def _several_codes(path, patterns):
    """Two Gray codes along one axis, or sines of the same periods that differ in their
    count of steps or where they begin."""
    first = {}
    for index, pattern in enumerate(patterns):
        said = {"of": pattern.of}
        if pattern.kind == "gray":
            said["cell_px"] = pattern.cell_px
        else:
            said["offset"] = pattern.offset
        code = pattern.axis, pattern.kind, pattern.periods
        earlier, before = first.setdefault(code, (index, said))
        for key in (key for key in said if said[key] != before[key]):
            fault = f"found {_told(said[key])}, but {_told(before[key])} in "
            fault = f"{fault}patterns[{earlier}] of the same code; give one code along "
            yield (*path, index, key), f"{fault}each axis"


def _told(value):
    return "none" if value is None else f"{value:g}"


def _extent(path, pattern, monitor_px):
    """A code that the monitor cannot show, or that does not reach across it."""
    pixels = monitor_px["xy".index(pattern.axis)]
    if pattern.kind == "phase":
        if 2 * pattern.periods > pixels:
            fault = f"found {pattern.periods:g} periods on {pixels} px of the monitor"
            fault = f"{fault}, which shows at most {pixels // 2}; mend periods or "
            yield (*path, "periods"), f"{fault}target.monitor_px"
        return
    cell = cell_width(pattern, monitor_px)
    if cell < WHOLE:
        fault = f"found {2**pattern.of} cells on {pixels} px of the monitor, {cell:.3g}"
        fault = f"{fault} px each; give cell_px: 1 where the code counts pixels, or"
        yield (*path, "of"), f"{fault} mend of"
    elif cell * 2**pattern.of < WHOLE * pixels:
        fault = f"found cells of {cell:g} px, and {2**pattern.of} of them do not reach"
        fault = f"{fault} across {pixels} px of the monitor; mend cell_px, of or "
        yield (*path, "cell_px"), f"{fault}target.monitor_px"
