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
    split = open_results("ext_split_corners_runs")
    quoted = {
        **of_stages(open_results("ext_further_ideas_runs")),
        "split.published": len(split.arrays(f"{PUBLISHED}.inliers")[0]),
        "split.symmetry": len(split.arrays("symmetry.inliers")[0]),
        "split.corners": SyntheticBoard(**DEFAULT).columns,
        **of_coded(open_results("ext_coded_grid_runs")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_stages(result):
    """What the further stages gain and lose, and where published runs are lost."""
    bent = [v for (_, m), v in comparisons(result).items() if m == "curvature"]
    on_column, lost = failed_on_column(result)
    return {
        "further.trials": result.trials_per_condition,
        "curvature.gained": sum(v["gained"] for v in bent),
        "curvature.lost": sum(v["lost"] for v in bent),
        "blur.published": share_in_blur(result, PUBLISHED),
        "blur.symmetry": share_in_blur(result, "symmetry"),
        "symmetry.error": in_times(error_ratio(result, "symmetry")),
        "clusters.silent": silently_wrong(result, "clusters"),
        "published.silent": silently_wrong(result, PUBLISHED),
        "published.losses": lost,
        "published.losses.column": on_column,
    }


def share_in_blur(result, method):
    """Share of successes under a blur of 5 px, in percent."""
    return 100 * float(successes(result, "blur SD 5 px", method).mean())


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


def in_times(ratio):
    """A ratio for a sentence; where no trial has one, the sentence says so."""
    return "an unknown number of" if ratio is None else f"{ratio:.1f}"


def failed_on_column(result):
    """(published runs lost on a column first, all published runs lost)."""
    trials = result.select()
    lost = ~np.array(trials.texts(f"{PUBLISHED}.success"), bool)
    on_column = np.array(trials.texts(f"{PUBLISHED}.failed_on")) == "column"
    return int((on_column & lost).sum()), int(lost.sum())


def of_coded(result):
    """How many blocks with either marks, in a wrong place, refused by the decoder."""
    found = {}
    for marks in coded.MARKS:
        of_all = counts(result.select(grid="coded", marks=marks))
        found[f"{marks}.all"] = int(of_all.sum())
        found[f"{marks}.wrong"] = int(of_all[-1])
        found[f"{marks}.refused"] = int(
            of_all[coded.OUTCOMES.index("refused by the decoder")]
        )
    return found
