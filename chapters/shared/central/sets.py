"""The two cameras of section 4.3 and their active grids: sets, rays, true values."""

from __future__ import annotations

import json
from typing import NamedTuple

import numpy as np

from raxel.calibration import linear_cgsp
from raxel.cameras import closest_point, load_camera
from raxel.features.active_grid import decode
from raxel.geometry import inverse_pose, transform
from raxel.sets import load_set, read_image

OMNI, FISH = "omnidirectional", "fisheye"
RIGS = {OMNI: "onevr-d70", FISH: "coolpix-4500-fce8"}
SMALL = {"quick": "-small", "full": ""}
RUNS = {"quick": (0,), "full": (0, 1, 2)}
LINEAR_GRIDS = 3  # 4.3.1
MAX_RAYS = 20_000  # 4.1.2
# Literals, which the workflow reads without running them.
GRID_SETS = {
    "quick": ("onevr-d70-small/0", "coolpix-4500-fce8-small/0"),
    "full": (
        "onevr-d70/0", "onevr-d70/1", "onevr-d70/2",
        "coolpix-4500-fce8/0", "coolpix-4500-fce8/1", "coolpix-4500-fce8/2",
    ),
}  # fmt: skip
GRID_RIGS = (
    "data/rigs/onevr-d70.yaml",
    "data/rigs/onevr-d70-small.yaml",
    "data/rigs/coolpix-4500-fce8.yaml",
    "data/rigs/coolpix-4500-fce8-small.yaml",
)


class SharedRays(NamedTuple):
    """Rays that meet the three grids of the linear stage.

    points: (3, N, 2) mm, where they meet each; pixels: (N, 2); found: the number of
    all, of which at most MAX_RAYS are here; left_out: share of these that RANSAC
    rejects.
    """

    points: np.ndarray
    pixels: np.ndarray
    found: int
    left_out: float


class TrueGrids(NamedTuple):
    """True values of a set, in the frame of its base grid, for scoring.

    centre: (3,) the point nearest to the rays that are scored; T_base_grid: (3, 4, 4);
    scatter_mm: RMS distance of these rays from it.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    scatter_mm: float


def grid_conditions(effort):
    """Return a condition for every rendered set of both cameras."""
    return [
        {"camera": camera, "rig": RIGS[camera] + SMALL[effort], "seed": seed}
        for camera in RIGS
        for seed in RUNS[effort]
    ]


def first_points(folder, count=LINEAR_GRIDS):
    """Return decoded points (count, H * W, 2) of the first grids, NaN if missing."""
    points = []
    for _, found in decoded_grids(folder, count):
        seen = np.where(found.mask[..., None], found.location, np.nan)
        points.append(seen.reshape(-1, 2))
    return np.array(points)


def first_points_and_truth(folder, count=LINEAR_GRIDS):
    """Return `first_points` and the true points (count, H * W, 2), for scoring."""
    decoded, true = [], []
    for grid in scored_grids(folder, count):
        seen = grid.decoded.mask[..., None]
        decoded.append(np.where(seen, grid.decoded.location, np.nan).reshape(-1, 2))
        true.append(grid.points.reshape(-1, 2))
    return np.array(decoded), np.array(true)


def shared_rays(points, width, rng, most=MAX_RAYS):
    """Return the SharedRays of decoded points (3, H * W, 2), without outliers.

    RANSAC estimates the homographies between grids (4.3.1). A ray whose points do not
    fit one of them is excluded for all methods.
    """
    common = np.flatnonzero(np.isfinite(points[..., 0]).all(axis=0))
    chosen = common
    if len(common) > most:
        chosen = np.sort(rng.choice(common, most, replace=False))
    some = points[:, chosen].astype(float)
    good = linear_cgsp(some, robust="ransac", rng=rng).inliers[1:].all(axis=0)
    kept = chosen[good]
    pixels = np.column_stack([kept % width, kept // width]).astype(float)
    return SharedRays(some[:, good], pixels, len(common), 1 - good.mean())


def true_grids(camera, T_camera_grid, pixels):
    """Return the TrueGrids of a camera, poses of the three grids, and pixels."""
    T_base = inverse_pose(T_camera_grid[0])
    rays = camera.rays(pixels)
    centre = closest_point(rays)
    reach = rays.origins - centre
    along = np.sum(reach * rays.directions, axis=1, keepdims=True)
    across = reach - along * rays.directions
    return TrueGrids(
        transform(T_base, centre),
        np.array([T_base @ T for T in T_camera_grid]),
        float(np.sqrt(np.mean(np.sum(across**2, axis=1)))),
    )


def true_grids_of_set(folder, pixels):
    """Return the TrueGrids of a rendered set."""
    poses = list(true_poses(folder).values())[:LINEAR_GRIDS]
    return true_grids(true_camera(folder), poses, pixels)


# Rendered sets of active grids: decoded points, and true ones for scoring.


class ScoredGrid(NamedTuple):
    """The decoded points of a view and its true ones, for scoring only.

    decoded: Decoded; points: (H, W, 2) mm, the true point of each pixel, NaN off the
    monitor; T_camera_grid: (4, 4).
    """

    name: str
    decoded: object
    points: np.ndarray
    T_camera_grid: np.ndarray


def decoded_grids(folder, count=None, **options):
    """Yield (name, Decoded) of each view of a rendered set, or of the first `count`.

    options: of `decode`. As in the thesis, no response is measured or corrected.
    """
    image_set = load_set(folder)
    for view in image_set.views[:count]:
        images = np.array(
            [read_image(image_set, shown.image) for shown in view.patterns]
        )
        settings = {"linear": True, **options}
        yield view.label, decode(images, view.patterns, image_set.target, **settings)


def scored_grids(folder, count=None, **options):
    """Yield the `ScoredGrid` of each view of a rendered set, as `decoded_grids`."""
    poses = true_poses(folder)
    for name, found in decoded_grids(folder, count, **options):
        with np.load(folder / "truth" / f"{name}.npz") as truth:
            points = truth["points_mm"]
        yield ScoredGrid(name, found, points, poses[name])


def true_camera(folder):
    """Return the camera of a rendered set, for scoring."""
    return load_camera(folder / "truth" / "camera.npz")


def true_poses(folder):
    """Return {view: T_camera_grid (4, 4)} of a rendered set, mm, for scoring."""
    text = (folder / "truth" / "poses.json").read_text("utf-8")
    poses = json.loads(text)["T_camera_target"]
    return {name: np.array(T) for name, T in poses.items()}
