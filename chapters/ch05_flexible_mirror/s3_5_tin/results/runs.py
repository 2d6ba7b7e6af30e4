"""Runs of the tin with drawn matches: result, error level and mirror."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import ANGLES_DEG, FACES, PAIRS
from chapters.shared.mirror_bench import LEVEL
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS = "table_5_8_runs", "table_5_8_swept"
JUDGED = ("table_5_8_runs", "table_5_8_swept")
PICTURES = "fig_5_22_pictures"
MATCHED = f"{LEVEL}.on_tin"
# The true mirror, and the calibration of the thesis.
WAYS = {"true": "true mirror", "published": "as published"}
PUBLISHED = "published"


class TinRuns(BenchRuns):
    """A tin seen twice."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def of(self, name, way=PUBLISHED):
        """A value (seeds,) of a mirror, nan where a run was rejected."""
        return self.result.column(f"{self.bench}.{way}.{name}")

    def angles(self, way=PUBLISHED):
        """Angles (3, seeds), degrees, of PAIRS."""
        return np.array([self.of(f"angle.{pair}", way) for pair in PAIRS])

    def off(self, way=PUBLISHED):
        """Errors (3, seeds) of the angles, degrees."""
        return self.angles(way) - ANGLES_DEG[:, None]

    def normality(self, way=PUBLISHED, name="qq"):
        """Correlations (3, seeds) with a normal law, of each face."""
        return np.array([self.of(f"{name}.{face}", way) for face in FACES])

    def refused(self, way=PUBLISHED):
        """Code of the error of each run (seeds,) without a tin, None with one."""
        return self.result.texts(f"{self.bench}.{way}.refused")
