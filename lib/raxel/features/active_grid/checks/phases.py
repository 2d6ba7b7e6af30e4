"""Do the phase steps follow one another, and begin where the cells of the code do?

Each picture of a sine, less the mean of all and in shares of their spread, is a
combination of a sine and a cosine over the pixels. So the pictures lie on a circle, at
the angles of their steps, up to a turn and a reflection; the Gray code's edges settle
these: the phase there is known.
"""

from itertools import combinations

import numpy as np

from raxel.features.active_grid.checks.sample import Doubt, neighbours

MIN_PERIODS = 1.5  # of a sine that are in the picture
FAINT = 0.01  # of the contrast: less is no sine
SAME_STEP = 0.1  # of the distance between steps
OF_SINES = 0.6  # share of a picture that is explained by what all have in common
MIN_LEFT = 0.01  # share that a sine leaves of the steps as they are listed
HEALED = 0.4  # of it is left by an order that explains the pictures
MIN_EDGES = 100  # pixels
SMOOTH = 3  # times the usual change from pixel to pixel
BREAK = 1.0  # rad
# Length of the mean of unit vectors. Without inverses a tone curve moves edges to dark
# and to bright apart, as far as blur reaches.
TOGETHER, TOGETHER_ALONE = 0.7, 0.3
OFF_CODE = 0.08  # periods
# Periods, standard deviations by noise, and shares of the blur, which draws edges and
# sines apart where a surface bends: what is beyond all three has moved.
MOVED, BEYOND_NOISE, DRAWN = 0.006, 6, 0.1
OFF_STEP = 0.45  # of a step: less is no exchange of steps
MAX_NAMED = 8


def phase_doubts(sample):
    """Doubts about the phase steps of a Sample."""
    found = []
    for axis, code in enumerate(sample.codes):
        if code.steps:
            own = list(_order(sample, axis))
            found += own or list(_beside_code(sample, axis))
    return found


def _order(sample, axis):
    code = sample.codes[axis]
    names = [sample.names[k] for k in code.steps]
    values = sample.pictures[list(code.steps)][:, sample.lit]
    values = values - values.mean(axis=0)
    spread = np.sqrt(np.mean(values**2, axis=0))
    contrast = np.median((sample.high - sample.low)[sample.lit])
    if np.median(spread) < FAINT * contrast:
        yield Doubt(
            True,
            f"{names[0]} to {names[-1]} show no sines along {'xy'[code.axis]}, but as "
            "good as equal light; put the right pictures there or take them again",
        )
        return
    good = spread > 0.25 * np.median(spread)
    values = values[:, good] / spread[good]
    count, step = len(values), 2 * np.pi / len(values)
    alike = values @ values.T / values.shape[1]
    size = np.sqrt(np.diag(alike))
    near = 1 - alike / (size[:, None] * size) + np.eye(count)
    j, k = divmod(int(np.argmin(near)), count)
    both_signs = 0.15 < np.mean(values[j] > 0) < 0.85
    if both_signs and near[j, k] < SAME_STEP * (1 - np.cos(step)):
        yield Doubt(
            True,
            f"{names[k]} shows the same step as {names[j]}; put the right picture "
            "there or take it again",
        )
        return
    if count == 3 or not _covered(alike):
        return  # any three pictures are the steps of some sine
    weights, vectors = np.linalg.eigh(alike)
    common = np.sum(weights[-2:] * vectors[:, -2:] ** 2, axis=1) / np.diag(alike)
    if common.min() < OF_SINES:
        odd = " or ".join(names[k] for k in np.flatnonzero(common < common.min() + 0.1))
        yield Doubt(
            True,
            f"{odd} shows no step of the sines along {'xy'[code.axis]} that the others "
            "show; put the right picture there",
        )
        return
    order, before, after = _best_order(alike)
    if before > MIN_LEFT and after < HEALED * before:
        listed = [names[k] for k in order][:MAX_NAMED]
        more = ", ..." if count > MAX_NAMED else ""
        yield Doubt(
            True,
            f"the phase steps along {'xy'[code.axis]} are not in order: the pictures "
            f"follow one another as {', '.join(listed)}{more}, or backwards; exchange "
            "them or mend step",
        )


def _covered(alike):
    """Whether there is enough of a period in the picture to know a sine by."""
    weights = np.linalg.eigvalsh(alike)
    return weights[-2] > 0.05 * weights[-1]


def _best_order(alike):
    """(order, what the steps leave as listed, what they leave in that order).

    What is left when a sine of the listed steps is fitted, as a share of all; pictures
    are exchanged as long as that makes it less.
    """
    count = len(alike)
    steps = 2 * np.pi / count * np.arange(count)
    due = 2 / count * np.cos(steps[:, None] - steps)
    total = np.trace(alike)

    def left(order):
        return 1 - np.sum(due * alike[np.ix_(order, order)]) / total

    order = list(range(count))
    listed = least = left(order)
    while True:
        trials = []
        for j, k in combinations(range(count), 2):
            trial = order.copy()
            trial[j], trial[k] = trial[k], trial[j]
            trials.append((left(trial), trial))
        best, trial = min(trials)
        if best > least - 1e-9:
            return order, listed, least
        least, order = best, trial


def _beside_code(sample, axis):
    """The phase where a bit changes, against what the code's cells make it there."""
    off, along = _edges_of_code(sample, axis)
    if len(off):
        yield from _edge_doubts(sample, sample.codes[axis], off, along)


def moved_doubts(sample, axis, blur_px):
    """A Doubt or none: did something move between Gray code and phases of an axis?

    blur_px: its standard deviation, or None. To be asked where the steps agree, as one
    that is brighter shifts the phase as well.
    """
    code = sample.codes[axis]
    # Of four steps and more, and edges midway between picture and inverse, the response
    # shifts none where they meet.
    if len(code.steps) < 4 or any(dark is None for _, dark in code.bits):
        return
    off, along = _edges_of_code(sample, axis)
    if not len(off):
        return
    mean = off.mean()
    turn = abs(np.angle(mean))
    spread = np.std(np.angle(off * np.conj(mean))) / np.sqrt(len(off))
    px = turn / np.median(np.abs(along))
    limit = max(BEYOND_NOISE * spread, 2 * np.pi * MOVED)
    if turn > limit and px > DRAWN * (blur_px or 0.0):
        files = f"{sample.names[code.steps[0]]} to {sample.names[code.steps[-1]]}"
        yield Doubt(
            False,
            f"the sines along {'xy'[code.axis]} ({files}) begin "
            f"{turn / (2 * np.pi):.2g} periods, about {px:.1f} px, off the cells of "
            "its Gray code: something moved between them; camera and monitor must be "
            "at rest: take the pictures again",
        )


def _edges_of_code(sample, axis):
    """All edges that `_at_edges` finds: off, along; none where these cannot be told."""
    code, none = sample.codes[axis], (np.empty(0),) * 2
    if not code.bits:
        return none
    apart = np.array([sample.apart(axis, bit) for bit in range(len(code.bits))])
    phase = sample.wave(axis)[0]
    phase = phase / np.maximum(np.abs(phase), 1e-9)
    cells = _cells(apart)
    found = [
        _at_edges(sample, code, apart, phase, cells, *slices)
        for slices in neighbours(1)
    ]
    off, along, breaks = (np.concatenate(parts) for parts in zip(*found, strict=True))
    # Among many breaks between surfaces, some look like edges.
    return (off, along) if len(off) >= max(MIN_EDGES, breaks.sum()) else none


def _at_edges(sample, code, apart, phase, cells, first, second):
    """Where one bit changes on one surface: complex (E,), (E,) and a count (1,).

    The phase there, interpolated to where picture and inverse are equal, less what the
    cells make it; how much it grows towards higher cells, rad; how often it breaks.
    """
    turn = np.angle(phase[second] * np.conj(phase[first]))
    lit = sample.lit[first] & sample.lit[second]
    up = cells[second] - cells[first]
    changed = (apart[(slice(None), *first)] > 0) != (apart[(slice(None), *second)] > 0)
    usual = np.median(np.abs(turn[lit])) if lit.any() else 0.0
    edge = lit & (np.abs(up) == 1) & (changed.sum(axis=0) == 1)
    edge &= np.abs(turn) < SMOOTH * max(usual, 0.01)
    breaks = np.count_nonzero(lit & (np.abs(turn) > max(SMOOTH * usual, BREAK)))
    bit = np.argmax(changed, axis=0)[None]
    before = np.take_along_axis(apart[(slice(None), *first)], bit, 0)[0][edge]
    after = np.take_along_axis(apart[(slice(None), *second)], bit, 0)[0][edge]
    share = before / (before - after)
    there = (1 - share) * phase[first][edge] + share * phase[second][edge]
    number = np.maximum(cells[first], cells[second])[edge]
    due = np.exp(-2j * np.pi * number * code.cell / code.period)
    return there * due / np.abs(there).clip(1e-9), turn[edge] * up[edge], [breaks]


def _cells(apart):
    """The cell of each pixel, by the signs of picture less inverse."""
    value = np.zeros(apart[0].shape, bool)
    cells = np.zeros(apart[0].shape, np.int32)
    for bit in apart:
        value = value ^ (bit > 0)
        cells = 2 * cells + value
    return cells


def _edge_doubts(sample, code, off, along):
    name = "xy"[code.axis]
    mean = off.mean()
    files = f"{sample.names[code.steps[0]]} to {sample.names[code.steps[-1]]}"
    alone = any(dark is None for _, dark in code.bits)
    if abs(mean) < (TOGETHER_ALONE if alone else TOGETHER):
        yield Doubt(
            True,
            f"the sines along {name} ({files}) do not fit the cells of its Gray code; "
            "mend periods, cell_px, of or axis",
        )
        return
    turns = np.angle(mean) / (2 * np.pi)
    if np.mean(along < 0) > 0.5:  # where sines are clipped, they stand still
        yield Doubt(
            True,
            f"the phase along {name} falls where its Gray code rises; reverse the "
            f"order of {files}, or exchange bit 0 and its inverse",
        )
    elif abs(turns) > OFF_CODE:
        off = f"begin {abs(turns):.2f} periods off the cells of its Gray code"
        advice = "; mend step, or inverse of its bits"
        if abs(turns) < OFF_STEP / len(code.steps):
            advice = ", as if something had moved; take all pictures in one pose"
        yield Doubt(True, f"the sines along {name} ({files}) {off}{advice}")
