"""The consistent adjustment at pixel density beside plain array arithmetic."""

import time
import tracemalloc
from typing import NamedTuple

import numpy as np

from raxel.calibration import adjust_consistent, linear_well_conditioned
from raxel.calibration.adjust.ray_elimination import moved
from raxel.calibration.adjust.whitening import frozen_whitening, start_directions
from raxel.geometry import intersect_rays_plane, pose, rotation_from_vector
from raxel.geometry.damped import damped_step

CENTRE_MM = np.array([0.0, 0.0, -300.0])
HALF_MM = 200.0
NOISE_RAD = 5e-4
TURNS = [[0.0, 0, 0], [0.35, 0.1, 0], [-0.1, 0.4, 0.2]]
SHIFTS = [[0.0, 0, 0], [20, -10, 60], [-30, 15, 90]]
START = 20_000  # rays of the linear stage


class Adjusted(NamedTuple):
    """Seconds of wall and processor time, bytes a ray with the points, the centre."""

    name: str
    rays: int
    wall: float
    cpu: float
    bytes: float
    centre: np.ndarray


def points_of(rays, rng):
    """Points (3, rays, 2) on three grids before a pinhole, with noise of the image."""
    u = np.column_stack([rng.uniform(-HALF_MM, HALF_MM, (rays, 2)), np.zeros(rays)])
    u -= CENTRE_MM
    grids = pose(rotation_from_vector(TURNS), np.array(SHIFTS))
    return np.stack(
        [
            intersect_rays_plane(CENTRE_MM, _shaken(u, rng), grid).points
            for grid in grids
        ]
    )


def _shaken(u, rng):
    size = NOISE_RAD * np.linalg.norm(u, axis=1, keepdims=True)
    return u + size * rng.standard_normal(u.shape)


def bench_adjusters(rays, rng, plainly=True):
    """[Adjusted, ...] for 3 x rays points, the second run of each counted."""
    points = points_of(rays, rng)
    seen = np.ones(points.shape[:2], bool)
    linear = linear_well_conditioned(points[:, :START])
    start = linear.centre, linear.T_base_grid
    runs = {"raxel": lambda: adjust_consistent(points, seen, *start).centre}
    adjust_consistent(points[:, :100], seen[:, :100], *start)
    if plainly:
        runs["plain numpy"] = lambda: plainly_adjusted(points, seen, *start)[0]
    return [_timed(name, run, points) for name, run in runs.items()]


def _timed(name, run, points):
    wall, cpu = time.perf_counter(), time.process_time()
    centre = run()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1] + points.nbytes
    tracemalloc.stop()
    count = points.shape[1]
    return Adjusted(name, count, wall, cpu, peak / count, centre)


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


def adjusted_table(found):
    """Lines to print: seconds, bytes a ray, and how far the centres are apart."""
    lines = [f"{'adjustment':<14}{'rays':>9}{'s':>8}{'CPU s':>8}{'bytes/ray':>11}"]
    for a in found:
        lines.append(
            f"{a.name:<14}{a.rays:>9}{a.wall:>8.2f}{a.cpu:>8.2f}{a.bytes:>11.0f}"
        )
    if len(found) == 2:
        ours, plain = found
        apart = np.linalg.norm(ours.centre - plain.centre)
        lines.append(
            f"{plain.wall / ours.wall:.1f} times as fast; centres {apart:.1e} mm apart"
        )
    return lines
