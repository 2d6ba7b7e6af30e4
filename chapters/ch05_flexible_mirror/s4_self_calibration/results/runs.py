"""The courses of self-calibration: which result, which bench, which features."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import SCENES
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS = "table_5_9_runs", "table_5_9_swept"
STAGES = (1, 2, 3)
STEP_MM = STAGES_MM[1]
# As 5.4 tells: features across the middle, and nearer ones at the end that bends.
TOLD = next(iter(SCENES))
OBJECTS = ("plane", "object", "wall")


class Courses(BenchRuns):
    """Three pushes."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def column(self, name):
        """A value (seeds,) that a run has once, nan where it ended before."""
        return self.result.column(f"{self.bench}.{name}")

    def of(self, way, name, stages=STAGES):
        """A value (stages, seeds) of `board` or one of SCENES."""
        return np.array([self.column(f"{way}.stage{k}.{name}") for k in stages])

    def refused(self, way):
        """Codes (seeds,) of the errors that ended a way, None where none did."""
        return self.result.texts(f"{self.bench}.{way}.refused")

    def arrays(self, name):
        """One array for each seed that has it; none where nothing was run."""
        result = self.result
        return result.arrays(f"{self.bench}.{name}") if result.names() else []

    def of_seed(self, name, seed, came, columns=2):
        """An array of one seed, where `came` (seeds,) says which seeds have it; one
        without rows where `seed` is None."""
        if seed is None:
            return np.empty((0, columns))
        return self.arrays(name)[np.count_nonzero(came[:seed])]

    def profiles(self, way, stage):
        """Heights (seeds that came so far, places), mm, along the middle line."""
        return self.arrays(f"{way}.stage{stage}.profile_mm")

    def inflected(self, way):
        """Whether the profile bends back (stages 2 and 3, seeds); false where a seed
        did not come so far."""
        back = np.zeros((len(STAGES) - 1, self.seeds), bool)
        for row, stage in zip(back, STAGES[1:], strict=True):
            came = np.isfinite(self.column(f"{way}.stage{stage}.angle_deg"))
            row[came] = [bends_back(z) for z in self.profiles(way, stage)]
        return back


def first_seed(*came):
    """The first seed that came as far as is asked; None where none did."""
    every = np.flatnonzero(np.logical_and.reduce(came))
    return int(every[0]) if len(every) else None


# Of the largest curvature: less of the other sign is no inflexion.
LEAST_BACK = 0.1
POLYNOMIAL = 5  # degree, of the profile that is differentiated


def bends_back(heights):
    """Whether a profile (n,), evenly spaced, has a tenth or more of its largest
    curvature with the other sign, in its middle eight tenths. One that the spline does
    not reach everywhere is none."""
    if not np.isfinite(heights).all():
        return False
    x = np.linspace(-1, 1, len(heights))
    bend = np.polynomial.Polynomial.fit(x, heights, POLYNOMIAL).deriv(2)(0.8 * x)
    return bool(min(-bend.min(), bend.max()) > LEAST_BACK * np.abs(bend).max())
