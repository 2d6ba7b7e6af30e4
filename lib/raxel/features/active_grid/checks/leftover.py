"""What N steps of a sine leave besides it, by response and light, and by what passed.

N - 3 numbers are left of each pixel: those of the Fourier transform of its steps that
belong to no level and no first harmonic. Harmonics of the response are in them, each
times the modulation and the phase's own power, with shares that follow from modulation,
level and place in the picture; so is the light of each step. Both are the same for all
pixels: a few coefficients, fitted to some of them such that few odd ones have no say.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

ROUNDS = 6
EXACT = 1e-9  # grey levels squared: pictures without noise leave what floats round
FEW = 2  # of the numbers by which harmonics change: those of small ones


class Steps(NamedTuple):
    """N steps of an axis: their numbers in the stack and pictures (H, W); weights (N,)
    complex and level (N,) that give the wave, which turns with the phase, and the mean;
    usual: a modulation, as a unit."""

    axis: int
    numbers: tuple[int, ...]
    pictures: list
    weights: np.ndarray
    level: np.ndarray
    usual: float

    @classmethod
    def of(cls, images, code, some):
        """Those of an AxisCode; some: an index into pictures, of lit pixels."""
        sine, cosine, level = code.sines.weights.astype(np.float32)
        # Of step 0, whatever the offset.
        turn = np.exp(2j * np.pi * code.sines.offset)
        weights = ((cosine + 1j * sine) * turn).astype(np.complex64)
        pictures = [images[k] for k in code.steps]
        own = cls(code.axis, code.steps, pictures, weights, level, 1.0)
        return own._replace(usual=float(np.median(own.at(some).size)))

    def at(self, where):
        """What is seen at an index into pictures, a tuple."""
        light = np.array([picture[where] for picture in self.pictures], np.float32)
        wave = np.tensordot(self.weights, light, 1)
        size = np.abs(wave)
        unit = wave / np.maximum(size, 1e-6)
        shape = self.pictures[0].shape
        v, u = np.ogrid[-1 : 1 : shape[0] * 1j, -1 : 1 : shape[1] * 1j]
        x, y = (np.broadcast_to(one, shape)[where] for one in (u, v))
        mean = np.tensordot(self.level, light, 1)
        return SeenSteps(light, mean, size, unit, x, y, self.usual)


class SeenSteps(NamedTuple):
    """light (N, ...), mean and size (...), the modulation, and unit complex (...),
    float32; x, y (...), place in the picture from -1 to 1; usual, as of Steps."""

    light: np.ndarray
    mean: np.ndarray
    size: np.ndarray
    unit: np.ndarray
    x: np.ndarray
    y: np.ndarray
    usual: float

    def shares(self):
        """(11, ...): by what harmonics may change."""
        x, y = self.x, self.y
        size, level = self.size / self.usual, self.mean / self.usual
        alike = size, level, size**2, size * level, level**2
        columns = np.ones_like(size), *alike, x, y, x * x, x * y, y * y
        return np.array(columns, np.float32)


class _Term(NamedTuple):
    """A harmonic in number m of those left: modulation times unit^power times shares,
    of which as many as there are coefficients, complex."""

    m: int
    power: int
    count: int


def _terms(count):
    """The harmonics that N steps have left over, below the one that is N + 2."""
    found = []
    for m in range(2, count // 2 + 1):
        powers = {m, m - count} if 2 * m < count else {m}
        for power in sorted(powers, key=abs):
            found.append(_Term(m, power, 11 if abs(power) <= 3 else FEW))
    return found


def left_over(count):
    """(M, N) complex: numbers 2 to N / 2 of the Fourier transform of steps, such that
    white noise of variance 1 gives all of them N - 3 together."""
    m = np.arange(2, count // 2 + 1)[:, None]
    waves = np.exp(-2j * np.pi * m * np.arange(count) / count)
    return waves * np.where(2 * m == count, 1, np.sqrt(2)) / np.sqrt(count)


def left_of(seen, transform, terms):
    """(M, ...) complex: what a transform of the steps leaves, less the terms."""
    count = len(seen.light)
    left, shares = np.tensordot(transform, seen.light, 1), seen.shares()
    for term, found in terms:
        even, odd = (
            np.tensordot(part.astype(np.float32), shares[: term.count], 1)
            for part in (found.real, found.imag)
        )
        own = (even + 1j * odd) * seen.size * power(seen.unit, term.power)
        left[term.m - 2] -= own.real if 2 * term.m == count else own
    if count % 2 == 0:
        left[-1].imag = 0
    return left


def power(unit, exponent):
    """unit^exponent of complex numbers of unit length, by products alone."""
    found = one = unit if exponent > 0 else unit.conj()
    for _ in range(abs(exponent) - 1):
        found = found * one
    return found


def response(seen):
    """(N,) light of each step less 1, and [(_Term, coefficients), ...], as most of some
    pixels have them, which are SeenSteps."""
    count, terms = len(seen.light), _terms(len(seen.light))
    found = robust(*_of_response(seen))
    numbers, at = [], count - 1
    for term in terms:
        pairs = found[at : at + 2 * term.count].reshape(-1, 2)
        numbers.append((term, pairs[:, 0] + 1j * pairs[:, 1]))
        at += 2 * term.count
    gains = found[: count - 1]
    return np.array([-gains.sum(), *gains]), numbers


def beside_response(seen, changes):
    """What is left of steps beside response and light, (K,), and of changes of steps,
    (C, N, ...) to (C, K), in standard deviations of most pixels, as SeenSteps.

    Pixels that are far off hardly count.
    """
    values, basis = _of_response(seen)
    count, transform = len(seen.light), left_over(len(seen.light))
    off = np.sum((values - np.tensordot(robust(values, basis), basis, 1)) ** 2, axis=0)
    usual = np.median(off) / chi2.median(len(values))
    weight = 1 / np.sqrt(1 + off / np.median(off)) / np.sqrt(usual)
    own = [values, *(real(np.tensordot(transform, one, 1), count) for one in changes)]
    own = weight * np.array(own)
    q = np.linalg.qr((weight * basis).reshape(len(basis), -1).T)[0]
    own = own.reshape(len(own), -1)
    own = own - (own @ q) @ q.T
    return own[0], own[1:]


def _of_response(seen):
    """Values (N - 3, P) that are left of some pixels, and basis (C, N - 3, P) of what
    response and light make of them."""
    count, light, size = len(seen.light), seen.light, seen.size
    transform, shares, terms = left_over(count), seen.shares(), _terms(count)
    # All of them brighter is no difference, and would explain everything.
    columns = [
        transform[:, [k]] * light[k] - transform[:, [0]] * light[0]
        for k in range(1, count)
    ]
    for term in terms:
        wave = size * power(seen.unit, term.power)
        for share in shares[: term.count]:
            for one in (1, 1j):
                column = np.zeros((len(transform), len(size)), complex)
                column[term.m - 2] = one * wave * share
                columns.append(column)
    basis = np.array([real(column, count) for column in columns])
    return real(transform @ light, count), basis


def real(values, count):
    """(N - 3, P) of complex (M, P)."""
    imaginary = values.imag[:-1] if count % 2 == 0 else values.imag
    return np.concatenate([values.real, imaginary])


def robust(values, basis):
    """Coefficients (C,) of basis (C, K, P) for values (K, P) of most of P."""
    scale = np.sqrt(np.mean(basis**2, axis=(1, 2))) + 1e-9
    basis = basis / scale[:, None, None]
    weights, flat = np.ones(values.shape[1]), basis.reshape(len(basis), -1)
    for _ in range(ROUNDS):
        own = (basis * weights).reshape(len(basis), -1)
        normal = own @ flat.T + 1e-6 * weights.sum() * np.eye(len(basis))
        found = np.linalg.solve(normal, own @ values.ravel())
        off = np.sum((values - np.tensordot(found, basis, 1)) ** 2, axis=0)
        weights = 1 / (1 + off / max(np.median(off), EXACT)) ** 2
    return found / scale
