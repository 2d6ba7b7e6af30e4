"""What the sweeps of 3.3.3 found, and the numbers that are quoted."""

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    ACTIVE,
    DEFAULT_LEVEL,
    DEFAULT_MM,
    DERIVATIVE,
    EXPOSURES,
    METHODS,
    ONE_WINDOW,
    OVER,
    SADDLE,
    SECOND_GRIDS,
    STATIC,
    TRUE,
    WINDOWS,
    WITHIN,
)
from repro.judge.statistics import with_worst
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value
from repro.run.readings import Case

SWEPT = ("fig_3_15_sweeps",)
SHORT = {ACTIVE: "active", DERIVATIVE: "derivative", SADDLE: "saddle"}
SWEEPS = ("distance", "orientation", "blur", "noise")
# What tells how far corners are off; the measure that decides comes first.
BY_GRID, BY_TRUTH = "a second grid", "the true corners"
MEASURES = (BY_GRID, BY_TRUTH)
# Question of the ledger -> its options, which the trials call so too.
NAMES = {
    question: {option: option for option in options}
    for question, options in (
        ("corner_window", WINDOWS),
        ("second_grid_pictures", SECOND_GRIDS),
        ("exposure", EXPOSURES),
        ("corner_measure", MEASURES),
    )
}
PRIMARY = Case(NAMES)


def swept(results):
    """The result of the sweeps."""
    return results[SWEPT[0]]


def levels_of(result, sweep):
    """Levels of a sweep in rising order, the default one among them."""
    default = {DEFAULT_LEVEL[sweep]} if sweep in DEFAULT_LEVEL else set()
    return sorted({*result.levels("level", sweep=sweep), *default})


def at(result, sweep, level, name):
    """Values (sets,) of a level."""
    if DEFAULT_LEVEL.get(sweep) == level:
        sweep, level = "default", DEFAULT_MM
    return result.select(sweep=sweep, level=level).column(name)


def points_of(result):
    """Every (sweep, level) once; the sweeps meet at the default."""
    return list(dict.fromkeys((c["sweep"], c["level"]) for c in result.conditions))


def residuals(result, sweep, level, method, taken=PRIMARY):
    """RMS residuals (sets,) in mm; infinite where the method failed.

    Against the true corners: RMS errors in px.
    """
    measured = taken["second_grid_pictures"]
    if taken["corner_measure"] == BY_TRUTH:
        measured = "off_px"
    name = f"{taken['exposure']}.{taken['corner_window']}.{measured}.{method}"
    return with_worst(at(result, sweep, level, name))


def tie_width(result, sweep, level, taken=PRIMARY):
    """Residuals that are no more apart are a tie: by how much the floor spreads.

    The largest less the least, over the sets, of what true corners leave. Against the
    true corners there is no floor, and no tie.
    """
    return np.ptp(residuals(result, sweep, level, TRUE, taken))


def errors(result, sweep, level, method, exposure=WITHIN):
    """RMS errors (sets,) in px against the true corners, of those found."""
    return at(result, sweep, level, f"{exposure}.{ONE_WINDOW}.off_px.{method}")


def lost(result, points, method, taken=PRIMARY):
    """How many corners (points, sets) a method left out."""
    name = f"{taken['exposure']}.{taken['corner_window']}.lost.{method}"
    return np.array([at(result, sweep, level, name) for sweep, level in points])


def wins(result, points, taken=PRIMARY):
    """Where (points, sets) the active grid is no worse than both others, or ties."""
    won = []
    for sweep, level in points:
        ours, *theirs = (
            residuals(result, sweep, level, method, taken)
            for method in (ACTIVE, *STATIC)
        )
        tie = tie_width(result, sweep, level, taken)
        won.append(np.isfinite(ours) & (ours <= np.minimum(*theirs) + tie))
    return np.array(won)


def points_along(result, sweep):
    """(sweep, level) of every level of a sweep, the default one among them."""
    return [(sweep, level) for level in levels_of(result, sweep)]


def blur_ratios(result, taken=PRIMARY):
    """Method -> residual at the largest blur over that without (sets,)."""
    least, *_, most = levels_of(result, "blur")
    return {
        method: residuals(result, "blur", most, method, taken)
        / residuals(result, "blur", least, method, taken)
        for method in METHODS
    }


def blur_tie(result, taken=PRIMARY):
    """Ratios (sets,) of `blur_ratios` that are no more apart are a tie."""
    least, *_, most = levels_of(result, "blur")
    sharp = residuals(result, "blur", least, ACTIVE, taken)
    return tie_width(result, "blur", most, taken) / sharp


@numbers("fig_3_15", needs=SWEPT, evidence="rendered")
def numbers_fig_3_15(results):
    """The settings of the sweeps as they were run."""
    ran = swept(results).settings
    return {
        "fig3_15_corners": Value(ran["corners"][0], unit="count"),
        "fig3_15_size": Value(ran["grid_mm"], unit="mm"),
        "fig3_15_dist": Value(ran["distance_mm"], unit="mm"),
        "fig3_15_ori": Value(ran["orientation_deg"], unit="deg"),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    result = open_results(SWEPT[0])
    quoted = {
        **of_exposure(result, "", WITHIN),
        **of_exposure(result, "over.", OVER),
        **of_noise(result),
        **of_blur(result),
        "floor": middle(residuals(result, "distance", DEFAULT_MM, TRUE)),
        "floor.spread": tie_width(result, "distance", DEFAULT_MM),
        "sets": len(result.levels("set")),
        **of_turns(open_results("exp_c3_active_viewing_angle")),
    }
    for name, number in quoted.items():
        value(name, number)


def middle(found):
    """Median of some values."""
    return float(np.median(found))


def of_exposure(result, short, exposure):
    """Where the active grid wins with an exposure, and every method's error."""
    taken = Case(NAMES, {"exposure": exposure})
    share = wins(result, points_of(result), taken).mean(axis=0)
    return {
        f"{short}won": 100 * middle(share),
        f"{short}won.least": 100 * float(share.min()),
    } | {
        f"{short}off.{SHORT[method]}": middle(
            errors(result, "distance", DEFAULT_MM, method, exposure)
        )
        for method in METHODS
    }


def of_noise(result):
    """Errors in the strongest noise, and where the active grid loses first."""
    most = levels_of(result, "noise")[-1]
    return {"most_noise": most, "first_lost_noise": _first_lost(result)} | {
        f"noisy.{SHORT[method]}": middle(errors(result, "noise", most, method))
        for method in METHODS
    }


def of_blur(result):
    """Every method's error in the strongest blur over that without, by true corners."""
    ratios = blur_ratios(result, Case(NAMES, {"corner_measure": BY_TRUTH}))
    return {
        f"blurred.{SHORT[method]}": middle(ratio) for method, ratio in ratios.items()
    }


def _first_lost(result):
    """The first noise at which the active grid loses in most sets."""
    for sweep, level in points_along(result, "noise"):
        if np.median(wins(result, [(sweep, level)])[0]) < 1:
            return level
    return "none"


def of_turns(result):
    """What is decoded of the monitor that is turned most."""
    turns = sorted(result.levels("turn_deg"))
    angles = result.select(turn_deg=turns[-1]).column("largest_angle_deg")
    light = float(np.cos(np.radians(angles.max())) ** 2)
    return {
        "turned": turns[-1],
        "share.turned": 100 * middle(shares(result, turns[-1])),
        "sigma.straight": middle(shares(result, turns[0], "sigma_um")),
        "sigma.turned": middle(shares(result, turns[-1], "sigma_um")),
        "largest_angle": float(np.max(angles)),
        "light_there": 100 * light,
        "grey_there": 100 * light ** (1 / 2.2),
    }


def shares(result, turn, name="share", *, falloff=2, gamma=2.2):
    """Shares (seeds,) of the visible area that are decoded at a turn.

    Or another value of the trials, by its name.
    """
    shown = {"falloff_exponent": falloff, "camera_gamma": gamma}
    return result.select(turn_deg=turn, **shown).column(name)
