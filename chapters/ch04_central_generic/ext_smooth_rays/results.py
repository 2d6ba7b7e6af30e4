"""Names of the methods, and the numbers that the page quotes."""

from chapters.ch04_central_generic.ext_smooth_rays.trials import METHODS
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
RADIAL = {"lens": "radial", "noise": 0.5, "grids": 3}
MANY = {"lens": "bent", "noise": 0.5, "grids": 10}


def median(result, name, **condition):
    """Median over trials with its interval, an Estimate."""
    return median_interval(result.column(name, **condition))


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = open_results("ext_smooth_rays_runs")
    names = [
        *(f"{method}.{name}" for method in METHODS for name in ("off_px", "left_px")),
        "smooth.normalised",
        "direct.normalised",
    ]
    conditions = {"usual": USUAL, "radial": RADIAL, "many": MANY}
    found = {
        **{
            f"{what}.{name}": median(runs, name, **condition).value
            for what, condition in conditions.items()
            for name in names
        }
    }
    for name, number in found.items():
        value(name, number)
