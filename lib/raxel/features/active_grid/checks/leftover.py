"""What N steps of a sine leave besides it, by response and light, and by what passed.

N - 3 numbers are left of each pixel: those of the Fourier transform of its steps that
belong to no level and no first harmonic. Harmonics of the response are in them, each
times the modulation and the phase's own power, with shares that follow from modulation,
level and place in the picture; so is the light of each step. Both are the same for all
pixels: a few coefficients, fitted to some of them such that few odd ones have no say.
"""

from typing import NamedTuple

import numpy as np

ROUNDS = 6
EXACT = 1e-9  # grey levels squared: pictures without noise leave what floats round
AT_ONCE = 2**18  # pixels, of which each takes some 200 bytes meanwhile
FEW = 2  # of the numbers by which harmonics change: those of small ones


class Steps(NamedTuple):
    """Of N steps of an axis: pictures (N,), light (N, H, W) float32, mean (H, W), size
    alike, the modulation, and unit complex (H, W), which turns with the phase; usual: a
    modulation, as a unit.
    """

    axis: int
    pictures: tuple[int, ...]
    light: np.ndarray
    mean: np.ndarray
    size: np.ndarray
    unit: np.ndarray
    usual: float

    @classmethod
    def of(cls, images, code, good):
        light = np.array([images[k] for k in code.steps], np.float32)
        sine, cosine, level = code.sines.weights.astype(np.float32)
        wave = np.tensordot(cosine + 1j * sine, light, 1)
        # Of step 0, whatever the offset.
        wave *= np.complex64(np.exp(2j * np.pi * code.sines.offset))
        size = np.abs(wave)
        usual = float(np.median(size[good])) if good.any() else 1.0
        unit = wave / np.maximum(size, 1e-6)
        mean = np.tensordot(level, light, 1)
        return cls(code.axis, code.steps, light, mean, size, unit, usual)

    def shares(self, where):
        """(11, ...): by what harmonics may change, at an index into pictures."""
        height, width = self.mean.shape
        v, u = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
        x, y = (np.broadcast_to(one, self.mean.shape)[where] for one in (u, v))
        size, level = self.size[where] / self.usual, self.mean[where] / self.usual
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


def blocks_of_rows(shape):
    """Slices of rows with AT_ONCE pixels each, or a single row."""
    high = max(1, AT_ONCE // shape[1])
    return [slice(top, top + high) for top in range(0, shape[0], high)]


def left_of(steps, transform, terms, rows):
    """(M, rows, W) complex: what a transform of the steps leaves, less the terms."""
    count = len(steps.light)
    left = np.tensordot(transform, steps.light[:, rows], 1)
    shares, size, unit = steps.shares(rows), steps.size[rows], steps.unit[rows]
    for term, found in terms:
        own = np.tensordot(found.astype(np.complex64), shares[: term.count], 1)
        own *= size * power(unit, term.power)
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


def response(steps, some):
    """(N,) light of each step less 1, and [(_Term, coefficients), ...], as most of some
    pixels have them."""
    count = len(steps.light)
    transform, light = left_over(count), steps.light[:, *some]
    size, unit = steps.size[some], steps.unit[some]
    shares, terms = steps.shares(some), _terms(count)
    # All of them brighter is no difference, and would explain everything.
    columns = [
        transform[:, [k]] * light[k] - transform[:, [0]] * light[0]
        for k in range(1, count)
    ]
    for term in terms:
        wave = size * power(unit, term.power)
        for share in shares[: term.count]:
            for one in (1, 1j):
                column = np.zeros((len(transform), len(size)), complex)
                column[term.m - 2] = one * wave * share
                columns.append(column)
    values = real(transform @ light, count)
    basis = np.array([real(column, count) for column in columns])
    found = robust(values, basis)
    numbers, at = [], count - 1
    for term in terms:
        pairs = found[at : at + 2 * term.count].reshape(-1, 2)
        numbers.append((term, pairs[:, 0] + 1j * pairs[:, 1]))
        at += 2 * term.count
    gains = found[: count - 1]
    return np.array([-gains.sum(), *gains]), numbers


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
