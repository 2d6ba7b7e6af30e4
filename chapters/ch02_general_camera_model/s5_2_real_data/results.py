"""The numbers of Table 2.2 and the settings of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    STAGE_IMAGES,
    STEP_MM,
    true_shape,
)
from chapters.shared.methods import METHODS
from chapters.shared.three_planes import FOVS_DEG
from chapters.shared.zoom_readings import ZoomCase
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.judge.statistics import (
    bootstrap,
    median_interval,
    trend,
    with_worst,
)
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

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


@numbers("table_2_2", needs=("table_2_2_redrawn",), evidence="rendered")
def values_of_table_2_2(results):
    """Medians over seeds in the primary reading."""
    case = ZoomCase(results["table_2_2_redrawn"])
    out = {}
    for name, short in (("parametric", "persp"), ("generic", "gen")):
        for statistic in ("rms", "sd"):
            for zoom in ZOOMS:
                trials = case.residual(name, zoom, f"{statistic}_px")
                found = median_interval(trials)
                mean = typical(case.residual(name, zoom, "mean_px"))
                out[f"t2_2_{short}_{statistic}_set{zoom}"] = Value(
                    found.value,
                    (found.low, found.high),
                    "px",
                    f"median over {len(trials)} seeds, {found.failed} failed; "
                    f"median of the mean residual {mean:.2f} px",
                )
    return out


@numbers("fig_2_4", needs=("table_2_2_rendered",), evidence="rendered")
def values_of_fig_2_4(results):
    """The converter's field of view, as the rig has it."""
    ran = results["table_2_2_rendered"]
    return {"s2_5_2_fov": Value(ran.settings["field_of_view_deg"])}


@numbers("fig_2_5", needs=(), evidence="rendered")
def values_of_fig_2_5(results):
    """How much longer the vectors are drawn."""
    return {"fig2_5_scale": Value(FIELD_SCALE)}


@numbers("fig_2_6", needs=(), evidence="rendered")
def values_of_fig_2_6(results):
    """Images, steps, and how much larger deviations are drawn."""
    return {
        "fig2_6_images": Value(STAGE_IMAGES),
        "fig2_6_step": Value(STEP_MM, unit="mm"),
        "fig2_6_scale": Value(STEP_SCALE),
    }


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
