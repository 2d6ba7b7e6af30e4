"""Central and nearly central cameras, and the results of the test."""

import numpy as np

from chapters.shared.central import (
    PRINCIPAL,
    SIDE,
    SIZE_PX,
    T_BASE_CAMERA,
    draw_pixels,
    draw_poses,
    equidistance,
)
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    adjust_consistent,
    centrality_test,
    linear_cgsp,
    relax_centrality,
)
from raxel.cameras import AxialCamera, centrality, closest_point
from raxel.geometry import intersect_rays_plane, inverse_pose, transform

RAYS = 500
GRIDS = 3
FOV_DEG = 120.0
PUPIL_SHIFT_MM = (10.0,)
NOISES_MM = (0.05, 0.1)
ALARM = 0.01
TRIALS = {"quick": 2, "full": 40}
MIRRORS = {
    "mirror_aligned": "onevr-d70-aligned-small",
    "mirror_half": "onevr-d70-half-small",
    "mirror_one": "onevr-d70-small",
    "mirror_two": "onevr-d70-double-small",
}
MIRROR_RIGS = (
    "data/rigs/onevr-d70-aligned-small.yaml",
    "data/rigs/onevr-d70-half-small.yaml",
    "data/rigs/onevr-d70-small.yaml",
    "data/rigs/onevr-d70-double-small.yaml",
)
CAMERAS = ("central", "pupil", *MIRRORS)
CENTRAL = ("central", "mirror_aligned")

CHOSEN = {
    "rays": RAYS,
    "grids": GRIDS,
    "fov_deg": FOV_DEG,
    "pupil_shift_mm": list(PUPIL_SHIFT_MM),
    "noise": "independent for every coordinate of every point",
    "alarm_below_p": ALARM,
}


def draw_geometry(name, rng):
    """Return camera, T_camera_grid (3, 4, 4), pixels (RAYS, 2), side of the centre."""
    if name in MIRRORS:
        rig = rig_named(MIRRORS[name])
        poses = rig.draw_poses(rng, GRIDS)
        return rig.camera, poses, _on_monitors(rig, poses, rng), -1
    camera = equidistance(FOV_DEG)
    if name == "pupil":
        camera = AxialCamera(
            camera.projection,
            camera.focal_px,
            PRINCIPAL,
            PUPIL_SHIFT_MM,
            SIZE_PX,
            SIZE_PX,
            camera.max_angle,
        )
    T_base_grid = draw_poses(rng, GRIDS)
    pixels = draw_pixels(camera, T_base_grid, rng, RAYS)
    return camera, inverse_pose(T_BASE_CAMERA) @ T_base_grid, pixels, SIDE


def _on_monitors(rig, poses, rng):
    """Return pixels (RAYS, 2), uniform over the image, that see every monitor."""
    size = rig.camera.width, rig.camera.height
    pixels = rng.uniform(-0.5, np.array(size) - 0.5, (60 * RAYS, 2))
    points, seen = met(rig.camera, pixels, poses)
    corner, extent = rig.extent
    inside = (points >= corner) & (points <= corner + extent)
    kept = pixels[(seen & inside.all(axis=2)).all(axis=0)]
    if len(kept) < RAYS:
        raise RuntimeError(f"{len(kept)} pixels see the monitor in all poses")
    return kept[:RAYS]


def met(camera, pixels, poses):
    """Return points (n, N, 2) of grids at pixels (N, 2), and their validity (n, N)."""
    rays = camera.rays(pixels)
    hits = [intersect_rays_plane(rays.origins, rays.directions, T) for T in poses]
    points = np.stack([hit.points for hit in hits])
    return points, np.stack([rays.valid & hit.valid for hit in hits])


def miss(rays, T_base, centre, origins, directions):
    """Return the RMS distance (mm) of estimated from true lines, near the camera.

    It is measured at the point of each true ray that is nearest to the true centre.
    """
    along = np.sum((centre - rays.origins) * rays.directions, axis=1)
    nearest = rays.origins + along[:, None] * rays.directions
    reach = transform(T_base, nearest) - origins
    off = np.cross(reach, directions)
    return float(np.sqrt(np.nanmean(np.sum(off**2, axis=1))))


def one_camera(name, noise_mm, rng):
    """Return the test on one scene, its truth, and the errors of free lines."""
    camera, poses, pixels, side = draw_geometry(name, rng)
    points, _ = met(camera, pixels, poses)
    points += noise_mm * rng.standard_normal(points.shape)
    start = linear_cgsp(points, side=side)
    begin = (None, start.centre, start.T_base_grid)
    test = centrality_test(points, *begin, sigma=noise_mm)
    central = adjust_consistent(points, *begin, sigma=noise_mm)
    lines = relax_centrality(points, central)
    rays = camera.rays(pixels)
    truth = rays, inverse_pose(poses[0]), closest_point(rays)
    return {
        "true_mm": 0.0 if camera.central else centrality(rays),
        "found_mm": test.distance_mm,
        "least_mm": test.at_least_mm,
        "most_mm": test.at_most_mm,
        "p": test.p_value,
        "central_miss_mm": miss(*truth, central.centre, central.directions),
        "lines_miss_mm": miss(*truth, lines.origins, lines.directions),
    }
