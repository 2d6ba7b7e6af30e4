"""An active grid photographed: one view, all its patterns, and the point of each pixel.

Rays and intersections are found once for a view; each pattern is then only shaded.
"""

import numpy as np

from raxel.cameras.core.smooth_rays import smooth_rays
from raxel.geometry.planes import intersect_rays_plane
from raxel.lab.monitor_sight import MonitorSight
from raxel.lab.patterns import MonitorBoard, monitor_scene
from raxel.sets.patterns import BLACK, WHITE, patterns_of

PIXELS_AT_ONCE = 1 << 16
# Smooth rays are closer to a camera's own than this share of the monitor.
NEAR = 1e-3
# Stream of random numbers of the chessboard, behind those of any patterns.
BOARD = 1 << 16


def photograph_patterns(rig, T_camera_target, seed):
    """Yield (WHITE, BLACK or a Pattern, picture) for one pose of the monitor.

    seed: list of whole numbers; each picture has a noise of its own.
    """
    laboratory, sight = rig.laboratory(), MonitorSight(rig, T_camera_target)
    shown = [WHITE, BLACK, *patterns_of(rig.patterns)]
    for number, what in enumerate(shown):
        rng = np.random.default_rng([*seed, number])
        if isinstance(what, str):
            radiance = sight.level(float(what == WHITE))
        else:
            radiance = sight.pattern(what)
        yield what, laboratory.develop(radiance, rng)


def photograph_chessboard(rig, T_camera_target, seed):
    """The picture of the chessboard that the rig's monitor shows in the same pose."""
    target, size = rig.target, (rig.target.monitor_px, rig.target.monitor_mm)
    board = MonitorBoard(*size, target.chessboard, rig.monitor.radiance)
    scene = monitor_scene(target, T_camera_target, board, **rig.radiances)
    rng = np.random.default_rng([*seed, BOARD])
    return rig.laboratory().photograph(scene, np.eye(4), rng)


def points_seen(camera, T_camera_target, size_mm):
    """Where each pixel's ray meets the monitor, (height, width, 2) mm; NaN beside it.

    T_camera_target: (4, 4); size_mm: (width, height) of the lit area, whose upper left
    corner is the origin. Smooth rays tell which pixels come near it; what these see is
    told by the camera's own.
    """
    points = np.full((camera.height, camera.width, 2), np.nan, np.float32)
    size, smooth = np.array(size_mm, float), smooth_rays(camera)
    u, step = np.arange(float(camera.width)), max(1, PIXELS_AT_ONCE // camera.width)
    for first in range(0, camera.height, step):
        v = np.arange(first, min(first + step, camera.height), dtype=float)
        rays = smooth.grid(u, v)
        _, near = _met(rays, T_camera_target, size, NEAR * size.max())
        near = np.flatnonzero(near)
        exact = smooth.exact_on_grid(u, v, rays, near)
        met, on = _met(exact, T_camera_target, size, 0.0)
        points[first : first + step].reshape(-1, 2)[near[on]] = met[on]
    return points


def _met(rays, T_camera_target, size, beyond):
    """Points (N, 2) mm of the monitor's plane that rays meet, and which (N,) of them
    lie on its face, or as far as `beyond` mm beside it."""
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_target)
    with np.errstate(invalid="ignore"):
        within = (met.points >= -beyond) & (met.points <= size + beyond)
    facing = rays.directions @ T_camera_target[:3, 2] > 0
    return met.points, within.all(axis=1) & facing & met.valid & rays.valid
