"""A room in front of both cameras: corrected images and straight edges."""

from functools import cache, lru_cache

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.calibrations import (
    METHODS,
    SWEPT_METHODS,
    calibrated,
    decoded_points,
    on_lattice,
    redrawn_points,
)
from chapters.shared.active_grid_sets import true_camera, true_poses
from chapters.shared.bench_noise import BENCH, NOISES, SWEPT_NOISES
from chapters.shared.central_sets import OMNI
from chapters.shared.rigs import rig_named
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.geometry import inverse_pose, pose, transform
from raxel.lab import room
from raxel.multiview.perspective_view import resample
from repro.run.rendered import rendered_set

ON_EDGE = 60
MIN_EDGE_POINTS = 8  # points of an edge with a ray
MIN_EDGE_SHARE = 0.3  # of an edge's points
VIEWS = 2  # frames, as in Figs 4.7 and 4.8
TURNS_DEG = (0.0, 35.0)
PANORAMA_PX, VIEW_PX = (720, 240), (480, 400)
PANORAMA_DEG, VIEW_DEG = 200.0, 100.0
# A mirror camera looks straight up, the fisheye straight ahead (world: y down).
LOOKS_UP = np.array([[-1.0, 0, 0], [0, 0, -1.0], [0, -1.0, 0]])


def middle_direction(folder):
    """Return the unit direction (3,), camera frame, to the centre of the base grid."""
    T = next(iter(true_poses(folder).values()))
    middle = T[:3, :3] @ [188.0, 150.0, 0.0] + T[:3, 3]
    return middle / np.linalg.norm(middle)


def T_world_camera(camera_name, folder, turn_deg):
    """Return the pose of the camera in the middle of the room, its grids ahead."""
    up = LOOKS_UP if camera_name == OMNI else np.eye(3)
    ahead = up @ middle_direction(folder)
    azimuth = np.arctan2(ahead[0], ahead[2]) + np.radians(turn_deg)
    c, s = np.cos(azimuth), np.sin(azimuth)
    level = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return pose(level @ up, np.zeros(3))


@cache
def edges(upright):
    """Return points (edges, ON_EDGE, 3), world, on the room's straight edges."""
    ends = room().straight_edges
    run = np.abs(ends[:, 1] - ends[:, 0])
    if upright:
        ends = ends[(run[:, 0] < 1e-6) & (run[:, 2] < 1e-6)]
    share = np.linspace(0, 1, ON_EDGE)[:, None]
    points = ends[:, :1] + share * (ends[:, 1:] - ends[:, :1])
    return np.unique(np.round(points, 6), axis=0)


@lru_cache(maxsize=8)
def visible_edges(camera_name, folder):
    """Return true pixels (edges, ON_EDGE, 2) of the edges, NaN where invisible."""
    T = inverse_pose(T_world_camera(camera_name, folder, 0.0))
    points = edges(camera_name == OMNI)
    seen = true_camera(folder).project(transform(T, points.reshape(-1, 3)))
    pixels = np.where(seen.valid[:, None], seen.pixels, np.nan)
    return pixels.reshape(*points.shape[:2], 2)


def straightness(found, lattice, pixels, camera_name, folder):
    """Return largest and median deviation of edges from lines, over their length.

    An edge's pixels are mapped to rays, and the rays to points on the cylinder or
    the plane. The deviation is the largest distance from the best line, over the
    distance between the edge's ends.
    """
    place = cylinder if camera_name == OMNI else flat
    down = downwards(camera_name, folder)
    shares = []
    for edge in pixels:
        rays = found.camera.rays(lattice.places(edge))
        if np.count_nonzero(rays.valid) < max(
            MIN_EDGE_POINTS, MIN_EDGE_SHARE * ON_EDGE
        ):
            continue
        points = place(rays.directions[rays.valid], down)
        points = points[np.isfinite(points[:, 0])]
        if len(points) >= MIN_EDGE_POINTS:
            shares.append(off_line(points))
    return {
        "edges": len(shares),
        "worst_share": max(shares, default=None),
        "median_share": float(np.median(shares)) if shares else None,
    }


def downwards(camera_name, folder):
    """Return the unit direction (3,), camera frame, that is down in the room."""
    return T_world_camera(camera_name, folder, 0.0)[:3, :3].T @ [0.0, 1.0, 0.0]


def level_axes(down, folder_ahead):
    """Return R (3, 3): rows x to the right, y down, z ahead, in the camera frame."""
    z = folder_ahead - (folder_ahead @ down) * down
    z /= np.linalg.norm(z)
    return np.stack([np.cross(down, z), down, z])


def cylinder(directions, down):
    """Return azimuth and height (N, 2) on a vertical unit cylinder."""
    x = np.cross(down, [0.3, 0.5, 0.7])
    x /= np.linalg.norm(x)
    z = np.cross(x, down)
    a, b = directions @ x, directions @ z
    azimuth = np.unwrap(np.arctan2(a, b))
    return np.column_stack([azimuth, directions @ down / np.hypot(a, b)])


def flat(directions, down):
    """Return points (N, 2) on the plane normal to the mean direction; NaN behind."""
    normal = directions.mean(axis=0)
    normal /= np.linalg.norm(normal)
    across = np.linalg.svd(normal[None])[2][1:]
    height = directions @ normal
    points = directions @ across.T / height[:, None]
    points[height < 0.1] = np.nan
    return points


def off_line(points):
    """Return the largest distance of points (N, 2) from their line, over its length."""
    centred = points - points.mean(axis=0)
    along, across = (centred @ np.linalg.svd(centred)[2].T).T
    return float(np.abs(across).max() / np.ptp(along))


def vertical_deg(camera, down):
    """Return the elevation range (deg) of the calibrated rays."""
    v, u = np.nonzero(camera.mask)
    nodes = np.column_stack([u, v]).astype(float)
    heights = camera.rays(nodes).directions @ -down
    return float(np.ptp(np.degrees(np.arcsin(np.clip(heights, -1, 1)))))


def equal_depth(calibration, points, depth, lattice, R_camera_base):
    """Return a calibration with another centre depth and recomputed rays."""
    centre = np.append(calibration.centre[:2], depth)
    used = calibration.used
    seen = np.isfinite(points[used][..., 0])
    rays = centroid_directions(points[used], seen, centre, calibration.T_base_grid)
    moved = calibration._replace(centre=centre, directions=rays)
    return on_lattice(lattice, points, moved, R_camera_base)


def lines_trial(condition, rng, errors):
    """Return straight edges and vertical field of view of a redrawn calibration.

    errors: {rig: DecodingErrors}.
    """
    rig = condition["rig"]
    seed = condition["seeds"][rng.integers(len(condition["seeds"]))]
    folder = rendered_set(rig, seed)
    lattice, points = redrawn_points(
        rig, seed, condition["step"], rng, errors[rig], NOISES | SWEPT_NOISES
    )
    out = {}
    for noise, seen in points.items():
        methods = SWEPT_METHODS if noise in SWEPT_NOISES else tuple(METHODS)
        found = calibrated(folder, lattice, seen, rng, methods)
        out[noise] = edges_and_field(found, seen, lattice, condition["camera"], folder)
    return out


def edges_and_field(calibrations, points, lattice, name, folder):
    """Return each method's edge deviations and vertical field of view."""
    pixels, down = visible_edges(name, folder), downwards(name, folder)
    out = {}
    for method, one in calibrations.items():
        if isinstance(one, str):
            out[method] = {"failed": one}
            continue
        out[method] = straightness(one, lattice, pixels, name, folder) | {
            "depth_mm": float(one.calibration.centre[2]),
            "vertical_deg": vertical_deg(one.camera, down),
        }
    best = calibrations["cgsp"]
    R = next(iter(true_poses(folder).values()))[:3, :3]
    for method, one in calibrations.items():
        if method == "cgsp" or isinstance(one, str) or isinstance(best, str):
            continue
        same = equal_depth(
            one.calibration, points, best.calibration.centre[2], lattice, R
        )
        out[method]["equal_depth_deg"] = vertical_deg(same.camera, down)
    return out


def pictures_trial(condition, rng):
    """Return two frames of the room, original and corrected by two calibrations."""
    name, rig = condition["camera"], condition["rig"]
    folder = rendered_set(rig, 0)
    bench = {BENCH: NOISES[BENCH]}
    lattice, points = decoded_points(folder, condition["step"], rng, bench)
    found = calibrated(folder, lattice, points[BENCH], rng, ("printed", "cgsp"))
    laboratory = rig_named(rig).laboratory()
    out = {}
    for frame, turn in enumerate(TURNS_DEG[:VIEWS]):
        picture = laboratory.photograph(room(), T_world_camera(name, folder, turn), rng)
        out[f"frame_{frame}"] = shrunk(picture, 480)
        for method, one in found.items():
            if not isinstance(one, str):
                out[f"{method}_{frame}"] = corrected(
                    picture, one, lattice, name, folder
                )
    return out


def shrunk(picture, width):
    """Return the image at about this width, neighbours averaged, uint8."""
    factor = max(1, picture.shape[1] // width)
    h, w = (n // factor * factor for n in picture.shape[:2])
    blocks = picture[:h, :w].reshape(h // factor, factor, w // factor, factor)
    return blocks.mean(axis=(1, 3)).round().astype(np.uint8)


def corrected(picture, found, lattice, name, folder):
    """Return the image on a cylinder or plane through calibrated rays, uint8."""
    R_camera_view = level_axes(downwards(name, folder), middle_direction(folder)).T
    directions = view_directions(name) @ R_camera_view.T
    seen = found.camera.project(directions.reshape(-1, 3))
    pixels = seen.pixels * lattice.step + lattice.step // 2
    pixels[~seen.valid] = np.nan
    shape = *directions.shape[:2], 2
    return resample(picture, pixels.reshape(shape).astype(np.float32))


def view_directions(name):
    """Return directions (h, w, 3) of the corrected image's pixels: x right, z ahead."""
    if name == OMNI:
        (w, h), half = PANORAMA_PX, np.radians(PANORAMA_DEG) / 2
        radius = w / (2 * half)
        azimuth = (np.arange(w) - (w - 1) / 2) / radius
        drop = (np.arange(h) - 0.75 * h) / radius
        drop, azimuth = np.meshgrid(drop, azimuth, indexing="ij")
        return np.stack([np.sin(azimuth), drop, np.cos(azimuth)], axis=-1)
    (w, h), half = VIEW_PX, np.radians(VIEW_DEG) / 2
    focal = w / 2 / np.tan(half)
    x = (np.arange(w) - (w - 1) / 2) / focal
    y = (np.arange(h) - (h - 1) / 2) / focal
    y, x = np.meshgrid(y, x, indexing="ij")
    return np.stack([x, y, np.ones_like(x)], axis=-1)
