"""Processor time of a bending mirror's calibration: a stage, a film, all stages."""

import time

import numpy as np

from raxel.calibration import (
    MirrorSettings,
    MirrorTracker,
    clamp_of_camera,
    update_mirror,
)
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from tests.bent_mirror_scenes import (
    GRID,
    bent,
    edge_pixels,
    grid_pose,
    seen,
    spline_like,
    visible_pixels,
)

SETTINGS = MirrorSettings(prior_sd=0.1)
# Milliseconds that the issue of chapter 5 asks for, on one core.
WANTED = {
    "stage, nothing known": 10.0,
    "stage, grid pose nearly known": 10.0,
    "next picture of a film": 3.0,
}


def bench_mirrors(repeats=25):
    """(features, {what: milliseconds, the median}) of one core."""
    rng, T = np.random.default_rng(0), grid_pose()
    flat = spline_like(bent(0.0), 0.0)
    clamp = clamp_of_camera(flat, edge_pixels())
    before, after = seen(bent(0.0), T, rng), seen(bent(5.0), T, rng)
    film = [seen(bent(deflection), T, rng) for deflection in (5.1, 5.2)]
    outline = visible_pixels(5.0, 2, 2)

    def stage(start_pose=None):
        return update_mirror(
            flat, before, after, GRID, clamp, SETTINGS, outline=outline,
            start_pose=start_pose,
        )  # fmt: skip

    found = stage()
    placed = transform(found.pose.T_camera_grid, on_plane(GRID))
    tracker = MirrorTracker(found.camera, placed, clamp, SETTINGS)

    def film_step():
        film.reverse()
        tracker.follow(film[0])

    ways = (stage, lambda: stage(found.pose.T_camera_grid), film_step)
    taken = [_median_ms(way, repeats) for way in ways]
    return int(found.used.sum()), dict(zip(WANTED, taken, strict=True))


def mirrors_table(features, taken):
    """Lines of text."""
    lines = [f"{features} features, 21 coefficients; ms of one core, asked for"]
    return lines + [
        f"{what:<32}{ms:8.2f}{WANTED[what]:8.0f}" for what, ms in taken.items()
    ]


def _median_ms(work, repeats):
    work()
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return 1000 * float(np.median(taken))
