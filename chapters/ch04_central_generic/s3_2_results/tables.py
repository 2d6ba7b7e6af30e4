"""Tables 4.2 and 4.3, and their numbers."""

from dataclasses import replace
from itertools import product

from chapters.ch04_central_generic.s3_2_results.results import (
    CAMERAS,
    PARAMETERS,
    SEEDS_OF_BOTH,
    UNITS,
    Seeds,
)
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
    "the factor of the thesis-matched level is solved from this number: it is near "
    "the printed one by construction"
)
POSES_OF_THE_RIG = (
    "the grid poses of the rig are those of Table 4.2: this is near the printed "
    "value by construction"
)
# Names of methods and stages in the ids of the registry.
PRINTED_METHODS = {"std": "as_printed", "cgsp": "cgsp"}
PRINTED_STAGES = {"pre": "ray", "ba": "ba"}


@table("table_4_2", needs=("table_4_3_rendered",), evidence="rendered")
def table_4_2(results):
    """Tabulate centre and poses by each method, and the true ones, of the first set."""
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
        "Camera centre in the frame of the base grid, and rotation and translation "
        "magnitudes of grids 2 and 3 relative to it: first rendered run of each "
        "camera, thesis-matched level. *True* is the point nearest to all rays, since "
        "neither camera is exactly central.",
        printed=printed,
    )


HEADS = {
    "ray_mean_mm": "Mean (mm)",
    "ray_sd_mm": "SD (mm)",
    "ba_mean_mm": "Mean after BA (mm)",
    "ba_sd_mm": "SD after BA (mm)",
    "centre_off_mm": "Centre error (mm)",
}


@table("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def table_4_3(results):
    """Tabulate ray-point errors before and after adjustment, thesis-matched level."""
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
    seeds = Seeds(results)
    rows = [
        (
            camera,
            LINEAR_NAMES[method],
            *(Measured.median(seeds.of(camera, f"{method}.{key}")) for key in HEADS),
        )
        for camera, method in product(CAMERAS.values(), LINEAR_NAMES)
    ]
    return Table(
        columns(("Camera", "Method", *HEADS.values()), rows),
        "Ray-point errors: mean and standard deviation over all rays of the linear "
        "stage, before and after the thesis's bundle adjustment (BA), which keeps the "
        "centre. *Centre error*: distance from the point nearest to the true rays, "
        "before adjustment. Medians over rendered and redrawn runs with 95 % "
        "intervals, thesis-matched level. CGSP's mean on the omnidirectional camera "
        "is set by the factor of that level.",
        printed=printed,
    )


@numbers("table_4_2", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_2(results):
    """Return centre and pose magnitudes of the rendered runs, standard as printed."""
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
    """Return ray-point errors over all runs, standard as printed."""
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
