"""Tables 4.2 and 4.3, their numbers, and what misalignment does."""

from dataclasses import replace
from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results.seeds import (
    BRACKETS,
    CAMERAS,
    PARAMETERS,
    SCATTER,
    SEEDS_OF_BOTH,
    UNITS,
    Seeds,
)
from chapters.shared.bench_noise import BENCH
from chapters.shared.central_sets import FISH
from chapters.shared.methods import LINEAR_NAMES
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Measured, Table, Value

WORDS = {
    "cx": "centre, x (mm)",
    "cy": "centre, y (mm)",
    "cz": "centre, z (mm)",
    "r2": "rotation of grid 2 (deg)",
    "t2": "translation of grid 2 (mm)",
    "r3": "rotation of grid 3 (deg)",
    "t3": "translation of grid 3 (mm)",
}
SOLVED = (
    "the factor of the bench's noise was solved from this number: it is near the "
    "printed one by construction"
)
POSES_OF_THE_RIG = (
    "the grids of the rig stand as Table 4.2 has them: this is near the printed "
    "value by construction"
)
# What the ledger's ids call methods and stages.
PRINTED_METHODS = {"std": "as_printed", "cgsp": "cgsp"}
PRINTED_STAGES = {"pre": "ray", "ba": "ba"}


@table("table_4_2", needs=("table_4_3_rendered",), evidence="rendered")
def table_4_2(results):
    """Centre and poses by every method, and the true ones, of the first set."""
    seeds = Seeds(results)
    rows = [
        (
            camera,
            WORDS[name],
            *(
                float(seeds.rendered(camera, f"{which}.{name}")[0])
                for which in (*LINEAR_NAMES, "true")
            ),
        )
        for camera, name in product(CAMERAS.values(), PARAMETERS)
    ]
    printed = {
        LINEAR_NAMES[which]: [
            f"t4_2_{short}_{name}_{method}"
            for short, name in product(CAMERAS, PARAMETERS)
        ]
        for method, which in PRINTED_METHODS.items()
    }
    return Table(
        columns(("Camera", "Parameter", *LINEAR_NAMES.values(), "true"), rows),
        "Centre of the camera in the frame of the base grid, and how far grids 2 "
        "and 3 are turned and moved against it, of the first rendered set of each "
        "camera, at the bench's noise. *True* is the point nearest to all rays: "
        "neither camera has one point through which they all pass.",
        printed=printed,
    )


HEADS = {
    "ray_mean_mm": "Mean (mm)",
    "ray_sd_mm": "SD (mm)",
    "ba_mean_mm": "Mean after BA (mm)",
    "ba_sd_mm": "SD after BA (mm)",
    "centre_off_mm": "Centre off (mm)",
}


def errors_at(results, noise):
    """Columns of Table 4.3 at one noise, medians over all seeds."""
    seeds = Seeds(results, noise=noise)
    rows = [
        (
            camera,
            LINEAR_NAMES[method],
            *(Measured.median(seeds.of(camera, f"{method}.{key}")) for key in HEADS),
        )
        for camera, method in product(CAMERAS.values(), LINEAR_NAMES)
    ]
    return columns(("Camera", "Method", *HEADS.values()), rows)


@table("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def table_4_3(results):
    """Ray-point errors before and after adjustment, at the bench's noise."""
    known = {which: method for method, which in PRINTED_METHODS.items()}
    printed = {
        HEADS[f"{key}_{statistic}_mm"]: [
            f"t4_3_{short}_{known[which]}_{statistic}_{stage}"
            if which in known
            else None
            for short, which in product(CAMERAS, LINEAR_NAMES)
        ]
        for stage, key in PRINTED_STAGES.items()
        for statistic in ("mean", "sd")
    }
    return Table(
        errors_at(results, BENCH),
        "Distances of the points on the three grids from their rays: mean and "
        "standard deviation over all rays of the linear stage, as it comes out and "
        "after the thesis's bundle adjustment (BA), which keeps the centre. *Centre "
        "off*: from the point nearest to the true rays, before adjustment. Medians "
        "over rendered and redrawn seeds with 95 % intervals, with decoding errors "
        "as large as the bench's. CGSP's mean on the omnidirectional camera was set "
        "by their factor.",
        printed=printed,
    )


@table("ext_table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def ext_table_4_3(results):
    """The same with the laboratory's own decoding errors."""
    return Table(
        errors_at(results, "laboratory"),
        "Table 4.3 with the laboratory's own decoding errors, about a fifth of the "
        "bench's.",
    )


@table("ext_fig_4_6_measures", needs=SEEDS_OF_BOTH, evidence="rendered")
def ext_fig_4_6_measures(results):
    """What the scatters of Fig. 4.6 are like, over all seeds."""
    heads = {
        "rms_mm": "RMS (mm)",
        "eigenvalues": "Eigenvalue ratio",
        "kurtosis": "Kurtosis off",
    }
    rows = []
    seeds = Seeds(results)
    for camera, method, words in product(CAMERAS.values(), LINEAR_NAMES, SCATTER):
        of_rays = f"{method}.{SCATTER[words]}"
        measures = [seeds.of(camera, f"{of_rays}.{key}") for key in heads]
        inside = float(np.nanmean(seeds.of(camera, f"{of_rays}.inside")))
        cells = (*map(Measured.median, measures), inside)
        rows.append((camera, LINEAR_NAMES[method], words, *cells))
    names = ("Camera", "Method", "Rays", *heads.values(), "Centre in hull (share)")
    return Table(
        columns(names, rows),
        "The scatters of Fig. 4.6 over all seeds, at the bench's noise: RMS distance "
        "from the centre; smaller over larger eigenvalue of the covariance, 1 for a "
        "round one; how far Mardia's kurtosis is from the 8 of a Gaussian; and in "
        "which share of the seeds the centre lies in the convex hull. Medians with "
        "95 % intervals.",
    )


@table("ext_misalignment", needs=("exp_c4_small_misalign",), evidence="rendered")
def ext_misalignment(results):
    """CGSP on the mirror with brackets more and less off."""
    heads = {
        "true_scatter_mm": "Rays from one point, RMS (mm)",
        "cgsp.ray_mean_mm": "Ray-point error (mm)",
        "cgsp.ba_mean_mm": "after BA (mm)",
        "cgsp.centre_off_mm": "Centre off (mm)",
    }
    rows = [
        (offset, *(Measured.median(seeds.column(key)) for key in heads))
        for offset, seeds in results[BRACKETS].by("offset_mm").items()
    ]
    return Table(
        columns(("Bracket off (mm)", *heads.values()), rows),
        "CGSP on rendered sets of reduced size of the mirror, with a bracket that is "
        "right, or off by so much. Median and range over the seeds.",
    )


@numbers("table_4_2", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_2(results):
    """Centre and pose magnitudes of the rendered sets, the standard as printed."""
    seeds = Seeds(results)
    found = {
        f"t4_2_{short}_{name}_{method}": Value.of_seeds(
            seeds.rendered(camera, f"{which}.{name}"),
            UNITS[name],
            put_in=POSES_OF_THE_RIG,
        )
        for short, camera in CAMERAS.items()
        for name in PARAMETERS
        for method, which in PRINTED_METHODS.items()
    }
    agree = Value.of_seeds(seeds.disagreement(FISH), "%")
    return found | {"t4_2_fish_agree": agree}


@numbers("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_3(results):
    """Ray-point errors over all seeds, the standard as printed."""
    seeds = Seeds(results)
    errors = {
        f"t4_3_{short}_{method}_{statistic}_{stage}": Value.of_seeds(
            seeds.of(camera, f"{which}.{key}_{statistic}_mm"), "mm"
        )
        for short, camera in CAMERAS.items()
        for method, which in PRINTED_METHODS.items()
        for stage, key in PRINTED_STAGES.items()
        for statistic in ("mean", "sd")
    }
    solved_from = "t4_3_omni_cgsp_mean_pre"
    errors[solved_from] = replace(errors[solved_from], put_in=SOLVED)
    return errors | {
        f"s4_4_ratio_{short}": Value.of_seeds(
            seeds.ratio(camera, "ray_mean_mm"), "ratio"
        )
        for short, camera in CAMERAS.items()
    }
