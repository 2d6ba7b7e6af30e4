"""Pieces of rows and columns of images, and the phases that neighbours there share.

What a response does to phases is looked for on them (`response`).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from raxel.features.active_grid.coding import COSINE, PITCH, SINE, STRIP, WORK, Ripples
from raxel.features.active_grid.reading import (
    IMAGINARY,
    MIN_MODULATION,
    RATE,
    REAL,
    SHARE,
    origin,
    undo_ripple,
)

# Rows and columns looked at are so many px wide, and so many altogether; of small
# images at most so many each way.
ACROSS, PIXELS, MOST_LINES = 7, 150_000, 16
RECORDS, OF_RIPPLE = 32, 8  # means in a piece of line, and in each ripple
ALONG = 7  # px of a mean along the line, at most
RIPPLES = 2.0, 8.0  # in a piece: fewer are like bending, of more means hold too much
MOST_ASLANT = 0.6  # ripples across a line: of more, a mean is blind to them
# Finer ones are seen pixel by pixel, on lines so wide; those of two pixels or three as
# well, since their shape is known. Of hardly more than one pixel they look smooth.
FINE_PX, FINEST_PX, FINE_ACROSS = 5.0, 2.0, 3


class Pieces(NamedTuple):
    """S pieces of lines, RECORDS means each, of K pixels.

    waves: (S, RECORDS, K) complex64, of unit length; basis: (S, RECORDS, 6), `basis_of`
    their places; phase: (S, RECORDS), of the means, unwrapped; back: its exp(-i phase).
    """

    waves: np.ndarray
    basis: np.ndarray
    phase: np.ndarray
    back: np.ndarray


class _Stripes(NamedTuple):
    """L lines of n px: waves (L, ACROSS, n) complex64 of unit length; good (L, n) bool,
    none of those across is dark or clipped; middle: (L,) px, where they lie."""

    waves: np.ndarray
    good: np.ndarray
    middle: np.ndarray


def basis_of(x, y):
    """(..., 6): 1, x, y, x^2, x y, y^2 of places from -1 to 1 over the image."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def pieces_of(stack, sines, noise, limit):
    """[Pieces, ...] of some rows and some columns that go through enough ripples.

    stack: a PictureStack; sines: `coding.Sines` of an axis; noise: a Noise; limit: the
    value from which a sine counts as clipped.
    """
    found = []
    if min(stack.shape) < 2 * ACROSS:
        return found
    for along in (1, 0):
        lines = _lines(stack, sines, noise, limit, along)
        ripple, most = _usual_ripple(lines, len(sines.steps)), RIPPLES[1]
        if not ripple or ripple < FINEST_PX:
            continue
        if ripple < FINE_PX:
            lines, most = _split(lines), RECORDS / FINEST_PX
        pitch = int(np.clip(ripple // OF_RIPPLE, 1, stack.shape[along] // RECORDS))
        cut = lines, pitch, len(sines.steps), most
        found.append(_cut(*cut, stack.shape, along))
    return found


def _split(lines):
    """Each of the lines as two that are FINE_ACROSS wide, at its sides."""
    sides = slice(FINE_ACROSS), slice(-FINE_ACROSS, None)
    aside = (ACROSS - FINE_ACROSS) // 2
    return _Stripes(
        np.concatenate([lines.waves[:, side] for side in sides]),
        np.concatenate([lines.good, lines.good]),
        np.concatenate([lines.middle - aside, lines.middle + aside]),
    )


def _lines(stack, sines, noise, limit, along):
    """The _Stripes along rows (along = 1) or columns of the images."""
    across_px = stack.shape[1 - along]
    most = min(MOST_LINES, PIXELS // (ACROSS * sum(stack.shape)))
    count = max(1, min(most, across_px // (2 * ACROSS)))
    first = np.linspace(0, across_px - ACROSS, count + 2)[1:-1].astype(int)
    taken = (first[:, None] + np.arange(ACROSS)).ravel()
    light = np.empty((len(taken), len(sines.steps), stack.shape[along]), np.float32)
    for j, k in enumerate(sines.steps):
        light[:, j] = stack.images[k][taken] if along else stack.images[k][:, taken].T
    # Line by line: so small a product is not shared out to threads, which takes longer.
    sine, cosine, mean = (sines.weights.astype(np.float32) @ light).swapaxes(0, 1)
    size = np.hypot(sine, cosine)
    good = size**2 > MIN_MODULATION**2 * 2 / len(sines.steps) * noise.at(mean)
    good &= light.max(axis=1) < limit
    part = np.float32(1) / np.maximum(size, np.float32(1e-6))
    waves = np.empty(size.shape, np.complex64)
    np.multiply(cosine, part, out=waves.real)
    np.multiply(sine, part, out=waves.imag)
    waves = waves.reshape(count, ACROSS, -1)
    return _Stripes(waves, good.reshape(waves.shape).all(axis=1), first + ACROSS // 2)


def _usual_ripple(lines, count):
    """px of a usual ripple of `count` steps; None where lines are too short or dark."""
    most = lines.good.shape[1] // RECORDS
    whole = slice(lines.good.shape[1] // 2 * 2)
    pairs = lines.waves[..., whole].sum(axis=1)
    pairs = pairs[:, ::2] + pairs[:, 1::2]
    lit = lines.good[:, whole][:, ::2]
    both = lit[:, 1:] & lit[:, :-1]
    if not most or np.count_nonzero(both) < RECORDS:
        return None
    turn = np.angle((pairs[:, 1:] * pairs[:, :-1].conj())[both])
    of_pixel = max(np.median(np.abs(turn)) / 2, 1e-6)
    return 2 * np.pi / (count * of_pixel)


def _cut(lines, pitch, count, most, shape, along):
    """The Pieces of lines, those of one line not where those of the next begin.

    pitch: px between means, OF_RIPPLE of them in a usual ripple of `count` steps; most:
    ripples in a piece.
    """
    n, used = lines.good.shape[1], min(pitch, ALONG)
    many = n // (pitch * RECORDS)
    spare = n - many * pitch * RECORDS
    line = np.arange(len(lines.good))
    begin = spare * line // max(len(line) - 1, 1)
    first = begin[:, None] + pitch * np.arange(many * RECORDS)
    first, line = first.reshape(-1, RECORDS), np.repeat(line, many)
    pixels = first[..., None] + np.arange(used)
    kept = lines.good[line[:, None, None], pixels].all(axis=(1, 2))
    first, line, pixels = first[kept], line[kept], pixels[kept]
    wide = lines.waves.shape[1]
    across = np.arange(wide)[:, None]
    waves = lines.waves[line[:, None, None, None], across, pixels[:, :, None]]
    whole = waves.reshape(len(line), RECORDS, wide * used)
    phase = np.unwrap(np.angle(whole.sum(axis=2)), axis=1)
    ripples = np.abs(phase[:, -1] - phase[:, 0]) * count / (2 * np.pi)
    kept = np.flatnonzero((ripples > RIPPLES[0]) & (ripples < most))
    # From pixel to pixel, since fine stripes turn more than once across a line.
    aside = np.sum(waves[kept, :, 1:] * waves[kept, :, :-1].conj(), axis=(2, 3))
    aslant = (wide - 1) * np.median(np.abs(np.angle(aside)), axis=1)
    kept = kept[aslant * count / (2 * np.pi) < MOST_ASLANT]
    place = 2 * (first[kept] + (used - 1) / 2) / (n - 1) - 1
    aside = 2 * lines.middle[line[kept], None] / (shape[1 - along] - 1) - 1
    places = np.broadcast_arrays(place, aside)
    basis = basis_of(*(places if along else places[::-1]))
    phase = phase[kept]
    return Pieces(whole[kept], basis, phase, np.exp(-1j * phase))


# The ripple of a view, and phases from which it is taken: of pixels and of means.
# `response` finds its numbers, `ripple` has the arithmetic of a row of pixels.


UNEVEN = 0.1  # of the usual rate of phases


class Ripple(NamedTuple):
    """The ripple of one axis of a view, as `ripple` has it.

    steps: N, 0 where nothing is corrected; offset: of the sines' first step, in
    periods; times: Newton's steps; share: (6,) real part of r1, as a polynomial 1, x,
    y, x^2, x y, y^2 of the place in the image, which goes from -1 to 1; terms: (3,)
    imaginary part of r1, r2, r3; all float32.
    """

    steps: int
    offset: float
    times: int
    share: np.ndarray
    terms: np.ndarray

    @property
    def uneven(self):
        """Whether phases run so unevenly that noise does within a window."""
        return bool(self.steps * abs(self.share[0]) > UNEVEN)

    def shares(self, x, y):
        """Real part of r1 at places from -1 to 1."""
        return basis_of(x, y) @ self.share


def no_ripple():
    """The Ripple that leaves phases as they are."""
    return Ripple(0, 0.0, 0, np.zeros(6, np.float32), np.zeros(3, np.float32))


def ripples_of(ripples, shape):
    """The layout.Ripples of A axes; shape: (H, W) of the images."""
    down, across = (np.float32(2 / max(size - 1, 1)) for size in shape)
    return Ripples(
        np.array([ripple.steps for ripple in ripples], np.int64),
        np.array([origin(ripple.offset) for ripple in ripples], np.float32),
        np.array([ripple.times for ripple in ripples], np.int64),
        np.array([ripple.share for ripple in ripples], np.float32),
        np.array([ripple.terms for ripple in ripples], np.float32),
        across,
        down,
    )


def corrected(pieces, ripple):
    """(S, RECORDS) phases of means that are corrected, unwrapped, and (S, RECORDS, 9)
    by how much of each number they become less."""
    share = (pieces.basis @ ripple.share).astype(np.float32)
    settings = _settings(ripple)
    sums, slopes = _means(pieces.waves, share, *settings)
    phase = pieces.phase + np.angle(sums * pieces.back)
    of_share = slopes[..., :1] * pieces.basis
    return phase, np.concatenate([of_share, slopes[..., 1:]], axis=-1)


def undone(ripple, wave, x, y):
    """Complex waves B exp(i phi) of any shape, seen at x, y, as they were shown.

    x, y: from -1 to 1 over the image, of the same shape. What N steps add up to is
    exp(i psi) f: the modulation is divided by the length of f as well.
    """
    if not ripple.steps:
        return wave
    share = ripple.shares(x, y).astype(np.float32).ravel()
    settings = _settings(ripple)
    flat = np.ascontiguousarray(wave, np.complex128).ravel()
    return _undone(flat, share, *settings).reshape(np.shape(wave))


def _settings(ripple):
    """As `undo_ripple` takes them."""
    return ripple.steps, origin(ripple.offset), ripple.times, tuple(ripple.terms)


@njit(cache=True, nogil=True, error_model="numpy")
def _undone(wave, share, steps, start, times, terms):
    row, work = np.zeros(3 * PITCH, np.float32), np.zeros(WORK, np.float32)
    out = np.empty_like(wave)
    skew, second, third = terms
    for first in range(0, len(wave), STRIP):
        n = min(STRIP, len(wave) - first)
        for x in range(n):
            size = abs(wave[first + x]) + 1e-20
            row[SINE + x] = wave[first + x].imag / size
            row[COSINE + x] = wave[first + x].real / size
            work[SHARE + x] = share[first + x]
        undo_ripple(n, steps, start, times, terms, row, work)
        for x in range(n):
            one = complex(work[REAL + x], -work[IMAGINARY + x])
            f = 1 + (work[SHARE + x] + 1j * skew) * one
            f += second * one**2 + third * one**3
            unit = complex(row[COSINE + x], row[SINE + x])
            out[first + x] = abs(wave[first + x]) / max(abs(f), 0.1) * unit
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _means(waves, share, steps, start, times, terms):
    """(S, RECORDS) sums of corrected waves, (S, RECORDS, 4) means of slopes."""
    pieces, records, size = waves.shape[:3]
    row, work = np.zeros(3 * PITCH, np.float32), np.zeros(WORK, np.float32)
    sums = np.zeros((pieces, records), np.complex128)
    slopes = np.zeros((pieces, records, 4))
    skew, second, third = terms
    n = records * size
    for piece in range(pieces):
        for k in range(records):
            for x in range(size):
                row[SINE + k * size + x] = waves[piece, k, x].imag
                row[COSINE + k * size + x] = waves[piece, k, x].real
                work[SHARE + k * size + x] = share[piece, k]
        undo_ripple(n, steps, start, times, terms, row, work)
        for k in range(records):
            own = share[piece, k]
            for x in range(k * size, (k + 1) * size):
                sums[piece, k] += complex(row[COSINE + x], row[SINE + x])
                c, s = work[REAL + x], -work[IMAGINARY + x]
                c2, s2 = c * c - s * s, 2 * c * s
                c3, s3 = c * c2 - s * s2, c * s2 + s * c2
                real = 1 + own * c - skew * s + second * c2 + third * c3
                imaginary = own * s + skew * c + second * s2 + third * s3
                rate = work[RATE + x] / (size * (real * real + imaginary * imaginary))
                # The imaginary parts of P* / f, i P* / f, P*^2 / f and P*^3 / f.
                slopes[piece, k, 0] += rate * (s * real - c * imaginary)
                slopes[piece, k, 1] += rate * (c * real + s * imaginary)
                slopes[piece, k, 2] += rate * (s2 * real - c2 * imaginary)
                slopes[piece, k, 3] += rate * (s3 * real - c3 * imaginary)
    return sums, slopes
