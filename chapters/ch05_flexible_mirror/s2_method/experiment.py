"""Trials of this page, their conditions and constants."""

import sys
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror import (
    BENCHES,
    BOARDS,
    CLAMP_PICKS,
    CLAMP_SD_PX,
    LEVEL,
    PUBLISHED,
    STAGES_MM,
    STEP_PX,
    calibrated_viewer,
    decoded,
    deflected,
    lattice,
    load_height,
    mirror_rig,
    platter_image,
    poses_in_platter,
    primary,
    ray_angles,
    seen_board,
    shape_name,
    true_points,
)
from raxel.calibration import (
    BoardView,
    clamp_line,
    fixed_line,
    interpolated_view,
    magnification,
    normalised,
    primary_from_points,
    refine_shape,
)
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform
from raxel.sets import patterns_of

# More knots: the largest tolerated step and the error of the shape (5.2.2).
#
# A flat mirror is bent once, by steps of several sizes. The same images are calibrated
# with several numbers of knots, the primary stage with the same number.


# Numbers of basis functions (Kf, Kg), and steps, mm.
SHAPES = ((5, 3), (7, 3), (9, 4), (11, 5))
STEPS_MM = (0.5, 1.0, 2.5, 3.75, 5.0, 7.5, 10.0, 15.0)
# Without noise: the smallest step, where the spline itself limits the shape least.
NOISE_FREE_MM = STEPS_MM[0]
CORNER_PX = 0.2  # standard deviation of a corner along each axis
COMPARED_PX = 168  # px between the pixels whose rays are compared


class StepsSeen(NamedTuple):
    """Inputs of the calibrations with all numbers of knots.

    viewer; pixels, points, poses: of the monitor, as for `primary_from_points`;
    line: the clamp's; corner_pairs: {step, mm: pixels (2, N, 2) before and after}.
    """

    viewer: object
    pixels: np.ndarray
    points: np.ndarray
    poses: object
    line: object
    corner_pairs: dict


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
    images = {
        mm: [seen_board(rig, c, T, errors, rng) for c in (flat, cameras[mm])]
        for mm, T in boards.items()
    }
    found = decoded(rig, flat, true, errors, rng)
    return StepsSeen(viewer, *found, poses, clamp_line(viewer, picks), images)


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
    for number, (mm, found) in enumerate(recalibrated(rig, noisy, shape, cameras)):
        if found is not None:
            true = cameras[mm]
            off = ray_angles(found, true, lattice(true, COMPARED_PX))
            angles[number] = np.nanmean(off)
    ((mm, found),) = recalibrated(rig, exact, shape, cameras)
    return {
        "angles_deg": angles,
        "noise_free_mm": np.nan if found is None else distance(found, cameras[mm]),
    }


def recalibrated(rig, seen, shape, cameras):
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
        return [(mm, None) for mm in seen.corner_pairs]
    held, found = fixed_line(first.camera, seen.line)._replace(slopes=None), []
    for mm, pair in seen.corner_pairs.items():
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


# Rendered image of the platter on its chessboard (Fig. 5.3).


# Index of the monitor's image in the platter: the first of its sinusoids.
SHOWN = "phase-x-0.png"


def platter_trial(condition, rng):
    """Image (576, 768), uint8, of the platter that shows the monitor.

    A quarter of the camera's pixels in each direction, for drawing only.
    """
    rig = mirror_rig("A", small=True)
    (shown,) = (p for p in patterns_of(rig.monitor.patterns) if p.image == SHOWN)
    T = rig.monitor_poses()[0]
    return {"picture": platter_image(rig, rig.platter(), rng, T, shown)}


# One run of SPFC2, watched: which stage of the code followed which (Fig. 5.4).


# Stage -> the function that does it, as Python finds it: module and name.
MIRROR, POSE = "raxel.calibration.mirror.", "raxel.calibration.pose."
STAGES = {
    "viewer": "raxel.calibration.parametric.opencv_fits.calibrate_zhang",
    "platter": MIRROR + "platter.grid_poses_in_platter",
    "line": MIRROR + "clamp.clamp_line",
    "rays": "raxel.calibration.generic.known_motion.rays_from_known_motion",
    "points": MIRROR + "primary.mirror_points",
    "shape": MIRROR + "refine.shape_up_to_scale",
    "scale": MIRROR + "refine.scaled_to_points",
    "first": MIRROR + "primary._refined",
    "held": MIRROR + "clamp.fixed_line",
    "pose": POSE + "non_central.pose_from_non_central_rays",
    "order": MIRROR + "update._not_exchanged",
    "knots": MIRROR + "update._knots",
    "linear": MIRROR + "refine.shape_with_clamp",
    "refine": MIRROR + "refine.refine_shape",
    "open": MIRROR + "refine.edge_flags",
}
REJECTED = "refused"


class Watch:
    """While it is entered: `order`, the stages as they begin, without the innermost.

    stages: name -> function, "module.name". What a stage calls of the others is a part
    of it and does not count.
    """

    def __init__(self, stages):
        self.names = {function: stage for stage, function in stages.items()}
        self.order, self._within = [], None

    def __enter__(self):
        sys.setprofile(self._saw)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)

    def _saw(self, frame, event, _):
        if event == "call" and self._within is None:
            called = f"{frame.f_globals.get('__name__')}.{frame.f_code.co_name}"
            if called in self.names:
                self.order.append(self.names[called])
                self._within = frame
        elif event == "return" and frame is self._within:
            self._within = None

    def ways(self):
        """{"one > other": how often the one was followed by the other}."""
        return Counter(f"{a} > {b}" for a, b in pairwise(self.order))


def watched_trial(condition, rng, errors):
    """Transitions of one run of three deflections, with its inputs and results.

    A rejected stage ends the run, with its own transition.
    """
    rig, bench = mirror_rig("A"), BENCHES[LEVEL]
    errors = errors.on(bench)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=condition["seed"])
    points, stages, rejected = rig.board.points(), [], {}
    with Watch(STAGES) as watch:
        first = primary(rig, cameras[0], PUBLISHED, errors, rng)
        before = first.camera
        for k in (1, 2, 3):
            pair = cameras[k - 1 : k + 1]
            T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
            images = [seen_board(rig, camera, T, errors, rng) for camera in pair]
            try:
                found = deflected(
                    before, pair[1], images, points, first.clamp, PUBLISHED
                )
            except CalibrationError as refusal:
                watch.order.append(REJECTED)
                rejected = {"refused": refusal.code}
                break
            stages.append(found)
            before = found.camera
    return rejected | {
        "ways": dict(watch.ways()),
        "boards": BOARDS,
        "positions": len(first.poses.T_camera_grid),
        "pixels": len(first.calibration.pixels),
        "mirror_points": int(first.calibration.mirror.valid.sum()),
        "primary_steps": len(first.calibration.costs) - 1,
        "coefficients": before.coefficients.size,
        **{f"stage{k}": counted(stage) for k, stage in enumerate(stages, 1)},
    }


def counted(stage):
    """What a MirrorUpdate had, and how many steps it took."""
    return {
        "posed": int(np.count_nonzero(stage.pose.inliers)),
        "common": int(np.count_nonzero(stage.used)),
        "steps": len(stage.fit.costs) - 1,
        "residual_mm": float(np.nanmean(stage.residuals)),
    }


# From which starts does the refinement of a deflection end in one place? (5.2.2)
#
# A mirror is bent by 5 mm and refined on the same features from three starts: the
# linear estimate, as published; the true surface, which no calibration has; and the
# surface as it was before, which needs no linear stage.


# px between the mirror points that a start is fitted to.
FITTED_PX = 64
STEP_MM = STAGES_MM[:2]


def one_deflection(rig, bench, errors, seed):
    """End of each start: cost (mm^2), deflection (mm), number of steps.

    `refused` is the code of a run or a start without a value.
    """
    rng = np.random.default_rng(seed)
    uneven = {"aberration_um": bench.aberration_um, "seed": seed}
    flat, bent = (rig.camera(deflection, **uneven) for deflection in STEP_MM)
    first = primary(rig, flat, PUBLISHED, errors, rng)
    T = rig.board_pose(rng, deflections=STEP_MM)
    images = [seen_board(rig, camera, T, errors, rng) for camera in (flat, bent)]
    board = rig.board.points()
    try:
        stage = deflected(first.camera, bent, images, board, first.clamp, PUBLISHED)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    starts = {
        "linear": stage.linear,
        "true": on_knots_of(stage.camera, bent),
        "before": on_knots_of(stage.camera, first.camera),
    }
    height = load_height(rig, first.camera, flat)
    found = {"common": int(np.count_nonzero(stage.used))}
    for name, start in starts.items():
        found[name] = {"start_mm": load_height(rig, start, bent) - height}
        try:
            camera, fit = refined(start, stage, images[1], board, first.clamp)
        except CalibrationError as refusal:
            found[name]["refused"] = refusal.code
            continue
        found[name] |= {
            "deflection_mm": load_height(rig, camera, bent) - height,
            "cost_mm2": float(np.sum(fit.residuals**2)),
            "steps": len(fit.costs) - 1,
        }
    return found


def on_knots_of(camera, other):
    """The spline on a calibrated camera's knots that is nearest to another's mirror."""
    points = other.rays(lattice(other, FITTED_PX)).origins
    return SplineMirrorCamera.fitted(
        camera.viewer, camera.grid, points, camera.quantity
    )


def refined(start, stage, pixels, board, clamp):
    """(SplineMirrorCamera, ShapeFit) from a start, on the features of a MirrorUpdate.

    pixels: (N, 2) after bending; board: (N, 2) mm.
    """
    viewer, used = start.viewer, stage.used
    placed = transform(stage.pose.T_camera_grid, on_plane(board))
    noise = PUBLISHED.settings.noise_px / np.median(magnification(viewer, pixels[used]))
    fit = refine_shape(
        normalised(viewer, pixels[used]),
        placed[used],
        start.grid,
        start.quantity,
        start.coefficients.ravel("F"),
        noise=noise,
        clamp=clamp,
    )
    found = SplineMirrorCamera.on_grid(
        viewer, start.grid, fit.coefficients, start.quantity
    )
    return found, fit


# Primary calibration from chessboards in place of a monitor, both without noise.
#
# The same pixels see the same two planes. The point that each sees is exact, as from an
# active grid, or interpolated between the corners of a chessboard (5.2.1).


PITCH_MM = 20.0
# A square as its four corners have it, as in section 3.2.
INTERPOLATION = "homographic"


def static_trial(condition, rng):
    """Errors of the surface before any deflection, mm, by where points come from.

    `pixel`: each pixel's own point; `grid`: interpolated. In each case of the surface
    as published (5.15, 5.16, and the scale), `linear_mm`, and of the refined one,
    `refined_mm`. aberration_um: of the mirror.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    camera = rig.camera(0.0, condition["aberration_um"], seed)
    poses = rig.monitor_poses(rng)
    pixels = lattice(camera, STEP_PX)
    exact = np.stack([true_points(rig, camera, pixels, T) for T in poses])
    read = [
        between_corners(chessboard(camera, T, seen), pixels)
        for T, seen in zip(poses, exact, strict=True)
    ]
    # Only pixels that both know of, so that nothing but the points differs.
    both = np.isfinite([exact, read]).all(axis=(0, 1, 3))
    out = {"pixels": int(np.count_nonzero(both))}
    for name, points in (("pixel", exact), ("grid", np.stack(read))):
        out[name] = surface_errors(rig, camera, pixels[both], points[:, both], poses)
    return out


def chessboard(camera, T_camera_board, seen):
    """BoardView of the exact corners, 20 mm apart, of a board that covers what the
    mirror shows of its plane, points (N, 2) mm; NaN where it does not show one."""
    corner = np.floor(np.nanmin(seen, axis=0) / PITCH_MM)
    ends = np.ceil(np.nanmax(seen, axis=0) / PITCH_MM)
    columns, rows = (ends - corner).astype(int) + 1
    across, down = np.meshgrid(np.arange(columns), np.arange(rows))
    points = PITCH_MM * (corner + np.column_stack([across.ravel(), down.ravel()]))
    pixels, valid = camera.project(transform(T_camera_board, on_plane(points)))
    shown = valid & camera.in_image(pixels)
    pixels = np.where(shown[:, None], pixels, np.nan)
    return BoardView(pixels, points, int(columns), int(rows))


def between_corners(board, pixels):
    """Points (N, 2) mm that pixels (N, 2) see between board corners, NaN elsewhere."""
    points, inside = interpolated_view(board, INTERPOLATION)[0].locate(pixels)
    return np.where(inside[:, None], points, np.nan)


def surface_errors(rig, camera, pixels, points, T_camera_board):
    """Mean distances from the true mirror along the viewing rays, mm."""
    line = clamp_line(rig.viewer, rig.clamp_pixels(camera, CLAMP_PICKS))
    found = primary_from_points(
        rig.viewer,
        pixels,
        points,
        T_camera_board,
        shape=PUBLISHED.shape,
        angle=line.angle,
        quantity=PUBLISHED.quantity,
        span=line.points(CLAMP_PICKS),
    )
    true = camera.rays(pixels).origins
    return {
        f"{name}_mm": float(
            np.mean(np.linalg.norm(one.rays(pixels).origins - true, axis=1))
        )
        for name, one in (("linear", found.linear), ("refined", found.camera))
    }
