"""Decodable share of a rotated monitor."""

from dataclasses import replace

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    patterns_taken,
)
from chapters.shared.rigs import rig_named
from raxel.features.active_grid import REASONS, decode
from raxel.geometry import pose, rotation_from_vector
from raxel.lab.monitor_views import points_seen

RIG = "monitor-d200-small"
FILES = ("data/rigs/monitor-d200-small.yaml",)
TURNS_DEG = {"quick": (0, 60), "full": (0, 14, 28, 42, 56, 70)}
# Exponent of the cosine fall-off, gamma of the camera, number of seeds. The first is
# the rig's.
VARIED = {
    "quick": ((2, 2.2, 1), (0, 2.2, 1), (2, 1.0, 1)),
    "full": ((2, 2.2, 3), (2, 1.0, 3), (0, 2.2, 3)),
}
DISTANCE_MM = 200
SHIFT_MM, TURN_DEG = 2, 1
DECODED = ("decoded", "filled from neighbours")
RIM = "at the rim of the lit area"
SETTINGS = {
    "rig": RIG,
    "distance_mm": DISTANCE_MM,
    "set_up": {"shift_mm": SHIFT_MM, "turn_deg": TURN_DEG},
}


def conditions(effort):
    """Return every rotation with every monitor and camera, and their seeds."""
    return [
        {
            "turn_deg": turn,
            "falloff_exponent": falloff,
            "camera_gamma": gamma,
            "seed": seed,
        }
        for falloff, gamma, seeds in VARIED[effort]
        for seed in range(seeds)
        for turn in TURNS_DEG[effort]
    ]


def viewing_trial(condition, rng):
    """Return shares of the visible area that are decoded, and their uncertainty.

    Pixels next to the edge of the lit area are excluded for their blur, not for
    their light; the share "with the rim" includes them.
    """
    rig = rig_named(RIG)
    falloff = condition["falloff_exponent"]
    monitor = replace(rig.monitor, falloff_exponent=falloff)
    sensor = replace(rig.sensor, gamma=condition["camera_gamma"])
    rig = replace(rig, monitor=monitor, sensor=sensor)
    T = turned_monitor(condition["turn_deg"], rig.target.monitor_mm, rng)
    area = visible_areas(rig, T)
    patterns, pictures = patterns_taken(rig, T, [condition["seed"]])
    found = decode(
        np.stack(pictures), patterns, rig.target,
        neighbours=True, fill=True, linear=True, threads=1,
    )  # fmt: skip
    names = np.array([REASONS[k] for k in sorted(REASONS)])[found.status]
    whole = np.isin(names, DECODED)
    return {
        "share": shared(area, whole | (names == RIM)),
        "without_rim": shared(area, whole),
        "sigma_um": 1000 * float(np.median(found.sigma[whole])),
        "largest_angle_deg": farthest_angle(rig, T),
    }


def turned_monitor(turn_deg, size_mm, rng):
    """Return T_camera_target of a monitor placed by hand and rotated."""
    shift, by_hand = rng.normal(size=(2, 3)) * [[SHIFT_MM], [TURN_DEG]]
    R = rotation_from_vector(np.radians(by_hand)) @ rotation_from_vector(
        np.radians([0.0, turn_deg, 0.0])
    )
    middle = np.array([*size_mm, 0]) / 2
    return pose(R, np.array([0, 0, DISTANCE_MM]) + shift - R @ middle)


def visible_areas(rig, T):
    """Return the area (H, W) of the grid that each pixel sees, mm^2; 0 outside it."""
    points = points_seen(rig.camera, T, rig.target.monitor_mm).astype(float)
    down, across = np.gradient(points, axis=(0, 1))
    area = across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0]
    return np.nan_to_num(np.abs(area))


def shared(area, where):
    """Return the share of an area (H, W) where a mask is True."""
    return float(area[where].sum() / area.sum())


def farthest_angle(rig, T):
    """Return the largest visible angle (deg) to the monitor's normal."""
    points = points_seen(rig.camera, T, rig.target.monitor_mm).astype(float)
    v, u = np.nonzero(np.isfinite(points[..., 0]))
    rays = rig.camera.rays(np.column_stack([u, v]).astype(float))
    cosines = rays.directions @ T[:3, 2]
    return float(np.degrees(np.arccos(cosines.min())))
