"""The claims of 4.3.2 about corrected pictures, and the numbers of Table 4.4.

Most are judged trial by trial: a predicate takes the `Corrected` trials of a reading
and returns whether it is true (trials,), what was measured (trials,), its unit, and
words.
"""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import (
    BOARDS,
    LINES,
    READINGS,
    Corrected,
)
from chapters.shared.bench_noise import BENCH
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.noise_sweep import judged_by_seed, over_the_sweep
from repro.judge.statistics import Estimate, all_of, median_interval, wins, with_worst
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value
from repro.run.readings import Case

STRAIGHT, MIN_GAIN = 0.01, 1.05
LINES_ALONE = ("fig_4_7_lines",)
BOARDS_ALONE = ("fig_4_9_boards",)
STANDARD = ("decoding_noise", "standard_method")
REMOVED = 0.2
MIN_RATIO, EQUAL = 1.3, (0.85, 1.25)
MAX_BIAS, SEAM, SKEW = 0.25, 1.5, 0.3


def _lines(results, options, noise=BENCH):
    return Corrected(results[LINES], options, noise)


def _boards(results, options, noise=BENCH):
    return Corrected(results[BOARDS], options, noise)


@claim("c4_lines_straight", needs=LINES_ALONE, evidence="rendered", readings=STANDARD)
def judge_lines_straight(results, options):
    """Worst edge within 1 % for both methods; CGSP ahead, omnidirectional."""

    def shares_at(noise):
        lines = Corrected(results[LINES], options, noise)
        methods = lines["standard_method"], "cgsp"
        return {
            (camera, method): lines.of(camera, f"{method}.worst_share")
            for camera, method in product((OMNI, FISH), methods)
        }

    def found_at(noise):
        shares = shares_at(noise)
        worst = {key: median_interval(found) for key, found in shares.items()}
        standard, cgsp = (with_worst(s) for (c, _), s in shares.items() if c == OMNI)
        return worst, wins([(cgsp, standard)])[0]

    def reading_at(noise):
        worst, ahead = found_at(noise)
        at = max(worst, key=lambda key: worst[key].value)
        return Reading.of(
            all_of([*(e.below(STRAIGHT) for e in worst.values()), ahead.decision]),
            Estimate(*(100 * end for end in worst[at][:3])),
            "%",
            f"largest deviation of an edge from its line, of its length: {at[0]}, "
            f"{at[1]}; standard / CGSP of the omnidirectional camera "
            f"{ahead.ratio.value:.3f} ({ahead.ratio.low:.3f} to "
            f"{ahead.ratio.high:.3f})",
        )

    def straight_and_ahead(noise):
        worst, ahead = found_at(noise)
        straight = all(found.value < STRAIGHT for found in worst.values())
        return straight and ahead.ratio.value >= MIN_GAIN

    return over_the_sweep(Case(READINGS, options), reading_at, straight_and_ahead)


@claim("c4_unwrap_fov", needs=LINES_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_lines)
def less_view(lines):
    """Less vertical view with the standard method, and its depth is why."""
    own, cgsp = lines.both(OMNI, "vertical_deg")
    same, _ = lines.both(OMNI, "equal_depth_deg")
    less = cgsp - own
    left = np.abs(cgsp - same) / np.abs(less)
    return (
        (less > 0) & (left <= REMOVED),
        less,
        "deg",
        "CGSP's vertical view less the standard one's; with equal depth "
        f"{100 * np.nanmedian(left):.0f} % of the difference is left",
    )


@claim("c4_t44_omni", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def larger_residuals(boards):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    mean, spread = (boards.ratio(OMNI, name) for name in ("mean_mm", "sd_mm"))
    return (
        (mean >= MIN_RATIO) & (spread >= MIN_RATIO),
        mean,
        "",
        f"ratio of the means; of the SDs {np.median(spread):.3f}",
    )


@claim("c4_t44_fish", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def equal_residuals(boards):
    """The means of the fisheye are nearly equal."""
    mean = boards.ratio(FISH, "mean_mm")
    return (mean >= EQUAL[0]) & (mean <= EQUAL[1]), mean, "", "ratio of the means"


@claim("c4_no_radial_bias", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def no_radial_bias(boards):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    worse = with_worst(boards.both(OMNI, "radial_bias")).max(axis=0)
    return (
        worse <= MAX_BIAS,
        worse,
        "",
        "largest mean radial residual of a quintile over the RMS, the worse of both "
        "methods",
    )


@claim("c4_seams", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def seams(boards):
    """Standard residuals are larger beside seams, CGSP's less so."""
    own, cgsp = boards.both(OMNI, "seam_ratio")
    return (
        (own > SEAM) & (cgsp < own),
        own,
        "",
        "mean residual beside seams over that elsewhere; CGSP "
        f"{np.nanmedian(cgsp):.2f}",
    )


@claim("c4_skew_amplifies", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
@judged_by_seed(_boards)
def skew(boards):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    least = boards.both(FISH, "skew_spearman").min(axis=0)
    return (
        least >= SKEW,
        least,
        "",
        "rank correlation of angle and residual, the smaller of both methods",
    )


@numbers("table_4_4", needs=BOARDS_ALONE, evidence="rendered")
def numbers_of_table_4_4(results):
    """Mean and SD of the residuals, the standard method as printed."""
    boards = Corrected(results[BOARDS])
    return {
        f"t4_4_{short}_{name}_{statistic}": Value.of_seeds(
            boards.of(camera, f"{method}.{statistic}_mm"), "mm"
        )
        for short, camera in (("omni", OMNI), ("fish", FISH))
        for name, method in (("std", "printed"), ("cgsp", "cgsp"))
        for statistic in ("mean", "sd")
    }


@numbers("fig_4_9", needs=BOARDS_ALONE, evidence="rendered")
def numbers_of_fig_4_9(results):
    """How much longer than they are the vectors are drawn."""
    drawn = results[BOARDS].settings["magnified"]
    return {"fig4_9_scale": Value(drawn, unit="x")}
