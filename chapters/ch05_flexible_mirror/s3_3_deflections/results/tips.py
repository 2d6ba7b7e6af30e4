"""How much the deflection scatters at the load and among the corners."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import TIPS, TIPS_SWEPT
from chapters.shared.mirror_bench import SWEPT
from repro.judge.statistics import bootstrap


class Tips(NamedTuple):
    """One push on one bench, of the seeds that were not refused."""

    result: object
    bench: str

    @classmethod
    def on(cls, results, bench):
        """That of a bench, or of an end of a sweep, by its name."""
        return cls(results[TIPS_SWEPT if bench in SWEPT else TIPS], bench)

    def of(self, name):
        """A value (seeds,) of those that have one."""
        found = self.result.column(f"{self.bench}.{name}")
        return found[np.isfinite(found)]

    @property
    def completed(self):
        """How many seeds have a value."""
        return len(self.of("tip_mm"))

    @property
    def refused(self):
        """How many seeds have none."""
        return self.result.trials_per_condition - self.completed

    def moments(self, of_surface=False):
        """Errors at the load, and means and mean squares of those among the corners,
        (seeds,) each; of how far the mirror went, or of where it is after."""
        prefix = "surface." if of_surface else ""
        return [self.of(prefix + n) for n in ("tip_mm", "mean_mm", "square_mm2")]

    def ratio(self, of_surface=False):
        """SD at the load over that among the corners, Estimate; a draw is of seeds."""
        return bootstrap(
            lambda tip, mean, square: tip_sd(tip) / among_sd(mean, square),
            *self.moments(of_surface),
            paired=True,
        )


def tip_sd(tip):
    """SD over seeds (..., seeds)."""
    return np.std(tip, axis=-1)


def among_sd(mean, square):
    """SD over places and seeds together, from each seed's mean and mean square."""
    whole = np.mean(square, axis=-1) - np.mean(mean, axis=-1) ** 2
    return np.sqrt(whole)
