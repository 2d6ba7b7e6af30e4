"""Tables 4.2 and 4.3, their numbers, and what misalignment does."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results import (
    BRACKETS,
    CAMERAS,
    NAMES,
    PARAMETERS,
    SCATTER,
    SEEDS_OF_BOTH,
    UNITS,
    bracket_errors,
    by_seed,
    disagreement,
    measured,
    rendered_seeds,
)
from chapters.shared.central_sets import FISH
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

WORDS = {
    "cx": "centre, x (mm)",
    "cy": "centre, y (mm)",
    "cz": "centre, z (mm)",
    "r2": "rotation of grid 2 (deg)",
    "t2": "translation of grid 2 (mm)",
    "r3": "rotation of grid 3 (deg)",
    "t3": "translation of grid 3 (mm)",
}


@table("table_4_2", needs=("table_4_3_rendered",), evidence="rendered")
def table_4_2(results):
    """Centre and poses by every method, and the true ones, of the first set."""
    heads = ["Camera", "Parameter", *NAMES.values(), "true"]
    columns = {head: [] for head in heads}
    for camera in CAMERAS.values():
        for name in PARAMETERS:
            cells = [
                float(rendered_seeds(results, camera, f"{which}.{name}")[0])
                for which in (*NAMES, "true")
            ]
            row = (camera, WORDS[name], *cells)
            for head, cell in zip(heads, row, strict=True):
                columns[head].append(cell)
    return Table(
        columns,
        "Centre of the camera in the frame of the base grid, and how far grids 2 "
        "and 3 are turned and moved against it, of the first rendered set of each "
        "camera. *True* is the point nearest to all rays: neither camera has one "
        "point through which they all pass.",
    )


@table("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def table_4_3(results):
    """Ray-point errors before and after adjustment."""
    columns = {"Camera": [], "Method": []}
    heads = {
        "ray_mean_mm": "Mean (mm)",
        "ray_sd_mm": "SD (mm)",
        "ba_mean_mm": "Mean after BA (mm)",
        "ba_sd_mm": "SD after BA (mm)",
        "centre_off_mm": "Centre off (mm)",
    }
    columns |= {head: [] for head in heads.values()}
    for camera in CAMERAS.values():
        for method, name in NAMES.items():
            columns["Camera"].append(camera)
            columns["Method"].append(name)
            for key, head in heads.items():
                columns[head].append(
                    measured(by_seed(results, camera, f"{method}.{key}"))
                )
    return Table(
        columns,
        "Distances of the points on the three grids from their rays: mean and "
        "standard deviation over all rays of the linear stage, as it comes out and "
        "after the thesis's bundle adjustment (BA), which keeps the centre. *Centre "
        "off*: from the point nearest to the true rays, before adjustment. Medians "
        "over rendered and redrawn seeds with 95 % intervals.",
    )


@table("ext_fig_4_6_measures", needs=SEEDS_OF_BOTH, evidence="rendered")
def ext_fig_4_6_measures(results):
    """What the scatters of Fig. 4.6 are like, over all seeds."""
    heads = {
        "rms_mm": "RMS (mm)",
        "eigenvalues": "Eigenvalue ratio",
        "kurtosis": "Kurtosis off",
        "inside": "Centre in hull (share)",
    }
    columns = {"Camera": [], "Method": [], "Rays": []}
    columns |= {head: [] for head in heads.values()}
    for camera in CAMERAS.values():
        for method, name in NAMES.items():
            for words, which in SCATTER.items():
                columns["Camera"].append(camera)
                columns["Method"].append(name)
                columns["Rays"].append(words)
                for key, head in heads.items():
                    found = by_seed(results, camera, f"{method}.{which}.{key}")
                    cell = measured(found)
                    if key == "inside":
                        cell = float(np.nanmean(found))
                    columns[head].append(cell)
    return Table(
        columns,
        "The scatters of Fig. 4.6 over all seeds: RMS distance from the centre; "
        "smaller over larger eigenvalue of the covariance, 1 for a round one; how "
        "far Mardia's kurtosis is from the 8 of a Gaussian; and in which share of "
        "the seeds the centre lies in the convex hull. Medians with 95 % intervals.",
    )


@table("ext_misalignment", needs=("exp_c4_small_misalign",), evidence="rendered")
def ext_misalignment(results):
    """CGSP on the mirror with brackets more and less off."""
    result = results[BRACKETS]
    offsets = sorted({c["offset_mm"] for c in result.conditions})
    heads = {
        "true_scatter_mm": "Rays from one point, RMS (mm)",
        "cgsp.ray_mean_mm": "Ray-point error (mm)",
        "cgsp.ba_mean_mm": "after BA (mm)",
        "cgsp.centre_off_mm": "Centre off (mm)",
    }
    columns = {"Bracket off (mm)": list(offsets)}
    for key, head in heads.items():
        columns[head] = [
            measured(bracket_errors(result, offset, key)) for offset in offsets
        ]
    return Table(
        columns,
        "CGSP on rendered sets of reduced size of the mirror, with a bracket that is "
        "right, or off by so much. Median and range over the seeds.",
    )


def of_seeds(values, unit):
    """A Value of one number by seed: median and range."""
    return Value(
        float(np.median(values)), (float(np.min(values)), float(np.max(values))), unit
    )


@numbers("table_4_2", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_2(results):
    """Centre and pose magnitudes of the rendered sets, the standard as printed."""
    found = {
        f"t4_2_{short}_{name}_{method}": of_seeds(
            rendered_seeds(results, camera, f"{which}.{name}"), UNITS[name]
        )
        for short, camera in CAMERAS.items()
        for name in PARAMETERS
        for method, which in (("std", "as_printed"), ("cgsp", "cgsp"))
    }
    agree = disagreement(results, FISH, "as_printed")
    return found | {"t4_2_fish_agree": of_seeds(agree, "%")}


@numbers("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_3(results):
    """Ray-point errors over all seeds, the standard as printed."""
    found = {}
    for short, camera in CAMERAS.items():
        for method, which in (("std", "as_printed"), ("cgsp", "cgsp")):
            for stage, key in (("pre", "ray"), ("ba", "ba")):
                for statistic in ("mean", "sd"):
                    values = by_seed(results, camera, f"{which}.{key}_{statistic}_mm")
                    name = f"t4_3_{short}_{method}_{statistic}_{stage}"
                    found[name] = of_seeds(values[np.isfinite(values)], "mm")
        standard, cgsp = (
            by_seed(results, camera, f"{method}.ray_mean_mm")
            for method in ("as_printed", "cgsp")
        )
        ratio = standard / cgsp
        found[f"s4_4_ratio_{short}"] = of_seeds(ratio[np.isfinite(ratio)], "ratio")
    return found
