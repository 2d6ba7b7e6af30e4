"""Effect of relief at stage 0, and how much of it more functions remove."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.relief import FEW, MANY
from chapters.shared.mirror_runs import shape_name
from repro.judge.statistics import OVER_TRIALS, bootstrap, with_worst

RELIEF = "exp_c5_high_order"
median = OVER_TRIALS["median"]


class ReliefRuns(NamedTuple):
    """Trials with a smooth mirror and with one with relief."""

    trials: object

    @classmethod
    def of(cls, results):
        """Return the trials from the Results, by name."""
        return cls(results[RELIEF].select(geometry="A"))

    def values(self, mirror, shape, name):
        """A measure (seeds,), infinite where rejected."""
        return with_worst(self.trials.column(f"{mirror}.{shape_name(shape)}.{name}"))

    def rise(self, name="back_mm"):
        """Relief over smooth with the fewest functions, ratio of medians, Estimate."""
        pair = (self.values(mirror, FEW, name) for mirror in ("relief", "smooth"))
        return bootstrap(lambda a, b: median(a) / median(b), *pair, paired=True)

    def removed(self, name="back_mm"):
        """Share of the rise that the most functions remove, percent, Estimate."""
        four = (
            self.values(mirror, shape, name)
            for shape in (FEW, MANY)
            for mirror in ("relief", "smooth")
        )
        with np.errstate(invalid="ignore"):
            return bootstrap(_removed, *four, paired=True)


def _removed(rough, smooth, rough_left, smooth_left):
    left = median(rough_left) - median(smooth_left)
    return 100 * (1 - left / (median(rough) - median(smooth)))
