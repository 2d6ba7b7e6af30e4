"""Grids that become parallel: to the base, or to each other."""

import numpy as np

from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SHIFT_MM,
    SIDE,
    draw_pixels,
    observe,
    radial_lens,
)
from raxel.calibration import linear_cgsp
from raxel.calibration.linear.synthetic_pinhole import (
    conic_system,
    scaled,
    sturm_maybank,
)
from raxel.errors import CalibrationError
from raxel.geometry import homography_dlt, pose, rotation_from_vector
from raxel.geometry.homography import normalising
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

TILT_DEG = 25.0
NOISE_PX = 0.5
TRIALS = {"quick": 6, "full": 60}
ANGLES_DEG = {
    "quick": [0.0, 0.5, 5.0],
    "full": [0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0],
}


def tilt(angle_deg, around):
    """Rotation by an angle about an axis in the plane, at ``around`` from x."""
    axis = np.array([np.cos(around), np.sin(around), 0.0])
    return rotation_from_vector(np.radians(angle_deg) * axis)


def draw_nearly_parallel(which, angle_deg, rng):
    """T_base_grid (3, 4, 4): grid 2 so far from the base, or grid 3 from grid 2.

    Each grid is turned in its own plane at random.
    """
    around = rng.uniform(0, 2 * np.pi)
    if which == "base":
        second = tilt(angle_deg, around)
        third = tilt(TILT_DEG, around + np.pi / 2)
    else:
        second = tilt(TILT_DEG, around)
        third = second @ tilt(angle_deg, rng.uniform(0, 2 * np.pi))
    turns = np.zeros((2, 3))
    turns[:, 2] = rng.uniform(0, 2 * np.pi, 2)
    turned = np.stack([second, third]) @ rotation_from_vector(turns)
    shifts = rng.uniform(-SHIFT_MM, SHIFT_MM, (2, 3))
    return np.concatenate([np.eye(4)[None], pose(turned, shifts)])


def unguarded(points):
    """Degeneracy, and the centre's error where nothing is refused."""
    base = normalising(points[0])
    homographies = scaled(
        np.stack(
            [
                base @ homography_dlt(own, points[0]) @ np.linalg.inv(normalising(own))
                for own in points[1:]
            ]
        )
    )
    singular = np.linalg.svd(conic_system(homographies), compute_uv=False)
    x, y, square = sturm_maybank(homographies)
    if not square > 0:
        return singular[2] / singular[0], None
    centre = np.array([x, y, np.sqrt(square)])
    centre = (centre - [*base[:2, 2], 0.0]) / base[0, 0]
    return singular[2] / singular[0], np.linalg.norm(centre - CENTRE_MM)


def parallel_trial(condition, rng):
    """What the linear stage says and finds, and what it would have found."""
    camera = radial_lens()
    T_base_grid = draw_nearly_parallel(condition["which"], condition["angle_deg"], rng)
    pixels = draw_pixels(camera, T_base_grid, rng)
    seen = observe(camera, T_base_grid, pixels, NOISE_PX, "px", rng)
    degeneracy, error = unguarded(seen.noisy)
    out = {"degeneracy": degeneracy, "unguarded_mm": error}
    try:
        found = linear_cgsp(seen.noisy, side=SIDE)
    except CalibrationError as refused:
        named = "parallel to the base" in str(refused)
        return out | {"refused": 1, "named": int(named), "centre_mm": None}
    off = np.linalg.norm(found.centre - CENTRE_MM)
    return out | {"refused": 0, "margin": found.margin, "centre_mm": off}


@experiment("ext_degeneracy_sweep", artefact="ext_degeneracy", shards={"full": 2})
def nearly_parallel(effort):
    """One angle goes to zero: of a grid to the base, or of two grids."""
    conditions = crossed(which=("base", "grids"), angle_deg=ANGLES_DEG[effort])
    return Plan(parallel_trial, conditions, TRIALS[effort], SETTINGS)
