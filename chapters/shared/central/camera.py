"""The simulated wide-angle camera of 4.1.5, before grids in any pose.

World = base grid, z = 0. The camera's centre is 600 mm above it and looks straight
down. Other grids are shifted and turned at random, and no pose is rejected: a grid may
be as good as parallel to another. Rays are those that meet every grid, not too nearly
along it. Noise is drawn anew for every grid, the base grid included.
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
# |cos| of the angle between a ray and a plane's normal, at least.
MIN_INCIDENCE = 0.1
# x right, y down, z ahead: the base grid's y and z, turned over.
T_BASE_CAMERA = pose(np.diag([1.0, -1.0, -1.0]), CENTRE_MM)
SIDE = 1  # sign of C_z, which data cannot tell

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
    """No ray, or next to none, meets all grids."""


def radial_lens(fov_deg=FOV_DEG, k1=LENS_K1):
    """A pinhole with one radial term whose circle shows ``fov_deg``."""
    tangent = np.tan(np.radians(fov_deg) / 2)
    focal = RADIUS_PX / (tangent * (1 + k1 * tangent**2))
    K = np.array([[focal, 0, PRINCIPAL[0]], [0, focal, PRINCIPAL[1]], [0, 0, 1.0]])
    return PerspectiveCamera(K, (k1,), SIZE_PX, SIZE_PX)


def equidistance(fov_deg):
    """A fisheye with r = f theta whose circle shows ``fov_deg``."""
    half = np.radians(fov_deg) / 2
    return FisheyeCamera(
        "equidistance", RADIUS_PX / half, PRINCIPAL, SIZE_PX, SIZE_PX, 1.1 * half
    )


def wide_lens(fov_deg):
    """The lens of 4.1.5 where the field of view is its, and a fisheye elsewhere."""
    return radial_lens() if fov_deg == FOV_DEG else equidistance(fov_deg)


def draw_poses(rng, grids=3, euler_deg=EULER_DEG):
    """T_base_grid (grids, 4, 4): the base itself, then others at random."""
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
    """Points (n, N, 2) of n grids that pixels (N, 2) see, and which they are, (n, N).

    pixels may be (n, N, 2), others for each grid.
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
    """Pixels (rays, 2), evenly over the circle, that see every grid.

    half_mm: the grids reach so far from their origin along both axes.
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
    """One trial's measurements, with the truth that only scoring may use.

    pixels (N, 2); T_base_grid (n, 4, 4); points (n, N, 2): clean; noisy (n, N, 2): what
    calibrations get. Rays that noise takes off a grid are left out.
    """

    camera: object
    T_base_grid: np.ndarray
    pixels: np.ndarray
    points: np.ndarray
    noisy: np.ndarray

    @property
    def directions(self):
        """True unit directions (N, 3) of the rays in the base frame."""
        return self.camera.rays(self.pixels).directions @ T_BASE_CAMERA[:3, :3].T


def observe(camera, T_base_grid, pixels, noise, domain, rng):
    """Grids measured by pixels that see all of them; noise: SD in px or mm."""
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
    """MeasuredGrids with poses, rays and noise drawn anew."""
    T_base_grid = draw_poses(rng, grids)
    pixels = draw_pixels(camera, T_base_grid, rng, rays)
    return observe(camera, T_base_grid, pixels, noise, domain, rng)
