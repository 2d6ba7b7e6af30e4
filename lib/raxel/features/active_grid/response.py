"""How places ripple by a response that is not linear, from the images themselves.

Monitors have a gamma, cameras a tone curve. What they make of a sine holds harmonics,
and places are off by a ripple that comes again N times in each period of N steps
(`ripple`, Appendix A). No one pixel tells it: its steps follow some sine as well as
they follow the right one. What tells it is that surfaces are smooth where a ripple is
not: along a line of the image, the phase is a polynomial of low degree plus the
ripple, whose shape is known but for a few numbers. These are the same in all of the
image, or change over it slowly: with the angle at which the monitor is seen, the
falloff of light, and blur.

They are found by least squares on short pieces of some rows and columns, each with a
polynomial of its own, through the very arithmetic that decodes: per pixel first, then
means of neighbours. So noise and fine patterns weaken the ripple alike in both.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid.coding import BRIGHT, LIT
from raxel.features.active_grid.lines import (
    RECORDS,
    Ripple,
    corrected,
    no_ripple,
    pieces_of,
    undone,
)
from raxel.features.active_grid.reading import MIN_MODULATION

# What steps themselves say of a response: a bound on what they cannot be corrected
# by. Harmonic m of the light is a_m cos(m psi). N steps tell a_2 to a_(N-2); what
# shifts phases is a_(N-1) and a_(N+1), which they do not tell from a_1. Of light to
# the power g, a_(n+1) / a_n = (g - n) / (g + n + 1), for 1 + cos(psi) to that power:
# a_2 tells g. Curves like an S have odd harmonics, of which a_2 says nothing and a_3
# does. Four steps do not tell a_3, but the Gray code does: it shows the light at psi
# = 0 and at pi, whose difference is 2 (a_1 + a_3 + a_5 + ...).


SAMPLES = 50_000  # pixels, for a mean
PARTS = 3  # along each side of the image
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
    phase turned back; turn (P,), rad per px of the image; at: rows and columns of the
    images (P,)."""

    light: np.ndarray
    size: np.ndarray
    back: np.ndarray
    turn: np.ndarray
    at: tuple[np.ndarray, np.ndarray]


def _seen(stack, steps, noise):
    """[_Sines, ...] of some pixels of each part of the image where any are lit.

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


DEGREE = 3  # of the polynomial
MIN_PIECES = 6
MOST_SHARE = 0.45  # of harmonic N - 1: half is where phases turn back
ROUNDS = 8
SURE = 8  # standard deviations of what noise makes of it, to correct at all
CONVERGED = 0.02  # of what is left of means
USUAL, FALL = 0.3, 3.0  # of harmonics: twice what a gamma of 2.4 has
ROUGH = 6  # times what smooth pieces leave
STEPS_ASKED, MOST_STEPS = 4, 6  # of Newton's method, while numbers are looked for
NEGLIGIBLE = 2e-5  # rad
MUCH = 0.8  # of a usual sigma, which holds it


class Response(NamedTuple):
    """What is known of the response along one axis of a view.

    ripple: Ripple. size: RMS in periods by which places were off, or would be by the
    fit where nothing was corrected; left: alike, what is left, and in sigma. Both None
    where the images do not tell. steps: of the sines, 0 where nothing was asked.
    """

    ripple: Ripple
    size: float | None = None
    left: float | None = None
    steps: int = 0
    bound: bool = False

    def scaled(self, length):
        """In the unit of `length`, of a period."""
        if self.size is None:
            return self
        size, left = (float(value * length) for value in (self.size, self.left))
        return self._replace(size=size, left=left)


UNTOLD = Response(no_ripple())


def measured_response(stack, noise, limit, blur_px):
    """(Response, ...) for each AxisCode of a PictureStack.

    noise: a Noise; limit: the value from which a sine counts as clipped; blur_px:
    standard deviation of the blur, 0 where it is not known.
    """
    return tuple(
        _of_axis(stack, code, noise, limit, blur_px) if code.steps else UNTOLD
        for code in stack.codes
    )


def response_warnings(decoded, linear):
    """Lines on what is not known of the response of a Decoded, or left of it."""
    lines = []
    for axis, response in enumerate(decoded.response):
        known = decoded.sigma[..., axis][decoded.mask]
        known = known[np.isfinite(known)]
        if linear or not len(known):
            continue
        if response.steps == 3 and response.size is None:
            lines.append(
                f"what the response of monitor and camera does to places along "
                f"{'xy'[axis]} cannot be told from so few pixels or so fine stripes, "
                "and standard deviations do not know of it; take six steps"
            )
            continue
        if response.left is None or response.left <= MUCH * np.median(known):
            continue
        if response.bound:
            lines.append(
                f"places along {'xy'[axis]} may be off by up to {response.left:.2g} "
                f"{decoded.unit} (RMS) by the response of monitor and camera, "
                "which so few pixels or so fine stripes do not tell, and standard "
                f"deviations hold that; take {_more_steps(response.steps)}, or decode "
                "with --linear if both answer in proportion"
            )
        else:
            lines.append(
                f"of the {response.size:.2g} {decoded.unit} by which the response of "
                f"monitor and camera shifts places along {'xy'[axis]}, "
                f"{response.left:.2g} {decoded.unit} are left; take more steps"
            )
    return lines


def _more_steps(count):
    return "six steps" if count < 6 else "more steps"


def _of_axis(stack, code, noise, limit, blur_px):
    pieces = pieces_of(stack, code.sines, noise, limit)
    if sum(len(own.phase) for own in pieces) < MIN_PIECES:
        return _bounded(stack, code, noise, blur_px)
    return _fitted(pieces, code.sines)


def _bounded(stack, code, noise, blur_px):
    """The Response where no piece of line tells it, by what the steps say themselves.

    Of three steps nothing is left that says anything.
    """
    count = len(code.steps)
    if count < 4:
        return Response(no_ripple(), steps=count)
    bound = shift_bound(stack, code, noise, blur_px)
    return Response(no_ripple(), bound, bound, count, True)


def _fitted(pieces, sines):
    """The Response that makes pieces of lines smooth."""
    count = len(sines.steps)
    used = _used(count)
    usual = _usual(count)[used]
    values, weights = np.zeros(9), None
    blind = _blind_to_polynomials()
    for _ in range(ROUNDS):
        # Where all numbers are 0, one of Newton's steps says that nothing is shifted.
        ripple = _ripple_of(values, sines, STEPS_ASKED if values.any() else 1)
        found = [corrected(own, ripple) for own in pieces]
        rest, slopes = (np.concatenate(part) for part in zip(*found, strict=True))
        rest, slopes = (blind @ rest[..., None])[..., 0], blind @ slopes
        asked = np.take(slopes, used, axis=2)
        change, weights = _step(values[used], usual, rest, asked, weights)
        values[used] += change
        values[0] = np.clip(values[0], -MOST_SHARE, MOST_SHARE)
        rest = rest - asked @ change
        if np.sqrt(np.mean((asked @ change) ** 2)) < CONVERGED * np.sqrt(
            np.mean(rest**2)
        ):
            break
    covariance = _covariance(usual, rest, asked, weights)
    gain = values[used] @ np.linalg.solve(covariance, values[used])
    basis = np.concatenate([own.basis.reshape(-1, 6) for own in pieces])
    size = _size(values, basis, count)
    of_fit = _of_fit(covariance, used, basis)
    if gain < len(used) + SURE * np.sqrt(2 * len(used)):
        left = np.sqrt(max(size**2, of_fit))
        return Response(no_ripple(), size, left, count)
    of_pieces = _of_pieces(rest, slopes[..., [0, 6]], weights)
    ripple = _ripple_of(values, sines, _enough_steps(values, sines))
    return Response(ripple, size, np.sqrt(of_fit + of_pieces), count)


def _size(values, basis, count):
    """RMS in periods of the shift of phases, all of them as often."""
    psi = 2 * np.pi * np.arange(64) / 64
    one = np.exp(-1j * psi)
    share = (basis[::100] @ values[:6])[:, None] + 1j * values[6]
    f = 1 + share * one + values[7] * one**2 + values[8] * one**3
    return np.sqrt(np.mean(np.angle(f) ** 2)) / (2 * np.pi)


def _of_fit(covariance, used, basis):
    """Mean square in periods of what the numbers' own uncertainty makes of phases."""
    full = np.zeros((9, 9))
    full[np.ix_(used, used)] = covariance
    own = np.sum(full[:6, :6] * (basis.T @ basis)) / len(basis)
    return (own + np.trace(full[6:, 6:])) / 2 / (2 * np.pi) ** 2


def _of_pieces(rest, slopes, weights):
    """Mean square in periods of ripples that pieces still have, beyond their noise.

    slopes: (S, RECORDS, 2), of a sine and a cosine.
    """
    kept = weights > 0
    rest, slopes, weights = rest[kept], slopes[kept], weights[kept]
    normal, right = slopes.swapaxes(1, 2) @ slopes, _right(slopes, rest)
    found = np.linalg.solve(normal, right[..., None])[..., 0]
    squares = weights * np.sum(found * right, axis=1)
    # Of chi squared with two degrees of freedom the median is 2 ln 2, and its relative
    # standard deviation 1 / (ln 2 sqrt(S)).
    excess = np.median(squares) / (2 * np.log(2)) - 1
    if excess < 2 / (np.log(2) * np.sqrt(len(rest))):
        return 0.0
    variance = np.median(2 / (weights * np.trace(normal, axis1=1, axis2=2)))
    return excess * variance / (2 * np.pi) ** 2


def _enough_steps(values, sines):
    """Newton's steps after which nothing changes any more."""
    phase = 2 * np.pi * np.arange(256) / 256
    wave, at = np.exp(1j * phase), np.zeros(256)
    before = wave
    for times in range(1, MOST_STEPS):
        ripple = _ripple_of(values, sines, times)
        now = undone(ripple, wave, at, at)
        if np.abs(np.angle(now * before.conj())).max() < NEGLIGIBLE:
            return max(times - 1, 1)
        before = now
    return MOST_STEPS


def _used(count):
    """Which of the nine numbers are asked for: share, imaginary part, r2, r3."""
    return np.arange({3: 9, 4: 8}.get(count, 7))


def _ripple_of(values, sines, times):
    share, terms = values[:6].astype(np.float32), values[6:].astype(np.float32)
    return Ripple(len(sines.steps), sines.offset, times, share, terms)


@cache
def _blind_to_polynomials():
    """(RECORDS, RECORDS): what polynomials do not explain of means along a line."""
    place = np.linspace(-1, 1, RECORDS)
    basis = np.linalg.qr(np.vander(place, DEGREE + 1))[0]
    return np.eye(RECORDS) - basis @ basis.T


def _usual(count):
    """(9,) standard deviations that numbers have before anything is measured.

    Harmonic m of responses that are met is below USUAL FALL^(2 - m) of the first one.
    """
    orders = np.array([count - 1] * 7 + [2 * count - 1, 3 * count - 1])
    usual = USUAL * FALL ** (2.0 - orders)
    usual[1:7] /= FALL  # how it changes in the image, and what no even blur makes
    return usual


def _step(values, usual, rest, slopes, weights):
    """Change of the numbers, and weights of pieces by what is left of them."""
    free = RECORDS - DEGREE - 1
    if weights is None:
        weights = np.full(len(rest), 1 / np.mean(rest**2))
    for _ in range(2):
        normal = _normal(usual, slopes, weights)
        right = weights @ _right(slopes, rest) - values / usual**2
        change = np.linalg.solve(normal, right)
        left = np.sum((rest - slopes @ change) ** 2, axis=1) / free
        smooth = lower_quartile(left)
        # What lies across a break, or is bent more than a polynomial, says nothing.
        weights = (left < ROUGH * smooth) / np.maximum(left, smooth)
    return change, weights


def _normal(usual, slopes, weights):
    of_pieces = slopes.swapaxes(1, 2) @ slopes
    return np.tensordot(weights, of_pieces, 1) + np.diag(1 / usual**2)


def _right(slopes, rest):
    """(S, p), each piece's right side of the normal equations."""
    return (slopes.swapaxes(1, 2) @ rest[..., None])[..., 0]


def lower_quartile(values):
    """As `np.quantile` has it, which takes longer to start than to find it."""
    place = (len(values) - 1) / 4
    below = int(place)
    ends = below, min(below + 1, len(values) - 1)
    low, high = np.partition(values, ends)[list(ends)]
    return low + (high - low) * (place - below)


def _covariance(usual, rest, slopes, weights):
    """Of the numbers: by the noise of means, or by how pieces contradict each other.

    The latter is larger where surfaces are not as smooth as a polynomial.
    """
    inverse = np.linalg.inv(_normal(usual, slopes, weights))
    pulls = inverse @ (weights[:, None] * _right(slopes, rest)).T
    known = np.count_nonzero(weights)
    scatter = pulls @ pulls.T * known / max(known - len(inverse), 1)
    share = np.trace(scatter @ np.linalg.inv(inverse)) / len(inverse)
    return inverse * max(share, 1.0)
