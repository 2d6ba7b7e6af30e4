"""Checks for motion of camera or monitor and for changes of the light.

An image plus its inverse has no pattern, and neither has the sum of phase steps. If
these sums differ as if one of them were shifted, something moved, to first order in the
shift.
"""

from itertools import pairwise

import numpy as np

from raxel.features.active_grid.checks.code import MIN_SPACING_PX, Diagnostic, spacing
from raxel.features.active_grid.checks.redundancy import LIGHT, MOTION, mismatch

WARN_MOTION_PX, MAX_MOTION_PX = 0.7, 1.2
MIN_SLOPE_SHARE = 0.2  # of the steepest slope
MIN_EDGE_SHARE = 0.3  # of those along the other axis
MIN_SIGMAS = 8  # standard deviations of the estimated motion
MIN_TONE_RATIO = 2  # over the effect of a tone curve, which may explain smaller ones


def motion_diagnostics(sample):
    """Yield the largest motion, as one diagnostic or none."""
    found = []
    flat = sorted(_without_pattern(sample), key=lambda one: min(one[0]))
    fitted = [_shifts(plain, flat[0][1], pattern) for _, plain, pattern in flat]
    shifts = [shift for shift, _, _ in fitted]
    # All images share one tone curve, and coarse bits have few edges to estimate it.
    threshold = MIN_TONE_RATIO * max(
        (np.hypot(*tone) for _, _, tone in fitted), default=0.0
    )
    for (images, _, _), (_, within, _) in zip(flat, fitted, strict=True):
        within = within * (np.hypot(*within) > threshold)
        found.append((within, "between {} and {}", images))
    for (before, after), (last, first) in zip(
        pairwise(shifts), pairwise(flat), strict=True
    ):
        images = last[0][-1], first[0][0]
        found.append((after - before, "between {} and {}", images))
    sizes = [float(np.hypot(*shift)) for shift, _, _ in found]
    if sizes and max(sizes) > WARN_MOTION_PX:
        size = max(sizes)
        _, when, images = found[sizes.index(size)]
        when = when.format(sample.names[images[0]], sample.names[images[-1]])
        yield Diagnostic(
            "moved",
            size > MAX_MOTION_PX,
            f"the image moved by about {size:.1f} px {when}; keep camera and monitor "
            "still and retake the images",
        )


def _without_pattern(sample):
    """Yield (images, their mean without pattern, half of the pattern or None)."""
    for axis, code in enumerate(sample.codes):
        for light, dark in code.bits:
            if dark is not None:
                a, b = sample.images[light], sample.images[dark]
                yield (light, dark), (a + b) / 2, (a - b) / 4
        if code.steps:
            yield code.steps, sample.wave(axis)[1], None


def _shifts(plain, reference, pattern):
    """Return shifts (2,) px: against the reference, against the inverse, by tone.

    At an edge of the pattern a tone curve makes image plus inverse brighter or darker,
    for both signs of the edge. The effect of a shift changes its sign with the edge.
    Unless it is far larger, the tone curve may explain it.
    """
    columns = [reference, np.ones_like(reference), *slopes_within(reference)]
    if pattern is None:
        return _fitted(plain, columns)[2:], np.zeros(2), np.zeros(2)
    slopes = [_edges(slope) for slope in slopes_within(pattern)]
    # Where edges end at the monitor's border, a few pixels have the other direction.
    count = [np.count_nonzero(slope) for slope in slopes]
    slopes = [
        s * (n > MIN_EDGE_SHARE * max(count))
        for s, n in zip(slopes, count, strict=True)
    ]
    found = _fitted(plain, [*columns, *slopes, *map(np.abs, slopes)])
    return found[2:4], found[4:6], found[6:]


def slopes_within(image):
    """Return the change per pixel along u and v within each band."""
    if image.shape[1] < 2:
        return np.gradient(image, axis=2), np.zeros_like(image)
    return np.gradient(image, axis=2), np.gradient(image, axis=1)


def _edges(slope):
    """Return the slope at edges, 0 where there is noise."""
    size = np.abs(slope)
    return np.where(size > MIN_SLOPE_SHARE * size.max(), slope, 0)


def _fitted(values, columns):
    """Return coefficients of the columns, 0 below MIN_SIGMAS standard deviations."""
    basis = np.stack([column.ravel() for column in columns], axis=1).astype(float)
    used = basis.any(axis=0)
    scale = np.where(used, np.sqrt(np.mean(basis**2, axis=0)), 1)
    basis = basis / scale
    normal = basis.T @ basis + 1e-9 * len(basis) * np.eye(len(scale))
    inverse = np.linalg.inv(normal)
    found = inverse @ (basis.T @ values.ravel())
    residual = values.ravel() - basis @ found
    spread = np.sqrt(np.mean(residual**2) * np.diag(inverse))
    return np.where(used & (np.abs(found) > MIN_SIGMAS * spread), found / scale, 0)


# Stability of light and phase steps. Where images of the code are bright, they should
# be equally bright. A light change by a share q moves an edge by q sqrt(pi / 8)
# standard deviations of the blur, which is harmless, so the limits are far above noise.


MIN_CLEAR_CONTRAST = 0.75  # of the contrast: pixels outside blurred edges
# Changes of the light, as shares: of code and of steps with a warning; rejected.
WARN_LIGHT_CHANGE, WARN_STEP_LIGHT_CHANGE, MAX_LIGHT_CHANGE = 0.06, 0.02, 0.2
# Position errors by inconsistent steps, in standard deviations: sigma is inflated; a
# warning; rejected if they exceed MIN_REJECTED_PERIODS as well.
INFLATE_SIGMAS, WARN_SIGMAS, REJECT_SIGMAS = 0.3, 2, 10
MIN_REJECTED_PERIODS = 0.01
# Excess variance of windows: 3.6 standard deviations of a median of 800 squares, which
# noise exceeds with a probability of 2e-4.
MIN_EXCESS_VARIANCE = 0.3
WARN_NOISE_FACTOR = 1.3  # factor on the standard deviation for a warning
# Sinusoidal errors are within their RMS for half of the pixels. Within this multiple of
# it are 69 % of them, as for a normal distribution.
SINE_TO_SIGMA = 1.25
MIN_SECOND_DRIFT = 0.3  # relative to the largest: then more than one step changed
EXPOSURE_ADVICE = (
    "disable automatic exposure, expose for whole periods of the monitor's refresh "
    "and retake it"
)
MIN_N_PIXELS = 30


def step_errors(sample, noise, sigma, smooth):
    """Return diagnostics, RMS errors (A,) in periods, and noise factors (A,).

    noise: a Noise; sigma: (A,), standard deviation of most positions, in periods;
    smooth: whether they are those of windows. Errors: of positions by inconsistent
    steps. Factors: increase of sigma by spatially correlated noise. They are 0 and 1
    where sigma is large enough, and for three steps, which have no redundancy.
    """
    diagnostics, errors, factors = [], np.zeros(len(sigma)), np.ones(len(sigma))
    for axis, usual in enumerate(sigma):
        found = mismatch(sample, axis, noise)
        if found is None:
            continue
        scatter = found.scatter
        variance = scatter.of(smooth) if scatter else 1.0
        if variance > 1 + MIN_EXCESS_VARIANCE:
            factors[axis] = np.sqrt(variance)
            usual = usual * factors[axis]
        drifts = scatter and found.kind != MOTION and _drifts(scatter, usual)
        if drifts and scatter.periods > found.periods:
            errors[axis] = SINE_TO_SIGMA * scatter.periods
            diagnostics += _drift_diagnostics(
                sample, axis, scatter, scatter.periods / usual
            )
        elif found.periods > INFLATE_SIGMAS * usual:
            errors[axis] = SINE_TO_SIGMA * found.periods
            diagnostics += _step_diagnostics(sample, axis, found, found.periods / usual)
    diagnostics += _shared_noise(sample, factors)
    return diagnostics, errors, factors


def _shared_noise(sample, factors):
    """Yield a diagnostic or none; factors: (A,) by which sigma increases."""
    if factors.max() > WARN_NOISE_FACTOR:
        times = " and ".join(
            f"{factor:.2g} ({'xy'[code.axis]})"
            for code, factor in zip(sample.codes, factors, strict=True)
        )
        yield Diagnostic(
            "correlated-noise",
            False,
            "noise is correlated between neighbouring pixels (as in JPEG files), sigma "
            f"is multiplied by {times}; save images without loss",
        )


def _drifts(scatter, usual):
    """Whether several steps are brighter or darker, by more than sigma contains."""
    deviations = np.abs(scatter.drift - np.median(scatter.drift))
    several = np.sort(deviations)[-2] > MIN_SECOND_DRIFT * deviations.max()
    return several and scatter.periods > INFLATE_SIGMAS * usual


def _drift_diagnostics(sample, axis, scatter, times):
    """Yield a diagnostic; times: position error in standard deviations."""
    steps, name = sample.codes[axis].steps, "xy"[sample.codes[axis].axis]
    if times > WARN_SIGMAS:
        percent = ", ".join(f"{100 * share:+.1f}" for share in scatter.drift)
        yield Diagnostic(
            "drift",
            times > REJECT_SIGMAS and scatter.periods > MIN_REJECTED_PERIODS,
            f"{sample.names[steps[0]]} to {sample.names[steps[-1]]}: light drifts "
            f"({percent} %), positions along {name} have an error of "
            f"{scatter.periods:.2g} periods ({times:.1f} sigma); let the monitor warm "
            "up",
        )


def _step_diagnostics(sample, axis, found, times):
    """Yield a diagnostic; times: position error in standard deviations."""
    if times <= WARN_SIGMAS:
        return
    steps, name = sample.codes[axis].steps, "xy"[sample.codes[axis].axis]
    invalidates = times > REJECT_SIGMAS and found.periods > MIN_REJECTED_PERIODS
    files = " or ".join(sample.names[k] for k in found.images)
    error = (
        f"positions along {name} have an error of {found.periods:.2g} periods "
        f"({times:.1f} sigma)"
    )
    if found.kind == LIGHT:
        invalidates = invalidates or abs(found.size) > MAX_LIGHT_CHANGE
        bright = f"{_brighter(found.size)} than other steps"
        yield Diagnostic(
            "brightness", invalidates, f"{files}: {bright}, {error}; {EXPOSURE_ADVICE}"
        )
    else:
        of_all = f"{sample.names[steps[0]]} to {sample.names[steps[-1]]}"
        yield Diagnostic(
            "moved-step",
            invalidates or found.size > MAX_MOTION_PX,
            f"{files}: moved by about {found.size:.1f} px among {of_all}, {error}; "
            "keep camera and monitor still and retake the images"
            "again",
        )


def unsteady_light(sample):
    """Yield diagnostics of the light of a Sample whose images are in order."""
    groups = [(WARN_LIGHT_CHANGE, dict(_light_of_bits(sample)))]
    # More than three steps are more informative (`step_errors`).
    three = [k for k, code in enumerate(sample.codes) if len(code.steps) == 3]
    groups += [
        (WARN_STEP_LIGHT_CHANGE, dict(_light_of_three(sample, k))) for k in three
    ]
    for threshold, group in groups:
        if len(group) < 3:
            continue
        usual = np.median(list(group.values()))
        deviations = {image: value / usual - 1 for image, value in group.items()}
        worst = max(deviations, key=lambda image: abs(deviations[image]))
        if abs(deviations[worst]) > threshold:
            yield Diagnostic(
                "brightness",
                abs(deviations[worst]) > MAX_LIGHT_CHANGE,
                f"{sample.names[worst]}: {_brighter(deviations[worst])} than others; "
                f"{EXPOSURE_ADVICE}",
            )


def _brighter(share):
    return f"{100 * abs(share):.2g} % {'brighter' if share > 0 else 'darker'}"


def _light_of_bits(sample):
    """Yield (image, its light where it is bright, relative to that of others)."""
    bright = {}
    for axis, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            difference = sample.difference(axis, bit)
            if spacing(difference > 0, sample.lit) < 2 * MIN_SPACING_PX:
                continue  # blurred stripes have less light
            bright[light] = sample.lit & (difference > MIN_CLEAR_CONTRAST)
            if dark is not None:
                bright[dark] = sample.lit & (difference < -MIN_CLEAR_CONTRAST)
    if not bright:
        return
    # Mean of the images that are bright, for each pixel.
    total = sum(sample.images[image] * on for image, on in bright.items())
    level = total / np.maximum(sum(bright.values(), np.zeros_like(total)), 1)
    for image, on in bright.items():
        on = on & (level > 0)
        if np.count_nonzero(on) > MIN_N_PIXELS:
            yield image, float(np.mean(sample.images[image][on] / level[on]))


def _light_of_three(sample, axis):
    """Yield (image, its light relative to that of the Gray code) of three steps.

    None without inverses. Three steps add up to three times the light without pattern.
    """
    total, count = np.zeros_like(sample.high), np.zeros_like(sample.high)
    for other, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            if dark is not None:
                clear = np.abs(sample.difference(other, bit)) > MIN_CLEAR_CONTRAST
                total += clear * (sample.images[light] + sample.images[dark]) / 2
                count += clear
    steps, on = sample.codes[axis].steps, sample.lit & (count > 0)
    if np.count_nonzero(on) < MIN_N_PIXELS:
        return
    light = sample.images[list(steps)][:, on]
    excess = light.sum(axis=0) - 3 * total[on] / count[on]
    change = np.linalg.lstsq(light.T, excess, rcond=None)[0]
    yield from zip(steps, 1 / (1 - change.clip(max=0.9)), strict=True)
