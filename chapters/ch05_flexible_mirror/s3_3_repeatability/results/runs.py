"""The runs out and back: result, error level and step."""

from typing import ClassVar

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import LOOP, OUT
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns
from raxel.calibration.mirror.edges import SWINGING_DEG

RUNS, SWEPT_RUNS, OTHER = "table_5_5_runs", "table_5_5_swept", "table_5_5_other"
JUDGED = ("table_5_5_runs", "table_5_5_swept")
PLACED, STARTED = "exp_c5_dense_grid", "exp_c5_not_sensitive_init"
STEPS = tuple(range(1, len(LOOP)))
THERE, BACK = STEPS[:OUT], STEPS[OUT:]
# Steps out, each with the step back that reverses it.
EQUIVALENT = tuple(zip(THERE, reversed(BACK), strict=True))
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
WHOLE_MM = STAGES_MM[-1] - STAGES_MM[0]
SCALE = 10  # of the vectors of Fig. 5.13
PANELS = {
    "start": "(a) stage 0, before",
    "step3": "(b) stage 3, three steps",
    "step6": "(c) stage 0, six steps",
    "single": "(d) stage 0, three and one",
}


class LoopRuns(BenchRuns):
    """The loop out and back, and the single step back."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"B": OTHER}
    SWINGS = tuple(f"step{step}" for step in STEPS)

    def goes_on(self, place):
        """Extends that of all runs; the single step starts after the third step."""
        if place != "single":
            return super().goes_on(place)
        on = super().goes_on(f"step{THERE[-1]}")
        swings = self.raw("single.swing_deg") >= SWINGING_DEG
        return on & ~(swings & self["swinging_ends"])

    def of(self, place, name):
        """A value (seeds,): place is "start", "step1" to "step6", or "single"."""
        return self.at_place(place, name)

    @property
    def completed(self):
        """Which runs (seeds,) completed all six steps."""
        return np.isfinite(self.of(f"step{STEPS[-1]}", "back_mm"))

    def at(self, name, steps=STEPS):
        """A value (steps, seeds) of several steps."""
        return np.array([self.of(f"step{step}", name) for step in steps])

    def refused(self):
        """Numbers of runs without the sixth step, and without the single step."""
        ends = self.of(f"step{STEPS[-1]}", "back_mm"), self.of("single", "back_mm")
        return tuple(int(np.isnan(end).sum()) for end in ends)

    def drawn(self, place):
        """Board corners and their errors (N, 2), mm, in the first completed run."""
        whole = np.isfinite(self.of("single", "back_mm"))
        seed = int(np.flatnonzero(whole)[0])
        before = np.isfinite(self.raw(f"{place}.back_mm"))[:seed].sum()
        name = f"{self.bench}.{place}.own"
        board = self.result.arrays(f"{self.bench}.board_mm")[0]
        return board, self.result.arrays(name)[before], seed
