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
    brackets, caustic = open_results(BRACKETS), open_results(CAUSTIC)
    bias = open_results(ERRORS).select().column("bias_mm_rms")
    apart = by_seed(results, OMNI, "cgsp.share_apart")

    def median_ratio(camera, option, stage):
        reading = {"standard_method": option}
        return np.nanmedian(ratio(results, camera, reading, f"{stage}_mean_mm"))

    found = {
        **{
            f"{short}.left_out": 100
            * np.median(rendered_seeds(results, camera, "left_out"))
            for short, camera in CAMERAS.items()
        },
        **{
            f"{short}.{name}": median_ratio(camera, option, stage)
            for short, camera in CAMERAS.items()
            for name, option, stage in (
                ("as_printed.ratio", "as printed", "ray"),
                ("as_printed.ba_ratio", "as printed", "ba"),
                ("well_conditioned.ratio", "well conditioned", "ray"),
            )
        },
        **{
            f"{short}.{method}.centre_mm": np.nanmedian(
                by_seed(results, camera, f"{method}.centre_off_mm")
            )
            for short, camera in CAMERAS.items()
            for method in ("well_conditioned", "cgsp")
        },
        "omni.true_scatter_mm": np.median(
            rendered_seeds(results, OMNI, "true_scatter_mm")
        ),
        **{
            f"inside.{method}": int(
                np.nansum(by_seed(results, FISH, f"{method}.all.inside"))
            )
            for method in ("as_printed", "cgsp")
        },
        "inside.seeds": len(apart),
        "omni.left_close": 100 * (1 - np.nanmedian(apart)),
        "rendered": len(rendered_seeds(results, OMNI, "rays")),
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
        "omni.errors.bias_mm_rms": bias[0],
    }
    for name, number in found.items():
        value(name, number)
