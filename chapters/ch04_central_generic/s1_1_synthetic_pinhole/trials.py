"""Central cameras of any kind before grids, and what their rays meet.

World = base grid, z = 0; every camera's centre is 600 mm above it.
"""

from __future__ import annotations

import numpy as np

from chapters.shared.methods import LINEAR_STAGES
from chapters.shared.wide_angle import (
    CENTRE_MM,
    LEAST_INCIDENCE,
    RADIUS_PX,
    RAYS,
    SETTINGS,
    SIDE,
    SIZE_PX,
    T_BASE_CAMERA,
    back_project,
    draw_poses,
    draw_scene,
    equidistance,
    observe,
    radial_lens,
)
from chapters.shared.zoo import ZOO
from raxel.calibration import (
    BoardView,
    linear_cgsp,
    pixels_on_board,
)
from raxel.cameras import closest_point
from raxel.cameras.base import pixel_grid
from raxel.errors import CalibrationError
from raxel.geometry import (
    apply_homography,
    homography_dlt,
    intersect_rays_plane,
    inverse_pose,
    pose,
    rotate,
    transform,
)
from raxel.geometry.homography import normalising
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

WIDE_FOV_DEG = 183.0
CONE_DEG = 100.0
# Two plane-based solvers, by the names of the methods of chapter 4.
SOLVERS = ("CGSP", "CGSP circle")
# The mirror looks sideways: its x axis down at the grids.
SIDEWAYS = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])

TRIALS = {"quick": 8, "full": 100}
NOISES_PX = {"quick": [0.1, 0.5, 2.0], "full": [0.1, 0.25, 0.5, 1.0, 2.0]}
FIELDS_DEG = {"quick": [60, 150], "full": [60, 90, 120, 150]}
PITCH_MM = 20.0
COMPARED_PX = 0.1


def _of_camera(camera, T_base_camera):
    """A function rng -> rays of random pixels in the base frame."""

    def draw(rng):
        pixels = rng.uniform(-0.5, camera.width - 0.5, (4 * RAYS, 2))
        rays = camera.rays(pixels)
        return (
            transform(T_base_camera, rays.origins[rays.valid]),
            rotate(T_base_camera, rays.directions[rays.valid]),
        )

    return draw


def lens(camera):
    """Rays of a lens that looks straight down."""
    return _of_camera(camera, T_BASE_CAMERA)


def mirror():
    """Rays of a hyperboloid mirror with its viewer in the focus."""
    camera = ZOO["hyperboloid mirror"].build()
    rays = camera.rays(pixel_grid(camera.width, camera.height)[::7])
    shift = CENTRE_MM - SIDEWAYS @ closest_point(rays)
    return _of_camera(camera, pose(SIDEWAYS, shift))


def no_lens():
    """Rays at random in a cone: as if each pixel looked where it likes."""

    def draw(rng):
        z = -rng.uniform(np.cos(np.radians(CONE_DEG / 2)), 1, 4 * RAYS)
        turn = rng.uniform(0, 2 * np.pi, len(z))
        across = np.sqrt(1 - z**2)
        directions = np.column_stack(
            [across * np.cos(turn), across * np.sin(turn), z]
        )
        return np.broadcast_to(CENTRE_MM, directions.shape), directions

    return draw


def camera_of(name):
    """The drawing function of one of CAMERAS."""
    if name == "radial lens, 100°":
        return lens(radial_lens())
    if name == "equidistance, 183°":
        return lens(equidistance(WIDE_FOV_DEG))
    return mirror() if name == "hyperboloid mirror" else no_lens()


CAMERAS = (
    "radial lens, 100°",
    "equidistance, 183°",
    "hyperboloid mirror",
    "no lens: rays at random",
)


def draw_points(draw, T_base_grid, rng):
    """Points (n, 999, 2) of rays that meet every grid, not too nearly along it."""
    kept = []
    while sum(map(len, kept)) < RAYS:
        origins, directions = draw(rng)
        hits = [
            intersect_rays_plane(origins, directions, T)
            for T in T_base_grid
        ]
        seen = [
            hit.valid & (np.abs(directions @ T[:3, 2]) >= LEAST_INCIDENCE)
            for hit, T in zip(hits, T_base_grid, strict=True)
        ]
        points = np.stack([hit.points for hit in hits], axis=1)
        kept.append(points[np.all(seen, axis=0)])
    return np.swapaxes(np.concatenate(kept)[:RAYS], 0, 1)


def picture_trial(condition, rng):
    """How far the picture on the base grid is from a homography of each grid."""
    points = draw_points(
        camera_of(condition["camera"]), draw_poses(rng), rng
    )
    largest, in_mm = [], []
    scale = normalising(points[0])[0, 0]
    for own in points[1:]:
        H = homography_dlt(own, points[0])
        gap = np.linalg.norm(apply_homography(H, own) - points[0], axis=1)
        in_mm.append(gap.max())
        largest.append(scale * gap.max())
    return {"residual": max(largest), "residual_mm": max(in_mm)}


@experiment(
    "exp_c4_synth_pinhole",
    artefact="fig_4_1",
    shards={"quick": 1, "full": 1},
)
def synthetic_pictures(effort):
    """Noise-free cameras: is the picture on the base grid one of a pinhole?"""
    conditions = [{"camera": name} for name in CAMERAS]
    return Plan(picture_trial, conditions, TRIALS[effort], SETTINGS)


def centre_off(stage, points):
    """Distance (mm) of the found centre from the true one; None if refused."""
    try:
        found = LINEAR_STAGES[stage](points, side=SIDE)
    except CalibrationError:
        return None
    return float(np.linalg.norm(found.centre - CENTRE_MM))


@experiment(
    "exp_c4_any_pinhole",
    artefact="sec_4_1_1",
    shards={"quick": 1, "full": 1},
)
def exact_centres(effort):
    """Two solvers on the same exact points, for cameras of every kind."""

    conditions = [{"camera": name} for name in CAMERAS]
    return Plan(exact_trial, conditions, TRIALS[effort], SETTINGS)


def exact_trial(condition, rng):
    """The centre's error of both solvers, without noise."""
    draw = camera_of(condition["camera"])
    points = draw_points(draw, draw_poses(rng), rng)
    return {stage: centre_off(stage, points) for stage in SOLVERS}


def noisy_trial(condition, rng):
    """The centre's error of both solvers, with noise."""
    fov_deg = condition["fov_deg"]
    camera = radial_lens() if fov_deg == 100 else equidistance(fov_deg)
    seen = draw_scene(camera, condition["noise_px"], rng)
    return {stage: centre_off(stage, seen.noisy) for stage in SOLVERS}


@experiment(
    "exp_c4_sm_vs_wl",
    artefact="ext_pinhole_methods",
    shards={"quick": 1, "full": 2},
)
def pinhole_methods(effort):
    """Sturm-Maybank and the circles on the same noisy points."""
    conditions = [
        {"fov_deg": 100, "noise_px": noise} for noise in NOISES_PX[effort]
    ]
    conditions += [
        {"fov_deg": fov, "noise_px": 0.5} for fov in FIELDS_DEG[effort]
    ]
    return Plan(noisy_trial, conditions, TRIALS[effort], SETTINGS)


def interpolated(camera, T_base_grid, pixels):
    """Points (n, N, 2) of a 20 mm chessboard by a homography per cell.

    NaN where no whole cell of the board is in the picture.
    """
    half = PITCH_MM * np.ceil(2.5 * CENTRE_MM[2] / PITCH_MM)
    along = np.arange(-half, half + PITCH_MM / 2, PITCH_MM)
    board = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    found = np.full((len(T_base_grid), len(pixels), 2), np.nan)
    for k, T in enumerate(T_base_grid):
        corners = transform(
            inverse_pose(T_BASE_CAMERA) @ T, np.pad(board, ((0, 0), (0, 1)))
        )
        at = camera.project(corners)
        middle = np.full(2, (SIZE_PX - 1) / 2)
        inside = np.linalg.norm(at.pixels - middle, axis=1) <= RADIUS_PX
        visible = (at.valid & inside)[:, None]
        view = BoardView(
            np.where(visible, at.pixels, np.nan), board, len(along), len(along)
        )
        place, points = pixels_on_board(view, SIZE_PX, SIZE_PX)
        table = np.full((SIZE_PX, SIZE_PX, 2), np.nan)
        table[place[:, 1], place[:, 0]] = points
        found[k] = table[pixels[:, 1], pixels[:, 0]]
    return found


def board_trial(condition, rng):
    """Centre errors: base from a chessboard's cells, or from every pixel."""
    camera, T_base_grid = radial_lens(), draw_poses(rng)
    every = pixel_grid(SIZE_PX, SIZE_PX)[:: SIZE_PX // 16 + 1].astype(int)
    every = rng.permutation(every)
    guessed = interpolated(camera, T_base_grid, every)
    exact, seen = back_project(camera, every.astype(float), T_base_grid)
    usable = seen.all(axis=0) & np.isfinite(guessed).all(axis=(0, 2))
    use = np.flatnonzero(usable)[:RAYS]
    mixed = exact[:, use].copy()
    mixed[0] = guessed[0, use]
    noisy = observe(
        camera, T_base_grid, every[use].astype(float), COMPARED_PX, "px", rng
    )
    gap = np.linalg.norm(guessed[0, use] - exact[0, use], axis=1)
    return {
        "rays": len(use),
        "bias_mm": float(np.median(gap)),
        "base interpolated": centre_off("CGSP", mixed),
        "all interpolated": centre_off("CGSP", guessed[:, use]),
        "every pixel, 0.1 px": centre_off("CGSP", noisy.noisy),
        "every pixel, exact": centre_off("CGSP", exact[:, use]),
    }


@experiment(
    "exp_c4_interp_bias_centre",
    artefact="ext_board_as_base",
    shards={"quick": 1, "full": 2},
)
def boards_as_base(effort):
    """A chessboard with interpolation in place of an active base grid."""
    trials = {"quick": 3, "full": 50}[effort]
    return Plan(board_trial, [{}], trials, SETTINGS | {"pitch_mm": PITCH_MM})


def count_trial(condition, rng):
    """Equations of n grids: how many unknowns of the conic they leave open."""
    points = draw_points(
        camera_of(CAMERAS[0]), draw_poses(rng, condition["grids"]), rng
    )
    try:
        found = linear_cgsp(points, side=SIDE)
    except CalibrationError:
        return {"found": 0, "centre_mm": None}
    off = np.linalg.norm(found.centre - CENTRE_MM)
    return {"found": 1, "centre_mm": float(off)}


@experiment(
    "sec_4_1_1_grids", artefact="sec_4_1_1", shards={"quick": 1, "full": 1}
)
def fewest_grids(effort):
    """Two grids, three, four: from when on is there a centre?"""
    conditions = [{"grids": n} for n in (2, 3, 4)]
    return Plan(count_trial, conditions, TRIALS[effort], SETTINGS)
