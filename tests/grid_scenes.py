"""Views of an active grid per camera pixel, without rendered images."""

import numpy as np

from raxel.calibration import dense_view
from raxel.cameras.core.base import pixel_grid
from raxel.geometry.planes import intersect_rays_plane

SIZE_MM = np.array([170.0, 130.0])


def seen_points(camera, T_camera_grid, size_mm=SIZE_MM):
    """(H, W, 2) mm, NaN for pixels outside the grid."""
    shape = camera.height, camera.width
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
    on = hits.valid & np.all((hits.points >= 0) & (hits.points <= size_mm), axis=1)
    return np.where(on[:, None], hits.points, np.nan).reshape(*shape, 2)


def grids_of(poses, camera, noise_mm=0.0, seed=0, size_mm=SIZE_MM):
    """DenseViews of a grid at these poses, with Gaussian noise on every point."""
    rng = np.random.default_rng(seed)
    views = []
    for k, T in enumerate(poses):
        points = seen_points(camera, T, size_mm)
        points += noise_mm * rng.normal(size=points.shape)
        sigma = np.full(points.shape, noise_mm) if noise_mm else None
        views.append(dense_view(points, sigma, name=f"pose-{k}"))
    return views
