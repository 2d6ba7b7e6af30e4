"""The mirrors of section 1.1.2 side by side, read from the results."""

from __future__ import annotations

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials import (
    ECCENTRICITIES,
    LEAST_RATIO,
    RIG_MIRROR,
)
from repro.page.reader import value


def over_mirrors(ran, name):
    """One value for each mirror, in the order of ECCENTRICITIES."""
    return np.array([ran.column(name, mirror=mirror)[0] for mirror in ECCENTRICITIES])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    taken = open_results("fig_1_1_picture")
    value("high", taken.column("highest_deg").max())
    value("low", -taken.column("lowest_deg").min())
    rows = open_results("fig_1_1_resolution")
    value("ratio", rows.column("ratio", mirror=RIG_MIRROR).max())
    value("least", over_mirrors(rows, "ratio").min())
    value("most", over_mirrors(rows, "ratio").max())
    value("band", over_mirrors(rows, "band_deg").min())
    value("limit", LEAST_RATIO)
