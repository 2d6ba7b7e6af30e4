"""The runs of three deflections: which result, which error level, which stage."""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS = "table_5_1_runs", "table_5_1_swept"
OTHER, LONGER = "table_5_1_other", "table_5_1_longer"
JUDGED = ("table_5_1_runs", "table_5_1_swept", "table_5_1_longer")
RENDERED = "table_5_1_rendered"
TIPS, TIPS_SWEPT = "exp_c5_extrapolated_tip", "exp_c5_extrapolated_tip_swept"
STAGES, DEFLECTED = (0, 1, 2, 3), (1, 2, 3)
LAST = DEFLECTED[-1]
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
# Of the translation stages that deflect the mirror.
RESOLUTION_MM = 0.01
SHIFT_MM = 100.0  # of the monitor, on its stage
# In Fig. 5.12, before calibration and after.
SCALES = (5, 30)
# Strips along the mirror's edges, shares of its length and width: one of five knot
# intervals.
STRIP = 0.2


class Runs(BenchRuns):
    """Three deflections."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"B": OTHER, "C": LONGER}
    SWINGS = tuple(f"stage{k}" for k in DEFLECTED)

    def of(self, stage, name):
        """A value (seeds,) of one stage."""
        return self.at_place(f"stage{stage}", name)

    def linear(self):
        """Linear estimates, mm (stages, seeds), also of rejected stages."""
        places = ["stage0", *self.SWINGS]
        return np.array(
            [
                np.where(self.goes_on(before), self.raw(f"{place}.linear_mm"), np.nan)
                for before, place in pairwise(places)
            ]
        )

    def at(self, name, stages=DEFLECTED):
        """A value (stages, seeds) of several stages."""
        return np.array([self.of(stage, name) for stage in stages])

    def refused(self):
        """Code of the rejection of each run (seeds,), None for completed ones; swinging
        ends do not count."""
        return self.result.texts(f"{self.bench}.refused")

    def each(self, stage, names, measure, count):
        """Return measure(*arrays of these names), `count` numbers, at one stage.

        Shape (count, seeds), nan where a run was rejected.
        """
        every = [
            self.result.arrays(f"{self.bench}.stage{stage}.{name}") for name in names
        ]
        rows = [measure(*arrays) for arrays in zip(*every, strict=True)]
        known = np.isfinite(self.raw(f"stage{stage}.angle_deg"))
        found = np.full((count, self.seeds), np.nan)
        # Where all runs were rejected there is no row.
        found[:, known] = np.reshape(rows, (-1, count)).T
        return np.where(self.goes_on(f"stage{stage}"), found, np.nan)

    def drawn(self, stage, name, which=0):
        """An array of one stage of one of the completed runs."""
        whole = self.at("angle_deg", STAGES)
        seed = np.flatnonzero(np.isfinite(whole).all(axis=0))[which]
        before = np.isfinite(self.raw(f"stage{stage}.angle_deg"))[:seed].sum()
        return self.result.arrays(f"{self.bench}.stage{stage}.{name}")[before]


def of_strips(sheet):
    """Whether points (N, 2) of the sheet are in the strip of the clamped edge, and
    whether in one of the three free strips only: (N,), (N,) bool."""
    along, across = np.transpose(sheet)
    clamped = along < STRIP
    beside = np.abs(across - 0.5) > 0.5 - STRIP
    return clamped, ~clamped & (beside | (along > 1 - STRIP))


def strip_means(off, sheet):
    """Means of angles (N,) at points (N, 2): clamped strip, all, free strips."""
    known = np.isfinite(off)
    clamped, free = of_strips(sheet)
    return [np.mean(off[known & which]) for which in (clamped, known, free)]
