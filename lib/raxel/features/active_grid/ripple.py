"""The phase that was shown, from the phase that is seen behind a response that bends.

Harmonics m N +- 1 of what a monitor and a camera make of a sine look to N steps like
the first one (Appendix A). Where the sine is shown as a cosine of psi, light is even in
psi, whatever its response and however blurred, so that the steps add up to
exp(i psi) f, f = 1 + r1 P* + r2 P*^2 + r3 P*^3 with P = exp(i N psi) and real r: the
phase that is seen is psi + e, e = arg f. r1 is the share of harmonic N - 1 less that
of N + 1; to first order these two do the same and cannot be told apart. An imaginary
part of r1 is what a blur makes that is not symmetric.

psi follows by Newton's method, on P alone. Written as `reading`, and compiled into it.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import (
    COSINE,
    OFF,
    PERIOD,
    PLACE,
    SINE,
    SPREAD,
    TURN,
    VARIANCE,
)

# Fields of Rows.work that nothing is kept in while rows are read: r1 of each pixel, P,
# the shift e so far, and how fast psi runs when the phase that is seen does.
SHARE, REAL, IMAGINARY, SHIFT, RATE = TURN, SPREAD, PERIOD, OFF, PLACE
# A response that grows with the light leaves psi + e growing: by gamma 2.4 no slower
# than 0.27 (three steps). Noise can make it seem slower.
SLOWEST = np.float32(0.2)
FARTHEST = np.float32(1)  # rad, that P turns in one of Newton's steps
FAST = {"contract", "arcp"}  # products added with one rounding; times 1 / x for / x
_ONE, _TWO, _THREE = np.float32(1), np.float32(2), np.float32(3)
# arctan(q) / q as a polynomial in q^2, right to 6e-7 for |q| < 0.7.
# Beyond, f is that of no response: there the nearest is taken.
_STEEPEST, _LEAST = np.float32(0.7), np.float32(0.1)
_ARCTAN = (0.99999092, -0.33293666, 0.19506967, -0.11675641, 0.04361909)
_ARCTAN = tuple(map(np.float32, _ARCTAN))
# cos a and sin a / a as polynomials in a^2, right to 3e-7 for |a| < 1.
_COSINE = tuple(map(np.float32, (1, -1 / 2, 1 / 24, -1 / 720, 1 / 40320)))
_SINE = tuple(map(np.float32, (1, -1 / 6, 1 / 120, -1 / 5040)))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _rotation(angle):
    """(cos, sin) of a small angle."""
    z = angle * angle
    cosine = (((_COSINE[4] * z + _COSINE[3]) * z + _COSINE[2]) * z + _COSINE[1]) * z
    sine = ((_SINE[3] * z + _SINE[2]) * z + _SINE[1]) * z
    return _ONE + cosine, angle * (_ONE + sine)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _arctan(q):
    z = q * q
    e = ((_ARCTAN[4] * z + _ARCTAN[3]) * z + _ARCTAN[2]) * z + _ARCTAN[1]
    return q * (e * z + _ARCTAN[0])


def origin(offset):
    """(2,) float32, exp(i psi) where phi is 0: sines are cosines of phi + 2 pi offset -
    pi / 2; offset: of their first step, in periods."""
    turn = 2 * np.pi * offset
    return np.float32(np.sin(turn)), np.float32(-np.cos(turn))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _to_power(n, steps, start, waves, work):
    """REAL, IMAGINARY: P of the phase that is seen."""
    p, q = start
    for x in range(n):
        c, d = waves[COSINE + x], waves[SINE + x]
        work[REAL + x] = p * c - q * d
        work[IMAGINARY + x] = p * d + q * c
    bit = 1
    while 2 * bit <= steps:
        bit *= 2
    bit //= 2
    while bit:
        for x in range(n):
            a, b = work[REAL + x], work[IMAGINARY + x]
            work[REAL + x] = a * a - b * b
            work[IMAGINARY + x] = _TWO * a * b
        if steps & bit:
            for x in range(n):
                a, b = work[REAL + x], work[IMAGINARY + x]
                c, d = waves[COSINE + x], waves[SINE + x]
                c, d = p * c - q * d, p * d + q * c
                work[REAL + x] = a * c - b * d
                work[IMAGINARY + x] = a * d + b * c
        bit //= 2


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _improve(n, steps, terms, work):
    """One step of Newton's method for SHIFT = e(psi), psi = phi - SHIFT; RATE there."""
    skew, second, third = terms
    many = np.float32(steps)
    for x in range(n):
        share = work[SHARE + x]
        c, s = work[REAL + x], work[IMAGINARY + x]
        c2, s2 = c * c - s * s, _TWO * c * s
        c3, s3 = c * c2 - s * s2, c * s2 + s * c2
        # (share + i skew) P* and the rest; and each times its order.
        a1, b1 = share * c + skew * s, skew * c - share * s
        a2, b2 = second * c2, -second * s2
        a3, b3 = third * c3, -third * s3
        real = max(_ONE + a1 + a2 + a3, _LEAST)
        imaginary = b1 + b2 + b3
        up, across = a1 + _TWO * a2 + _THREE * a3, b1 + _TWO * b2 + _THREE * b3
        size = real * real + imaginary * imaginary
        slope = _ONE - many * (up * real + across * imaginary) / size
        rate = _ONE / max(slope, SLOWEST)
        tangent = min(max(imaginary / real, -_STEEPEST), _STEEPEST)
        step = (_arctan(tangent) - work[SHIFT + x]) * rate
        step = min(max(step, -FARTHEST / many), FARTHEST / many)
        work[SHIFT + x] += step
        work[RATE + x] = rate
        turned, aside = _rotation(many * step)
        work[REAL + x] = c * turned + s * aside
        work[IMAGINARY + x] = s * turned - c * aside


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _turn_back(n, waves, work):
    for x in range(n):
        turned, aside = _rotation(work[SHIFT + x])
        sine, cosine = waves[SINE + x], waves[COSINE + x]
        waves[SINE + x] = sine * turned - cosine * aside
        waves[COSINE + x] = cosine * turned + sine * aside
        waves[VARIANCE + x] *= work[RATE + x] * work[RATE + x]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def undo_ripple(n, steps, start, times, terms, waves, work):
    """Turn n unit vectors (cosine, sine) of phases back to those that were shown.

    steps: N; start: `origin`; times: Newton's steps; terms: (imaginary part of r1, r2,
    r3) float32; waves, work: of a row, as `layout.Rows`, with the real part of r1 in
    SHARE. The variance of a phase grows or falls with RATE, squared.
    """
    _to_power(n, steps, start, waves, work)
    work[SHIFT : SHIFT + n] = 0
    for _ in range(times):
        _improve(n, steps, terms, work)
    _turn_back(n, waves, work)
