"""Trials of this page, their conditions and constants."""

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from chapters.shared.grids import steps_between
from chapters.shared.rigs import rig_named
from raxel.features.active_grid import REASONS, decode, pixels_of, points_at
from raxel.features.localise import derivative, saddle_point
from raxel.geometry import (
    apply_homography,
    homography_dlt,
    pose,
    refine_homography,
    rotation_from_vector,
)
from raxel.io import read_json
from raxel.lab import bloom, points_seen, render_patterns
from raxel.sets import load_set, read_image
from repro.run.rendered import rendered_set

# Measurements of 3.3.3: corners in one grid, and their positions in a second one.


# RIG/SEED of the images, as the experiments name them.
SETS = {
    "quick": ("monitor-d200-small/0",),
    "full": ("monitor-d200/0", "monitor-d200/1", "monitor-d200/2"),
}
# Levels of the sweeps; the first of blur and noise is zero.
LEVELS = {
    "distance": {"quick": (200, 360), "full": (150, 200, 270, 360, 480, 640)},
    "orientation": {"quick": (0, 28), "full": (0, 7, 14, 21, 28, 35)},
    "blur": {"quick": (0, 2), "full": (0, 0.5, 1, 2, 3, 4)},
    "noise": {"quick": (0, 8), "full": (0, 1, 2, 4, 8, 16)},
}
DEFAULT_MM = 200
# Level of a sweep at the default condition. At 0 deg the first grid is the same,
# but the second one is that of all orientations.
DEFAULT_LEVEL = {"distance": DEFAULT_MM, "blur": 0, "noise": 0}

ACTIVE, DERIVATIVE, SADDLE = "active grid", "derivative", "saddle point"
STATIC = (DERIVATIVE, SADDLE)
METHODS = (*STATIC, ACTIVE)
TRUE = "true corners"
START_SD_PX = 1.0
# Interpretations of 3.3.3; the primary option comes first.
ONE_WINDOW, BY_SQUARE = "one window", "half a square"
WINDOWS = (ONE_WINDOW, BY_SQUARE)
AS_TAKEN, AS_FIRST = "as taken", "as the first"
SECOND_GRIDS = (AS_TAKEN, AS_FIRST)
WITHIN, OVER = "no full well", "a fifth above full"
EXPOSURES = (WITHIN, OVER)
# From the rig's exposure, white at 0.9 of a well, to 1.2 of it.
GAIN = 4 / 3
WINDOW_PX, BLUR_SHARE, MIN_WINDOW_PX = 15, 2 / 15, 5
# A method that finds a smaller share of the corners has failed.
MIN_FOUND = 0.5
# Margin excluded at the edge of the lit area, at every level as in sharp images; the
# decoder's own margin follows the blur at edges of the Gray code.
MARGIN_PX = 6
SETTINGS = {
    "corners": [15, 15],
    "grid_mm": 301.5,
    "distance_mm": DEFAULT_MM,
    "orientation_deg": 0,
    "blur_px": 0,
    "noise_grey": 0,
    "start_sd_px": START_SD_PX,
    "window_px": WINDOW_PX,
    "saddle_blur_of_window": BLUR_SHARE,
    "least_found": MIN_FOUND,
    "margin_px": MARGIN_PX,
}


def conditions(effort):
    """Return every level of every sweep with every set; the default level once."""
    swept = [
        (name, level)
        for name, levels in LEVELS.items()
        for level in levels[effort]
        if level != DEFAULT_LEVEL.get(name)
    ]
    return [
        condition_of(name, level, images)
        for images in SETS[effort]
        for name, level in [("default", DEFAULT_MM), *swept]
    ]


def condition_of(name, level, images):
    """Return one level: the views to open, and the changes of their images."""
    first, second = (f"distance-{DEFAULT_MM}", f"distance-{DEFAULT_MM}-second")
    if name == "distance":
        first, second = f"distance-{level}", f"distance-{level}-second"
    if name == "orientation":
        first = f"tilt-{level}" if level else first
        second = "tilt-second"
    return {
        "sweep": name,
        "level": level,
        "set": images,
        "first": first,
        "second": second,
        "blur_px": level if name == "blur" else 0,
        "noise_grey": level if name == "noise" else 0,
    }


def robustness_trial(condition, rng):
    """Return corners by three methods, and their residuals by the second grid.

    Residuals are in mm on the chessboard; true corners leave the second grid's own
    error. All exposures use the same images.
    """
    name, changed = (condition["set"], condition["sweep"] in ("blur", "noise"))
    image_set, views = opened(name)
    target, patterns = image_set.target, views[condition["first"]].patterns
    points = target.chessboard_points()
    true = corners_of(image_set)[views[condition["first"]].chessboard]
    starts = true + rng.normal(0, START_SD_PX, true.shape)
    seen = {AS_TAKEN: location_as_taken(name, condition["second"])}
    seen[AS_FIRST] = seen[AS_TAKEN]
    if changed:
        second = images_of(name, condition["second"])
        second = degraded([second], condition, rng)[0]
        seen[AS_FIRST] = location_of(second, patterns, target)
    first = [bright_images_of(name, condition["first"], e) for e in EXPOSURES]
    first = degraded(first, condition, rng) if changed else first
    out = {"least_square_px": min_step(true)}
    for exposure, (board, *shown) in zip(EXPOSURES, first, strict=True):
        location = location_of(shown, patterns, target)
        found = by_methods(board, location, starts, true, points)
        out[exposure] = scores(found, seen, true, points)
    return out


@lru_cache(maxsize=4)
def opened(name):
    """Return (ImageSet RIG/SEED, {name of the view: View})."""
    rig, _, seed = name.partition("/")
    image_set = load_set(rendered_set(rig, int(seed)))
    return image_set, {view.name: view for view in image_set.views}


@lru_cache(maxsize=2)
def images_of(name, view):
    """Return images (n, H, W) uint8 of a view: chessboard if any, then patterns."""
    image_set, views = opened(name)
    files = [pattern.image for pattern in views[view].patterns]
    board = [views[view].chessboard] if views[view].chessboard else []
    return np.stack([read_image(image_set, file) for file in board + files])


@lru_cache(maxsize=4)
def bright_images_of(name, view, exposure):
    """Return `images_of` a view with an exposure, (n, H, W) uint8."""
    images = images_of(name, view)
    if exposure == WITHIN:
        return images
    sensor = rig_named(name.partition("/")[0]).sensor
    return np.stack([brighter(image, sensor) for image in images])


@lru_cache(maxsize=2)
def location_as_taken(name, view):
    """Return the grid position that each pixel of a view sees, (H, W, 2) mm."""
    image_set, views = opened(name)
    images = images_of(name, view)
    return location_of(images, views[view].patterns, image_set.target)


def brighter(image, sensor):
    """Return the image (H, W) uint8 of GAIN times the light, with overflowing wells.

    Charges are recovered from the grey values by the tone curve of the sensor.
    """
    table = (np.arange(256) / 255) ** sensor.gamma * GAIN
    charge = bloom(table.astype(np.float32)[image], 1.0, sensor.blooming)
    return sensor.develop(charge)


def degraded(stacks, condition, rng):
    """Return stacks of images (n, H, W) uint8 with equal blur and noise."""
    stacks = [stack.copy() for stack in stacks]
    for images in zip(*stacks, strict=True):
        noise = np.float32(0)
        if condition["noise_grey"]:
            noise = rng.standard_normal(images[0].shape, np.float32)
            noise *= condition["noise_grey"]
        for image in images:
            soft = image.astype(np.float32)
            if condition["blur_px"]:
                soft = cv2.GaussianBlur(soft, (0, 0), condition["blur_px"])
            image[:] = np.clip(np.rint(soft + noise), 0, 255)
    return stacks


def patterns_taken(rig, T, seed):
    """Render the active grid at T_camera_target: (patterns, their images)."""
    views = render_patterns(rig, T, seed)
    # White, black and chessboard have names of type str.
    taken = [(what, one) for what, one in views if not isinstance(what, str)]
    return tuple(zip(*taken, strict=True))


def location_of(images, patterns, target):
    """Decode as in the thesis: its filters, and no mask for clipped sinusoids.

    The filters of 3.2.2 are 7 x 7 pixels of the sinusoids, the eight neighbours of
    each location, and the filling of holes. Stored as 16 bits, no 8-bit value
    counts as clipped.
    """
    return decode(
        np.asarray(images, np.uint16),
        patterns,
        target,
        neighbours=True,
        fill=True,
        margin_px=MARGIN_PX,
        linear=True,
        threads=1,
    ).location


def by_methods(board, location, starts, true, points):
    """Return {(method, window): corners (N, 2) px}, NaN where a method failed.

    board: (H, W), the chessboard; location: (H, W, 2) mm of the grid at the same
    position; starts, true: (N, 2) px, clicks and corners; points: (N, 2) mm.
    """
    pixels = pixels_of(location, points)
    found = by_static_methods(board, starts)
    for window in WINDOWS:
        found |= {(ACTIVE, window): pixels, (TRUE, window): true}
    return found


def scores(found, seen, true, points):
    """Return residuals (mm) and errors (px) of corners, by window and second grid.

    found: from `by_methods`; seen: {interpretation: location of the second grid}.
    """
    out = {}
    for (method, window), corners in found.items():
        off = np.linalg.norm(corners - true, axis=1)
        out[f"{window}.off_px.{method}"] = rms(off)
        out[f"{window}.lost.{method}"] = int(np.isnan(off).sum())
        for again, second in seen.items():
            residual = residual_mm(corners, second, points)
            out[f"{window}.{again}.{method}"] = residual
    return out


def corners_of(image_set):
    """Return {chessboard image: its true corners (N, 2) px}."""
    truth = read_json(image_set.folder / "truth" / "corners.json")["images"]
    return {name: np.array(one["corners"]) for name, one in truth.items()}


def by_static_methods(board, starts):
    """Return {(method, window): corners (N, 2)}, NaN where a method failed."""
    found = {}
    for name, window in ((ONE_WINDOW, WINDOW_PX), (BY_SQUARE, window_of(starts))):
        blur = BLUR_SHARE * window
        for method, result in (
            (DERIVATIVE, derivative(board, starts, window=window)),
            (SADDLE, saddle_point(board, starts, window=window, blur_sd=blur)),
        ):
            kept = result.converged[:, None]
            found[method, name] = np.where(kept, result.corners, np.nan)
    return found


def window_of(corners):
    """Return the odd window (px) of half the smallest step between corners."""
    half = int(min_step(corners) / 2)
    return max(half - 1 + half % 2, MIN_WINDOW_PX)


def min_step(corners):
    """Return the smallest step (px) between neighbours of 15 x 15 corners (N, 2)."""
    side = round(np.sqrt(len(corners)))
    return float(steps_between(corners.reshape(side, side, 2)).min())


def residual_mm(corners, location, points):
    """Return the RMS residual (mm) of a homography from second grid to chessboard.

    corners: (N, 2) px, NaN if not found; location: (H, W, 2) mm of the second grid;
    points: (N, 2) mm, the chessboard's corners. Only corners found are scored; NaN
    if too few.
    """
    seen = points_at(location, corners)
    known = np.isfinite(seen).all(axis=1)
    if known.mean() < MIN_FOUND:
        return float("nan")
    seen, points = seen[known], points[known]
    H = refine_homography(homography_dlt(seen, points), seen, points)
    return rms(np.linalg.norm(apply_homography(H, seen) - points, axis=1))


def rms(lengths):
    """Return the root mean square of the finite values; NaN if no value is."""
    if not np.isfinite(lengths).any():
        return float("nan")
    return float(np.sqrt(np.nanmean(lengths**2)))


# Decodable share of a rotated monitor.


RIG = "monitor-d200-small"
FILES = ("data/rigs/monitor-d200-small.yaml",)
TURNS_DEG = {"quick": (0, 60), "full": (0, 14, 28, 42, 56, 70)}
# Exponent of the cosine fall-off, gamma of the camera, number of runs. The first is
# the rig's.
VARIED = {
    "quick": ((2, 2.2, 1), (0, 2.2, 1), (2, 1.0, 1)),
    "full": ((2, 2.2, 3), (2, 1.0, 3), (0, 2.2, 3)),
}
DISTANCE_MM = 200
SHIFT_MM, TURN_DEG = 2, 1
DECODED = ("decoded", "filled from neighbours")
RIM = "at the rim of the lit area"
VIEWING_SETTINGS = {
    "rig": RIG,
    "distance_mm": DISTANCE_MM,
    "set_up": {"shift_mm": SHIFT_MM, "turn_deg": TURN_DEG},
}


def conditions_of_viewing(effort):
    """Return every rotation with every monitor and camera, by simulated run."""
    return [
        {
            "turn_deg": turn,
            "falloff_exponent": falloff,
            "camera_gamma": gamma,
            "seed": seed,
        }
        for falloff, gamma, seeds in VARIED[effort]
        for seed in range(seeds)
        for turn in TURNS_DEG[effort]
    ]


def viewing_trial(condition, rng):
    """Return shares of the visible area that are decoded, and their uncertainty.

    Pixels next to the edge of the lit area are excluded for their blur, not for
    their light; the share "with the rim" includes them.
    """
    rig = rig_named(RIG)
    falloff = condition["falloff_exponent"]
    monitor = replace(rig.monitor, falloff_exponent=falloff)
    sensor = replace(rig.sensor, gamma=condition["camera_gamma"])
    rig = replace(rig, monitor=monitor, sensor=sensor)
    T = turned_monitor(condition["turn_deg"], rig.target.monitor_mm, rng)
    area = visible_areas(rig, T)
    patterns, images = patterns_taken(rig, T, [condition["seed"]])
    found = decode(
        np.stack(images), patterns, rig.target,
        neighbours=True, fill=True, linear=True, threads=1,
    )  # fmt: skip
    names = np.array([REASONS[k] for k in sorted(REASONS)])[found.status]
    whole = np.isin(names, DECODED)
    return {
        "share": shared(area, whole | (names == RIM)),
        "without_rim": shared(area, whole),
        "sigma_um": 1000 * float(np.median(found.sigma[whole])),
        "largest_angle_deg": farthest_angle(rig, T),
    }


def turned_monitor(turn_deg, size_mm, rng):
    """Return T_camera_target of a monitor placed by hand and rotated."""
    shift, by_hand = rng.normal(size=(2, 3)) * [[SHIFT_MM], [TURN_DEG]]
    R = rotation_from_vector(np.radians(by_hand)) @ rotation_from_vector(
        np.radians([0.0, turn_deg, 0.0])
    )
    middle = np.array([*size_mm, 0]) / 2
    return pose(R, np.array([0, 0, DISTANCE_MM]) + shift - R @ middle)


def visible_areas(rig, T):
    """Return the area (H, W) of the grid that each pixel sees, mm^2; 0 outside it."""
    points = points_seen(rig.camera, T, rig.target.monitor_mm).astype(float)
    down, across = np.gradient(points, axis=(0, 1))
    area = across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0]
    return np.nan_to_num(np.abs(area))


def shared(area, where):
    """Return the share of an area (H, W) where a mask is True."""
    return float(area[where].sum() / area.sum())


def farthest_angle(rig, T):
    """Return the largest visible angle (deg) to the monitor's normal."""
    points = points_seen(rig.camera, T, rig.target.monitor_mm).astype(float)
    v, u = np.nonzero(np.isfinite(points[..., 0]))
    rays = rig.camera.rays(np.column_stack([u, v]).astype(float))
    cosines = rays.directions @ T[:3, 2]
    return float(np.degrees(np.arccos(cosines.min())))
