"""The numbers of Table 2.2 and the settings of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    true_shape,
)
from chapters.shared.methods import METHODS
from chapters.shared.three_planes import FOVS_DEG
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.judge.statistics import (
    bootstrap,
    trend,
    with_worst,
)
from repro.page.reader import value

FIELD_SCALE = 50
STEP_SCALE = 20


def typical(trials):
    """Median over trials; a failed one counts as the worst."""
    return float(np.median(with_worst(trials)))


def share_left_out(result, zoom):
    """Share of the corners found that have no generic ray, over all seeds."""
    place = "generic_as_printed.calibration"
    left_out, boards = (
        np.nansum(result.column(f"{place}.{name}", zoom=zoom))
        for name in ("left_out", "boards")
    )
    return left_out / (boards * true_shape(zoom)[0])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    made = open_results("table_2_2_redrawn")
    rendered = open_results("table_2_2_rendered")
    centre = open_results("fig_2_5_true_centre")
    exact = open_results("ext_table_2_2_exact").column(
        "generic_as_printed.calibration.corrected.rms_px", zoom=STAGE_ZOOM
    )
    value("exact_generic", typical(exact))
    trials = rendered.trials_per_condition
    value("asked", trials * rendered.settings["calibration_images"])
    shown = value("seeds", made.trials_per_condition)
    value("rendered_seeds", rendered.trials_per_condition)
    for zoom in ZOOMS:
        for name, of in (("redrawn", made), ("rendered", rendered)):
            error = of.column("corner_error_px", zoom=zoom)
            value(f"corner_{name}_{zoom}", typical(error))
        level = rendered.column("distortion_level", zoom=zoom)
        value(f"level_{zoom}", typical(level))
        value(f"left_out_{zoom}", 100 * share_left_out(made, zoom))
        found = rendered.column("found.calibration", zoom=zoom)
        value(f"found_{zoom}", int(found.sum()))
        for method in METHODS:
            place = f"{method}.calibration.corrected.rms_px"
            value(
                f"{method}_{zoom}", typical(made.column(place, zoom=zoom))
            )
    for method in METHODS:
        steps = made.column(f"{method}.stage.grid.step_mm", zoom=STAGE_ZOOM)
        value(f"step_{method}", typical(steps))
    for linear, short in (
        ("as printed", "printed"),
        ("well conditioned", "well"),
    ):
        ratio = centre.column(f"{linear}.corrected.ratio")
        value(f"centre_{short}", typical(ratio))
        value(f"centre_failed_{short}", int(np.isnan(ratio).sum()))
    return shown


def distortion_level(angle_deg: float) -> float:
    """|r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def _log_slope(x: np.ndarray, medians: np.ndarray) -> float:
    return float(np.polyfit(x, np.log(medians), 1)[0])


def swept_slopes(case):
    """Slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(
            levels,
            [one("mean_px", fov_deg=f) for f in FOVS_DEG],
            _log_slope,
        )
        for one in (case.parametric, case.generic)
    ]


def zoom_slope(levels, *trials):
    """Slope of log median residual on distortion level."""
    logs = np.log(np.stack([np.median(t, axis=-1) for t in trials], -1))
    centred = levels - levels.mean()
    return np.sum(logs * centred, axis=-1) / np.sum(centred**2)


def rendered_slopes(case):
    """Slopes of both methods over the three sets, with intervals."""
    levels = np.array(
        [
            np.median(case.result.column("distortion_level", zoom=zoom))
            for zoom in ZOOMS
        ]
    )
    return [
        bootstrap(
            lambda *t: zoom_slope(levels, *t),
            *(with_worst(t) for t in case.residuals(name)),
        )
        for name in ("parametric", "generic")
    ]
