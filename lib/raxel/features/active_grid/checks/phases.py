"""Do the phase steps follow one another, and begin where the cells of the code do?"""

import numpy as np

from raxel.features.active_grid.checks.edges import phases_at_edges
from raxel.features.active_grid.checks.frequencies import frequency_doubts
from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.steps import (
    circle_order,
    faulty_pictures,
    rounded_offset,
)

# Length of the mean of unit vectors. Without inverses a tone curve moves edges to dark
# and to bright apart, as far as blur reaches.
TOGETHER, TOGETHER_ALONE = 0.7, 0.3
OFF_CODE = 0.08  # periods


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
        names = [sample.names[k] for k in sines.steps]
        if order != list(range(len(order))):
            yield Doubt(
                "step-order",
                True,
                f"the phase steps along {'xy'[sample.codes[axis].axis]} ({names[0]} to "
                f"{names[-1]}) are not in order; correct step",
            )
        elif sines is every[0]:
            at_edges = phases_at_edges(sample, axis, sines.steps)
            if len(at_edges[0]):
                yield from edge_doubts(sample, axis, *at_edges)


def edge_doubts(sample, axis, phase, due, along):
    """Doubts about steps in order by their phases at edges (`phases_at_edges`)."""
    code = sample.codes[axis]
    name, names = "xy"[code.axis], [sample.names[k] for k in code.steps]
    # Where sines are clipped, they stand still.
    backwards = bool(np.mean(along < 0) > 0.5)
    mean = np.mean((-np.conj(phase) if backwards else phase) * np.conj(due))
    turns = np.angle(mean) / (2 * np.pi)
    steps, bits = f"{names[0]} to {names[-1]}", _of_code(sample, code)
    alone = any(dark is None for _, dark in code.bits)
    if abs(mean) < (TOGETHER_ALONE if alone else TOGETHER):
        yield Doubt(
            "period",
            True,
            f"the sines along {name} ({steps}) do not fit the cells of its Gray code "
            f"({bits}); correct periods, cell_px, of or axis",
        )
    elif backwards:
        yield Doubt(
            "reversed",
            True,
            f"the phase along {name} falls where its Gray code rises: correct step of "
            f"{steps}, or bit and inverse of {bits}",
        )
    elif abs(turns) > OFF_CODE:
        there = rounded_offset(code.sines.offset + turns)
        yield Doubt(
            "offset",
            True,
            f"the sines along {name} ({steps}) begin {abs(turns):.2f} periods off the "
            f"cells of its Gray code: give offset: {there} if they begin there, else "
            "correct step, or take all pictures in one pose",
        )


def _of_code(sample, code):
    """The pictures of a Gray code, as messages name them."""
    names = [sample.names[k] for pair in code.bits for k in pair if k is not None]
    return f"{names[0]} to {names[-1]}"
