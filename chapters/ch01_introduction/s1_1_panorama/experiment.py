"""The camera of Fig. 1.1 in a room, alternative mirrors, and what is measured."""

from dataclasses import replace
from functools import cache
from pathlib import PurePosixPath

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.cameras import OrthographicCamera, PerspectiveCamera, QuadricMirrorCamera
from raxel.geometry import inverse_pose, pose, transform
from raxel.lab import Laboratory, room
from raxel.multiview import FAR_RANGE_MM, cylindrical_view
from raxel.show import drawn_poses

RIG = "panorama-hyperboloid"
RIGS = ("data/rigs/panorama-hyperboloid.yaml",)
# The camera looks straight up, and the top of its image is the forward direction.
# Columns: its x, y and z axes in the world (x right, y down, z forward).
R_WORLD_CAMERA = np.array([[-1.0, 0, 0], [0, 0, -1.0], [0, -1.0, 0]])
DOWN, AHEAD = R_WORLD_CAMERA.T @ [0, 1, 0], R_WORLD_CAMERA.T @ [0, 0, 1]
ON_EDGE = 60
LEVEL_MM = 2000.0
# Search range (px) for a border around its expected column.
SEARCH_PX = 3
MIN_STEP = 12.0
MIN_N_ROWS = 8
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@cache
def simulator(size):
    """Return the rig with `size` times its pixels in each direction."""
    rig = rig_named(RIG)
    mirror, viewer = rig.camera, rig.camera.viewer
    width, height = (round(size * n) for n in (viewer.width, viewer.height))
    # Pixel centres are at integers: an image starts at -0.5.
    K = np.diag([size, size, 1.0]) @ viewer.K
    K[:2, 2] += (size - 1) / 2
    camera = QuadricMirrorCamera(
        PerspectiveCamera(K, viewer.radial, width, height),
        mirror.shape,
        mirror.axes,
        mirror.rim_radius,
        mirror.T_viewer_mirror,
        mirror.side,
        mirror.hole_radius,
    )
    pupil = size * rig.optics.exit_pupil_px
    return Laboratory(camera, rig.sensor, replace(rig.optics, exit_pupil_px=pupil))


def T_world_camera(camera):
    """Return the pose with the mirror's inner focus in the middle of the room."""
    return pose(R_WORLD_CAMERA, -R_WORLD_CAMERA @ camera.centre)


def view_of(camera):
    """Return the cylinder about the mirror's focus, as wide as the image."""
    return cylindrical_view(camera, DOWN, AHEAD, camera.width)


@cache
def uprights():
    """Return points (edges, ON_EDGE, 3), world, on the room's vertical edges."""
    ends = room().straight_edges
    run = np.abs(ends[:, 1] - ends[:, 0])
    upright = (run[:, 0] < 1e-6) & (run[:, 2] < 1e-6)
    share = np.linspace(0, 1, ON_EDGE)[:, None]
    start, stop = ends[upright][:, :1], ends[upright][:, 1:]
    return start + share * (stop - start)


def unwrapped_places(camera, view, points):
    """Return the panorama positions (N, 2) of world points (N, 3).

    A point is projected into the source image and unwrapped with the ray of that
    pixel. NaN where the source image does not show the point.
    """
    T_camera_world = inverse_pose(T_world_camera(camera))
    rays = camera.rays(camera.project(transform(T_camera_world, points)).pixels)
    return view.project(rays.origins + LEVEL_MM * rays.directions)


def through_the_mirror(camera, view):
    """Return the largest row error of the horizon and column spread of uprights, px."""
    azimuth = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    level = LEVEL_MM * np.column_stack(
        [np.sin(azimuth), np.zeros(360), np.cos(azimuth)]
    )
    rows = unwrapped_places(camera, view, level)[:, 1]
    points = uprights()
    places = unwrapped_places(camera, view, points.reshape(-1, 3))
    columns = places[:, 0].reshape(points.shape[:2])
    columns = columns[np.isfinite(columns).any(axis=1)]
    spread = np.nanmax(columns, axis=1) - np.nanmin(columns, axis=1)
    return float(np.abs(rows - view.horizon).max()), float(spread.max())


def borders(unwrapped, camera, view):
    """Return the upright borders detected in the panorama.

    Rows (n, 4): expected column (px) of an upright edge of the room, median column of
    the brightness steps near it, their median absolute deviation from it (px), and the
    number of rows with a step. The step may belong to a border next to the edge:
    straightness is measured, not position. Edges at the seam, hidden edges and edges
    next to several steps are excluded.
    """
    grey = unwrapped @ LUMINANCE
    T_camera_world = inverse_pose(T_world_camera(camera))
    out = []
    for points in np.unique(np.round(uprights(), 3), axis=0):
        places = view.project(transform(T_camera_world, points))
        column, (top, bottom) = places[0, 0], np.sort(places[[0, -1], 1])
        # Near its ends an edge meets other edges.
        rows = np.arange(np.ceil(top) + 2, np.floor(bottom) - 1).astype(int)
        rows = rows[(rows > 0) & (rows < view.height - 1)]
        found = steps_along(grey, column, rows)
        found = found[np.isfinite(found)]
        if len(found) >= MIN_N_ROWS:
            middle = np.median(found)
            off = np.median(np.abs(found - middle))
            out.append((column, middle, off, len(found)))
    return np.array(out).reshape(-1, 4)


def steps_along(grey, column, rows):
    """Return the columns (rows,) of the brightness step nearest to `column`, or NaN.

    The position of a step is the mean column of the gradient, weighted by its size,
    within a few pixels.
    """
    first = round(column) - SEARCH_PX
    window = np.arange(first, first + 2 * SEARCH_PX + 1)
    if window[0] < 1 or window[-1] > grey.shape[1] - 2 or not len(rows):
        return np.full(len(rows), np.nan)
    slope = (grey[rows][:, window + 1] - grey[rows][:, window - 1]) / 2
    signed = slope.sum(axis=1)
    # A thin frame has two steps, up and down: no single position.
    single = np.abs(signed) > 0.9 * np.abs(slope).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        places = slope @ window / signed
    return np.where(single & (np.abs(signed) > MIN_STEP), places, np.nan)


RIG_MIRROR = "rig"
# Eccentricities of mirrors with the same rim; 1 is a paraboloid.
ECCENTRICITIES = {
    "paraboloid": 1.0,
    "hyperboloid 1.05": 1.05,
    RIG_MIRROR: None,
    "hyperboloid 1.25": 1.25,
}
HIGHEST_DEG = 50.0
RIM_MM, RIM_PX = 37.5, 475.0
WIDTH, HEIGHT = 1280, 960
MIDDLE = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
STEP_PX = 0.05
BANDS_DEG = np.arange(0.1, 45.0, 0.1)
MIN_RATIO = 1.5


def mirror_camera(name):
    """Return a central camera whose rim is at the rig's highest elevation.

    The rig itself, or a mirror of the same rim radius in the world and in the image.
    In polar form about the inner focus a mirror is at R / (1 + e cos psi), with psi the
    angle from straight down.
    """
    e = ECCENTRICITIES[name]
    if e is None:
        return simulator(1.0).camera
    psi = np.radians(90 + HIGHEST_DEG)
    R = RIM_MM * (1 + e * np.cos(psi)) / np.sin(psi)
    if e == 1:
        viewer = OrthographicCamera(RIM_PX / RIM_MM, MIDDLE, WIDTH, HEIGHT)
        return QuadricMirrorCamera.aligned(viewer, "paraboloid", [R / 2], RIM_MM)
    a = R / (e * e - 1)
    b = a * np.sqrt(e * e - 1)
    focal = RIM_PX / np.tan(viewer_angle(e, psi))
    K = [[focal, 0, MIDDLE[0]], [0, focal, MIDDLE[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [], WIDTH, HEIGHT)
    return QuadricMirrorCamera.aligned(viewer, "hyperboloid", [a, b], RIM_MM)


def viewer_angle(e, psi):
    """Return the angle (rad) at the camera of a direction psi from straight down."""
    return 2 * np.arctan((e - 1) / (e + 1) * np.tan(psi / 2))


def jacobians(camera, view, pixels):
    """Return the Jacobians (N, 2, 2) of source pixels by panorama pixels (N, 2)."""
    columns = []
    for step in STEP_PX * np.eye(2):
        ahead, behind = (
            camera.project(
                view.centre + FAR_RANGE_MM * view.directions(pixels + side * step)
            ).pixels
            for side in (1, -1)
        )
        columns.append((ahead - behind) / (2 * STEP_PX))
    return np.stack(columns, axis=-1)


def scales(camera, view, elevations):
    """Return source px per panorama px, (N,) each: area, along row and column.

    At elevations (N,), radians, in the middle column. The mirror is a surface of
    revolution, so all columns are alike.
    """
    v = view.horizon - view.radius * np.tan(elevations)
    J = jacobians(camera, view, np.column_stack([np.full_like(v, view.middle), v]))
    along = np.linalg.norm(J, axis=1)
    return np.abs(np.linalg.det(J)), along[:, 0], along[:, 1]


RIG_SEED = 0
# All but those of quick builds, whose names end in -small.
RIG_FILES = (
    "data/rigs/active-grid-demo.yaml",
    "data/rigs/coolpix-4500-fce8-boards.yaml",
    "data/rigs/coolpix-4500-fce8.yaml",
    "data/rigs/coolpix-fce8-zoom-1.yaml",
    "data/rigs/coolpix-fce8-zoom-2.yaml",
    "data/rigs/coolpix-fce8-zoom-3.yaml",
    "data/rigs/d200-boards.yaml",
    "data/rigs/d200-fisheye.yaml",
    "data/rigs/d200-lens-sharp.yaml",
    "data/rigs/d200-lens.yaml",
    "data/rigs/fisheye-12x9.yaml",
    "data/rigs/fisheye-9x7.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror.yaml",
    "data/rigs/hyperboloidal.yaml",
    "data/rigs/kodak-boards.yaml",
    "data/rigs/kodak-megaplus.yaml",
    "data/rigs/large-fisheye.yaml",
    "data/rigs/large-hyperboloidal.yaml",
    "data/rigs/mirror-ball.yaml",
    "data/rigs/monitor-d200.yaml",
    "data/rigs/onevr-d70-boards.yaml",
    "data/rigs/onevr-d70.yaml",
    "data/rigs/ordinary-lens.yaml",
    "data/rigs/panorama-hyperboloid.yaml",
    "data/rigs/spherical.yaml",
)
RIG_NAMES = tuple(PurePosixPath(path).stem for path in RIG_FILES)


def rig_trial(condition, rng):
    """Return the poses of a rig's targets, as `raxel render` draws them."""
    rig = rig_named(condition["rig"])
    return {
        "T_camera_target": drawn_poses(rig, RIG_SEED),
        "width_px": rig.camera.width,
        "height_px": rig.camera.height,
        "kind": rig.camera.kind,
    }
