"""Section 2.5.1: its sweeps, both methods on one trial's data, and their scores."""

from __future__ import annotations

import numpy as np

from chapters.shared.methods import LINEAR, SCALES, SCORINGS
from chapters.shared.three_planes import (
    POINTS,
    SIZE_PX,
    about_principal_ray,
    camera_of,
    central_focal,
    draw_grids,
    draw_pixels,
    observe,
    score,
    targets,
    view,
)
from raxel.calibration.bundle import bundle_adjust_fixed_centre
from raxel.calibration.correspondence import BoardView
from raxel.calibration.generic_linear import (
    linear_as_printed,
    linear_well_conditioned,
)
from raxel.calibration.zhang import calibrate_zhang
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.distortion import angular_residual
from raxel.geometry import inverse_pose, rotate

LEVELS = (0.02, 0.1, 0.25, 0.5, 1.0, 2.0)
NOISE_FOV_DEG = 60
FOV_NOISE = 0.5
LAWS_FOV_DEG = 90

DOMAINS = ("px", "mm")
EXTENTS = ("unbounded", "finite")

LAWS = ("equidistance", "equisolid", "stereographic", "perspective")
# Its radius is the largest at every angle short of the corner, so rays
# drawn in its image lie inside the other images too.
OUTERMOST_LAW = "equisolid"


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
    return score_generic(data, focal, LINEAR[method])


def measure_laws(condition, rng):
    """Data by law: the same grids, rays and noise, seen by each camera."""
    fov_deg, domain = condition["fov_deg"], condition["domain"]
    drawn = camera_of(OUTERMOST_LAW, fov_deg)
    grids, _ = draw_grids(rng)
    pixels, _ = draw_pixels(drawn, grids, condition["extent"], rng)
    rays = drawn.rays(pixels).directions
    noise = condition["noise"] * rng.standard_normal((3, POINTS, 2))
    data = {}
    for law in LAWS:
        camera = camera_of(law, fov_deg)
        seen = camera.project(rays).pixels
        data[law] = observe(camera, grids, seen, noise, domain)
    return data
