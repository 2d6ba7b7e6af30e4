"""Errors of the motion by method and detector."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.results import MEASURES, NAMES, trials_of
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.shared.bench_noise import BENCH
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

NOISES = {BENCH: "thesis-matched", "laboratory": "low-noise"}


@table("ext_motion", needs=("fig_4_10_seeds", "fig_4_10_rendered"), evidence="rendered")
def motion_table(results):
    """Tabulate medians of both errors, redrawn and rendered."""
    result, rendered = (
        results[name] for name in ("fig_4_10_seeds", "fig_4_10_rendered")
    )
    rows = []
    for noise, detector, method in product(NOISES, DETECTORS, NAMES):
        cells = []
        for motion, measure in MEASURES.items():
            redrawn, found = (
                trials_of(one, motion, measure, method, detector, noise)
                for one in (result, rendered)
            )
            cells += [Measured.median_or_none(redrawn), float(np.median(found))]
        rows.append((NOISES[noise], detector, NAMES[method], *cells))
    return Table(
        columns(
            (
                "Noise level",
                "Corners",
                "Calibration",
                "Deviation from the mean step, redrawn (mm)",
                "rendered (mm)",
                "Error of the total rotation, redrawn (°)",
                "rendered (°)",
            ),
            rows,
        ),
        "Errors of the reconstructed motion: medians over the redrawn runs, with 95 % "
        "intervals, and over the rendered runs, at both noise levels of the decoded "
        "grids.",
    )
