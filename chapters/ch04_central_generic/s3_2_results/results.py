"""Seeds of section 4.3.2, rendered and redrawn, and what the page quotes of them."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.shared.central_sets import FISH, OMNI
from repro.judge.statistics import median_interval
from repro.page.reader import value
from repro.run.outcomes import Measured

RENDERED = "table_4_3_rendered"
REDRAWN = "table_4_3_redrawn"
BRACKETS = "exp_c4_small_misalign"
CAUSTIC = "exp_c4_caustic_floor"
ERRORS = "table_4_3_errors"
SEEDS_OF_BOTH = ("table_4_3_rendered", "table_4_3_redrawn")
STANDARD = {"as printed": "as_printed", "well conditioned": "well_conditioned"}
SCATTER = {"all rays": "all", "rays whose points lie apart": "apart"}
QUESTIONS = {"standard_method": tuple(STANDARD), "scatter_rays": tuple(SCATTER)}
NAMES = {
    "as_printed": "standard, as printed",
    "well_conditioned": "standard, well conditioned",
    "cgsp": "CGSP",
}
CAMERAS = {"omni": OMNI, "fish": FISH}
PARAMETERS = ("cx", "cy", "cz", "r2", "t2", "r3", "t3")
UNITS = dict.fromkeys(PARAMETERS, "mm") | {"r2": "deg", "r3": "deg"}


def cases(*questions):
    """Every combination of options of the questions, as dicts."""
    return [
        dict(zip(questions, chosen, strict=True))
        for chosen in product(*(QUESTIONS[q] for q in questions))
    ]


def rendered_seeds(results, camera, key):
    """A value of every rendered set of a camera, (seeds,)."""
    result = results[RENDERED]
    return np.array(
        [
            result.column(key, **condition)[0]
            for condition in result.conditions
            if condition["camera"] == camera
        ]
    )


def by_seed(results, camera, key):
    """A value of every seed, those rendered first; nan where a method failed."""
    redrawn = results[REDRAWN].column(key, camera=camera)
    return np.concatenate([rendered_seeds(results, camera, key), redrawn])


def measured(values):
    """Median and its interval of seeds (n,), for a cell of a table."""
    return Measured(*median_interval(values)[:3])


def disagreement(results, camera, standard):
    """Largest difference of CGSP from a standard method, in %, by seed, (seeds,)."""
    pairs = [
        [by_seed(results, camera, f"{m}.{name}") for m in (standard, "cgsp")]
        for name in PARAMETERS
    ]
    return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)


def name_values(open_results):
    """Name the numbers of the prose: medians over all seeds, unless they say else."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}
    for short, camera in CAMERAS.items():
        left_out = rendered_seeds(results, camera, "left_out")
        value(f"{short}.left_out", 100 * float(np.median(left_out)))
        for standard, key, name in (
            ("as_printed", "ray_mean_mm", "ratio"),
            ("as_printed", "ba_mean_mm", "ba_ratio"),
            ("well_conditioned", "ray_mean_mm", "ratio"),
        ):
            a, b = (
                by_seed(results, camera, f"{method}.{key}")
                for method in (standard, "cgsp")
            )
            value(f"{short}.{standard}.{name}", float(np.nanmedian(a / b)))
    scatter = rendered_seeds(results, OMNI, "true_scatter_mm")
    value("omni.true_scatter_mm", float(np.median(scatter)))
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
        found = bracket_errors(brackets, offset)
        value(f"bracket.{offset}", float(np.median(found)))
    caustic = open_results(CAUSTIC)
    for key in ("scatter_mm", "caustic_mm"):
        value(f"caustic.{key}", float(np.median(caustic.column(key))))
    errors = open_results(ERRORS)
    bias = errors.column("bias_mm_rms", **errors.conditions[0])[0]
    value("omni.errors.bias_mm_rms", float(bias))


def bracket_errors(result, offset, key="cgsp.ray_mean_mm"):
    """A value of every rendered set of one misalignment, (seeds,)."""
    return np.array(
        [
            result.column(key, **condition)[0]
            for condition in result.conditions
            if condition["offset_mm"] == offset
        ]
    )
