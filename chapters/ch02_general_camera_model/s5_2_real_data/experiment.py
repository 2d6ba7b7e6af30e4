"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from functools import cache, partial
from typing import NamedTuple

import numpy as np

from chapters.shared.general import (
    FACADE_ZOOM,
    IN_PAIRS,
    NOISE_PX,
    PRINCIPAL,
    STAGE_ZOOM,
    VARIANTS,
    ZOOM_RIGS,
    ZOOMS,
    about_principal_ray,
    adjusted_rays,
    central_focal,
    measure,
    rig_of,
    score,
    simulator_of,
    source_pixels_of,
    straightness,
    targets,
    zoom_camera,
)
from chapters.shared.general import view as plane_view
from chapters.shared.methods import LINEAR, METHODS, SCALES, STARTS
from raxel.calibration import (
    BoardView,
    calibrate_compared,
    calibrate_opencv_fisheye,
    calibrate_zhang,
    compared_boards,
)
from raxel.cameras import pixel_grid
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import corrected_view, distortion_residual, synthetic_plane
from raxel.features import find_opencv
from raxel.geometry import (
    homography_dlt,
    inverse_pose,
    on_plane,
    pose,
    pose_from_homography,
    refine_homography,
    rotation_from_vector,
    transform,
)
from raxel.lab import board_scene
from repro.run import Plan, crossed, experiment

# Images of section 2.5.2: boards in front of a lens at three zoom settings.
#
# A simulated run draws its poses. Its corners are then detected in rendered images, or
# redrawn: true projections, each board with the errors of one board that was detected
# in a rendered image (or missing, as some of those).


STAGE_IMAGES, STEP_MM = 5, 25.0
STAGE_TURN_DEG = 10.0
MAX_DRAWS = 2000


class Counts(NamedTuple):
    """Number of board images of a run, by their use."""

    calibration: int
    held_out: int


class Boards(NamedTuple):
    """Corners (n, N, 2) of n boards, NaN where not detected, and true ones.

    Only STAGE_ZOOM has boards of the stage.
    """

    found: np.ndarray
    true: np.ndarray


def draw_poses(zoom, counts, rng):
    """Return poses T_camera_grid (n, 4, 4) of a run's boards, by their use."""
    rig = rig_of(zoom)
    uses = {
        "calibration": rig.draw_poses(rng, counts.calibration),
        "held_out": rig.draw_poses(rng, counts.held_out),
    }
    if zoom == STAGE_ZOOM:
        uses["stage"] = draw_stage(rig, rng)
    return uses


def draw_stage(rig, rng):
    """Return five poses, 25 mm apart along one line, all in view."""
    for _ in range(MAX_DRAWS):
        middle = rig.draw_poses(rng, 1)[0]
        axis = rng.standard_normal(3)
        turn = np.radians(rng.uniform(0, STAGE_TURN_DEG))
        turned = rotation_from_vector(turn * axis / np.linalg.norm(axis))
        along = middle[:3, :3] @ turned[:, 0]
        steps = np.arange(STAGE_IMAGES) - (STAGE_IMAGES - 1) / 2
        poses = pose(middle[:3, :3], middle[:3, 3] + STEP_MM * steps[:, None] * along)
        if all(rig.shows(T) for T in poses):
            return poses
    raise RuntimeError("the rig's boards leave no room for the stage")


def true_corners(zoom, poses):
    """Return the projections (n, N, 2) of the board's corners."""
    flat = on_plane(rig_of(zoom).target.points())
    return np.stack(
        [zoom_camera(zoom).project(transform(T, flat)).pixels for T in poses]
    )


def true_shape(zoom):
    """Return the shape (N, 2) of the board's corners."""
    target = rig_of(zoom).target
    return target.columns * target.rows, 2


def render_board(zoom, T_camera_grid, rng):
    """Render one image of the board, uint8 (height, width)."""
    rig = rig_of(zoom)
    scene = board_scene(rig.target, T_camera_grid, rig.border_mm)
    return simulator_of(zoom).render(scene, np.eye(4), rng)


def find(zoom, image):
    """Return the detected corners (N, 2), or NaN."""
    target = rig_of(zoom).target
    seen = find_opencv(image, target.columns, target.rows)
    if seen.found:
        return seen.corners
    return np.full((target.columns * target.rows, 2), np.nan)


def found_in_images(zoom, poses, rng):
    """Render the boards and detect corners in every image: (Boards, images)."""
    images = [render_board(zoom, T, rng) for T in poses]
    found = np.stack([find(zoom, image) for image in images])
    return Boards(found, true_corners(zoom, poses)), images


def redrawn(zoom, poses, errors, rng):
    """Return boards with the corner errors of one board of `errors` (m, N, 2) each."""
    true = true_corners(zoom, poses)
    return Boards(true + errors[rng.integers(len(errors), size=len(true))], true)


def noisier(boards, sd_px, rng):
    """Return the boards with Gaussian noise (px, each axis) on detected corners."""
    noise = rng.normal(0.0, sd_px, boards.found.shape)
    return boards._replace(found=boards.found + noise)


def views_of(zoom, corners):
    """Return BoardViews of the detected boards."""
    target = rig_of(zoom).target
    return [
        BoardView(pixels, target.points(), target.columns, target.rows, str(index))
        for index, pixels in enumerate(corners)
        if np.isfinite(pixels).all()
    ]


# Scores of section 2.5.2: residuals of perspective correction, numbers of a run.


MIN_POINTS = 12
QUINTILES = 5
NEIGHBOURS = 8
PERMUTATIONS = 999
COVERAGE_PX = 8  # spacing of the pixels on which coverage is counted


def calibrate(method, views, size, rng, prepared):
    """Return the camera of one method, from views of boards; size (width, height).

    prepared() returns the common input of all generic methods, computed once.
    """
    if method == "parametric":
        return calibrate_zhang(views, *size).camera
    if method == "opencv_fisheye":
        return calibrate_opencv_fisheye(views, *size).camera
    return calibrate_compared(prepared(), rng=rng, linear=LINEAR[method]).camera


class Residuals(NamedTuple):
    """Residuals of one board and their positions.

    pixels (M, 2): corners that have a ray; corrected, source (M, 2): residual
    vectors in px of the corrected view and of the source image; left_out: the
    number of corners without a ray.
    """

    pixels: np.ndarray
    corrected: np.ndarray
    source: np.ndarray
    left_out: int


def residuals_of(camera, views):
    """Return the residuals of each board: corrected corners compared with its grid."""
    plane = synthetic_plane(camera)
    found, straight = [], []
    for view in views:
        rays = camera.rays(view.pixels)
        seen, ahead = corrected_view(
            rays.directions, plane, np.nan_to_num(rays.origins)
        )
        usable = rays.valid & ahead
        if np.count_nonzero(usable) < MIN_POINTS:
            usable[:] = False
        seen, points = seen[usable], view.points[usable]
        residual = distortion_residual(seen, points) if len(seen) else seen
        straight.append(seen - residual)
        left_out = int(np.count_nonzero(~usable))
        found.append((view.pixels[usable], residual, left_out))
    bent = source_pixels_of(camera, plane, np.concatenate(straight))
    ends = np.cumsum([len(points) for points in straight])[:-1]
    return [
        Residuals(pixels, corrected, pixels - back, left_out)
        for (pixels, corrected, left_out), back in zip(
            found, np.split(bent, ends), strict=True
        )
    ]


def summary_of(boards):
    """Return RMS, mean and SD of residual lengths over all boards, in both scales."""
    out = {"left_out": sum(board.left_out for board in boards), "boards": len(boards)}
    for scale in SCALES:
        vectors = np.concatenate([getattr(board, scale) for board in boards])
        lengths = np.linalg.norm(vectors, axis=1)
        lengths = lengths[np.isfinite(lengths)]
        if len(lengths) < MIN_POINTS:
            continue
        out[scale] = {
            "rms_px": np.sqrt(np.mean(lengths**2)),
            "mean_px": lengths.mean(),
            "sd_px": lengths.std(ddof=1),
        }
    return out


def radial_bias(boards, middle):
    """Return the mean signed radial residual in quintiles of the image radius.

    boards: Residuals; middle: (2,) px. Returns per quintile mean, p-value of
    the mean against zero (t test over corners), and the RMS of all; in px of
    the corrected view and of the source image. Outwards is positive.
    """
    from scipy.stats import ttest_1samp

    pixels = np.concatenate([board.pixels for board in boards])
    if len(pixels) < MIN_POINTS:
        return {}
    offset = pixels - middle
    radius = np.linalg.norm(offset, axis=1)
    outward = offset / np.maximum(radius, 1e-9)[:, None]
    limits = np.quantile(radius, np.linspace(0, 1, QUINTILES + 1)[1:-1])
    place = np.digitize(radius, limits)
    out = {}
    for scale in SCALES:
        vectors = np.concatenate([getattr(board, scale) for board in boards])
        signed = np.sum(vectors * outward, axis=1)
        known = np.isfinite(signed)
        out[scale] = {"rms_px": np.sqrt(np.mean(np.sum(vectors[known] ** 2, 1)))}
        for quintile in range(QUINTILES):
            values = signed[known & (place == quintile)]
            if len(values) < MIN_POINTS:
                continue
            out[scale][f"q{quintile + 1}"] = {
                "mean_px": values.mean(),
                "p": ttest_1samp(values, 0.0).pvalue,
            }
    return out


def moran(positions, vectors, rng):
    """Return Moran's I of the residual vectors of one board, and its p-value.

    Weights: the eight nearest neighbours; p: share of random reorderings with
    an I as large, one-sided.
    """
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    nearest = np.argsort(distances, axis=1)[:, 1 : NEIGHBOURS + 1]
    centred = vectors - vectors.mean(axis=0)
    spread = np.sum(centred**2) / len(centred)
    adjacent = np.mean(np.sum(centred[:, None] * centred[nearest], 2))
    shuffled = [rng.permutation(centred) for _ in range(PERMUTATIONS)]
    # Sums over neighbours, of all orders at once; the first is the order found.
    neighbours = np.zeros((len(centred), len(centred)))
    np.put_along_axis(neighbours, nearest, 1.0, axis=1)
    orders = np.stack([centred, *shuffled], axis=1)
    sums = np.tensordot(neighbours, orders, axes=1)
    found, *others = np.sum(orders * sums, axis=(0, 2))
    beaten = np.count_nonzero(np.array(others) >= found)
    return float(adjacent / spread), (beaten + 1) / (PERMUTATIONS + 1)


def stage_poses(camera, views):
    """Return poses T_camera_grid (n, 4, 4) from decomposed homographies.

    Raises InputError for a board with too few rays.
    """
    poses = []
    for view in views:
        rays = camera.rays(view.pixels)
        ahead = rays.valid & (rays.directions[:, 2] > 0)
        if np.count_nonzero(ahead) < MIN_POINTS:
            raise InputError(f"stage image {view.name}: too few rays")
        flat = rays.directions[ahead, :2] / rays.directions[ahead, 2:]
        points = view.points[ahead]
        H = refine_homography(homography_dlt(points, flat), points, flat)
        poses.append(pose_from_homography(H))
    return np.stack(poses)


def steps_of(poses):
    """Return steps (n - 1, 3) in mm between poses, in grid and camera frame."""
    in_grid = -np.diff(inverse_pose(poses)[:, :3, 3], axis=0)
    return {"grid": in_grid, "camera": np.diff(poses[:, :3, 3], axis=0)}


def scatter_of(steps):
    """Return the RMS deviation (mm) of steps (n, 3) from their mean, and its length."""
    mean = steps.mean(axis=0)
    deviation = np.sqrt(np.mean(np.sum((steps - mean) ** 2, axis=1)))
    return {"deviation_mm": deviation, "step_mm": np.linalg.norm(mean)}


def example_view(zoom, boards):
    """Return the first calibration image in which the board was detected."""
    return int(np.argmax(np.isfinite(boards["calibration"].found).all(axis=(1, 2))))


def scores(zoom, boards, rng, methods=METHODS, interpolation="homographic"):
    """Return all numbers of a run, and the calibrated cameras by method."""
    views = {use: views_of(zoom, seen.found) for use, seen in boards.items()}
    true = zoom_camera(zoom)
    size = true.width, true.height
    out = {f"found.{use}": len(of_use) for use, of_use in views.items()}
    out["distortion_level"] = distortion_level(true, boards)
    cameras, seen = {}, views["calibration"]
    prepared = cache(lambda: compared_boards(seen, *size, interpolation))
    for method in methods:
        try:
            camera = calibrate(method, seen, size, rng, prepared)
            out[method] = of_camera(zoom, camera, views, rng)
            cameras[method] = camera
        except (CalibrationError, InputError) as error:
            out[method] = {"failed": error.code}
    if zoom == FACADE_ZOOM and "parametric" in cameras:
        out["lines"] = straightness(cameras)
    return out, cameras


def of_camera(zoom, camera, views, rng):
    """Return the scores of one calibrated camera."""
    boards = {
        use: residuals_of(camera, views[use]) for use in ("calibration", "held_out")
    }
    out = {use: summary_of(of_use) for use, of_use in boards.items()}
    out["share_of_image"] = share_of_image(camera)
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    if zoom == STAGE_ZOOM:
        for use, of_use in boards.items():
            out[use]["radial"] = radial_bias(of_use, middle)
        out["moran"] = correlation(boards["calibration"][0], rng)
        out["stage"] = stage(camera, views["stage"])
    return out


def share_of_image(camera):
    """Return the share of the image with a ray, on every eighth row and column."""
    size = camera.width // COVERAGE_PX, camera.height // COVERAGE_PX
    pixels = COVERAGE_PX * pixel_grid(*size) + COVERAGE_PX // 2
    return float(np.mean(camera.rays(pixels).valid))


def correlation(board, rng):
    """Return Moran's I of one board's residuals, in both scales."""
    out = {}
    for scale in SCALES:
        vectors = getattr(board, scale)
        known = np.isfinite(vectors).all(axis=1)
        if np.count_nonzero(known) < MIN_POINTS:
            continue
        index, p = moran(board.pixels[known], vectors[known], rng)
        out[scale] = {"index": index, "p": p}
    return out


def stage(camera, views):
    """Return the steps of the stage, which require all five images."""
    if len(views) < STAGE_IMAGES:
        return {"failed": "too-few-boards"}
    try:
        steps = steps_of(stage_poses(camera, views))
    except InputError as error:
        return {"failed": error.code}
    return {frame: scatter_of(s) | {"steps": s} for frame, s in steps.items()}


def fields(zoom, boards, sample, cameras):
    """Return arrays for Fig. 2.5: residual vectors of the sample image."""
    views = views_of(zoom, boards["calibration"].found[sample][None])
    return {
        f"field.{method}": np.hstack(residuals_of(camera, views)[0][:3])
        for method, camera in cameras.items()
    }


def distortion_level(camera, boards):
    """Return the largest |r_distorted / r_pinhole - 1| over the calibration boards.

    A pinhole with the camera's scale at the centre; beyond 90 degrees it has
    no radius, and the level is 1.
    """
    pixels = boards["calibration"].true.reshape(-1, 2)
    middle = camera.project(np.array([[0.0, 0.0, 1.0]])).pixels[0]
    step = camera.project(np.array([[1e-4, 0, 1], [-1e-4, 0, 1]])).pixels
    focal = np.linalg.norm(step[0] - step[1]) / 2e-4
    z = camera.rays(pixels).directions[:, 2]
    tangent = np.sqrt(1 - z**2) / np.maximum(z, 1e-12)
    radius = np.linalg.norm(pixels - middle, axis=1)
    level = np.abs(radius / (focal * np.maximum(tangent, 1e-12)) - 1)
    return float(np.max(np.where(z > 0, level, 1.0)))


# Two small experiments of section 2.5.2: the true centre, and a homography.


SCENE = {
    "law": "equidistance",
    "fov_deg": 120,
    "noise": 0.5,
    "domain": "px",
    "extent": "unbounded",
}
POINTS = 200


def centre_trial(condition, rng):
    """Return the RMS residual with the estimated and with the true centre."""
    data, _ = measure(SCENE, rng)
    true_centre = inverse_pose(data.grids[0])[:3, 3]
    out = {}
    for name, start in STARTS.items():
        try:
            linear = start(data.noisy_points)
            estimated = rms_of(data, linear.centre, linear.T_base_grid)
            true = rms_of(data, true_centre, linear.T_base_grid)
        except (CalibrationError, InputError) as error:
            out[name] = {"failed": error.code}
            continue
        out[name] = {"centre_error_mm": np.linalg.norm(linear.centre - true_centre)}
        for scoring, scales in estimated.items():
            out[name][scoring] = {
                scale: {
                    "estimated_px": rms,
                    "true_px": true[scoring][scale],
                    "ratio": true[scoring][scale] / rms,
                }
                for scale, rms in scales.items()
            }
    return out


def rms_of(data, centre, T_base_grid):
    """Return the RMS residual (px) by scoring and scale, for a given centre.

    The rays and all grids except the base grid are adjusted to that centre.
    """
    directions = adjusted_rays(data, centre, T_base_grid)
    focal = central_focal(data.camera)
    corrected = plane_view(about_principal_ray(directions, data.pixels), focal)
    return {
        scoring: {
            scale: np.sqrt(np.nanmean(lengths**2))
            for scale, lengths in score(corrected, target, data.camera, focal).items()
        }
        for scoring, target in targets(data, focal).items()
    }


def homography_trial(condition, rng):
    """Return the RMS residual (px) of perspective points and of distorted ones."""
    points = rng.uniform(-300, 300, (POINTS, 2))
    H = np.eye(3) + rng.uniform(-1, 1, (3, 3)) * [
        [0.3, 0.3, 200],
        [0.3, 0.3, 200],
        [3e-4, 3e-4, 0],
    ]
    lifted = np.column_stack([points, np.ones(POINTS)]) @ H.T
    seen = lifted[:, :2] / lifted[:, 2:]
    offset = seen / np.abs(seen).max()
    k1 = rng.uniform(0.02, 0.2)
    bent = seen * (1 + k1 * np.sum(offset**2, axis=1, keepdims=True))
    residuals = {
        "without_px": distortion_residual(seen, points),
        "with_px": distortion_residual(bent + PRINCIPAL, points),
    }
    return {
        name: np.sqrt(np.mean(np.sum(vectors**2, axis=1)))
        for name, vectors in residuals.items()
    }


# Simulated runs of Table 2.2: numbers, settings, and runs with other corners.


COUNTS = {"quick": Counts(5, 1), "full": Counts(14, 4)}
READ = {"quick": 1, "full": 12}
PAIRED = {"quick": 1, "full": 50}
SMALL = {"quick": 4, "full": 50}
EXACT = {"quick": 1, "full": 4}
SETS = crossed(zoom=ZOOMS)


def settings(effort):
    """Return the settings that a reader needs to repeat the run."""
    return {
        "rigs": list(ZOOM_RIGS),
        "calibration_images": COUNTS[effort].calibration,
        "held_out_images": COUNTS[effort].held_out,
        "stage_images": STAGE_IMAGES,
        "step_mm": STEP_MM,
        "field_of_view_deg": round(np.degrees(2 * zoom_camera(ZOOMS[-1]).max_angle), 6),
        "detector": "findChessboardCorners, refined",
    }


def redrawn_trial(condition, rng, counts, errors):
    """Score a redrawn run: new poses with the corner errors of rendered boards."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    boards = {
        use: redrawn(zoom, of_use, errors[zoom], rng) for use, of_use in poses.items()
    }
    return scores(zoom, boards, rng)[0]


def errors_in(results):
    """Return the errors (boards, corners, 2) of the rendered runs, by zoom."""
    rendered = results["table_2_2_rendered"]
    return {
        zoom: np.concatenate(rendered.arrays("errors", zoom=zoom)) for zoom in ZOOMS
    }


def read_trial(condition, rng, counts, errors):
    """Score a run with other corner noise or another interpolation."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    noise = NOISE_PX[condition["corner_noise"]]
    boards = {
        use: noisier(redrawn(zoom, of_use, errors[zoom], rng), noise, rng)
        for use, of_use in poses.items()
    }
    methods = ["parametric", "generic_as_printed"]
    if noise == 0:
        methods.append("opencv_fisheye")
    return scores(zoom, boards, rng, methods, condition["interpolation"])[0]


@experiment(
    "table_2_2_readings",
    artefact="table_2_2",
    inputs=ZOOM_RIGS,
    needs=("table_2_2_rendered",),
)
def read_seeds(effort, results):
    """Runs with other corner noise or interpolation."""
    trial = partial(read_trial, counts=COUNTS[effort], errors=errors_in(results))
    return Plan(trial, VARIANTS, READ[effort], settings(effort))


@experiment(
    "fig_2_7_smooth",
    artefact="table_2_2",
    inputs=ZOOM_RIGS,
    needs=("table_2_2_rendered",),
)
def smooth_seeds(effort, results):
    """Runs with a smooth surface, enough for the paired test of 2.5.3."""
    trial = partial(read_trial, counts=COUNTS[effort], errors=errors_in(results))
    return Plan(trial, IN_PAIRS, PAIRED[effort], settings(effort))


@experiment("ext_table_2_2_exact", artefact="table_2_2", inputs=ZOOM_RIGS)
def exact_seeds(effort):
    """Set 3 with exact corners: residuals that the detector does not cause."""
    none = {STAGE_ZOOM: np.zeros((1, *true_shape(STAGE_ZOOM)))}
    trial = partial(redrawn_trial, counts=COUNTS[effort], errors=none)
    return Plan(trial, [{"zoom": STAGE_ZOOM}], EXACT[effort], settings(effort))


@experiment("fig_2_5_true_centre", artefact="fig_2_5")
def true_centres(effort):
    """Simulated runs with the true centre in place of the estimated one."""
    return Plan(centre_trial, [{}], SMALL[effort], {"scene": SCENE})


@experiment("exp_c2_homography_harmless", artefact="fig_2_5")
def homographies(effort):
    """Perspective and distorted points after a homography."""
    return Plan(homography_trial, [{}], SMALL[effort], {})
