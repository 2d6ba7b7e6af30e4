"""What steps themselves say of a response: a bound on what they cannot be corrected by.

Harmonic m of the light is a_m cos(m psi). N steps tell a_2 to a_(N-2); what shifts
phases is a_(N-1) and a_(N+1), which they do not tell from a_1. Of light to the power g,

    a_(n+1) / a_n = (g - n) / (g + n + 1),

for 1 + cos(psi) to that power: a_2 tells g. Curves like an S have odd harmonics, of
which a_2 says nothing and a_3 does: four steps, which do not tell a_3, miss them.
"""

import numpy as np

from raxel.features.active_grid.reading import MIN_MODULATION

SAMPLES = 50_000  # pixels, for a mean
# a_2 / a_1 of the powers 0.03 and 4: responses have less.
MOST = 0.48, 0.5
POWERS = 16  # from 1 to that of a_2: two that follow one another look like one between
# Of the two harmonics before them, what those that are not told have at most.
LESS = 0.5


def shift_bound(stack, steps, noise):
    """RMS in periods by which a response shifts phases at most; 0 where nothing is lit.

    stack: a PictureStack; steps: pictures, four or more; noise: a Noise.
    """
    shares = _shares(stack, steps, noise)
    if shares is None:
        return 0.0
    return bound_of_shares(shares, len(steps)) / np.sqrt(2) / (2 * np.pi)


def bound_of_shares(shares, count):
    """How large a_(N-1) and a_(N+1) together are at most, in shares of a_1.

    shares: (N - 1,) of harmonics 0 to N - 2; count: N, 4 or more.
    """
    second = np.clip(shares[2], -MOST[0], MOST[1])
    power = (1 + 2 * second) / (1 - second)
    powers = np.linspace(1, power, POWERS)
    between = np.abs(harmonics_of_powers(powers, count + 1)).max(axis=0)
    bound = between[count - 1] + between[count + 1]
    if count == 4:
        return bound
    if count == 5:
        third = shares[3] - harmonics_of_powers([power], 3)[0, 3]
        return bound + abs(second * third)
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


def _shares(stack, steps, noise):
    """(N - 1,) harmonics 0 (as 0) to N - 2 in shares of a_1, or None."""
    count = len(steps)
    apart = max(1, int(np.sqrt(np.prod(stack.shape) / SAMPLES)))
    light = np.array([stack.images[k][::apart, ::apart] for k in steps], np.float32)
    turn = np.exp(-2j * np.pi * np.arange(count) / count)
    first = 2 / count * np.tensordot(turn, light, 1)
    least = MIN_MODULATION**2 * 2 / count * noise.at(light.mean(axis=0))
    lit = np.abs(first) ** 2 > least
    if not lit.any():
        return None
    size, light = np.abs(first[lit]), light[:, lit]
    back = first[lit].conj() / size
    shares = np.zeros(count - 1)
    shares[1] = 1
    for m in range(2, count - 1):
        waves = 2 / count * np.tensordot(turn**m, light, 1)
        # Harmonic N - m is in it as well, and turns the other way.
        shares[m] = np.mean(waves * back**m).real / size.mean()
    return shares
