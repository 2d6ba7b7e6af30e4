"""How large a step several numbers of knots bear, and how near they come."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.trials.knots import SHAPES, STEPS_MM
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.judge.statistics import median_interval

KNOTS = "exp_c5_knot_tradeoff"
MOST_DEG = 1.0


class Knots(NamedTuple):
    """The trials of one step with several numbers of knots."""

    trials: object

    @classmethod
    def of(cls, results):
        """From the Results, by name."""
        return cls(results[KNOTS].select(geometry="A"))

    def angles(self, shape):
        """Mean ray errors (seeds, steps), degrees, NaN where refused."""
        return np.array(self.trials.arrays(f"{name_of(shape)}.angles_deg"))

    def shares(self, shape):
        """Share (steps,) of the seeds with a mean ray error below MOST_DEG."""
        with np.errstate(invalid="ignore"):
            return np.mean(self.angles(shape) < MOST_DEG, axis=0)

    def largest_step(self, shape):
        """The largest step, mm, with nine of ten seeds below MOST_DEG, 0 if none."""
        borne = np.array(STEPS_MM)[self.shares(shape) >= SHARE_OF_SEEDS]
        return float(borne.max(initial=0.0))

    def refused_percent(self):
        """How many of all that are not below MOST_DEG were refused, percent."""
        angles = np.stack([self.angles(shape) for shape in SHAPES])
        with np.errstate(invalid="ignore"):
            others = angles[~(angles < MOST_DEG)]
        return 100 * float(np.mean(np.isnan(others))) if others.size else 0.0

    def noise_free(self, shape):
        """Estimate of the shape's median error without noise, mm."""
        return median_interval(self.trials.column(f"{name_of(shape)}.noise_free_mm"))
