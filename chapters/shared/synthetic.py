"""The synthetic experiment of section 2.5.1: measure, calibrate, score.

A camera looks at three tilted planes. 999 random pixels are back-projected
on each plane, with noise that is independent from plane to plane. The
parametric and the generic method calibrate from the same data, and both are
scored the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raxel.calibration.bundle import bundle_adjust_fixed_centre
from raxel.calibration.correspondence import BoardView
from raxel.calibration.generic_linear import (
    linear_as_printed,
    linear_well_conditioned,
)
from raxel.calibration.zhang import calibrate_zhang
from raxel.cameras import FisheyeCamera, PerspectiveCamera
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.distortion import (
    angular_residual,
    distortion_residual,
)
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    pose,
    rotate,
    rotation_from_vector,
)

SIZE_PX = 640
POINTS = 999
PRINCIPAL = np.full(2, (SIZE_PX - 1) / 2)
CORNER_RADIUS_PX = np.hypot(*PRINCIPAL)
DISTANCE_MM = 600.0
SHIFT_MM = 150.0
TILT_DEG = (10.0, 30.0)
LEAST_ANGLE_DEG = 10.0
FINITE_MM = 600.0
LENS_K1, LENS_K2 = -0.2, 0.05
METHODS = ("parametric", "generic_as_printed", "generic_well_conditioned")
SCORINGS = ("noisy", "clean")
SCALES = ("corrected", "source")


def fisheye(projection, fov_deg):
    """A fisheye of the field of view ``fov_deg`` on the image diagonal."""
    half = np.radians(fov_deg) / 2
    radius_at_unit_focal = {
        "equidistance": half,
        "equisolid": 2 * np.sin(half / 2),
        "stereographic": 2 * np.tan(half / 2),
    }[projection]
    focal = CORNER_RADIUS_PX / radius_at_unit_focal
    return FisheyeCamera(
        projection, focal, PRINCIPAL, SIZE_PX, SIZE_PX, 1.1 * half
    )


def perspective(fov_deg, radial=()):
    """A pinhole of that diagonal field of view, with radial distortion."""
    focal = CORNER_RADIUS_PX / np.tan(np.radians(fov_deg) / 2)
    K = np.array(
        [[focal, 0, PRINCIPAL[0]], [0, focal, PRINCIPAL[1]], [0, 0, 1.0]]
    )
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
        if angles.min() >= LEAST_ANGLE_DEG:
            return grids, angles.min()


def _draw_grid(rng):
    """A grid facing the camera (z away from it), tilted, shifted."""
    axis = rng.uniform(0, 2 * np.pi)
    tilt = np.radians(rng.uniform(*TILT_DEG))
    R = rotation_from_vector(
        tilt * np.array([np.cos(axis), np.sin(axis), 0.0])
    )
    spin = rotation_from_vector(
        np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])
    )
    shift = rng.uniform(-SHIFT_MM, SHIFT_MM, 3)
    return pose(R @ spin, shift + [0.0, 0.0, DISTANCE_MM])


def back_project(camera, pixels, T_camera_grid):
    """Points (N, 2) of a grid that pixels see, and whether they do."""
    rays = camera.rays(pixels)
    hit = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
    return hit.points, rays.valid & hit.valid


def draw_pixels(camera, grids, extent, rng):
    """999 random pixels that see all grids, and the share that do."""
    kept, tried = np.empty((0, 2)), 0
    while len(kept) < POINTS:
        pixels = rng.uniform(-0.5, SIZE_PX - 0.5, (4 * POINTS, 2))
        seen = np.ones(len(pixels), bool)
        for T_camera_grid in grids:
            points, hit = back_project(camera, pixels, T_camera_grid)
            seen &= hit
            if extent == "finite":
                seen &= hit & (
                    np.abs(np.where(hit[:, None], points, 0)) <= FINITE_MM
                ).all(1)
        kept = np.concatenate([kept, pixels[seen]])
        tried += len(pixels)
        if tried > 4000 * POINTS:
            raise RuntimeError("the grids are all but out of view")
    return kept[:POINTS], len(kept) / tried


@dataclass(frozen=True)
class Data:
    """One trial's measurements, with the truth that only scoring may use.

    pixels (N, 2), points (3, N, 2): clean. noisy_pixels (3, N, 2): what the
    parametric method gets; noisy_points (3, N, 2): the generic method.
    """

    camera: object
    grids: np.ndarray
    pixels: np.ndarray
    noisy_pixels: np.ndarray
    points: np.ndarray
    noisy_points: np.ndarray


def measure(condition, rng):
    """Draw a trial: camera, grids, pixels, noise anew for every grid."""
    camera = camera_of(condition["law"], condition["fov_deg"])
    grids, least_angle = draw_grids(rng)
    pixels, share = draw_pixels(camera, grids, condition["extent"], rng)
    noise = condition["noise"] * rng.standard_normal((3, POINTS, 2))
    data = observe(camera, grids, pixels, noise, condition["domain"])
    return data, {"accepted_share": share, "least_angle_deg": least_angle}


def observe(camera, grids, pixels, noise, domain):
    """Data of pixels that see all grids; noise (3, N, 2) in px or mm."""
    points = np.stack([back_project(camera, pixels, T)[0] for T in grids])
    keep = np.ones(len(pixels), bool)
    noisy_pixels, noisy_points = np.repeat(pixels[None], 3, 0), points
    if domain == "px":
        noisy_pixels = pixels + noise
        seen = [
            back_project(camera, p, T)
            for p, T in zip(noisy_pixels, grids, strict=True)
        ]
        noisy_points = np.stack([s[0] for s in seen])
        keep = np.all([s[1] for s in seen], axis=0)
    else:
        noisy_points = points + noise
    return Data(
        camera, grids, pixels[keep], noisy_pixels[:, keep], points[:, keep],
        noisy_points[:, keep],
    )  # fmt: skip


def calibrate_parametric(data):
    """Zhang's method on the trial; returns a PerspectiveCamera.

    Noise in mm disturbs the points it is given, noise in px the pixels:
    the points of a target are known.
    """
    moved = not np.array_equal(data.noisy_pixels[0], data.pixels)
    points = data.points if moved else data.noisy_points
    views = [
        BoardView(pixels, on_grid, len(pixels), 1)
        for pixels, on_grid in zip(data.noisy_pixels, points, strict=True)
    ]
    return calibrate_zhang(views, SIZE_PX, SIZE_PX).camera


def calibrate_generic(data, linear):
    """Algorithm 1, steps 3 and 4: rays (N, 3) in the base grid's frame.

    As printed, t_z divides by C_y (2.23).
    """
    if linear == "as printed":
        start = linear_as_printed(*data.noisy_points)
    else:
        start = linear_well_conditioned(data.noisy_points)
    seen = np.ones(data.noisy_points.shape[:2], bool)
    return bundle_adjust_fixed_centre(
        data.noisy_points, seen, start.centre, start.T_base_grid
    ).directions


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
    on_sensor = [
        camera.project(np.column_stack([p / focal, np.ones(len(p))])).pixels
        for p in (target, target - residual)
    ]
    return {
        "corrected": np.linalg.norm(residual, axis=1),
        "source": np.linalg.norm(on_sensor[0] - on_sensor[1], axis=1),
    }


def targets(data, focal):
    """Known positions in the true corrected view: measured, clean."""
    T = data.grids[0]
    clean = view(data.camera.rays(data.pixels).directions, focal)
    flat = np.column_stack(
        [data.noisy_points[0], np.zeros(len(data.pixels))]
    )
    on_base = flat @ T[:3, :3].T + T[:3, 3]
    return {"noisy": view(on_base, focal), "clean": clean}


def summaries(residuals):
    """Mean, SD and median of residual lengths over a trial's points."""
    finite = residuals[np.isfinite(residuals)]
    return {
        "mean_px": finite.mean(),
        "sd_px": finite.std(ddof=1),
        "median_px": np.median(finite),
    }


def score_parametric(data, focal):
    """Score Zhang's camera on noisy and on clean data."""
    camera = calibrate_parametric(data)
    known = targets(data, focal)
    pixels_moved = not np.array_equal(data.noisy_pixels[0], data.pixels)
    pairs = {
        "noisy": (
            data.noisy_pixels[0],
            known["clean" if pixels_moved else "noisy"],
        ),
        "clean": (data.pixels, known["clean"]),
    }
    out = {}
    for scoring, (pixels, target) in pairs.items():
        rays = camera.rays(pixels)
        lengths = score(
            view(rays.directions[rays.valid], focal), target[rays.valid],
            data.camera, focal,
        )  # fmt: skip
        out[scoring] = {s: summaries(lengths[s]) for s in SCALES}
        out[scoring]["left_out_share"] = 1 - rays.valid.mean()
    true = data.camera.rays(data.pixels).directions
    found = camera.rays(data.pixels)
    out["ray_deg"] = _ray_error(
        found.directions[found.valid], true[found.valid]
    )
    return out


def score_generic(data, focal, linear):
    """Score generic rays on noisy and on clean data."""
    directions = calibrate_generic(data, linear)
    corrected = view(about_principal_ray(directions, data.pixels), focal)
    known = targets(data, focal)
    out = {
        "ray_deg": _ray_error(
            directions, data.camera.rays(data.pixels).directions
        )
    }
    for scoring in SCORINGS:
        lengths = score(corrected, known[scoring], data.camera, focal)
        out[scoring] = {s: summaries(lengths[s]) for s in SCALES}
        for scale in SCALES:
            out[scoring][scale]["grazing_spearman"] = _rank_correlation(
                lengths[scale], 1 / _least_sine(data)
            )
    return out


def _ray_error(found, true):
    """Median angle (deg) between ray bundles after the best rotation."""
    return np.degrees(np.median(angular_residual(found, true)))


def _least_sine(data):
    """Sine of the smallest angle between each ray and the three planes."""
    directions = data.camera.rays(data.pixels).directions
    on_normals = [
        rotate(inverse_pose(T), directions)[:, 2] for T in data.grids
    ]
    return np.min(np.abs(on_normals), axis=0)


def _rank_correlation(a, b):
    ranks = [np.argsort(np.argsort(values)) for values in (a, b)]
    return np.corrcoef(*ranks)[0, 1]


def point_noise_ratio(data):
    """SD of noise on the grids: outer over inner 20 % of field angle."""
    directions = data.camera.rays(data.pixels).directions
    angle = np.arccos(np.clip(directions[:, 2], -1, 1))
    error = data.noisy_points - data.points
    outer = error[:, angle > 0.8 * angle.max()].std(ddof=1)
    inner = error[:, angle < 0.2 * angle.max()].std(ddof=1)
    return outer / inner


def widest_angle_deg(data):
    """Largest angle from the axis at which all grids were measured."""
    axial = data.camera.rays(data.pixels).directions[:, 2]
    return np.degrees(np.arccos(axial.min()))


def trial(condition, rng):
    """One trial: measure, calibrate with each method, score each way."""
    data, drawn = measure(condition, rng)
    out = drawn | {
        "points": len(data.pixels),
        "widest_angle_deg": widest_angle_deg(data),
    }
    if condition["noise"] > 0:
        out["point_noise_ratio"] = point_noise_ratio(data)
    return out | scores(data, METHODS)


def scores(data, methods):
    """Score every method; one that fails says why and the others go on."""
    focal = central_focal(data.camera)
    out = {}
    for method in methods:
        try:
            out[method] = _scored(method, data, focal)
        except (CalibrationError, InputError) as error:
            out[method] = {"failed": str(error)}
    return out


def _scored(method, data, focal):
    if method == "parametric":
        return score_parametric(data, focal)
    linear = (
        "as printed"
        if method == "generic_as_printed"
        else "well conditioned"
    )
    return score_generic(data, focal, linear)
