"""What the correction experiments left, by camera and method."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.protocol import METHODS
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import LINEAR_NAMES
from repro.page.reader import value
from repro.run.readings import Case

BOARDS, LINES = "fig_4_9_boards", "fig_4_7_lines"
NAMES = {method: LINEAR_NAMES[stage] for method, stage in METHODS.items()}
READINGS = {
    "standard_method": {"as printed": "printed", "well conditioned": "conditioned"}
}


def of_camera(result, camera, name):
    """Values (trials,) of one camera over all its conditions."""
    return result.select(camera=camera).column(name)


def both(result, camera, options, name):
    """A value of the standard method and of CGSP in one reading, (2, trials)."""
    methods = Case(READINGS, options)["standard_method"], "cgsp"
    return np.array([of_camera(result, camera, f"{m}.{name}") for m in methods])


def name_values(open_results):
    """Name the numbers of the prose: medians of the trials that have a value."""
    boards, lines = open_results(BOARDS), open_results(LINES)

    trials = {
        f"{short}.{method}.{name}": of_camera(result, camera, f"{method}.{key}")
        for short, camera in (("omni", OMNI), ("fish", FISH))
        for method in NAMES
        for name, result, key in (
            ("mean", boards, "mean_mm"),
            ("worst", lines, "worst_share"),
        )
    } | {
        f"{name}.{method}": of_camera(result, camera, f"{method}.{key}")
        for name, result, camera, key in (
            ("seam", boards, OMNI, "seam_ratio"),
            ("skew", boards, FISH, "skew_spearman"),
            ("vertical", lines, OMNI, "vertical_deg"),
        )
        for method in ("printed", "cgsp")
    }
    found = {
        name: np.nanmedian(one) * (100 if name.endswith(".worst") else 1)
        for name, one in trials.items()
    } | {
        "omni.boards": int(of_camera(boards, OMNI, "boards_found").sum()),
        "fish.boards": int(of_camera(boards, FISH, "boards_found").sum()),
        "trials": lines.trials_per_condition,
    }
    for name, number in found.items():
        value(name, number)
