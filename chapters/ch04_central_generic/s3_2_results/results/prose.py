"""The numbers that the page quotes: medians over all seeds, unless they say else."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results.seeds import (
    BRACKETS,
    CAMERAS,
    CAUSTIC,
    ERRORS,
    REDRAWN,
    RENDERED,
    Seeds,
)
from chapters.shared.bench_noise import FACTOR, WHITE_FACTOR
from chapters.shared.central_sets import FISH, OMNI
from repro.page.reader import value

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
