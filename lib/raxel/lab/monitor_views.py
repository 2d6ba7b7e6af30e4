"""An active grid photographed: one view, all its patterns, and the point of each pixel.

Rays and intersections are found once for a view; each pattern is then only shaded.
"""

import numpy as np

from raxel.cameras.base import pixel_grid
from raxel.geometry.planes import intersect_rays_plane
from raxel.lab.patterns import MonitorLevel, MonitorPattern, monitor_scene
from raxel.lab.render import trace
from raxel.sets.patterns import BLACK, WHITE, patterns_of

PIXELS_AT_ONCE = 1 << 18


def photograph_patterns(rig, T_camera_target, seed):
    """Yield (WHITE, BLACK or a Pattern, picture) for one pose of the monitor.

    seed: list of whole numbers; each picture has a noise of its own.
    """
    laboratory, response = rig.laboratory(), rig.monitor.radiance
    scene = monitor_scene(rig.target, T_camera_target, **rig.radiances)
    traced = trace(rig.camera, np.eye(4), scene)
    shown = [(WHITE, MonitorLevel(1.0, response)), (BLACK, MonitorLevel(0.0, response))]
    size = rig.target.monitor_px, rig.target.monitor_mm
    for pattern in patterns_of(rig.patterns):
        shown.append((pattern, MonitorPattern(*size, pattern, response)))
    for number, (what, texture) in enumerate(shown):
        rng = np.random.default_rng([*seed, number])
        yield what, laboratory.develop(traced.shade({0: texture}), rng)


def points_seen(camera, T_camera_target, size_mm):
    """Where each pixel's ray meets the monitor, (height, width, 2) mm; NaN beside it.

    T_camera_target: (4, 4); size_mm: (width, height) of the lit area, whose upper left
    corner is the origin.
    """
    points = np.full((camera.height * camera.width, 2), np.nan)
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
