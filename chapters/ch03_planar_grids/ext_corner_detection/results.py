"""Results of 6.3.1: methods compared in pairs, outcomes counted, quoted numbers."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.ext_corner_detection.trials import coded
from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    DEFAULT,
    OTHERS,
    PUBLISHED,
)
from chapters.shared.scoring import CORNER_OFF
from chapters.shared.synthetic_board import SyntheticBoard
from repro.judge.statistics import bootstrap, holm, mcnemar
from repro.page.reader import value

SIGNIFICANT = 0.05


def successes(result, picture, method):
    """Trials (n,) bool: every corner within 8 px."""
    return np.array(result.texts(f"{method}.success", picture=picture), bool)


def comparisons(result):
    """{(picture, method): values against the published stages, with Holm's p}.

    `gained`, `lost`: trials; `p`: corrected over the whole table; `low`, `high`: 95 %
    interval of the difference of the two shares, resampled by trial.
    """
    pairs, raw = {}, []
    for picture, method in product(result.levels("picture"), OTHERS):
        before, after = (successes(result, picture, m) for m in (PUBLISHED, method))
        change = bootstrap(
            lambda a, b: b.mean(axis=-1) - a.mean(axis=-1), before, after, paired=True
        )
        pairs[picture, method] = {
            "before": float(before.mean()),
            "after": float(after.mean()),
            "gained": int((after & ~before).sum()),
            "lost": int((before & ~after).sum()),
            "low": change.low,
            "high": change.high,
        }
        raw.append(mcnemar(before, after))
    for values, p in zip(pairs.values(), holm(raw), strict=True):
        values["p"] = p
    return pairs


def counts(trials):
    """How often each of OUTCOMES came in a selection of trials, (5,) int."""
    outcomes = trials.texts("outcome")
    return np.array([outcomes.count(name) for name in coded.OUTCOMES])


def by_picture(result):
    """Name of a condition of the coded grid -> its trials."""
    return {name_of(c): result.one(**c) for c in result.conditions}


def name_of(condition):
    """How a condition is called in table and figure."""
    if condition["grid"] != "coded":
        return condition["grid"]
    return (
        f"{condition['marks']}, {condition['fov_deg']}°, noise {condition['noise_sd']}"
    )


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    _name_further(open_results("ext_further_ideas_runs"))
    _name_split(open_results("ext_split_corners_runs"))
    _name_coded(open_results("ext_coded_grid_runs"))


def _name_further(result):
    value("further.trials", result.trials_per_condition)
    compared = comparisons(result)
    bent = [v for (_, m), v in compared.items() if m == "curvature"]
    for what in ("gained", "lost"):
        value(f"curvature.{what}", sum(v[what] for v in bent))
    for method in (PUBLISHED, "symmetry"):
        blurred = successes(result, "blur SD 5 px", method)
        value(f"blur.{method}", 100 * float(blurred.mean()))
    on_column, lost = failed_on_column(result)
    value("published.losses", lost)
    value("published.losses.column", on_column)


def _name_split(result):
    for method in (PUBLISHED, "symmetry"):
        (inliers,) = result.arrays(f"{method}.inliers")
        value(f"split.{method}", len(inliers))
    value("split.corners", SyntheticBoard(**DEFAULT).columns)


def silently_wrong(result, method):
    """Trials that a method returned with a corner more than 8 px off."""
    return result.select().texts(f"{method}.stage").count(CORNER_OFF)


def of_both(trials, method, names):
    """Values of trials that a method and the published stages both get right."""
    both = np.array(trials.texts(f"{method}.success"), bool)
    both &= np.array(trials.texts(f"{PUBLISHED}.success"), bool)
    return [trials.column(name)[both] for name in names]


def error_ratio(result, method):
    """Mean error over the published, median of trials where both succeed, or None."""
    names = f"{method}.mean_px", f"{PUBLISHED}.mean_px"
    after, before = of_both(result.select(), method, names)
    return float(np.median(after / before)) if len(after) else None


def failed_on_column(result):
    """(published runs lost on a column first, all published runs lost)."""
    trials = result.select()
    lost = ~np.array(trials.texts(f"{PUBLISHED}.success"), bool)
    on_column = np.array(trials.texts(f"{PUBLISHED}.failed_on")) == "column"
    return int((on_column & lost).sum()), int(lost.sum())


def _name_coded(result):
    for marks in coded.MARKS:
        of_all = counts(result.select(grid="coded", marks=marks))
        value(f"{marks}.all", int(of_all.sum()))
        value(f"{marks}.wrong", int(of_all[-1]))
