"""Central cameras of any kind before grids, and what their rays meet.

World = base grid, z = 0; every camera's centre is 600 mm above it.
"""

import numpy as np

from chapters.shared.wide_angle import (
    CENTRE_MM,
    LEAST_INCIDENCE,
    RAYS,
    T_BASE_CAMERA,
    equidistance,
    radial_lens,
)
from chapters.shared.zoo import ZOO
from raxel.cameras import closest_point
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import intersect_rays_plane, pose, rotate, transform

WIDE_FOV_DEG = 183.0
CONE_DEG = 100.0
# The mirror looks sideways: its x axis down at the grids.
SIDEWAYS = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])


def _of_camera(camera, T_base_camera):
    """A function rng -> rays of random pixels in the base frame."""

    def draw(rng):
        rays = camera.rays(rng.uniform(-0.5, camera.width - 0.5, (4 * RAYS, 2)))
        return (
            transform(T_base_camera, rays.origins[rays.valid]),
            rotate(T_base_camera, rays.directions[rays.valid]),
        )

    return draw


def lens(camera):
    """Rays of a lens that looks straight down."""
    return _of_camera(camera, T_BASE_CAMERA)


def mirror():
    """Rays of a hyperboloid mirror with its viewer in the focus."""
    camera = ZOO["hyperboloid mirror"].build()
    rays = camera.rays(pixel_grid(camera.width, camera.height)[::7])
    shift = CENTRE_MM - SIDEWAYS @ closest_point(rays)
    return _of_camera(camera, pose(SIDEWAYS, shift))


def no_lens():
    """Rays at random in a cone: as if each pixel looked where it likes."""

    def draw(rng):
        z = -rng.uniform(np.cos(np.radians(CONE_DEG / 2)), 1, 4 * RAYS)
        turn = rng.uniform(0, 2 * np.pi, len(z))
        across = np.sqrt(1 - z**2)
        directions = np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
        return np.broadcast_to(CENTRE_MM, directions.shape), directions

    return draw


def camera_of(name):
    """The drawing function of one of CAMERAS."""
    if name == "radial lens, 100°":
        return lens(radial_lens())
    if name == "equidistance, 183°":
        return lens(equidistance(WIDE_FOV_DEG))
    return mirror() if name == "hyperboloid mirror" else no_lens()


CAMERAS = (
    "radial lens, 100°",
    "equidistance, 183°",
    "hyperboloid mirror",
    "no lens: rays at random",
)


def draw_points(draw, T_base_grid, rng):
    """Points (n, 999, 2) of rays that meet every grid, not too nearly along it."""
    kept = []
    while sum(map(len, kept)) < RAYS:
        origins, directions = draw(rng)
        hits = [intersect_rays_plane(origins, directions, T) for T in T_base_grid]
        seen = [
            hit.valid & (np.abs(directions @ T[:3, 2]) >= LEAST_INCIDENCE)
            for hit, T in zip(hits, T_base_grid, strict=True)
        ]
        points = np.stack([hit.points for hit in hits], axis=1)
        kept.append(points[np.all(seen, axis=0)])
    return np.swapaxes(np.concatenate(kept)[:RAYS], 0, 1)
