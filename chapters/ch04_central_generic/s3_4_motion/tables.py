"""Errors of the motion by method and detector, and what detectors refused."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.results import MEASURES, NAMES, trials_of
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.shared.bench_noise import BENCH
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

LABORATORY = "laboratory"


@table("ext_motion", needs=("fig_4_10_seeds", "fig_4_10_rendered"), evidence="rendered")
def motion_table(results):
    """Medians of both errors, redrawn and rendered."""
    result, rendered = (
        results[name] for name in ("fig_4_10_seeds", "fig_4_10_rendered")
    )
    rows = []
    for noise, detector, method in product((BENCH, LABORATORY), DETECTORS, NAMES):
        cells = []
        for motion, measure in MEASURES.items():
            redrawn, found = (
                trials_of(one, motion, measure, method, detector, noise)
                for one in (result, rendered)
            )
            cells += [Measured.median_or_none(redrawn), float(np.median(found))]
        rows.append((noise, detector, NAMES[method], *cells))
    return Table(
        columns(
            (
                "Noise",
                "Corners",
                "Calibration",
                "Deviation from the mean step, redrawn (mm)",
                "rendered (mm)",
                "Total turn off 110°, redrawn (°)",
                "rendered (°)",
            ),
            rows,
        ),
        "Errors of the motion: medians over seeds with redrawn corners, with "
        "95 % intervals, and over those whose corners were found in "
        "pictures. The grids were decoded with errors as large as the bench's, or "
        "with the laboratory's own.",
    )
