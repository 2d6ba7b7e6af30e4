"""Checks of phase steps: their order, and their offset from the cells of the code."""

from itertools import combinations

import cv2
import numpy as np

from raxel.features.active_grid.checks.code import Diagnostic, neighbours
from raxel.features.active_grid.coding import WINDOW_RADIUS
from raxel.features.active_grid.phase_unwrapping import mean_misfit, unwrapped_share

# Order of phase steps. Each image minus the mean of all, divided by their spread, is a
# combination of a sine and a cosine over the pixels. So the images are on a circle, at
# the angles of their steps, up to a rotation and a reflection: image j in the order of
# the circle has step m + j or m - j. The edges of a Gray code, or sinusoids of other
# periods, determine which.


MIN_SINE_CONTRAST = 0.01  # of the contrast
MAX_STEP_DISTANCE = 0.1  # of the distance between steps
MIN_COMMON_SHARE = 0.6  # of an image, explained by the common sinusoid
MIN_RESIDUAL_SHARE = 0.01  # of the listed steps, not explained by a sinusoid
MAX_RESIDUAL_RATIO = 0.4  # of that residual, for an order that explains the images
# Offsets that are multiples of a fraction are rounded to it.
OFFSETS_PER_PERIOD, OFFSET_TOL = (24, 0.005)


def rounded_offset(offset):
    """Return a measured offset as it is written in set.yaml."""
    near = round(offset * OFFSETS_PER_PERIOD) / OFFSETS_PER_PERIOD
    offset = near if abs(offset - near) < OFFSET_TOL else offset
    return f"{offset % 1:.3g}"


def faulty_steps(sample, axis, sines):
    """Yield a diagnostic or none: images of some Sines that are not a phase step."""
    names = [sample.names[k] for k in sines.steps]
    along, values = "xy"[sample.codes[axis].axis], _around_mean(sample, sines.steps)
    spread = np.sqrt(np.mean(values**2, axis=0))
    contrast = np.median((sample.high - sample.low)[sample.lit])
    if np.median(spread) < MIN_SINE_CONTRAST * contrast:
        yield Diagnostic(
            "no-sines",
            True,
            f"{names[0]} to {names[-1]}: no sinusoidal pattern along {along}; correct "
            "the file names or retake the images",
        )
        return
    values = _in_shares(values)
    alike = values @ values.T / values.shape[1]
    count, step, size = len(values), 2 * np.pi / len(values), np.sqrt(np.diag(alike))
    near = 1 - alike / (size[:, None] * size) + np.eye(count)
    j, k = divmod(int(np.argmin(near)), count)
    both_signs = 0.15 < np.mean(values[j] > 0) < 0.85
    if both_signs and near[j, k] < MAX_STEP_DISTANCE * (1 - np.cos(step)):
        yield Diagnostic(
            "same-step",
            True,
            f"{names[k]}: same phase step as {names[j]}; correct the file name or "
            "retake the image",
        )
        return
    common = _in_common(alike)
    if common.min() < MIN_COMMON_SHARE:
        outliers = np.flatnonzero(common < common.min() + 0.1)
        yield Diagnostic(
            "not-a-step",
            True,
            f"{' or '.join(names[k] for k in outliers)}: not a phase step along "
            f"{along} of the period of the others; correct the file name",
        )


def circle_order(sample, sines):
    """Return the order of images of some Sines that fits a sinusoid, by list index.

    The listed order, unless it leaves a large residual that another order explains.
    """
    listed = list(range(len(sines.steps)))
    values = _in_shares(_around_mean(sample, sines.steps))
    alike = values @ values.T / values.shape[1]
    if len(listed) == 3 or not _covered(alike):
        return listed  # any three images are the steps of some sinusoid
    order, before, after = _best_order(alike)
    return (
        order
        if before > MIN_RESIDUAL_SHARE and after < MAX_RESIDUAL_RATIO * before
        else listed
    )


def _around_mean(sample, images):
    """Return (N, P) light at lit pixels, minus the mean of all images."""
    values = sample.images[list(images)][:, sample.lit]
    return values - values.mean(axis=0)


def _in_shares(values):
    """Return the values divided by their spread, where that is not small."""
    spread = np.sqrt(np.mean(values**2, axis=0))
    good = spread > 0.25 * np.median(spread)
    return values[:, good] / spread[good]


def _in_common(alike):
    """Return (N,) the share of each image that a common sinusoid explains.

    1 for three images, which always fit, or if too little of a period is visible.
    """
    if len(alike) == 3 or not _covered(alike):
        return np.ones(len(alike))
    weights, vectors = np.linalg.eigh(alike)
    return np.sum(weights[-2:] * vectors[:, -2:] ** 2, axis=1) / np.diag(alike)


def _covered(alike):
    """Whether the image contains enough of a period to estimate a sinusoid."""
    weights = np.linalg.eigvalsh(alike)
    return weights[-2] > 0.05 * weights[-1]


def _best_order(alike):
    """Return (order, residual of the listed order, residual of that order).

    The residual of a sinusoid fitted to the steps, as a share of all. Images are
    exchanged as long as that reduces it.
    """
    count = len(alike)
    steps = 2 * np.pi / count * np.arange(count)
    expected = 2 / count * np.cos(steps[:, None] - steps)
    total = np.trace(alike)

    def residual(order):
        return 1 - np.sum(expected * alike[np.ix_(order, order)]) / total

    order = list(range(count))
    listed = lowest = residual(order)
    while True:
        trials = []
        for j, k in combinations(range(count), 2):
            trial = order.copy()
            trial[j], trial[k] = trial[k], trial[j]
            trials.append((residual(trial), trial))
        best, trial = min(trials)
        if best > lowest - 1e-9:
            return order, listed, lowest
        lowest, order = best, trial


# Uniqueness of multi-frequency phase unwrapping, without a Gray code.


N_PIXELS = 5000
WINDOW = 2 * WINDOW_RADIUS + 1
MIN_UNWRAPPED_SHARE = 0.5  # of the pixels
MIN_WINDOW_MODULATION = 0.5  # of the modulation of single pixels
# Offsets between sinusoids in periods, as means over all pixels: ripples of a response
# and noise have none. Minimal offset, and minimal common offset.
MIN_OFFSET, MIN_COMMON_OFFSET = 0.002, 0.04


def unwrapping_diagnostics(sample, axis, noise):
    """Yield a diagnostic or none of the sinusoids of an axis; noise: a Noise.

    Images exchanged between two of them, steps in the wrong order and unstated offsets
    leave each sinusoid consistent, and make their phases contradict each other.
    """
    code = sample.codes[axis]
    every = code.sines, *code.others
    periods = np.array([1 / one.period for one in every])
    periods = (sample.extents[axis] * periods).astype(np.float32)
    turns, variances = _windows(sample, every, noise)
    along = "xy"[code.axis]
    if unwrapped_share(turns, variances, periods) >= MIN_UNWRAPPED_SHARE:
        yield from _offset_diagnostics(every, turns, variances, periods, along)
        return
    files = ", ".join(
        f"{sample.names[one.steps[0]]} to {sample.names[one.steps[-1]]}"
        for one in every
    )
    yield Diagnostic(
        "periods-unknown",
        True,
        f"axis {along}: the phases do not determine the period ({files}); check order, "
        "step, periods and offset, or reduce the noise",
    )


def _offset_diagnostics(every, turns, variances, periods, along):
    """Yield a diagnostic of sinusoids with offsets between them.

    A small offset looks like a nonlinear response, whose errors have a mean of 0.
    """
    offsets, shares = mean_misfit(turns, variances, periods)
    # The common offset, from the offset of each against the positions of the first.
    begun = offsets @ (shares - 1) / max((shares - 1) @ (shares - 1), 1e-6)
    largest = np.abs(offsets).max()
    if largest < MIN_OFFSET or abs(begun) < MIN_COMMON_OFFSET:
        return
    offset = rounded_offset(every[0].offset + begun)
    yield Diagnostic(
        "offset",
        True,
        f"axis {along}: sinusoids differ by {largest:.2g} periods of offset (stated "
        f"offset wrong or motion between them); give offset: {offset} or retake the "
        "images",
    )


def _windows(sample, every, noise):
    """Return phases of windows in the bands and variances, (F, P) float32, periods.

    Phases of single pixels for sinusoids that windows average out.
    """
    lit = np.flatnonzero(sample.lit)
    some = lit[:: -(-len(lit) // N_PIXELS)]
    turns, variances = [], []
    for sines in every:
        wave, mean = sample.wave_of(sines, sines.steps)
        sine, cosine = (
            np.array([cv2.blur(band, (WINDOW, WINDOW)) for band in part])
            for part in (wave.imag, wave.real)
        )
        own, wave = wave.ravel()[some], (cosine + 1j * sine).ravel()[some]
        of_wave = 2 / len(sines.steps) * noise.at(mean.ravel()[some])
        if np.median(np.abs(wave)) < MIN_WINDOW_MODULATION * np.median(np.abs(own)):
            wave = own  # the mean over a whole period has no phase
        else:
            of_wave = of_wave / WINDOW**2
        turns.append(np.angle(wave) / (2 * np.pi) % 1)
        variances.append(of_wave / (np.abs(wave) ** 2 + 1e-6) / (2 * np.pi) ** 2)
    return np.float32(turns), np.float32(variances)


# Phases at the edges of their Gray code, where the cells predict them.


MIN_N_EDGES = 100  # pixels
MAX_TURN_RATIO = 3  # over the usual change between pixels
MIN_BREAK_RAD = 1.0
# Periods, standard deviations by noise, and shares of the blur, which shifts edges and
# sinusoids differently on curved surfaces: a shift beyond all three is a motion.
MIN_MOTION_PERIODS, NOISE_SIGMAS, MIN_MOTION_BLURS = 0.006, 6, 0.1
# Modulation over contrast, relative to its 0.95 quantile. Where blur removes finer
# stripes, the phase is that of coarser ones next to them.
MIN_CONTRAST_SHARE = 0.25


def motion_after_code(sample, axis, blur_px):
    """Yield a diagnostic or none of motion between Gray code and phases of an axis.

    blur_px: its standard deviation, or None. Valid only if the steps agree, since a
    brighter step shifts the phase as well.
    """
    code = sample.codes[axis]
    # With four steps or more, and edges midway between image and inverse, the response
    # does not shift phases at edges.
    if len(code.steps) < 4 or any(dark is None for _, dark in code.bits):
        return
    phase, expected, along = phases_at_edges(sample, axis, code.steps)
    if not len(along):
        return
    offsets = phase * np.conj(expected)
    mean = offsets.mean()
    turn = abs(np.angle(mean))
    spread = np.std(np.angle(offsets * np.conj(mean))) / np.sqrt(len(offsets))
    px = turn / np.median(np.abs(along))
    limit = max(NOISE_SIGMAS * spread, 2 * np.pi * MIN_MOTION_PERIODS)
    if turn > limit and px > MIN_MOTION_BLURS * (blur_px or 0.0):
        files = f"{sample.names[code.steps[0]]} to {sample.names[code.steps[-1]]}"
        yield Diagnostic(
            "moved-code-phase",
            False,
            f"axis {'xy'[code.axis]}: sinusoids {files} are shifted by "
            f"{turn / (2 * np.pi):.2g} periods (about {px:.1f} px) against the Gray "
            "code; keep camera and monitor still and retake the images",
        )


def phases_at_edges(sample, axis, images):
    """Return phases at E edges, their prediction by the code, and their growth.

    Complex (E,) of unit length twice, and rad towards higher cells (E,); all empty
    without enough edges. images: in place of the axis' steps.
    """
    code, empty = sample.codes[axis], (np.empty(0),) * 3
    if not code.bits:
        return empty
    difference = np.array(
        [sample.difference(axis, bit) for bit in range(len(code.bits))]
    )
    phase = sample.wave_of(code.sines, images)[0]
    lit = sample.lit & _clear(sample, np.abs(phase))
    phase = phase / np.maximum(np.abs(phase), 1e-9)
    cells = _cells(difference)
    found = [
        _at_edges(code, difference, phase, cells, lit, *slices)
        for slices in neighbours(1)
    ]
    *edges, breaks = (np.concatenate(parts) for parts in zip(*found, strict=True))
    # Among many breaks between surfaces, some look like edges.
    return edges if len(edges[0]) >= max(MIN_N_EDGES, breaks.sum()) else empty


def _clear(sample, amplitudes):
    """Return where the modulation is large enough for a reliable phase."""
    kept = amplitudes / np.maximum(sample.high - sample.low, 1e-6)
    return kept > MIN_CONTRAST_SHARE * np.quantile(kept[sample.lit], 0.95)


def _at_edges(code, difference, phase, cells, lit, first, second):
    """Return where one bit changes on one surface: two complex (E,), (E,), (1,).

    The phase there, interpolated to where image and inverse are equal; its prediction
    by the cells; its growth towards higher cells, rad; and the number of breaks.
    """
    turn = np.angle(phase[second] * np.conj(phase[first]))
    lit = lit[first] & lit[second]
    up = cells[second] - cells[first]
    changed = (difference[(slice(None), *first)] > 0) != (
        difference[(slice(None), *second)] > 0
    )
    usual = np.median(np.abs(turn[lit])) if lit.any() else 0.0
    edge = lit & (np.abs(up) == 1) & (changed.sum(axis=0) == 1)
    edge &= np.abs(turn) < MAX_TURN_RATIO * max(usual, 0.01)
    breaks = np.count_nonzero(
        lit & (np.abs(turn) > max(MAX_TURN_RATIO * usual, MIN_BREAK_RAD))
    )
    bit = np.argmax(changed, axis=0)[None]
    before = np.take_along_axis(difference[(slice(None), *first)], bit, 0)[0][edge]
    after = np.take_along_axis(difference[(slice(None), *second)], bit, 0)[0][edge]
    share = before / (before - after)
    there = (1 - share) * phase[first][edge] + share * phase[second][edge]
    number = np.maximum(cells[first], cells[second])[edge]
    expected = np.exp(2j * np.pi * number * code.cell / code.period)
    return there / np.abs(there).clip(1e-9), expected, turn[edge] * up[edge], [breaks]


def _cells(difference):
    """Return the cell of each pixel, by the signs of image minus inverse."""
    value = np.zeros(difference[0].shape, bool)
    cells = np.zeros(difference[0].shape, np.int32)
    for bit in difference:
        value = value ^ (bit > 0)
        cells = 2 * cells + value
    return cells


# Length of the mean of unit vectors. Without inverses a tone curve shifts edges to dark
# and to bright in opposite directions, as far as blur reaches.
MIN_COHERENCE, MIN_COHERENCE_WITHOUT_INVERSE = 0.7, 0.3
MAX_CODE_OFFSET = 0.08  # periods


def phase_diagnostics(sample, noise):
    """Return diagnostics of the phase steps of a Sample; noise: a Noise."""
    found = []
    for axis, code in enumerate(sample.codes):
        if not code.steps:
            continue
        every = code.sines, *code.others
        faults = [f for sines in every for f in faulty_steps(sample, axis, sines)]
        if not faults:
            orders = [circle_order(sample, sines) for sines in every]
            faults = list(_out_of_order(sample, axis, every, orders))
        if not faults and code.others:
            faults = list(unwrapping_diagnostics(sample, axis, noise))
        found += faults
    return found


def _out_of_order(sample, axis, every, orders):
    """Yield diagnostics of orders of images, each of some Sines."""
    for sines, order in zip(every, orders, strict=True):
        names = [sample.names[k] for k in sines.steps]
        if order != list(range(len(order))):
            yield Diagnostic(
                "step-order",
                True,
                f"{names[0]} to {names[-1]}: phase steps along "
                f"{'xy'[sample.codes[axis].axis]} are not in order; correct step",
            )
        elif sines is every[0]:
            at_edges = phases_at_edges(sample, axis, sines.steps)
            if len(at_edges[0]):
                yield from edge_diagnostics(sample, axis, *at_edges)


def edge_diagnostics(sample, axis, phase, expected, along):
    """Yield diagnostics of ordered steps by their phases at edges."""
    code = sample.codes[axis]
    name, names = "xy"[code.axis], [sample.names[k] for k in code.steps]
    # The phase of clipped sinusoids does not change.
    backwards = bool(np.mean(along < 0) > 0.5)
    mean = np.mean((-np.conj(phase) if backwards else phase) * np.conj(expected))
    turns = np.angle(mean) / (2 * np.pi)
    of_bits = [sample.names[k] for pair in code.bits for k in pair if k is not None]
    steps, bits = (f"{own[0]} to {own[-1]}" for own in (names, of_bits))
    alone = any(dark is None for _, dark in code.bits)
    if abs(mean) < (MIN_COHERENCE_WITHOUT_INVERSE if alone else MIN_COHERENCE):
        yield Diagnostic(
            "period",
            True,
            f"axis {name}: sinusoids {steps} do not fit the cells of the Gray code "
            f"{bits}; correct periods, cell_px, of or axis",
        )
    elif backwards:
        yield Diagnostic(
            "reversed",
            True,
            f"axis {name}: the phase decreases where the Gray code increases; correct "
            f"step of {steps}, or bit and inverse of {bits}",
        )
    elif abs(turns) > MAX_CODE_OFFSET:
        there = rounded_offset(code.sines.offset + turns)
        yield Diagnostic(
            "offset",
            True,
            f"axis {name}: sinusoids {steps} have an offset of {abs(turns):.2f} "
            f"periods from the Gray code; give offset: {there}, correct step, or "
            "retake all images in one pose",
        )
