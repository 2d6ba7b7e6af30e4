"""Did light and steps stay as they were from picture to picture?

Where a picture of the code is bright, it is as bright as the others are. By a
share q more of it an edge moves q sqrt(pi / 8) standard deviations of the blur, which
spoils no place: limits far above noise miss nothing there. Over whole periods all steps
of a sine give the same light.
"""

import numpy as np

from raxel.features.active_grid.checks.code import MIN_SPACING_PX, spacing
from raxel.features.active_grid.checks.motion import FAR_MOVED_PX
from raxel.features.active_grid.checks.redundancy import (
    LIGHT,
    MORE_THAN_NOISE,
    MOTION,
    mismatch,
)
from raxel.features.active_grid.checks.sample import Doubt
from raxel.features.active_grid.checks.scatter import Scatter

CLEAR = 0.75  # of the contrast: beyond what is blurred
BRIGHTER, FAR_BRIGHTER = 0.06, 0.2  # shares of the light: a word, and too much
# Errors of places by steps that do not agree, in standard deviations: so large that
# these are widened, if it is known by what, and if not; worth a word, alike; too much,
# if they are FAR_OFF as well.
WIDENS, WIDENS_UNEXPLAINED, WORTH_A_WORD, UNEXPLAINED, TOO_FAR = 0.3, 2, 2, 4, 10
BEYOND_LOCAL = 1.5  # times the variance: what JPEG leaves in rows is up to 1.3 times
WORTH_SAYING = 1.3  # times the standard deviation: so much it is widened with a word
# Errors that go as a sine are within their RMS in half of the pixels, and within so
# much more of it in 0.69 of them, as those of a normal law are.
OF_SINE = 1.25
OF_LARGEST = 0.3  # a second step that is off by such a share: no single one is
FAR_OFF = 0.01  # periods
# Of a bit and its inverse; pixels that are looked at; standard deviations.
MIN_PAIRS, FOR_SLOPE, SURE_OF_DRIFT = 4, 5000, 4
EXPOSE = (
    "switch automatic exposure off, expose for whole periods of the monitor's light, "
    "and take it again"
)
PHASE_BINS = 16
MIN_IN_BIN = 30


def step_errors(sample, noise, sigma, smooth, bands, jolted=()):
    """Doubts, RMS errors of places (A,) in periods by steps that do not agree, factors
    (A,) by which sigma is larger since neighbours share their noise, and by how much
    the mean of steps moved at most, px, where one did alone.

    noise: a Noise; sigma: (A,), standard deviation of most places, in periods; smooth:
    whether they are those of windows; bands: (A,), of `passing.Passing`; jolted: axes
    amid whose steps something moved for good (`jolts`), which are not asked. An error
    is 0, and a factor 1, where what is stated can hold it.
    """
    doubts, errors, factors = [], np.zeros(len(sigma)), np.ones(len(sigma))
    mean_moved = 0.0
    banded = np.zeros(len(sigma), bool)
    for axis, usual in enumerate(sigma):
        found = None if axis in jolted else mismatch(sample, axis, noise)
        if found is None:
            continue
        if found.kind == MOTION:
            size = found.size / len(sample.codes[axis].steps)
            mean_moved = max(mean_moved, size)
        scatter = found.scatter
        variance = scatter.of(smooth) if scatter else 1.0
        # What is local, as in JPEG files, windows beside each other know as well.
        if smooth and bands[axis] > BEYOND_LOCAL * variance:
            variance, banded[axis] = bands[axis], True
        if variance > 1 + MORE_THAN_NOISE:
            factors[axis] = np.sqrt(variance)
            usual = usual * factors[axis]
        # What neither of the two explains is in the factor, where there is one.
        own = found.periods if factors[axis] == 1 else found.by_one
        known = found.kind or scatter is None
        if own > (WIDENS if known else WIDENS_UNEXPLAINED) * usual:
            errors[axis] = own * (OF_SINE if found.kind else 1)
        # Of three steps in such light one seems to have moved.
        drifts = found.kind != MOTION or scatter is None
        if scatter is None:
            scatter = _by_code(sample, axis)
        drifts = drifts and scatter and _drifts(scatter, usual)
        if drifts and scatter.periods > found.by_one:
            errors[axis] = OF_SINE * scatter.periods
            doubts += _drift_doubts(sample, axis, scatter, scatter.periods / usual)
        else:
            doubts += _step_doubts(sample, axis, found, found.periods / usual)
    doubts += _shared_noise(sample, np.where(banded, 1, factors))
    doubts += _in_bands(sample, np.where(banded, factors, 1))
    return doubts, errors, factors, mean_moved


def _shared_noise(sample, factors):
    """A Doubt or none; factors: (A,) by which sigma is larger."""
    if factors.max() > WORTH_SAYING:
        yield Doubt(
            False,
            "neighbouring pixels share their noise, or hide it, as JPEG files and "
            f"cameras that smooth do: {_times(sample, factors)}; save without loss",
        )


def _in_bands(sample, factors):
    """As `_shared_noise`."""
    if factors.max() > WORTH_SAYING:
        yield Doubt(
            False,
            "light changes from picture to picture in rows or columns, as where bands "
            "of a flickering light roll through or something moved: "
            f"{_times(sample, factors)}; expose for whole periods of lamps and of the "
            "monitor's light, and keep camera and monitor at rest",
        )


def _times(sample, factors):
    told = " and ".join(
        f"{factor:.2g} ({'xy'[code.axis]})"
        for code, factor in zip(sample.codes, factors, strict=True)
    )
    return (
        f"standard deviations are taken {told} times as large as white noise would "
        "have them"
    )


def _by_code(sample, axis):
    """A Scatter of three steps, whose light changes as that of the code does, or None.

    They leave nothing to tell it by. Of a bit and its inverse a pixel is bright in one:
    if light changes evenly, so do these, beside what each pair of them and each pixel
    has for itself.
    """
    slope, spread = _slope_of_light(sample)
    if abs(slope) <= SURE_OF_DRIFT * spread:
        return None
    steps = np.array(sample.codes[axis].steps)
    drift = slope * (steps - steps.mean())
    values = sample.pictures[steps][:, sample.lit]
    turn = np.exp(-2j * np.pi * np.arange(len(steps)) / len(steps))
    turned = (turn * (1 + drift)) @ values * np.conj(turn @ values)
    periods = np.sqrt(np.mean((np.angle(turned) / (2 * np.pi)) ** 2))
    return Scatter(1.0, 1.0, drift, float(periods))


def _slope_of_light(sample):
    """By which share light grows from picture to picture, and its standard deviation;
    0 where fewer than MIN_PAIRS of bits and inverses tell."""
    apart, pictures = [], []
    for axis, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            own = sample.apart(axis, bit)
            wide = spacing(own > 0, sample.lit) >= 2 * MIN_SPACING_PX
            if dark is not None and wide:
                apart.append(own)
                pictures.append((light, dark))
    if len(pictures) < MIN_PAIRS:
        return 0.0, 0.0
    some = np.argwhere(sample.lit)
    at = tuple(some[:: 1 + len(some) // FOR_SLOPE].T)
    apart, pictures = np.array([own[at] for own in apart]), np.array(pictures)
    clear, which = np.abs(apart) > CLEAR, (apart < 0).astype(int)
    when = np.take_along_axis(pictures, which, axis=1)
    values = sample.pictures[(when, *at)]
    return _even_change(values, when - when.mean(), clear)


def _even_change(values, when, used):
    """By which share values (K, P) change with `when`, and its standard deviation;
    where `used`, beside factors of each row and of each column."""
    weight = used / np.maximum(used.sum(axis=0), 1)
    share = values / np.maximum(np.sum(weight * values, axis=0), 1e-6) - 1
    # Factors of the columns are taken off: of the rows', one less is left.
    rows = np.eye(len(values))[1:, :, None] * np.ones(values.shape[1])
    columns = np.concatenate([when[None], rows])
    columns = used * (columns - np.sum(weight * columns, axis=1, keepdims=True))
    columns = columns.reshape(len(columns), -1)
    share = (used * share).ravel()
    inverse = np.linalg.inv(columns @ columns.T)
    found = inverse @ (columns @ share)
    left = share - found @ columns
    free = max(np.count_nonzero(used) - values.shape[1] - len(found), 1)
    return float(found[0]), float(np.sqrt(left @ left / free * inverse[0, 0]))


def _drifts(scatter, usual):
    """Whether more than one step is brighter or darker, and by more than is stated."""
    off = np.abs(scatter.drift - np.median(scatter.drift))
    several = np.sort(off)[-2] > OF_LARGEST * off.max()
    return several and scatter.periods > WIDENS * usual


def _drift_doubts(sample, axis, scatter, times):
    """times: the error of places in standard deviations."""
    steps, name = sample.codes[axis].steps, "xy"[sample.codes[axis].axis]
    if times > WORTH_A_WORD:
        percent = ", ".join(f"{100 * share:+.1f}" for share in scatter.drift)
        yield Doubt(
            times > TOO_FAR and scatter.periods > FAR_OFF,
            f"light changes from {sample.names[steps[0]]} to {sample.names[steps[-1]]} "
            f"({percent} %): places along {name} are wrong by {scatter.periods:.2g} "
            f"periods, {times:.1f} of their standard deviations by noise; let the "
            f"monitor warm up; {EXPOSE}",
        )


def _step_doubts(sample, axis, found, times):
    """times: the error of places in standard deviations."""
    steps, name = sample.codes[axis].steps, "xy"[sample.codes[axis].axis]
    spoils = times > TOO_FAR and found.periods > FAR_OFF
    files = " or ".join(sample.names[k] for k in found.pictures)
    of_all = f"{sample.names[steps[0]]} to {sample.names[steps[-1]]}"
    wrong = (
        f"places along {name} are wrong by {found.periods:.2g} periods, {times:.1f} of "
        "their standard deviations by noise"
    )
    if found.kind == LIGHT and times > WORTH_A_WORD:
        spoils = spoils or abs(found.size) > FAR_BRIGHTER
        bright = f"{_brighter(found.size)} than others (to {100 * found.spread:.1g} %)"
        yield Doubt(spoils, f"{files} is {bright}; {wrong}; {EXPOSE}")
    elif found.kind == MOTION and times > WORTH_A_WORD:
        yield Doubt(
            spoils or found.size > FAR_MOVED_PX,
            f"the picture moved by about {found.size:.1f} px at {files}, among "
            f"{of_all}; {wrong}; camera and monitor must be at rest: take the pictures "
            "again",
        )
    elif times > UNEXPLAINED:
        yield Doubt(
            spoils,
            f"{of_all} do not agree: one of them was compressed, or something in it "
            f"moved; {wrong}; save all without loss, or take them again",
        )


def unsteady_light(sample):
    """Doubts about the light of a Sample whose pictures are in order."""
    groups = [dict(_light_of_bits(sample))]
    # More steps than three say more, and more exactly, and so do three beside a code
    # with its inverse (`step_errors`).
    three = [k for k, code in enumerate(sample.codes) if len(code.steps) == 3]
    if any(dark is not None for code in sample.codes for _, dark in code.bits):
        three = []
    groups += [dict(_light_of_steps(sample, k)) for k in three]
    for group in groups:
        if len(group) < 3:
            continue
        usual = np.median(list(group.values()))
        off = {picture: value / usual - 1 for picture, value in group.items()}
        worst = max(off, key=lambda picture: abs(off[picture]))
        if abs(off[worst]) > BRIGHTER:
            yield Doubt(
                abs(off[worst]) > FAR_BRIGHTER,
                f"{sample.names[worst]} is {_brighter(off[worst])} than others; "
                f"{EXPOSE}",
            )


def _brighter(share):
    return f"{100 * abs(share):.2g} % {'brighter' if share > 0 else 'darker'}"


def _light_of_bits(sample):
    """(picture, its light where it is bright, as a share of what others give there)"""
    bright = {}
    for axis, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            apart = sample.apart(axis, bit)
            if spacing(apart > 0, sample.lit) < 2 * MIN_SPACING_PX:
                continue  # blurred stripes are darker
            bright[light] = sample.lit & (apart > CLEAR)
            if dark is not None:
                bright[dark] = sample.lit & (apart < -CLEAR)
    if not bright:
        return
    level = _usual_level(sample, bright)
    for picture, on in bright.items():
        on = on & (level > 0)
        if np.count_nonzero(on) > MIN_IN_BIN:
            yield picture, float(np.mean(sample.pictures[picture][on] / level[on]))


def _usual_level(sample, bright):
    """The mean of the pictures that are bright, for each pixel."""
    total, count = np.zeros_like(sample.high), np.zeros_like(sample.high)
    for picture, on in bright.items():
        total += sample.pictures[picture] * on
        count += on
    return total / np.maximum(count, 1)


def _light_of_steps(sample, axis):
    """(picture, mean over all phases of its light as a share of the mean of all)"""
    steps = sample.codes[axis].steps
    if not steps:
        return
    wave, mean = sample.wave(axis)
    turn = np.angle(wave[sample.lit]) / (2 * np.pi) % 1
    place = np.minimum((turn * PHASE_BINS).astype(int), PHASE_BINS - 1)
    count = np.bincount(place, minlength=PHASE_BINS)
    if count.min() < MIN_IN_BIN:
        return
    level = mean[sample.lit].clip(1e-6)
    for picture in steps:
        share = sample.pictures[picture][sample.lit] / level
        binned = np.bincount(place, share, minlength=PHASE_BINS) / count
        yield picture, float(binned.mean())
