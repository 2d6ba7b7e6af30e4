"""Runs of the moving cylinder: result, error level, camera, method and step."""

from typing import ClassVar

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import STEP_MM, STEPS
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS, LONGER = "table_5_7_runs", "table_5_7_swept", "table_5_7_longer"
JUDGED = ("table_5_7_runs", "table_5_7_swept")
# As in the thesis: calibration stage by stage, and step lengths estimated from rays.
CAMERA, WAY = "published", "open"
CAMERAS = ("true", "published")
EACH_STEP = range(1, STEPS + 1)
STAGES = range(len(STAGES_MM))
LAST = len(STAGES_MM) - 1


class MotionRuns(BenchRuns):
    """Motions of the cylinder."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"C": LONGER}

    def column(self, name):
        """A value (seeds,) that a run has once."""
        return self.result.column(f"{self.bench}.{name}")

    def of(self, name, camera=CAMERA, way=WAY):
        """A value (seeds,) of a camera and a method."""
        return self.column(f"{camera}.{way}.{name}")

    def steps(self, name, camera=CAMERA, way=WAY):
        """A value (5, seeds) after each step, all steps before added up."""
        return np.array([self.of(f"step{k}.{name}", camera, way) for k in EACH_STEP])

    def scales(self, stage):
        """Mean estimated step over the true one, (seeds,), at a stage."""
        own = f"stage{stage}.mean_mm" if stage < LAST else f"{CAMERA}.{WAY}.mean_mm"
        return self.column(own) / STEP_MM

    def refused(self):
        """Code of the error of each run (seeds,) without a motion, None with one."""
        calibration = self.result.texts(f"{self.bench}.refused")
        motion = self.result.texts(f"{self.bench}.{CAMERA}.refused")
        return [a or b for a, b in zip(calibration, motion, strict=True)]

    def drawn_camera(self):
        """The published calibration, the true mirror where that has no cylinder."""
        has = np.isfinite(self.of("radius_mm"))
        return CAMERA if has.any() else "true"

    def middling(self, off):
        """Index of the run with a cylinder whose measure off (seeds,) is the median."""
        has = np.isfinite(self.of("radius_mm", self.drawn_camera()))
        order = np.argsort(np.where(has, off, np.nan))
        return int(order[(np.count_nonzero(has) - 1) // 2])

    def array(self, name, seed):
        """An array of one run, None where it has none."""
        has = self._has(name)
        if not has[seed]:
            return None
        every = self.result.arrays(f"{self.bench}.{name}")
        return every[np.count_nonzero(has[:seed])]

    def _has(self, name):
        """Which runs (seeds,) have an array: those with its number."""
        beside = {"path": "mean_mm", "points": "radius_mm", "cylinder": "radius_mm"}
        owner, last = name.rsplit(".", 1)
        if owner == "marks":
            return np.ones(self.seeds, bool)
        return np.isfinite(self.column(f"{owner}.{beside[last]}"))
