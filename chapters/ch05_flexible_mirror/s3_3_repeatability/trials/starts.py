"""Refinement started from mirrors that are bent too little or too much.

A stage is calibrated; its linear estimate is then bent more or less, evenly from half
of the deflection less to half of it more, twisted besides, and refined again with the
same corners.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import travelled
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from chapters.shared.mirror_scores import load_height
from raxel.calibration.mirror.refine import refine_shape
from raxel.calibration.mirror.sightings import normalised
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

STARTS = 6
MAX_BEND = 0.5  # of the deflection, that a start is bent more or less
# Stages before and after: the first step of Table 5.5, and the way back at a stroke.
STEPS = {"5": (0, 1), "15": (3, 0)}
STEPS_MM = {
    name: abs(STAGES_MM[end] - STAGES_MM[start]) for name, (start, end) in STEPS.items()
}


def both_steps(rig, bench, errors, seed):
    """{step: its starts and their ends}; `refused` where there is no stage."""
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    out = {}
    for name, ends in STEPS.items():
        pair = [cameras[k] for k in ends]
        first = primary(rig, pair[0], PUBLISHED, errors, rng)
        T = rig.board_pose(rng, deflections=[STAGES_MM[k] for k in ends])
        pictures = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        further = STEPS_MM[name] * shares(rng)
        try:
            stage = deflected(
                first.camera, pair[1], pictures, rig.board.points(), first.clamp,
                PUBLISHED,
            )  # fmt: skip
        except CalibrationError as refusal:
            out[name] = {"refused": refusal.code}
            continue
        once = travelled(rig, first.camera, stage, *pair)
        out[name] = {"deflection_mm": once["deflection_mm"]} | from_starts(
            rig, pair, first, stage, pictures[1], further
        )
    return out


def shares(rng):
    """How much more each start is bent at the three columns of coefficients across the
    mirror, (STARTS, 3) shares of the deflection, none beyond MAX_BEND."""
    even = np.linspace(-MAX_BEND, MAX_BEND, STARTS)[:, None]
    twist = rng.uniform(-MAX_BEND, MAX_BEND, (STARTS, 1)) * [-1, 0, 1]
    return np.clip(even + twist, -MAX_BEND, MAX_BEND)


def from_starts(rig, pair, first, stage, pixels, further_mm):
    """SD, mm, of the deflections at the ends; NaN where one was rejected.

    pair: true cameras before and after; pixels: (N, 2) of the board after.
    """
    before = load_height(rig, first.camera, pair[0])
    used = stage.used
    p = normalised(stage.camera.viewer, pixels)[used]
    points = transform(stage.pose.T_camera_grid, on_plane(rig.board.points()))[used]
    grid, quantity = stage.camera.grid, stage.camera.quantity
    bent = bending(rig, pair[1], grid, first.clamp)

    def travel(coefficients):
        viewer = stage.camera.viewer
        camera = SplineMirrorCamera.on_grid(viewer, grid, coefficients, quantity)
        return abs(load_height(rig, camera, pair[1]) - before)

    ends = np.full(len(further_mm), np.nan)
    for number, mm in enumerate(further_mm):
        start = np.ravel(stage.linear.coefficients + bent * mm, order="F")
        try:
            fit = refine_shape(
                p, points, grid, quantity, start, noise=1.0, clamp=first.clamp
            )
        except CalibrationError:
            continue
        ends[number] = travel(fit.coefficients)
    return {"sd_mm": float(ends.std(ddof=1))}


def bending(rig, true, grid, clamp):
    """Change (Kf, Kg) of the distances that lifts the free edge by 1 mm along the load.

    It rises with the square of the distance from the clamp, in the image.
    """
    u = grid.knots_u
    degree = grid.degree[0]
    # Where along u a coefficient acts: the mean of the knots inside its support.
    places = np.array([u[i + 1 : i + 1 + degree].mean() for i in range(grid.shape[0])])
    way = np.abs(places - np.median(grid.turned(clamp.points)[:, 0]))
    place = rig.load_point(true)
    along = rig.deflection_direction() @ place / np.linalg.norm(place)
    rise = (way / way.max()) ** 2 / along
    return np.repeat(rise[:, None], grid.shape[1], axis=1)
