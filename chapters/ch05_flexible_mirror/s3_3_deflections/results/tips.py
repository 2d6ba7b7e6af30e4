"""Scatter of the deflection at the load and among the corners."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import TIPS, TIPS_SWEPT
from chapters.shared.mirror_bench import SWEPT
from repro.judge.statistics import bootstrap


class Tips(NamedTuple):
    """One push at one error level, of the completed runs."""

    result: object
    bench: str

    @classmethod
    def on(cls, results, bench):
        """Return the push at a level, or at an end of the sweep, by its name."""
        return cls(results[TIPS_SWEPT if bench in SWEPT else TIPS], bench)

    def of(self, name):
        """A value (seeds,) of the runs that have one."""
        found = self.result.column(f"{self.bench}.{name}")
        return found[np.isfinite(found)]

    @property
    def completed(self):
        """Number of runs with a value."""
        return len(self.of("tip_mm"))

    @property
    def refused(self):
        """Number of runs without a value."""
        return self.result.trials_per_condition - self.completed

    def moments(self, of_surface=False):
        """Errors at the load, and means and mean squares of those among the corners,
        (seeds,) each; of the movement, or of the position after it."""
        prefix = "surface." if of_surface else ""
        return [self.of(prefix + n) for n in ("tip_mm", "mean_mm", "square_mm2")]

    def ratio(self, of_surface=False):
        """SD at the load over that among the corners, Estimate; runs are resampled."""
        return bootstrap(
            lambda tip, mean, square: tip_sd(tip) / among_sd(mean, square),
            *self.moments(of_surface),
            paired=True,
        )


def tip_sd(tip):
    """SD over runs (..., seeds)."""
    return np.std(tip, axis=-1)


def among_sd(mean, square):
    """SD over points and runs together, from each run's mean and mean square."""
    whole = np.mean(square, axis=-1) - np.mean(mean, axis=-1) ** 2
    return np.sqrt(whole)
