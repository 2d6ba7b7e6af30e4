"""Trials of this page, their conditions and constants."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from chapters.shared.grids import SIZE_PX
from raxel.calibration import BoardView, cell_maps, locate_pixels
from raxel.cameras import (
    BrownCamera,
    Camera,
    PerspectiveCamera,
    PlanarMirrorsCamera,
    pixel_grid,
)
from raxel.features.active_grid import decode
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.lab import (
    Laboratory,
    Monitor,
    MonitorPattern,
    Optics,
    Sensor,
    monitor_scene,
    points_seen,
    trace,
)
from raxel.sets import ActiveGrid, patterns_of, plan_of_cells
from repro.run import Plan, experiment

# An active grid rendered by the simulator, and decoded.


LIGHT = Monitor(gamma=2.2, black_level=0.004, falloff_exponent=1.5)
SENSOR = Sensor(white_e=9000.0, full_well_e=12000.0, read_noise_e=15.0, gamma=2.2)
OPTICS = Optics(blur_sd_px=(0.7, 0.7))
SMOOTHED = {"7 x 7": True, "none": False}


def rendered_images(camera, grid, T_camera_grid, rng):
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
    images, patterns = rendered_images(camera, grid, T_camera_grid, rng)
    seen = points_seen(camera, T_camera_grid, grid.monitor_mm)
    decoded = {
        name: decode(images, patterns, grid, smooth=smooth, linear=True, threads=1)
        for name, smooth in SMOOTHED.items()
    }
    return {name: found.location - seen for name, found in decoded.items()}, seen


# Interpolation of the grid point of a pixel from nearby corners.


# Number of nearest corners from which four are chosen.
CANDIDATES = 24


def places_of(view):
    """Column and row (N, 2) of each corner of a BoardView."""
    row, column = np.divmod(np.arange(len(view.pixels)), view.columns)
    return np.column_stack([column, row])


def nearest_four(pixels, corners, places):
    """The four nearest corners of each pixel, no three on one line of the grid.

    pixels: (M, 2); corners: (N, 2) px; places: (N, 2) int, column and row. Nearer
    corners come first, and a corner collinear with two others is skipped.
    Returns (M, 4) int, -1 where too few are left.
    """
    from scipy.spatial import cKDTree

    count = min(CANDIDATES, len(corners))
    candidates = cKDTree(corners).query(pixels, count)[1]
    taken = np.full((len(pixels), 4), -1)
    number = np.zeros(len(pixels), int)
    for candidate in candidates.T:
        good = number < 4
        for a, b in zip(*np.triu_indices(4, 1), strict=True):
            u = places[taken[:, a]] - places[candidate]
            v = places[taken[:, b]] - places[candidate]
            in_line = u[:, 0] * v[:, 1] == u[:, 1] * v[:, 0]
            good &= ~(in_line & (number > b))
        rows = np.flatnonzero(good)
        taken[rows, number[rows]] = candidate[rows]
        number[rows] += 1
    taken[number < 4] = -1
    return taken


def through_four(pixels, corners, points):
    """Points (M, 2) by the homography through four corners (M, 4, 2) of each pixel."""
    maps = cell_maps(corners, points)
    mapped = np.einsum("mij,mj->mi", maps[..., :2], pixels) + maps[..., 2]
    return mapped[:, :2] / mapped[:, 2:]


def by_nearest_four(pixels, view):
    """Step 2 of Algorithm 1 as described in section 3.2.1."""
    four = nearest_four(pixels, view.pixels, places_of(view))
    return through_four(pixels, view.pixels[four], view.points[four])


def by_enclosing_cell(pixels, view):
    """The same with the corners of the square that contains the pixel."""
    return locate_pixels(pixels, view)[0]


FOUR = {"nearest four": by_nearest_four, "enclosing cell": by_enclosing_cell}


# A camera that views a monitor in two flat mirrors.


WIDTH_PX, FOCAL_PX = 480, 600.0
RIDGE_MM, MONITOR_MM = 300.0, 400.0  # camera to ridge, ridge to monitor
RAISED_DEG, FACET_DEG = 20.0, 1.5
RIDGE_PX = (WIDTH_PX - 1) / 2  # column of the ridge, which is upright
TILT_DEG, SHIFT_MM = 10.0, 20.0
PITCH_MM = 20.0
GROSS_MM = 1.0
GRID = ActiveGrid((1920, 1200), (518.0, 324.0))


def turned(*vector_deg):
    """Rotation (3, 3) by a vector in degrees."""
    return rotation_from_vector(np.radians(vector_deg))


@cache
def two_facets(facet_deg, height_px):
    """The camera: facet 0 at the left of an upright ridge, facet 1 at its right.

    Each is rotated away from the other by facet_deg, and raised so that the camera
    views the monitor above itself.
    """
    middle = [RIDGE_PX, (height_px - 1) / 2]
    K = [[FOCAL_PX, 0, middle[0]], [0, FOCAL_PX, middle[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, (), WIDTH_PX, height_px)
    raised = turned(-RAISED_DEG, 0, 0)
    poses, outlines = [], []
    for side in (-1, 1):
        R = raised @ turned(0, -side * facet_deg, 0)
        poses.append(pose(R, [0, 0, RIDGE_MM]))
        outline = np.array([[0, -200], [side * 250, -200]])
        outlines.append(np.vstack([outline, outline[::-1] * [1, -1]]))
    return PlanarMirrorsCamera(viewer, np.array(poses), outlines)


def monitor_pose(rng):
    """Pose (4, 4) of the screen, orthogonal to the reflected axis, then perturbed."""
    up = math.radians(2 * RAISED_DEG)
    away = np.array([0.0, -math.sin(up), -math.cos(up)])
    across = np.array([-1.0, 0.0, 0.0])
    R = np.column_stack([across, np.cross(away, across), away])
    R = R @ turned(*rng.uniform(-TILT_DEG, TILT_DEG, 2), 0)
    middle = [0, 0, RIDGE_MM] + MONITOR_MM * away
    middle = middle + R @ [*rng.uniform(-SHIFT_MM, SHIFT_MM, 2), 0]
    return pose(R, middle - R @ [*np.divide(GRID.monitor_mm, 2), 0])


def chessboard_corners(camera, T_camera_monitor):
    """Visible corners of a chessboard in place of the monitor's screen.

    Returns pixels (N, 2), points (N, 2) mm, places (N, 2) int and the facet (N,).
    """
    count = np.array(GRID.monitor_mm) // PITCH_MM
    places = np.stack(
        np.meshgrid(*(np.arange(n + 1, dtype=int) for n in count)), -1
    ).reshape(-1, 2)
    points = PITCH_MM * places
    space = transform(T_camera_monitor, on_plane(points))
    found = []
    for facet in range(2):
        seen = camera.project_facet(space, facet)
        here = np.flatnonzero(seen.valid)
        own = np.full(len(here), facet)
        found.append((seen.pixels[here], points[here], places[here], own))
    return [np.concatenate(part) for part in zip(*found, strict=True)]


def interpolated(pixels, corners, facets=None):
    """Points (M, 2) of pixels by their four nearest corners, NaN without four.

    corners: as `chessboard_corners`. facets: (M,) facet of each pixel, if known.
    Then only corners of the same facet are used.
    """
    seen, points, places, own = corners
    found = np.full(pixels.shape, np.nan)
    groups = [(slice(None), slice(None))]
    if facets is not None:
        groups = [(facets == k, own == k) for k in range(2)]
    for asked, given in groups:
        four = nearest_four(pixels[asked], seen[given], places[given])
        part = np.full((len(four), 2), np.nan)
        good = four[:, 0] >= 0
        four = four[good]
        part[good] = through_four(
            pixels[asked][good], seen[given][four], points[given][four]
        )
        found[asked] = part
    return found


def ridge_distance(pixels):
    """Distance (M,) px of pixels (M, 2) from the ridge."""
    return np.abs(pixels[:, 0] - RIDGE_PX)


def jump_mm(camera, T_camera_monitor):
    """Distance in mm on the monitor between both sides of the ridge, mid-image."""
    sides = [[RIDGE_PX + d, camera.height / 2] for d in (-1e-6, 1e-6)]
    rays = camera.rays(np.array(sides))
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_monitor)
    return float(np.linalg.norm(met[0][1] - met[0][0]))


def square_px(corners):
    """Mean width in px of a square, over neighbours in a row within a facet."""
    seen, _, places, own = corners
    adjacent = np.all(np.diff(places, axis=0) == [1, 0], axis=1)
    adjacent &= np.diff(own) == 0
    steps = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    return float(steps[adjacent].mean())


# The camera and the grid of section 3.2.1.


SIDE_MM, MIDDLE_MM = 300.0, 150.0
FOCAL_MM, RADIAL = 680.0, (-0.8, 0.4)
PIXEL_MM = 0.3
POINTS = 500
SETTINGS = {
    "points": POINTS,
    "grid_mm": SIDE_MM,
    "f_mm": FOCAL_MM,
    "k": list(RADIAL),
    "pixel_mm": PIXEL_MM,
}


@dataclass(frozen=True, eq=False)
class GridScene:
    """A square grid of SIDE_MM in front of a camera, first corner at its origin."""

    camera: Camera
    T_camera_grid: np.ndarray

    def pixels(self, points):
        """Pixels of points (..., 2) mm of the grid; NaN if not visible."""
        flat = np.reshape(points, (-1, 2))
        seen = transform(self.T_camera_grid, on_plane(flat))
        return self.camera.project(seen).pixels.reshape(np.shape(points))

    def view(self, pitch_mm):
        """Its corners from border to border, as a BoardView."""
        count = round(SIDE_MM / pitch_mm) + 1
        row, column = np.divmod(np.arange(count**2), count)
        points = pitch_mm * np.column_stack([column, row])
        return BoardView(self.pixels(points), points, count, count)


def lens(share=1.0):
    """The camera of 3.2.1 with a share of its distortion.

    The grid is one focal length away (E-3.07) and fills the image of 1000 px. One
    pixel covers PIXEL_MM of it.
    """
    focal, middle = FOCAL_MM * SIZE_PX / SIDE_MM, (SIZE_PX - 1) / 2
    K = [[focal, 0, middle], [0, focal, middle], [0, 0, 1]]
    radial = tuple(share * np.array(RADIAL))
    camera = BrownCamera(K, radial, (0, 0), SIZE_PX, SIZE_PX)
    return GridScene(camera, facing(FOCAL_MM))


def facing(distance_mm):
    """Pose (4, 4) of the grid, fronto-parallel to the camera."""
    return pose(np.eye(3), [-MIDDLE_MM, -MIDDLE_MM, distance_mm])


def rms(errors):
    """Root mean square length of vectors (..., 2), NaN excluded."""
    return float(np.sqrt(np.nanmean(np.sum(np.square(errors), axis=-1))))


# Interpolation and decoding at the ridge of two mirrors.


HEIGHT_PX = {"quick": 60, "full": 360}


def ridge_trial(condition, rng):
    """Interpolation and decoding near the ridge of two mirrors, RMS in mm."""
    camera = two_facets(condition["facet_deg"], condition["height_px"])
    T_camera_monitor = monitor_pose(rng)
    corners = chessboard_corners(camera, T_camera_monitor)
    errors, seen = decoding_errors(camera, GRID, T_camera_monitor, rng)
    pixels, seen = (pixel_grid(camera.width, camera.height), seen.reshape(-1, 2))
    errors = {k: e.reshape(-1, 2).astype(float) for k, e in errors.items()}
    near = ridge_distance(pixels) <= square_px(corners)
    near &= np.isfinite(seen[:, 0])
    trusted = near & np.all([np.isfinite(e[:, 0]) for e in errors.values()], axis=0)
    pixels, seen = pixels[trusted], seen[trusted]
    own = camera.facet_of(pixels)
    errors = {k: e[trusted] for k, e in errors.items()} | {
        "unknown": interpolated(pixels, corners) - seen,
        "known": interpolated(pixels, corners, own) - seen,
    }
    column, of_column = np.unique(pixels[:, 0], return_inverse=True)
    found = {
        "jump_mm": jump_mm(camera, T_camera_monitor),
        "trusted": float(trusted.sum() / near.sum()),
        "from_ridge_px": column - RIDGE_PX,
    }
    for name, error in errors.items():
        size = np.linalg.norm(error, axis=1)
        found[name] = {
            "rms_mm": rms(error),
            "gross": float(np.mean(size > GROSS_MM)),
            "by_column_mm": np.array(
                [rms(error[of_column == k]) for k in range(len(column))]
            ),
        }
    return found


@experiment("exp_c3_interp_discontinuous", artefact="sec_3_2_1")
def ridge(effort):
    """The camera of two facets."""
    stated = {"facet_deg": FACET_DEG, "height_px": HEIGHT_PX[effort]}
    trials = {"quick": 1, "full": 8}[effort]
    return Plan(ridge_trial, [stated], trials, SETTINGS)
