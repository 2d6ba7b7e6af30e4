"""Trials that Fig. 5.5 and its claims use, and the numbers that the page quotes."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_1_simulated.trials.scene import LENGTH_MM, rig_of
from chapters.ch05_flexible_mirror.s3_1_simulated.trials.sweeps import (
    BASE,
    DEFAULT,
    SWEEPS,
)
from repro.judge.statistics import OVER_TRIALS, bootstrap, with_worst
from repro.page.reader import value
from repro.run.readings import Case

RESULT = "fig_5_5_sweeps"
READINGS = {
    "averaged_trials": {"mean": "mean", "median": "median"},
    "reduced_curve": {
        "distance along the viewing rays": "distance",
        "height over the clamped line": "height",
    },
    "surface_error": {
        "across the whole mirror": "across_mm",
        "along the rays at the corners": "along_mm",
    },
    "row_before": {"found in the picture before": False, "known": True},
    "pixel_pitch": {
        "half of the MegaPlus": "megaplus",
        "APS-C sensor": "d200",
        "small sensor": "olympus",
        "film frame": "film",
    },
    "corner_rows": {"one row of 14": 1, "13 rows of 14": 13},
    "bend_sense": {"convex": 1, "concave": -1},
    "grid_size": {"fills the view": "fills", "one size": "one size"},
}
NOISY = SWEEPS["noise"][1:]
FAR = [depth for depth in SWEEPS["depth"] if depth >= 3000]
NEAR = [depth for depth in SWEEPS["depth"] if depth <= 3000]
MEAN_OF_BEAM = 3 / 8
"""Mean deflection of the beam (5.1) over that of its tip."""


class CurveCase(Case):
    """One interpretation of 5.3.1, with the primary option of all other questions."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    @property
    def statistic(self):
        """'mean' or 'median' of the trials."""
        return self["averaged_trials"]

    @property
    def method(self):
        """Name of this interpretation's method in the trials."""
        return "known" if self["row_before"] else self["reduced_curve"]

    def column(self, result, sweep, level, name):
        """A value (trials,) of this set-up at a level; nan where failed."""
        number = SWEEPS[sweep].index(level)
        where = {"pitch": self["pixel_pitch"], "rows": self["corner_rows"],
                 "sense": self["bend_sense"], "grid": self["grid_size"]}  # fmt: skip
        return result.column(f"level_{number}.{name}", sweep=sweep, **where)

    def errors(self, result, sweep, level, stage):
        """Surface errors (trials,) of a stage, mm; the worst where one failed."""
        name = f"{self.method}.{stage}.{self['surface_error']}"
        return self._filled(self.column(result, sweep, level, name))

    def missing(self, result, level):
        """Share (trials,) of the tip's deflection that the linear stage misses."""
        name = f"{self.method}.linear.tip_ratio"
        return self._filled(1 - self.column(result, "depth", level, name))

    def _filled(self, trials):
        """Set a failure to infinity for a median, to the worst trial for a mean."""
        if self.statistic == "median" or np.isnan(trials).all():
            return with_worst(trials)
        return with_worst(trials, np.nanmax(trials))

    def along(self, result, sweep, stage, levels=None):
        """Errors of a stage at the levels of a sweep, a list of (trials,)."""
        return [
            self.errors(result, sweep, level, stage)
            for level in levels or SWEEPS[sweep]
        ]


PRIMARY = CurveCase()


def typical(statistic, trials):
    """Mean or median of trials (n,), an Estimate."""
    return bootstrap(OVER_TRIALS[statistic], trials)


def over_levels(statistic, levels, fit):
    """Estimate of a fit to the levels' means or medians; a draw is one of all levels.

    levels: a list of (n,), where trial i has the same grid and noise at all of them;
    fit: (levels, draws) -> (draws,).
    """
    over = OVER_TRIALS[statistic]
    return bootstrap(
        lambda *trials: fit(np.stack([over(t) for t in trials])), *levels, paired=True
    )


def linear_by_formula(depth, tip, pitch=BASE["pitch"]):
    """Mean surface error of the linear stage that an infinite scene costs, mm.

    It finds Z / (Z + D) of the deflection; the beam's mean is 3/8 of that of its tip.
    """
    return MEAN_OF_BEAM * tip * missing_by_formula(depth, pitch)


def missing_by_formula(depth, pitch=BASE["pitch"]):
    """D / (Z + D), the share of the deflection that the linear stage misses."""
    distance = rig_of(pitch).distance_mm
    return distance / (depth + distance)


def curvature(tip):
    """Curvature of the beam (5.1) at its clamp, 1/m."""
    return 3000 * tip / LENGTH_MM**2


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation."""
    result = open_results(RESULT)
    for name, number in quoted(result).items():
        value(name, number)


def quoted(result):
    """Name -> number, of what the prose quotes."""
    default = DEFAULT["depth"]
    return {
        "camera.distance": rig_of(BASE["pitch"]).distance_mm,
        f"ratio.{default:g}": 1 - float(np.mean(PRIMARY.missing(result, default))),
        f"formula.{default:g}": 1 - missing_by_formula(default),
        **{
            f"noise.distance.{level:g}": float(
                np.mean(PRIMARY.errors(result, "noise", level, "final"))
            )
            for level in (0.0, 1.0, 3.0)
        },
    }
