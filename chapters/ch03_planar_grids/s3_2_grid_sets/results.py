"""What the four experiments of 3.3.2 found, and the numbers that are quoted."""

from __future__ import annotations

import math

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    CONTOUR,
    MERGED,
    METHODS,
    MISSED,
    REFERENCE,
    SPLIT,
    TRUTH,
)
from chapters.shared.grid_detectors import CELECT, OPENCV, OPENCV_SB
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# The four of them: what the claims of all sixty pictures need.
GRIDS = (
    "table_3_4_grids",
    "table_3_5_grids",
    "table_3_6_grids",
    "table_3_7_grids",
)
TITLES = {
    "spherical": "Spherical",
    "hyperboloidal": "Hyperboloidal",
    "fisheye": "Fisheye",
    "flexible-mirror": "Flexible Mirror",
}
DETECTORS_OF_TODAY = (OPENCV, OPENCV_SB)
# Short names of sets in the ledger's numbers, with their grids.
SHORT = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
SEEDS_RANGE = "mean and range of the rendered seeds"


def seeds_of(result):
    """Seeds of an experiment, in order."""
    return list(dict.fromkeys(c["seed"] for c in result.conditions))


def any_of(results):
    """The seeds, which all four experiments share."""
    return seeds_of(next(iter(results.values())))


def pictures_of(result, seed=None):
    """Conditions of an experiment, of one seed or of all."""
    return [c for c in result.conditions if seed in (None, c["seed"])]


def right(result, method, seed=None):
    """Whether each picture's grid was found and in order: (n,) bool."""
    name = f"{method}.success"
    return np.array(
        [
            bool(result.column(name, **c)[0])
            for c in pictures_of(result, seed)
        ]
    )


def all_right(results, method, seed):
    """`right` of a seed's pictures of all sets, in the order of the sets."""
    return np.concatenate(
        [
            right(results[name], method, seed)
            for name in EXPERIMENTS.values()
        ]
    )


def of_each_seed(results, detector):
    """Each seed, and which of its pictures CELECT and a detector get right.

    Yields (seed, (n,) bool, (n,) bool), the pictures of all four sets.
    """
    for seed in any_of(results):
        yield (
            seed,
            all_right(results, CELECT, seed),
            all_right(results, detector, seed),
        )


def errors(result, method, when, reference, seed=None):
    """Errors (N,) in px of all corners of the right grids.

    when: 'before' or 'after' localisation; reference: one of REFERENCES.
    """
    against = "truth" if reference == TRUTH else "reference"
    found = [np.empty(0)]
    for condition in pictures_of(result, seed):
        found += result.arrays(f"{method}.{when}_{against}", **condition)
    return np.concatenate(found)


def texts(result, name, seed=None):
    """One text of each picture, None where it has none."""
    return [result.texts(name, **c)[0] for c in pictures_of(result, seed)]


def causes(results, seed, set_name=None):
    """Why CELECT failed, one text per failed picture of a seed."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, seed)
        told = texts(result, f"{CELECT}.cause", seed)
        found += [
            cause for cause, bad in zip(told, lost, strict=True) if bad
        ]
    return found


def cleared(result, blemish, seed):
    """How many failures of CELECT a clean mirror would have spared."""
    name = f"{CELECT}.right_without_{blemish}"
    return sum(
        result.column(name, **c)[0] == 1 for c in pictures_of(result, seed)
    )


def opened_all(open_results):
    """The four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def title_of(set_name):
    """Name of a set in the thesis."""
    return TITLES[set_name]


def spread(values):
    """(mean, (least, greatest)) of one value per seed."""
    return float(np.mean(values)), (
        float(np.min(values)),
        float(np.max(values)),
    )


def chance_of_split(only_one, only_other):
    """Exact two-sided chance of McNemar's test for a split of pictures."""
    count = only_one + only_other
    fewer = min(only_one, only_other)
    tail = sum(math.comb(count, k) for k in range(fewer + 1))
    return min(1.0, 2 * tail / 2**count)


@numbers(
    "table_3_3",
    needs=GRIDS,
    evidence="rendered",
)
def numbers_table_3_3(results):
    """The settings as they were run."""
    found = {}
    for set_name, short in SHORT.items():
        ran = results[EXPERIMENTS[set_name]].settings
        width, height = ran["image_px"]
        found[f"t3_3_{short}_w"] = Value(width, unit="px")
        found[f"t3_3_{short}_h"] = Value(height, unit="px")
        single = len(ran["grids"]) == 1
        for (columns, rows), pitch in zip(
            ran["grids"], ran["pitch_mm"], strict=True
        ):
            size = f"{columns}x{rows}"
            found[f"t3_3_{short}_grid_{size}"] = Value(size, unit="count")
            tail = "" if single else f"_{size}"
            found[f"t3_3_{short}_pitch{tail}"] = Value(pitch, unit="mm")
    total = sum(results[EXPERIMENTS["spherical"]].settings["images"])
    return found | {"t3_3_images": Value(total, unit="count")}


def per_seed(results, count):
    """Value of a count per seed: count(seed)."""
    value, interval = spread([float(count(s)) for s in any_of(results)])
    return value, interval


def of_table(result, table_id):
    """Counts and errors of OpenCV's and CELECT's rows of one table."""
    found = {}
    for name, method in (("opencv", OPENCV), ("celect", CELECT)):
        counts = [right(result, method, s).sum() for s in seeds_of(result)]
        count, interval = spread(counts)
        found[f"t{table_id}_{name}_count"] = Value(
            count,
            interval=interval,
            unit="count (of 15)",
            reason=SEEDS_RANGE,
        )
        for label, when in (("pre", "before"), ("post", "after")):
            sizes = errors(result, method, when, REFERENCE)
            for statistic, taken in (
                ("mean", np.mean),
                ("max", np.max),
                ("sd", lambda e: e.std(ddof=1)),
            ):
                key = f"t{table_id}_{name}_{label}_{statistic}"
                found[key] = Value(
                    float(taken(sizes)) if len(sizes) else "no right grid",
                    unit="px",
                    reason="all seeds; against cornerSubPix from the truth",
                )
    return found


@numbers("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def numbers_table_3_4(results):
    """The Spherical set."""
    return of_table(results["table_3_4_grids"], "3_4")


@numbers("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def numbers_table_3_5(results):
    """The Hyperboloidal set."""
    return of_table(results["table_3_5_grids"], "3_5")


@numbers("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def numbers_table_3_6(results):
    """The Fisheye set."""
    return of_table(results["table_3_6_grids"], "3_6")


@numbers("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def numbers_table_3_7(results):
    """The Flexible Mirror set."""
    return of_table(results["table_3_7_grids"], "3_7")


def largest_localised(results):
    """Largest error (px) after localisation, of OpenCV's and CELECT's grids."""
    sizes = [
        errors(result, method, "after", REFERENCE)
        for result in results.values()
        for method in (OPENCV, CELECT)
    ]
    return float(np.concatenate(sizes).max(initial=0.0))


@numbers(
    "sec_3_3_2",
    needs=GRIDS,
    evidence="rendered",
)
def numbers_sec_3_3_2(results):
    """Totals over the four sets, and what CELECT's failures come from."""
    precision = results["table_3_4_grids"].settings["localiser"]
    spherical, hyperboloidal = (
        results[EXPERIMENTS[name]]
        for name in ("spherical", "hyperboloidal")
    )

    def ours(seed):
        return all_right(results, CELECT, seed)

    def theirs(seed):
        return all_right(results, OPENCV, seed)

    counts = {
        "opencv_only": lambda s: (theirs(s) & ~ours(s)).sum(),
        "celect_only": lambda s: (ours(s) & ~theirs(s)).sum(),
        "celect_rate": lambda s: 100 * ours(s).mean(),
        "opencv_rate": lambda s: 100 * theirs(s).mean(),
        "contour_fail": lambda s: causes(results, s).count(CONTOUR),
        "sph_noise_fail": lambda s: cleared(spherical, "spots", s),
        "sph_missed_fail": lambda s: causes(results, s, "spherical").count(
            MISSED
        ),
        "hyp_dirt_fail": lambda s: cleared(hyperboloidal, "spots", s),
        "hyp_glare_fail": lambda s: cleared(hyperboloidal, "glare", s),
        "fish_merge_fail": lambda s: sum(
            causes(results, s, "fisheye").count(c) for c in (MERGED, SPLIT)
        ),
    }
    reasons = {
        "sph_noise_fail": "right once the mirror has no flaws",
        "hyp_dirt_fail": "right once the mirror has no dirt",
        "hyp_glare_fail": "right once there is no glare",
        "fish_merge_fail": "first failed contour: corners merged, or split",
    }
    found = {}
    for name, count in counts.items():
        mean, interval = per_seed(results, count)
        told = [reasons[name]] if name in reasons else []
        found[f"s3_3_2_{name}"] = Value(
            mean, interval=interval, reason="; ".join([*told, SEEDS_RANGE])
        )
    total = len(ours(any_of(results)[0]))
    return found | {
        "s3_3_2_total": Value(total, unit="count"),
        "s3_3_2_prec": Value(precision["precision_px"], unit="px"),
        "s3_3_2_excess": Value(
            largest_localised(results) - precision["precision_px"],
            unit="px",
            reason="both methods, all seeds; against cornerSubPix from the "
            "truth",
        ),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = opened_all(open_results)
    seeds = any_of(results)
    value("seeds", len(seeds))
    value("pictures", len(all_right(results, CELECT, seeds[0])))
    for method in METHODS:
        rates = [100 * all_right(results, method, s).mean() for s in seeds]
        value(f"rate.{method}", float(np.mean(rates)))
    for set_name, experiment in EXPERIMENTS.items():
        value(
            f"celect.{SHORT[set_name]}",
            100 * float(right(results[experiment], CELECT).mean()),
        )
    told = [cause for seed in seeds for cause in causes(results, seed)]
    value("failures", len(told))
    common = max(set(told), key=told.count) if told else "none"
    value("cause", common)
    value("cause.count", told.count(common))
    value("split", told.count(SPLIT))
    value("contours", told.count(CONTOUR))
    value("largest.reference", largest_localised(results))
    against_truth = [
        errors(result, method, "after", TRUTH)
        for result in results.values()
        for method in (OPENCV, CELECT)
    ]
    value(
        "largest.truth",
        float(np.concatenate(against_truth).max(initial=0.0)),
    )
    squares = [
        result.column("least_px", **c)[0]
        for result in results.values()
        for c in result.conditions
    ]
    value("least.median", float(np.median(squares)))
