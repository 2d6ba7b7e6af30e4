"""Section 2.5.1: sweeps, both methods on one trial's data, and their scores."""

import numpy as np

from chapters.shared.general import (
    FINITE_MM,
    FOVS_DEG,
    POINTS,
    SIZE_PX,
    about_principal_ray,
    adjusted_rays,
    camera_of,
    central_focal,
    draw_grids,
    draw_noise,
    draw_pixels,
    measure,
    noise_alone,
    observe,
    score,
    targets,
    view,
)
from chapters.shared.methods import LINEAR, METHODS, SCALES, SCORINGS, STARTS
from raxel.calibration import BoardView, calibrate_opencv_fisheye, calibrate_zhang
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import angular_residual
from repro.run import Plan, experiment

LEVELS = (0.02, 0.1, 0.25, 0.5, 1.0, 2.0)
NOISE_FOV_DEG = 60
FOV_NOISE = 0.5
LAWS_FOV_DEG = 90

DOMAINS = ("px", "mm")
EXTENTS = ("unbounded", "finite")

LAWS = ("equidistance", "equisolid", "stereographic", "perspective")
# Its radius is the largest at every angle below that of the corner, so rays
# drawn in its image are inside the other images too.
OUTERMOST_LAW = "equisolid"


def pixels_moved(data):
    """Return whether noise is on the pixels; points of a target are then exact."""
    return not np.array_equal(data.noisy_pixels[0], data.pixels)


def views_of(data):
    """Return BoardViews of the three grids, for methods that calibrate from pixels."""
    points = data.points if pixels_moved(data) else data.noisy_points
    return [
        BoardView(pixels, on_grid, len(pixels), 1)
        for pixels, on_grid in zip(data.noisy_pixels, points, strict=True)
    ]


def calibrate_parametric(data):
    """Calibrate the trial with Zhang's method; return a PerspectiveCamera."""
    return calibrate_zhang(views_of(data), SIZE_PX, SIZE_PX).camera


def calibrate_fisheye(data):
    """Calibrate OpenCV's fisheye model; return a KannalaBrandtCamera."""
    return calibrate_opencv_fisheye(views_of(data), SIZE_PX, SIZE_PX).camera


# Parametric methods: their camera accepts any pixel.
FEW_NUMBERS = {"parametric": calibrate_parametric, "opencv_fisheye": calibrate_fisheye}


def calibrate_generic(data, linear):
    """Run steps 3 and 4 of Algorithm 1; return rays (N, 3) in the base grid's frame."""
    start = STARTS[linear](data.noisy_points)
    return adjusted_rays(data, start.centre, start.T_base_grid)


def summaries(residuals):
    """Return mean, SD and median of residual lengths over a trial's points."""
    finite = residuals[np.isfinite(residuals)]
    return {
        "mean_px": finite.mean(),
        "sd_px": finite.std(ddof=1),
        "median_px": np.median(finite),
    }


def score_parametric(data, focal, camera):
    """Score a parametric camera on fresh, noisy and clean data."""
    known = targets(data, focal)
    if pixels_moved(data):
        known = dict.fromkeys(SCORINGS, known["clean"])
    pixels = {
        "fresh": data.fresh_pixels,
        "noisy": data.noisy_pixels[0],
        "clean": data.pixels,
    }
    out = {"ray_deg": _error_of(camera, data)}
    for scoring in SCORINGS:
        rays = camera.rays(pixels[scoring])
        ahead = rays.valid & (rays.directions[:, 2] > 0)
        lengths = score(
            view(rays.directions[ahead], focal), known[scoring][ahead],
            data.camera, focal,
        )  # fmt: skip
        out[scoring] = {s: summaries(lengths[s]) for s in SCALES}
        out[scoring]["left_out_share"] = 1 - ahead.mean()
    return out


def score_generic(data, focal, linear):
    """Score generic rays on fresh, noisy and clean data."""
    directions = calibrate_generic(data, linear)
    corrected = view(about_principal_ray(directions, data.pixels), focal)
    known = targets(data, focal)
    out = {"ray_deg": _ray_error(directions, data.directions)}
    for scoring in SCORINGS:
        lengths = score(corrected, known[scoring], data.camera, focal)
        out[scoring] = ranked(lengths, data)
    return out


def _error_of(camera, data):
    """Return the ray error of a camera over the clean pixels that have a ray."""
    found = camera.rays(data.pixels)
    return _ray_error(found.directions[found.valid], data.directions[found.valid])


def _ray_error(found, true):
    """Return the median angle (deg) between ray bundles after the best rotation."""
    return np.degrees(np.median(angular_residual(found, true)))


def _rank_correlation(values, ranks):
    return np.corrcoef(np.argsort(np.argsort(values)), ranks)[0, 1]


def point_noise_ratio(data):
    """Return the ratio of noise SDs on the grids, outer over inner 20 % of angle."""
    directions = data.directions
    angle = np.arccos(np.clip(directions[:, 2], -1, 1))
    error = data.noisy_points - data.points
    outer = error[:, angle > 0.8 * angle.max()].std(ddof=1)
    inner = error[:, angle < 0.2 * angle.max()].std(ddof=1)
    return outer / inner


def widest_angle_deg(data):
    """Return the largest angle from the axis at which all grids were measured."""
    axial = data.directions[:, 2]
    return np.degrees(np.arccos(axial.min()))


def score_exact(data, focal):
    """Summarise the noise of the scored points alone, in both scales."""
    return ranked(noise_alone(data, focal), data)


def ranked(lengths, data):
    """Summarise by scale, with the rank correlation with grazing incidence."""
    return {
        scale: summaries(found)
        | {"grazing_spearman": _rank_correlation(found, data.grazing_ranks)}
        for scale, found in lengths.items()
    }


def scores(data, methods):
    """Score every method; a failed one returns its error code."""
    focal = central_focal(data.camera)
    out = {"exact": score_exact(data, focal)}
    for method in methods:
        try:
            out[method] = _scored(method, data, focal)
        except (CalibrationError, InputError) as error:
            out[method] = {"failed": error.code}
    return out


def _scored(method, data, focal):
    if method in FEW_NUMBERS:
        return score_parametric(data, focal, FEW_NUMBERS[method](data))
    return score_generic(data, focal, LINEAR[method])


def measure_laws(condition, rng):
    """Return data by law: the same grids, rays and noise for each camera."""
    fov_deg, domain = condition["fov_deg"], condition["domain"]
    drawn = camera_of(OUTERMOST_LAW, fov_deg)
    grids, _ = draw_grids(rng)
    pixels, _ = draw_pixels(drawn, grids, condition["extent"], rng)
    rays = drawn.rays(pixels).directions
    noise = draw_noise(condition["noise"], rng)
    data = {}
    for law in LAWS:
        camera = camera_of(law, fov_deg)
        data[law] = observe(camera, grids, camera.project(rays).pixels, noise, domain)
    return data


# The sweeps

TRIALS = {"quick": 3, "full": 50}
FISHEYE_TRIALS = {"quick": 1, "full": 12}

SETTINGS = {
    "image_px": [SIZE_PX, SIZE_PX],
    "points_per_trial": POINTS,
    "noise_sweep": {
        "law": "pinhole with k1 = -0.2, k2 = 0.05",
        "fov_deg": NOISE_FOV_DEG,
        "levels": list(LEVELS),
    },
    "fov_sweep": {"law": "equidistance", "fov_deg": list(FOVS_DEG), "noise": FOV_NOISE},
    "law_sweep": {"laws": list(LAWS), "fov_deg": LAWS_FOV_DEG, "noise": FOV_NOISE},
    "fov": "on the image diagonal",
    "fresh_noise": "the base grid measured once more, only to be scored on",
    "finite_grids_mm": [-FINITE_MM, FINITE_MM],
    "grids": "600 mm away, shifted by up to 150 mm on every axis, tilted "
    "by 10 to 30 deg about a random axis, at least 10 deg apart",
}


def conditions(law, fovs_deg, levels):
    """Return all conditions of a sweep."""
    return [
        {
            "law": law,
            "fov_deg": fov_deg,
            "noise": level,
            "domain": domain,
            "extent": extent,
        }
        for domain in DOMAINS
        for extent in EXTENTS
        for fov_deg in fovs_deg
        for level in levels
    ]


def fisheye_trial(condition, rng):
    """Score OpenCV's fisheye model on the data of `trial`."""
    data, _ = measure(condition, rng)
    return scores(data, ("opencv_fisheye",))


@experiment("fig_2_3_fisheye", artefact="fig_2_3")
def fisheye_sweep(effort):
    """The first trials of `fov_sweep` in the primary interpretation."""
    cases = [
        case
        for case in conditions("equidistance", FOVS_DEG, [FOV_NOISE])
        if (case["domain"], case["extent"]) == (DOMAINS[0], EXTENTS[0])
    ]
    return Plan(fisheye_trial, cases, FISHEYE_TRIALS[effort], SETTINGS)


def laws_trial(condition, rng):
    """Run one trial: the generic method's scores under every law."""
    measured = measure_laws(condition, rng)
    return {law: scores(measured[law], METHODS[1:]) for law in LAWS}


@experiment("fig_2_3_laws", artefact="fig_2_3")
def law_sweep(effort):
    """Four laws at 90 degrees: same image radius, rays and noise."""
    cases = conditions("all four", [LAWS_FOV_DEG], [FOV_NOISE])
    return Plan(laws_trial, cases, TRIALS[effort], SETTINGS)
