"""Distances from straight lines, read from the seeds of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.judge.statistics import with_worst


def line_median(made, name, scale="corrected"):
    """Median over seeds of a method's distance from straight lines."""
    place = f"lines.generic_as_printed.{name}.{scale}"
    trials = made.column(place, zoom=FACADE_ZOOM)
    return float(np.median(with_worst(trials)))
