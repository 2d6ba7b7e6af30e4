"""Runs of self-calibration: result, error level and features."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import SCENES
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS = "table_5_9_runs", "table_5_9_swept"
STAGES = (1, 2, 3)
STEP_MM = STAGES_MM[1]
# As 5.4 describes: features across the middle, and near ones at the free end.
THESIS_SCENE = next(iter(SCENES))
OBJECTS = ("plane", "object", "wall")


class Courses(BenchRuns):
    """Three pushes."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def column(self, name):
        """A value (seeds,) of each run, nan where it ended before."""
        return self.result.column(f"{self.bench}.{name}")

    def of(self, way, name, stages=STAGES):
        """A value (stages, seeds) of `board` or one of SCENES."""
        return np.array([self.column(f"{way}.stage{k}.{name}") for k in stages])

    def refused(self, way):
        """Codes (seeds,) of the errors that ended a method, None where none did."""
        return self.result.texts(f"{self.bench}.{way}.refused")

    def arrays(self, name):
        """One array for each run that has it; none where nothing was run."""
        result = self.result
        return result.arrays(f"{self.bench}.{name}") if result.names() else []

    def of_seed(self, name, seed, came, columns=2):
        """Array of one run, where `came` (seeds,) marks the runs that have it.

        One without rows where `seed` is None.
        """
        if seed is None:
            return np.empty((0, columns))
        return self.arrays(name)[np.count_nonzero(came[:seed])]

    def profiles(self, way, stage):
        """Heights (completed runs, places), mm, along the middle line."""
        return self.arrays(f"{way}.stage{stage}.profile_mm")

    def inflected(self, way):
        """Whether the profile has an inflexion (stages 2 and 3, seeds).

        False where a run ended before.
        """
        back = np.zeros((len(STAGES) - 1, self.seeds), bool)
        for row, stage in zip(back, STAGES[1:], strict=True):
            came = np.isfinite(self.column(f"{way}.stage{stage}.angle_deg"))
            row[came] = [bends_back(z) for z in self.profiles(way, stage)]
        return back


def first_seed(*came):
    """Index of the first run for which all conditions hold; None without one."""
    every = np.flatnonzero(np.logical_and.reduce(came))
    return int(every[0]) if len(every) else None


# Fraction of the largest curvature: less of the other sign is no inflexion.
MIN_INFLEXION_RATIO = 0.1
POLYNOMIAL = 5  # degree of the polynomial that is differentiated


def bends_back(heights):
    """Whether a profile (n,), evenly spaced, has an inflexion.

    A tenth or more of its largest curvature has the other sign, in its middle eight
    tenths. False for a profile that the spline does not cover everywhere.
    """
    if not np.isfinite(heights).all():
        return False
    x = np.linspace(-1, 1, len(heights))
    bend = np.polynomial.Polynomial.fit(x, heights, POLYNOMIAL).deriv(2)(0.8 * x)
    return bool(min(-bend.min(), bend.max()) > MIN_INFLEXION_RATIO * np.abs(bend).max())
