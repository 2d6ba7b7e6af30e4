"""What the library is measured against: plain code with OpenCV, numpy and scipy.

The plain decoder does what the decoder does in the easiest case: cell, place after
7 x 7, sigma and a mask, on a Gray code with inverse and one cell a period.
"""

import cv2
import numpy as np
from scipy.optimize import least_squares

from raxel.calibration import RayPoints, clamped, normalised
from raxel.calibration.adjust.bundle import frozen_whitening, start_directions
from raxel.calibration.adjust.ray_elimination import moved
from raxel.calibration.linear.cgsp import centre_of, scaled
from raxel.geometry import apply_homography, normalising
from raxel.geometry.least_squares import damped_step
from raxel.sets.patterns import cell_width

MIN_CONTRAST, MIN_MODULATION = 7, 5  # standard deviations, as in the decoder
WINDOW = 7


def read_plan(patterns, monitor_px):
    """Of each axis: [(picture, inverse), ...], [pictures of the steps], cell in px."""
    axes = []
    for axis in "xy":
        own = [(p, k) for k, p in enumerate(patterns) if p.axis == axis]
        bits = {(p.bit, p.inverse): k for p, k in own if p.kind == "gray"}
        pairs = [(bits[b, False], bits[b, True]) for b in range(len(bits) // 2)]
        steps = [k for _, k in sorted((p.step, k) for p, k in own if p.kind == "phase")]
        gray = next(p for p, _ in own if p.kind == "gray")
        axes.append((pairs, steps, cell_width(gray, monitor_px)))
    return axes


def with_opencv(images, axes, noise):
    """Return location, sigma (A, H, W) float32 and mask (H, W) of an active grid."""
    mask = np.full(images[0].shape, 255, np.uint8)
    location, sigma = (np.empty((2, *mask.shape), np.float32) for _ in range(2))
    for axis, (pairs, steps, cell) in enumerate(axes):
        value = np.zeros(mask.shape, np.uint8)
        code = np.zeros(mask.shape, np.uint8)
        for k, (picture, inverse) in enumerate(pairs):
            bit = cv2.compare(images[picture], images[inverse], cv2.CMP_GT)
            cv2.bitwise_xor(value, bit, value)
            cv2.bitwise_and(value, 1 << (len(pairs) - 1 - k), bit)
            cv2.bitwise_or(code, bit, code)
        contrast = cv2.absdiff(images[pairs[0][0]], images[pairs[0][1]])
        seen = cv2.compare(contrast, MIN_CONTRAST * noise, cv2.CMP_GT)
        cv2.bitwise_and(mask, seen, mask)
        sine, cosine = (
            cv2.boxFilter(_weighed(images, used), -1, (WINDOW, WINDOW))
            for used in _weighed_steps(steps)
        )
        modulation, angle = cv2.cartToPolar(cosine, sine)
        least = MIN_MODULATION * np.sqrt(2 / len(steps)) * noise
        cv2.bitwise_and(mask, cv2.compare(modulation, least, cv2.CMP_GT), mask)
        share = cell / (2 * np.pi)
        cv2.addWeighted(code, cell, angle, share, 0, location[axis], cv2.CV_32F)
        cv2.divide(float(_sigma(len(steps), cell, noise)), modulation, sigma[axis])
    return location, sigma, mask > 0


def _weighed(images, used):
    if len(used) == 2:
        (p, a), (q, b) = used
        return cv2.addWeighted(
            images[a], float(p), images[b], float(q), 0, dtype=cv2.CV_32F
        )
    total = np.zeros(images[0].shape, np.float32)
    for weight, k in used:
        cv2.addWeighted(total, 1, images[k], float(weight), 0, total, cv2.CV_32F)
    return total


def _weighed_steps(steps):
    """[(weight, picture), ...] of sine and cosine, those that count."""
    angle = 2 * np.pi * np.arange(len(steps)) / len(steps)
    waves = np.array([np.cos(angle), np.sin(angle)])
    weights = np.round(2 / len(steps) * waves, 12).astype(np.float32)
    return [[(w, k) for w, k in zip(row, steps, strict=True) if w] for row in weights]


def _sigma(count, cell, noise):
    return np.float32(cell * np.sqrt(2 / count) * noise / (2 * np.pi * WINDOW))


def fringes_decoder(count, size):
    """decode(threads) of the package, on patterns of its own; None where it is not.

    count: of images, for both axes with two numbers of periods; size: (width,
    height). It reads no Gray code: it tells periods apart by a second sine.
    """
    try:
        from fringes import Fringes
    except ImportError:
        return None
    package = Fringes()
    package.X, package.Y = size
    package.K, package.N, package.v = 2, max(3, count // 4), [8, 1]
    pictures = package.encode()
    return lambda threads: package.decode(pictures, threads=threads).x


def plain_homography(source, target):
    """The normalised DLT as one writes it with arrays: all rows, then A^T A."""
    T_s, T_t = normalising(source), normalising(target)
    s = np.pad(apply_homography(T_s, source), ((0, 0), (0, 1)), constant_values=1.0)
    t = apply_homography(T_t, target)
    zero = np.zeros_like(s)
    A = np.block([[s, zero, -t[:, :1] * s], [zero, s, -t[:, 1:] * s]])
    h = np.linalg.eigh(A.T @ A)[1][:, 0]
    return np.linalg.solve(T_t, h.reshape(3, 3) @ T_s)


def centre_by(homography, points):
    """The centre (3,) from two homographies of `homography`, normalised as usual."""
    base = normalising(points[0])
    found = [
        base @ homography(own, points[0]) @ np.linalg.inv(normalising(own))
        for own in points[1:]
    ]
    centre = centre_of(scaled(np.stack(found)), 0.0, side=1)[0]
    return (centre - [*base[:2, 2], 0.0]) / base[0, 0]


def plainly_adjusted(points, seen, centre, T, rounds=2, passes=4):
    """Centre and poses by the same equations, each a line of array arithmetic."""
    u = start_directions(points, seen, centre, T)
    for _ in range(rounds):
        whitening = frozen_whitening(seen, u, centre, T).astype(float)
        for _ in range(passes):
            u = _settled(points, whitening, u, centre, T)
            own, rows = _jacobians(points, whitening, u, centre, T)
            V = np.swapaxes(own, 1, 2) @ own
            cross = np.swapaxes(own, 1, 2) @ rows
            flat = rows.reshape(-1, rows.shape[2])
            both = flat.T @ flat - np.einsum(
                "nap,naq->pq", cross, np.linalg.solve(V, cross), optimize=True
            )
            centre, T = moved(centre, T, damped_step(both[:-1, :-1], both[:-1, -1], 0))
    return centre, T


def _settled(points, whitening, u, centre, T):
    own, rows = _jacobians(points, whitening, u, centre, T)
    V = np.swapaxes(own, 1, 2) @ own
    pull = np.swapaxes(own, 1, 2) @ rows[..., -1:]
    u = u.copy()
    u[:, :2] -= np.linalg.solve(V, pull)[..., 0]
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def _jacobians(points, whitening, u, centre, T):
    """(N, 2 n, 2) by u_x and u_y, and (N, 2 n, 6 n - 3 + 1) with the residual last."""
    grids, count = points.shape[:2]
    own = np.empty((count, 2 * grids, 2))
    rows = np.zeros((count, 2 * grids, 6 * grids - 2))
    for j in range(grids):
        R = T[j, :3, :3]
        d, c = u @ R, (centre - T[j, :3, 3]) @ R
        m = d[:, :2] / d[:, 2:]
        q = c[:2] - c[2] * m
        W = np.zeros((count, 2, 2))
        W[:, 0, 0], W[:, 0, 1], W[:, 1, 1] = whitening[j].T
        A = np.concatenate([np.tile(np.eye(2), (count, 1, 1)), -m[..., None]], axis=2)
        E = W @ A
        part = slice(2 * j, 2 * j + 2)
        own[:, part] = (-c[2] / d[:, 2])[:, None, None] * (E @ R.T)[..., :2]
        at = 6 * j
        rows[:, part, at : at + 3] = E
        rows[:, part, -1] = (W @ (q - points[j])[..., None])[..., 0]
        if j:
            x, y = q.T
            rows[:, part, at - 3] = -y[:, None] * E[..., 2]
            rows[:, part, at - 2] = x[:, None] * E[..., 2]
            rows[:, part, at - 1] = y[:, None] * E[..., 0] - x[:, None] * E[..., 1]
    return own, rows


def plain_shape(start, pixels, points, clamp):
    """Coefficients (K,) of a shape from points (N, 3), by the general solver."""
    grid, p = start.grid, normalised(start.viewer, pixels)
    used = grid.inside(p)
    rays, space = RayPoints(p[used], grid, start.quantity), clamped(grid, clamp)
    points = points[used]

    def jacobian(free):
        rows = rays.jacobian(space.coefficients(free), points)
        return rows.reshape(-1, grid.size) @ space.directions

    found = least_squares(
        lambda free: rays.residuals(space.coefficients(free), points).ravel(),
        space.free(start.coefficients.ravel("F")),
        jacobian,
        x_scale="jac",
    )
    return space.coefficients(found.x)
