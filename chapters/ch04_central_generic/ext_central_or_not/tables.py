"""The test and the free lines, in numbers."""

from itertools import product

from chapters.ch04_central_generic.ext_central_or_not.results import (
    NAMES,
    RUNS,
    alarms,
    median,
)
from chapters.ch04_central_generic.ext_central_or_not.trials import CAMERAS, NOISES_MM
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

COLUMNS = {
    "True distance (mm)": "true_mm",
    "Measured (mm)": "found_mm",
    "Bound, 95 % (mm)": "most_mm",
    "p (1)": "p",
    "Central rays miss by (mm)": "central_miss_mm",
    "Free lines miss by (mm)": "lines_miss_mm",
}


@table("ext_centrality_table", needs=("ext_centrality_runs",), evidence="synthetic")
def centrality_table(results):
    """Medians for every camera and noise."""
    result = results[RUNS]
    rows = [
        (
            NAMES[camera],
            noise,
            *(
                Measured(*median(result, field, camera, noise)[:3])
                for field in COLUMNS.values()
            ),
            Measured(*alarms(result, camera, noise).times(100)[:3]),
        )
        for camera, noise in product(CAMERAS, NOISES_MM)
    ]
    return Table(
        columns(("Camera", "Noise (mm)", *COLUMNS, "Called non-central (%)"), rows),
        "How far from one point the rays of each camera pass: the truth, the "
        "test's estimate, its upper bound and p-value. The misses are RMS "
        "distances from the true rays, next to the camera. Medians over "
        f"{result.trials_per_condition} trials with 95 % intervals; shares "
        "with exact ones.",
    )
