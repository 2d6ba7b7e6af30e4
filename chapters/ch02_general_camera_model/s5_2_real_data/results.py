"""The numbers of Table 2.2 and the settings of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.scores import QUINTILES
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


def image_share(case, method, zoom):
    """Median over seeds of the picture's share with a ray (%), or None."""
    shares = case.column(f"{method}.share_of_image", zoom)
    known = shares[np.isfinite(shares)]
    return 100 * float(np.median(known)) if len(known) else None


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    cases = {name: ZoomCase(results, options) for name, options in CASES.items()}
    made = cases["as_found"]
    exact = open_results("ext_table_2_2_exact").column(
        "generic_as_printed.calibration.corrected.rms_px", zoom=STAGE_ZOOM
    )
    # The true centre in a simulation, and OpenCV's fisheye model on set 3.
    centre = open_results("fig_2_5_true_centre").column(
        f"as printed.{SCORINGS[0]}.corrected.ratio"
    )
    fisheye = cases["smooth"].column(
        "opencv_fisheye.calibration.corrected.rms_px", STAGE_ZOOM
    )
    found = {
        "exact_generic": typical(exact),
        "rendered_seeds": open_results("table_2_2_rendered").trials_per_condition,
        **{f"ratio_{name}": ratio_of_sets(case) for name, case in cases.items()},
        "parametric_most_1": typical(cases["most"].residual("parametric", 1)),
        **{
            f"{name}_{zoom}": typical(made.residual(name, zoom))
            for zoom in (1, 3)
            for name in ("parametric", "generic")
        },
        "image_share_3": image_share(made, "generic_as_printed", STAGE_ZOOM),
        **of_radial(made),
        "largest_fifth": largest_fifth(made),
        **{
            f"{name}_{method}": typical(
                made.of(method, f"stage.grid.{what}", STAGE_ZOOM)
            )
            for method in ("parametric", "generic")
            for name, what in (("step", "step_mm"), ("scatter", "deviation_mm"))
        },
        "fisheye_seeds": len(fisheye),
        "fisheye_off": np.sum(~(fisheye < FAR_OFF_PX)),
        "far_off": FAR_OFF_PX,
        "centre_printed": typical(centre),
        "centre_failed": np.isnan(centre).sum(),
        **{
            f"moran{name}": related_percent(case)
            for name, case in (("", made), ("_smooth", cases["smooth"]))
        },
    }
    for name, number in found.items():
        value(name, number)


def ratio_of_sets(case):
    """Largest over smallest generic residual of the three sets."""
    medians = [typical(trials) for trials in case.residuals("generic")]
    return max(medians) / min(medians)


def related_percent(case):
    """In how many of a hundred seeds generic residuals of neighbours correlate."""
    p = case.of("generic", "moran.corrected.p", STAGE_ZOOM)
    return round(100 * float(np.mean(p < MORAN_P)))


def of_radial(made):
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
    return {
        "seeds": means.shape[1],
        "turned": np.sum(np.min(means[:2] * means[-1], axis=0) < 0),
        "outer_sure": np.sum(p[-1] < BIAS_P),
    }


def largest_fifth(made):
    """Largest generic mean of a fifth of the radius over the RMS, median of seeds."""
    place = "calibration.radial.corrected"
    means = np.stack(
        [
            made.of("generic", f"{place}.q{n}.mean_px", STAGE_ZOOM)
            for n in range(1, QUINTILES + 1)
        ]
    )
    rms = made.of("generic", f"{place}.rms_px", STAGE_ZOOM)
    return np.nanmedian(np.max(np.abs(means), axis=0) / rms)


def distortion_level(angle_deg: float) -> float:
    """|r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def log_slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Slopes (...) of least-squares lines through log y (..., n) over x (n,)."""
    centred = x - x.mean()
    return np.sum(np.log(y) * centred, axis=-1) / np.sum(centred**2)


def swept_slopes(case):
    """Slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(levels, [one("mean_px", fov_deg=f) for f in FOVS_DEG], log_slope)
        for one in (case.parametric, case.generic)
    ]


def zoom_slope(levels, *trials):
    """Slope of log median residual on distortion level."""
    return log_slope(levels, np.stack([np.median(t, axis=-1) for t in trials], axis=-1))


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
