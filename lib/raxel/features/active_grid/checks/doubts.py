"""What the images of an active grid say against themselves.

An image in another's place, a camera that moved, an exposure that changed: the decoder
would take them, and its sigma would not know. They contradict one another all the same,
and that is looked for here, on a part of the pixels. What a scene may do is no
contradiction: places may jump from pixel to pixel, and parts may be dark or unseen.
"""

import hashlib
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.checks.code import Doubt, code_doubts, sampled
from raxel.features.active_grid.checks.motion import (
    motion_doubts,
    step_errors,
    unsteady_light,
)
from raxel.features.active_grid.checks.phases import moved_doubts, phase_doubts
from raxel.features.active_grid.coding import BESIDE, DARK, SATURATED, read_coding
from raxel.sets.patterns import pattern_picture

# Of the pixels that see the monitor: shares that are worth a word, or too many.
CLIPPED = 0.1
OUTSIDE = 0.2
# Values so much more frequent than those below them are where a camera stops counting.
SPIKE = 5
MIN_AT_LIMIT = 5e-4
FEW = 50_000  # pixels, enough for a median


class Examined(NamedTuple):
    """The Doubts about images that were decoded, those that spoil the result first;
    errors of places (2,) by what the steps of sines contradict each other, in the unit
    of the result, 0 where sigma holds them; and factors (2,) by which noise that
    neighbours share makes sigma larger, 1 where it is white."""

    doubts: list[Doubt]
    errors: np.ndarray
    factors: np.ndarray

    def widened(self, sigma):
        """sigma (H, W, 2) with the errors; factors are for `decode`, as `shared`."""
        return np.hypot(sigma, self.errors).astype(np.float32)


def examine(
    images, patterns, monitor, decoded, white=None, black=None, smooth=True
):  # fmt: skip
    """What these images say against themselves, as Examined.

    As `decode`, whose result `decoded` is, with windows averaged or not (smooth).
    Not detected: both axes exchanged or one of them reversed as a whole, which is what
    a mirror does; light that drifts by a few percent over all images; something that
    covers the monitor in some of them; a step of three that is brighter, where no Gray
    code has its inverse; and a movement of less than a pixel that neither the edges
    beside the pattern, the steps, nor the code shows.
    """
    found = list(_equal_pictures(images, patterns))
    errors, factors = np.zeros(2), np.ones(2)
    codes = read_coding(patterns, monitor.monitor_px)
    levels = white, black
    sample = sampled(images, patterns, codes, monitor, decoded.noise, levels)
    found += _levels(sample, white, black)
    if sample is not None:
        found += code_doubts(sample)
        found += phase_doubts(sample, decoded.noise)
        # In the wrong order, images seem unsteady as well.
        if not any(doubt.spoils for doubt in found):
            found += unsteady_light(sample)
            found += motion_doubts(sample)
            of_steps, errors, factors = _of_steps(sample, monitor, decoded, smooth)
            found += of_steps
            for axis, code in enumerate(codes):
                if not errors[code.axis]:
                    found += moved_doubts(sample, axis, decoded.blur_px)
    found += _left_out(decoded, codes)
    found = sorted(found, key=lambda doubt: not doubt.spoils)
    return Examined(found, errors, factors)


def _of_steps(sample, monitor, decoded, smooth):
    """Doubts, errors (2,) and factors (2,) by steps that do not agree."""
    errors, factors = np.zeros(2), np.ones(2)
    known = decoded.sigma[decoded.mask]
    if not len(known):
        return [], errors, factors
    size = monitor.monitor_mm or monitor.monitor_px
    axes = [code.axis for code in sample.codes]
    lengths = [
        (code.period or code.cell) * size[code.axis] / monitor.monitor_px[code.axis]
        for code in sample.codes
    ]
    usual = np.median(known[:: 1 + len(known) // FEW], axis=0)[axes] / lengths
    doubts, periods, wider = step_errors(sample, decoded.noise, usual, smooth)
    errors[axes], factors[axes] = periods * lengths, wider
    return doubts, errors, factors


def _equal_pictures(images, patterns):
    """Two photographs are never equal, unless there is nothing in them."""
    first = {}
    for image, pattern in zip(images, patterns, strict=True):
        if image.min() == image.max():
            continue
        key = hashlib.blake2b(np.ascontiguousarray(image)).digest()
        other = first.setdefault(key, pattern)
        if other is not pattern and not _shown_alike(other, pattern):
            yield Doubt(
                "same-image",
                True,
                f"{pattern.image}: the same image as {other.image}, pixel for pixel; "
                "take it again or mend the name",
            )


def _shown_alike(one, other):
    """Whether a usual monitor shows both alike, as bits of a code too long for it."""
    size = 1024, 1024
    same = pattern_picture(one, size) == pattern_picture(other, size)
    return bool(same.all())


def _levels(sample, white, black):
    """White is brighter than black, where there is light."""
    if sample is None or white is None or black is None:
        return
    light = white.astype(np.int32) - black
    if np.quantile(light, 0.95) < np.abs(np.quantile(light, 0.05)):
        yield Doubt(
            "white-black",
            True,
            "its black image is brighter than its white one; exchange white and black",
        )


def _left_out(decoded, codes):
    """Pixels that are not decoded for one reason, too many of those not in the dark."""
    counts = np.bincount(decoded.status.ravel(), minlength=8)
    seen = max(counts.sum() - counts[DARK], 1)
    if counts[BESIDE] > OUTSIDE * seen:
        axes = " and ".join("xy"[code.axis] for code in codes)
        yield Doubt(
            "beside-monitor",
            True,
            f"{100 * counts[BESIDE] / seen:.0f} % of the pixels would lie beside the "
            f"monitor along {axes}; correct target.monitor_px, or of and cell_px of "
            "its Gray code",
        )
    if counts[SATURATED] > CLIPPED * seen:
        yield Doubt(
            "overexposed",
            False,
            f"{100 * counts[SATURATED] / seen:.0f} % of the pixels that see the "
            "monitor are overexposed and left out; expose less",
        )


def clipped_at(images, patterns):
    """The grey value at which the sines are clipped, None where none is.

    A camera of 12 bits in files of 16, or one that ends at 235, clips its sines below
    the largest value of the file: such a value is far more frequent than those below.
    """
    sines = [i for i, p in zip(images, patterns, strict=True) if p.kind == "phase"]
    if not sines:
        return None
    top = max(int(image.max()) for image in sines)
    count = total = 0
    for image in sines:
        count += int(np.count_nonzero(image == top))
        total += image.size
    if count < MIN_AT_LIMIT * total:
        return None
    values = np.concatenate([image[image > 0.9 * top].ravel() for image in sines])
    lower = np.unique(values[values < top])[::-1][:3]
    if len(lower) < 3:
        return None
    below = np.isin(values, lower).sum() / len(lower)
    return top if count > SPIKE * below else None
