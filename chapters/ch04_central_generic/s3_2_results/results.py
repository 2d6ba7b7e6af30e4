"""Section 4.3.2: its seeds in one reading, and the numbers of the prose."""

from itertools import product

import numpy as np

from chapters.shared.bench_noise import BENCH, FACTOR, OPTIONS, SWEPT, WHITE_FACTOR
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


# Before and after adjustment.

# Pairs of ray-point errors (`error_pairs`) of which the first may be smaller.


NOISES = {"": "bench", "lab.": "laboratory"}
RATIOS = (
    ("as_printed.ratio", "as printed", "ray"),
    ("as_printed.ba_ratio", "as printed", "ba"),
    ("well_conditioned.ratio", "well conditioned", "ray"),
)


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}
    brackets, caustic = open_results(BRACKETS), open_results(CAUSTIC)
    errors = open_results(ERRORS).select()
    bench = Seeds(results)
    apart = bench.of(OMNI, "cgsp.share_apart")
    found = {
        **_of_noises(results),
        **{
            f"{prefix}{short}.left_out": 100
            * np.median(Seeds(results, noise=noise).rendered(camera, "left_out"))
            for prefix, noise in NOISES.items()
            for short, camera in CAMERAS.items()
        },
        "omni.true_scatter_mm": np.median(bench.rendered(OMNI, "true_scatter_mm")),
        **{
            f"inside.{method}": int(np.nansum(bench.of(FISH, f"{method}.all.inside")))
            for method in ("as_printed", "cgsp")
        },
        "inside.seeds": len(apart),
        "omni.left_close": 100 * (1 - np.nanmedian(apart)),
        "rendered": len(bench.rendered(OMNI, "rays")),
        "redrawn": results[REDRAWN].trials_per_condition,
        **{
            f"bracket.{offset}": np.median(
                brackets.select(offset_mm=offset).column("cgsp.ray_mean_mm")
            )
            for offset in (0, 1)
        },
        **{
            f"caustic.{key}": np.median(caustic.column(key))
            for key in ("scatter_mm", "caustic_mm")
        },
        "omni.errors.bias_mm_rms": errors.column("bias_mm_rms")[0],
        "factor": FACTOR,
        "factor.white": WHITE_FACTOR,
    }
    for name, number in found.items():
        value(name, number)


def _of_noises(results):
    """Ratios of ray-point errors, and errors of centres, at both noises."""
    found = {}
    for (prefix, noise), (short, camera) in product(NOISES.items(), CAMERAS.items()):
        for name, option, stage in RATIOS:
            seeds = Seeds(results, {"standard_method": option}, noise)
            ratio = seeds.ratio(camera, f"{stage}_mean_mm")
            found[f"{prefix}{short}.{name}"] = np.nanmedian(ratio)
        for method, key in product(
            ("as_printed", "well_conditioned", "cgsp"), ("centre_off_mm", "ray_mean_mm")
        ):
            errors = Seeds(results, noise=noise).of(camera, f"{method}.{key}")
            found[f"{prefix}{short}.{method}.{key}"] = np.nanmedian(errors)
    return found
