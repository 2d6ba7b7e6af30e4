"""The judgements of this page's claims."""

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.experiment import CONTOUR, TRUTH
from chapters.ch03_planar_grids.s3_2_grid_sets.report import (
    EXPERIMENTS,
    GRIDS,
    MIN_SPACING_PX,
    SPACING,
    Which,
    causes,
    errors,
    numbers_of,
    right,
    right_by_run,
    seeds_of,
    spread,
)
from chapters.shared.grids import CELECT, OPENCV
from repro.run import FAILS, NOT_COMPARABLE, Reading, claim, mcnemar

# Verdicts of predicates that are tested run by run.


def run_by_run(holds, found, reason, unit=""):
    """Return the Reading of a predicate from the runs that it applies to.

    found: what was measured, as `Reading.of` takes it.
    """
    runs = f"true of {int(np.sum(holds))} of {len(holds)} simulated runs"
    runs = runs if holds else "it applies to no run"
    return Reading.of_seeds(holds, found, unit, f"{reason}; {runs}")


# Claims of section 3.3.2 about errors of corners, over correct grids alone.


# The grids, and the distances of their corners.
GRIDS_AND_SPACING = (
    "table_3_4_grids",
    "table_3_5_grids",
    "table_3_6_grids",
    "table_3_7_grids",
    "exp_c3_same_after_loc",
)
MAX_LOCALISED_PX, MAX_GAP_PX = 0.22, 0.01
LEFT_OUT = "a set in which one of them finds nothing is left out"


def pairs_by_run(results, options, errors_of):
    """Errors (N,), (N,) of the detector and of CELECT, of every set that has both.

    options: of the registry's questions; errors_of: (result, method, which, seed) ->
    the errors of each grid that counts. Returns a list of pairs for every run that
    has some.
    """
    which = Which.of(options)
    methods = options["opencv_detector"], CELECT
    by_run = [
        [[errors_of(results[name], m, which, seed) for m in methods] for name in GRIDS]
        for seed in seeds_of(results, which)
    ]
    of_both = [
        [tuple(map(np.concatenate, pair)) for pair in run if all(pair)]
        for run in by_run
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

    runs = pairs_by_run(results, options, before)
    ratios = [[ours.mean() / theirs.mean() for theirs, ours in pairs] for pairs in runs]
    holds = [
        min(of_means) > 1 and all(ours.max() > theirs.max() for theirs, ours in pairs)
        for of_means, pairs in zip(ratios, runs, strict=True)
    ]
    return run_by_run(
        holds,
        spread(np.concatenate(ratios)) if runs else "none",
        "mean error of CELECT over that of the detector, mean and range over sets "
        f"and simulated runs; {LEFT_OUT}",
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
    apart = results[SPACING], MIN_SPACING_PX[options["corner_spacing"]]

    def after(result, method, which, seed):
        return errors(result, method, "after", reference, which, seed, window, apart)

    runs = pairs_by_run(results, options, after)
    largest = [max(e.max() for pair in pairs for e in pair) for pairs in runs]
    gaps = [max(abs(a.mean() - b.mean()) for a, b in pairs) for pairs in runs]
    holds = [
        high <= MAX_LOCALISED_PX and gap <= MAX_GAP_PX
        for high, gap in zip(largest, gaps, strict=True)
    ]
    return run_by_run(
        holds,
        float(max(largest)) if runs else "none to compare",
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
OF_IMAGES = ("pose_range", "spots")
OF_IMAGES_AND_DETECTOR = ("opencv_detector", "pose_range", "spots")


@claim(
    "c3_beats_opencv", needs=GRIDS, evidence="rendered", readings=OF_IMAGES_AND_DETECTOR
)
def judge_beats_opencv(results, options):
    """More in each set, and 20 points more in all, not by chance."""
    which, methods = Which.of(options), (CELECT, options["opencv_detector"])
    ours, theirs = (right_by_run(results, method, which) for method in methods)
    excess = 100 * (ours.mean(axis=1) - theirs.mean(axis=1))
    holds = [
        points >= MIN_EXCESS
        and mcnemar(*of_run) < MAX_CHANCE
        and np.greater(*counts_by_set(results, methods, which, seed)).all()
        for points, seed, *of_run in zip(
            excess, seeds_of(results, which), ours, theirs, strict=True
        )
    ]
    return run_by_run(
        holds,
        spread(excess),
        "CELECT's success rate less that of the detector, mean and range of the "
        f"simulated runs; the detector has {100 * theirs.mean():.0f} %, and above 80 % "
        "nobody can be 20 points ahead",
        "percentage points",
    )


def counts_by_set(results, methods, which, seed):
    """Numbers of correct grids of a run, (methods, sets)."""
    return np.array(
        [[right(results[e], m, which, seed).sum() for e in GRIDS] for m in methods]
    )


@claim("c3_subset", needs=GRIDS, evidence="rendered", readings=OF_IMAGES_AND_DETECTOR)
def judge_subset(results, options):
    """Grids only OpenCV finds: at most a fifth of those only CELECT finds."""
    ours, theirs = (
        right_by_run(results, method, Which.of(options))
        for method in (CELECT, options["opencv_detector"])
    )
    alone = np.sum([theirs & ~ours, ours & ~theirs], axis=2).T
    return run_by_run(
        [one <= RARE * other for one, other in alone if one + other],
        ", ".join(f"{one} to {other}" for one, other in alone),
        "images that only the detector, to those that only CELECT gets right, by "
        "simulated run",
    )


@claim("c3_fail_causes", needs=GRIDS, evidence="rendered", readings=OF_IMAGES)
def judge_fail_causes(results, options):
    """Lost contours are at most a third of CELECT's failures."""
    which = Which.of(options)
    found = [causes(results, which, seed) for seed in seeds_of(results, which)]
    lost_of = [(kinds.count(CONTOUR), len(kinds)) for kinds in found]
    return run_by_run(
        [lost <= CONTOUR_SHARE * count for lost, count in lost_of if count],
        ", ".join(f"{lost} of {count}" for lost, count in lost_of),
        "failures in which a contour was lost, by simulated run; the first failed "
        "contour of an image counts",
    )


@claim("c3_opencv_missed", needs=GRIDS, evidence="rendered", readings=OF_IMAGES)
def judge_opencv_missed(results, options):
    """Share of corners that a Harris detector finds where current OpenCV fails."""
    shares, returned, good = (
        np.concatenate(
            [numbers_of(results[e], *path, which=Which.of(options)) for e in GRIDS]
        )
        for path in (("independent",), (OPENCV, "returned"), (OPENCV, "success"))
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
        f"detector finds in the {len(shares)} images in which it fails; "
        f"in {wrong} of them it returned wrong corners, else no corners",
    )


@claim(
    "c3_examples_exist",
    needs=GRIDS,
    evidence="rendered",
    readings=OF_IMAGES_AND_DETECTOR,
)
def judge_examples_exist(results, options):
    """Both classes in every set, and CELECT nearly always in the last."""
    which = Which.of(options)
    holds, rates = [], []
    for seed in seeds_of(results, which):
        classes = []
        for name in GRIDS:
            ours, theirs = (
                right(results[name], method, which, seed)
                for method in (CELECT, options["opencv_detector"])
            )
            classes += [(ours & theirs).any(), (ours & ~theirs).any()]
        flexible = results[EXPERIMENTS["flexible-mirror"]]
        rates.append(right(flexible, CELECT, which, seed).mean())
        holds.append(all(classes) and rates[-1] >= FLEXIBLE_RATE)
    return run_by_run(
        holds,
        spread(rates),
        "CELECT's success rate in the Flexible Mirror set, mean and range of "
        "the simulated runs",
    )
