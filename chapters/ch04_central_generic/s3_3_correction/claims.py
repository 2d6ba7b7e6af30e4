"""The claims of 4.3.2 about corrected pictures, and the numbers of Table 4.4."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import (
    of_camera,
    ratio,
    readings,
)
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.counterpart import decided
from repro.judge.statistics import all_of, median_interval, wins, with_worst
from repro.run.experiment import claim, numbers
from repro.run.outcomes import DECISIONS, Reading, Value

STRAIGHT, REMOVED = 0.01, 0.2
LEAST_RATIO, EQUAL = 1.3, (0.85, 1.25)
MOST_BIAS, SEAM, SKEW = 0.25, 1.5, 0.3
LINES = ("fig_4_7_lines",)
BOARDS = ("fig_4_9_boards",)


@claim("c4_lines_straight", needs=LINES, evidence="rendered")
def judge_lines_straight(results):
    """Worst edge within 1 % for both methods; CGSP ahead, omnidirectional."""
    result, found = results["fig_4_7_lines"], []
    for options, standard in readings():
        worst = {
            (camera, method): median_interval(
                of_camera(result, camera, f"{method}.worst_share")
            )
            for camera in (OMNI, FISH)
            for method in (standard, "cgsp")
        }
        pair = [
            with_worst(of_camera(result, OMNI, f"{method}.worst_share"))
            for method in ("cgsp", standard)
        ]
        ahead = wins([tuple(pair)])[0]
        at = max(worst, key=lambda key: worst[key].value)
        decision = all_of(
            [*(e.below(STRAIGHT) for e in worst.values()), ahead.decision]
        )
        found.append(
            Reading(
                DECISIONS[decision],
                100 * worst[at].value,
                reading=options,
                interval=(100 * worst[at].low, 100 * worst[at].high),
                unit="%",
                reason=f"largest deviation of an edge from its line, of its "
                f"length: {at[0]}, {at[1]}; standard / CGSP of the "
                f"omnidirectional camera {ahead.ratio.value:.3f} "
                f"({ahead.ratio.low:.3f} to {ahead.ratio.high:.3f})",
            )
        )
    return found


@claim("c4_unwrap_fov", needs=LINES, evidence="rendered")
def judge_unwrapped_view(results):
    """Less vertical view with the standard method, and its depth is why."""
    result, found = results["fig_4_7_lines"], []
    cgsp = of_camera(result, OMNI, "cgsp.vertical_deg")
    for options, standard in readings():
        own = of_camera(result, OMNI, f"{standard}.vertical_deg")
        same = of_camera(result, OMNI, f"{standard}.equal_depth_deg")
        less = cgsp - own
        left = np.abs(cgsp - same) / np.abs(less)
        found.append(
            decided(
                (less > 0) & (left <= REMOVED),
                less,
                options,
                "deg",
                "CGSP's vertical view less the standard one's; with equal depth "
                f"{100 * np.nanmedian(left):.0f} % of the difference is left",
            )
        )
    return found


@claim("c4_t44_omni", needs=BOARDS, evidence="rendered")
def judge_omnidirectional_residuals(results):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    result, found = results["fig_4_9_boards"], []
    for options, standard in readings():
        mean = ratio(result, OMNI, standard, "mean_mm")
        spread = ratio(result, OMNI, standard, "sd_mm")
        found.append(
            decided(
                (mean >= LEAST_RATIO) & (spread >= LEAST_RATIO),
                mean,
                options,
                "",
                f"ratio of the means; of the SDs {np.median(spread):.3f}",
            )
        )
    return found


@claim("c4_t44_fish", needs=BOARDS, evidence="rendered")
def judge_fisheye_residuals(results):
    """The means are nearly equal."""
    result, found = results["fig_4_9_boards"], []
    for options, standard in readings():
        mean = ratio(result, FISH, standard, "mean_mm")
        inside = (mean >= EQUAL[0]) & (mean <= EQUAL[1])
        found.append(decided(inside, mean, options, "", "ratio of the means"))
    return found


@claim("c4_no_radial_bias", needs=BOARDS, evidence="rendered")
def judge_radial_bias(results):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    result, found = results["fig_4_9_boards"], []
    for options, standard in readings():
        bias = np.max(
            [
                with_worst(of_camera(result, OMNI, f"{m}.radial_bias"))
                for m in (standard, "cgsp")
            ],
            axis=0,
        )
        found.append(
            decided(
                bias <= MOST_BIAS,
                bias,
                options,
                "",
                "largest mean radial residual of a quintile over the RMS, the "
                "worse of both methods",
            )
        )
    return found


@claim("c4_seams", needs=BOARDS, evidence="rendered")
def judge_seams(results):
    """Standard residuals are larger beside seams, CGSP's less so."""
    result, found = results["fig_4_9_boards"], []
    for options, standard in readings():
        own, cgsp = (
            of_camera(result, OMNI, f"{m}.seam_ratio") for m in (standard, "cgsp")
        )
        found.append(
            decided(
                (own > SEAM) & (cgsp < own),
                own,
                options,
                "",
                "mean residual beside seams over that elsewhere; CGSP "
                f"{np.nanmedian(cgsp):.2f}",
            )
        )
    return found


@claim("c4_skew_amplifies", needs=BOARDS, evidence="rendered")
def judge_skew(results):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    result, found = results["fig_4_9_boards"], []
    for options, standard in readings():
        least = np.min(
            [of_camera(result, FISH, f"{m}.skew_spearman") for m in (standard, "cgsp")],
            axis=0,
        )
        found.append(
            decided(
                least >= SKEW,
                least,
                options,
                "",
                "rank correlation of angle and residual, the smaller of both methods",
            )
        )
    return found


@numbers("table_4_4", needs=BOARDS, evidence="rendered")
def numbers_of_table_4_4(results):
    """Mean and SD of the residuals, the standard method as printed."""
    result = results["fig_4_9_boards"]
    return {
        f"t4_4_{short}_{name}_{statistic}": Value(
            float(np.median(found)),
            interval=(float(found.min()), float(found.max())),
            unit="mm",
        )
        for short, camera in (("omni", OMNI), ("fish", FISH))
        for name, method in (("std", "printed"), ("cgsp", "cgsp"))
        for statistic in ("mean", "sd")
        for found in [of_camera(result, camera, f"{method}.{statistic}_mm")]
    }


@numbers("fig_4_9", needs=BOARDS, evidence="rendered")
def numbers_of_fig_4_9(results):
    """How much longer than they are the vectors are drawn."""
    drawn = results["fig_4_9_boards"].settings["magnified"]
    return {"fig4_9_scale": Value(drawn, unit="x")}
