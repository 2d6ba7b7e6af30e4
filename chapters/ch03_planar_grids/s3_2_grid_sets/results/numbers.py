"""Regenerated numbers of 3.3.2, and those that its page quotes."""

import math

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    CLEAN,
    EXPERIMENTS,
    GRIDS,
    MIN_SPACING_PX,
    PRIMARY,
    SPACING,
    Which,
    all_right,
    apart,
    causes,
    cleared,
    errors,
    numbers_of,
    of_each_seed,
    opened_all,
    pictures_of,
    right,
    seeds_of,
    spread,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    CONTOUR,
    MERGED,
    MISSED,
    REFERENCE,
    SPLIT,
    SPOTLESS_SEED,
    TRUTH,
)
from chapters.shared.grid_detectors import CELECT, CLICKLESS, LINEAR, OPENCV
from chapters.shared.grid_rigs import WHOLE
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

# Short names of sets in the registry's numbers.
SHORT = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
# Merging distance of CELECT below which squares are small.
SMALL_T8_PX = 4.5
SEEDS_RANGE = "mean and range of the rendered seeds"


def chance_of_split(only_one, only_other):
    """Return the exact two-sided p-value of McNemar's test for a split of images."""
    count = only_one + only_other
    fewer = min(only_one, only_other)
    tail = sum(math.comb(count, k) for k in range(fewer + 1))
    return min(1.0, 2 * tail / 2**count)


@numbers("table_3_3", needs=GRIDS, evidence="rendered")
def numbers_table_3_3(results):
    """Return the settings as they were run."""
    found = {}
    for set_name, short in SHORT.items():
        ran = results[EXPERIMENTS[set_name]].settings
        width, height = ran["image_px"]
        found[f"t3_3_{short}_w"] = Value(width, unit="px")
        found[f"t3_3_{short}_h"] = Value(height, unit="px")
        single = len(ran["grids"]) == 1
        for (columns, rows), pitch in zip(ran["grids"], ran["pitch_mm"], strict=True):
            size = f"{columns}x{rows}"
            found[f"t3_3_{short}_grid_{size}"] = Value(size, unit="count")
            tail = "" if single else f"_{size}"
            found[f"t3_3_{short}_pitch{tail}"] = Value(pitch, unit="mm")
    total = sum(results[EXPERIMENTS["spherical"]].settings["images"])
    return found | {"t3_3_images": Value(total, unit="count")}


def joined(found):
    """Return all errors of several grids in one array."""
    return np.concatenate([np.empty(0), *found])


def mean_of_seeds(found, reason, unit=""):
    """Return the mean of one number per run, with the range of the runs."""
    mean, low, high, _ = spread(found)
    return Value(mean, (low, high), unit, reason)


def of_table(result, table_id):
    """Return counts and errors of OpenCV's and CELECT's rows of one table."""
    found = {}
    for name, method in (("opencv", OPENCV), ("celect", CELECT)):
        by_seed = pictures_of(result).levels("seed")
        counts = [right(result, method, PRIMARY, s).sum() for s in by_seed]
        found[f"t{table_id}_{name}_count"] = mean_of_seeds(
            counts, SEEDS_RANGE, "count (of 15)"
        )
        for label, when, reference in (
            ("pre", "before", TRUTH),
            ("post", "after", REFERENCE),
        ):
            seeds = [
                joined(errors(result, method, when, reference, seed=s)) for s in by_seed
            ]
            sizes, seeds = joined(seeds), [s for s in seeds if len(s)]
            for statistic, taken in (
                ("mean", np.mean),
                ("max", np.max),
                ("sd", lambda e: e.std(ddof=1)),
            ):
                key = f"t{table_id}_{name}_{label}_{statistic}"
                found[key] = Value(
                    float(taken(sizes)) if seeds else "no right grid",
                    interval=spread([taken(s) for s in seeds])[1:3] if seeds else None,
                    unit="px",
                    reason="all seeds together, and range of the seeds; "
                    f"against {reference}",
                )
    return found


@numbers("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def numbers_table_3_4(results):
    """Return the numbers of the Spherical set."""
    return of_table(results["table_3_4_grids"], "3_4")


@numbers("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def numbers_table_3_5(results):
    """Return the numbers of the Hyperboloidal set."""
    return of_table(results["table_3_5_grids"], "3_5")


@numbers("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def numbers_table_3_6(results):
    """Return the numbers of the Fisheye set."""
    return of_table(results["table_3_6_grids"], "3_6")


@numbers("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def numbers_table_3_7(results):
    """Return the numbers of the Flexible Mirror set."""
    return of_table(results["table_3_7_grids"], "3_7")


def largest_after(results, reference):
    """Return the largest error (px) after localisation, of OpenCV and CELECT."""
    sizes = [
        joined(errors(result, method, "after", reference))
        for result in results.values()
        for method in (OPENCV, CELECT)
    ]
    return float(np.concatenate(sizes).max(initial=0.0))


def largest_far_apart(results, spacing):
    """Return the same for grids with all neighbouring corners at least 15 px apart."""
    least_px = MIN_SPACING_PX["15 px or more"]
    sizes = [
        one
        for result in results.values()
        for method in (OPENCV, CELECT)
        for one in apart(
            errors(result, method, "after", REFERENCE),
            result,
            spacing,
            least_px,
            method,
        )
    ]
    return float(joined(sizes).max(initial=0.0))


def spared_by_clean_ball(result):
    """Return how many failures of CELECT succeed without the spots."""
    spotted = right(result, CELECT, PRIMARY, SPOTLESS_SEED)
    clean = right(result, CELECT, Which(WHOLE, CLEAN), SPOTLESS_SEED)
    return int((clean & ~spotted).sum())


@numbers("sec_3_3_2", needs=GRIDS, evidence="rendered")
def numbers_sec_3_3_2(results):
    """Return totals over the four sets, and causes of CELECT's failures."""
    precision = results["table_3_4_grids"].settings["localiser"]
    hyperboloidal = results[EXPERIMENTS["hyperboloidal"]]

    def caused(seed, *kinds, of=None):
        stated = causes(results, PRIMARY, seed, of)
        return sum(stated.count(kind) for kind in kinds)

    totals = {
        "opencv_only": lambda ours, theirs: (theirs & ~ours).sum(),
        "celect_only": lambda ours, theirs: (ours & ~theirs).sum(),
        "celect_rate": lambda ours, theirs: 100 * ours.mean(),
        "opencv_rate": lambda ours, theirs: 100 * theirs.mean(),
    }
    counts = {
        "contour_fail": lambda s: caused(s, CONTOUR),
        "sph_missed_fail": lambda s: caused(s, MISSED, of="spherical"),
        "hyp_dirt_fail": lambda s: cleared(hyperboloidal, "spots", s),
        "hyp_glare_fail": lambda s: cleared(hyperboloidal, "glare", s),
        "fish_merge_fail": lambda s: caused(s, MERGED, SPLIT, of="fisheye"),
    }
    reasons = {
        "hyp_dirt_fail": "right once the mirror has no dirt",
        "hyp_glare_fail": "right once there is no glare",
        "fish_merge_fail": "first failed contour: corners merged, or split",
    }
    by_seed = list(of_each_seed(results, OPENCV, PRIMARY))
    of_seeds = {
        name: [count(*pair) for _, *pair in by_seed] for name, count in totals.items()
    } | {name: [count(s) for s, *_ in by_seed] for name, count in counts.items()}
    found = {
        f"s3_3_2_{name}": mean_of_seeds(
            of_seed, "; ".join(filter(None, [reasons.get(name), SEEDS_RANGE]))
        )
        for name, of_seed in of_seeds.items()
    }
    return found | {
        "s3_3_2_sph_noise_fail": Value(
            spared_by_clean_ball(results[EXPERIMENTS["spherical"]]),
            reason="right once the mirror has no flaws; of the 15 pictures of one seed",
        ),
        "s3_3_2_total": Value(len(by_seed[0][1]), unit="count"),
        "s3_3_2_prec": Value(precision["precision_px"], unit="px"),
        "s3_3_2_excess": Value(
            largest_after(results, REFERENCE) - precision["precision_px"],
            unit="px",
            reason="both methods, all seeds; against cornerSubPix from the truth",
        ),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = opened_all(open_results)
    stated = [c for s in seeds_of(results) for c in causes(results, PRIMARY, s)]
    quoted = {
        f"{WHOLE}.{method}": mean_rate(results, method)
        for method in (LINEAR, CLICKLESS)
    } | {
        "contours": stated.count(CONTOUR),
        "largest.apart": largest_far_apart(results, open_results(SPACING)),
        **of_lost(results),
    }
    for name, number in quoted.items():
        value(name, number)


def mean_rate(results, method):
    """Return the mean over the runs of a method's success, in percent."""
    rates = [
        100 * all_right(results, method, PRIMARY, s).mean() for s in seeds_of(results)
    ]
    return float(np.mean(rates))


def of_lost(results):
    """Return how many grids CELECT fails on, and how many have small squares."""
    reach = [
        numbers_of(result, "t8_px")[~right(result, CELECT)]
        for result in results.values()
    ]
    lost = np.concatenate(reach)
    return {
        f"{WHOLE}.lost": len(lost),
        f"small.{WHOLE}.lost": int((lost < SMALL_T8_PX).sum()),
    }
