"""Ripple of positions by a nonlinear response, estimated from the images themselves.

Monitors have a gamma, cameras a tone curve. Both add harmonics to a sinusoidal pattern.
Positions then have a ripple with N cycles per period of N steps (`reading`, Appendix
A). A single pixel does not reveal it: its steps fit some sinusoid as well as the right
one. The smoothness of surfaces does: along a line of the image, the phase is a
polynomial of low degree plus the ripple, whose shape has a few unknown coefficients.
They are constant over the image, or change slowly with the viewing angle of the
monitor, the falloff of light, and blur.

The coefficients are estimated by least squares on short pieces of some rows and
columns, each with its own polynomial, through the arithmetic of the decoder: per pixel
first, then means of neighbours. So noise and fine patterns weaken the ripple equally in
both.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.coding import BRIGHT_PERCENTILE, MIN_MODULATION_SHARE
from raxel.features.active_grid.lines import (
    MEANS_PER_PIECE,
    Ripple,
    corrected_phases,
    corrected_waves,
    no_ripple,
    pieces_of,
)
from raxel.features.active_grid.reading import MIN_MODULATION

# A bound on the harmonics that the steps do not determine. Harmonic m of the light is
# a_m cos(m psi). N steps determine a_2 to a_(N-2). a_(N-1) and a_(N+1) shift phases and
# cannot be distinguished from a_1. For light to the power g, a_(n+1) / a_n = (g - n) /
# (g + n + 1), for 1 + cos(psi) to that power: a_2 determines g. S-shaped curves have
# odd harmonics, which a_3 reveals and a_2 does not. Four steps do not determine a_3,
# but the Gray code does: it shows the light at psi = 0 and at pi, whose difference is 2
# (a_1 + a_3 + a_5 + ...).


N_SAMPLES = 50_000  # pixels, for a mean
PARTS_PER_SIDE = 3  # of the image
# a_2 / a_1 of the powers 0.03 and 4: responses are between them.
SECOND_HARMONIC_LIMITS = 0.48, 0.5
N_HARMONICS = 60  # harmonics of a power in a sum
N_POWERS = 16  # powers from 1 to that of a_2, dense enough to interpolate
# Undetermined harmonics, at most, as a share of the two harmonics before them.
MAX_HARMONIC_RATIO = 0.5
# For an S-shaped curve whose odd harmonics beyond the first have the sum t, a_3 and a_5
# together are below (1 + ODD_SLOPE |t|) |t|; a_4 and a_6 are below SECOND_THIRD_FACTOR
# |a_2 a_3|; a_9 and a_11 are below THIRD_FACTOR a_3^4.
ODD_SLOPE, SECOND_THIRD_FACTOR, THIRD_FACTOR = 5.0, 4.0, 5.0
# Relative uncertainty of the blur, by which sinusoids are weaker than the code.
BLUR_UNCERTAINTY = 0.3
# Logarithm of the largest attenuation by blur: weaker sinusoids are not decoded.
MAX_LOG_ATTENUATION = 3.0


def shift_bound(stack, code, noise, blur_px):
    """Return a bound on the shift of phases, RMS in periods; 0 without lit pixels.

    stack: an ImageStack; code: an AxisCode with four steps or more; noise: a Noise;
    blur_px: standard deviation, 0 if unknown.
    """
    parts = _sampled_sines(stack, code.steps, noise)
    if not parts:
        return 0.0
    bounds = [_bound(stack, code, part, blur_px) for part in parts]
    pixels = [len(part.size) for part in parts]
    mean_square = np.average(np.square(bounds), weights=pixels)
    return np.sqrt(mean_square / 2) / (2 * np.pi)


def _bound(stack, code, sines, blur_px):
    count = len(code.steps)
    odd, uncertainty = 0.0, 0.0
    if count == 4 and code.bits:
        odd, uncertainty = _odd_harmonics(stack, code, sines, blur_px)
    return bound_of_shares(_shares(sines, count), count, odd) + uncertainty


def bound_of_shares(shares, count, odd=0.0):
    """Return a bound on a_(N-1) and a_(N+1) together, in units of a_1.

    shares: (N - 1,) of harmonics 0 to N - 2; count: N, 4 or more; odd: for four steps,
    a_3 + a_5 + ...
    """
    second = np.clip(shares[2], -SECOND_HARMONIC_LIMITS[0], SECOND_HARMONIC_LIMITS[1])
    power = (1 + 2 * second) / (1 - second)
    powers = np.linspace(1, power, N_POWERS)
    between = np.abs(harmonics_of_powers(powers, count + 1)).max(axis=0)
    bound = between[count - 1] + between[count + 1]
    if count == 4:
        excess = abs(odd - harmonics_of_powers([power], N_HARMONICS)[0, 3::2].sum())
        return bound + (1 + ODD_SLOPE * excess) * excess
    if count == 5:
        third = shares[3] - harmonics_of_powers([power], 3)[0, 3]
        return (
            bound + SECOND_THIRD_FACTOR * abs(second * third) + THIRD_FACTOR * third**4
        )
    before = np.abs(shares[-2:])
    excess = np.maximum(before - between[count - 3 : count - 1], 0)
    return min(
        bound + MAX_HARMONIC_RATIO * excess.max(), MAX_HARMONIC_RATIO * before.max()
    )


def harmonics_of_powers(powers, last):
    """Return (P, last + 1) harmonics of powers (P,) in units of a_1; the mean is 0."""
    powers, n = np.asarray(powers, float)[:, None], np.arange(1, last)
    shares = np.zeros((len(powers), last + 1))
    shares[:, 1] = 1
    shares[:, 2:] = np.cumprod((powers - n) / (powers + n + 1), axis=1)
    return shares


class _Sines(NamedTuple):
    """Hold P lit pixels of N steps.

    light: (N, P); size: (P,), modulation; back: (P,), conjugate of the unit phase
    vector; turn: (P,), rad per px of the image; at: rows and columns of the images
    (P,).
    """

    light: np.ndarray
    size: np.ndarray
    back: np.ndarray
    turn: np.ndarray
    at: tuple[np.ndarray, np.ndarray]


def _sampled_sines(stack, steps, noise):
    """Return _Sines of some pixels of each part of the image with lit pixels.

    Where the light falls off, parts show the bright and the dark end of a curve.
    """
    count = len(steps)
    difference = max(1, int(np.sqrt(np.prod(stack.shape) / N_SAMPLES)))
    height, width = stack.shape
    turn = 2 / count * np.exp(-2j * np.pi * np.arange(count) / count)
    positions = [
        np.s_[
            down : height - 1 + down : difference,
            right : width - 1 + right : difference,
        ]
        for down, right in ((0, 0), (1, 0), (0, 1))
    ]
    every = [
        np.array([stack.images[k][position] for k in steps], np.float32)
        for position in positions
    ]
    first, below, right_of = (np.tensordot(turn, light, 1) for light in every)
    middle = every[0]
    threshold = MIN_MODULATION**2 * 2 / count * noise.at(middle.mean(axis=0))
    size = np.maximum(np.abs(first), 1e-6)
    lit = size**2 > threshold
    if lit.any():
        lit &= size > MIN_MODULATION_SHARE * np.percentile(size[lit], BRIGHT_PERCENTILE)
    back = first.conj() / size
    turn_rate = np.hypot(*(np.angle(other * back) for other in (below, right_of)))
    rows, columns = np.nonzero(lit)
    part = (
        PARTS_PER_SIDE * (PARTS_PER_SIDE * rows // lit.shape[0])
        + PARTS_PER_SIDE * columns // lit.shape[1]
    )
    found = []
    for k in np.unique(part):
        at = rows[part == k], columns[part == k]
        own = middle[:, *at], size[at], back[at], turn_rate[at]
        found.append(_Sines(*own, tuple(difference * position for position in at)))
    return found


def _shares(sines, count):
    """Return (N - 1,) harmonics 0 (as 0) to N - 2 in units of a_1."""
    turn = np.exp(-2j * np.pi * np.arange(count) / count)
    shares = np.zeros(count - 1)
    shares[1] = 1
    for m in range(2, count - 1):
        waves = 2 / count * np.tensordot(turn**m, sines.light, 1)
        # Harmonic N - m is included and rotates in the opposite direction.
        shares[m] = np.mean(waves * sines.back**m).real / sines.size.mean()
    return shares


def _odd_harmonics(stack, code, sines, blur_px):
    """Return (a_3 + a_5 + ..., its uncertainty), in units of a_1.

    Blur attenuates the sinusoids more than the coarsest bit.
    """
    half = np.abs(stack.difference(code.bits[0], sines.at)) / 2
    weaker = np.minimum((blur_px * sines.turn) ** 2 / 2, MAX_LOG_ATTENUATION)
    kept = half * np.exp(-weaker)
    odd = np.sum(kept) / np.sum(sines.size) - 1
    return odd, BLUR_UNCERTAINTY * np.sum(weaker * kept) / max(np.sum(kept), 1e-6)


POLYNOMIAL_DEGREE = 3
MIN_N_PIECES = 6
MAX_SHARE = 0.45  # of harmonic N - 1: at one half, phases reverse
MAX_ROUNDS = 8
MIN_GAIN_SIGMAS = 8  # standard deviations of the gain by noise; below, no correction
CONVERGENCE_TOL = 0.02  # share of the residuals of means
TYPICAL_SHARE, HARMONIC_DECAY = 0.3, 3.0  # of harmonics: twice those of a gamma of 2.4
MAX_ROUGHNESS_RATIO = 6  # times the residual of smooth pieces
N_FIT_STEPS, MAX_NEWTON_STEPS = 4, 6  # of Newton's method; during the fit, at most
PHASE_TOL_RAD = 2e-5
WARN_RATIO = 0.8  # of a usual sigma, which contains the rest


class Response(NamedTuple):
    """Hold the response along one axis of a view.

    ripple: Ripple. size: RMS in periods of the shift of positions, as corrected, or of
    the fit if nothing was corrected; remaining: of the rest, which sigma contains. Both
    None where the images do not determine them. steps: number of phase steps, 0 where
    the response was not estimated. bound: whether size is only an upper bound.
    """

    ripple: Ripple
    size: float | None = None
    remaining: float | None = None
    steps: int = 0
    bound: bool = False

    def scaled(self, length):
        """Return the response in the unit of `length`, the length of a period."""
        if self.size is None:
            return self
        size, remaining = (
            float(value * length) for value in (self.size, self.remaining)
        )
        return self._replace(size=size, remaining=remaining)


UNKNOWN_RESPONSE = Response(no_ripple())


def measured_response(stack, noise, limit, blur_px):
    """Return a Response for each AxisCode of an ImageStack.

    noise: a Noise; limit: the grey level from which a sinusoid counts as clipped;
    blur_px: standard deviation of the blur, 0 if unknown.
    """
    return tuple(
        _of_axis(stack, code, noise, limit, blur_px) if code.steps else UNKNOWN_RESPONSE
        for code in stack.codes
    )


def response_warnings(decoded, linear):
    """Return warnings on an unknown or remaining response of a Decoded."""
    lines = []
    for axis, response in enumerate(decoded.response):
        known = decoded.sigma[..., axis][decoded.mask]
        known = known[np.isfinite(known)]
        if linear or not len(known):
            continue
        if response.steps == 3 and response.size is None:
            lines.append(
                f"axis {'xy'[axis]}: response of monitor and camera is unknown (too "
                "few pixels or too fine stripes) and not included in sigma; take six "
                "steps"
            )
            continue
        if response.remaining is None or response.remaining <= WARN_RATIO * np.median(
            known
        ):
            continue
        if response.bound:
            lines.append(
                f"axis {'xy'[axis]}: positions may be shifted by up to "
                f"{response.remaining:.2g} {decoded.unit} RMS (response unknown, "
                f"included in sigma); take {'six' if response.steps < 6 else 'more'} "
                "steps, or use "
                "--linear for a linear monitor and camera"
            )
        else:
            lines.append(
                f"axis {'xy'[axis]}: {response.remaining:.2g} {decoded.unit} of the "
                f"shift of {response.size:.2g} {decoded.unit} by the response remain "
                "after correction; take more steps"
            )
    return lines


def _of_axis(stack, code, noise, limit, blur_px):
    pieces = pieces_of(stack, code.sines, noise, limit)
    if sum(len(own.phase) for own in pieces) < MIN_N_PIECES:
        return _bounded(stack, code, noise, blur_px)
    return _fitted(pieces, code.sines)


def _bounded(stack, code, noise, blur_px):
    """Return the bound on the Response from the steps, where lines do not determine it.

    Three steps give no bound.
    """
    count = len(code.steps)
    if count < 4:
        return Response(no_ripple(), steps=count)
    bound = shift_bound(stack, code, noise, blur_px)
    return Response(no_ripple(), bound, bound, count, True)


def _fitted(pieces, sines):
    """Return the Response that makes pieces of lines smooth."""
    count = len(sines.steps)
    used = np.arange({3: 9, 4: 8}.get(count, 7))  # of share, skew, r2, r3
    usual = _usual(count)[used]
    values, weights = np.zeros(9), None
    blind = _blind_to_polynomials()
    for _ in range(MAX_ROUNDS):
        # From zero, one of Newton's steps is exact.
        ripple = _ripple_of(values, sines, N_FIT_STEPS if values.any() else 1)
        found = [corrected_phases(own, ripple) for own in pieces]
        rest, slopes = (np.concatenate(part) for part in zip(*found, strict=True))
        rest, slopes = (blind @ rest[..., None])[..., 0], blind @ slopes
        selected = np.take(slopes, used, axis=2)
        change, weights = _step(values[used], usual, rest, selected, weights)
        values[used] += change
        values[0] = np.clip(values[0], -MAX_SHARE, MAX_SHARE)
        rest = rest - selected @ change
        if np.sqrt(np.mean((selected @ change) ** 2)) < CONVERGENCE_TOL * np.sqrt(
            np.mean(rest**2)
        ):
            break
    covariance = _covariance(usual, rest, selected, weights)
    gain = values[used] @ np.linalg.solve(covariance, values[used])
    basis = np.concatenate([own.basis.reshape(-1, 6) for own in pieces])
    size = _size(values, basis, count)
    of_fit = _of_fit(covariance, used, basis)
    if gain < len(used) + MIN_GAIN_SIGMAS * np.sqrt(2 * len(used)):
        remaining = np.sqrt(max(size**2, of_fit))
        return Response(no_ripple(), size, remaining, count)
    of_pieces = _of_pieces(rest, slopes[..., [0, 6]], weights)
    ripple = _ripple_of(values, sines, _newton_steps(values, sines))
    return Response(ripple, size, np.sqrt(of_fit + of_pieces), count)


def _size(values, basis, count):
    """Return the RMS shift in periods of phases that are uniformly distributed."""
    psi = 2 * np.pi * np.arange(64) / 64
    one = np.exp(-1j * psi)
    share = (basis[::100] @ values[:6])[:, None] + 1j * values[6]
    f = 1 + share * one + values[7] * one**2 + values[8] * one**3
    return np.sqrt(np.mean(np.angle(f) ** 2)) / (2 * np.pi)


def _of_fit(covariance, used, basis):
    """Return the mean square in periods by the covariance of the coefficients."""
    full = np.zeros((9, 9))
    full[np.ix_(used, used)] = covariance
    own = np.sum(full[:6, :6] * (basis.T @ basis)) / len(basis)
    return (own + np.trace(full[6:, 6:])) / 2 / (2 * np.pi) ** 2


def _of_pieces(rest, slopes, weights):
    """Return the mean square in periods of ripples of pieces, beyond their noise.

    slopes: (S, MEANS_PER_PIECE, 2), of a sine and a cosine.
    """
    kept = weights > 0
    rest, slopes, weights = rest[kept], slopes[kept], weights[kept]
    normal, right = slopes.swapaxes(1, 2) @ slopes, _right(slopes, rest)
    found = np.linalg.solve(normal, right[..., None])[..., 0]
    squares = weights * np.sum(found * right, axis=1)
    # Chi squared with two degrees of freedom has the median 2 ln 2 with the relative
    # standard deviation 1 / (ln 2 sqrt(S)).
    excess = np.median(squares) / (2 * np.log(2)) - 1
    if excess < 2 / (np.log(2) * np.sqrt(len(rest))):
        return 0.0
    variance = np.median(2 / (weights * np.trace(normal, axis1=1, axis2=2)))
    return excess * variance / (2 * np.pi) ** 2


def _newton_steps(values, sines):
    """Return the number of Newton's steps until convergence."""
    phase = 2 * np.pi * np.arange(256) / 256
    wave, at = np.exp(1j * phase), np.zeros(256)
    before = wave
    for times in range(1, MAX_NEWTON_STEPS):
        ripple = _ripple_of(values, sines, times)
        now = corrected_waves(ripple, wave, at, at)
        if np.abs(np.angle(now * before.conj())).max() < PHASE_TOL_RAD:
            return max(times - 1, 1)
        before = now
    return MAX_NEWTON_STEPS


def _ripple_of(values, sines, times):
    share, terms = values[:6].astype(np.float32), values[6:].astype(np.float32)
    return Ripple(len(sines.steps), sines.offset, times, share, terms)


@cache
def _blind_to_polynomials():
    """Return the projection of means along a line off the polynomials."""
    position = np.linspace(-1, 1, MEANS_PER_PIECE)
    basis = np.linalg.qr(np.vander(position, POLYNOMIAL_DEGREE + 1))[0]
    return np.eye(MEANS_PER_PIECE) - basis @ basis.T


def _usual(count):
    """Return (9,) prior standard deviations of the coefficients.

    Harmonic m of real responses is below TYPICAL_SHARE HARMONIC_DECAY^(2 - m) of the
    first one.
    """
    orders = np.array([count - 1] * 7 + [2 * count - 1, 3 * count - 1])
    usual = TYPICAL_SHARE * HARMONIC_DECAY ** (2.0 - orders)
    usual[1:7] /= (
        HARMONIC_DECAY  # change over the image, and effect of an asymmetric blur
    )
    return usual


def _step(values, usual, rest, slopes, weights):
    """Return the change of the coefficients, and weights of pieces by residuals."""
    free = MEANS_PER_PIECE - POLYNOMIAL_DEGREE - 1
    if weights is None:
        weights = np.full(len(rest), 1 / np.mean(rest**2))
    for _ in range(2):
        normal = _normal(usual, slopes, weights)
        right = weights @ _right(slopes, rest) - values / usual**2
        change = np.linalg.solve(normal, right)
        remaining = np.sum((rest - slopes @ change) ** 2, axis=1) / free
        smooth = lower_quartile(remaining)
        # Pieces across a break, or with a stronger bend than a polynomial, are
        # excluded.
        weights = (remaining < MAX_ROUGHNESS_RATIO * smooth) / np.maximum(
            remaining, smooth
        )
    return change, weights


def _normal(usual, slopes, weights):
    of_pieces = slopes.swapaxes(1, 2) @ slopes
    return np.tensordot(weights, of_pieces, 1) + np.diag(1 / usual**2)


def _right(slopes, rest):
    """Return (S, p), the right side of each piece's normal equations."""
    return (slopes.swapaxes(1, 2) @ rest[..., None])[..., 0]


def lower_quartile(values):
    """Return the quantile 0.25, faster than `np.quantile`."""
    position = (len(values) - 1) / 4
    below = int(position)
    ends = below, min(below + 1, len(values) - 1)
    low, high = np.partition(values, ends)[list(ends)]
    return low + (high - low) * (position - below)


def _covariance(usual, rest, slopes, weights):
    """Return the covariance by the noise of means, or by the scatter of pieces.

    The latter is larger where surfaces are not as smooth as a polynomial.
    """
    inverse = np.linalg.inv(_normal(usual, slopes, weights))
    pulls = inverse @ (weights[:, None] * _right(slopes, rest)).T
    known = np.count_nonzero(weights)
    scatter = pulls @ pulls.T * known / max(known - len(inverse), 1)
    share = np.trace(scatter @ np.linalg.inv(inverse)) / len(inverse)
    return inverse * max(share, 1.0)
