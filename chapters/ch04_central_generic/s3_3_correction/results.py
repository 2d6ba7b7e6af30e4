"""Results of section 4.3.2b in one interpretation, and the numbers of the text."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.calibrations import METHODS
from chapters.shared.bench_noise import BENCH, OPTIONS
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import with_worst
from repro.page.reader import value
from repro.run.readings import Case

BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"},
}


class Corrected(Case):
    """Trials of one experiment in one interpretation, at one noise level."""

    def __init__(self, result, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.result, self.noise = result, noise

    def of(self, camera, name):
        """Return a value of each trial of a camera, (trials,)."""
        return self.result.select(camera=camera).column(f"{self.noise}.{name}")

    def both(self, camera, name):
        """Return a value of the standard method and of CGSP, (2, trials)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{m}.{name}") for m in methods])

    def ratio(self, camera, name):
        """Return standard over CGSP, (trials,); a failed standard run is the worst."""
        standard, cgsp = self.both(camera, name)
        return with_worst(standard) / cgsp


def name_values(open_results):
    """Name the numbers that the text quotes: medians of the trials with a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)

    def median(result, noise, camera, name):
        return np.nanmedian(Corrected(result, noise=noise).of(camera, name))

    cameras = {"omni": OMNI, "fish": FISH}
    for short, camera in cameras.items():
        for method in ("printed", "cgsp"):
            mean = median(boards, "laboratory", camera, f"{method}.mean_mm")
            value(f"lab.{short}.{method}.mean", mean)
        worst = median(lines, BENCH, camera, "cgsp.worst_share")
        value(f"{short}.cgsp.worst", 100 * worst)
