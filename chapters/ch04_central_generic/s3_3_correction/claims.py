"""The claims of 4.3.2 about corrected pictures, and the numbers of Table 4.4."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import (
    READINGS,
    both,
    of_camera,
)
from chapters.shared.central_sets import FISH, OMNI
from repro.judge.statistics import Estimate, all_of, median_interval, wins, with_worst
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value
from repro.run.readings import Case, counterpart

STRAIGHT, REMOVED = 0.01, 0.2
MIN_RATIO, EQUAL = 1.3, (0.85, 1.25)
MAX_BIAS, SEAM, SKEW = 0.25, 1.5, 0.3
LINES = ("fig_4_7_lines",)
BOARDS = ("fig_4_9_boards",)
STANDARD = ("standard_method",)


@claim("c4_lines_straight", needs=LINES, evidence="rendered", readings=STANDARD)
def judge_lines_straight(results, options):
    """Worst edge within 1 % for both methods; CGSP ahead, omnidirectional."""
    result = results["fig_4_7_lines"]
    methods = Case(READINGS, options)["standard_method"], "cgsp"
    shares = {
        (camera, method): of_camera(result, camera, f"{method}.worst_share")
        for camera, method in product((OMNI, FISH), methods)
    }
    worst = {key: median_interval(found) for key, found in shares.items()}
    standard, cgsp = (with_worst(shares[OMNI, method]) for method in methods)
    ahead = wins([(cgsp, standard)])[0]
    at = max(worst, key=lambda key: worst[key].value)
    return Reading.of(
        all_of([*(e.below(STRAIGHT) for e in worst.values()), ahead.decision]),
        Estimate(*(100 * end for end in worst[at][:3])),
        "%",
        f"largest deviation of an edge from its line, of its length: {at[0]}, "
        f"{at[1]}; standard / CGSP of the omnidirectional camera "
        f"{ahead.ratio.value:.3f} ({ahead.ratio.low:.3f} to {ahead.ratio.high:.3f})",
    )


@claim("c4_unwrap_fov", needs=LINES, evidence="rendered", readings=STANDARD)
def judge_unwrapped_view(results, options):
    """Less vertical view with the standard method, and its depth is why."""
    result = results["fig_4_7_lines"]
    own, cgsp = both(result, OMNI, options, "vertical_deg")
    same, _ = both(result, OMNI, options, "equal_depth_deg")
    less = cgsp - own
    left = np.abs(cgsp - same) / np.abs(less)
    return counterpart(
        (less > 0) & (left <= REMOVED),
        less,
        "deg",
        "CGSP's vertical view less the standard one's; with equal depth "
        f"{100 * np.nanmedian(left):.0f} % of the difference is left",
    )


def _ratio(results, camera, options, name):
    """Standard over CGSP, (seeds,); a failed standard run counts as the worst."""
    standard, cgsp = both(results["fig_4_9_boards"], camera, options, name)
    return with_worst(standard) / cgsp


@claim("c4_t44_omni", needs=BOARDS, evidence="rendered", readings=STANDARD)
def judge_omnidirectional_residuals(results, options):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    mean, spread = (
        _ratio(results, OMNI, options, name) for name in ("mean_mm", "sd_mm")
    )
    return counterpart(
        (mean >= MIN_RATIO) & (spread >= MIN_RATIO),
        mean,
        reason=f"ratio of the means; of the SDs {np.median(spread):.3f}",
    )


@claim("c4_t44_fish", needs=BOARDS, evidence="rendered", readings=STANDARD)
def judge_fisheye_residuals(results, options):
    """The means are nearly equal."""
    mean = _ratio(results, FISH, options, "mean_mm")
    inside = (mean >= EQUAL[0]) & (mean <= EQUAL[1])
    return counterpart(inside, mean, reason="ratio of the means")


@claim("c4_no_radial_bias", needs=BOARDS, evidence="rendered", readings=STANDARD)
def judge_radial_bias(results, options):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    biases = both(results["fig_4_9_boards"], OMNI, options, "radial_bias")
    worse = with_worst(biases).max(axis=0)
    return counterpart(
        worse <= MAX_BIAS,
        worse,
        reason="largest mean radial residual of a quintile over the RMS, the "
        "worse of both methods",
    )


@claim("c4_seams", needs=BOARDS, evidence="rendered", readings=STANDARD)
def judge_seams(results, options):
    """Standard residuals are larger beside seams, CGSP's less so."""
    own, cgsp = both(results["fig_4_9_boards"], OMNI, options, "seam_ratio")
    return counterpart(
        (own > SEAM) & (cgsp < own),
        own,
        reason="mean residual beside seams over that elsewhere; CGSP "
        f"{np.nanmedian(cgsp):.2f}",
    )


@claim("c4_skew_amplifies", needs=BOARDS, evidence="rendered", readings=STANDARD)
def judge_skew(results, options):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    found = both(results["fig_4_9_boards"], FISH, options, "skew_spearman")
    least = found.min(axis=0)
    return counterpart(
        least >= SKEW,
        least,
        reason="rank correlation of angle and residual, the smaller of both methods",
    )


@numbers("table_4_4", needs=BOARDS, evidence="rendered")
def numbers_of_table_4_4(results):
    """Mean and SD of the residuals, the standard method as printed."""
    result = results["fig_4_9_boards"]
    return {
        f"t4_4_{short}_{name}_{statistic}": Value.of_seeds(
            of_camera(result, camera, f"{method}.{statistic}_mm"), "mm"
        )
        for short, camera in (("omni", OMNI), ("fish", FISH))
        for name, method in (("std", "printed"), ("cgsp", "cgsp"))
        for statistic in ("mean", "sd")
    }


@numbers("fig_4_9", needs=BOARDS, evidence="rendered")
def numbers_of_fig_4_9(results):
    """How much longer than they are the vectors are drawn."""
    drawn = results["fig_4_9_boards"].settings["magnified"]
    return {"fig4_9_scale": Value(drawn, unit="x")}
