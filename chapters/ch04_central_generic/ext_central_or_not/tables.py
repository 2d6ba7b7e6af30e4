"""The test and the free lines, in numbers."""

from __future__ import annotations

from chapters.ch04_central_generic.ext_central_or_not.results import (
    NAMES,
    RUNS,
    alarms,
    median,
)
from chapters.ch04_central_generic.ext_central_or_not.trials import CAMERAS, NOISES_MM
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
    rows = [(camera, noise) for camera in CAMERAS for noise in NOISES_MM]
    cells = {
        "Camera": [NAMES[camera] for camera, _ in rows],
        "Noise (mm)": [noise for _, noise in rows],
    }
    for title, field in COLUMNS.items():
        cells[title] = [Measured(*median(result, field, *row)[:3]) for row in rows]
    cells["Called non-central (%)"] = [
        Measured(*(100 * part for part in alarms(result, *row)[:3])) for row in rows
    ]
    return Table(
        cells,
        "How far from one point the rays of each camera pass: the truth, the "
        "test's estimate, its upper bound and p-value. The misses are RMS "
        "distances from the true rays, next to the camera. Medians over "
        f"{result.trials_per_condition} trials with 95 % intervals; shares "
        "with exact ones.",
    )
