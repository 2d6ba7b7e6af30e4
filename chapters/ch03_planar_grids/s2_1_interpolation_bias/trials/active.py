"""An active grid rendered by the simulator, and decoded."""

import numpy as np

from raxel.features.active_grid import decode
from raxel.lab import (
    Laboratory,
    Monitor,
    MonitorPattern,
    Optics,
    Sensor,
    monitor_scene,
    trace,
)
from raxel.lab.monitor_views import points_seen
from raxel.sets import patterns_of, plan_of_cells

LIGHT = Monitor(gamma=2.2, black_level=0.004, falloff_exponent=1.5)
SENSOR = Sensor(white_e=9000.0, full_well_e=12000.0, read_noise_e=15.0, gamma=2.2)
OPTICS = Optics(blur_sd_px=(0.7, 0.7))
SMOOTHED = {"7 x 7": True, "none": False}


def photographed(camera, grid, T_camera_grid, rng):
    """The 20 images (n, H, W) of an active grid, and their patterns."""
    laboratory = Laboratory(camera, SENSOR, OPTICS)
    scene = monitor_scene(grid, T_camera_grid, background=0.05)
    traced = trace(camera, np.eye(4), scene)
    size = grid.monitor_px, grid.monitor_mm
    patterns = patterns_of(plan_of_cells(grid.monitor_px, phase_steps=4))
    shown = [
        traced.shade({0: MonitorPattern(*size, pattern, LIGHT.radiance)})
        for pattern in patterns
    ]
    return np.array([laboratory.develop(s, rng) for s in shown]), patterns


def decoding_errors(camera, grid, T_camera_grid, rng):
    """Error (H, W, 2) mm of each decoded point, by smoothing; NaN if untrusted.

    Also the true point (H, W, 2) mm at the centre of each pixel.
    """
    pictures, patterns = photographed(camera, grid, T_camera_grid, rng)
    seen = points_seen(camera, T_camera_grid, grid.monitor_mm)
    decoded = {
        name: decode(pictures, patterns, grid, smooth=smooth, linear=True, threads=1)
        for name, smooth in SMOOTHED.items()
    }
    return {name: found.location - seen for name, found in decoded.items()}, seen
