"""What the sweeps of 3.3.3 found, and the numbers that are quoted."""

from __future__ import annotations

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
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

SWEPT = ("fig_3_15_sweeps",)
SWEEPS = ("distance", "orientation", "blur", "noise")
NEARLY_ALL = 0.9
# Question -> its options in settings.yaml, the primary one first.
QUESTIONS = {
    "corner_window": WINDOWS,
    "second_grid_pictures": SECOND_GRIDS,
    "exposure": EXPOSURES,
}
PRIMARY = {question: options[0] for question, options in QUESTIONS.items()}


def swept(results):
    """The result of the sweeps."""
    return results[SWEPT[0]]


def levels_of(result, sweep):
    """Levels of a sweep in rising order, the default one among them."""
    levels = {c["level"] for c in result.conditions if c["sweep"] == sweep}
    if sweep in DEFAULT_LEVEL:
        levels.add(DEFAULT_LEVEL[sweep])
    return sorted(levels)


def at(result, sweep, level, name):
    """Values (sets,) of a level."""
    if DEFAULT_LEVEL.get(sweep) == level:
        sweep, level = "default", DEFAULT_MM
    return along(result, name, sweep=sweep, level=level)


def along(result, name, **asked):
    """A value (n,) of all conditions that fit, such as every set or seed."""
    return np.concatenate(
        [
            result.column(name, **condition)
            for condition in result.conditions
            if asked.items() <= condition.items()
        ]
    )


def points_of(result):
    """Every (sweep, level) once; the sweeps meet at the default."""
    points = {}
    for condition in result.conditions:
        points[condition["sweep"], condition["level"]] = None
    return list(points)


def residuals(result, sweep, level, method, reading=PRIMARY):
    """RMS residuals (sets,) in mm; infinite where the method failed."""
    window, again = (reading["corner_window"], reading["second_grid_pictures"])
    name = f"{reading['exposure']}.{window}.{again}.{method}"
    found = at(result, sweep, level, name)
    return np.where(np.isnan(found), np.inf, found)


def errors(result, sweep, level, method, exposure=WITHIN):
    """RMS errors (sets,) in px against the true corners, of those found."""
    return at(result, sweep, level, f"{exposure}.{ONE_WINDOW}.off_px.{method}")


def lost(result, sweep, level, method, exposure=WITHIN):
    """How many corners (sets,) a method lost."""
    return at(result, sweep, level, f"{exposure}.{ONE_WINDOW}.lost.{method}")


def wins(result, points, reading=PRIMARY):
    """Where (points, sets) the active grid is no worse than both others."""
    won = []
    for sweep, level in points:
        ours, *theirs = (
            residuals(result, sweep, level, method, reading)
            for method in (ACTIVE, *STATIC)
        )
        won.append(np.isfinite(ours) & (ours <= np.minimum(*theirs)))
    return np.array(won)


def points_along(result, sweep):
    """(sweep, level) of every level of a sweep, the default one among them."""
    return [(sweep, level) for level in levels_of(result, sweep)]


def blur_ratios(result, reading=PRIMARY):
    """Method -> residual at the largest blur over that without (sets,)."""
    least, *_, most = levels_of(result, "blur")
    return {
        method: residuals(result, "blur", most, method, reading)
        / residuals(result, "blur", least, method, reading)
        for method in METHODS
    }


def readings_of(questions):
    """Dictionaries question -> option, all that settings.yaml asks for.

    The exposure is not crossed with the others.
    """
    asked = [{}]
    for question in questions:
        if question != "exposure":
            asked = [
                reading | {question: option}
                for reading in asked
                for option in QUESTIONS[question]
            ]
    within = [reading | {"exposure": WITHIN} for reading in asked]
    primary = {question: PRIMARY[question] for question in questions}
    return [*within, primary | {"exposure": OVER}]


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
    for short, exposure in (("", WITHIN), ("over.", OVER)):
        reading = PRIMARY | {"exposure": exposure}
        share = wins(result, points_of(result), reading).mean(axis=0)
        value(f"{short}won", 100 * float(np.median(share)))
        value(f"{short}won.least", 100 * float(share.min()))
        for method in METHODS:
            off = errors(result, "distance", DEFAULT_MM, method, exposure)
            value(f"{short}off.{_short(method)}", float(np.median(off)))
    floor = residuals(result, "distance", DEFAULT_MM, TRUE)
    value("floor", float(np.median(floor)))
    most = levels_of(result, "noise")[-1]
    value("most_noise", most)
    for method in METHODS:
        off = errors(result, "noise", most, method)
        value(f"noisy.{_short(method)}", float(np.median(off)))
    value("first_lost_noise", _first_lost(result))
    value("sets", len({c["set"] for c in result.conditions}))
    _name_pixels(open_results("ext_active_pixels"))
    _name_viewing(open_results("exp_c3_active_viewing_angle"))


def _short(method):
    names = {ACTIVE: "active", DERIVATIVE: "derivative", SADDLE: "saddle"}
    return names[method]


def _first_lost(result):
    """The first noise at which the active grid loses in most sets."""
    for sweep, level in points_along(result, "noise"):
        if np.median(wins(result, [(sweep, level)])[0]) < 1:
            return level
    return "none"


def _name_pixels(result):
    for steps in (4, 6):
        found = result.column("all_mm", camera_gamma=2.2, steps=steps)
        value(f"pixels.{steps}", float(np.median(found)))


def _name_viewing(result):
    turns = sorted({c["turn_deg"] for c in result.conditions})
    value("turned", turns[-1])
    found = shares(result, turns[-1])
    value("share.turned", 100 * float(np.median(found)))
    for short, turn in (("straight", turns[0]), ("turned", turns[-1])):
        found = shares(result, turn, "sigma_um")
        value(f"sigma.{short}", float(np.median(found)))
    angles = along(result, "largest_angle_deg", turn_deg=turns[-1])
    light = float(np.cos(np.radians(angles.max())) ** 2)
    value("largest_angle", float(np.max(angles)))
    value("light_there", 100 * light)
    value("grey_there", 100 * light ** (1 / 2.2))


def shares(result, turn, name="share", *, falloff=2, gamma=2.2):
    """Shares (seeds,) of the visible area that are decoded at a turn.

    Or another value of the trials, by its name.
    """
    return along(
        result, name, turn_deg=turn, falloff_exponent=falloff, camera_gamma=gamma
    )
