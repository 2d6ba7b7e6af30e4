"""The mirrors of section 1.1.2 side by side, read from the results."""

from chapters.ch01_introduction.s1_1_panorama.trials import LEAST_RATIO, RIG_MIRROR
from repro.page.reader import value


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    taken = open_results("fig_1_1_picture")
    value("high", taken.column("highest_deg").max())
    value("low", -taken.column("lowest_deg").min())
    rows = open_results("fig_1_1_resolution")
    value("ratio", rows.column("ratio", mirror=RIG_MIRROR).max())
    ratios, bands = (rows.select().column(name) for name in ("ratio", "band_deg"))
    value("least", ratios.min())
    value("most", ratios.max())
    value("band", bands.min())
    value("limit", LEAST_RATIO)
