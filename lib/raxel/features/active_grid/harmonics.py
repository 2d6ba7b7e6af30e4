"""What steps themselves say of a response: a bound on what they cannot be corrected by.

Harmonic m of the light is a_m cos(m psi). N steps tell a_2 to a_(N-2); what shifts
phases is a_(N-1) and a_(N+1), which they do not tell from a_1. Of light to the power g,

    a_(n+1) / a_n = (g - n) / (g + n + 1),

for 1 + cos(psi) to that power: a_2 tells g. Curves like an S have odd harmonics, of
which a_2 says nothing and a_3 does. Four steps do not tell a_3, but the Gray code does:
it shows the light at psi = 0 and at pi, whose difference is 2 (a_1 + a_3 + a_5 + ...).
"""

from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.layout import BRIGHT, LIT
from raxel.features.active_grid.reading import MIN_MODULATION

SAMPLES = 50_000  # pixels, for a mean
PARTS = 3  # along each side of the picture
# a_2 / a_1 of the powers 0.03 and 4: responses have less.
MOST = 0.48, 0.5
MANY = 60  # harmonics of a power that are added up
POWERS = 16  # from 1 to that of a_2: two that follow one another look like one between
# Of the two harmonics before them, what those that are not told have at most.
LESS = 0.5
# Of a curve like an S, whose sum of odd harmonics beyond the first is t, a_3 and a_5
# together are below (1 + STEEPER |t|) |t|; a_4 and a_6 below ASIDE |a_2 a_3|; and a_9
# and a_11 below FAR a_3^4.
STEEPER, ASIDE, FAR = 5.0, 4.0, 5.0
# Share to which the blur is known by which sines are weaker than the code.
BLUR_KNOWN = 0.3
# Logarithm of by how much blur weakens sines at most: what is weaker is not decoded.
MOST_WEAKER = 3.0


def shift_bound(stack, code, noise, blur_px):
    """RMS in periods by which a response shifts phases at most; 0 where nothing is lit.

    stack: a PictureStack; code: an AxisCode with four steps or more; noise: a Noise;
    blur_px: standard deviation, 0 where it is not known.
    """
    parts = _seen(stack, code.steps, noise)
    if not parts:
        return 0.0
    bounds = [_bound(stack, code, part, blur_px) for part in parts]
    pixels = [len(part.size) for part in parts]
    mean_square = np.average(np.square(bounds), weights=pixels)
    return np.sqrt(mean_square / 2) / (2 * np.pi)


def _bound(stack, code, sines, blur_px):
    count = len(code.steps)
    odd, unsure = 0.0, 0.0
    if count == 4 and code.bits:
        odd, unsure = _odd_beyond_first(stack, code, sines, blur_px)
    return bound_of_shares(_shares(sines, count), count, odd) + unsure


def bound_of_shares(shares, count, odd=0.0):
    """How large a_(N-1) and a_(N+1) together are at most, in shares of a_1.

    shares: (N - 1,) of harmonics 0 to N - 2; count: N, 4 or more; odd: for four steps,
    a_3 + a_5 + ...
    """
    second = np.clip(shares[2], -MOST[0], MOST[1])
    power = (1 + 2 * second) / (1 - second)
    powers = np.linspace(1, power, POWERS)
    between = np.abs(harmonics_of_powers(powers, count + 1)).max(axis=0)
    bound = between[count - 1] + between[count + 1]
    if count == 4:
        off = abs(odd - harmonics_of_powers([power], MANY)[0, 3::2].sum())
        return bound + (1 + STEEPER * off) * off
    if count == 5:
        third = shares[3] - harmonics_of_powers([power], 3)[0, 3]
        return bound + ASIDE * abs(second * third) + FAR * third**4
    before = np.abs(shares[-2:])
    excess = np.maximum(before - between[count - 3 : count - 1], 0)
    return min(bound + LESS * excess.max(), LESS * before.max())


def harmonics_of_powers(powers, last):
    """(P, last + 1) harmonics of powers (P,), in shares of a_1; the mean as 0."""
    powers, n = np.asarray(powers, float)[:, None], np.arange(1, last)
    shares = np.zeros((len(powers), last + 1))
    shares[:, 1] = 1
    shares[:, 2:] = np.cumprod((powers - n) / (powers + n + 1), axis=1)
    return shares


class _Sines(NamedTuple):
    """P lit pixels of N steps: light (N, P); size (P,), modulation; back (P,), its
    phase turned back; turn (P,), rad per px of the picture; at: rows and columns of the
    pictures (P,)."""

    light: np.ndarray
    size: np.ndarray
    back: np.ndarray
    turn: np.ndarray
    at: tuple[np.ndarray, np.ndarray]


def _seen(stack, steps, noise):
    """[_Sines, ...] of some pixels of each part of the picture where any are lit.

    Where light falls off, a curve is seen at its bright and at its dark end.
    """
    count = len(steps)
    apart = max(1, int(np.sqrt(np.prod(stack.shape) / SAMPLES)))
    height, width = stack.shape
    turn = 2 / count * np.exp(-2j * np.pi * np.arange(count) / count)
    places = [
        np.s_[down : height - 1 + down : apart, right : width - 1 + right : apart]
        for down, right in ((0, 0), (1, 0), (0, 1))
    ]
    every = [
        np.array([stack.images[k][place] for k in steps], np.float32)
        for place in places
    ]
    first, below, beside = (np.tensordot(turn, light, 1) for light in every)
    middle = every[0]
    least = MIN_MODULATION**2 * 2 / count * noise.at(middle.mean(axis=0))
    size = np.maximum(np.abs(first), 1e-6)
    lit = size**2 > least
    if lit.any():
        lit &= size > LIT * np.percentile(size[lit], BRIGHT)
    back = first.conj() / size
    turned = np.hypot(*(np.angle(other * back) for other in (below, beside)))
    rows, columns = np.nonzero(lit)
    part = PARTS * (PARTS * rows // lit.shape[0]) + PARTS * columns // lit.shape[1]
    found = []
    for k in np.unique(part):
        at = rows[part == k], columns[part == k]
        own = middle[:, *at], size[at], back[at], turned[at]
        found.append(_Sines(*own, tuple(apart * place for place in at)))
    return found


def _shares(sines, count):
    """(N - 1,) harmonics 0 (as 0) to N - 2 in shares of a_1."""
    turn = np.exp(-2j * np.pi * np.arange(count) / count)
    shares = np.zeros(count - 1)
    shares[1] = 1
    for m in range(2, count - 1):
        waves = 2 / count * np.tensordot(turn**m, sines.light, 1)
        # Harmonic N - m is in it as well, and turns the other way.
        shares[m] = np.mean(waves * sines.back**m).real / sines.size.mean()
    return shares


def _odd_beyond_first(stack, code, sines, blur_px):
    """(a_3 + a_5 + ..., by how much it is not known), in shares of a_1.

    Blur takes more of sines than of the coarsest bit.
    """
    half = np.abs(stack.apart(code.bits[0], sines.at)) / 2
    weaker = np.minimum((blur_px * sines.turn) ** 2 / 2, MOST_WEAKER)
    kept = half * np.exp(-weaker)
    odd = np.sum(kept) / np.sum(sines.size) - 1
    return odd, BLUR_KNOWN * np.sum(weaker * kept) / max(np.sum(kept), 1e-6)
