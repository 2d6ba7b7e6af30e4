"""Errors of the motion by method and detector, and what detectors refused."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.results import (
    MEASURES,
    METHODS,
    NAMES,
    corner_error,
    refusals,
    trials_of,
)
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.ch04_central_generic.s3_4_motion.trials.stage import STEPS
from repro.judge.statistics import median_interval
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


def measured(trials):
    """The median of trials with its interval; None where none gave one."""
    found = median_interval(trials)
    if not np.isfinite(found.value):
        return None
    return Measured(found.value, found.low, found.high)


@table("ext_motion", needs=("fig_4_10_seeds", "fig_4_10_rendered"), evidence="rendered")
def motion_table(results):
    """Medians of both errors, redrawn and rendered."""
    result, rendered = (
        results[name] for name in ("fig_4_10_seeds", "fig_4_10_rendered")
    )
    rows = []
    for detector in DETECTORS:
        for method in METHODS:
            cells = []
            for motion, measure in MEASURES.items():
                of_seeds = trials_of(rendered, motion, measure, method, detector)
                cells += [
                    measured(trials_of(result, motion, measure, method, detector)),
                    float(np.median(of_seeds)),
                ]
            rows.append((detector, NAMES[method], *cells))
    return Table(
        columns(
            (
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
        "pictures.",
    )


@table("ext_motion_refused", needs=("fig_4_10_corners",), evidence="rendered")
def refused_table(results):
    """How many boards each detector refused, and its errors."""
    result = results["fig_4_10_corners"]
    rows = [
        (
            detector,
            motion,
            *refusals(result, motion, detector)[::-1],
            corner_error(result, motion, detector),
        )
        for detector in DETECTORS
        for motion in STEPS
    ]
    return Table(
        columns(
            (
                "Detector",
                "Motion",
                "Boards shown",
                "Refused",
                "RMS error of the others (px)",
            ),
            rows,
        ),
        "Boards in the rendered pictures, and how many of them each detector "
        "refused. Those were clicked by hand, corner by corner.",
    )
