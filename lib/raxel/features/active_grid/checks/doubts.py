"""What the pictures of an active grid say against themselves.

A picture in another's place, a camera that moved, an exposure that changed: the decoder
would take them, and its sigma would not know. They contradict one another all the same,
and that is looked for here, on a part of the pixels. What a scene may do is no
contradiction: places may jump from pixel to pixel, and parts may be dark or unseen.
"""

import hashlib
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.checks.code import code_doubts
from raxel.features.active_grid.checks.edges import moved_doubts
from raxel.features.active_grid.checks.jolts import (
    changes_over,
    jolt_doubts,
    jolts,
    without_means_of,
)
from raxel.features.active_grid.checks.motion import motion_doubts
from raxel.features.active_grid.checks.phases import phase_doubts
from raxel.features.active_grid.checks.sample import Doubt, sampled
from raxel.features.active_grid.checks.steadiness import (
    WIDENS,
    WORTH_A_WORD,
    step_errors,
    unsteady_light,
)
from raxel.features.active_grid.checks.tones import tone_doubts
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.layout import BESIDE, DARK, SATURATED
from raxel.sets.patterns import pattern_picture

# Of the pixels that see the monitor: shares that are worth a word, or too many.
CLIPPED = 0.1
OUTSIDE = 0.2
# Values so much more frequent than those below them are where a camera stops counting.
SPIKE = 5
MOSAIC = 0.1  # of the light: pixels of every second row or column differ by more
MIN_AT_LIMIT = 5e-4
FEW = 50_000  # pixels, enough for a median


class ClippedAt(NamedTuple):
    """The grey value at which pictures stop, and the share of pixels there."""

    level: int
    share: float


class Examined(NamedTuple):
    """The Doubts about pictures that were decoded, those that spoil the result first;
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
    images, patterns, monitor, decoded,
    white=None, black=None, smooth=True, spoilt=None, bands=(1.0, 1.0),
):  # fmt: skip
    """What these pictures say against themselves, as Examined.

    As `decode`, whose result `decoded` is, with windows averaged or not (smooth).
    spoilt: (H, W) bool, pixels before which something passed, and bands, as of
    `passing.Passing`. What
    is not told: two axes exchanged as a whole, or one of them reversed as a whole,
    which is what a mirror does; light that drifts by a few percent over all pictures,
    and turns no phase by more than noise; tones that a camera sets by what lies around,
    where there is no Gray code; a step of three that is brighter, where no
    Gray code has its inverse; and a movement of a pixel between two pictures, where
    neither edges beside the pattern nor steps and code of one axis, before and after
    it, show it.
    """
    found = list(_equal_pictures(images, patterns))
    errors, factors = np.zeros(2), np.ones(2)
    codes = read_coding(patterns, monitor.monitor_px)
    levels = white, black
    sample = sampled(images, patterns, codes, monitor, decoded.noise, levels, spoilt)
    found += _levels(sample, white, black)
    if sample is not None:
        found += code_doubts(sample)
        found += phase_doubts(sample, decoded.noise)
        # In the wrong order, pictures seem unsteady as well.
        if not any(doubt.spoils for doubt in found):
            found += unsteady_light(sample)
            found += tone_doubts(sample, decoded.blur_px)
            far = list(motion_doubts(sample))
            of_steps, errors, factors = _of_steps(
                sample, monitor, decoded, smooth, bands, far
            )
            found += far + of_steps
            for axis, code in enumerate(codes):
                if not errors[code.axis]:
                    found += moved_doubts(sample, axis, decoded.blur_px)
    found += _mosaic(images, codes, decoded)
    found += _outside(decoded, codes)
    found += _overexposed(decoded)
    found = sorted(found, key=lambda doubt: not doubt.spoils)
    return Examined(found, errors, factors)


def _of_steps(sample, monitor, decoded, smooth, bands, far):
    """Doubts, errors (2,) and factors (2,) by steps that do not agree, and by movements
    between them; far: doubts about such as are told already."""
    size = monitor.monitor_mm or monitor.monitor_px
    lengths = np.array(
        [
            (code.period or code.cell) * size[code.axis] / monitor.monitor_px[code.axis]
            for code in sample.codes
        ]
    )
    known = decoded.sigma[decoded.mask]
    errors, factors = np.zeros(2), np.ones(2)
    if not len(known):
        return [], errors, factors
    axes = [code.axis for code in sample.codes]
    every = np.median(known[:: 1 + len(known) // FEW], axis=0)
    noise, stated = decoded.noise, every[axes] / lengths
    bands = [bands[axis] for axis in axes]
    moved = jolts(sample, decoded.blur_px)
    jolted = [jolt.within for jolt in moved]
    told = step_errors(sample, noise, stated, smooth, bands, jolted)
    doubts, periods, wider, mean_moved = told
    errors[axes], factors[axes] = periods * lengths, wider
    moved = without_means_of(moved, mean_moved)
    if moved:
        off = [changes_over(jolt.shift, decoded.location) for jolt in moved]
        off = np.max(off, axis=0)
        errors = np.hypot(errors, np.where(off > WIDENS * every, off, 0))
        if not far:
            doubts += jolt_doubts(sample, moved, off, WORTH_A_WORD * every)
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
                True,
                f"{pattern.image}: the same picture as {other.image}, pixel for pixel; "
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
            True,
            "its black picture is brighter than its white one; exchange white and "
            "black",
        )


def _mosaic(images, codes, decoded):
    """Raw pictures of colour sensors: neighbours see other colours."""
    steps = next((code.steps for code in codes if len(code.steps) > 2), ())
    if not steps:
        return
    parts = [np.s_[down::2, right::2] for down in (0, 1) for right in (0, 1)]
    light = np.array([sum(images[k][part].mean() for k in steps) for part in parts])
    apart = np.ptp(light) / max(light.mean(), 1e-6)
    if apart > MOSAIC:
        yield Doubt(
            not decoded.mask.any(),
            f"pixels of every second row or column differ by {100 * apart:.0f} % of "
            "their light, which is taken for noise: raw pictures of a colour camera "
            "are mosaics; give their colour pictures, or grey ones made of them",
        )


def _outside(decoded, codes):
    """The code counts cells that the monitor does not have."""
    counts = np.bincount(decoded.status.ravel(), minlength=8)
    seen = counts[[k for k in range(8) if k != DARK]].sum()
    if counts[BESIDE] > OUTSIDE * max(seen, 1):
        axes = " and ".join("xy"[code.axis] for code in codes)
        share = 100 * counts[BESIDE] / seen
        yield Doubt(
            True,
            f"{share:.0f} % of the pixels would lie beside the monitor along {axes}; "
            "mend target.monitor_px, or of and cell_px of its Gray code",
        )


def _overexposed(decoded):
    counts = np.bincount(decoded.status.ravel(), minlength=8)
    seen = counts.sum() - counts[DARK]
    if counts[SATURATED] > CLIPPED * max(seen, 1):
        share = 100 * counts[SATURATED] / seen
        yield Doubt(
            False,
            f"{share:.0f} % of the pixels that see the monitor are overexposed and "
            "left out; expose less",
        )


def clipped_at(images, patterns):
    """Where these pictures stop, as ClippedAt, or None where they do not.

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
    return ClippedAt(top, count / total) if count > SPIKE * below else None
