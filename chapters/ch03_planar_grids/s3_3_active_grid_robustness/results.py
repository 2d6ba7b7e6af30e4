"""Results of the sweeps of 3.3.3, and the numbers that the prose quotes."""

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    ACTIVE,
    DEFAULT_LEVEL,
    DEFAULT_MM,
    DERIVATIVE,
    EXPOSURES,
    METHODS,
    ONE_WINDOW,
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
SWEEPS = ("distance", "orientation", "blur", "noise")
# Measures of the error of corners; the primary one comes first.
BY_GRID, BY_TRUTH = "a second grid", "the true corners"
MEASURES = (BY_GRID, BY_TRUTH)
# Question of the registry -> its options, named alike in the trials.
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
    """Return the result of the sweeps."""
    return results[SWEPT[0]]


def levels_of(result, sweep):
    """Return the levels of a sweep in rising order, including the default one."""
    default = {DEFAULT_LEVEL[sweep]} if sweep in DEFAULT_LEVEL else set()
    return sorted({*result.levels("level", sweep=sweep), *default})


def at(result, sweep, level, name):
    """Return values (sets,) of a level."""
    if DEFAULT_LEVEL.get(sweep) == level:
        sweep, level = "default", DEFAULT_MM
    return result.select(sweep=sweep, level=level).column(name)


def points_of(result):
    """Return every (sweep, level) once; the sweeps share the default."""
    return list(dict.fromkeys((c["sweep"], c["level"]) for c in result.conditions))


def residuals(result, sweep, level, method, taken=PRIMARY):
    """Return RMS residuals (sets,) in mm; infinite where the method failed.

    Against the true corners: RMS errors in px.
    """
    measured = taken["second_grid_pictures"]
    if taken["corner_measure"] == BY_TRUTH:
        measured = "off_px"
    name = f"{taken['exposure']}.{taken['corner_window']}.{measured}.{method}"
    return with_worst(at(result, sweep, level, name))


def tie_width(result, sweep, level, taken=PRIMARY):
    """Return the spread of the floor; residuals that differ by no more are a tie.

    It is the range over the sets of the residual of true corners. Compared with the
    true corners there is no floor, and no tie.
    """
    return np.ptp(residuals(result, sweep, level, TRUE, taken))


def errors(result, sweep, level, method, exposure=WITHIN):
    """Return RMS errors (sets,) in px of the corners found, by the true corners."""
    return at(result, sweep, level, f"{exposure}.{ONE_WINDOW}.off_px.{method}")


def lost(result, points, method, taken=PRIMARY):
    """Return the number of corners (points, sets) that a method missed."""
    name = f"{taken['exposure']}.{taken['corner_window']}.lost.{method}"
    return np.array([at(result, sweep, level, name) for sweep, level in points])


def wins(result, points, taken=PRIMARY):
    """Return where (points, sets) the active grid beats or ties both others."""
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
    """Return (sweep, level) of every level of a sweep, including the default one."""
    return [(sweep, level) for level in levels_of(result, sweep)]


def blur_ratios(result, taken=PRIMARY):
    """Return {method: residual at the largest blur over that without (sets,)}."""
    least, *_, most = levels_of(result, "blur")
    return {
        method: residuals(result, "blur", most, method, taken)
        / residuals(result, "blur", least, method, taken)
        for method in METHODS
    }


def blur_tie(result, taken=PRIMARY):
    """Return the difference (sets,) below which `blur_ratios` are a tie."""
    least, *_, most = levels_of(result, "blur")
    sharp = residuals(result, "blur", least, ACTIVE, taken)
    return tie_width(result, "blur", most, taken) / sharp


@numbers("fig_3_15", needs=SWEPT, evidence="rendered")
def numbers_fig_3_15(results):
    """Return the settings of the sweeps as they were run."""
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
    share = wins(result, points_of(result)).mean(axis=0)
    quoted = {
        "won": 100 * np.median(share),
        "won.least": 100 * share.min(),
        "floor": np.median(residuals(result, "distance", DEFAULT_MM, TRUE)),
        "first_lost_noise": _first_lost(result),
    } | {
        f"off.{method}": np.median(errors(result, "distance", DEFAULT_MM, name))
        for method, name in (("active", ACTIVE), ("derivative", DERIVATIVE))
    }
    for name, number in quoted.items():
        value(name, number)


def _first_lost(result):
    """Return the first noise level at which the active grid loses in most sets."""
    for sweep, level in points_along(result, "noise"):
        if np.median(wins(result, [(sweep, level)])[0]) < 1:
            return level
    return "none"


def shares(result, turn, name="share", *, falloff=2, gamma=2.2):
    """Return shares (runs,) of the visible area that are decoded at a rotation.

    name: another value of the trials instead.
    """
    shown = {"falloff_exponent": falloff, "camera_gamma": gamma}
    return result.select(turn_deg=turn, **shown).column(name)
