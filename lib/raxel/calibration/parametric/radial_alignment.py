"""A start for any lens with an axis: poses of boards without a lens formula.

Whatever a lens does along the radius, it leaves the azimuth alone: seen from the point
c where the axis meets the image, a corner (u, v) lies in the direction of its board
point's offset (x, y) across the axis,

    (u - c_u) y = (v - c_v) x,   x = h1 . (X, Y, 1),   y = h2 . (X, Y, 1).

For each board that is linear in h1, h2: its pose but for the depth. It holds for angles
beyond 90 degrees, for mirrors, and where the entrance pupil moves along the axis. The
depths, and which of the two mirrored tilts is the right one, follow with the first
guess of a law: r = F theta of fisheyes, or r = F tan theta of lenses that keep lines
straight. F is searched for, and so is c. A law that bends the other way than the lens
takes tilts for their mirror images, from which no fit comes back: both are tried.

Source of the constraint: R. Y. Tsai, IEEE J. Robotics and Automation 3(4), 1987,
doi:10.1109/JRA.1987.1087109.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from raxel.geometry.poses import pose

CENTRES = 21  # tried each way, over the middle of the image
SPREAD = 0.6  # of the image's sides, in which they lie
ROUNDS = 5  # of reweighting against wrong corners
NARROWEST, LENGTHS = 0.08, 25  # radians at the rim, and how many up to the widest


class StartLaw(NamedTuple):
    """angle: r / F -> theta; radius: back; turned: how much r / F moves with theta;
    widest: radians at the rim; k1: of r = F theta (1 + k1 theta^2), near the axis."""

    angle: Callable
    radius: Callable
    turned: Callable
    widest: float
    k1: float


LAWS = (
    StartLaw(lambda x: x, lambda theta: theta, np.ones_like, 3.05, 0.0),
    StartLaw(np.arctan, np.tan, lambda x: 1 + x**2, 1.3, 1 / 3),
)


class AlignedStart(NamedTuple):
    """centre (2,) px, where the axis meets the image; focal_px and k1, of
    r = F theta (1 + k1 theta^2); T_camera_grid (n, 4, 4)."""

    centre: np.ndarray
    focal_px: float
    k1: float
    T_camera_grid: np.ndarray


def aligned_starts(pixels, points, seen, width, height):
    """AlignedStarts to choose from, of either law, about the image's middle and about
    the centre that fits best.

    pixels: (n, M, 2), points: (n, M, 2) on n boards; seen: (n, M) bool.
    """
    middle = (np.array([width, height]) - 1) / 2
    return [
        _started(law, pixels, points, seen, centre)
        for centre in (middle, _best_centre(pixels, points, seen, width, height))
        for law in LAWS
    ]


def _best_centre(pixels, points, seen, width, height):
    """The centre about which boards align best: a search over a grid, then a finer."""
    middle = (np.array([width, height]) - 1) / 2
    size = np.array([width, height], float)
    moments = _moments(pixels - middle, *_normalised(points, seen), seen, size.max())
    best, reach = np.zeros(2), SPREAD * size / 2 / size.max()
    for _ in range(3):
        ends = np.linspace(-1, 1, CENTRES)
        tried = best + np.stack(np.meshgrid(ends, ends), -1).reshape(-1, 2) * reach
        best = tried[np.argmin([_misalignment(moments, c) for c in tried])]
        reach = 2 * reach / (CENTRES - 1)
    return middle + best * size.max()


def _moments(offsets, flat, _, seen, size):
    """(n, 6, 6, 6): products of the rows' parts without c, with c_u and with c_v."""
    u, v = np.where(seen[..., None], offsets / size, 0.0).transpose(2, 0, 1)
    flat = np.where(seen[..., None], flat, 0.0)
    zero = np.zeros_like(flat)
    parts = np.stack(
        [
            np.concatenate([-v[..., None] * flat, u[..., None] * flat], axis=2),
            np.concatenate([zero, -flat], axis=2),
            np.concatenate([flat, zero], axis=2),
        ]
    )
    return np.einsum("anmi,bnmj->abnij", parts, parts)


def _misalignment(moments, c):
    """Sum over boards of the least squared residual of unit vectors (h1, h2)."""
    weights = np.array([1.0, *c])
    normal = np.einsum("a,b,abnij->nij", weights, weights, moments)
    return np.sum(np.linalg.eigvalsh(normal)[:, 0])


def _started(law, pixels, points, seen, centre):
    offsets = np.where(seen[..., None], pixels - centre, 0.0)
    radius = np.linalg.norm(offsets, axis=2)
    h1, h2 = _aligned(offsets, points, seen)
    rims = np.geomspace(law.widest, NARROWEST, LENGTHS)
    lengths = radius.max() / law.radius(rims)
    rotations, shifts = _two_tilts(h1, h2)
    fits = [_depths(law, rotations, shifts, points, seen, radius, f) for f in lengths]
    best = int(np.argmin([cost.sum() for _, _, cost in fits]))
    sign, depth, _ = fits[best]
    rows = np.arange(len(points))
    return AlignedStart(
        np.asarray(centre, float),
        float(lengths[best]),
        law.k1,
        pose(rotations[sign, rows], np.column_stack([shifts, depth])),
    )


def _normalised(points, seen):
    """(X, Y, 1) (n, M, 3) about each board's middle, in units of its size, and the
    matrices (n, 3, 3) that make them of points."""
    count = seen.sum(axis=1)[:, None]
    inside = np.where(seen[..., None], points, 0.0)
    middle = inside.sum(axis=1) / count
    offset = np.where(seen[..., None], points - middle[:, None], 0.0)
    size = np.sqrt((offset**2).sum(axis=(1, 2)) / count[:, 0])
    matrix = np.zeros((len(points), 3, 3))
    matrix[:, [0, 1], [0, 1]] = 1 / size[:, None]
    matrix[:, :2, 2] = -middle / size[:, None]
    matrix[:, 2, 2] = 1.0
    flat = np.concatenate([offset / size[:, None, None], np.ones((*seen.shape, 1))], 2)
    return flat, matrix


def _aligned(offsets, points, seen):
    """h1, h2 (n, 3) of every board, reweighted by the distances across the radius."""
    flat, matrix = _normalised(points, seen)
    weights = seen.astype(float)
    for _ in range(ROUNDS):
        rows = np.concatenate([-offsets[..., 1:] * flat, offsets[..., :1] * flat], 2)
        normal = np.einsum("nmi,nm,nmj->nij", rows, weights, rows)
        h = np.linalg.eigh(normal)[1][:, :, 0].reshape(-1, 2, 3)
        across = np.einsum("nij,nmj->nmi", h, flat)
        length = np.maximum(np.linalg.norm(across, axis=2), 1e-12)
        miss = np.einsum("nmi,ni->nm", rows, h.reshape(-1, 6)) / length
        scale = 1.4826 * np.median(np.abs(miss[seen])) + 1e-12
        weights = seen / (1 + (miss / (3 * scale)) ** 2) / length**2
        weights /= weights.max(axis=1, keepdims=True)
    outward = np.einsum("nmi,nmi,nm->n", across, offsets, weights)
    h = (h * np.sign(outward)[:, None, None]) @ matrix
    return h[:, 0], h[:, 1]


def _two_tilts(h1, h2):
    """Rotations (2, n, 3, 3), tilted one way and the other, and shifts (n, 2).

    The third components w of the rotation's first columns complete them to unit length:
    with M = [h1; h2] over the columns, M^T M = s^2 (I - w w^T).
    """
    M = np.stack([h1[:, :2], h2[:, :2]], axis=1)
    _, s, Vt = np.linalg.svd(M)
    w = np.sqrt(np.maximum(1 - (s[:, 1] / s[:, 0]) ** 2, 0))[:, None] * Vt[:, 1]
    top = M / s[:, :1, None]
    rotations = []
    for third in (w, -w):
        pair = np.concatenate([top, third[:, None]], axis=1)
        last = np.cross(pair[..., 0], pair[..., 1])
        rotations.append(np.concatenate([pair, last[..., None]], axis=2))
    return np.stack(rotations), np.stack([h1[:, 2], h2[:, 2]], axis=1) / s[:, :1]


def _depths(law, rotations, shifts, points, seen, radius, focal_px):
    """For a law and F: tilt (n,) 0 or 1, depth (n,), and cost (n,) px^2 (robust)."""
    theta = np.clip(law.angle(radius / focal_px), 1e-6, np.pi - 1e-3)
    across = np.einsum("nij,nmj->nmi", rotations[0, :, :2, :2], points)
    rho = np.linalg.norm(across + shifts[:, None], axis=2)
    tilted = np.einsum("knj,nmj->knm", rotations[:, :, 2, :2], points)
    gap = rho / np.tan(theta) - tilted  # the depth that each point asks for
    # How much r / F moves with the depth.
    turn = np.where(seen, np.sin(theta) ** 2 / np.maximum(rho, 1e-12), 0.0)
    turn = turn * law.turned(radius / focal_px)
    weights = np.broadcast_to(turn**2, gap.shape)
    for _ in range(ROUNDS):
        depth = np.sum(weights * gap, 2) / np.maximum(np.sum(weights, 2), 1e-300)
        miss = focal_px * turn * (gap - depth[..., None])
        scale = 1.4826 * np.median(np.abs(miss[:, seen])) + 1e-12
        weights = turn**2 / (1 + (miss / (3 * scale)) ** 2)
    # Beyond a tenth of the image's radius all misses are alike.
    limit = (radius.max() / 10) ** 2
    cost = np.sum(np.where(seen, miss**2 / (1 + miss**2 / limit), 0.0), axis=2)
    tilt = np.argmin(cost, axis=0)
    rows = np.arange(len(points))
    return tilt, depth[tilt, rows], cost[tilt, rows]
