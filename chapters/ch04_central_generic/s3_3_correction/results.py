"""What the correction experiments left in one reading, and the prose."""

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


def name_values(open_results):
    """Name the numbers of the prose: medians of the trials that have a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)
    wanted = [
        *(
            (f"{short}.{method}.{name}", result, camera, f"{method}.{key}")
            for short, camera in (("omni", OMNI), ("fish", FISH))
            for method in NAMES
            for name, result, key in (
                ("mean", boards, "mean_mm"),
                ("worst", lines, "worst_share"),
            )
        ),
        *(
            (f"{name}.{method}", result, camera, f"{method}.{key}")
            for name, result, camera, key in (
                ("seam", boards, OMNI, "seam_ratio"),
                ("skew", boards, FISH, "skew_spearman"),
                ("vertical", lines, OMNI, "vertical_deg"),
            )
            for method in ("printed", "cgsp")
        ),
    ]
    found = {
        "omni.boards": int(boards.select(camera=OMNI).column("boards_found").sum()),
        "fish.boards": int(boards.select(camera=FISH).column("boards_found").sum()),
        "trials": lines.trials_per_condition,
    }
    for name, result, camera, key in wanted:
        percent = 100 if name.endswith(".worst") else 1
        for prefix, noise in (("", BENCH), ("lab.", "laboratory")):
            trials = Corrected(result, noise=noise).of(camera, key)
            found[prefix + name] = percent * np.nanmedian(trials)
    for name, number in found.items():
        value(name, number)
