"""More knots: the largest tolerated step and the error of the shape (5.2.2).

A flat mirror is bent once, by steps of several sizes. The same images are calibrated
with several numbers of knots, the primary stage with the same number.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    PUBLISHED,
    STEP_PX,
    calibrated_viewer,
    decoded,
    deflected,
    lattice,
    poses_in_platter,
    seen_board,
    shape_name,
    true_points,
)
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.primary import primary_from_points
from raxel.errors import CalibrationError

# Numbers of basis functions (Kf, Kg), and steps, mm.
SHAPES = ((5, 3), (7, 3), (9, 4), (11, 5))
STEPS_MM = (0.5, 1.0, 2.5, 3.75, 5.0, 7.5, 10.0, 15.0)
# Without noise: the smallest step, which says least about what larger ones hide.
NOISE_FREE_MM = STEPS_MM[0]
CORNER_PX = 0.2  # standard deviation of a corner along each axis
COMPARED_PX = 168  # px between the pixels whose rays are compared


class StepsSeen(NamedTuple):
    """Inputs of the calibrations with all numbers of knots.

    viewer; pixels, points, poses: of the monitor, as for `primary_from_points`;
    line: the clamp's; pictures: {step, mm: pixels (2, N, 2) before and after}.
    """

    viewer: object
    pixels: np.ndarray
    points: np.ndarray
    poses: object
    line: object
    pictures: dict


def knots_trial(condition, rng, errors):
    """For each number of knots the mean ray error after each step, with noise, and the
    shape's error after one step without; nothing where it is rejected."""
    rig = mirror_rig(condition["geometry"])
    errors = errors[condition["geometry"]]
    errors = errors._replace(corner=rng.normal(0, CORNER_PX, errors.corner.shape))
    cameras = {mm: rig.camera(mm) for mm in (0.0, *STEPS_MM)}
    boards = {mm: rig.board_pose(rng, deflections=(0.0, mm)) for mm in STEPS_MM}
    seen = with_noise(rig, cameras, boards, errors, rng), without(rig, cameras, boards)
    return {shape_name(shape): of_shape(rig, *seen, shape, cameras) for shape in SHAPES}


def with_noise(rig, cameras, boards, errors, rng):
    """Observations with the errors of images."""
    viewer, true = calibrated_viewer(rig, errors, rng), rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, true, errors, rng)
    flat = cameras[0.0]
    picks = rig.clamp_pixels(flat, CLAMP_PICKS, rng, CLAMP_SD_PX)
    pictures = {
        mm: [seen_board(rig, c, T, errors, rng) for c in (flat, cameras[mm])]
        for mm, T in boards.items()
    }
    found = decoded(rig, flat, true, errors, rng)
    return StepsSeen(viewer, *found, poses, clamp_line(viewer, picks), pictures)


def without(rig, cameras, boards):
    """What is seen without any error, by the true viewer, of monitors in true poses."""
    flat, T = cameras[0.0], rig.monitor_poses()
    pixels = lattice(flat, STEP_PX)
    points = np.stack([true_points(rig, flat, pixels, pose) for pose in T])
    both = np.isfinite(points).all(axis=(0, 2))
    ends = [
        rig.corners(c, boards[NOISE_FREE_MM]) for c in (flat, cameras[NOISE_FREE_MM])
    ]
    pair = [np.where(seen[:, None], p, np.nan) for p, seen in ends]
    line = clamp_line(rig.viewer, rig.clamp_pixels(flat, CLAMP_PICKS))
    return StepsSeen(
        rig.viewer, pixels[both], points[:, both], T, line, {NOISE_FREE_MM: pair}
    )


def of_shape(rig, noisy, exact, shape, cameras):
    """Both measures of one number of knots, NaN where it is rejected."""
    angles = np.full(len(STEPS_MM), np.nan)
    for number, (mm, found) in enumerate(bent(rig, noisy, shape, cameras)):
        if found is not None:
            true = cameras[mm]
            off = ray_angles(found, true, lattice(true, COMPARED_PX))
            angles[number] = np.nanmean(off)
    ((mm, found),) = bent(rig, exact, shape, cameras)
    return {
        "angles_deg": angles,
        "noise_free_mm": np.nan if found is None else distance(found, cameras[mm]),
    }


def bent(rig, seen, shape, cameras):
    """(step, mm, and the SplineMirrorCamera after it) for each imaged step; None
    where a calibration was rejected."""
    method, board = PUBLISHED._replace(shape=shape), rig.board.points()
    try:
        first = primary_from_points(
            seen.viewer, seen.pixels, seen.points, seen.poses, shape=shape,
            angle=seen.line.angle, quantity=method.quantity,
            span=seen.line.points(CLAMP_PICKS),
        )  # fmt: skip
    except CalibrationError:
        return [(mm, None) for mm in seen.pictures]
    held, found = fixed_line(first.camera, seen.line)._replace(slopes=None), []
    for mm, pair in seen.pictures.items():
        try:
            stage = deflected(first.camera, cameras[mm], pair, board, held, method)
            found.append((mm, stage.camera))
        except CalibrationError:
            found.append((mm, None))
    return found


def distance(found, true):
    """Mean distance, mm, of a mirror from the true one along viewing rays, over the
    whole of it."""
    pixels = lattice(true, COMPARED_PX)
    off = found.rays(pixels).origins - true.rays(pixels).origins
    return float(np.nanmean(np.linalg.norm(off, axis=1)))
