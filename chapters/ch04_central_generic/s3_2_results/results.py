"""Section 4.3.2: the runs in one interpretation, and the numbers of the text."""

import numpy as np

from chapters.shared.bench_noise import BENCH, FACTOR, OPTIONS, SWEPT
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import STANDARD_METHODS
from repro.page.reader import value
from repro.run.readings import Case

RENDERED = "table_4_3_rendered"
REDRAWN = "table_4_3_redrawn"
BRACKETS = "exp_c4_small_misalign"
CAUSTIC = "exp_c4_caustic_floor"
ERRORS = "table_4_3_errors"

SEEDS_OF_BOTH = ("table_4_3_rendered", "table_4_3_redrawn")
SCATTER = {"all rays": "all", "rays whose points lie apart": "apart"}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": STANDARD_METHODS,
    "scatter_rays": SCATTER,
}
CAMERAS = {"omni": OMNI, "fish": FISH}
PARAMETERS = ("cx", "cy", "cz", "r2", "t2", "r3", "t3")
UNITS = dict.fromkeys(PARAMETERS, "mm") | {"r2": "deg", "r3": "deg"}


class Seeds(Case):
    """Values of all runs in one interpretation, at one noise level of the trials.

    The sweep of the factor has redrawn runs only. Otherwise the rendered runs come
    first. A method that failed has nan.
    """

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.results, self.noise = results, noise

    def rendered(self, camera, key):
        """Return a value of each rendered run of a camera, (runs,)."""
        trials = self.results[RENDERED].select(camera=camera)
        return trials.column(f"{self.noise}.{key}")

    def of(self, camera, key):
        """Return a value of each run of a camera, (runs,)."""
        name = f"{self.noise}.{key}"
        redrawn = self.results[REDRAWN].column(name, camera=camera)
        if self.noise in SWEPT.values():
            return redrawn
        return np.concatenate([self.rendered(camera, key), redrawn])

    def both(self, camera, key):
        """Return a value of the standard method and of CGSP, (2, runs)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{method}.{key}") for method in methods])

    def ratio(self, camera, key):
        """Return the ratio of the standard method to CGSP, (runs,)."""
        return np.divide(*self.both(camera, key))

    def scatter(self, camera, key):
        """Return a measure of the scatter of both methods, (2, runs)."""
        return self.both(camera, f"{self['scatter_rays']}.{key}")

    def disagreement(self, camera, parameters=PARAMETERS):
        """Return the largest difference of CGSP from the standard, %, (runs,)."""
        pairs = [self.both(camera, name) for name in parameters]
        return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)


def name_values(open_results):
    """Name the numbers that the text quotes."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}

    def ratio(camera, method, noise=BENCH):
        seeds = Seeds(results, {"standard_method": method}, noise)
        return np.nanmedian(seeds.ratio(camera, "ray_mean_mm"))

    rejected = Seeds(results).rendered(OMNI, "left_out")
    found = {
        "omni.well_conditioned.ratio": ratio(OMNI, "well conditioned"),
        "fish.well_conditioned.ratio": ratio(FISH, "well conditioned"),
        "lab.omni.as_printed.ratio": ratio(OMNI, "as printed", "laboratory"),
        "omni.left_out": 100 * np.median(rejected),
        "redrawn": results[REDRAWN].trials_per_condition,
        "factor": FACTOR,
    }
    for name, number in found.items():
        value(name, number)
