"""The mirrors of section 1.1.2 side by side, read from the results."""

from chapters.ch01_introduction.s1_1_panorama.trials import LEAST_RATIO, RIG_MIRROR
from repro.page.reader import value


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    taken = open_results("fig_1_1_picture")
    rows = open_results("fig_1_1_resolution")
    ratios = rows.select().column("ratio")
    found = {
        "high": taken.column("highest_deg").max(),
        "low": -taken.column("lowest_deg").min(),
        "ratio": rows.column("ratio", mirror=RIG_MIRROR).max(),
        "least": ratios.min(),
        "most": ratios.max(),
        "band": rows.select().column("band_deg").min(),
        "limit": LEAST_RATIO,
    }
    for name, number in found.items():
        value(name, number)
