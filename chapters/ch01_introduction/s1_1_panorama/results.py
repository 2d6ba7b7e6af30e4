"""Values that the page of section 1.1.2 quotes."""

from chapters.ch01_introduction.s1_1_panorama.trials import RIG_MIRROR
from repro.page.reader import value


def name_values(open_results):
    """Name the values that the page quotes."""
    rows = open_results("fig_1_1_resolution")
    found = {
        "ratio": rows.column("ratio", mirror=RIG_MIRROR).max(),
        "band": rows.select().column("band_deg").min(),
    }
    for name, number in found.items():
        value(name, number)
