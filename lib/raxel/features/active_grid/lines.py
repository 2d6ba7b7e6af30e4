"""Segments of image rows and columns that show the ripple of the response.

`response` estimates the ripple from them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from raxel.features.active_grid.coding import (
    COSINE,
    FIELD_PITCH,
    MAX_STRIP_COLUMNS,
    SINE,
    WORK,
    Ripples,
)
from raxel.features.active_grid.reading import (
    IMAGINARY,
    MIN_MODULATION,
    RATE,
    REAL,
    SHARE,
    origin,
    undo_ripple,
)

# Width of the sampled rows and columns in px, their total pixels, and, for small
# images, their maximal number along each axis.
LINE_WIDTH_PX, MAX_LINE_PIXELS, MAX_LINES = 7, 150_000, 16
# Means in a piece of line, and in each ripple.
MEANS_PER_PIECE, MEANS_PER_RIPPLE = (32, 8)
MAX_MEAN_PX = 7  # length of a mean along the line
# Fewer look like a bend of the surface; more have too few means each.
RIPPLES_PER_PIECE = (2.0, 8.0)
MAX_RIPPLES_ACROSS = 0.6  # across a line: a mean averages more of them out
# Finer ripples are sampled pixel by pixel, on lines so wide, down to two or three
# pixels, since their shape is known. Ripples of about one pixel look smooth.
MIN_RIPPLE_PX, MIN_FINE_RIPPLE_PX, FINE_LINE_WIDTH_PX = 5.0, 2.0, 3


class Pieces(NamedTuple):
    """Hold S pieces of lines with R = MEANS_PER_PIECE means each, of K pixels.

    waves: (S, R, K) complex64, of unit length; basis: (S, R, 6), `basis_of` their
    positions; phase: (S, R), of the means, unwrapped; back: its exp(-i phase).
    """

    waves: np.ndarray
    basis: np.ndarray
    phase: np.ndarray
    back: np.ndarray


class _Stripes(NamedTuple):
    """Hold L lines of n px.

    waves: (L, LINE_WIDTH_PX, n) complex64 of unit length; good: (L, n) bool, no pixel
    across the line is dark or clipped; middle: (L,) px, position of the line.
    """

    waves: np.ndarray
    good: np.ndarray
    middle: np.ndarray


def basis_of(x, y):
    """Return (..., 6): 1, x, y, x^2, x y, y^2 of image positions from -1 to 1."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def pieces_of(stack, sines, noise, limit):
    """Return Pieces of some rows and some columns that contain enough ripples.

    stack: an ImageStack; sines: `coding.Sines` of an axis; noise: a Noise; limit: the
    grey level from which a sinusoid counts as clipped.
    """
    found = []
    if min(stack.shape) < 2 * LINE_WIDTH_PX:
        return found
    for along in (1, 0):
        lines = _lines(stack, sines, noise, limit, along)
        ripple, max_ripples = (
            _usual_ripple(lines, len(sines.steps)),
            RIPPLES_PER_PIECE[1],
        )
        if not ripple or ripple < MIN_FINE_RIPPLE_PX:
            continue
        if ripple < MIN_RIPPLE_PX:
            lines, max_ripples = _split(lines), MEANS_PER_PIECE / MIN_FINE_RIPPLE_PX
        pitch = int(
            np.clip(
                ripple // MEANS_PER_RIPPLE, 1, stack.shape[along] // MEANS_PER_PIECE
            )
        )
        arguments = lines, pitch, len(sines.steps), max_ripples
        found.append(_pieces(*arguments, stack.shape, along))
    return found


def _split(lines):
    """Split each line into two, FINE_LINE_WIDTH_PX wide, at its sides."""
    sides = slice(FINE_LINE_WIDTH_PX), slice(-FINE_LINE_WIDTH_PX, None)
    lateral = (LINE_WIDTH_PX - FINE_LINE_WIDTH_PX) // 2
    return _Stripes(
        np.concatenate([lines.waves[:, side] for side in sides]),
        np.concatenate([lines.good, lines.good]),
        np.concatenate([lines.middle - lateral, lines.middle + lateral]),
    )


def _lines(stack, sines, noise, limit, along):
    """Return the _Stripes along rows (along = 1) or columns of the images."""
    across_px = stack.shape[1 - along]
    max_ripples = min(MAX_LINES, MAX_LINE_PIXELS // (LINE_WIDTH_PX * sum(stack.shape)))
    count = max(1, min(max_ripples, across_px // (2 * LINE_WIDTH_PX)))
    first = np.linspace(0, across_px - LINE_WIDTH_PX, count + 2)[1:-1].astype(int)
    taken = (first[:, None] + np.arange(LINE_WIDTH_PX)).ravel()
    light = np.empty((len(taken), len(sines.steps), stack.shape[along]), np.float32)
    for j, k in enumerate(sines.steps):
        light[:, j] = stack.images[k][taken] if along else stack.images[k][:, taken].T
    # Line by line: BLAS would spend more time on threads for so small a product.
    sine, cosine, mean = (sines.weights.astype(np.float32) @ light).swapaxes(0, 1)
    size = np.hypot(sine, cosine)
    good = size**2 > MIN_MODULATION**2 * 2 / len(sines.steps) * noise.at(mean)
    good &= light.max(axis=1) < limit
    part = np.float32(1) / np.maximum(size, np.float32(1e-6))
    waves = np.empty(size.shape, np.complex64)
    np.multiply(cosine, part, out=waves.real)
    np.multiply(sine, part, out=waves.imag)
    waves = waves.reshape(count, LINE_WIDTH_PX, -1)
    return _Stripes(
        waves, good.reshape(waves.shape).all(axis=1), first + LINE_WIDTH_PX // 2
    )


def _usual_ripple(lines, count):
    """Return the usual ripple of `count` steps in px; None for short or dark lines."""
    max_ripples = lines.good.shape[1] // MEANS_PER_PIECE
    whole = slice(lines.good.shape[1] // 2 * 2)
    pairs = lines.waves[..., whole].sum(axis=1)
    pairs = pairs[:, ::2] + pairs[:, 1::2]
    lit = lines.good[:, whole][:, ::2]
    both = lit[:, 1:] & lit[:, :-1]
    if not max_ripples or np.count_nonzero(both) < MEANS_PER_PIECE:
        return None
    turn = np.angle((pairs[:, 1:] * pairs[:, :-1].conj())[both])
    of_pixel = max(np.median(np.abs(turn)) / 2, 1e-6)
    return 2 * np.pi / (count * of_pixel)


def _pieces(lines, pitch, count, max_ripples, shape, along):
    """Return the Pieces of lines; the pieces of different lines are staggered.

    pitch: px between means, MEANS_PER_RIPPLE of them in a usual ripple of `count`
    steps; max_ripples: in a piece.
    """
    n, used = lines.good.shape[1], min(pitch, MAX_MEAN_PX)
    many = n // (pitch * MEANS_PER_PIECE)
    spare = n - many * pitch * MEANS_PER_PIECE
    line = np.arange(len(lines.good))
    begin = spare * line // max(len(line) - 1, 1)
    first = begin[:, None] + pitch * np.arange(many * MEANS_PER_PIECE)
    first, line = first.reshape(-1, MEANS_PER_PIECE), np.repeat(line, many)
    pixels = first[..., None] + np.arange(used)
    kept = lines.good[line[:, None, None], pixels].all(axis=(1, 2))
    first, line, pixels = first[kept], line[kept], pixels[kept]
    wide = lines.waves.shape[1]
    across = np.arange(wide)[:, None]
    waves = lines.waves[line[:, None, None, None], across, pixels[:, :, None]]
    whole = waves.reshape(len(line), MEANS_PER_PIECE, wide * used)
    phase = np.unwrap(np.angle(whole.sum(axis=2)), axis=1)
    ripples = np.abs(phase[:, -1] - phase[:, 0]) * count / (2 * np.pi)
    kept = np.flatnonzero((ripples > RIPPLES_PER_PIECE[0]) & (ripples < max_ripples))
    # From pixel to pixel, since the phase of fine stripes wraps across a line.
    lateral = np.sum(waves[kept, :, 1:] * waves[kept, :, :-1].conj(), axis=(2, 3))
    across = (wide - 1) * np.median(np.abs(np.angle(lateral)), axis=1)
    kept = kept[across * count / (2 * np.pi) < MAX_RIPPLES_ACROSS]
    position = 2 * (first[kept] + (used - 1) / 2) / (n - 1) - 1
    lateral = 2 * lines.middle[line[kept], None] / (shape[1 - along] - 1) - 1
    positions = np.broadcast_arrays(position, lateral)
    basis = basis_of(*(positions if along else positions[::-1]))
    phase = phase[kept]
    return Pieces(whole[kept], basis, phase, np.exp(-1j * phase))


# Ripple of a view, and its correction of the phases of pixels and of means.
# `response` estimates its coefficients; `reading` corrects rows of pixels.


MAX_EVEN_RATE = 0.1  # relative change of the rate of phases


class Ripple(NamedTuple):
    """Hold the ripple of one axis of a view, as in `reading`.

    steps: N, 0 without a correction; offset: of the first step, in periods; times:
    Newton's steps; share: (6,) real part of r1, as a polynomial 1, x, y, x^2, x y, y^2
    of the image position from -1 to 1; terms: (3,) imaginary part of r1, r2, r3; all
    float32.
    """

    steps: int
    offset: float
    times: int
    share: np.ndarray
    terms: np.ndarray

    @property
    def uneven(self):
        """Whether the variance of phases changes within a window."""
        return bool(self.steps * abs(self.share[0]) > MAX_EVEN_RATE)

    def shares(self, x, y):
        """Return the real part of r1 at positions from -1 to 1."""
        return basis_of(x, y) @ self.share


def no_ripple():
    """Return the Ripple that leaves phases unchanged."""
    return Ripple(0, 0.0, 0, np.zeros(6, np.float32), np.zeros(3, np.float32))


def ripples_of(ripples, shape):
    """Return the coding.Ripples of A axes; shape: (H, W) of the images."""
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


def corrected_phases(pieces, ripple):
    """Return corrected phases of means and their derivatives.

    (S, MEANS_PER_PIECE), unwrapped, and (S, MEANS_PER_PIECE, 9), minus the derivatives
    with respect to the coefficients.
    """
    share = (pieces.basis @ ripple.share).astype(np.float32)
    settings = _settings(ripple)
    sums, slopes = _means(pieces.waves, share, *settings)
    phase = pieces.phase + np.angle(sums * pieces.back)
    of_share = slopes[..., :1] * pieces.basis
    return phase, np.concatenate([of_share, slopes[..., 1:]], axis=-1)


def corrected_waves(ripple, wave, x, y):
    """Return complex waves B exp(i phi) of any shape, at x, y, as they were displayed.

    x, y: from -1 to 1 over the image, of the same shape. The sum of N steps is
    exp(i psi) f. The modulation is divided by |f| as well.
    """
    if not ripple.steps:
        return wave
    share = ripple.shares(x, y).astype(np.float32).ravel()
    settings = _settings(ripple)
    flat = np.ascontiguousarray(wave, np.complex128).ravel()
    return _corrected_waves(flat, share, *settings).reshape(np.shape(wave))


def _settings(ripple):
    """Return the arguments of `undo_ripple`."""
    return ripple.steps, origin(ripple.offset), ripple.times, tuple(ripple.terms)


@njit(cache=True, nogil=True, error_model="numpy")
def _corrected_waves(wave, share, steps, start, times, terms):
    row, work = np.zeros(3 * FIELD_PITCH, np.float32), np.zeros(WORK, np.float32)
    out = np.empty_like(wave)
    skew, second, third = terms
    for first in range(0, len(wave), MAX_STRIP_COLUMNS):
        n = min(MAX_STRIP_COLUMNS, len(wave) - first)
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
    """Return sums of corrected waves (S, R), means of their derivatives (S, R, 4)."""
    pieces, records, size = waves.shape[:3]
    row, work = np.zeros(3 * FIELD_PITCH, np.float32), np.zeros(WORK, np.float32)
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
                # Imaginary parts of P* / f, i P* / f, P*^2 / f and P*^3 / f.
                slopes[piece, k, 0] += rate * (s * real - c * imaginary)
                slopes[piece, k, 1] += rate * (c * real + s * imaginary)
                slopes[piece, k, 2] += rate * (s2 * real - c2 * imaginary)
                slopes[piece, k, 3] += rate * (s3 * real - c3 * imaginary)
    return sums, slopes
