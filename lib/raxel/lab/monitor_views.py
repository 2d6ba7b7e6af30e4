"""An active grid photographed: one view, all its patterns, and the point of each pixel.

Rays and intersections are found once for a view; each pattern is then only shaded.
"""

import numpy as np

from raxel.cameras.core.base import pixel_grid
from raxel.geometry.planes import intersect_rays_plane
from raxel.lab.monitor_sight import MonitorSight
from raxel.lab.patterns import MonitorBoard, monitor_scene
from raxel.sets.patterns import BLACK, WHITE, patterns_of

PIXELS_AT_ONCE = 1 << 18
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
    corner is the origin.
    """
    points = np.full((camera.height * camera.width, 2), np.nan, np.float32)
    pixels = pixel_grid(camera.width, camera.height)
    for first in range(0, len(pixels), PIXELS_AT_ONCE):
        part = slice(first, first + PIXELS_AT_ONCE)
        rays = camera.rays(pixels[part])
        met = intersect_rays_plane(rays.origins, rays.directions, T_camera_target)
        with np.errstate(invalid="ignore"):
            on = np.all((met[0] >= 0) & (met[0] <= size_mm), axis=1)
        facing = rays.directions @ T_camera_target[:3, 2] > 0
        seen = on & facing & met[2] & rays.valid
        points[part][seen] = met[0][seen]
    return points.reshape(camera.height, camera.width, 2)
