"""What each order gave, and which one white residuals chose."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.trials.orders import NAMES, STAGES
from repro.judge.statistics import median_interval

ORDERS = "ext_orders_runs"
WORDS = {
    "smooth": "smooth mirror, white noise",
    "uneven": "uneven mirror, white noise",
    "bench": "uneven mirror, the bench's errors",
}


class Course(NamedTuple):
    """The orders that one seed went through: rows (steps, NAMES); white: which step is
    the first with white residuals, -1 for none; published: the row of 7 x 3 quadratic
    functions, NaN where it is refused."""

    rows: np.ndarray
    white: int
    published: np.ndarray

    def values(self, name):
        """A column (steps,) of NAMES; or `size`, the number of coefficients."""
        if name == "size":
            return self.values("functions_u") * self.values("functions_v")
        return self.rows[:, NAMES.index(name)]

    def chosen(self, name):
        """A value at the order that is taken: the first with white residuals, or the
        last that could be had."""
        return float(self.values(name)[self.white])

    def least(self, name):
        """The least of a column along the course."""
        return float(np.nanmin(self.values(name)))

    def with_least(self, name, of):
        """A value at the order that has the least of another column."""
        return float(self.values(of)[np.nanargmin(self.values(name))])


def courses(results, case, stage):
    """Courses of all seeds of a case, "primary" or "stage"; refused ones left out."""
    trials = results[ORDERS].select(case=case)
    white = trials.column(f"{stage}.white")
    got = np.flatnonzero(np.isfinite(white))
    arrays = (trials.arrays(f"{stage}.{name}") for name in ("rows", "published"))
    return [
        Course(rows, int(white[k]), published)
        for k, rows, published in zip(got, *arrays, strict=True)
    ]


def published_of(found, name):
    """A column (courses,) of the published order's rows."""
    return np.array([one.published[NAMES.index(name)] for one in found])


def quoted(results):
    """Name -> number, of what the prose quotes: medians over seeds."""
    found = {"seeds": results[ORDERS].trials_per_condition}
    for case in WORDS:
        for stage in STAGES:
            of = courses(results, case, stage)
            white = [one for one in of if one.white >= 0]
            numbers = {
                "white": len(white),
                "size": _median([one.chosen("size") for one in of]),
                "degree": _median([one.chosen("degree") for one in of]),
                "angle": _median([one.chosen("angle_deg") for one in of]),
                "best": _median([one.least("angle_deg") for one in of]),
                "kept": _median([one.with_least("kept_mm", "angle_deg") for one in of]),
                "last": _median([one.rows[-1, -1] for one in of]),
                "excess": _median([one.chosen("excess") for one in of]),
                "published": _median(published_of(of, "angle_deg")),
                "published.excess": _median(published_of(of, "excess")),
            }
            found |= {f"{case}.{stage}.{name}": n for name, n in numbers.items()}
    return found


def _median(values):
    return median_interval(np.array(values)).value if len(values) else np.nan
