"""Values of the prose, figures and judgements of section 5.3.2, from its results."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.experiment import (
    INJECTED_MM,
    PUBLISHED_WAY,
)
from chapters.shared.mirror import (
    CONTRASTED,
    LEVEL,
    LEVEL_NAMES,
    READINGS,
    counterpart_over_the_sweep,
)
from chapters.shared.mirror import SWEPT as ENDS
from repro.page import INK, legend_below, look_of, new_figure, series, value
from repro.run import (
    Case,
    Drawing,
    Reading,
    Value,
    claim,
    columns,
    figure,
    median_and_range,
    numbers,
    trend,
    with_worst,
)

RUNS, SWEPT = "fig_5_7_runs", "fig_5_7_swept"
SENSITIVITY = "exp_c5_primary_sensitivity"
# Names in the trials of the options of each question; each except the primary one is a
# calibration of its own.
WAYS = {
    "reduced_curve": {
        "distance along the viewing rays": PUBLISHED_WAY,
        "height over the clamped line": "height",
    },
    "reduced_start": {
        "shape from normals, scale from points": PUBLISHED_WAY,
        "mirror points": "points",
    },
    "reduced_corners": {"all": PUBLISHED_WAY, "middle strip": "strip"},
}
FRAMES = {
    "scan_frame": {
        "camera's frame": "camera_mm",
        "aligned before bending": "shared_mm",
        "each aligned": "alone_mm",
    }
}
OPTIONS = READINGS | WAYS | FRAMES


def errors(results, case, level, stages):
    """Mean distances (stages, runs) of curves from the scan, mm; nan where rejected.

    case: an interpretation, in which at most one calibration differs from the primary
    one; stages: of "before", "linear" and "final".
    """
    ways = (case[question] for question in WAYS)
    way = next((way for way in ways if way != PUBLISHED_WAY), PUBLISHED_WAY)
    result = results[SWEPT if level in ENDS else RUNS]
    return result.column(level, way, stages, case["scan_frame"])


def final_errors(result, kind):
    """Final errors (levels, runs) mm with added errors; nan where rejected."""
    return np.array(result.arrays("final_mm", kind=kind)).T


def final_over_injected(result, kind):
    """Slope of the median final error over the added error, Estimate."""
    return trend(
        np.array(INJECTED_MM),
        list(final_errors(result, kind)),
        lambda x, y: float(np.polyfit(x, y, 1)[0]),
    )


def name_values(open_results):
    """Name the numbers of the prose: medians over the runs at the primary level."""
    result = open_results(RUNS)
    frames = list(FRAMES["scan_frame"].values())
    found = result.column(LEVEL, PUBLISHED_WAY, ("before", "linear", "final"), frames)
    before, linear, final = found
    value(f"{LEVEL}.before.camera_mm", float(np.nanmedian(before[0])))
    for frame, ratio in zip(frames, np.nanmedian(linear / final, axis=1), strict=True):
        value(f"ratio.{frame}", float(ratio))
    slope = final_over_injected(open_results(SENSITIVITY), "all")
    value("sensitivity.all", slope.value)


# Fig. 5.6, Fig. 5.7, and errors of the curves of all runs.


# Curve -> its name, the scan that it is compared with, and how it is drawn.
CURVES = {
    "before": ("primary calibration", "true_before", series(2)),
    "linear": ("linear estimate after", "true_after", series(0)),
    "final": ("final estimate after", "true_after", series(1)),
}
SHARES = (5, 50, 95)


@figure("fig_5_6", needs=("fig_5_6_pictures",), evidence="rendered")
def fig_5_6(results):
    """The chessboard in a smooth mirror, and in an uneven one."""
    result = results["fig_5_6_pictures"]
    drawn, panels = new_figure(1, 2, height_in=3.2)
    names = {"even": "smooth mirror", "uneven": "mirror of the second level"}
    for panel, (name, title) in zip(panels, names.items(), strict=True):
        panel.imshow(result.arrays(name)[0], cmap="gray", vmin=0, vmax=255)
        panel.set(title=title, xticks=[], yticks=[])
    depths = ("280", "1000", "5000")
    moved = result.column("moved", depths)[:, 0]
    settings = result.settings
    return Drawing(
        drawn,
        {"depth_mm": list(map(float, depths)), "mean_displacement_mm": list(moved)},
        f"A chessboard with squares of {settings['board'][2]:g} mm, "
        f"{settings['depth_mm'] / 1000:g} m from the unbent mirror of rig A. "
        f"Left: smooth mirror. Right: unevenness of {settings['aberration_um']:g} µm "
        "(RMS), as at the second level, and as much strain at its free edges. It "
        f"displaces the points that pixels see by {moved[-1]:.0f} mm on average; at "
        f"280 mm it would be {moved[0]:.2f} mm.",
    )


@figure("fig_5_7", needs=("fig_5_7_curves",), evidence="rendered")
def fig_5_7(results):
    """Scan and curves of one run, before and after, and their differences."""
    result = results["fig_5_7_curves"]
    scans = {"true_before": "true mirror", "true_after": None}
    shapes = {name: result.arrays(name)[0] for name in (*CURVES, *scans)}
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    rows = []
    for name, label in scans.items():
        look = look_of("true mirror") | {"marker": ""}
        left.plot(*shapes[name], label=label, **look)
        rows += [(name, *row, 0.0) for row in shapes[name].T]
    for name, (label, scan, look) in CURVES.items():
        x, height = shapes[name]
        on = x <= shapes[scan][0, -1]
        x, height = x[on], height[on]
        off = height - np.interp(x, *shapes[scan])
        every = look | {"markevery": 10}
        left.plot(x, height, label=label, **every)
        if name != "linear":
            right.plot(x, off, label=label, **every)
        rows += [(name, *row) for row in zip(x, height, off, strict=True)]
    right.axhline(0, color=INK, lw=1.0)
    left.set(xlabel="Position along mirror (mm)", ylabel="Height of the mirror (mm)")
    right.set(xlabel="Position along mirror (mm)", ylabel="Error of the height (mm)")
    legend_below(drawn, left, ncols=2)
    return Drawing(
        drawn,
        columns(("curve", "along_mm", "height_mm", "error_mm"), rows),
        "Left: the mirror before and after a push of "
        f"{result.settings['deflection_mm']:g} mm near its free edge, true and "
        "estimated with the reduced model from a board at "
        f"{result.settings['depth_mm']:g} mm; heights above the flat sheet, in the "
        "camera's frame. Right: errors of the primary "
        "calibration and of the final estimate. One run, second level.",
    )


@figure("ext_reduced_errors", needs=("fig_5_7_runs",), evidence="rendered")
def ext_reduced_errors(results):
    """Mean distances from the scan of all runs, in each frame, at two levels."""
    from matplotlib.ticker import FixedFormatter

    result = results[RUNS]
    drawn, panels = new_figure(1, 2, height_in=3.6, sharey=True)
    frames = FRAMES["scan_frame"]
    names = [frame.replace(" ", "\n", 1) for frame in frames]
    rows = []
    for panel, level in zip(panels, CONTRASTED, strict=True):
        for k, (stage, (label, _, look)) in enumerate(CURVES.items()):
            at = np.arange(len(frames)) + 0.2 * (k - 1)
            found = result.column(level, PUBLISHED_WAY, stage, list(frames.values()))
            low, middle, high = np.nanpercentile(found, SHARES, axis=1)
            panel.errorbar(
                at,
                middle,
                [middle - low, high - middle],
                label=label,
                capsize=3,
                **look | {"linestyle": ""},
            )
            rows += [
                (LEVEL_NAMES[level], stage, *row)
                for row in zip(frames, low, middle, high, strict=True)
            ]
        panel.set(title=LEVEL_NAMES[level], yscale="log")
        panel.set_xticks(range(len(frames)))
        panel.xaxis.set_major_formatter(FixedFormatter(names))
    panels[0].set_ylabel("Mean distance from the true mirror (mm)")
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(("level", "curve", "frame", "low_mm", "median_mm", "high_mm"), rows),
        "Mean distance of the curves from the true mirror: in the camera's frame, "
        "after one alignment to the curve before bending, and after an alignment of "
        f"each. Rig A, {result.trials_per_condition} runs: medians, and bars from "
        "5 to 95 %.",
    )


# Claims about Fig. 5.7, tested as registered, and its numbers.


BOTH = ("fig_5_7_runs", "fig_5_7_swept")
QUESTIONS = (
    "mirror_bench",
    "reduced_curve",
    "reduced_start",
    "reduced_corners",
    "scan_frame",
)
MIN_POOR, SIMILAR = 3.0, (0.5, 2.0)
MIN_SLOPE = 0.5


@claim("c5_red_final_good", needs=BOTH, evidence="rendered", readings=QUESTIONS)
def judge_final_good(results, options):
    """The linear error is three times the final one or more."""
    case = Case(OPTIONS, options)

    def found_at(level):
        linear, final = errors(results, case, level, ("linear", "final"))
        reason = f"linear over final error; {_medians(linear=linear, final=final)}"
        # nan compares as false, and counts as rejected.
        return linear >= MIN_POOR * final, linear / final, "x", reason

    return counterpart_over_the_sweep(case, found_at)


@claim("c5_red_primary_limits", needs=BOTH, evidence="rendered", readings=QUESTIONS)
def judge_primary_limits(results, options):
    """The final error is between half and twice that of the primary calibration."""
    case = Case(OPTIONS, options)

    def found_at(level):
        before, final = errors(results, case, level, ("before", "final"))
        ratio = final / before
        reason = f"final over primary error; {_medians(primary=before, final=final)}"
        return (ratio >= SIMILAR[0]) & (ratio <= SIMILAR[1]), ratio, "x", reason

    return counterpart_over_the_sweep(case, found_at)


@claim(
    "c5_primary_sensitivity",
    needs=("exp_c5_primary_sensitivity",),
    evidence="synthetic",
)
def judge_primary_sensitivity(results):
    """Slope of the final error over the error put into the primary surface.

    Fixed before the run: exact corners, clamp and viewing rays; an error along the
    mirror of four parts of equal weight (shift, tilt, bend, and one of third order),
    drawn once for all levels; its size the mean distance between the curves with and
    without it, 0 to 0.8 mm; the final error the mean distance from the true mirror
    after a deflection of 7.98 mm; a straight line through the medians of the levels.
    """
    result = results["exp_c5_primary_sensitivity"]
    slope = final_over_injected(result, "all")
    # A rejected run counts as the worst.
    medians = np.median(with_worst(final_errors(result, "all")), axis=1)
    others = ", ".join(
        f"{kind} {final_over_injected(result, kind).value:.2f}"
        for kind in ("shift", "tilt", "bend")
    )
    return Reading.of(
        slope.above(np.nextafter(MIN_SLOPE, 0)),
        slope,
        "1",
        f"mm of final error for each mm; medians {medians[0]:.3g}, {medians[-1]:.3g} "
        "mm without and with most; "
        f"slopes of one part alone: {others}",
    )


def _medians(**found):
    """The medians of those runs that have a value, in words."""
    middle = {name: median_and_range(v).value for name, v in found.items()}
    return ", ".join(f"{name} {value:.3g} mm" for name, value in middle.items())


@numbers("fig_5_7", needs=("fig_5_7_runs",), evidence="rendered")
def numbers_fig_5_7(results):
    """Settings stated in the text, as they were run, and the mean error."""
    settings = results[RUNS].settings
    (final,) = errors(results, Case(OPTIONS), LEVEL, ("final",))
    return {
        "fig5_7_defl": Value(settings["deflection_mm"], unit="mm"),
        "fig5_7_depth": Value(settings["depth_mm"], unit="mm"),
        "fig5_7_err": Value.of_seeds(
            final, "mm", "after the deflection, in the camera's frame, primary level"
        ),
    }


@numbers("fig_5_6", needs=("fig_5_6_pictures",), evidence="rendered")
def numbers_fig_5_6(results):
    """Distance of the chessboard, as it was rendered."""
    depth = results["fig_5_6_pictures"].settings["depth_mm"]
    return {"s5_3_2_depth_ab": Value(depth, unit="mm")}
