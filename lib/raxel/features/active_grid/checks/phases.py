"""Do the phase steps follow one another, and begin where the cells of the code do?"""

from itertools import combinations

import cv2
import numpy as np

from raxel.features.active_grid.checks.code import Doubt, neighbours
from raxel.features.active_grid.coding import REACH
from raxel.features.active_grid.phase_unwrapping import share_told, usual_misfit

# Which step does each image of a sine show? Each image of a sine, less the mean
# of all and in shares of their spread, is a combination of a sine and a cosine over
# the pixels. So the images lie on a circle, at the angles of their steps, up to a
# turn and a reflection: image j of those in the order of the circle shows step m +
# j or m - j. The edges of a Gray code, or sines of other periods, determine which.


FAINT = 0.01  # of the contrast: less is no sine
SAME_STEP = 0.1  # of the distance between steps
OF_SINES = 0.6  # share of an image that is explained by what all have in common
MIN_LEFT = 0.01  # share that a sine leaves of the steps as they are listed
HEALED = 0.4  # of it is left by an order that explains the images
OFFSETS, SAME_OFFSET = 24, 0.005  # in a period, and what is taken for one of them


def rounded_offset(offset):
    """An offset as it is written in set.yaml, by one that is measured."""
    near = round(offset * OFFSETS) / OFFSETS
    offset = near if abs(offset - near) < SAME_OFFSET else offset
    return f"{offset % 1:.3g}"


def faulty_pictures(sample, axis, sines):
    """A Doubt or none: about images of some Sines that show none of their steps."""
    names = [sample.names[k] for k in sines.steps]
    along, values = "xy"[sample.codes[axis].axis], _around_mean(sample, sines.steps)
    spread = np.sqrt(np.mean(values**2, axis=0))
    contrast = np.median((sample.high - sample.low)[sample.lit])
    if np.median(spread) < FAINT * contrast:
        yield Doubt(
            "no-sines",
            True,
            f"{names[0]} to {names[-1]} show no sines along {along}, but as good as "
            "equal light; put the right images there or take them again",
        )
        return
    values = _in_shares(values)
    alike = values @ values.T / values.shape[1]
    count, step, size = len(values), 2 * np.pi / len(values), np.sqrt(np.diag(alike))
    near = 1 - alike / (size[:, None] * size) + np.eye(count)
    j, k = divmod(int(np.argmin(near)), count)
    both_signs = 0.15 < np.mean(values[j] > 0) < 0.85
    if both_signs and near[j, k] < SAME_STEP * (1 - np.cos(step)):
        yield Doubt(
            "same-step",
            True,
            f"{names[k]} shows the same step as {names[j]}; put the right image "
            "there or take it again",
        )
        return
    common = _in_common(alike)
    if common.min() < OF_SINES:
        odd = np.flatnonzero(common < common.min() + 0.1)
        yield Doubt(
            "not-a-step",
            True,
            f"{' or '.join(names[k] for k in odd)} shows no step of the sines along "
            f"{along} that the others show; put the right image there",
        )


def circle_order(sample, sines):
    """Pictures of some Sines, by their place in the list, in an order that makes sines
    of them: the listed one, unless that leaves much that another one explains."""
    listed = list(range(len(sines.steps)))
    values = _in_shares(_around_mean(sample, sines.steps))
    alike = values @ values.T / values.shape[1]
    if len(listed) == 3 or not _covered(alike):
        return listed  # any three images are the steps of some sine
    order, before, after = _best_order(alike)
    return order if before > MIN_LEFT and after < HEALED * before else listed


def _around_mean(sample, images):
    """(N, P) light at lit pixels, less the mean of all."""
    values = sample.images[list(images)][:, sample.lit]
    return values - values.mean(axis=0)


def _in_shares(values):
    """In shares of their spread, where that is not faint."""
    spread = np.sqrt(np.mean(values**2, axis=0))
    good = spread > 0.25 * np.median(spread)
    return values[:, good] / spread[good]


def _in_common(alike):
    """(N,) the share of each image that a sine of all explains; 1 where any three
    images are the steps of some sine, or too little of a period is seen."""
    if len(alike) == 3 or not _covered(alike):
        return np.ones(len(alike))
    weights, vectors = np.linalg.eigh(alike)
    return np.sum(weights[-2:] * vectors[:, -2:] ** 2, axis=1) / np.diag(alike)


def _covered(alike):
    """Whether there is enough of a period in the image to know a sine by."""
    weights = np.linalg.eigvalsh(alike)
    return weights[-2] > 0.05 * weights[-1]


def _best_order(alike):
    """(order, what the steps leave as listed, what they leave in that order).

    What is left when a sine of the listed steps is fitted, as a share of all; images
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


# Do sines of several periods, without a Gray code, tell which period is seen?


PIXELS = 5000
WINDOW = 2 * REACH + 1
MOST = 0.5  # share of pixels that must know their period
WASHED_OUT = 0.5  # of the modulation of pixels, that their windows must keep
# Periods by which sines begin off each other in the mean over all pixels: ripples of a
# response and noise have none. So much of an offset that all share is too much.
OFF, TOO_FAR_OFF = 0.002, 0.04


def frequency_doubts(sample, axis, noise):
    """A Doubt or none about the sines of an axis of a Sample; noise: a Noise.

    Images of two of them exchanged, steps in the wrong order and offsets that are
    not stated leave each sine sound by itself, and phases that contradict each other.
    """
    code = sample.codes[axis]
    every = code.sines, *code.others
    periods = np.array([1 / one.period for one in every])
    periods = (sample.extents[axis] * periods).astype(np.float32)
    turns, variances = _windows(sample, every, noise)
    along = "xy"[code.axis]
    if share_told(turns, variances, periods) >= MOST:
        yield from _offset_doubts(every, turns, variances, periods, along)
        return
    files = ", ".join(
        f"{sample.names[one.steps[0]]} to {sample.names[one.steps[-1]]}"
        for one in every
    )
    yield Doubt(
        "periods-unknown",
        True,
        f"the phases of the sines along {along} ({files}) do not determine the period: "
        "check their order, step, periods and offset, or reduce the noise",
    )


def _offset_doubts(every, turns, variances, periods, along):
    """Sines that fit each other, but not quite: a small offset looks like a response
    that is not linear, whose errors have a mean of none."""
    off, shares = usual_misfit(turns, variances, periods)
    # The offset that all share, by how much each is off the places of the first.
    begun = off @ (shares - 1) / max((shares - 1) @ (shares - 1), 1e-6)
    most = np.abs(off).max()
    if most < OFF or abs(begun) < TOO_FAR_OFF:
        return
    offset = rounded_offset(every[0].offset + begun)
    yield Doubt(
        "offset",
        True,
        f"the sines along {along} begin {most:.2g} periods off each other: give "
        f"offset: {offset} if all of them begin there; else something moved between "
        "them, and they must be taken again",
    )


def _windows(sample, every, noise):
    """Phases of windows in the bands and their variances, (F, P) float32, periods.

    Of sines that windows wash out, those of pixels.
    """
    lit = np.flatnonzero(sample.lit)
    some = lit[:: -(-len(lit) // PIXELS)]
    turns, variances = [], []
    for sines in every:
        wave, mean = sample.wave_of(sines, sines.steps)
        sine, cosine = (
            np.array([cv2.blur(band, (WINDOW, WINDOW)) for band in part])
            for part in (wave.imag, wave.real)
        )
        own, wave = wave.ravel()[some], (cosine + 1j * sine).ravel()[some]
        of_wave = 2 / len(sines.steps) * noise.at(mean.ravel()[some])
        if np.median(np.abs(wave)) < WASHED_OUT * np.median(np.abs(own)):
            wave = own  # of windows that hold a period, the mean is turned round
        else:
            of_wave = of_wave / WINDOW**2
        turns.append(np.angle(wave) / (2 * np.pi) % 1)
        variances.append(of_wave / (np.abs(wave) ** 2 + 1e-6) / (2 * np.pi) ** 2)
    return np.float32(turns), np.float32(variances)


# What phases are at the edges of their Gray code, where the cells make them known.


MIN_EDGES = 100  # pixels
SMOOTH = 3  # times the usual change from pixel to pixel
BREAK = 1.0  # rad
# Periods, standard deviations by noise, and shares of the blur, which draws edges and
# sines apart where a surface bends: what is beyond all three has moved.
MOVED, BEYOND_NOISE, DRAWN = 0.006, 6, 0.1
# Of what sines keep of a pixel's contrast where they keep most, 0.95 quantile. Where
# blur washes finer ones out, their phase is that of coarser ones beside them.
CLEAR = 0.25


def moved_doubts(sample, axis, blur_px):
    """A Doubt or none: did something move between Gray code and phases of an axis?

    blur_px: its standard deviation, or None. To be asked where the steps agree, as one
    that is brighter shifts the phase as well.
    """
    code = sample.codes[axis]
    # Of four steps and more, and edges midway between image and inverse, the response
    # shifts none where they meet.
    if len(code.steps) < 4 or any(dark is None for _, dark in code.bits):
        return
    phase, due, along = phases_at_edges(sample, axis, code.steps)
    if not len(along):
        return
    off = phase * np.conj(due)
    mean = off.mean()
    turn = abs(np.angle(mean))
    spread = np.std(np.angle(off * np.conj(mean))) / np.sqrt(len(off))
    px = turn / np.median(np.abs(along))
    limit = max(BEYOND_NOISE * spread, 2 * np.pi * MOVED)
    if turn > limit and px > DRAWN * (blur_px or 0.0):
        files = f"{sample.names[code.steps[0]]} to {sample.names[code.steps[-1]]}"
        yield Doubt(
            "moved-code-phase",
            False,
            f"the sines along {'xy'[code.axis]} ({files}) begin "
            f"{turn / (2 * np.pi):.2g} periods, about {px:.1f} px, off the cells of "
            "its Gray code: something moved between them; camera and monitor must be "
            "at rest: take the images again",
        )


def phases_at_edges(sample, axis, images):
    """Of E edges that `_at_edges` finds, phases and what the code makes them, complex
    (E,) of unit length, and how much they grow towards higher cells, rad; all empty
    where these cannot be told. images: in the place of the axis' steps."""
    code, none = sample.codes[axis], (np.empty(0),) * 3
    if not code.bits:
        return none
    apart = np.array([sample.apart(axis, bit) for bit in range(len(code.bits))])
    phase = sample.wave_of(code.sines, images)[0]
    lit = sample.lit & _clear(sample, np.abs(phase))
    phase = phase / np.maximum(np.abs(phase), 1e-9)
    cells = _cells(apart)
    found = [
        _at_edges(code, apart, phase, cells, lit, *slices) for slices in neighbours(1)
    ]
    *told, breaks = (np.concatenate(parts) for parts in zip(*found, strict=True))
    # Among many breaks between surfaces, some look like edges.
    return told if len(told[0]) >= max(MIN_EDGES, breaks.sum()) else none


def _clear(sample, amplitudes):
    """Where sines keep enough of the contrast for their phase to be their own."""
    kept = amplitudes / np.maximum(sample.high - sample.low, 1e-6)
    return kept > CLEAR * np.quantile(kept[sample.lit], 0.95)


def _at_edges(code, apart, phase, cells, lit, first, second):
    """Where one bit changes on one surface: complex (E,) twice, (E,) and a count (1,).

    The phase there, interpolated to where image and inverse are equal, and what the
    cells make it; how much it grows towards higher cells, rad; how often it breaks.
    """
    turn = np.angle(phase[second] * np.conj(phase[first]))
    lit = lit[first] & lit[second]
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
    due = np.exp(2j * np.pi * number * code.cell / code.period)
    return there / np.abs(there).clip(1e-9), due, turn[edge] * up[edge], [breaks]


def _cells(apart):
    """The cell of each pixel, by the signs of image less inverse."""
    value = np.zeros(apart[0].shape, bool)
    cells = np.zeros(apart[0].shape, np.int32)
    for bit in apart:
        value = value ^ (bit > 0)
        cells = 2 * cells + value
    return cells


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
    """Doubts about orders of images, each of some Sines, the first by its code."""
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
            "correct step, or take all images in one pose",
        )


def _of_code(sample, code):
    """The images of a Gray code, as messages name them."""
    names = [sample.names[k] for pair in code.bits for k in pair if k is not None]
    return f"{names[0]} to {names[-1]}"
