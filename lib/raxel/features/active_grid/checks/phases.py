"""Do the phase steps follow one another, and begin where the cells of the code do?"""

import numpy as np

from raxel.features.active_grid.checks.edges import phases_at_edges
from raxel.features.active_grid.checks.frequencies import frequency_doubts
from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.steps import (
    circle_order,
    every_turned,
    faulty_pictures,
    nearest_turned,
    put_right,
    told_offset,
)

# Length of the mean of unit vectors. Without inverses a tone curve moves edges to dark
# and to bright apart, as far as blur reaches.
TOGETHER, TOGETHER_ALONE = 0.7, 0.3
OFF_CODE = 0.08  # periods
OFF_STEP = 0.45  # of a step: less is no exchange of steps


def phase_doubts(sample, noise):
    """Doubts about the phase steps of a Sample; noise: a Noise."""
    found = []
    for axis, code in enumerate(sample.codes):
        if not code.steps:
            continue
        every = code.sines, *code.others
        faults = [f for sines in every for f in faulty_pictures(sample, axis, sines)]
        if not faults:
            orders = [circle_order(sample, sines) for sines in every]
            faults = list(_out_of_order(sample, axis, every, orders))
        if not faults and code.others:
            faults = list(frequency_doubts(sample, axis, noise))
        found += faults
    return found


def _out_of_order(sample, axis, every, orders):
    """Doubts about orders of pictures, each of some Sines, the first by its code."""
    for sines, order in zip(every, orders, strict=True):
        at_edges = ((),) * 3
        if sines is every[0]:
            pictures = [sines.steps[k] for k in order]
            at_edges = phases_at_edges(sample, axis, pictures)
        if len(at_edges[0]):
            yield from edge_doubts(sample, axis, order, *at_edges)
        elif not _as_listed(order):
            yield _not_in_order(sample, axis, sines, order, every_turned(len(order)))


def _as_listed(order):
    return all(j == k for j, k in enumerate(order))


def _not_in_order(sample, axis, sines, order, ways):
    """ways: of the order round the circle, each a Turned."""
    names = [sample.names[k] for k in sines.steps]
    told = put_right(names, [turned.shown(order) for turned in ways])
    along = "xy"[sample.codes[axis].axis]
    return Doubt(True, f"the phase steps along {along} are not in order: {told}")


def edge_doubts(sample, axis, order, phase, due, along):
    """Doubts by phases at edges; order: of pictures, the others `phases_at_edges`."""
    code = sample.codes[axis]
    name, names = "xy"[code.axis], [sample.names[k] for k in code.steps]
    # Where sines are clipped, they stand still.
    backwards = bool(np.mean(along < 0) > 0.5)
    mean = np.mean((-np.conj(phase) if backwards else phase) * np.conj(due))
    where = f"the sines along {name} ({names[0]} to {names[-1]})"
    alone = any(dark is None for _, dark in code.bits)
    if abs(mean) < (TOGETHER_ALONE if alone else TOGETHER):
        yield Doubt(
            True,
            f"{where} do not fit the cells of its Gray code "
            f"({_of_code(sample, code)}); mend periods, cell_px, of or axis",
        )
        return
    turns = np.angle(mean) / (2 * np.pi)
    turned = nearest_turned(turns, backwards, code.sines)
    if backwards:
        what = f"the phase along {name} falls where its Gray code rises"
        yield Doubt(True, f"{what}: {_ways(sample, code, order, turned, phase, due)}")
    elif not _as_listed(order):
        ways = [turned] if turned else every_turned(len(order))
        yield _not_in_order(sample, axis, code.sines, order, ways)
    elif abs(turns) > OFF_CODE:
        there = f"give offset: {told_offset(code.sines.offset + turns)}"
        advice = f": {there} if they begin there, or mend step or inverse of its bits"
        if abs(turns) < OFF_STEP / len(names):
            advice = (
                ", as if something had moved; take all pictures in one pose, or "
                f"{there} if they begin there"
            )
        elif turned:
            steps = put_right(names, [turned.shown(order)])
            advice = f": {steps}, or {there} if they begin there"
        off = f"begin {abs(turns):.2f} periods off the cells of its Gray code"
        yield Doubt(True, f"{where} {off}{advice}")


def _ways(sample, code, order, turned, phase, due):
    """What makes phases fall where cells rise: steps, or bit 0 and its inverse."""
    names, ways = [sample.names[k] for k in code.steps], []
    if turned is not None:
        ways.append(put_right(names, [turned.shown(order)]))
    # With bit 0 turned over, cells count from the other end.
    last = np.exp(2j * np.pi * 2 ** len(code.bits) * code.cell / code.period)
    off = np.angle(np.mean(phase * due * np.conj(last))) / (2 * np.pi)
    if abs(off) < OFF_CODE and _as_listed(order):
        light, dark = code.bits[0]
        if dark is None:
            ways.append(f"{sample.names[light]} shows its inverse: mend inverse")
        else:
            pair = f"{sample.names[light]} and {sample.names[dark]}"
            ways.append(f"{pair} are in each other's place: exchange them")
    every = f"{names[0]} to {names[-1]} and {_of_code(sample, code)}"
    return ", or ".join(ways) or f"mend step, bit and inverse of {every}"


def _of_code(sample, code):
    """The pictures of a Gray code, as messages name them."""
    names = [sample.names[k] for pair in code.bits for k in pair if k is not None]
    return f"{names[0]} to {names[-1]}"
