"""Names of the methods, and the numbers that the page quotes."""

from repro.judge.statistics import median_interval
from repro.page.reader import value

NAMES = {
    "table": "table of rays",
    "formula": "radial law alone",
    "smooth": "smooth table",
    "direct": "adjusted directly",
}
NOISES = (0.25, 0.5, 1.0)
USUAL = {"lens": "bent", "noise": 0.5, "grids": 3}
MANY = {"lens": "bent", "noise": 0.5, "grids": 10}


def median(result, name, **condition):
    """Return the median over trials, an Estimate."""
    return median_interval(result.column(name, **condition))


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = open_results("ext_smooth_rays_runs")
    quoted = {
        "usual": (
            "table.left_px",
            "smooth.left_px",
            "smooth.off_px",
            "smooth.normalised",
            "direct.normalised",
        ),
        "many": ("smooth.off_px",),
    }
    conditions = {"usual": USUAL, "many": MANY}
    for what, names in quoted.items():
        for name in names:
            value(f"{what}.{name}", median(runs, name, **conditions[what]).value)
