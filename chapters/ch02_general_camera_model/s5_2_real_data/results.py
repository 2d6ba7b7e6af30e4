"""The numbers of Table 2.2 and the settings of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.scores import QUINTILES
from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import true_shape
from chapters.shared.methods import SCORINGS
from chapters.shared.three_planes import FOVS_DEG
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.judge.statistics import bootstrap, trend, with_worst
from repro.page.reader import value

FIELD_SCALE, COARSE_SCALE = 50, 10
STEP_SCALE = 20
BIAS_P = MORAN_P = 0.01
FAR_OFF_PX = 1.0
# Readings whose numbers the prose quotes.
CASES = {
    "as_found": {},
    "smooth": {"interpolation": "smooth"},
    "least": {"corner_noise": "0.06 px"},
    "most": {"corner_noise": "0.45 px"},
}


def typical(trials):
    """Median over trials; a failed one counts as the worst."""
    return float(np.median(with_worst(trials)))


def covered(case, method, zoom):
    """Calibration corners found over all seeds, and those without a ray."""
    place = f"{method}.calibration"
    boards, left_out = (
        int(np.nansum(case.column(f"{place}.{name}", zoom)))
        for name in ("boards", "left_out")
    )
    return boards * true_shape(zoom)[0], left_out


def image_share(case, method, zoom):
    """Median over seeds of the picture's share with a ray (%), or None."""
    shares = case.column(f"{method}.share_of_image", zoom)
    known = shares[np.isfinite(shares)]
    return 100 * float(np.median(known)) if len(known) else None


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    made = ZoomCase(results)
    exact = open_results("ext_table_2_2_exact").column(
        "generic_as_printed.calibration.corrected.rms_px", zoom=STAGE_ZOOM
    )
    value("exact_generic", typical(exact))
    value("rendered_seeds", open_results("table_2_2_rendered").trials_per_condition)
    for name, options in CASES.items():
        residuals = ZoomCase(results, options).residuals("generic")
        medians = [typical(trials) for trials in residuals]
        value(f"ratio_{name}", max(medians) / min(medians))
    noisy = ZoomCase(results, CASES["most"])
    value("parametric_most_1", typical(noisy.residual("parametric", 1)))
    for zoom in (1, 3):
        value(f"parametric_{zoom}", typical(made.residual("parametric", zoom)))
        value(f"generic_{zoom}", typical(made.residual("generic", zoom)))
    value("image_share_3", image_share(made, "generic_as_printed", STAGE_ZOOM))
    name_radial(made)
    name_steps(made)
    name_fisheye(ZoomCase(results, CASES["smooth"]))
    name_centre(open_results("fig_2_5_true_centre"))
    for name, case in (("", made), ("_smooth", ZoomCase(results, CASES["smooth"]))):
        p = case.of("generic", "moran.corrected.p", STAGE_ZOOM)
        value(f"moran{name}", round(100 * float(np.mean(p < MORAN_P))))


def name_radial(made):
    """In how many seeds the parametric residual turns round, and surely so."""
    place = "parametric.calibration.radial.corrected"
    means, p = (
        np.stack(
            [
                made.column(f"{place}.q{n}.{name}", STAGE_ZOOM)
                for n in range(1, QUINTILES + 1)
            ]
        )
        for name in ("mean_px", "p")
    )
    value("seeds", means.shape[1])
    value("turned", int(np.sum(np.min(means[:2] * means[-1], axis=0) < 0)))
    value("outer_sure", int(np.sum(p[-1] < BIAS_P)))


def name_steps(made):
    """The mean step of the stage, and how much the steps scatter."""
    for name in ("parametric", "generic"):
        value(f"step_{name}", typical(made.of(name, "stage.grid.step_mm", STAGE_ZOOM)))
        scatter = made.of(name, "stage.grid.deviation_mm", STAGE_ZOOM)
        value(f"scatter_{name}", typical(scatter))


def name_fisheye(made):
    """In how many seeds of set 3 OpenCV's fisheye model misses by much."""
    trials = made.column("opencv_fisheye.calibration.corrected.rms_px", STAGE_ZOOM)
    value("fisheye_seeds", len(trials))
    value("fisheye_off", int(np.sum(~(trials < FAR_OFF_PX))))
    value("far_off", FAR_OFF_PX)


def name_centre(centre):
    """What the true centre does to the residual of a simulation."""
    scoring = SCORINGS[0]
    ratio = centre.column(f"as printed.{scoring}.corrected.ratio")
    value("centre_printed", typical(ratio))
    value("centre_failed", int(np.isnan(ratio).sum()))


def distortion_level(angle_deg: float) -> float:
    """|r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Slopes (...) of least-squares lines through y (..., n) over x (n,)."""
    centred = x - x.mean()
    return np.sum(y * centred, axis=-1) / np.sum(centred**2)


def _log_slope(x: np.ndarray, medians: np.ndarray) -> float:
    return float(slope(x, np.log(medians)))


def swept_slopes(case):
    """Slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(levels, [one("mean_px", fov_deg=f) for f in FOVS_DEG], _log_slope)
        for one in (case.parametric, case.generic)
    ]


def zoom_slope(levels, *trials):
    """Slope of log median residual on distortion level."""
    medians = np.stack([np.median(t, axis=-1) for t in trials], axis=-1)
    return slope(levels, np.log(medians))


def rendered_slopes(case):
    """Slopes of both methods over the three sets, with intervals."""
    levels = np.array(
        [np.median(case.column("distortion_level", zoom)) for zoom in ZOOMS]
    )
    return [
        bootstrap(
            lambda *t: zoom_slope(levels, *t),
            *(with_worst(t) for t in case.residuals(name)),
        )
        for name in ("parametric", "generic")
    ]
