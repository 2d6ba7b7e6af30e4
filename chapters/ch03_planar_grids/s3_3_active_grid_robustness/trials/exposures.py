"""The default condition again, with other exposures and another tone curve."""

from dataclasses import replace

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    AS_TAKEN,
    DEFAULT_MM,
    START_SD_PX,
    by_methods,
    corners_of,
    location_as_taken,
    location_of,
    opened,
    patterns_taken,
    scores,
)
from chapters.shared.rigs import rig_named
from raxel.io.files import read_json
from raxel.lab.monitor_views import photograph_chessboard, points_seen
from raxel.sets.patterns import CHESSBOARD, plan_of_cells

FILES = ("data/rigs/monitor-d200.yaml", "data/rigs/monitor-d200-small.yaml")
# One set: how the monitor was set up is in the sweeps.
SETS = {"quick": ("monitor-d200-small/0",), "full": ("monitor-d200/0",)}
# White on the sensor, as a share of a full well; the rig's own is 0.9.
EXPOSURES = {"quick": (0.9, 1.5), "full": (0.45, 0.9, 1.2, 1.5, 2.0)}
GAMMAS = (2.2, 1.0)
STEPS = (4, 6)
NEAR_MM = 0.3
DEFAULT = f"distance-{DEFAULT_MM}"


def exposure_trial(condition, rng):
    """Chessboard and first grid with a white of this share of a full well."""
    image_set, rig, T = default_view(condition["set"])
    white = condition["white_of_well"] * rig.sensor.full_well_e
    rig = replace(rig, sensor=replace(rig.sensor, white_e=white))
    seed = [int(rng.integers(1 << 31))]
    board = photograph_chessboard(rig, T, seed)
    second = location_as_taken(condition["set"], f"{DEFAULT}-second")
    true = corners_of(image_set)[f"{DEFAULT}/{CHESSBOARD}"]
    starts = true + rng.normal(0, START_SD_PX, true.shape)
    points = image_set.target.chessboard_points()
    found = by_methods(board, decoded_now(rig, T, seed), starts, true, points)
    said = scores(found, {AS_TAKEN: second}, true, points)
    return said | {"full_wells": float(np.mean(board == board.max()))}


def pixel_trial(condition, rng):
    """Errors over all pixels of the first grid, and next to the corners."""
    image_set, rig, T = default_view(condition["set"])
    sensor = replace(rig.sensor, gamma=condition["camera_gamma"])
    plan = plan_of_cells(rig.target.monitor_px, condition["cells"], condition["steps"])
    rig = replace(rig, sensor=sensor, patterns=plan)
    found = decoded_now(rig, T, [int(rng.integers(1 << 31))])
    true = points_seen(rig.camera, T, rig.target.monitor_mm)
    error = np.linalg.norm(found - true, axis=2)
    known = np.isfinite(error)
    near = known & near_points(true, image_set.target.chessboard_points())
    return {
        "all_mm": float(np.sqrt(np.mean(error[known] ** 2))),
        "corners_mm": float(np.sqrt(np.mean(error[near] ** 2))),
        "pixels": int(known.sum()),
    }


def default_view(name):
    """(ImageSet, its Rig, T_camera_target) of the default condition."""
    image_set, _ = opened(name)
    rig = rig_named(name.partition("/")[0])
    poses = read_json(image_set.folder / "truth" / "poses.json")
    return image_set, rig, np.array(poses["T_camera_target"][DEFAULT])


def decoded_now(rig, T, seed):
    """The point that each pixel sees, (H, W, 2) mm, in pictures taken now."""
    patterns, pictures = patterns_taken(rig, T, seed)
    return location_of(pictures, patterns, rig.target)


def near_points(location, points):
    """Pixels (H, W) that see within NEAR_MM of one of a square lattice's points."""
    pitch, first = (np.ptp(points[:, 0]) / (np.sqrt(len(points)) - 1), points[0])
    steps = (location - first) / pitch
    whole = np.clip(np.rint(steps), 0, np.sqrt(len(points)) - 1)
    with np.errstate(invalid="ignore"):
        return np.linalg.norm((steps - whole) * pitch, axis=2) < NEAR_MM
