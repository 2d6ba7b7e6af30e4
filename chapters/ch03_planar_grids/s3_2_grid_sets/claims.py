"""The judgements of this page's claims."""

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.experiment import CONTOUR, TRUTH
from chapters.ch03_planar_grids.s3_2_grid_sets.report import (
    EXPERIMENTS,
    GRIDS,
    GRIDS_AND_SPACING,
    MIN_SPACING_PX,
    SPACING,
    Which,
    apart,
    causes,
    errors,
    numbers_of,
    of_each_seed,
    right,
    seed_by_seed,
    seeds_of,
    spread,
)
from chapters.shared.grids import CELECT, OPENCV
from repro.run import FAILS, NOT_COMPARABLE, Reading, claim, mcnemar

# Claims of section 3.3.2 about errors of corners, over correct grids alone.


MAX_LOCALISED_PX, MAX_GAP_PX = 0.22, 0.01
LEFT_OUT = "a set in which one of them finds nothing is left out"


def pairs_by_seed(results, options, errors_of):
    """Errors (N,), (N,) of the detector and of CELECT, of every set that has both.

    options: of the ledger's questions; errors_of: (result, method, which, seed) -> the
    errors of each grid that counts. Returns a list of pairs for every seed that has
    some.
    """
    which = Which.of(options)
    methods = options["opencv_detector"], CELECT
    found = [
        [
            [errors_of(result, m, which, seed) for m in methods]
            for result in results.values()
        ]
        for seed in seeds_of(results, which)
    ]
    of_both = [
        [tuple(map(np.concatenate, pair)) for pair in of_seed if all(pair)]
        for of_seed in found
    ]
    return [pairs for pairs in of_both if pairs]


@claim(
    "c3_less_accurate_raw",
    needs=GRIDS,
    evidence="rendered",
    readings=("opencv_detector", "pose_range", "spots"),
)
def judge_less_accurate_raw(results, options):
    """Mean and largest error before localisation: CELECT's are larger.

    Against truth alone, as the test has it.
    """

    def before(result, method, which, seed):
        return errors(result, method, "before", TRUTH, which, seed)

    seeds = pairs_by_seed(results, options, before)
    ratios = [[ours.mean() / theirs.mean() for theirs, ours in s] for s in seeds]
    holds = [
        min(of_means) > 1 and all(ours.max() > theirs.max() for theirs, ours in pairs)
        for of_means, pairs in zip(ratios, seeds, strict=True)
    ]
    return seed_by_seed(
        holds,
        spread(np.concatenate(ratios)) if seeds else "none",
        "mean error of CELECT over that of the detector, mean and range over sets "
        f"and seeds; {LEFT_OUT}",
    )


@claim(
    "c3_same_after_loc",
    needs=GRIDS_AND_SPACING,
    evidence="rendered",
    readings=(
        "opencv_detector",
        "pose_range",
        "spots",
        "corner_reference",
        "localiser_window",
        "corner_spacing",
    ),
)
def judge_same_after_loc(results, options):
    """After localisation: no error above 0.22 px, means within 0.01 px."""
    reference, window = options["corner_reference"], options["localiser_window"]
    least_px = MIN_SPACING_PX[options["corner_spacing"]]

    def after(result, method, which, seed):
        found = errors(result, method, "after", reference, which, seed, window)
        return apart(found, result, results[SPACING], least_px, method, which, seed)

    seeds = pairs_by_seed({name: results[name] for name in GRIDS}, options, after)
    largest = [max(max(e.max() for e in pair) for pair in pairs) for pairs in seeds]
    gaps = [max(abs(a.mean() - b.mean()) for a, b in pairs) for pairs in seeds]
    holds = [
        high <= MAX_LOCALISED_PX and gap <= MAX_GAP_PX
        for high, gap in zip(largest, gaps, strict=True)
    ]
    return seed_by_seed(
        holds,
        float(max(largest)) if seeds else "none to compare",
        "largest error of either after localisation; largest difference of means: "
        f"{max(gaps, default=0):.3f} px; {LEFT_OUT}",
        "px",
    )


# Claims of section 3.3.2 about numbers of extracted grids, run by run.
#
# A claim about hardware that is not available holds if it is true of at least 90 % of
# the simulated runs.


MIN_EXCESS, MAX_CHANCE = 20, 0.001
RARE = 0.2
CONTOUR_SHARE = 1 / 3
FLEXIBLE_RATE = 0.93
PICTURES = ("pose_range", "spots")
PICTURES_AND_DETECTOR = ("opencv_detector", "pose_range", "spots")


@claim(
    "c3_beats_opencv", needs=GRIDS, evidence="rendered", readings=PICTURES_AND_DETECTOR
)
def judge_beats_opencv(results, options):
    """More in each set, and 20 points more in all, not by chance."""
    detector, which = options["opencv_detector"], Which.of(options)
    holds, excess, rates = [], [], []
    for seed, ours, theirs in of_each_seed(results, detector, which):
        excess.append(100 * (ours.mean() - theirs.mean()))
        rates.append(100 * theirs.mean())
        more = all(
            right(result, CELECT, which, seed).sum()
            > right(result, detector, which, seed).sum()
            for result in results.values()
        )
        sure = mcnemar(ours, theirs) < MAX_CHANCE
        holds.append(more and sure and excess[-1] >= MIN_EXCESS)
    return seed_by_seed(
        holds,
        spread(excess),
        "CELECT's success rate less that of the detector, mean and range of the seeds; "
        f"the detector has {np.mean(rates):.0f} %, and above 80 % nobody can be 20 "
        "points ahead",
        "percentage points",
    )


@claim("c3_subset", needs=GRIDS, evidence="rendered", readings=PICTURES_AND_DETECTOR)
def judge_subset(results, options):
    """Grids only OpenCV finds: at most a fifth of those only CELECT finds."""
    alone_and_spared = [
        ((theirs & ~ours).sum(), (ours & ~theirs).sum())
        for _, ours, theirs in of_each_seed(
            results, options["opencv_detector"], Which.of(options)
        )
    ]
    return seed_by_seed(
        [a <= RARE * spared for a, spared in alone_and_spared if a + spared],
        ", ".join(f"{alone} to {spared}" for alone, spared in alone_and_spared),
        "pictures that only the detector, to those that only CELECT gets right, by "
        "seed",
    )


@claim("c3_fail_causes", needs=GRIDS, evidence="rendered", readings=PICTURES)
def judge_fail_causes(results, options):
    """Lost contours are at most a third of CELECT's failures."""
    which = Which.of(options)
    found = [causes(results, which, seed) for seed in seeds_of(results, which)]
    lost_of = [(kinds.count(CONTOUR), len(kinds)) for kinds in found]
    return seed_by_seed(
        [lost <= CONTOUR_SHARE * count for lost, count in lost_of if count],
        ", ".join(f"{lost} of {count}" for lost, count in lost_of),
        "failures in which a contour was lost, by seed; the first failed contour of a "
        "picture tells",
    )


@claim("c3_opencv_missed", needs=GRIDS, evidence="rendered", readings=PICTURES)
def judge_opencv_missed(results, options):
    """Share of corners that a Harris detector finds where current OpenCV fails."""
    shares, returned, good = (
        np.concatenate([numbers_of(r, n, Which.of(options)) for r in results.values()])
        for n in ("independent", f"{OPENCV}.returned", f"{OPENCV}.success")
    )
    shares = shares[np.isfinite(shares)]
    if not len(shares):
        reason = "differs (today's software): OpenCV did not fail"
        return Reading.of(FAILS, "no failure", reason=reason)
    wrong = int(((returned == 1) & (good == 0)).sum())
    return Reading.of(
        NOT_COMPARABLE,
        spread(shares),
        reason="today's function returns no unordered "
        "corners. Mean and range of the share of corners that a Harris "
        f"detector sees in the {len(shares)} pictures in which it fails; "
        f"in {wrong} of them it returned wrong corners, else none",
    )


@claim(
    "c3_examples_exist",
    needs=GRIDS,
    evidence="rendered",
    readings=PICTURES_AND_DETECTOR,
)
def judge_examples_exist(results, options):
    """Both classes in every set, and CELECT nearly always in the last."""
    which = Which.of(options)
    holds, rates = [], []
    for seed in seeds_of(results, which):
        classes = []
        for result in results.values():
            ours, theirs = (
                right(result, method, which, seed)
                for method in (CELECT, options["opencv_detector"])
            )
            classes += [(ours & theirs).any(), (ours & ~theirs).any()]
        flexible = results[EXPERIMENTS["flexible-mirror"]]
        rates.append(right(flexible, CELECT, which, seed).mean())
        holds.append(all(classes) and rates[-1] >= FLEXIBLE_RATE)
    return seed_by_seed(
        holds,
        spread(rates),
        "CELECT's success rate in the Flexible Mirror set, mean and range of the seeds",
    )
