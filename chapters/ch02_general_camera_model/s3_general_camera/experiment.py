"""Trials of this page, their conditions and constants."""

import numpy as np

from chapters.shared.general import CAMERAS, draw_two_grids
from raxel.calibration import (
    bundle_adjust_fixed_centre,
    linear_well_conditioned,
    rays_from_known_motion,
)
from raxel.cameras import GeneralCamera, pixel_grid
from raxel.geometry import (
    intersect_rays_plane,
    pluecker_matrix,
    pluecker_vector,
    pose,
    rotation_from_vector,
    transform,
)
from repro.run import Plan, crossed, experiment

# Data of Figs 2.1 and 2.2: rays of tables, and rays that meet grids.


# Fig. 2.1: a small image, so that its pixels can be drawn, and the pixel i
# whose matrix is printed.
TABLE_PX = (14, 10)
PIXEL_I = (3, 3)


def table_trial(condition, rng):
    """Return the look-up table of one camera: rays and matrices of its pixels."""
    width, height = TABLE_PX
    camera = CAMERAS[condition["camera"]](width, height)
    table = GeneralCamera.from_camera(camera)
    pixels = pixel_grid(width, height)
    rays = table.rays(pixels)
    out = {
        "pixels": pixels,
        "origins": rays.origins,
        "directions": rays.directions,
        "matrices": table.pluecker().reshape(-1, 4, 4),
        "rays": int(rays.valid.sum()),
    }
    if condition["camera"] == "faceted":
        out["facets"] = np.stack(
            [
                transform(T, np.column_stack([outline, np.zeros(4)]))
                for T, outline in zip(
                    camera.T_viewer_facets, camera.outlines, strict=True
                )
            ]
        )
    return out


# Fig. 2.2: the camera sees three grids; world = the first, the base grid.
IMAGE_PX = (33, 25)
DRAWN_STEP = 8
TILTS_DEG = ((0, 0, 0), (18, -10, 4), (-12, 14, -6))
SHIFTS_MM = ((0, 0, 420), (25, -15, 560), (-10, 20, 700))
KNOWN_SHIFT_MM = (0, 0, 160)
MARGIN_MM = 30.0


def three_unknown_poses(points):
    """Return poses, centre and directions from three grids in unknown poses."""
    start = linear_well_conditioned(points)
    seen = np.isfinite(points).all(axis=2)
    adjusted = bundle_adjust_fixed_centre(points, seen, start.centre, start.T_base_grid)
    return adjusted.T_base_grid, start.centre, adjusted.directions


def meetings_of(origins, directions, poses):
    """Return intersections with the grids (n, N, 3), and outlines (n, 5, 3).

    An anchor on the first grid meets it at distance zero, so the origins are
    moved back along their lines.
    """
    behind = origins - 1000.0 * directions
    hits = intersect_rays_plane(behind, directions, poses).points
    low = hits.min(axis=1) - MARGIN_MM
    high = hits.max(axis=1) + MARGIN_MM
    corners = np.stack(
        [
            np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], 1),
            np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], 1),
        ],
        axis=2,
    )
    return {
        "meetings": transform(poses, _flat(hits)),
        "outlines": transform(poses, _flat(corners)),
    }


def _flat(points):
    return np.concatenate([points, np.zeros((*points.shape[:2], 1))], 2)


# Two grids in known poses: calibration of any camera, and errors of a motion.


# Viewing direction of each camera, along z of its frame.
AHEAD = {"pinhole": 1.0, "fisheye": 1.0, "faceted": -1.0}

# Errors of T_1, in mm or degrees.
LEVELS = (0.1, 0.2, 0.5, 1.0, 2.0)

POSES = {"quick": 3, "full": 30}


def known_motion_trial(condition, rng):
    """Calibrate every pixel of a camera by two known grids, no noise."""
    name = condition["camera"]
    camera = CAMERAS[name](160, 120)
    pixels = pixel_grid(camera.width, camera.height)
    true = camera.rays(pixels)
    grids = draw_two_grids(rng, AHEAD[name])
    hits = intersect_rays_plane(true.origins, true.directions, grids)
    found = rays_from_known_motion(hits.points, grids)
    both = found.valid & true.valid
    angle, gap = ray_errors(found, true, both)
    shape = (camera.height, camera.width)
    table = GeneralCamera(
        found.directions.reshape(*shape, 3),
        found.valid.reshape(shape),
        found.origins.reshape(*shape, 3),
    )
    stored = table.rays(pixels[both])
    return {
        "angle_rad": angle.max(),
        "gap_mm": gap.max(),
        "share": both.sum() / true.valid.sum(),
        "table_angle_rad": angles(stored.directions, true.directions[both]).max(),
        "jump_deg": largest_jump(camera),
    }


def ray_errors(found, true, rows):
    """Return angle (rad) and distance (mm) of estimated rays from true ones, (M,).

    The distance is that of the true origin from the estimated line.
    """
    angle = angles(found.directions[rows], true.directions[rows])
    offset = true.origins[rows] - found.origins[rows]
    across = np.cross(offset, found.directions[rows])
    return angle, np.linalg.norm(across, axis=1)


def angles(a, b):
    """Return angles (N,) in radians between unit vectors (N, 3)."""
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.arctan2(across, np.sum(a * b, axis=1))


def largest_jump(camera):
    """Return the largest angle (deg) between rays of neighbours in a row."""
    rays = camera.rays(pixel_grid(camera.width, camera.height)).directions
    rays = rays.reshape(camera.height, camera.width, 3)
    left, right = rays[:, :-1].reshape(-1, 3), rays[:, 1:].reshape(-1, 3)
    return float(np.degrees(np.nanmax(angles(left, right))))


def error_pose(kind, error):
    """Return the pose (4, 4) of an error (3,) in mm, or in degrees about an axis."""
    if kind == "translation":
        return pose(np.eye(3), error)
    return pose(rotation_from_vector(np.radians(error)), np.zeros(3))


@experiment("exp_c2_nonparam_any", artefact="fig_2_1")
def two_known_grids(effort):
    """Every pixel of three cameras, calibrated by two known grids."""
    settings = {
        "image_px": [160, 120],
        "grids": "near one 350 to 450 mm away, the far one 200 to 400 mm "
        "behind it, each turned by up to 6 deg about every axis; no noise",
    }
    conditions = crossed(camera=("pinhole", "fisheye", "faceted"))
    return Plan(known_motion_trial, conditions, POSES[effort], settings)


# Plücker matrices and vectors of random lines, (2.11) and (2.12).


LINES = 100
EXTENT_M = 1.0  # points and distances are of order one
MIN_SEPARATION = 0.05

LINE_TRIALS = {"quick": 2, "full": 10}

LINE_SETTINGS = {
    "lines_per_trial": 100,
    "points": "within 1 m of a point of the line, at least 5 cm apart, "
    "each at a homogeneous scale of its own",
    "lines": "through a point within a cube of 2 m about the origin, or "
    "through the origin",
}


def two_pairs_trial(condition, rng):
    """Compare (2.11) from two pairs of points of each of 100 lines."""
    origins, directions = draw_lines(rng)
    first, second = (
        normalised(pluecker_matrix(*homogeneous_pair(o, directions, rng)))
        for o in (origins, origins)
    )
    return {
        "difference": np.abs(first - second).max(),
        "asymmetry": np.abs(first + np.swapaxes(first, 1, 2)).max(),
    }


def origin_trial(condition, rng):
    """Compute moments of (2.12): 100 lines through the origin, 100 others."""
    origins, directions = draw_lines(rng)
    ratio = {}
    for name, place in (("through", 0.0), ("beside", origins)):
        pair = homogeneous_pair(place, directions, rng)
        vectors = pluecker_vector(pluecker_matrix(*pair))
        ratio[name] = np.linalg.norm(vectors[:, 3:], axis=1)
        ratio[name] /= np.linalg.norm(vectors, axis=1)
    return {
        "through_origin": ratio["through"].max(),
        "beside_origin": ratio["beside"].min(),
        "least_distance_m": np.linalg.norm(np.cross(origins, directions), axis=1).min(),
    }


def draw_lines(rng):
    """Return points (100, 3) and unit directions of random lines."""
    origins = rng.uniform(-EXTENT_M, EXTENT_M, (LINES, 3))
    directions = rng.normal(size=(LINES, 3))
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def homogeneous_pair(origins, directions, rng):
    """Yield two distinct points (N, 4) on each line, each with its own scale."""
    places = rng.uniform(-EXTENT_M, EXTENT_M, (2, len(directions)))
    close = np.abs(places[0] - places[1]) < MIN_SEPARATION * EXTENT_M
    places[1, close] = places[0, close] + EXTENT_M
    for place in places:
        point = origins + place[:, None] * directions
        scale = rng.uniform(0.2, 5.0, (len(point), 1))
        yield scale * np.column_stack([point, np.ones(len(point))])


def normalised(matrices):
    """Return matrices of unit norm with positive largest entry."""
    flat = matrices.reshape(len(matrices), -1)
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    largest = np.argmax(np.abs(np.triu(matrices)).reshape(flat.shape), 1)
    sign = np.sign(flat[np.arange(len(flat)), largest])
    return (sign[:, None] * flat).reshape(matrices.shape)


@experiment("exp_c2_pluecker_invariant", artefact="sec_2_3")
def lines_by_two_pairs(effort):
    """Plücker matrices of random lines, each from two pairs of points."""
    return Plan(two_pairs_trial, [{}], LINE_TRIALS[effort], LINE_SETTINGS)


@experiment("exp_c2_pluecker_origin", artefact="sec_2_3")
def lines_through_origin(effort):
    """Plücker vectors of lines through the origin and of others."""
    return Plan(origin_trial, [{}], LINE_TRIALS[effort], LINE_SETTINGS)
