"""All conditions in numbers."""

from chapters.ch04_central_generic.ext_smooth_rays.results import NAMES, median
from chapters.ch04_central_generic.ext_smooth_rays.trials import CONDITIONS, METHODS
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table(
    "ext_smooth_rays_honest_table",
    needs=("ext_smooth_rays_runs",),
    evidence="synthetic",
)
def smooth_rays_honest_table(results):
    """Errors of all methods, and squared errors relative to the predicted ones."""
    result = results["ext_smooth_rays_runs"]

    def cells(name):
        return [Measured(*median(result, name, **c)[:3]) for c in CONDITIONS]

    columns = {
        "Lens": [c["lens"] for c in CONDITIONS],
        "Noise (px)": [c["noise"] for c in CONDITIONS],
        "Grids": [c["grids"] for c in CONDITIONS],
    }
    for method in METHODS:
        columns[f"{NAMES[method]} (px)"] = cells(f"{method}.off_px")
    for method in ("smooth", "direct"):
        columns[f"squared error / predicted, {NAMES[method]}"] = cells(
            f"{method}.normalised"
        )
    return Table(
        columns,
        "Distance in the image after one rotation of all rays (RMS over 999 "
        "rays), and squared errors relative to the predicted variances (1 if "
        "the predictions are correct): medians over "
        f"{result.trials_per_condition} trials with 95 % intervals.",
    )
