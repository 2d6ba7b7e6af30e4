"""Section 4.1.1: central cameras, their centres, and a chessboard as base grid.

World = base grid, z = 0; every camera's centre is 600 mm above it.
"""

from functools import partial

import numpy as np

from chapters.shared.central import (
    CENTRE_MM,
    MIN_INCIDENCE,
    PRINCIPAL,
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
    wide_lens,
)
from chapters.shared.general import ZOO
from raxel.calibration import BoardView, linear_cgsp, pixels_on_board
from raxel.cameras import closest_point, pixel_grid
from raxel.errors import CalibrationError
from raxel.geometry import (
    apply_homography,
    homography_dlt,
    intersect_rays_plane,
    inverse_pose,
    normalising,
    on_plane,
    pose,
    rotate,
    rotation_from_vector,
    transform,
)
from repro.run import Plan, crossed, experiment

WIDE_FOV_DEG = 183.0
CONE_DEG = 100.0
# The mirror looks sideways: its x axis down at the grids.
SIDEWAYS = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])


def _of_camera(camera, T_base_camera):
    """A function rng -> rays of random pixels in the base frame."""

    def draw(rng):
        rays = camera.rays(rng.uniform(-0.5, camera.width - 0.5, (4 * RAYS, 2)))
        return (
            transform(T_base_camera, rays.origins[rays.valid]),
            rotate(T_base_camera, rays.directions[rays.valid]),
        )

    return draw


def mirror():
    """Rays of a hyperboloid mirror whose camera is in the focus."""
    camera = ZOO["hyperboloid mirror"]()
    rays = camera.rays(pixel_grid(camera.width, camera.height)[::7])
    shift = CENTRE_MM - SIDEWAYS @ closest_point(rays)
    return _of_camera(camera, pose(SIDEWAYS, shift))


def no_lens():
    """Random rays in a cone: each pixel views an independent direction."""

    def draw(rng):
        z = -rng.uniform(np.cos(np.radians(CONE_DEG / 2)), 1, 4 * RAYS)
        turn = rng.uniform(0, 2 * np.pi, len(z))
        across = np.sqrt(1 - z**2)
        directions = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
        return np.broadcast_to(CENTRE_MM, directions.shape), directions

    return draw


def camera_of(name):
    """The drawing function of one of CAMERAS."""
    if name == "radial lens, 100°":
        return _of_camera(radial_lens(), T_BASE_CAMERA)
    if name == "equidistance, 183°":
        return _of_camera(equidistance(WIDE_FOV_DEG), T_BASE_CAMERA)
    return mirror() if name == "hyperboloid mirror" else no_lens()


CAMERAS = (
    "radial lens, 100°",
    "equidistance, 183°",
    "hyperboloid mirror",
    "no lens: rays at random",
)


def draw_points(draw, T_base_grid, rng):
    """Points (n, 999, 2) of rays that meet every grid, none at grazing incidence."""
    kept = []
    while sum(map(len, kept)) < RAYS:
        origins, directions = draw(rng)
        hits = [intersect_rays_plane(origins, directions, T) for T in T_base_grid]
        seen = [
            hit.valid & (np.abs(directions @ T[:3, 2]) >= MIN_INCIDENCE)
            for hit, T in zip(hits, T_base_grid, strict=True)
        ]
        points = np.stack([hit.points for hit in hits], axis=1)
        kept.append(points[np.all(seen, axis=0)])
    return np.swapaxes(np.concatenate(kept)[:RAYS], 0, 1)


# CGSP's linear stage with two plane-based solvers.
SOLVERS = {"CGSP": linear_cgsp, "CGSP circle": partial(linear_cgsp, pinhole="circle")}
TRIALS = {"quick": 8, "full": 60}
NOISES_PX = {"quick": [0.1, 0.5, 2.0], "full": [0.1, 0.25, 0.5, 1.0, 2.0]}
FIELDS_DEG = {"quick": [60, 150], "full": [60, 90, 120, 150]}
NOISE_PX = 0.5


def image_trial(condition, rng):
    """Residual of the homography from each grid to the base grid."""
    points = draw_points(camera_of(condition["camera"]), draw_poses(rng), rng)
    largest, in_mm = [], []
    scale = normalising(points[0])[0, 0]
    for own in points[1:]:
        H = homography_dlt(own, points[0])
        gap = np.linalg.norm(apply_homography(H, own) - points[0], axis=1)
        in_mm.append(gap.max())
        largest.append(scale * gap.max())
    return {"residual": max(largest), "residual_mm": max(in_mm)}


@experiment("exp_c4_synth_pinhole", artefact="fig_4_1")
def synthetic_images(effort):
    """Noise-free cameras: test for a pinhole image on the base grid."""
    return Plan(image_trial, crossed(camera=CAMERAS), TRIALS[effort], SETTINGS)


def centre_error(solver, points):
    """Distance (mm) of the estimated from the true centre; None if rejected."""
    try:
        found = SOLVERS[solver](points, side=SIDE)
    except CalibrationError:
        return None
    return float(np.linalg.norm(found.centre - CENTRE_MM))


def noisy_trial(condition, rng):
    """The centre's error of both solvers, with noise."""
    fov_deg = condition["fov_deg"]
    seen = draw_scene(wide_lens(fov_deg), condition["noise_px"], rng)
    return {solver: centre_error(solver, seen.noisy) for solver in SOLVERS}


@experiment("exp_c4_sm_vs_wl", artefact="sec_4_1_1")
def pinhole_methods(effort):
    """Sturm-Maybank and the circles on the same noisy points."""
    conditions = [{"fov_deg": 100, "noise_px": noise} for noise in NOISES_PX[effort]]
    conditions += [{"fov_deg": fov, "noise_px": NOISE_PX} for fov in FIELDS_DEG[effort]]
    return Plan(noisy_trial, conditions, TRIALS[effort], SETTINGS)


def count_trial(condition, rng):
    """Centre from n grids, if their equations determine the conic."""
    points = draw_points(
        camera_of(CAMERAS[0]), draw_poses(rng, condition["grids"]), rng
    )
    try:
        found = linear_cgsp(points, side=SIDE)
    except CalibrationError:
        return {"found": 0, "centre_mm": None}
    off = np.linalg.norm(found.centre - CENTRE_MM)
    return {"found": 1, "centre_mm": float(off)}


@experiment("sec_4_1_1_grids", artefact="sec_4_1_1")
def grid_counts(effort):
    """Two, three and four grids: the smallest number that gives a centre."""
    return Plan(count_trial, crossed(grids=(2, 3, 4)), TRIALS[effort], SETTINGS)


PITCH_MM = 20.0
COMPARED_PX = 0.1
REACH = 2.5  # half size of the board, in distances of the camera
FISHEYE_DEG = 150.0
LENSES = ("radial, 100°", "equidistance, 150°")
PITCHES_MM = {"quick": [20.0, 80.0], "full": [20.0, 40.0, 80.0, 160.0]}
EVERY = 13  # step between the pixels used: about 31 000 pixels


def lens_of(name):
    """One of LENSES."""
    return radial_lens() if name == LENSES[0] else equidistance(FISHEYE_DEG)


def interpolated(camera, T_base_grid, pixels, pitch_mm):
    """Points (N, 2) of a chessboard, interpolated by one homography per cell.

    T_base_grid: (4, 4). NaN where no whole cell is in the circular image.
    """
    half = pitch_mm * np.ceil(REACH * CENTRE_MM[2] / pitch_mm)
    along = np.arange(-half, half + pitch_mm / 2, pitch_mm)
    board = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    T_camera_grid = inverse_pose(T_BASE_CAMERA) @ T_base_grid
    at = camera.project(transform(T_camera_grid, on_plane(board)))
    off = np.linalg.norm(at.pixels - PRINCIPAL, axis=1)
    visible = (at.valid & (off <= RADIUS_PX))[:, None]
    corners = np.where(visible, at.pixels, np.nan)
    view = BoardView(corners, board, len(along), len(along))
    places, points = pixels_on_board(view, SIZE_PX, SIZE_PX)
    table = np.full((SIZE_PX, SIZE_PX, 2), np.nan)
    table[places[:, 1], places[:, 0]] = points
    return table[pixels[:, 1], pixels[:, 0]]


def board_trial(condition, rng):
    """Centre errors: the base from a chessboard's cells, or from every pixel."""
    camera, T_base_grid = lens_of(condition["lens"]), draw_poses(rng)
    pixels = rng.permutation(pixel_grid(SIZE_PX, SIZE_PX)[::EVERY].astype(int))
    exact, seen = back_project(camera, pixels.astype(float), T_base_grid)
    boards = T_base_grid if condition["all_grids"] else T_base_grid[:1]
    pitch = condition["pitch_mm"]
    guessed = np.stack([interpolated(camera, T, pixels, pitch) for T in boards])
    found = np.isfinite(guessed).all(axis=(0, 2))
    use = np.flatnonzero(seen.all(axis=0) & found)[:RAYS]
    exact, guessed = exact[:, use], guessed[:, use]
    measured = observe(camera, T_base_grid, pixels[use] + 0.0, COMPARED_PX, "px", rng)
    gap = np.linalg.norm(guessed[0] - exact[0], axis=1)
    return {
        "rays": len(use),
        "gap_mm": float(np.median(gap)),
        "base_mm": centre_error("CGSP", np.stack([guessed[0], *exact[1:]])),
        "all_mm": centre_error("CGSP", guessed) if len(boards) > 1 else None,
        "noise_mm": centre_error("CGSP", measured.noisy),
    }


@experiment("exp_c4_interp_bias_centre", artefact="sec_4_1_1")
def boards_as_base(effort):
    """Case of the claim: 20 mm squares in front of the camera of 4.1.5."""
    conditions = crossed(lens=LENSES[:1], pitch_mm=[PITCH_MM], all_grids=[True])
    return Plan(board_trial, conditions, {"quick": 4, "full": 50}[effort], SETTINGS)


@experiment("ext_board_as_base_sweep", artefact="ext_board_as_base")
def pitches(effort):
    """Larger squares, and a lens with more distortion."""
    conditions = crossed(lens=LENSES, pitch_mm=PITCHES_MM[effort], all_grids=[False])
    return Plan(board_trial, conditions, {"quick": 3, "full": 20}[effort], SETTINGS)


COLUMNS, ROWS, DRAWN_PITCH_MM = 9, 7, 190.0
BOARD_MM = np.array([0.0, 0.0, -480.0])
TILT_DEG = np.array([24.0, -12.0, 12.0])


def board_pose():
    """T_base_board: from the camera, the board is behind the base grid."""
    return pose(rotation_from_vector(np.radians(TILT_DEG)), BOARD_MM)


def scene_trial(condition, rng):
    """Corners of the board: in space, in the camera image, on the base grid."""
    camera = equidistance(WIDE_FOV_DEG)
    at = DRAWN_PITCH_MM * (np.indices((ROWS, COLUMNS))[::-1].T - [4, 3])
    corners = on_plane(np.swapaxes(at, 0, 1))
    corners = transform(board_pose(), corners.reshape(-1, 3))
    seen = camera.project(transform(inverse_pose(T_BASE_CAMERA), corners))
    rays = corners - CENTRE_MM
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    hits = intersect_rays_plane(CENTRE_MM, rays, np.eye(4))
    lattice = ROWS, COLUMNS
    return {
        "corners": corners.reshape(*lattice, 3),
        "picture": seen.pixels.reshape(*lattice, 2),
        "synthetic": hits.points.reshape(*lattice, 2),
    }


@experiment("fig_4_1_scene", artefact="fig_4_1")
def scene(effort):
    """One board, its image in a fisheye and its image on the base grid."""
    settings = SETTINGS | {"fov_deg": WIDE_FOV_DEG, "pitch_mm": DRAWN_PITCH_MM}
    return Plan(scene_trial, [{}], 1, settings)
