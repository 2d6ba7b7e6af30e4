"""Fig. 5.5 and the bias of the linear stage."""

from chapters.ch05_flexible_mirror.s3_1_simulated.results import (
    PRIMARY,
    RESULT,
    CurveCase,
    curvature,
    linear_by_formula,
    missing_by_formula,
    typical,
)
from chapters.ch05_flexible_mirror.s3_1_simulated.trials.scene import rig_of
from chapters.ch05_flexible_mirror.s3_1_simulated.trials.sweeps import DEFAULT, SWEEPS
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

AXES = {
    "noise": "Image noise SD (px)",
    "depth": "Scene depth (mm)",
    "bend": "Curvature at the clamp (1/m)",
}
DEPTH_TICKS, SHARE_TICKS = (500, 1000, 2000, 4000, 8000), (0.05, 0.1, 0.2, 0.5, 0.8)
FORMULA = {"color": INK, "linestyle": ":", "marker": ""}
HEIGHT = CurveCase({"reduced_curve": "height over the clamped line"})
FINAL = (
    ("final, cubic of the image coordinate", PRIMARY, series(1)),
    ("final, cubic of the length", HEIGHT, series(2)),
)
PITCHES = {
    "half of the MegaPlus": series(0),
    "APS-C sensor": series(1),
    "small sensor": series(2),
    "film frame": series(3),
}
UNITS = {"noise": "px", "depth": "mm", "bend": "1/m"}


@figure("fig_5_5", needs=("fig_5_5_sweeps",), evidence="synthetic")
def fig_5_5(results):
    """Mean errors over noise, depth and curvature of the linear and final stages."""
    result, rows = results[RESULT], []
    drawn, axes = new_figure(3, 2, height_in=7.8, sharex="row")
    for (left, right), (sweep, levels) in zip(axes, SWEEPS.items(), strict=True):
        x = [curvature(tip) if sweep == "bend" else tip for tip in levels]
        formula = [_formula(sweep, level) for level in levels]
        left.plot(x, formula, label="linear, by formula", **FORMULA)
        for axis, stage, curves in (
            (left, "linear", (("linear estimate", PRIMARY, series(0)),)),
            (right, "final", FINAL),
        ):
            for label, case, look in curves:
                found = [
                    typical(case.statistic, case.errors(result, sweep, level, stage))
                    for level in levels
                ]
                whose = (sweep, UNITS[sweep], label)
                rows += plot_estimates(axis, x, found, whose, look=look, label=label)
            axis.set_xlabel(AXES[sweep])
            axis.set_ylim(bottom=0)
            if sweep == "depth":
                _log_depth(axis)
        left.set_ylabel("Surface error (mm)")
        right.set_ylabel("Surface error (mm)")
    axes[0, 0].set_title("linear estimate")
    axes[0, 1].set_title("final estimate")
    _legend_of(drawn, axes[0])
    return Drawing(
        drawn,
        columns(("sweep", "unit", "estimate", "level", "mean_mm", "low", "high"), rows),
        "Mean error of the estimated mirror surface against image noise, scene depth "
        "and curvature, of the linear estimate (left) and of the final one (right; "
        "other scale). The final estimate is shown for both interpretations of the "
        "reduced model's cubic. Means of the trials with 95 % intervals; dotted: "
        "error by the assumption of an infinite scene, 3/8 of the tip's deflection "
        "times D/(Z+D).",
    )


def _log_depth(axes):
    axes.set_xscale("log")
    axes.minorticks_off()
    axes.set_xticks(DEPTH_TICKS, [f"{tick}" for tick in DEPTH_TICKS])


def _formula(sweep, level):
    at = DEFAULT | {sweep: level}
    return linear_by_formula(at["depth"], at["bend"])


def _legend_of(drawn, pair):
    """One legend below, of both panels of a row."""
    handles, labels = [], []
    for axis in pair:
        for all_of_figure, own in zip(
            (handles, labels), axis.get_legend_handles_labels(), strict=True
        ):
            all_of_figure += own
    drawn.legend(handles, labels, loc="outside lower center", ncols=2)


@figure("ext_fig_5_5_bias", needs=("fig_5_5_sweeps",), evidence="synthetic")
def ext_fig_5_5_bias(results):
    """Deflection that the linear stage misses, over depth, with D / (Z + D)."""
    result, rows = results[RESULT], []
    drawn, axes = new_figure(height_in=3.9)
    depths = SWEEPS["depth"]
    for name, look in PITCHES.items():
        case = CurveCase({"pixel_pitch": name})
        found = [typical("mean", case.missing(result, depth)) for depth in depths]
        pitch = case["pixel_pitch"]
        label = f"{name}, camera {rig_of(pitch).distance_mm / 1000:.2f} m away"
        rows += plot_estimates(axes, depths, found, (name,), look=look, label=label)
        dotted = [missing_by_formula(depth, pitch) for depth in depths]
        axes.plot(depths, dotted, **FORMULA)
    axes.plot([], [], label="D/(Z+D)", **FORMULA)
    _log_depth(axes)
    axes.set(yscale="log", xlabel=AXES["depth"])
    axes.minorticks_off()
    axes.set_yticks(SHARE_TICKS, [f"{tick:g}" for tick in SHARE_TICKS])
    axes.set_ylabel("Missing share of the deflection")
    legend_below(drawn, axes, ncols=2)
    return Drawing(
        drawn,
        columns(("sensor", "depth_mm", "mean_share", "low", "high"), rows),
        "Share of the tip's deflection that the linear estimate misses, against scene "
        "depth, for four sensors with the same lens, and so four distances D from the "
        "camera to the mirror. Means with 95 % intervals; dotted: D/(Z+D); both axes "
        "are logarithmic.",
    )
