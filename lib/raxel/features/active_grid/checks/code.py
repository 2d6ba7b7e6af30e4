"""Checks of the Gray code of a view.

Two tests. An image and its inverse share the light: each pixel is bright in one of
them. Where a single bit changes between neighbouring pixels, a Gray code changes by
one, in any scene. Exchanged or inverted bits make the code leap. The exchange that
corrects the code is searched for. A bit that appears twice is reported first.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.constants import golden_ratio

# Sample of pixels for the checks.


N_PIXELS = 250_000
BAND_ROWS = 16  # consecutive rows, so that pixels have neighbours along both axes
# Wider images have shorter bands, as few rows do not distinguish the bits along y.
MAX_BAND_COLUMNS, SHORT_BAND_COLUMNS = 3125, 1000
MIN_CONTRAST_SIGMAS = 10  # standard deviations of the noise
MIN_CONTRAST_SHARE = 0.1  # of the contrast of well lit pixels
MIN_N_LIT = 500  # pixels; with fewer, nothing is checked


class Diagnostic(NamedTuple):
    """Hold a problem of the images and what to do.

    code: kind of the problem, for programs; invalidates: whether the decoded positions
    are wrong; text: problem and remedy.
    """

    code: str
    invalidates: bool
    text: str


@dataclass(frozen=True, eq=False)
class Sample:
    """Hold bands of rows of all images (n, bands, BAND_ROWS, w) float32, and codes.

    high, low: largest and smallest value of each pixel; lit: bool, whether they differ
    clearly. codes: the AxisCodes; extents: (A,) of the monitor, px; names: of the
    images. middle: mean of high and low, for bits without inverse. x: (bands, w), image
    columns from -1 to 1.
    """

    images: np.ndarray
    names: list
    codes: tuple
    extents: np.ndarray
    high: np.ndarray
    low: np.ndarray
    lit: np.ndarray
    middle: np.ndarray
    x: np.ndarray

    def difference(self, axis, bit):
        """Return image minus inverse of a bit, as a share of the contrast, -1 to 1."""
        light, dark = self.codes[axis].bits[bit]
        if dark is None:
            value = 2 * (self.images[light] - self.middle)
        else:
            value = self.images[light] - self.images[dark]
        return value / np.maximum(self.high - self.low, 1e-6)

    def wave(self, axis):
        """Return (B exp(i phi), mean) of the steps that give positions."""
        sines = self.codes[axis].sines
        return self.wave_of(sines, sines.steps)

    def wave_of(self, sines, images):
        """Return `wave` with these images in place of the steps of some Sines."""
        weights = sines.weights.astype(np.float32)
        parts = np.tensordot(weights, self.images[list(images)], 1)
        return parts[1] + 1j * parts[0], parts[2]


def sampled(images, patterns, codes, monitor, noise, levels):
    """Return the Sample of a view's images, or None with too few lit pixels."""
    rows, columns = _bands(*images[0].shape)
    levels = [level for level in levels if level is not None]
    extents = np.array([monitor.monitor_px[code.axis] for code in codes])
    where = rows[..., None], columns[:, None]
    taken = np.array([image[where] for image in (*images, *levels)], np.float32)
    high, low = taken.max(axis=0), taken.min(axis=0)
    contrast = high - low
    spread = np.sqrt(noise.at((high + low) / 2))
    usual = np.quantile(contrast, 0.95)
    lit = contrast > np.maximum(
        MIN_CONTRAST_SIGMAS * spread, MIN_CONTRAST_SHARE * usual
    )
    if np.count_nonzero(lit) < MIN_N_LIT:
        return None
    own = taken[: len(images)], [p.image for p in patterns], codes, extents
    return Sample(
        *own, high, low, lit, (high + low) / 2, 2 * columns / images[0].shape[1] - 1
    )


def _bands(height, width):
    """Return rows (n, BAND_ROWS) and columns (n, w) of evenly spread bands."""
    band = min(BAND_ROWS, height)
    wide = width if width <= MAX_BAND_COLUMNS else SHORT_BAND_COLUMNS
    count = min(max(1, N_PIXELS // (band * wide)), height // band)
    first = np.linspace(0, height - band, count).round().astype(int)
    left = (np.arange(count) * golden_ratio % 1 * (width - wide)).astype(int)
    return first[:, None] + np.arange(band), left[:, None] + np.arange(wide)


def neighbours(distance):
    """Return slices of pixels and of those so far to the right of, or below, them."""
    every = slice(None)
    return (
        ((every, every, slice(None, -distance)), (every, every, slice(distance, None))),
        ((every, slice(None, -distance), every), (every, slice(distance, None), every)),
    )


MAX_UNEQUAL_SHARE = 0.15  # of the lit pixels
# Of the contrast: minimal difference between an image and its inverse.
MIN_BIT_CONTRAST = 0.25
PIXEL_DISTANCE_PX = 4  # between compared pixels: farther than the blur of an edge
MIN_SPACING_PX = 12  # between the edges of a bit that is checked
MIN_N_PAIRS = 30
MAX_LEAP_SHARE = 0.5  # of the edges of a bit
MAX_LEAPS_LEFT = 0.2  # share of the leaps that remain after a correction
REJECT_LEAP_SHARE = 0.4  # of all edges
MIN_READ_SHARE = 0.7  # of the lit pixels, for a bit to count as visible
# A bit appears twice if two bits are equal, or opposite, at so many of the pixels where
# both are readable, and each sign has its share. Different bits have different edges.
DOUBLED_SHARE, MIN_SIGN_SHARE = 0.98, 0.05


def code_diagnostics(sample):
    """Return diagnostics of the Gray codes of a Sample."""
    found = list(_not_opposite(sample))
    return found or list(_out_of_order(sample))


def _not_opposite(sample):
    total = sample.high + sample.low
    contrast = np.maximum(sample.high - sample.low, 1e-6)
    for code in sample.codes:
        for light, dark in code.bits:
            if dark is None:
                continue
            both = sample.images[light] + sample.images[dark]
            excess = np.abs(both - total)[sample.lit] > 0.5 * contrast[sample.lit]
            if excess.mean() > MAX_UNEQUAL_SHARE:
                yield Diagnostic(
                    "not-opposite",
                    True,
                    f"{sample.names[light]}, {sample.names[dark]}: not a pattern and "
                    "its inverse; correct the file names or retake the images",
                )


def _out_of_order(sample):
    bits = [
        (axis, bit)
        for axis, code in enumerate(sample.codes)
        for bit in range(len(code.bits))
    ]
    signs, strong, widths = [], [], []
    for axis, bit in bits:
        difference = sample.difference(axis, bit)
        signs.append(difference > 0)
        strong.append(sample.lit & (np.abs(difference) > MIN_BIT_CONTRAST))
        widths.append(spacing(signs[-1], strong[-1]))
    doubled = list(_doubled([_name(sample, bit) for bit in bits], signs, strong))
    if doubled:
        yield from doubled
        return
    visible = [
        np.count_nonzero(s) > MIN_READ_SHARE * np.count_nonzero(sample.lit)
        for s in strong
    ]
    orders, coarser = _countable(sample, bits, widths, visible)
    if coarser:
        yield coarser
        return
    kept = [k for order in orders for k in order]
    if len(kept) < 2:
        return
    words = sum(
        signs[k].astype(np.int64) << position for position, k in enumerate(kept)
    )
    valid = np.logical_and.reduce([strong[k] for k in kept])
    before, after, count = _single_changes(words, valid)
    positions = {k: position for position, k in enumerate(kept)}
    slots = [[(positions[k], False) for k in order] for order in orders]
    diagnostic = _leaping(before, after, count, slots)
    if diagnostic is None:
        return
    named = [_name(sample, bits[k]) for k in kept]
    cause = _cause(before, after, count, slots, named)
    if cause or max(diagnostic) > REJECT_LEAP_SHARE:
        axes = [a for a in range(len(orders)) if diagnostic[a]]
        where = " and ".join("xy"[sample.codes[a].axis] for a in axes)
        of_all = _listed(named[p] for a in axes for p, _ in slots[a])
        cause = cause or f"check axis, bit and inverse ({of_all})"
        yield Diagnostic(
            "code-leaps", True, f"axis {where}: the Gray code has leaps; {cause}"
        )


def _doubled(names, signs, strong):
    """Yield diagnostics of bits with the same edges; names: pairs, of each."""
    for one, other in combinations(range(len(names)), 2):
        both = strong[one] & strong[other]
        first, second = signs[one][both], signs[other][both]
        if not len(first):
            continue
        alike = np.mean(first == second)
        shares = [np.mean(sign) for sign in (first, second)]
        two = min(*shares, *(1 - share for share in shares)) > MIN_SIGN_SHARE
        if two and max(alike, 1 - alike) > DOUBLED_SHARE:
            yield Diagnostic(
                "doubled-bit",
                True,
                f"{_both(names[other])}: same stripes as {_both(names[one])}; correct "
                "the file names or retake the images",
            )


def _name(sample, position):
    light, dark = sample.codes[position[0]].bits[position[1]]
    return sample.names[light], None if dark is None else sample.names[dark]


def _both(pair):
    """Return the names of an image and its inverse, if it has one."""
    return " and ".join(name for name in pair if name)


def _listed(pairs):
    return ", ".join(name for pair in pairs for name in pair if name)


def spacing(sign, strong):
    """Return the mean distance between the edges of a bit, along the denser axis."""
    result = np.inf
    for first, second in neighbours(1):
        both = strong[first] & strong[second]
        edges = np.count_nonzero((sign[first] != sign[second]) & both)
        # Weak pixels at an edge hide it from their neighbours.
        blurred = np.count_nonzero(strong[first] & ~strong[second])
        total = np.count_nonzero(both)
        result = min(result, total / max(edges + blurred / 2, 1))
    return result


def _countable(sample, bits, widths, visible):
    """Return the bits of each axis, coarsest first, up to the first one too fine.

    With a diagnostic where a coarse bit follows one that is too fine.
    """
    orders = []
    for axis in range(len(sample.codes)):
        own = [k for k, (a, _) in enumerate(bits) if a == axis]
        fine = next((k for k in own if widths[k] < MIN_SPACING_PX), None)
        stop = own.index(fine) if fine is not None else len(own)
        for k in own[stop + 1 :]:
            wide = np.isfinite(widths[k]) and widths[k] >= MIN_SPACING_PX
            if wide and visible[k] and visible[fine] and widths[k] > 2 * widths[fine]:
                first, second = (_both(_name(sample, bits[n])) for n in (fine, k))
                name = "xy"[sample.codes[axis].axis]
                return orders, Diagnostic(
                    "coarse-after-fine",
                    True,
                    f"{second}: coarser stripes than {first}, the bit before it in the "
                    f"code of axis {name}; correct bit",
                )
        orders.append(own[:stop])
    return orders, None


def _single_changes(words, valid):
    """Return (before, after, count) of words that differ in one bit, a little apart."""
    found = []
    for first, second in neighbours(PIXEL_DISTANCE_PX):
        if min(words[first].shape) == 0:
            continue
        both = valid[first] & valid[second] & (words[first] != words[second])
        found.append(np.stack([words[first][both], words[second][both]]))
    pairs = np.concatenate(found, axis=1)
    changed = pairs[0] ^ pairs[1]
    pairs = pairs[:, (changed & (changed - 1)) == 0]
    if not pairs.size:
        return np.empty(0, int), np.empty(0, int), np.empty(0, int)
    unique, count = np.unique(pairs, axis=1, return_counts=True)
    return *unique, count


def _codes(words, slots):
    """Return cell numbers of words; slots: (position in the word, inverted) by bit."""
    code, value = np.zeros_like(words), np.zeros_like(words)
    for position, inverted in slots:
        value = value ^ (words >> position & 1) ^ inverted
        code = 2 * code + value
    return code


def _leaps(before, after, count, slots):
    """Return for each slot the pixel pairs where only its bit changes, and leaps."""
    step = np.abs(_codes(before, slots) - _codes(after, slots))
    changed = before ^ after
    own = [(changed >> position & 1).astype(bool) for position, _ in slots]
    return np.array([[count[o].sum(), count[o & (step != 1)].sum()] for o in own])


def _leaping(before, after, count, slots):
    """Return the share of leaps among the edges of each axis, or None without any."""
    shares = []
    for order in slots:
        table = _leaps(before, after, count, order) if order else np.zeros((0, 2))
        bad = (table[:, 1] > MAX_LEAP_SHARE * table[:, 0]) & (
            table[:, 1] >= MIN_N_PAIRS
        )
        shares.append(table[:, 1].sum() / table[:, 0].sum() if bad.any() else 0.0)
    return shares if any(shares) else None


def _cause(before, after, count, slots, names):
    """Return the remedy for the single mistake that explains the leaps, or "".

    names: (image, inverse) by position in the word.
    """

    def leaps(trial):
        return sum(
            _leaps(before, after, count, order)[:, 1].sum() for order in trial if order
        )

    trials = [(leaps(trial), text) for trial, text in _trials(slots, names)]
    fewest, text = min(trials, key=lambda one: one[0], default=(np.inf, ""))
    return text if fewest <= MAX_LEAPS_LEFT * leaps(slots) else ""


def _trials(slots, names):
    """Yield orders of bits after a single mistake, each with its remedy."""
    flat = [(a, b) for a, order in enumerate(slots) for b in range(len(order))]
    for a, b in flat:
        if b:  # an inverted coarsest bit reverses the axis and makes no leap
            position, inverted = slots[a][b]
            text = f"correct inverse of {_both(names[position])}"
            yield _with(slots, {(a, b): (position, not inverted)}), text
    for (a, b), (c, d) in combinations(flat, 2):
        one, other = slots[a][b], slots[c][d]
        pairs = zip(names[one[0]], names[other[0]], strict=True)
        text = ", ".join(f"{j} and {k}" for j, k in pairs if j and k)
        yield _with(slots, {(a, b): other, (c, d): one}), f"exchange {text}"


def _with(slots, changes):
    return [
        [changes.get((a, b), slot) for b, slot in enumerate(order)]
        for a, order in enumerate(slots)
    ]
