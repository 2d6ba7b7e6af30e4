"""Consistency checks on the images of an active grid.

A misplaced image, a moved camera or a changed exposure can be decoded, and sigma does
not contain it. Such images contradict each other, which is tested here on a sample of
the pixels. Effects of the scene are not contradictions: positions may jump between
pixels, and parts may be dark or invisible.
"""

import hashlib
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.checks.code import Diagnostic, code_diagnostics, sampled
from raxel.features.active_grid.checks.motion import (
    motion_diagnostics,
    step_errors,
    unsteady_light,
)
from raxel.features.active_grid.checks.phases import (
    motion_after_code,
    phase_diagnostics,
)
from raxel.features.active_grid.coding import DARK, OUTSIDE, SATURATED, read_coding
from raxel.sets.patterns import pattern_image

# Maximal shares of the pixels on the monitor.
MAX_CLIPPED_SHARE = 0.1
MAX_OUTSIDE_SHARE = 0.2
# A value so much more frequent than those below it is the camera's saturation level.
MIN_SPIKE_RATIO = 5
MIN_CLIPPED_SHARE = 5e-4
N_MEDIAN_PIXELS = 50_000  # for a median
USUAL_PX = 1024, 1024  # monitor that displays bits finer than its pixels as equal


class Examined(NamedTuple):
    """Hold the diagnostics of decoded images, the fatal ones first.

    errors: (2,) of positions by inconsistent phase steps, in the unit of the result, 0
    where sigma contains them; factors: (2,) by which spatially correlated noise
    increases sigma, 1 for white noise.
    """

    diagnostics: list[Diagnostic]
    errors: np.ndarray
    factors: np.ndarray

    def widened(self, sigma):
        """Return sigma (H, W, 2) with the errors; `decode` applies the factors."""
        wider = np.empty_like(sigma)
        return np.hypot(sigma, self.errors, out=wider, casting="same_kind")


def examine(
    images, patterns, monitor, decoded, white=None, black=None, smooth=True
):  # fmt: skip
    """Check the images of a view against each other and return Examined.

    Arguments as of `decode`, and its result; smooth: whether windows were averaged.
    Not detected: both axes exchanged, or one axis reversed, as in a mirror; a drift of
    the light by a few percent over all images; an occlusion in some images; one
    brighter step of three, without inverses in the Gray code; and a movement of less
    than a pixel without visible edges, in neither steps nor code.
    """
    found = list(_equal_images(images, patterns))
    errors, factors = np.zeros(2), np.ones(2)
    codes = read_coding(patterns, monitor.monitor_px)
    sample = sampled(images, patterns, codes, monitor, decoded.noise, (white, black))
    found += _levels(sample, white, black)
    if sample is not None:
        found += code_diagnostics(sample)
        found += phase_diagnostics(sample, decoded.noise)
        # Misordered images would appear unsteady as well.
        if not any(diagnostic.invalidates for diagnostic in found):
            found += unsteady_light(sample)
            found += motion_diagnostics(sample)
            of_steps, errors, factors = _of_steps(sample, monitor, decoded, smooth)
            found += of_steps
            for axis, code in enumerate(codes):
                if not errors[code.axis]:
                    found += motion_after_code(sample, axis, decoded.blur_px)
    found += _exclusion_diagnostics(decoded, codes)
    found.sort(key=lambda diagnostic: not diagnostic.invalidates)
    return Examined(found, errors, factors)


def _of_steps(sample, monitor, decoded, smooth):
    """Return diagnostics, errors (2,) and factors (2,) by inconsistent steps."""
    errors, factors = np.zeros(2), np.ones(2)
    mask = decoded.mask
    step = 1 + np.count_nonzero(mask) // N_MEDIAN_PIXELS
    known = [decoded.sigma[..., code.axis][mask][::step] for code in sample.codes]
    if not len(known[0]):
        return [], errors, factors
    size = monitor.monitor_mm or monitor.monitor_px
    axes = [code.axis for code in sample.codes]
    lengths = [
        (code.period or code.cell) * size[code.axis] / monitor.monitor_px[code.axis]
        for code in sample.codes
    ]
    usual = np.median(known, axis=1) / lengths
    diagnostics, periods, wider = step_errors(sample, decoded.noise, usual, smooth)
    errors[axes], factors[axes] = periods * lengths, wider
    return diagnostics, errors, factors


def _equal_images(images, patterns):
    """Yield a diagnostic for equal images, unless they are uniform."""
    first = {}
    for stored, pattern in zip(images, patterns, strict=True):
        image = stored[:]
        if image.min() == image.max():
            continue
        key = hashlib.blake2b(np.ascontiguousarray(image)).digest()
        other = first.setdefault(key, pattern)
        if other is not pattern and not np.array_equal(
            # Usual monitors display both alike, as bits finer than their pixels.
            *(pattern_image(each, USUAL_PX) for each in (other, pattern))
        ):
            yield Diagnostic(
                "same-image",
                True,
                f"{pattern.image}: identical to {other.image}; retake the image or "
                "correct the file name",
            )


def _levels(sample, white, black):
    """Yield a diagnostic if black is brighter than white."""
    if sample is None or white is None or black is None:
        return
    light = np.subtract(white[:], black[:], dtype=np.int32)
    low, high = np.quantile(light, (0.05, 0.95), overwrite_input=True)
    if high < np.abs(low):
        yield Diagnostic(
            "white-black",
            True,
            "black is brighter than white; exchange white and black",
        )


def _exclusion_diagnostics(decoded, codes):
    """Yield diagnostics of pixels that are excluded for one reason too often."""
    counts = list(decoded.counts().values())
    visible = max(sum(counts) - counts[DARK], 1)
    if counts[OUTSIDE] > MAX_OUTSIDE_SHARE * visible:
        axes = " and ".join("xy"[code.axis] for code in codes)
        yield Diagnostic(
            "beside-monitor",
            True,
            f"{100 * counts[OUTSIDE] / visible:.0f} % of the pixels decode to "
            f"positions outside the monitor along {axes}; correct target.monitor_px, "
            "or of and cell_px of its Gray code",
        )
    if counts[SATURATED] > MAX_CLIPPED_SHARE * visible:
        yield Diagnostic(
            "overexposed",
            False,
            f"{100 * counts[SATURATED] / visible:.0f} % of the pixels on the monitor "
            "are excluded (overexposed); reduce the exposure",
        )


def clipped_at(images, patterns):
    """Return the grey level at which the sinusoids are clipped, or None.

    A camera with 12 bits in files of 16, or one that saturates at 235, clips below the
    largest value of the file. The clipped value is far more frequent than those below.
    """
    sines = [i for i, p in zip(images, patterns, strict=True) if p.kind == "phase"]
    if not sines:
        return None
    top = max(int(image[:].max()) for image in sines)
    count = sum(int(np.count_nonzero(image[:] == top)) for image in sines)
    if count < MIN_CLIPPED_SHARE * len(sines) * np.prod(sines[0].shape):
        return None
    values = np.concatenate([i[i > 0.9 * top] for i in (image[:] for image in sines)])
    lower = np.unique(values[values < top])[::-1][:3]
    if len(lower) < 3:
        return None
    below = np.isin(values, lower).sum() / len(lower)
    return top if count > MIN_SPIKE_RATIO * below else None
