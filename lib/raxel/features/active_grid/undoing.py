"""The ripple of a view, and phases from which it is taken: of pixels and of means.

`response` finds its numbers, `ripple` has the arithmetic of a row of pixels.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import COSINE, PITCH, SINE, STRIP, WORK, Ripples
from raxel.features.active_grid.lines import basis_of
from raxel.features.active_grid.ripple import (
    IMAGINARY,
    RATE,
    REAL,
    SHARE,
    origin,
    undo_ripple,
)

UNEVEN = 0.1  # of the usual rate of phases


class Ripple(NamedTuple):
    """The ripple of one axis of a view, as `ripple` has it.

    steps: N, 0 where nothing is corrected; offset: of the sines' first step, in
    periods; times: Newton's steps; share: (6,) real part of r1, as a polynomial 1, x,
    y, x^2, x y, y^2 of the place in the picture, which goes from -1 to 1; terms: (3,)
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
    """The layout.Ripples of A axes; shape: (H, W) of the pictures."""
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

    x, y: from -1 to 1 over the picture, of the same shape. What N steps add up to is
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
