"""Trials of this page, their conditions and constants."""

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.scenes import (
    at_four_pixels,
    best_of,
    by_local_fit,
    calibrated,
    capture_of,
    corner_conditions,
    decoded,
    images_of,
    residual_of,
    rig_of,
    square_px,
    sweep,
    through,
)
from raxel.features.active_grid import decode
from raxel.geometry import (
    apply_homography,
    inverse_pose,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.lab import room
from raxel.multiview import perspective_view, remap_to_plane, resample, source_pixels
from raxel.sets import chessboard_image, pattern_image, patterns_of
from repro.run import columns

# The active grid of Table 3.8, near and far, with each of the decoder's filters.


# Averaging: none; sinusoids; sinusoids and then locations, as in 3.2.2.
AS_TEXT = "7 x 7 and 3 x 3"
FILTERS = {
    "none": {"smooth": False, "neighbours": False},
    "7 x 7": {"smooth": True, "neighbours": False},
    AS_TEXT: {"smooth": True, "neighbours": True},
}
SEARCHES = {"four nearest pixels": at_four_pixels, "local fit": by_local_fit}


def filter_conditions(effort):
    """Return a condition for each distance and seed."""
    return [
        {name: one[name] for name in ("case", "seed", "rig", "boards", "pose")}
        for one in corner_conditions(effort, ("near", "far"))
    ]


def filter_trial(condition, rng):
    """Return the mean residual (px) of the active grid's corners with each filter.

    Images are undistorted as in Table 3.8; `true_lens`: as by the true lens.
    """
    camera = calibrated(condition["boards"], condition["seed"])
    sources = source_pixels(camera, perspective_view(camera))
    image_set, view = capture_of(condition["rig"], condition["seed"], condition["pose"])
    images, others = images_of(image_set, view)
    images = np.array([resample(image, sources) for image in images])
    lit = {k: resample(others[k], sources) for k in ("white", "black") if k in others}
    metric = image_set.target.chessboard_points()
    truth = rig_of(condition["rig"]).camera
    out = {}
    for name, options in FILTERS.items():
        grid = decode(
            images, view.patterns, image_set.target,
            fill=True, linear=True, **lit, **options,
        )  # fmt: skip
        for search, found_by in SEARCHES.items():
            corners = found_by(grid, metric)
            left = residual_of(corners, metric)
            moved = residual_of(through(camera, truth, corners), metric)
            out[f"{name}.{search}"] = {
                "mean": left["mean"],
                "true_lens": {"mean": moved["mean"]},
                "lost": left["lost"],
            }
    return out | {"square_px": square_px(corners, metric)}


# Table 3.8 at the camera's own pixels, which resolve the raster of the monitor.
#
# The simulator renders a monitor as a continuous image. Here each of its pixels has a
# bright opening and a dark frame. Only patches around the corners are rendered: the
# whole image would have 10 million pixels.


RIG = "d200-lens"
NATIVE_RIGS = ("data/rigs/d200-lens.yaml",)
BINNED = 3  # pixels of the camera per rig pixel, each way
# Bright share of a monitor's pixel, each way: 64 % of its area.
APERTURE = 0.8
# Share of a full well: the raster's peaks exceed its mean and must not clip.
WHITE_WELLS = 0.75
FINENESS = 3  # samples each way for a pixel, before the blur
# Full widths and SDs, px of the camera; step between the corners used along a row.
WINDOWS = {"quick": (5, 21), "full": (5, 9, 13, 17, 21, 25, 33, 41, 49, 57, 73, 89)}
BLURS = {"quick": (2.0,), "full": (0.5, 1.0, 2.0, 3.0, 4.0, 6.0)}
STRIDE = {"quick": 7, "full": 1}
SEEDS = (1, 2, 3)
NO_RASTER = "no raster"
HALF_DECODED = 20  # half-width of a decoded patch, px


def native_conditions(effort):
    """Return a condition for each seed, named as those of Table 3.8.

    One more condition has no raster, to isolate its effect.
    """
    seeds = SEEDS[:1] if effort == "quick" else SEEDS
    return [
        {
            "case": case,
            "seed": seed,
            "stride": STRIDE[effort],
            "windows": list(WINDOWS[effort]),
            "blurs": list(BLURS[effort]),
        }
        for case, of_case in (("near", seeds), (NO_RASTER, seeds[:1]))
        for seed in of_case
    ]


@dataclass(frozen=True)
class NativeCamera:
    """The rig's camera with its own pixels and no distortion, in front of its monitor.

    K: (3, 3) px; T_camera_target: (4, 4) mm; blur_sd_px, size: as in the rig, in
    the camera's pixels.
    """

    rig: object
    T_camera_target: np.ndarray

    @property
    def size(self):
        """Width and height, px."""
        return BINNED * self.rig.camera.width, BINNED * self.rig.camera.height

    @property
    def K(self):
        """The rig's, in pixels of which BINNED share the centre of its pixel."""
        finer = np.diag([BINNED, BINNED, 1.0])
        finer[:2, 2] = (BINNED - 1) / 2
        return finer @ self.rig.camera.K

    @property
    def H_px_mm(self):
        """Points of the monitor (mm) to pixels."""
        return self.K @ self.T_camera_target[:3, [0, 1, 3]]

    @property
    def sensor(self):
        """The rig's for one pixel, with slightly less exposure."""
        well = self.rig.sensor.full_well_e / BINNED**2
        read = self.rig.sensor.read_noise_e / BINNED
        return replace(
            self.rig.sensor,
            white_e=WHITE_WELLS * well,
            full_well_e=well,
            read_noise_e=read,
        )

    @property
    def middle(self):
        """The centre (u, v) of the image."""
        return (np.array(self.size) - 1) / 2

    def vignetting(self, u, v):
        """Return the share of light at pixels (u, v): cos^4 at the exit pupil."""
        pupil = BINNED * self.rig.optics.exit_pupil_px
        square = (u - self.middle[0]) ** 2 + (v - self.middle[1]) ** 2
        return 1 / (1 + square / pupil**2) ** 2

    def blur_sd(self, pixel):
        """Return the SD (px) of the point spread at a pixel (2,).

        The rig's blur in its larger pixels is used as the lens's blur on these.
        """
        away = pixel - self.middle
        share = 4 * away @ away / np.sum(np.square(self.size))
        low, high = np.square(self.rig.optics.blur_sd_px)
        return float(np.sqrt(low + (high - low) * share))


def opened(place, width):
    """Return the mean brightness of the raster over samples along one axis.

    place: (...) of their centres, width: of a sample, both in pixels of the
    monitor. A sample is narrower than the dark frame, so it covers one opening at
    most.
    """

    def until(x):
        whole = np.floor(x)
        return whole * APERTURE + np.clip(x - whole - (1 - APERTURE) / 2, 0, APERTURE)

    return (until(place + width / 2) - until(place - width / 2)) / (width * APERTURE)


def rastered(shown, place):
    """Return light (n, ...) of the monitor at samples, each pixel in its dark frame.

    shown: (n, height, width), light of the monitor's pixels; place: (rows, columns,
    2) of the samples' centres, in pixels of the monitor.
    """
    x, y = place[..., 0], place[..., 1]
    column, row = np.floor(place).astype(int).transpose(2, 0, 1)
    across, down = sample_widths(place)
    return shown[:, row, column] * opened(x, across) * opened(y, down)


def without_raster(shown, place):
    """Return the same for pixels without dark frames: means over the samples."""
    border = np.rint(place).astype(int)
    beyond = np.clip((place - border) / sample_widths(place) + 0.5, 0, 1)
    (column, row), (right, low) = border.transpose(2, 0, 1), beyond.transpose(2, 0, 1)

    def along(row):
        return (1 - right) * shown[:, row, column - 1] + right * shown[:, row, column]

    return (1 - low) * along(row - 1) + low * along(row)


def sample_widths(place):
    """Return width and height (2,) of samples at positions (rows, columns, 2)."""
    across = np.diff(place[..., 0], axis=1).mean()
    down = np.diff(place[..., 1], axis=0).mean()
    return np.array([across, down])


def light_of_patch(camera, shown, pixel, half, drawn=rastered):
    """Return light (n, side, side) on the sensor around a pixel, of n monitor images.

    shown: (n, height, width) uint8, input of the monitor; pixel: (2,) whole; drawn:
    appearance of its pixels.
    """
    from scipy.ndimage import gaussian_filter

    side = 2 * half + 1
    offsets = (np.arange(side * FINENESS) + 0.5) / FINENESS - half - 0.5
    v, u = np.meshgrid(pixel[1] + offsets, pixel[0] + offsets, indexing="ij")
    seen = np.column_stack([u.ravel(), v.ravel()])
    target, monitor = camera.rig.target, camera.rig.monitor
    pitch_mm = np.divide(target.monitor_mm, target.monitor_px)
    mm = apply_homography(np.linalg.inv(camera.H_px_mm), seen)
    place = (mm / pitch_mm).reshape(*u.shape, 2)
    points = transform(camera.T_camera_target, on_plane(mm))
    normal = camera.T_camera_target[:3, 2]
    cosine = (points @ normal / np.linalg.norm(points, axis=1)).reshape(u.shape)
    levels = monitor.light(np.arange(256) / 255)
    radiance = drawn(levels[shown], place) * monitor.falloff(cosine)
    spread = FINENESS * camera.blur_sd(pixel)
    soft = gaussian_filter(radiance, (0, spread, spread), mode="nearest")
    binned = soft.reshape(len(shown), side, FINENESS, side, FINENESS).mean(axis=(2, 4))
    away = np.arange(-half, half + 1)
    return binned * camera.vignetting(pixel[0] + away, pixel[1] + away[:, None])


def native_trial(condition, rng):
    """Return residuals of corners by every method and setting, like `corner_trial`.

    condition: case (NO_RASTER: the chessboard alone, on a monitor without raster),
    stride (of the corners used along rows and columns), windows, blurs. Pixels are
    the camera's. The lens has no distortion, so the errors are the localisers' own.
    """
    rig = rig_of(RIG)
    camera = NativeCamera(rig, rig.draw_poses(rng, 1)[0])
    board = rig.target.chessboard
    points = rig.target.chessboard_points().reshape(board.rows, board.columns, 2)
    stride = condition["stride"]
    metric = points[::stride, ::stride].reshape(-1, 2)
    truth = apply_homography(camera.H_px_mm, metric)
    start = np.rint(truth).astype(int)
    found = localised_in_patches(camera, start, condition, rng)
    if condition["case"] != NO_RASTER:
        found |= decoded_in_patches(camera, start, metric, rng)
    out = {name: best_of(corners, metric) for name, corners in found.items()}
    off = {
        name: corners.reshape(-1, *metric.shape)[out[name]["best"]] - truth
        for name, corners in found.items()
    }
    for name, error in off.items():
        out[name]["rms_true_px"] = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
    return out | {"metric": metric, "middle": camera.K[:2, 2]}


def localised_in_patches(camera, start, condition, rng):
    """Return {method: corners (settings..., n, 2) px} of the chessboard, by `sweep`.

    The patches are tiled in one image, each with its start in its centre.
    """
    windows, blurs = condition["windows"], condition["blurs"]
    half = max(windows) // 2 + int(np.ceil(3 * max(blurs)))
    side = 2 * half + 1
    target = camera.rig.target
    shown = chessboard_image(target.chessboard, target.monitor_px)[None]
    drawn = without_raster if condition["case"] == NO_RASTER else rastered
    light = [light_of_patch(camera, shown, pixel, half, drawn)[0] for pixel in start]
    across = int(np.ceil(np.sqrt(len(start))))
    tiles = np.zeros((across, across, side, side))
    tiles.reshape(-1, side, side)[: len(start)] = light
    image = tiles.swapaxes(1, 2).reshape(across * side, across * side)
    taken = camera.sensor.expose(image, rng)
    row, column = np.divmod(np.arange(len(start)), across)
    middle = np.column_stack([column, row]) * side + half
    found = sweep(taken, middle.astype(float), windows, blurs)
    # Half-windows of this size reach into the next patch.
    del found["OpenCV half"]
    return {name: corners + (start - middle) for name, corners in found.items()}


def decoded_in_patches(camera, start, metric, rng):
    """Return {search: corners (1, n, 2) px} in the decoded data of each patch."""
    rig = camera.rig
    patterns = patterns_of(rig.patterns)
    size = rig.target.monitor_px
    even = [np.full(size[::-1], value, np.uint8) for value in (255, 0)]
    shown = np.array([*(pattern_image(p, size) for p in patterns), *even])
    searches = {"four nearest pixels": at_four_pixels, "local fit": by_local_fit}
    found = {name: [] for name in searches}
    for pixel, place in zip(start, metric, strict=True):
        light = light_of_patch(camera, shown, pixel, HALF_DECODED)
        side = light.shape[-1]
        taken = camera.sensor.expose(light.reshape(-1, side), rng)
        *images, white, black = taken.reshape(-1, side, side)
        grid = decode(
            np.array(images), patterns, rig.target, white=white, black=black,
            neighbours=True, fill=True, blur_px=camera.blur_sd(pixel), linear=True,
            threads=1,
        )  # fmt: skip
        for name, search in searches.items():
            found[name].append(search(grid, place[None])[0] + pixel - HALF_DECODED)
    return {name: np.array(corners)[None] for name, corners in found.items()}


# Fig. 3.17: a room through a fisheye, remapped to an active grid's plane.


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
    images = grey(taken), np.where(seen, grey(laid), np.nan)
    paths = visible_paths(condition["rig"], condition["view"])
    rows = []
    for k, (edge, path) in enumerate(zip(room_edges(), paths, strict=True)):
        pixels, places, at, on = edge_in_both(grid, path, images)
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


def edge_in_both(grid, path, images):
    """Return points of an edge before and after remapping, projected and detected.

    path: pixels (n, 2) that see it; images: before and after. Returns (m, 2) px
    each: projected before, projected after, detected before and after; empty if too
    little of the edge is decoded.
    """
    places = location_at(grid, path)
    known = np.isfinite(places[:, 0])
    if known.sum() < MIN_POINTS:
        return (np.empty((0, 2)),) * 4
    both = path[known], places[known] / MM_PER_PX - 0.5
    found = [edge_points(*pair) for pair in zip(images, both, strict=True)]
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


def grey(image):
    """Return an image in grey, float."""
    if image.ndim == 2:
        return image.astype(float)
    return image @ np.array([0.299, 0.587, 0.114])


def edge_points(image, path):
    """Return points (n, 2) of the steepest intensity across a path (n, 2), or NaN."""
    from scipy.ndimage import map_coordinates, uniform_filter1d

    ahead = np.gradient(path, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    across = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    offsets = np.arange(-SEARCH_PX, SEARCH_PX + FINE_PX / 2, FINE_PX)
    spots = path[:, None] + offsets[:, None] * across[:, None]
    values = map_coordinates(
        image, [spots[..., 1], spots[..., 0]], order=1, cval=np.nan
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
