"""Runs of 5.3.4: result, error level, stage and camera."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import PLACES
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_sweep import BenchRuns

RUNS, SWEPT_RUNS = "table_5_6_runs", "table_5_6_swept"
PICTURES = "fig_5_14_pictures"
JUDGED = ("table_5_6_runs", "table_5_6_swept")
STAGES = tuple(range(len(STAGES_MM)))
# Magnification of the residuals in Figs. 5.14 to 5.17.
SCALE = 50
FIRST, LAST = 1, STAGES[-1]
# Mirror that corrects: the true one, and that of the published calibration.
WAYS = {"true": "true mirror", "published": "stage by stage"}


class CircleRuns(BenchRuns):
    """Circle and face of every run at one error level."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def of(self, stage, name, way="published"):
        """A value (seeds,) of one stage, nan where a run was rejected before."""
        return self.result.column(f"{self.bench}.{way}.stage{stage}.{name}")

    def at(self, name, way="published", stages=STAGES):
        """A value (stages, seeds) of several stages."""
        return np.array([self.of(stage, name, way) for stage in stages])

    def face(self, name, camera="calibrated"):
        """A value (seeds,) of the face."""
        return self.result.column(f"{self.bench}.face.{camera}.{name}")

    def came_to(self, stage, way="published"):
        """Number of runs with a circle at a stage."""
        return int(np.isfinite(self.of(stage, "radius_mm", way)).sum())

    def refused(self):
        """Number of runs that ended before the last stage."""
        return self._codes("refused")

    def face_refused(self):
        """Number of runs without a camera for the face."""
        return self._codes("face.refused")

    def _codes(self, name):
        codes = self.result.texts(f"{self.bench}.{name}")
        return sum(code is not None for code in codes)

    def profiles(self, stage):
        """Residuals (seeds, PLACES) mm around the circle, outwards.

        nan where a run was rejected and where a point is not visible.
        """
        known = np.isfinite(self.of(stage, "radius_mm"))
        found = np.full((self.seeds, PLACES), np.nan)
        arrays = self.result.arrays(f"{self.bench}.published.stage{stage}.profile")
        if known.any():
            found[known] = arrays
        return found


class PictureRuns(CircleRuns):
    """Runs with rendered images; all are at the primary level."""

    EXPERIMENTS = (PICTURES, PICTURES)

    def drawn(self):
        """(way, run) of the figures: the first run calibrated at all stages.

        The first run of the true mirror where there is none.
        """
        came = np.flatnonzero(np.isfinite(self.of(LAST, "radius_mm")))
        return ("published", int(came[0])) if len(came) else ("true", 0)

    def array(self, way, stage, name, run):
        """An array of a run that reached the stage."""
        before = self.of(stage, "radius_mm", way)[:run]
        arrays = self.result.arrays(f"{self.bench}.{way}.stage{stage}.{name}")
        return arrays[np.count_nonzero(np.isfinite(before))]

    def picture(self, stage, run):
        """Image of a run at a stage."""
        return self.result.arrays(f"{self.bench}.picture.stage{stage}.grey")[run]

    def corrected(self, run):
        """Image of the last stage, rectified to the board."""
        return self.result.arrays(f"{self.bench}.corrected")[run]
