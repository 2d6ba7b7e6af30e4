"""Claims about Fig. 5.7, tested as registered, and its numbers."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.results import (
    PRIMARY,
    RUNS,
    ReducedCase,
    final_over_injected,
    medians_by_kind,
)
from chapters.shared.mirror_bench import LEVEL
from chapters.shared.mirror_sweep import counterpart_over_the_sweep
from repro.judge.statistics import median_and_range
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

SEEDS = ("fig_5_7_runs", "fig_5_7_swept")
QUESTIONS = (
    "mirror_bench",
    "reduced_curve",
    "reduced_start",
    "reduced_corners",
    "scan_frame",
)
MIN_POOR, SIMILAR = 3.0, (0.5, 2.0)
MIN_SLOPE = 0.5


@claim("c5_red_final_good", needs=SEEDS, evidence="rendered", readings=QUESTIONS)
def judge_final_good(results, options):
    """The linear error is three times the final one or more."""
    case = ReducedCase(options)

    def found_at(bench):
        linear, final = (
            case.errors(results, bench, stage) for stage in ("linear", "final")
        )
        reason = f"linear over final error; {_medians(linear=linear, final=final)}"
        # nan compares as false, and counts as rejected.
        return linear >= MIN_POOR * final, linear / final, "x", reason

    return counterpart_over_the_sweep(case, found_at)


@claim("c5_red_primary_limits", needs=SEEDS, evidence="rendered", readings=QUESTIONS)
def judge_primary_limits(results, options):
    """The final error is between half and twice that of the primary calibration."""
    case = ReducedCase(options)

    def found_at(bench):
        before, final = (
            case.errors(results, bench, stage) for stage in ("before", "final")
        )
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
    ends = ", ".join(f"{mm:.3g}" for mm in medians_by_kind(result, "all")[[0, -1]])
    others = ", ".join(
        f"{kind} {final_over_injected(result, kind).value:.2f}"
        for kind in ("shift", "tilt", "bend")
    )
    return Reading.of(
        slope.above(np.nextafter(MIN_SLOPE, 0)),
        slope,
        "1",
        f"mm of final error for each mm; medians {ends} mm without and with most; "
        f"slopes of one part alone: {others}",
    )


def _medians(**found):
    """The medians of those seeds that have a value, in words."""
    middle = {name: median_and_range(v).value for name, v in found.items()}
    return ", ".join(f"{name} {value:.3g} mm" for name, value in middle.items())


@numbers("fig_5_7", needs=("fig_5_7_runs",), evidence="rendered")
def numbers_fig_5_7(results):
    """Settings stated in the text, as they were run, and the mean error."""
    settings = results[RUNS].settings
    final = PRIMARY.errors(results, LEVEL, "final")
    return {
        "fig5_7_defl": Value(settings["deflection_mm"], unit="mm"),
        "fig5_7_depth": Value(settings["depth_mm"], unit="mm"),
        "fig5_7_err": Value.of_seeds(
            final, "mm", "after the deflection, in the camera's frame, on the bench"
        ),
    }


@numbers("fig_5_6", needs=("fig_5_6_pictures",), evidence="rendered")
def numbers_fig_5_6(results):
    """Distance of the chessboard, as it was rendered."""
    depth = results["fig_5_6_pictures"].settings["depth_mm"]
    return {"s5_3_2_depth_ab": Value(depth, unit="mm")}
