"""Is a lattice's corner a corner, and where exactly?"""

from typing import NamedTuple

import numpy as np

from raxel.features.find.ring import SMOOTHED_NOISE, remapped

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

    sd: from the level's noise; halves (N, 2, 2) px: how far opposite edges are apart,
    see `_halves`. misfit: share of the edges' strength that does not point at the
    corner; good (N,): whether the search ended near its start.
    """

    points: np.ndarray
    sd: np.ndarray
    halves: np.ndarray
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


def half_turned(patches, level):
    """Corners beside themselves after half a turn, in a Level: (uneven, shift) (N,).

    The four fields of a corner are the same after half a turn about it, however they
    are blurred; what covers part of it, or an edge of a shadow across it, is not.
    uneven: root of the share of the odd part in the window, without a slope of the
    light and without what the level's noise explains; shift: px from the corner to the
    place about which the window is nearest to even.
    """
    k = np.linspace(-TURNED, TURNED, TURNED_SAMPLES)
    t, s = (a.ravel() for a in np.meshgrid(k, k, indexing="ij"))
    here, turned = (sampled(level, patches.at(a * s, a * t)) for a in (1, -1))
    even, odd = (here + turned) / 2, (here - turned) / 2
    even = even - even.mean(axis=1, keepdims=True)
    slope = np.column_stack([s, t])
    level_light = np.eye(len(s)) - slope @ np.linalg.inv(slope.T @ slope) @ slope.T
    odd = odd @ level_light
    noise = SMOOTHED_NOISE * level.noise / np.sqrt(2)
    share = np.maximum((odd**2).mean(axis=1) - noise**2, 0)
    share = share / np.maximum((even**2).mean(axis=1), 1e-6)
    field = even.reshape(-1, TURNED_SAMPLES, TURNED_SAMPLES)
    change = np.stack(np.gradient(field, k, k, axis=(2, 1)), axis=3)
    change = level_light @ change.reshape(*even.shape, 2)
    normal = np.swapaxes(change, 1, 2) @ change + 1e-9 * np.eye(2)
    right = -np.swapaxes(change, 1, 2) @ odd[..., None]
    ds, dt = np.linalg.solve(normal, right)[..., 0].T
    shift = ds[:, None] * patches.u + dt[:, None] * patches.v
    return np.sqrt(share), np.linalg.norm(shift, axis=1)


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
    from raxel.features.find.compiled import slopes_in_windows

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
        g = slopes_in_windows(level.grey, level.scale, local, half[active], effort.half)
        g -= (weight[:, None] * g).sum(axis=1, keepdims=True) / weight.sum()
        gradients[active] = g
        shift = _solved(g, x, weight) * half[active]
        shift = np.clip(shift, -FARTHEST, FARTHEST)
        move = shift[:, :1] * local.u + shift[:, 1:] * local.v
        points[active] += move
        now = now._replace(p=points)
        active = active[np.linalg.norm(move, axis=1) > effort.still]
        if not len(active):
            break
    sd, misfit = _quality(gradients, x, weight, half, patches, level, effort.half)
    halves = _halves(gradients, x, weight, half, patches)
    away = np.linalg.norm(points - start, axis=1) / np.maximum(patches.size, 1e-6)
    return Placed(points, sd, halves, misfit, away < FARTHEST)


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


def _halves(g, x, weight, half, patches):
    """How far opposite edges are apart, halved, (N, 2, 2) px: in rising columns, rows.

    Two opposite edges say independently of each other where the corner lies across
    them; the corner is in the middle, and moves by this vector when one is left out.
    """
    mine = np.abs(x[:, :1]) > np.abs(x[:, 1:])
    halves = []
    for axis, across in ((1, patches.u), (0, patches.v)):
        arm = (mine[:, 0] == (axis == 0)) * np.sign(x[:, axis])
        moved = [_solved(g, x, weight * (arm != side)) for side in (1, -1)]
        half_apart = (half * (moved[0] - moved[1]) / 2)[:, 1 - axis]
        halves.append(half_apart[:, None] * across)
    return np.stack(halves, axis=1)


def _quality(g, x, weight, half, patches, level, samples):
    """(sd (N,) px, misfit (N,)) of corners whose windows are centred on them."""
    A, _ = _normal(g, x, weight)
    off = (g * x).sum(axis=2)
    length = np.sqrt((g**2).sum(axis=2) * (x**2).sum(axis=1))
    total = np.maximum((weight * length**2).sum(axis=1), 1e-9)
    misfit = (weight * off**2).sum(axis=1) / total
    J = np.stack([half[:, :1] * patches.u, half[:, 1:] * patches.v], axis=2)
    reach = ((x @ np.swapaxes(J, 1, 2)) ** 2).sum(axis=2)
    # Of white noise smoothed by sigma: SD of a derivative, and the area in px^2 over
    # which it stays alike.
    slope = level.noise / (np.sqrt(8 * np.pi) * level.sigma**2) / level.scale
    area = 4 * np.pi * level.sigma**2
    wg = g * (weight**2 * reach)[..., None]
    B = slope**2 * (np.swapaxes(wg, 1, 2) @ g)
    cell = np.abs(np.linalg.det(J)) / samples**2 / level.scale**2
    alike = np.maximum(1, area / np.maximum(cell, 1e-9))
    A = (
        A
        + 1e-9 * np.trace(A, axis1=1, axis2=2)[:, None, None] * np.eye(2)
        + 1e-12 * (np.eye(2))
    )
    inverse = np.linalg.inv(A)
    covariance = J @ inverse @ B @ inverse @ np.swapaxes(J, 1, 2)
    largest = np.linalg.eigvalsh(covariance)[:, 1] * alike
    return np.sqrt(np.maximum(largest, 0)), misfit
