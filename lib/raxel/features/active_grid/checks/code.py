"""Does the Gray code of the images count?

Two tests. An image and its inverse share the light: each pixel is bright in one of
them. And where one bit alone changes from a pixel to one beside it, the code goes one
up or down, whatever the scene: only that makes it a Gray code. Bits in each other's
place, or turned over, count in leaps; which exchange would mend that is tried out. A
bit that is there twice, in another's place, is told before.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

# The part of the pixels that doubts are looked for in, and what codes make of it.


PIXELS = 250_000
BAND = 16  # rows that are taken together, so that there are neighbours both ways
MIN_CONTRAST = 10  # standard deviations of the noise
MIN_SHARE = 0.1  # of what the better lit pixels have
MIN_LIT = 500  # pixels; of fewer, nothing is said


class Doubt(NamedTuple):
    """What was found and what to do. code: of its kind, for programs; `spoils`: what
    was decoded is wrong."""

    code: str
    spoils: bool
    text: str


@dataclass(frozen=True, eq=False)
class Sample:
    """Bands of rows of all images (n, bands, BAND, W) float32, and their codes.

    high, low: the brightest and darkest of each pixel; lit: bool, whether they are far
    apart. codes: the AxisCodes; extents: (A,) of the monitor, px; names: of the
    images. middle: halfway, for bits without inverse.
    """

    images: np.ndarray
    names: list
    codes: tuple
    extents: np.ndarray
    high: np.ndarray
    low: np.ndarray
    lit: np.ndarray
    middle: np.ndarray

    def apart(self, axis, bit):
        """Picture less inverse of a bit, in shares of the contrast, -1 to 1."""
        light, dark = self.codes[axis].bits[bit]
        if dark is None:
            value = 2 * (self.images[light] - self.middle)
        else:
            value = self.images[light] - self.images[dark]
        return value / np.maximum(self.high - self.low, 1e-6)

    def wave(self, axis):
        """(B exp(i phi), mean) of the steps that places are read from."""
        sines = self.codes[axis].sines
        return self.wave_of(sines, sines.steps)

    def wave_of(self, sines, images):
        """As `wave`, of these images in the place of the steps of some Sines."""
        weights = sines.weights.astype(np.float32)
        parts = np.tensordot(weights, self.images[list(images)], 1)
        return parts[1] + 1j * parts[0], parts[2]


def sampled(images, patterns, codes, monitor, noise, levels):
    """The Sample of a view's images, or None where too little of it is lit."""
    height, width = images[0].shape
    rows = _rows(height, width)
    levels = [level for level in levels if level is not None]
    extents = np.array([monitor.monitor_px[code.axis] for code in codes])
    taken = np.array([image[rows] for image in (*images, *levels)], np.float32)
    taken = taken.reshape(len(taken), -1, min(BAND, height), width)
    high, low = taken.max(axis=0), taken.min(axis=0)
    contrast = high - low
    spread = np.sqrt(noise.at((high + low) / 2))
    usual = np.quantile(contrast, 0.95)
    lit = contrast > np.maximum(MIN_CONTRAST * spread, MIN_SHARE * usual)
    if np.count_nonzero(lit) < MIN_LIT:
        return None
    names = [p.image for p in patterns]
    own = taken[: len(images)], names, codes, extents
    return Sample(*own, high, low, lit, (high + low) / 2)


def _rows(height, width):
    """Bands of rows, evenly spread, of about PIXELS pixels."""
    band = min(BAND, height)
    count = min(max(1, PIXELS // (band * width)), height // band)
    first = np.linspace(0, height - band, count).round().astype(int)
    return (first[:, None] + np.arange(band)).ravel()


def neighbours(distance):
    """Slices of pixels and of those so far to the right of, or below, them."""
    every = slice(None)
    return (
        ((every, every, slice(None, -distance)), (every, every, slice(distance, None))),
        ((every, slice(None, -distance), every), (every, slice(distance, None), every)),
    )


NOT_OPPOSITE = 0.15  # share of the lit pixels
STRONG = 0.25  # of the contrast: so far apart, an image and its inverse are read
APART_PX = 4  # between the pixels that are compared: beyond the blur of an edge
MIN_SPACING_PX = 12  # between the edges of a bit, to be counted
MIN_PAIRS = 30
LEAPS = 0.5  # of the edges of a bit
HEALED = 0.2  # of the leaps are left by an exchange that explains them
BEYOND_REPAIR = 0.4  # of all edges
READ = 0.7  # of the lit pixels, for a bit to count as seen
# Of the pixels at which two bits are read: as many alike, or opposite, and one bit is
# shown twice, where each sign has its share. No two bits change at the same places.
ALIKE, BOTH_SIGNS = 0.98, 0.05


def code_doubts(sample):
    """Doubts about the Gray codes of a Sample."""
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
            off = np.abs(both - total)[sample.lit] > 0.5 * contrast[sample.lit]
            if off.mean() > NOT_OPPOSITE:
                yield Doubt(
                    "not-opposite",
                    True,
                    f"{sample.names[light]} and {sample.names[dark]} are not opposite "
                    "to each other, as a pattern and its inverse are; put the right "
                    "pictures there or take them again",
                )


def _out_of_order(sample):
    bits = [
        (axis, bit)
        for axis, code in enumerate(sample.codes)
        for bit in range(len(code.bits))
    ]
    signs, strong, widths = [], [], []
    for axis, bit in bits:
        apart = sample.apart(axis, bit)
        signs.append(apart > 0)
        strong.append(sample.lit & (np.abs(apart) > STRONG))
        widths.append(spacing(signs[-1], strong[-1]))
    doubled = list(_doubled([_name(sample, bit) for bit in bits], signs, strong))
    if doubled:
        yield from doubled
        return
    seen = [np.count_nonzero(s) > READ * np.count_nonzero(sample.lit) for s in strong]
    orders, coarser = _countable(sample, bits, widths, seen)
    if coarser:
        yield coarser
        return
    kept = [k for order in orders for k in order]
    if len(kept) < 2:
        return
    words = sum(signs[k].astype(np.int64) << place for place, k in enumerate(kept))
    valid = np.logical_and.reduce([strong[k] for k in kept])
    before, after, count = _single_changes(words, valid)
    places = {k: place for place, k in enumerate(kept)}
    slots = [[(places[k], False) for k in order] for order in orders]
    doubt = _leaping(before, after, count, slots)
    if doubt is None:
        return
    named = [_name(sample, bits[k]) for k in kept]
    cause = _cause(before, after, count, slots, named)
    if cause or max(doubt) > BEYOND_REPAIR:
        axes = [a for a in range(len(orders)) if doubt[a]]
        where = " and ".join("xy"[sample.codes[a].axis] for a in axes)
        of_all = _listed(named[p] for a in axes for p, _ in slots[a])
        cause = cause or f"check axis, bit and inverse of {of_all}"
        yield Doubt("code-leaps", True, f"the Gray code of axis {where} leaps: {cause}")


def _doubled(names, signs, strong):
    """Doubts about bits that change where another one does; names: pairs, of each."""
    for one, other in combinations(range(len(names)), 2):
        both = strong[one] & strong[other]
        first, second = signs[one][both], signs[other][both]
        if not len(first):
            continue
        alike = np.mean(first == second)
        shares = [np.mean(sign) for sign in (first, second)]
        two = min(*shares, *(1 - share for share in shares)) > BOTH_SIGNS
        if two and max(alike, 1 - alike) > ALIKE:
            yield Doubt(
                "doubled-bit",
                True,
                f"{_both(names[other])}: the same stripes as of {_both(names[one])}; "
                "one of both is there twice: put the right images there or take them "
                "again",
            )


def _name(sample, place):
    light, dark = sample.codes[place[0]].bits[place[1]]
    return sample.names[light], None if dark is None else sample.names[dark]


def _both(pair):
    """The names of an image and its inverse, if it has one."""
    return " and ".join(name for name in pair if name)


def _listed(pairs):
    return ", ".join(name for pair in pairs for name in pair if name)


def spacing(sign, strong):
    """Mean distance between the edges of a bit, px, along the way it changes more."""
    result = np.inf
    for first, second in neighbours(1):
        both = strong[first] & strong[second]
        edges = np.count_nonzero((sign[first] != sign[second]) & both)
        # Weak pixels at an edge hide it from those beside it.
        blurred = np.count_nonzero(strong[first] & ~strong[second])
        total = np.count_nonzero(both)
        result = min(result, total / max(edges + blurred / 2, 1))
    return result


def _countable(sample, bits, widths, seen):
    """The bits of each axis, coarsest first, up to one too fine for the image.

    With a Doubt where a coarse bit follows on one that is too fine.
    """
    orders = []
    for axis in range(len(sample.codes)):
        own = [k for k, (a, _) in enumerate(bits) if a == axis]
        fine = next((k for k in own if widths[k] < MIN_SPACING_PX), None)
        stop = own.index(fine) if fine is not None else len(own)
        for k in own[stop + 1 :]:
            wide = np.isfinite(widths[k]) and widths[k] >= MIN_SPACING_PX
            if wide and seen[k] and seen[fine] and widths[k] > 2 * widths[fine]:
                first, second = (_both(_name(sample, bits[n])) for n in (fine, k))
                name = "xy"[sample.codes[axis].axis]
                return orders, Doubt(
                    "coarse-after-fine",
                    True,
                    f"{first} has finer stripes than {second}, which follows it in the "
                    f"code of axis {name}; mend their bits",
                )
        orders.append(own[:stop])
    return orders, None


def _single_changes(words, valid):
    """(before, after, count) of the words that differ in one bit, a little apart."""
    found = []
    for first, second in neighbours(APART_PX):
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
    """Cell numbers of words; slots: (place in the word, turned over) by bit."""
    code, value = np.zeros_like(words), np.zeros_like(words)
    for place, turned in slots:
        value = value ^ (words >> place & 1) ^ turned
        code = 2 * code + value
    return code


def _leaps(before, after, count, slots):
    """For each slot: (pixel pairs where its bit alone changes, of these in leaps)."""
    step = np.abs(_codes(before, slots) - _codes(after, slots))
    changed = before ^ after
    own = [(changed >> place & 1).astype(bool) for place, _ in slots]
    return np.array([[count[o].sum(), count[o & (step != 1)].sum()] for o in own])


def _leaping(before, after, count, slots):
    """Share of edges that are leaps, for each axis; 0 where bits count. Or None."""
    shares = []
    for order in slots:
        table = _leaps(before, after, count, order) if order else np.zeros((0, 2))
        bad = (table[:, 1] > LEAPS * table[:, 0]) & (table[:, 1] >= MIN_PAIRS)
        shares.append(table[:, 1].sum() / table[:, 0].sum() if bad.any() else 0.0)
    return shares if any(shares) else None


def _cause(before, after, count, slots, names):
    """What to do about the one mistake that explains the leaps, or "" where none does;
    names: (image, inverse) by place in the word."""

    def leaps(trial):
        return sum(
            _leaps(before, after, count, order)[:, 1].sum() for order in trial if order
        )

    trials = [(leaps(trial), text) for trial, text in _trials(slots, names)]
    least, text = min(trials, key=lambda one: one[0], default=(np.inf, ""))
    return text if least <= HEALED * leaps(slots) else ""


def _trials(slots, names):
    """Orders that mistakes make, each with what to do about it."""
    flat = [(a, b) for a, order in enumerate(slots) for b in range(len(order))]
    for a, b in flat:
        if b:  # turned over, the coarsest bit reverses the axis and leaps nowhere
            place, turned = slots[a][b]
            text = f"correct inverse of {_both(names[place])}"
            yield _with(slots, {(a, b): (place, not turned)}), text
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
