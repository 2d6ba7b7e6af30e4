"""The simulated wide-angle camera of 4.1.5, in front of grids in random poses.

World = base grid, z = 0. The camera is 600 mm above it and looks straight down. Other
grids are shifted and rotated at random, and no pose is rejected: grids may be nearly
parallel. Rays are those that meet every grid, not at grazing incidence. Every grid has
its own noise, the base grid included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raxel.cameras import FisheyeCamera, PerspectiveCamera
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    pose,
    rotation_from_vector,
)

SIZE_PX = 640
RADIUS_PX = SIZE_PX / 2  # of the circular image
PRINCIPAL = np.full(2, (SIZE_PX - 1) / 2)
RAYS = 999
FOV_DEG = 100.0
LENS_K1 = -0.1
CENTRE_MM = np.array([0.0, 0.0, 600.0])
SHIFT_MM = 150.0
EULER_DEG = 30.0
# Of |cos| of the angle between a ray and a plane's normal.
MIN_INCIDENCE = 0.1
# x right, y down, z forward: y and z are those of the base grid, reversed.
T_BASE_CAMERA = pose(np.diag([1.0, -1.0, -1.0]), CENTRE_MM)
SIDE = 1  # sign of C_z, which the data do not determine

SETTINGS = {
    "image_px": [SIZE_PX, SIZE_PX],
    "image": "circular; the field of view is its diameter",
    "rays_per_trial": RAYS,
    "centre_mm": CENTRE_MM.tolist(),
    "grids": "shifted by up to 150 mm along and turned by up to 30 deg about "
    "each axis, unbounded; none rejected",
    "least_cosine_of_incidence": MIN_INCIDENCE,
    "side": SIDE,
}


class OutOfView(RuntimeError):
    """Hardly any ray meets all grids."""


def radial_lens(fov_deg=FOV_DEG, k1=LENS_K1):
    """Return a pinhole camera with one radial term whose circle shows ``fov_deg``."""
    tangent = np.tan(np.radians(fov_deg) / 2)
    focal = RADIUS_PX / (tangent * (1 + k1 * tangent**2))
    K = np.array([[focal, 0, PRINCIPAL[0]], [0, focal, PRINCIPAL[1]], [0, 0, 1.0]])
    return PerspectiveCamera(K, (k1,), SIZE_PX, SIZE_PX)


def equidistance(fov_deg):
    """Return a fisheye with r = f theta whose circle shows ``fov_deg``."""
    half = np.radians(fov_deg) / 2
    return FisheyeCamera(
        "equidistance", RADIUS_PX / half, PRINCIPAL, SIZE_PX, SIZE_PX, 1.1 * half
    )


def wide_lens(fov_deg):
    """Return the lens of 4.1.5 for its field of view, a fisheye for any other."""
    return radial_lens() if fov_deg == FOV_DEG else equidistance(fov_deg)


def draw_poses(rng, grids=3, euler_deg=EULER_DEG):
    """Return T_base_grid (grids, 4, 4): the base itself, then random ones."""
    return np.stack(
        [np.eye(4)] + [_draw_pose(rng, euler_deg) for _ in range(grids - 1)]
    )


def _draw_pose(rng, euler_deg):
    shift = rng.uniform(-SHIFT_MM, SHIFT_MM, 3)
    R = np.eye(3)
    for axis, angle in zip(
        np.eye(3), np.radians(rng.uniform(-euler_deg, euler_deg, 3)), strict=True
    ):
        R = rotation_from_vector(angle * axis) @ R
    return pose(R, shift)


def back_project(camera, pixels, T_base_grid):
    """Return points (n, N, 2) of n grids that pixels (N, 2) see, and a mask (n, N).

    pixels may be (n, N, 2), different ones for each grid.
    """
    if pixels.ndim == 2:
        by_grid = [camera.rays(pixels)] * len(T_base_grid)
    else:
        by_grid = [camera.rays(seen_by) for seen_by in pixels]
    points, seen = [], []
    for T, rays in zip(T_base_grid, by_grid, strict=True):
        T_camera_grid = inverse_pose(T_BASE_CAMERA) @ T
        hit = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
        incidence = np.abs(rays.directions @ T_camera_grid[:3, 2])
        points.append(hit.points)
        seen.append(rays.valid & hit.valid & (incidence >= MIN_INCIDENCE))
    return np.stack(points), np.stack(seen)


def draw_pixels(camera, T_base_grid, rng, rays=RAYS, half_mm=np.inf):
    """Return pixels (rays, 2), uniform over the circle, that see every grid.

    half_mm: half the size of the grids along both axes.
    """
    kept = np.empty((0, 2))
    for _ in range(1000):
        pixels = rng.uniform(-0.5, SIZE_PX - 0.5, (2 * rays, 2))
        pixels = pixels[np.linalg.norm(pixels - PRINCIPAL, axis=1) <= RADIUS_PX]
        points, seen = back_project(camera, pixels, T_base_grid)
        on_grid = (np.abs(points) <= half_mm).all(axis=2)
        seen = (seen & on_grid).all(axis=0)
        kept = np.concatenate([kept, pixels[seen]])
        if len(kept) >= rays:
            return kept[:rays]
    raise OutOfView("the grids are all but out of view")


@dataclass(frozen=True)
class MeasuredGrids:
    """One trial's measurements, with the true values, which only scoring may use.

    pixels (N, 2); T_base_grid (n, 4, 4); points (n, N, 2): exact; noisy (n, N, 2): the
    input of calibrations. Rays that noise moves off a grid are excluded.
    """

    camera: object
    T_base_grid: np.ndarray
    pixels: np.ndarray
    points: np.ndarray
    noisy: np.ndarray

    @property
    def directions(self):
        """Return the true unit directions (N, 3) of the rays in the base frame."""
        return self.camera.rays(self.pixels).directions @ T_BASE_CAMERA[:3, :3].T


def observe(camera, T_base_grid, pixels, noise, domain, rng):
    """Return MeasuredGrids of pixels that see all grids; noise: SD in px or mm."""
    points, _ = back_project(camera, pixels, T_base_grid)
    drawn = noise * rng.standard_normal(points.shape)
    if domain == "mm":
        return MeasuredGrids(camera, T_base_grid, pixels, points, points + drawn)
    noisy, seen = back_project(camera, pixels + drawn, T_base_grid)
    keep = seen.all(axis=0)
    return MeasuredGrids(
        camera, T_base_grid, pixels[keep], points[:, keep], noisy[:, keep]
    )


def draw_scene(camera, noise, rng, *, grids=3, domain="px", rays=RAYS):
    """Return MeasuredGrids with random poses, rays and noise."""
    T_base_grid = draw_poses(rng, grids)
    pixels = draw_pixels(camera, T_base_grid, rng, rays)
    return observe(camera, T_base_grid, pixels, noise, domain, rng)
