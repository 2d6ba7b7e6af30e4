"""Did camera and monitor rest, by the light that a pattern does not change?

An image and its inverse add up to one without pattern, as the steps of a sine do.
Where these differ from each other as if the first were shifted, something moved, to
first order in the shift.
"""

from itertools import pairwise

import numpy as np

from raxel.features.active_grid.checks.code import MIN_SPACING_PX, Doubt, spacing
from raxel.features.active_grid.checks.redundancy import LIGHT, MOTION, mismatch

MOVED_PX, FAR_MOVED_PX = 0.7, 1.2
EDGE = 0.2  # of the steepest slope
FEW_EDGES = 0.3  # of those along the other direction
SURE = 8  # standard deviations of the estimated motion
TONE = 2  # times what a tone curve does: less may be its as well


def motion_doubts(sample):
    """The largest motion, as one Doubt or none."""
    found = []
    flat = sorted(_without_pattern(sample), key=lambda one: min(one[0]))
    fitted = [_shifts(plain, flat[0][1], pattern) for _, plain, pattern in flat]
    shifts = [shift for shift, _, _ in fitted]
    # One tone curve is behind all images, and coarse bits have few edges to know it.
    least = TONE * max((np.hypot(*tone) for _, _, tone in fitted), default=0.0)
    for (images, _, _), (_, within, _) in zip(flat, fitted, strict=True):
        within = within * (np.hypot(*within) > least)
        found.append((within, "between {} and {}", images))
    for (before, after), (last, first) in zip(
        pairwise(shifts), pairwise(flat), strict=True
    ):
        images = last[0][-1], first[0][0]
        found.append((after - before, "between {} and {}", images))
    sizes = [float(np.hypot(*shift)) for shift, _, _ in found]
    if sizes and max(sizes) > MOVED_PX:
        size = max(sizes)
        _, when, images = found[sizes.index(size)]
        when = when.format(sample.names[images[0]], sample.names[images[-1]])
        yield Doubt(
            "moved",
            size > FAR_MOVED_PX,
            f"the image moved by about {size:.1f} px {when}; camera and monitor must "
            "be at rest: take the images again",
        )


def _without_pattern(sample):
    """(images, their mean without pattern, half of what the pattern adds or None)"""
    for axis, code in enumerate(sample.codes):
        for light, dark in code.bits:
            if dark is not None:
                a, b = sample.images[light], sample.images[dark]
                yield (light, dark), (a + b) / 2, (a - b) / 4
        if code.steps:
            yield code.steps, sample.wave(axis)[1], None


def _shifts(plain, reference, pattern):
    """Shift (2,) px against the reference, of an image against its inverse, and what
    the tone curve does to these two, alike.

    At an edge of the pattern a tone curve makes both together brighter or darker,
    whichever side is bright. What a shift leaves turns with the side; unless it is far
    more, it is the tone curve's as well.
    """
    columns = [reference, np.ones_like(reference), *slopes_within(reference)]
    if pattern is None:
        return _fitted(plain, columns)[2:], np.zeros(2), np.zeros(2)
    slopes = [_edges(slope) for slope in slopes_within(pattern)]
    # Where edges end at the monitor's border, a few go across their own direction.
    count = [np.count_nonzero(slope) for slope in slopes]
    slopes = [
        s * (n > FEW_EDGES * max(count)) for s, n in zip(slopes, count, strict=True)
    ]
    found = _fitted(plain, [*columns, *slopes, *map(np.abs, slopes)])
    return found[2:4], found[4:6], found[6:]


def slopes_within(image):
    """Changes per pixel along u and v within each band."""
    if image.shape[1] < 2:
        return np.gradient(image, axis=2), np.zeros_like(image)
    return np.gradient(image, axis=2), np.gradient(image, axis=1)


def _edges(slope):
    """The slope where there is an edge, 0 where there is noise."""
    size = np.abs(slope)
    return np.where(size > EDGE * size.max(), slope, 0)


def _fitted(values, columns):
    """Coefficients of the columns, 0 for those that are not SURE."""
    basis = np.stack([column.ravel() for column in columns], axis=1).astype(float)
    used = basis.any(axis=0)
    scale = np.where(used, np.sqrt(np.mean(basis**2, axis=0)), 1)
    basis = basis / scale
    normal = basis.T @ basis + 1e-9 * len(basis) * np.eye(len(scale))
    inverse = np.linalg.inv(normal)
    found = inverse @ (basis.T @ values.ravel())
    left = values.ravel() - basis @ found
    spread = np.sqrt(np.mean(left**2) * np.diag(inverse))
    return np.where(used & (np.abs(found) > SURE * spread), found / scale, 0)


# Did light and steps stay as they were from image to image? Where an image of
# the code is bright, it is as bright as the others are. By a share q more of it an
# edge moves q sqrt(pi / 8) standard deviations of the blur, which spoils no place:
# limits far above noise miss nothing there.


CLEAR = 0.75  # of the contrast: beyond what is blurred
# Shares of the light: a word, of code and of steps, and too much.
BRIGHTER, BRIGHTER_STEP, FAR_BRIGHTER = 0.06, 0.02, 0.2
# Errors of places by steps that do not agree, in standard deviations: so large that
# these are widened; worth a word; too much, if they are FAR_OFF as well.
WIDENS, WORTH_A_WORD, TOO_FAR = 0.3, 2, 10
FAR_OFF = 0.01  # periods
# Of the variance of windows: 3.6 times the deviation of a median of the squares of 800,
# which noise passes twice in 10 000.
MORE_THAN_NOISE = 0.3
WORTH_SAYING = 1.3  # times the standard deviation: so much it is widened with a word
# Errors that go as a sine are within their RMS in half of the pixels, and within so
# much more of it in 0.69 of them, as those of a normal law are.
OF_SINE = 1.25
OF_LARGEST = 0.3  # a second step that is off by such a share: no single one is
EXPOSE = (
    "switch automatic exposure off, expose for whole periods of the monitor's light, "
    "and take it again"
)
MIN_PIXELS = 30


def step_errors(sample, noise, sigma, smooth):
    """Doubts, RMS errors of places (A,) in periods by steps that do not agree, and
    factors (A,) by which sigma is larger since neighbours share their noise.

    noise: a Noise; sigma: (A,), standard deviation of most places, in periods; smooth:
    whether they are those of windows. An error is 0, and a factor 1, where what is
    stated can hold it, and of three steps, which leave nothing to determine it by.
    """
    doubts, errors, factors = [], np.zeros(len(sigma)), np.ones(len(sigma))
    for axis, usual in enumerate(sigma):
        found = mismatch(sample, axis, noise)
        if found is None:
            continue
        scatter = found.scatter
        variance = scatter.of(smooth) if scatter else 1.0
        if variance > 1 + MORE_THAN_NOISE:
            factors[axis] = np.sqrt(variance)
            usual = usual * factors[axis]
        drifts = scatter and found.kind != MOTION and _drifts(scatter, usual)
        if drifts and scatter.periods > found.periods:
            errors[axis] = OF_SINE * scatter.periods
            doubts += _drift_doubts(sample, axis, scatter, scatter.periods / usual)
        elif found.periods > WIDENS * usual:
            errors[axis] = OF_SINE * found.periods
            doubts += _step_doubts(sample, axis, found, found.periods / usual)
    doubts += _shared_noise(sample, factors)
    return doubts, errors, factors


def _shared_noise(sample, factors):
    """A Doubt or none; factors: (A,) by which sigma is larger."""
    if factors.max() > WORTH_SAYING:
        times = " and ".join(
            f"{factor:.2g} ({'xy'[code.axis]})"
            for code, factor in zip(sample.codes, factors, strict=True)
        )
        yield Doubt(
            "correlated-noise",
            False,
            "noise is correlated between neighbouring pixels, as in JPEG files: "
            f"standard deviations are multiplied by {times}; save without loss",
        )


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
            "drift",
            times > TOO_FAR and scatter.periods > FAR_OFF,
            f"light changes from {sample.names[steps[0]]} to {sample.names[steps[-1]]} "
            f"({percent} %): places along {name} are wrong by {scatter.periods:.2g} "
            f"periods, {times:.1f} of their standard deviations by noise; let the "
            f"monitor warm up; {EXPOSE}",
        )


def _step_doubts(sample, axis, found, times):
    """times: the error of places in standard deviations."""
    if times <= WORTH_A_WORD:
        return
    steps, name = sample.codes[axis].steps, "xy"[sample.codes[axis].axis]
    spoils = times > TOO_FAR and found.periods > FAR_OFF
    files = " or ".join(sample.names[k] for k in found.images)
    wrong = (
        f"places along {name} are wrong by {found.periods:.2g} periods, {times:.1f} of "
        "their standard deviations by noise"
    )
    if found.kind == LIGHT:
        spoils = spoils or abs(found.size) > FAR_BRIGHTER
        bright = f"{_brighter(found.size)} than others"
        yield Doubt("brightness", spoils, f"{files} is {bright}; {wrong}; {EXPOSE}")
    else:
        of_all = f"{sample.names[steps[0]]} to {sample.names[steps[-1]]}"
        yield Doubt(
            "moved-step",
            spoils or found.size > FAR_MOVED_PX,
            f"the image moved by about {found.size:.1f} px at {files}, among "
            f"{of_all}; {wrong}; camera and monitor must be at rest: take the images "
            "again",
        )


def unsteady_light(sample):
    """Doubts about the light of a Sample whose images are in order."""
    groups = [(BRIGHTER, dict(_light_of_bits(sample)))]
    # More steps than three say more, and more exactly (`step_errors`).
    three = [k for k, code in enumerate(sample.codes) if len(code.steps) == 3]
    groups += [(BRIGHTER_STEP, dict(_light_of_three(sample, k))) for k in three]
    for least, group in groups:
        if len(group) < 3:
            continue
        usual = np.median(list(group.values()))
        off = {image: value / usual - 1 for image, value in group.items()}
        worst = max(off, key=lambda image: abs(off[image]))
        if abs(off[worst]) > least:
            yield Doubt(
                "brightness",
                abs(off[worst]) > FAR_BRIGHTER,
                f"{sample.names[worst]} is {_brighter(off[worst])} than others; "
                f"{EXPOSE}",
            )


def _brighter(share):
    return f"{100 * abs(share):.2g} % {'brighter' if share > 0 else 'darker'}"


def _light_of_bits(sample):
    """(image, its light where it is bright, as a share of what others give there)"""
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
    # The mean of the images that are bright, for each pixel.
    total = sum(sample.images[image] * on for image, on in bright.items())
    level = total / np.maximum(sum(bright.values(), np.zeros_like(total)), 1)
    for image, on in bright.items():
        on = on & (level > 0)
        if np.count_nonzero(on) > MIN_PIXELS:
            yield image, float(np.mean(sample.images[image][on] / level[on]))


def _light_of_three(sample, axis):
    """(image, its light as a share of what the Gray code gives) of three steps; none
    without inverses. Three steps add up to three times the light without pattern."""
    total, count = np.zeros_like(sample.high), np.zeros_like(sample.high)
    for other, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            if dark is not None:
                clear = np.abs(sample.apart(other, bit)) > CLEAR
                total += clear * (sample.images[light] + sample.images[dark]) / 2
                count += clear
    steps, on = sample.codes[axis].steps, sample.lit & (count > 0)
    if np.count_nonzero(on) < MIN_PIXELS:
        return
    light = sample.images[list(steps)][:, on]
    beyond = light.sum(axis=0) - 3 * total[on] / count[on]
    change = np.linalg.lstsq(light.T, beyond, rcond=None)[0]
    yield from zip(steps, 1 / (1 - change.clip(max=0.9)), strict=True)
