"""Three tilted planes in front of a camera: measurements on them, and scores.

999 random pixels are back-projected on each plane, with noise that is
independent from plane to plane. The base plane is measured once more, with
noise that no calibration uses. The rays of every method are scored the same way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from raxel.calibration import bundle_adjust_fixed_centre
from raxel.cameras import FisheyeCamera, PerspectiveCamera
from raxel.evaluation import distortion_residual
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    on_plane,
    pose,
    rotate,
    rotation_from_vector,
    transform,
)

SIZE_PX = 640
POINTS = 999
PRINCIPAL = np.full(2, (SIZE_PX - 1) / 2)
CORNER_RADIUS_PX = np.hypot(*PRINCIPAL)
DISTANCE_MM = 600.0
SHIFT_MM = 150.0
TILT_DEG = (10.0, 30.0)
MIN_ANGLE_DEG = 10.0
FINITE_MM = 600.0
LENS_K1, LENS_K2 = -0.2, 0.05
# Fields of view of the sweep of Fig. 2.3(b), on the image diagonal.
FOVS_DEG = (30, 45, 60, 75, 90, 105, 120, 135, 150)


def fisheye(projection, fov_deg):
    """A fisheye of the field of view ``fov_deg`` on the image diagonal."""
    half = np.radians(fov_deg) / 2
    radius_at_unit_focal = {
        "equidistance": half,
        "equisolid": 2 * np.sin(half / 2),
        "stereographic": 2 * np.tan(half / 2),
    }[projection]
    focal = CORNER_RADIUS_PX / radius_at_unit_focal
    return FisheyeCamera(projection, focal, PRINCIPAL, SIZE_PX, SIZE_PX, 1.1 * half)


def perspective(fov_deg, radial=()):
    """A pinhole of that diagonal field of view, with radial distortion."""
    focal = CORNER_RADIUS_PX / np.tan(np.radians(fov_deg) / 2)
    K = np.array([[focal, 0, PRINCIPAL[0]], [0, focal, PRINCIPAL[1]], [0, 0, 1.0]])
    return PerspectiveCamera(K, radial, SIZE_PX, SIZE_PX)


def camera_of(law, fov_deg):
    """The camera of a condition; ``lens`` is one a pinhole can be."""
    if law == "lens":
        return perspective(fov_deg, (LENS_K1, LENS_K2))
    if law == "perspective":
        return perspective(fov_deg)
    return fisheye(law, fov_deg)


def draw_grids(rng):
    """Poses T_camera_grid (3, 4, 4) of grids, no two nearly parallel."""
    while True:
        grids = np.stack([_draw_grid(rng) for _ in range(3)])
        normals = grids[:, :3, 2]
        cosines = (normals @ normals.T)[np.triu_indices(3, 1)]
        angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
        if angles.min() >= MIN_ANGLE_DEG:
            return grids, angles.min()


def _draw_grid(rng):
    """A grid facing the camera (z away from it), tilted, shifted."""
    axis = rng.uniform(0, 2 * np.pi)
    tilt = np.radians(rng.uniform(*TILT_DEG))
    R = rotation_from_vector(tilt * np.array([np.cos(axis), np.sin(axis), 0.0]))
    spin = rotation_from_vector(np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)]))
    shift = rng.uniform(-SHIFT_MM, SHIFT_MM, 3)
    return pose(R @ spin, shift + [0.0, 0.0, DISTANCE_MM])


def met(rays, T_camera_grid):
    """Points (N, 2) of a grid that rays meet, and whether they do."""
    hit = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
    return hit.points, rays.valid & hit.valid


def draw_pixels(camera, grids, extent, rng):
    """999 random pixels that see all grids, and the share that do."""
    kept, tried = np.empty((0, 2)), 0
    while len(kept) < POINTS:
        pixels = rng.uniform(-0.5, SIZE_PX - 0.5, (4 * POINTS, 2))
        seen, rays = np.ones(len(pixels), bool), camera.rays(pixels)
        for T_camera_grid in grids:
            points, hit = met(rays, T_camera_grid)
            seen &= hit
            if extent == "finite":
                seen &= hit & (
                    np.abs(np.where(hit[:, None], points, 0)) <= FINITE_MM
                ).all(1)
        kept = np.concatenate([kept, pixels[seen]])
        tried += len(pixels)
        if tried > 4000 * POINTS:
            raise RuntimeError("the grids are almost outside the field of view")
    return kept[:POINTS], len(kept) / tried


@dataclass(frozen=True)
class Data:
    """One trial's measurements, with the truth that only scoring may use.

    pixels (N, 2), points (3, N, 2): clean. noisy_pixels (3, N, 2): what the
    parametric method gets; noisy_points (3, N, 2): the generic method.
    fresh_pixels, fresh_points (N, 2): the base grid measured once more.
    """

    camera: object
    grids: np.ndarray
    pixels: np.ndarray
    noisy_pixels: np.ndarray
    points: np.ndarray
    noisy_points: np.ndarray
    fresh_pixels: np.ndarray
    fresh_points: np.ndarray

    @cached_property
    def directions(self):
        """True directions (N, 3) of the clean pixels' rays."""
        return self.camera.rays(self.pixels).directions

    @cached_property
    def grazing_ranks(self):
        """Ranks (N,) of the rays, those last that graze one of the planes most."""
        on_normals = [
            rotate(inverse_pose(T), self.directions)[:, 2] for T in self.grids
        ]
        least_sine = np.min(np.abs(on_normals), axis=0)
        return np.argsort(np.argsort(1 / least_sine))


def draw_noise(size, rng):
    """Noise (4, N, 2) of SD size: of three grids, and of the base once more."""
    return size * rng.standard_normal((4, POINTS, 2))


def measure(condition, rng):
    """Draw a trial: camera, grids, pixels, noise anew for every grid."""
    camera = camera_of(condition["law"], condition["fov_deg"])
    grids, least_angle = draw_grids(rng)
    pixels, share = draw_pixels(camera, grids, condition["extent"], rng)
    noise = draw_noise(condition["noise"], rng)
    data = observe(camera, grids, pixels, noise, condition["domain"])
    return data, {"accepted_share": share, "least_angle_deg": least_angle}


def observe(camera, grids, pixels, noise, domain):
    """Data of pixels that see all grids; noise (4, N, 2) in px or mm."""
    looks = [*grids, grids[0]]
    rays = camera.rays(pixels)
    points = np.stack([met(rays, T)[0] for T in looks])
    keep = np.ones(len(pixels), bool)
    noisy_pixels, noisy_points = np.repeat(pixels[None], 4, 0), points
    if domain == "px":
        noisy_pixels = pixels + noise
        seen = [
            met(camera.rays(p), T) for p, T in zip(noisy_pixels, looks, strict=True)
        ]
        noisy_points = np.stack([s[0] for s in seen])
        keep = np.all([s[1] for s in seen], axis=0)
    else:
        noisy_points = points + noise
    noisy_pixels, noisy_points = (noisy_pixels[:, keep], noisy_points[:, keep])
    return Data(
        camera, grids, pixels[keep], noisy_pixels[:3], points[:3, keep],
        noisy_points[:3], noisy_pixels[3], noisy_points[3],
    )  # fmt: skip


def central_focal(camera):
    """Scale of corrected views: central px per unit of tangent."""
    step = 1e-4
    towards = np.array([[step, 0.0, 1.0], [-step, 0.0, 1.0]])
    ends = camera.project(towards).pixels
    return np.linalg.norm(ends[0] - ends[1]) / (2 * step)


def view(directions, focal):
    """Corrected image (px): rays cut by a plane across the z axis."""
    return focal * directions[:, :2] / directions[:, 2:]


def about_principal_ray(directions, pixels):
    """Rotate the ray nearest the principal point onto the z axis."""
    nearest = np.argmin(np.sum((pixels - PRINCIPAL) ** 2, axis=1))
    z = directions[nearest]
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    return directions @ np.stack([x, np.cross(z, x), z], axis=1)


def score(corrected, target, camera, focal):
    """Residuals after the homography onto known positions, in two scales.

    corrected, target: (N, 2) px of corrected views. Returns lengths (N,) in
    px of the corrected view and, for the same pairs, of the source image.
    """
    residual = distortion_residual(target, corrected)
    return lengths(target, target - residual, camera, focal)


def adjusted_rays(data, centre, T_base_grid):
    """Rays (N, 3) in the base grid's frame, adjusted together with the other grids."""
    seen = np.ones(data.noisy_points.shape[:2], bool)
    return bundle_adjust_fixed_centre(
        data.noisy_points, seen, centre, T_base_grid
    ).directions


def noise_alone(data, focal):
    """Lengths (N,) in both scales that fresh noise leaves of exact rays."""
    known = targets(data, focal)
    return lengths(known["fresh"], known["clean"], data.camera, focal)


def lengths(one, other, camera, focal):
    """Distances (N,) of positions in a corrected view, in two scales."""
    on_sensor = [
        camera.project(np.column_stack([p / focal, np.ones(len(p))])).pixels
        for p in (one, other)
    ]
    return {
        "corrected": np.linalg.norm(one - other, axis=1),
        "source": np.linalg.norm(on_sensor[0] - on_sensor[1], axis=1),
    }


def targets(data, focal):
    """Known positions in the true corrected view, by how they are scored.

    noisy: the points of the base grid that were calibrated with; fresh:
    measured anew; clean: without noise.
    """
    return {
        "fresh": _in_view(data.fresh_points, data.grids[0], focal),
        "noisy": _in_view(data.noisy_points[0], data.grids[0], focal),
        "clean": view(data.directions, focal),
    }


def _in_view(points, T_camera_grid, focal):
    """Corrected view (px) of points (N, 2) of a grid."""
    flat = on_plane(points)
    return view(transform(T_camera_grid, flat), focal)
