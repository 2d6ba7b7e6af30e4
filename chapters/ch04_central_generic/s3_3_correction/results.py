"""What the correction experiments left, by camera and method."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.protocol import METHODS
from chapters.shared.central_sets import FISH, OMNI, RIGS
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

    def median(result, camera, key):
        return float(np.nanmedian(of_camera(result, camera, key)))

    for camera in RIGS:
        short = "omni" if camera == OMNI else "fish"
        for method in NAMES:
            value(f"{short}.{method}.mean", median(boards, camera, f"{method}.mean_mm"))
            worst = median(lines, camera, f"{method}.worst_share")
            value(f"{short}.{method}.worst", 100 * worst)
        value(f"{short}.boards", int(of_camera(boards, camera, "boards_found").sum()))
    for method in ("printed", "cgsp"):
        for name, result, camera, key in (
            ("seam", boards, OMNI, "seam_ratio"),
            ("skew", boards, FISH, "skew_spearman"),
            ("vertical", lines, OMNI, "vertical_deg"),
        ):
            value(f"{name}.{method}", median(result, camera, f"{method}.{key}"))
    value("trials", lines.trials_per_condition)
