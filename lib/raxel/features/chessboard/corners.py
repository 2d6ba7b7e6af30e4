"""Is a lattice's corner a corner, and where exactly?"""

from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.saddles import SMOOTHED_NOISE, remapped

# What the noise of single pixels does to a corner's fit, carried through it exactly.
# The fit of `corners` takes slopes g_k at places x_k of a window, in half windows
# from its middle, and solves A q = sum w_k g_k (g_k . x_k), A = sum w_k g_k g_k^T.
# Slopes that are wrong by n_k move the corner, which is at q = 0, by A^-1 sum w_k
# (g_k (n_k . x_k) + n_k (g_k . x_k)), and n_k are differences of smoothed noise,
# which is alike at places close by: of white noise of variance 1, smoothed by a
# Gaussian of variance s^2, two values d apart have the covariance exp(-d^2 / 4 s^2) /
# (4 pi s^2).


# Variance, px^2, that the interpolation adds to the smoothing: of a cubic B-spline.
BETWEEN_PIXELS = 1 / 3


def influences(g, x, weight, part=1.0):
    """(q, how slopes move it): of the fit to a part of the window's slopes.

    g: (N, K, 2) slopes, K = (2 n + 1)^2 row by row, from which their weighted mean was
    taken off; x: (K, 2); weight, part: (K,). Returned are q (N, 2), in half windows,
    and (N, 2, K, 2): by how much it moves with each slope.
    """
    of = weight * part
    toward = (g * x).sum(axis=2)
    A = np.swapaxes(g * of[:, None], 1, 2) @ g
    A += (1e-9 * np.trace(A, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(2)
    inverse = np.linalg.inv(A)
    right = (of[:, None] * g * toward[..., None]).sum(axis=1)
    moved = of[:, None, None] * (
        g[..., None] * x[:, None, :] + toward[..., None, None] * np.eye(2)
    )
    moved -= (weight / weight.sum())[:, None, None] * moved.sum(axis=1, keepdims=True)
    q = np.einsum("nab,nb->na", inverse, right)
    return q, np.einsum("nab,nkbc->nakc", inverse, moved)


def variances(moved, window, level):
    """Variance (N, M) that pixel noise gives to sums over slopes of a Level.

    moved: (N, M, K, 2) weights of the slopes; window: (N, 2, 2) px, its columns half a
    window in s and t.
    """
    weights = _of_samples(moved)
    size = 2 * weights.shape[-1]
    power = np.abs(np.fft.rfft2(weights, (size, size))) ** 2
    alike = np.fft.irfft2(power, (size, size))
    steps = np.fft.fftfreq(size, 1 / size) * 2 / (weights.shape[-1] - 3)
    apart = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    px = apart @ np.swapaxes(window / level.scale, 1, 2)
    smooth = level.sigma**2 + BETWEEN_PIXELS
    shared = np.exp(-(px**2).sum(axis=2) / (4 * smooth)) / (4 * np.pi * smooth)
    total = (alike.reshape(*alike.shape[:2], -1) @ shared[..., None])[..., 0]
    return level.noise**2 * np.maximum(total, 0)


def _of_samples(moved):
    """Weights (N, M, S, S) of samples, S = 2 n + 3, from those (N, M, K, 2) of slopes.

    A slope is the difference of the samples on its two sides, times n / 2.
    """
    side = round(np.sqrt(moved.shape[2]))
    s, t = np.moveaxis(moved.reshape(*moved.shape[:2], side, side, 2), -1, 0)
    per_half = (side - 1) / 4
    weights = np.zeros((*moved.shape[:2], side + 2, side + 2))
    weights[..., 1:-1, 2:] += per_half * s
    weights[..., 1:-1, :-2] -= per_half * s
    weights[..., 2:, 1:-1] += per_half * t
    weights[..., :-2, 1:-1] -= per_half * t
    return weights


QUADRANT = np.array([0.2, 0.34])
LEAST_EVEN = 0.3
# Half window, as a share of the spacing and in px.
WINDOW, LARGEST_PX = 0.38, 7.0


class Effort(NamedTuple):
    """How finely a window is looked at.

    half: samples from its middle to its side; iterations: how often it is moved at
    most; still: px; a smaller move is the last; wider: how much larger than a window
    the cell's share must be for the next window to be tried.
    """

    half: int
    iterations: int
    still: float
    wider: float


QUICK, FULL = Effort(4, 5, 0.02, 1.67), Effort(7, 12, 1e-3, 1.15)
FARTHEST = 0.3
# Of the window, to each side: the part about a corner, which tells as much as the rest.
NEAR_PART = 0.6
# Of half a window: how far one is moved to see how its corner follows.
ASIDE = 0.1
LEAST_FOLLOWING = 1e-3
# The window that is compared with itself after half a turn: share of the spacing to
# each side, and samples along it.
TURNED, TURNED_SAMPLES = 0.33, 12


class Fields(NamedTuple):
    """The four fields around N corners.

    alternate (N,) bool: dark and bright in turn; sign (N,) of the field between +s and
    +t; contrast (N,): smallest difference of neighbours.
    """

    alternate: np.ndarray
    sign: np.ndarray
    contrast: np.ndarray


class Placed(NamedTuple):
    """Corners put where the edges cross: points (N, 2), sd (N,) px, misfit (N,).

    sd: of the level's noise, as that of `Grid`; apart (N, 2): how far the near and the
    far part of the window disagree, in SDs of that noise, see `_near_and_far`. misfit:
    share of the edges' strength that does not point at the corner; good (N,): whether
    the search ended near its start.
    """

    points: np.ndarray
    sd: np.ndarray
    apart: np.ndarray
    misfit: np.ndarray
    good: np.ndarray


def fields_of(patches, level):
    """Fields around corners, looked at in a Level."""
    a, b = np.meshgrid(QUADRANT, QUADRANT)
    s = np.concatenate([x * a.ravel() for x in (1, -1, -1, 1)])
    t = np.concatenate([y * b.ravel() for y in (1, 1, -1, -1)])
    grey = sampled(level, patches.at(s, t)).reshape(-1, 4, a.size)
    fields = grey.mean(axis=2)
    step = (fields - np.roll(fields, -1, axis=1)) * [1, -1, 1, -1]
    sign = np.sign(step.sum(axis=1))
    step *= sign[:, None]
    least, most = step.min(axis=1), step.max(axis=1)
    return Fields(least > LEAST_EVEN * np.maximum(most, 1e-6), sign, least)


def uneven(patches, level):
    """By how much corners differ from themselves after half a turn, in a Level: (N,).

    The four fields of a corner are the same after half a turn about it, however they
    are blurred; what covers part of it, or an edge of a shadow across it, is not.
    Returned is the root of the share of the odd part in the window, without a slope of
    the light and without what the level's noise explains.
    """
    _, even, odd, _ = _even_and_odd(patches, level, TURNED_SAMPLES)
    noise = SMOOTHED_NOISE * level.noise / np.sqrt(2)
    share = np.maximum((odd**2).mean(axis=1) - noise**2, 0)
    return np.sqrt(share / np.maximum((even**2).mean(axis=1), 1e-6))


def half_turned(patches, level, samples):
    """How far (N,) px corners are from where half a turn says they are, in a Level.

    That is the place about which the window is nearest to even, see `uneven`; samples:
    along it.
    """
    k, even, odd, flat = _even_and_odd(patches, level, samples)
    field = even.reshape(-1, len(k), len(k))
    change = np.gradient(field, k, k, axis=(2, 1))
    change = np.stack([flat(one.reshape(even.shape)) for one in change], axis=2)
    normal = np.swapaxes(change, 1, 2) @ change + 1e-9 * np.eye(2)
    right = -np.swapaxes(change, 1, 2) @ odd[..., None]
    ds, dt = np.linalg.solve(normal, right)[..., 0].T
    return np.linalg.norm(ds[:, None] * patches.u + dt[:, None] * patches.v, axis=1)


def _even_and_odd(patches, level, samples):
    """Places (samples,) along a window, its even and its odd part (N, samples^2).

    Of the even part its mean is taken off, of the odd part a slope of the light, as by
    the function that is returned with them.
    """
    k = np.linspace(-TURNED, TURNED, samples)
    t, s = (a.ravel() for a in np.meshgrid(k, k, indexing="ij"))
    here, turned = (sampled(level, patches.at(a * s, a * t)) for a in (1, -1))
    even, odd = (here + turned) / 2, (here - turned) / 2
    slope = np.column_stack([s, t]) / np.linalg.norm(s)

    def flat(values):
        return values - (values @ slope) @ slope.T

    return k, even - even.mean(axis=1, keepdims=True), flat(odd), flat


def sampled(level, pixels):
    """Grey (N, M) of a Level at image px (N, M, 2); the rim's beyond the image."""
    import cv2

    at = (pixels / level.scale).astype(np.float32)
    u, v = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
    return remapped(level.grey, u, v, cv2.BORDER_REPLICATE)


def placed(patches, level, window_px=LARGEST_PX, effort=FULL):
    """Corners where the edges of their patches cross: `Placed`.

    In the window every gradient should be across the line to the corner: the corner
    minimises the sum of (g . (x - q))^2, iterated until it stays. The mean of the
    gradients is taken off them first: about a corner it vanishes, so what is there is
    the slope of the light, or blur that is not even, and pulls the corner aside. The
    standard deviation is that of the level's noise carried through this fit.
    """
    size = np.stack([np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)], axis=1)
    window = window_px * level.scale
    half = np.minimum(WINDOW, window / np.maximum(size, 1e-6))
    k = np.arange(-effort.half, effort.half + 1) / effort.half
    b, a = np.meshgrid(k, k, indexing="ij")
    x = np.stack([a.ravel(), b.ravel()], axis=1).astype(np.float32)
    weight = np.exp(-(x**2).sum(axis=1) / (2 * 0.6**2))
    start = patches.p
    now, active = patches, np.arange(len(start))
    points = start.copy()
    gradients = np.zeros((len(start), len(x), 2), np.float32)
    for _ in range(effort.iterations):
        local = now.of(active)
        g = _slopes(level, local, half[active], weight, effort.half)
        gradients[active] = g
        shift = _solved(g, x, weight) * half[active]
        shift = np.clip(shift, -FARTHEST, FARTHEST)
        move = shift[:, :1] * local.u + shift[:, 1:] * local.v
        points[active] += move
        now = now._replace(p=points)
        active = active[np.linalg.norm(move, axis=1) > effort.still]
        if not len(active):
            break
    window = np.stack([half[:, :1] * patches.u, half[:, 1:] * patches.v], axis=2)
    follows = _follows(level, now, half, x, weight, effort.half)
    sd = _sd_of_noise(gradients, x, weight, window, follows, level)
    apart = _near_and_far(gradients, x, weight, window, level)
    misfit = _misfit(gradients, x, weight)
    away = np.linalg.norm(points - start, axis=1) / np.maximum(patches.size, 1e-6)
    return Placed(points, sd, apart, misfit, away < FARTHEST)


def _slopes(level, patches, half, weight, samples):
    """Slopes (N, K, 2) in windows, per half window, without their mean."""
    from raxel.features.chessboard.compiled import slopes_in_windows

    g = slopes_in_windows(level.grey, level.scale, patches, half, samples)
    return g - (weight[:, None] * g).sum(axis=1, keepdims=True) / weight.sum()


def _follows(level, patches, half, x, weight, samples):
    """By how much q falls where the window is moved on, (N, 2, 2), about 1.

    A window in the middle of its corner sees the four fields evenly; beside it, what it
    takes in and what it leaves out move q as well.
    """
    change = np.empty((len(half), 2, 2))
    for axis, along in enumerate((patches.u, patches.v)):
        aside = ASIDE * half[:, axis : axis + 1] * along
        g = _slopes(level, patches.moved(aside), half, weight, samples)
        change[..., axis] = -_solved(g, x, weight) / ASIDE
    return change


def _solved(g, x, weight):
    """q (N, 2) that minimises sum w (g . (x - q))^2."""
    A, rhs = _normal(g, x, weight)
    det = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] ** 2
    det = np.where(det > 1e-12, det, np.inf)
    return np.stack(
        [
            (A[:, 1, 1] * rhs[:, 0] - A[:, 0, 1] * rhs[:, 1]) / det,
            (A[:, 0, 0] * rhs[:, 1] - A[:, 0, 1] * rhs[:, 0]) / det,
        ],
        axis=1,
    )


def _normal(g, x, weight):
    wg = g * weight[:, None]
    A = np.swapaxes(wg, 1, 2) @ g
    toward = (g * x).sum(axis=2)
    return A, (wg * toward[..., None]).sum(axis=1)


def _sd_of_noise(g, x, weight, window, follows, level):
    """SD (N,) px that the level's noise gives to corners; window: see `variances`.

    Infinite where no window follows its corner.
    """
    _, moved = influences(g, x, weight)
    some = np.linalg.det(follows) > LEAST_FOLLOWING
    px = window @ np.linalg.inv(np.where(some[:, None, None], follows, np.eye(2)))
    in_px = np.einsum("nab,nbkc->nakc", px, moved)
    variance = variances(in_px, window, level).mean(axis=1)
    return np.where(some, np.sqrt(variance), np.inf)


def _near_and_far(g, x, weight, window, level):
    """How far two parts of a window disagree about a corner, (N, 2): across u and v.

    In SDs of what the level's noise alone would make of it. The near and the far part
    of the edges say independently of each other where the corner is. Whatever is the
    same after half a turn about it (blur, motion, thick ink, clipped whites, edges
    that cross at a sharp angle) moves neither.
    """
    near = np.abs(x).max(axis=1) <= NEAR_PART
    (here, moved), (there, also) = (
        influences(g, x, weight, part) for part in (near, ~near)
    )
    return (here - there) / np.sqrt(variances(moved - also, window, level) + 1e-12)


def _misfit(g, x, weight):
    """Share (N,) of the edges' strength that does not point at the corner."""
    off = (g * x).sum(axis=2)
    length = np.sqrt((g**2).sum(axis=2) * (x**2).sum(axis=1))
    total = np.maximum((weight * length**2).sum(axis=1), 1e-9)
    return (weight * off**2).sum(axis=1) / total
