"""Seeds of section 4.3.2, rendered and redrawn, in one reading and at one noise."""

import numpy as np

from chapters.shared.bench_noise import BENCH, OPTIONS, SWEPT
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import STANDARD_METHODS
from repro.run.readings import Case

RENDERED = "table_4_3_rendered"
REDRAWN = "table_4_3_redrawn"
BRACKETS = "exp_c4_small_misalign"
CAUSTIC = "exp_c4_caustic_floor"
ERRORS = "table_4_3_errors"
SIMULATED = "fig_4_2_redrawn"  # of 4.1.5
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
    """What every seed gives in one reading, at the noise that trials call so.

    Those of the sweep of the factor are redrawn alone; else the rendered ones come
    first. A method that failed has nan.
    """

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.results, self.noise = results, noise

    def rendered(self, camera, key):
        """A value of every rendered set of a camera, (seeds,)."""
        trials = self.results[RENDERED].select(camera=camera)
        return trials.column(f"{self.noise}.{key}")

    def of(self, camera, key):
        """A value of every seed of a camera, (seeds,)."""
        name = f"{self.noise}.{key}"
        redrawn = self.results[REDRAWN].column(name, camera=camera)
        if self.noise in SWEPT.values():
            return redrawn
        return np.concatenate([self.rendered(camera, key), redrawn])

    def both(self, camera, key):
        """A value of the standard method and of CGSP, (2, seeds)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{method}.{key}") for method in methods])

    def ratio(self, camera, key):
        """The standard method over CGSP, (seeds,)."""
        return np.divide(*self.both(camera, key))

    def scatter(self, camera, key):
        """A measure of the scatter of both methods, (2, seeds)."""
        return self.both(camera, f"{self['scatter_rays']}.{key}")

    def disagreement(self, camera, parameters=PARAMETERS):
        """Largest difference of CGSP from the standard method, %, (seeds,)."""
        pairs = [self.both(camera, name) for name in parameters]
        return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)
