"""What the correction experiments left, in one reading and at one noise."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.protocol import METHODS
from chapters.shared.bench_noise import BENCH, OPTIONS
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import with_worst
from repro.run.readings import Case

BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"},
}


class Corrected(Case):
    """Trials of one experiment in one reading, at the noise that trials call so."""

    def __init__(self, result, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.result, self.noise = result, noise

    def of(self, camera, name):
        """A value of every trial of a camera, (trials,)."""
        return self.result.select(camera=camera).column(f"{self.noise}.{name}")

    def both(self, camera, name):
        """A value of the standard method and of CGSP, (2, trials)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{m}.{name}") for m in methods])

    def ratio(self, camera, name):
        """Standard over CGSP, (trials,); a failed standard run counts as the worst."""
        standard, cgsp = self.both(camera, name)
        return with_worst(standard) / cgsp
