"""Which trials Fig. 5.5 and its claims read, and the numbers that the page quotes."""

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
    """One reading of 5.3.1, with the primary option of what is not asked."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    @property
    def statistic(self):
        """'mean' or 'median' of the trials."""
        return self["averaged_trials"]

    @property
    def method(self):
        """What the trials call the method of this reading."""
        return "known" if self["row_before"] else self["reduced_curve"]

    def column(self, result, sweep, level, name):
        """A value (trials,) of this reading's set-up at a level; nan where failed."""
        number = SWEEPS[sweep].index(level)
        where = {"pitch": self["pixel_pitch"], "rows": self["corner_rows"],
                 "sense": self["bend_sense"], "grid": self["grid_size"]}  # fmt: skip
        return result.column(f"level_{number}.{name}", sweep=sweep, **where)

    def errors(self, result, sweep, level, stage):
        """Surface errors (trials,) of a stage, mm; the worst where one failed."""
        name = f"{self.method}.{stage}.{self['surface_error']}"
        return self._filled(self.column(result, sweep, level, name))

    def missing(self, result, level):
        """Share (trials,) of the tip's deflection that the linear stage leaves out."""
        name = f"{self.method}.linear.tip_ratio"
        return self._filled(1 - self.column(result, "depth", level, name))

    def _filled(self, trials):
        """A failure is infinite in a median, and as the worst trial in a mean."""
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
    """D / (Z + D), the share of the deflection that the linear stage leaves out."""
    distance = rig_of(pitch).distance_mm
    return distance / (depth + distance)


def curvature(tip):
    """Curvature of the beam (5.1) at its clamp, 1/m."""
    return 3000 * tip / LENGTH_MM**2


def name_values(open_results):
    """Name the numbers of the prose, in the primary reading."""
    result = open_results(RESULT)
    for name, number in quoted(result).items():
        value(name, number)


def quoted(result):
    """Name -> number, of what the prose quotes."""
    height = CurveCase({"reduced_curve": "height over the clamped line"})
    at_corners = CurveCase({"surface_error": "along the rays at the corners"})

    def mean(sweep, level, stage, case=PRIMARY):
        return float(np.mean(case.errors(result, sweep, level, stage)))

    def median(sweep, level, name, case=PRIMARY):
        return float(np.nanmedian(case.column(result, sweep, level, name)))

    rig = rig_of(BASE["pitch"])
    ratio = {
        f"ratio.{level:g}": 1 - float(np.mean(PRIMARY.missing(result, level)))
        for level in (400.0, 1650.0, 8000.0)
    }
    final_on_curve = {
        f"{name}.{kind}.{level:g}": mean(sweep, level, "final", case)
        for kind, case in (("distance", PRIMARY), ("height", height))
        for name, sweep, levels in (
            ("noise", "noise", SWEEPS["noise"]),
            ("bend", "bend", (5.0, 53.0)),
            ("depth", "depth", (400.0, 3000.0, 8000.0)),
        )
        for level in levels
    }
    restarts = [
        PRIMARY.column(result, sweep, level, "distance.restart_mm")
        for sweep, levels in SWEEPS.items()
        for level in levels
    ]
    return {
        "camera.distance": rig.distance_mm,
        "camera.pixel_mrad": 1000 * rig.pixel,
        "linear": mean("noise", 1.0, "linear"),
        "linear.formula": linear_by_formula(DEFAULT["depth"], DEFAULT["bend"]),
        "linear.growth": mean("noise", 3.0, "linear") / mean("noise", 0.5, "linear"),
        "final.growth": mean("noise", 3.0, "final") / mean("noise", 0.5, "final"),
        "linear.53": mean("bend", 53.0, "linear"),
        "reach.53": 100 * median("bend", 53.0, "distance.reach"),
        "corners.53": mean("bend", 53.0, "final", at_corners),
        "restart.most": float(np.nanmax(restarts)),
        "slope2": median("noise", 1.0, "slope2"),
        "slope2.most": median("bend", 53.0, "slope2"),
        **{f"formula.{z}": 1 - missing_by_formula(z) for z in (400, 1650, 8000)},
        **ratio,
        **final_on_curve,
    }
