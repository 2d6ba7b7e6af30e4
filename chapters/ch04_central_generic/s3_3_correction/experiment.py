"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from functools import cache, lru_cache, partial
from typing import NamedTuple

import numpy as np

from chapters.shared.central import (
    GRID_SETS,
    MATCHED,
    NOISES,
    OMNI,
    RIGS,
    RUNS,
    SMALL,
    SWEPT_NOISES,
    DecodingErrors,
    grid_conditions,
    lattice_rays,
    redrawn_lattice,
    scored_grids,
    true_camera,
    true_lattice,
    true_poses,
)
from chapters.shared.methods import LINEAR_STAGES
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    board_views,
    calibrate_central,
    centroid_directions,
    grid_pose_ransac,
    linear_cgsp,
    pose_from_rays,
    relaxed_start,
    synthetic_plane_normal,
)
from raxel.cameras import GeneralCamera
from raxel.errors import CalibrationError
from raxel.evaluation import distortion_residual
from raxel.features import detect_boards
from raxel.geometry import inverse_pose, pose, transform
from raxel.lab import room
from raxel.multiview import resample
from raxel.sets import load_set
from repro.run import Plan, experiment
from repro.run.rendered import rendered_set

# Both generic methods on the same decoded grids, and their rays on a lattice (4.3.1).
#
# The standard method adjusts the poses of three grids (centre kept) and places further
# grids by three points and a refinement. CGSP does not adjust its linear stage, and
# places further grids linearly. Outliers are detected once, and both get the same
# points.


LINEAR = 3  # grids of the linear stage
# weight: of the linear stage's points in the rays, against those of further grids;
# most: points used for the pose of a further grid.
PROTOCOL = {"weight": 10.0, "most": 2000}
ADJUSTED = 2000  # rays that the poses are adjusted on
# Linear stages by their names in these trials.
SWEPT_METHODS = ("printed", "cgsp")  # along the sweep of the noise level
METHODS = {"printed": "as_printed", "conditioned": "well_conditioned", "cgsp": "cgsp"}


def without_outliers(points, rng):
    """Return points (n, N, 2) with NaN where the grids of the linear stage disagree.

    Points of a grid that fit no homography to the base grid are outliers.
    """
    first = points[:LINEAR]
    found = linear_cgsp(first, robust="ransac", rng=rng)
    shared = np.isfinite(first[0, :, 0]) & np.isfinite(first[..., 0])
    kept = points.copy()
    kept[:LINEAR][shared & ~found.inliers] = np.nan
    return kept


def by_protocol(points, method, rng):
    """Return the CentralCalibration of one of METHODS from points (n, N, 2).

    Raises CalibrationError where the linear stage fails. As printed, it needs
    rays that see all three grids.
    """
    first = points[:LINEAR]
    seen = np.isfinite(first[..., 0]).all(axis=0)
    given = first[:, seen] if method == "printed" else first
    start = LINEAR_STAGES[METHODS[method]](given)
    if method == "cgsp":
        return calibrate_central(points, start, grid_pose_ransac, rng, **PROTOCOL)
    start = relaxed_start(first, start, ADJUSTED)
    return calibrate_central(points, start, pose_from_rays, rng, **PROTOCOL)


STEP = {"quick": 2, "full": 6}  # px between neighbours of the lattice of rays
ALL_SETS = {
    "quick": (
        "onevr-d70-small/0",
        "coolpix-4500-fce8-small/0",
        "onevr-d70-boards-small/0",
        "coolpix-4500-fce8-boards-small/0",
    ),
    "full": (
        "onevr-d70/0",
        "onevr-d70/1",
        "onevr-d70/2",
        "coolpix-4500-fce8/0",
        "coolpix-4500-fce8/1",
        "coolpix-4500-fce8/2",
        "onevr-d70-boards/0",
        "onevr-d70-boards/1",
        "onevr-d70-boards/2",
        "coolpix-4500-fce8-boards/0",
        "coolpix-4500-fce8-boards/1",
        "coolpix-4500-fce8-boards/2",
    ),
}


class Lattice(NamedTuple):
    """Every step-th pixel of an image in both directions, from ``step // 2``.

    shape: (h, w); pixels: (N, 2), the nodes that see at least one grid.
    """

    step: int
    shape: tuple
    pixels: np.ndarray

    def places(self, pixels):
        """Return lattice positions (N, 2), with nodes at whole numbers."""
        return (np.asarray(pixels, float) - self.step // 2) / self.step

    def table(self, values):
        """Return node values (N, ...) as an array (h, w, ...), NaN elsewhere."""
        u, v = self.places(self.pixels).astype(int).T
        table = np.full((*self.shape, *np.shape(values)[1:]), np.nan)
        table[v, u] = values
        return table


class LatticeRays(NamedTuple):
    """A method's rays on a lattice, and the grids they come from.

    camera: GeneralCamera over the lattice's nodes, in the true camera's axes;
    calibration: CentralCalibration; sources (h, w): a bit for every grid used.
    """

    camera: GeneralCamera
    calibration: object
    sources: np.ndarray


def decoded_points(folder, step, rng, noises=NOISES):
    """Return (Lattice, {noise: points (n, N, 2)}) of a rendered and decoded set.

    noises: {name: DecodingNoise}.
    """
    nodes = np.s_[step // 2 :: step, step // 2 :: step]
    decoded, true = [], []
    for grid in scored_grids(folder):
        seen = grid.decoded.mask[nodes][..., None]
        decoded.append(np.where(seen, grid.decoded.location[nodes], np.nan))
        true.append(grid.points[nodes])
    return _at_noises(decoded, true, step, rng, noises)


@lru_cache(maxsize=4)
def true_lattices(rig, seed, step, size_mm):
    """Return `true_lattice` of every grid of a rendered set."""
    folder = rendered_set(rig, seed)
    rays = lattice_rays(true_camera(folder), step)
    return [true_lattice(*rays, T, size_mm) for T in true_poses(folder).values()]


def redrawn_points(rig, seed, step, rng, errors, noises, size_mm=(376.9, 301.5)):
    """Return the same as `decoded_points`, with redrawn DecodingErrors.

    The errors are drawn once, and scaled for the thesis-matched level.
    """
    decoded, true = [], []
    for points, cosine in true_lattices(rig, seed, step, size_mm):
        decoded.append(redrawn_lattice(errors, points, cosine, rng, step))
        true.append(points)
    return _at_noises(decoded, true, step, rng, noises)


def _at_noises(decoded, true, step, rng, noises):
    """Return (Lattice, {noise: points (n, N, 2)}) of lattice tables (n, h, w, 2)."""
    shape = decoded[0].shape[:2]
    decoded, true = (
        np.reshape(tables, (len(tables), -1, 2)).astype(float)
        for tables in (decoded, true)
    )
    some = np.isfinite(decoded[..., 0]).any(axis=0)
    v, u = np.divmod(np.flatnonzero(some), shape[1])
    lattice = Lattice(step, shape, np.column_stack([u, v]) * float(step) + step // 2)
    points = {
        name: without_outliers(noise.points(decoded[:, some], true[:, some], rng), rng)
        for name, noise in noises.items()
    }
    return lattice, points


def calibrated(folder, lattice, points, rng, methods=tuple(METHODS)):
    """Return {method: LatticeRays, or the code of its error}.

    The true pose of the base grid rotates the rays to the camera's axes. Only the
    drawn view and the vertical depend on it.
    """
    R_camera_base = next(iter(true_poses(folder).values()))[:3, :3]
    out = {}
    for method in methods:
        try:
            found = by_protocol(points, method, rng)
            out[method] = on_lattice(lattice, points, found, R_camera_base)
        except CalibrationError as fault:
            out[method] = fault.code
    return out


def on_lattice(lattice, points, found, R_camera_base):
    """Return the LatticeRays of a CentralCalibration."""
    table = lattice.table(found.directions @ R_camera_base.T)
    mask = np.isfinite(table[..., 0])
    bits = np.isfinite(points[found.used][..., 0]).T @ (1 << np.array(found.used))
    camera = GeneralCamera(np.where(mask[..., None], table, 1.0), mask)
    return LatticeRays(camera, found, lattice.table(bits))


# A room in front of both cameras: corrected images and straight edges.


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


def images_trial(condition, rng):
    """Return two frames of the room, original and corrected by two calibrations."""
    name, rig = condition["camera"], condition["rig"]
    folder = rendered_set(rig, 0)
    bench = {MATCHED: NOISES[MATCHED]}
    lattice, points = decoded_points(folder, condition["step"], rng, bench)
    found = calibrated(folder, lattice, points[MATCHED], rng, ("printed", "cgsp"))
    laboratory = rig_named(rig).laboratory()
    out = {}
    for frame, turn in enumerate(TURNS_DEG[:VIEWS]):
        image = laboratory.render(room(), T_world_camera(name, folder, turn), rng)
        out[f"frame_{frame}"] = shrunk(image, 480)
        for method, one in found.items():
            if not isinstance(one, str):
                out[f"{method}_{frame}"] = corrected(image, one, lattice, name, folder)
    return out


def shrunk(image, width):
    """Return the image at about this width, neighbours averaged, uint8."""
    factor = max(1, image.shape[1] // width)
    h, w = (n // factor * factor for n in image.shape[:2])
    blocks = image[:h, :w].reshape(h // factor, factor, w // factor, factor)
    return blocks.mean(axis=(1, 3)).round().astype(np.uint8)


def corrected(image, found, lattice, name, folder):
    """Return the image on a cylinder or plane through calibrated rays, uint8."""
    R_camera_view = level_axes(downwards(name, folder), middle_direction(folder)).T
    directions = view_directions(name) @ R_camera_view.T
    seen = found.camera.project(directions.reshape(-1, 3))
    pixels = seen.pixels * lattice.step + lattice.step // 2
    pixels[~seen.valid] = np.nan
    shape = *directions.shape[:2], 2
    return resample(image, pixels.reshape(shape).astype(np.float32))


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


# Residuals of corrected chessboards, and the experiments of Figs 4.7 to 4.9.


MIN_CORNERS = 12  # corners with a ray
COLUMNS_OF_SEAM = 2
QUINTILES = 5
FIELDS = ("x_mm", "y_mm", "dx_mm", "dy_mm", "angle_deg", "radial_mm", "seam")


def cut_across(directions):
    """Return crossings (N, 2) of rays with their perpendicular plane, and angles (N,).

    directions: (N, 3). The plane is at distance 1, with the normal of (4.24). NaN
    behind it.
    """
    normal = synthetic_plane_normal(directions)
    across = np.linalg.svd(normal[None])[2][1:]
    height = directions @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        points = directions @ across.T / height[:, None]
    points[height <= 0] = np.nan
    return points, np.arccos(np.clip(height, -1, 1))


def corner_residuals(found, lattice, view, scale):
    """Return rows FIELDS of a board's corners that have a ray, or None.

    view: BoardView, mm; scale: from its image's pixels to the calibration's.
    The homography maps the corrected view to the metric grid, so that residuals
    are in mm on the board.
    """
    places = lattice.places((view.pixels + 0.5) * scale - 0.5)
    rays = found.camera.rays(places)
    if np.count_nonzero(rays.valid) < MIN_CORNERS:
        return None
    metric = np.asarray(view.points, float)
    image, angle = cut_across(rays.directions[rays.valid])
    residual = distortion_residual(metric[rays.valid], image)
    outward = metric[rays.valid] - metric[rays.valid].mean(axis=0)
    length = np.linalg.norm(outward, axis=1)
    radial = np.sum(residual * outward, axis=1) / np.maximum(length, 1e-9)
    seam = near_seam(found.sources, places, view)[rays.valid]
    return np.column_stack(
        [metric[rays.valid], residual, np.degrees(angle), radial, seam]
    )


def near_seam(sources, places, view):
    """Return corners (N,) within two columns of one calibrated by other grids."""
    height, width = sources.shape
    u, v = np.round(places).astype(int).T
    bits = sources[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)]
    rows = bits.reshape(-1, view.columns)
    adjacent = np.zeros(rows.shape, bool)
    for shift in range(1, COLUMNS_OF_SEAM + 1):
        differs = rows[:, shift:] != rows[:, :-shift]
        adjacent[:, shift:] |= differs
        adjacent[:, :-shift] |= differs
    return adjacent.ravel()


def statistics(rows):
    """Return mean and SD of residual lengths, and the measures of the claims."""
    lengths = np.hypot(rows[:, 2], rows[:, 3])
    seam = rows[:, 6] > 0
    out = {
        "corners": len(rows),
        "mean_mm": lengths.mean(),
        "sd_mm": lengths.std(ddof=1),
        "radial_bias": radial_bias(rows, lengths),
        "skew_spearman": spearman(rows[:, 4], lengths),
        "corners_at_seams": int(np.count_nonzero(seam)),
    }
    if seam.any() and not seam.all():
        out["seam_ratio"] = lengths[seam].mean() / lengths[~seam].mean()
    return out


def radial_bias(rows, lengths):
    """Return the largest mean radial residual of a radius quintile, over the RMS."""
    radius = np.hypot(*(rows[:, :2] - rows[:, :2].mean(axis=0)).T)
    order = np.argsort(radius)
    means = [part.mean() for part in np.array_split(rows[order, 5], QUINTILES)]
    return float(np.max(np.abs(means)) / np.sqrt(np.mean(lengths**2)))


def spearman(a, b):
    """Return the rank correlation; ties are rare in measured numbers."""
    return float(np.corrcoef(*(np.argsort(np.argsort(v)) for v in (a, b)))[0, 1])


def run_trial(condition, rng):
    """Return residuals of all boards of a rendered run, by method."""
    rig, seed = condition["rig"], condition["seed"]
    grids = rendered_set(rig, seed)
    boards = load_set(rendered_set(boards_of(rig), seed))
    scale = load_set(grids).width / boards.width
    noises = NOISES | SWEPT_NOISES
    lattice, points = decoded_points(grids, condition["step"], rng, noises)
    views = board_views(boards, detect_boards(boards))
    out = {"boards": len(boards.views), "boards_found": len(views)}
    for noise, seen in points.items():
        methods = SWEPT_METHODS if noise in SWEPT_NOISES else tuple(METHODS)
        found = calibrated(grids, lattice, seen, rng, methods)
        out[noise] = by_method(found, lattice, views, scale)
        if noise != MATCHED:
            for method in out[noise].values():
                method.pop("field", None)  # one is drawn
    return out


def by_method(calibrations, lattice, views, scale):
    """Return residuals of all boards by each method with a calibration."""
    out = {}
    for method, found in calibrations.items():
        if isinstance(found, str):
            out[method] = {"failed": found}
            continue
        fields = (corner_residuals(found, lattice, v, scale) for v in views)
        kept = [rows for rows in fields if rows is not None]
        out[method] = {
            "boards": len(kept),
            "calibrated_share": float(np.mean(found.camera.mask)),
            **statistics(np.concatenate(kept)),
            "field": largest(kept),
        }
    return out


def boards_of(rig):
    """Return the rig that renders the boards for a rig that renders grids."""
    small = SMALL["quick"]
    return rig.removesuffix(small) + "-boards" + small * rig.endswith(small)


def largest(fields):
    """Return the board with most corners that have a ray, for Fig. 4.9."""
    return max(fields, key=len)


# Of the vectors of Fig. 4.9; at the thesis's factor of 15 they would be invisible.
MAGNIFIED = 40
LINES = {"quick": 2, "full": 50}
LINES_STEP = {"quick": 4, "full": 12}


@experiment("fig_4_9_boards", artefact="fig_4_9", rendered=ALL_SETS)
def boards(effort):
    """Plan corrected chessboards of the rendered runs of both cameras."""
    cases = [case | {"step": STEP[effort]} for case in grid_conditions(effort)]
    return Plan(run_trial, cases, 1, {"step_px": STEP[effort], "magnified": MAGNIFIED})


@experiment("fig_4_7_pictures", artefact="fig_4_7", rendered=GRID_SETS)
def room_images(effort):
    """Plan two frames of a room by each camera, original and corrected."""
    cases = [
        {"camera": camera, "rig": name + SMALL[effort], "step": STEP[effort]}
        for camera, name in RIGS.items()
    ]
    return Plan(images_trial, cases, 1, {"step_px": STEP[effort]})


@experiment(
    "fig_4_7_lines", artefact="fig_4_7", rendered=GRID_SETS, needs=("table_4_3_errors",)
)
def lines(effort, results):
    """Plan redrawn calibrations of both cameras: edges and field of view."""
    step = LINES_STEP[effort]
    cases = [
        {
            "camera": camera,
            "rig": name + SMALL[effort],
            "seeds": list(RUNS[effort]),
            "step": step,
        }
        for camera, name in RIGS.items()
    ]
    errors = DecodingErrors.by_rig(results["table_4_3_errors"])
    trial = partial(lines_trial, errors=errors)
    return Plan(trial, cases, LINES[effort], {"step_px": step})
