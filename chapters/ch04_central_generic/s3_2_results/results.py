"""Seeds of section 4.3.2, rendered and redrawn, and what the page quotes of them."""

import numpy as np

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
READINGS = {"standard_method": STANDARD_METHODS, "scatter_rays": SCATTER}
CAMERAS = {"omni": OMNI, "fish": FISH}
PARAMETERS = ("cx", "cy", "cz", "r2", "t2", "r3", "t3")
UNITS = dict.fromkeys(PARAMETERS, "mm") | {"r2": "deg", "r3": "deg"}


def rendered_seeds(results, camera, key):
    """A value of every rendered set of a camera, (seeds,)."""
    return results[RENDERED].select(camera=camera).column(key)


def by_seed(results, camera, key):
    """A value of every seed, those rendered first; nan where a method failed."""
    redrawn = results[REDRAWN].column(key, camera=camera)
    return np.concatenate([rendered_seeds(results, camera, key), redrawn])


def both(results, camera, options, key):
    """A value of the standard method and of CGSP in one reading, (2, seeds)."""
    methods = Case(READINGS, options)["standard_method"], "cgsp"
    return np.array([by_seed(results, camera, f"{method}.{key}") for method in methods])


def ratio(results, camera, options, key):
    """The standard method over CGSP, (seeds,)."""
    return np.divide(*both(results, camera, options, key))


def scatter(results, camera, options, key):
    """A measure of the scatter of both methods, (2, seeds)."""
    rays = Case(READINGS, options)["scatter_rays"]
    return both(results, camera, options, f"{rays}.{key}")


def disagreement(results, camera, options, parameters=PARAMETERS):
    """Largest difference of CGSP from the standard method, in %, by seed, (seeds,)."""
    pairs = [both(results, camera, options, name) for name in parameters]
    return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)


def name_values(open_results):
    """Name the numbers of the prose: medians over all seeds, unless they say else."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}
    for short, camera in CAMERAS.items():
        left_out = rendered_seeds(results, camera, "left_out")
        value(f"{short}.left_out", 100 * float(np.median(left_out)))
        for option, stage, name in (
            ("as printed", "ray", "ratio"),
            ("as printed", "ba", "ba_ratio"),
            ("well conditioned", "ray", "ratio"),
        ):
            reading = {"standard_method": option}
            found = ratio(results, camera, reading, f"{stage}_mean_mm")
            standard = STANDARD_METHODS[option]
            value(f"{short}.{standard}.{name}", float(np.nanmedian(found)))
    true = rendered_seeds(results, OMNI, "true_scatter_mm")
    value("omni.true_scatter_mm", float(np.median(true)))
    for method in ("as_printed", "cgsp"):
        inside = by_seed(results, FISH, f"{method}.all.inside")
        value(f"inside.{method}", int(np.nansum(inside)))
    value("inside.seeds", len(inside))
    apart = by_seed(results, OMNI, "cgsp.share_apart")
    value("omni.left_close", 100 * float(1 - np.nanmedian(apart)))
    value("rendered", len(rendered_seeds(results, OMNI, "rays")))
    value("redrawn", results[REDRAWN].trials_per_condition)
    brackets = open_results(BRACKETS)
    for offset in (0, 1):
        found = brackets.select(offset_mm=offset).column("cgsp.ray_mean_mm")
        value(f"bracket.{offset}", float(np.median(found)))
    caustic = open_results(CAUSTIC)
    for key in ("scatter_mm", "caustic_mm"):
        value(f"caustic.{key}", float(np.median(caustic.column(key))))
    bias = open_results(ERRORS).select().column("bias_mm_rms")
    value("omni.errors.bias_mm_rms", float(bias[0]))
