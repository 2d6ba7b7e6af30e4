"""The claims of 4.3.2 about corrected pictures, and the numbers of Table 4.4."""

from itertools import product

from chapters.ch04_central_generic.s3_3_correction.results import (
    BOARDS,
    LINES,
    READINGS,
    Corrected,
    equal_residuals,
    larger_residuals,
    less_view,
    no_radial_bias,
    seams,
    skew,
)
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.noise_sweep import counterpart_over_the_sweep, over_the_sweep
from repro.judge.statistics import Estimate, all_of, median_interval, wins, with_worst
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value
from repro.run.readings import Case

STRAIGHT, MIN_GAIN = 0.01, 1.05
LINES_ALONE = ("fig_4_7_lines",)
BOARDS_ALONE = ("fig_4_9_boards",)
STANDARD = ("decoding_noise", "standard_method")


def _by_trial(result, options, predicate):
    """The Reading of a predicate of `Corrected`, over the sweep of the noise."""
    return counterpart_over_the_sweep(
        Case(READINGS, options),
        lambda noise: predicate(Corrected(result, options, noise)),
    )


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
def judge_unwrapped_view(results, options):
    """Less vertical view with the standard method, and its depth is why."""
    return _by_trial(results[LINES], options, less_view)


@claim("c4_t44_omni", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
def judge_omnidirectional_residuals(results, options):
    """Mean and SD of the standard residuals at least 1.3 times CGSP's."""
    return _by_trial(results[BOARDS], options, larger_residuals)


@claim("c4_t44_fish", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
def judge_fisheye_residuals(results, options):
    """The means are nearly equal."""
    return _by_trial(results[BOARDS], options, equal_residuals)


@claim("c4_no_radial_bias", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
def judge_radial_bias(results, options):
    """No quintile of radius has a mean radial residual of a quarter RMS."""
    return _by_trial(results[BOARDS], options, no_radial_bias)


@claim("c4_seams", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
def judge_seams(results, options):
    """Standard residuals are larger beside seams, CGSP's less so."""
    return _by_trial(results[BOARDS], options, seams)


@claim("c4_skew_amplifies", needs=BOARDS_ALONE, evidence="rendered", readings=STANDARD)
def judge_skew(results, options):
    """Residuals of the fisheye rise with the angle to the plane's normal."""
    return _by_trial(results[BOARDS], options, skew)


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
