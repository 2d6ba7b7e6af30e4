"""Results of 6.3.1: methods compared in pairs, outcomes counted, quoted numbers."""

from __future__ import annotations

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
    found = result.texts(f"{method}.success", picture=picture)
    return np.array(found, bool)


def comparisons(result):
    """{(picture, method): values against the published stages, with Holm's p}.

    `gained`, `lost`: trials; `p`: corrected over the whole table; `low`, `high`: 95 %
    interval of the difference of the two shares, resampled by trial.
    """
    pairs, raw = {}, []
    for condition in result.conditions:
        picture = condition["picture"]
        before = successes(result, picture, PUBLISHED)
        for method in OTHERS:
            after = successes(result, picture, method)
            change = bootstrap(
                lambda a, b: b.mean(axis=-1) - a.mean(axis=-1),
                before,
                after,
                paired=True,
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


def counts(result, condition):
    """How often each of OUTCOMES came, (5,) int."""
    outcomes = result.texts("outcome", **condition)
    return np.array([outcomes.count(name) for name in coded.OUTCOMES])


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
    stages = [
        stage
        for condition in result.conditions
        for stage in result.texts(f"{method}.stage", **condition)
    ]
    return stages.count(CORNER_OFF)


def error_ratio(result, method):
    """Mean error over the published, median of trials where both succeed, or None."""
    ratios = []
    for condition in result.conditions:
        picture = condition["picture"]
        both = successes(result, picture, method)
        both = both & successes(result, picture, PUBLISHED)
        after, before = (
            result.column(f"{name}.mean_px", picture=picture)[both]
            for name in (method, PUBLISHED)
        )
        ratios.append(after / before)
    ratios = np.concatenate(ratios)
    return float(np.median(ratios)) if len(ratios) else None


def failed_on_column(result):
    """(published runs lost on a column first, all published runs lost)."""
    on_column = lost = 0
    for condition in result.conditions:
        picture = condition["picture"]
        won = successes(result, picture, PUBLISHED)
        kinds = result.texts(f"{PUBLISHED}.failed_on", picture=picture)
        lost += int((~won).sum())
        on_column += sum(
            kind == "column" and not good for kind, good in zip(kinds, won, strict=True)
        )
    return on_column, lost


def of_marks(result, marks):
    """Conditions with the grid looked for and marks of this contrast."""
    return [
        c for c in result.conditions if c["grid"] == "coded" and c["marks"] == marks
    ]


def _name_coded(result):
    for marks in coded.MARKS:
        total = sum(counts(result, c) for c in of_marks(result, marks))
        value(f"{marks}.all", int(total.sum()))
        value(f"{marks}.wrong", int(total[-1]))
