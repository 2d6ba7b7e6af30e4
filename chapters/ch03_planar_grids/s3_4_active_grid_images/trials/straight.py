"""Fig. 3.17: a room through a fisheye, remapped to an active grid's plane."""

import json
from functools import cache

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import (
    capture_of,
    decoded,
    rig_of,
)
from raxel.geometry import inverse_pose, pose, rotation_from_vector, transform
from raxel.lab import room
from raxel.multiview.plane_view import remap_to_plane
from repro.run.columns import columns

# Heading to the right; the camera is level in the middle of the room.
HEADING_DEG = {"long wall": 90.0, "corner": 45.0}
COLOURED = "long wall"
MM_PER_PX = 0.25
# Step along an edge, search range to both sides, and its resolution.
STEP_PX, SEARCH_PX, FINE_PX = 4.0, 4.0, 0.25
HALF_EDGE_PX, WIDTH = 1.5, 9
MIN_SLOPE = 3.0  # grey levels per px
MIN_POINTS, MIN_LENGTH_PX = 20, 100.0
HIDDEN_MM = 5.0
ALONG_EDGE = 801  # points, about a px apart on the longest
# Points farther from the cubic curve (in robust SDs) belong to another edge.
MAX_SDS, MIN_SD_PX = 4.0, 0.05
DOWN = np.array([0.0, 1.0, 0.0])
# Arrays of a trial, one entry per measured edge.
OF_EDGE = (
    "edge",
    "place",
    "before.found",
    "before.projected",
    "after.found",
    "after.projected",
    "vertical",
    "lean_deg",
    "predicted_deg",
)


def T_world_camera(view):
    """Return the camera's pose in the room, (4, 4) mm."""
    turn = np.array([0.0, np.radians(HEADING_DEG[view]), 0.0])
    return pose(rotation_from_vector(turn), np.zeros(3))


@cache
def furnished():
    """Return the room, whose textures take a while to render."""
    return room()


@cache
def room_light(rig, view):
    """Return the light of the room on the sensor, (H, W, 3) for the coloured view."""
    laboratory = rig_of(rig).laboratory()
    return laboratory.irradiance(
        furnished(), T_world_camera(view), colour=view == COLOURED
    )


def straight_trial(condition, rng):
    """Return deviations and inclinations of the room's edges before and after.

    condition: rig, seed, pose (its number), view of the room; drawn: whether the
    images are kept. Returns by edge the deviation from its best line as a share of
    its length, before and after, from detected points and from points projected
    from truth. Also returns the angle of verticals to the image columns, the angle
    predicted from the grid's pose, and the edge's position (px) in the remapped
    image.
    """
    rig = rig_of(condition["rig"])
    image_set, view = capture_of(condition["rig"], condition["seed"], condition["pose"])
    grid, _ = decoded(image_set, view)
    light = room_light(condition["rig"], condition["view"])
    if not condition["drawn"]:
        light = grey(light)
    taken = rig.sensor.expose(light, rng, colour=light.ndim == 3)
    size = image_set.target.monitor_mm
    laid, seen = remap_to_plane(
        taken, grid.location, grid.sigma, grid.mask, size, MM_PER_PX
    )
    truth = true_pose(image_set, view)
    pictures = grey(taken), np.where(seen, grey(laid), np.nan)
    paths = visible_paths(condition["rig"], condition["view"])
    rows = []
    for k, (edge, path) in enumerate(zip(room_edges(), paths, strict=True)):
        pixels, places, at, on = edge_in_both(grid, path, pictures)
        if len(places) < MIN_POINTS or length(places) < MIN_LENGTH_PX:
            continue
        bends = map(bend, (at, pixels, on, places))
        angles = lean(on), predicted_lean(truth, places)
        rows.append((k, places.mean(axis=0), *bends, is_vertical(edge), *angles))
    drawn = {"taken": taken, "laid": laid} if condition["drawn"] else {}
    of_edges = columns(OF_EDGE, rows)
    return drawn | {
        **{name: np.array(cells) for name, cells in of_edges.items()},
        "pitch_deg": pitch_of(truth),
        "share_seen": float(grid.mask.mean()),
        "half_angle_deg": half_angle(rig.camera, grid.mask),
    }


def edge_in_both(grid, path, pictures):
    """Return points of an edge before and after remapping, projected and detected.

    path: pixels (n, 2) that see it; pictures: before and after. Returns (m, 2) px
    each: projected before, projected after, detected before and after; empty if too
    little of the edge is decoded.
    """
    places = location_at(grid, path)
    known = np.isfinite(places[:, 0])
    if known.sum() < MIN_POINTS:
        return (np.empty((0, 2)),) * 4
    both = path[known], places[known] / MM_PER_PX - 0.5
    found = [edge_points(*pair) for pair in zip(pictures, both, strict=True)]
    clear = smooth_run(found[0]) & smooth_run(found[1])
    return [points[clear] for points in (*both, *found)]


def true_pose(image_set, view):
    """Return T_camera_grid of a view from the truth of its set."""
    poses = json.loads((image_set.folder / "truth/poses.json").read_text("utf-8"))
    return np.array(poses["T_camera_target"][view.label])


def room_edges():
    """Return the room's straight edges longer than half a metre, (n, 2, 3) mm."""
    edges = furnished().straight_edges
    return edges[np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) > 500]


def is_vertical(edge):
    """Return whether an edge (2, 3) is vertical."""
    return bool(np.abs(edge[1] - edge[0])[[0, 2]].max() < 1e-6)


@cache
def visible_paths(rig, view):
    """Return for each edge of the room the pixels (n, 2) that see it."""
    camera = rig_of(rig).camera
    return [visible_pixels(camera, edge, view) for edge in room_edges()]


def visible_pixels(camera, edge, view):
    """Return pixels (n, 2), a few px apart, of the visible points of an edge."""
    T = T_world_camera(view)
    share = np.linspace(0, 1, ALONG_EDGE)[:, None]
    points = edge[0] + share * (edge[1] - edge[0])
    pixels, valid = camera.project(transform(inverse_pose(T), points))
    valid &= camera.in_image(pixels)
    valid[valid] = not_hidden(T[:3, 3], points[valid])
    points, pixels = points[valid], pixels[valid]
    if len(pixels) < 2:
        return np.empty((0, 2))
    steps = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    along = np.append(0, np.cumsum(steps))
    return pixels[np.searchsorted(along, np.arange(0, along[-1], STEP_PX))]


def not_hidden(eye, points):
    """Return which points (n, 3) of the room's walls are not occluded."""
    lines = points - eye
    far = np.linalg.norm(lines, axis=1)
    nearest = np.min(
        [
            part.hit(eye[None], lines / far[:, None]).distance
            for part in furnished().surfaces
        ],
        axis=0,
    )
    return nearest > far - HIDDEN_MM


def location_at(grid, pixels):
    """Return positions (n, 2) mm seen by subpixel points; NaN where unknown."""
    first = np.floor(pixels).astype(int)
    height, width = grid.mask.shape
    inside = ((first >= 0) & (first + 1 < [width, height])).all(axis=1)
    u, v = np.where(inside[:, None], first, 0).T
    across, down = np.moveaxis(pixels - first, 1, 0)[..., None]
    places = np.where(grid.mask[..., None], grid.location, np.nan)
    upper = (1 - across) * places[v, u] + across * places[v, u + 1]
    lower = (1 - across) * places[v + 1, u] + across * places[v + 1, u + 1]
    mixed = (1 - down) * upper + down * lower
    return np.where(inside[:, None], mixed, np.nan)


def grey(picture):
    """Return an image in grey, float."""
    if picture.ndim == 2:
        return picture.astype(float)
    return picture @ np.array([0.299, 0.587, 0.114])


def edge_points(picture, path):
    """Return points (n, 2) of the steepest intensity across a path (n, 2), or NaN."""
    from scipy.ndimage import map_coordinates, uniform_filter1d

    ahead = np.gradient(path, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    across = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    offsets = np.arange(-SEARCH_PX, SEARCH_PX + FINE_PX / 2, FINE_PX)
    spots = path[:, None] + offsets[:, None] * across[:, None]
    values = map_coordinates(
        picture, [spots[..., 1], spots[..., 0]], order=1, cval=np.nan
    )
    slopes = np.abs(np.diff(values, axis=1)) / FINE_PX
    slopes[~np.isfinite(slopes)] = 0
    smooth = uniform_filter1d(slopes, WIDTH, axis=1)
    k = smooth.argmax(axis=1)
    at = (offsets[1:] + offsets[:-1]) / 2
    # Centre of the steep part: slopes of bilinear interpolation are steps.
    place = at[k]
    for _ in range(5):
        inside = HALF_EDGE_PX - np.abs(at - place[:, None])
        weight = np.clip(inside / FINE_PX + 0.5, 0, 1) * slopes
        place = weight @ at / np.maximum(weight.sum(axis=1), 1e-9)
    inner = np.abs(at[k]) <= SEARCH_PX - HALF_EDGE_PX
    steep = inner & (smooth[np.arange(len(k)), k] > MIN_SLOPE)
    return path + np.where(steep, place, np.nan)[:, None] * across


def smooth_run(points):
    """Return which points (n, 2) of a sequence are near a cubic curve through them."""
    found = np.isfinite(points[:, 0])
    if found.sum() < MIN_POINTS:
        return np.zeros(len(points), bool)
    centre, along = best_line(points[found])
    s = (points - centre) @ along
    off = (points - centre) @ [-along[1], along[0]]
    rows = np.vander(s / np.ptp(s[found]), 4)
    for _ in range(3):
        fit, *_ = np.linalg.lstsq(rows[found], off[found], rcond=None)
        left = np.abs(off - rows @ fit)
        robust_sd = 1.4826 * np.median(left[found])
        with np.errstate(invalid="ignore"):
            found = left <= MAX_SDS * max(robust_sd, MIN_SD_PX)
    return found


def length(points):
    """Return the distance between the ends of a sequence of points (n, 2)."""
    return float(np.linalg.norm(points[-1] - points[0]))


def best_line(points):
    """Return a point and the direction of the best line (total least squares)."""
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre)[2][0]


def bend(points):
    """Return the largest distance of points (n, 2) from their line, over its length."""
    centre, along = best_line(points)
    away = np.abs((points - centre) @ [-along[1], along[0]])
    return float(away.max() / length(points))


def lean(points):
    """Return the angle (deg) of the best line of points (n, 2) to image columns."""
    return angle_from_columns(best_line(points)[1])


def angle_from_columns(along):
    """Return the angle (deg) of a direction (2,): positive if right going down."""
    x, y = along if along[1] > 0 else -along
    return float(np.degrees(np.arctan2(x, y)))


def predicted_lean(T_camera_grid, places):
    """Return the angle (deg) to the columns of the vertical through `places`.

    The camera is level. In the grid's plane all verticals pass through one point:
    where the vertical through the centre of the camera meets the plane. Without
    pitch, that point is infinitely far.
    """
    T_grid_camera = inverse_pose(T_camera_grid)
    eye, down = T_grid_camera[:3, 3], T_grid_camera[:3, :3] @ DOWN
    middle = (np.median(places, axis=0) + 0.5) * MM_PER_PX
    # From a point of the plane, towards eye + t down with z = 0, without dividing.
    towards = eye[:2] * down[2] - down[:2] * eye[2] - middle * down[2]
    return angle_from_columns(towards)


def pitch_of(T_camera_grid):
    """Return the angle (deg) of the grid's normal above the camera's axis."""
    x, y, z = T_camera_grid[:3, 2]
    return float(np.degrees(np.arctan2(-y, np.hypot(x, z))))


def half_angle(camera, mask):
    """Return the largest decoded angle (deg) from the axis."""
    v, u = np.nonzero(mask)
    rays = camera.rays(np.column_stack([u, v]).astype(float)).directions
    return float(np.degrees(np.arccos(rays[:, 2]).max()))
