"""Claims from the remarks of section 3.3.2, tested on rendered images."""

import numpy as np
from scipy.stats import norm

from chapters.ch03_planar_grids.s3_2_conditions.report import (
    CAMERAS,
    all_orders,
    differing,
    in_light,
    levels_run,
    logistic_fit,
    merging_of,
    numbers_of,
    shadow_effects,
)
from chapters.shared.grids import CELECT, OPENCV_SB
from repro.run import (
    DECISIONS,
    FAILS,
    HOLDS,
    UNDECIDED,
    Estimate,
    Reading,
    all_of,
    claim,
    paired_gain,
    proportion,
)

COPES = 0.7
MIN_GAIN = 0.3
SAME, MIN_DROP = 0.05, 0.15
MIN_RATIO = 1.3
# The thesis mentions the fisheye image only.
NEARER_WITH = "fisheye"
# Below this success without shadow, a loss cannot be judged.
MIN_PLAIN_SUCCESS = 0.2
MAX_DIFFERING = 0.25
MIN_FAILURES = 10
EDGE = 1e-9


@claim(
    "c3_low_contrast",
    needs=("exp_c3_low_contrast",),
    evidence="rendered",
    readings=("opencv_detector", "pose_range", "spots"),
)
def judge_low_contrast(results, options):
    """CELECT at least 0.3 ahead in the lowest light in which it has 0.7."""
    result = results["exp_c3_low_contrast"]
    ours, theirs = (
        in_light(result, method, options["pose_range"], options["spots"])
        for method in (CELECT, options["opencv_detector"])
    )
    rates = ours.mean(axis=1)
    copes = np.flatnonzero(rates >= COPES)
    darkest = copes[-1] if len(copes) else rates.argmax()
    found = paired_gain(ours[darkest], theirs[darkest])
    decision = found.above(MIN_GAIN - EDGE)
    light = f"the lowest of which CELECT extracts {100 * COPES:.0f} %"
    if not len(copes):
        light = (
            f"in which CELECT extracts most, {100 * rates[darkest]:.0f} %, as it "
            f"extracts {100 * COPES:.0f} % in no light"
        )
        decision = all_of([decision, proportion(ours[darkest]).above(COPES)])
    return Reading.of(
        decision,
        found,
        "1",
        f"success of CELECT less OpenCV's in {levels_run(result)[darkest]:g} of full "
        f"light, {light}; {ours.shape[1]} images",
    )


@claim(
    "c3_shadow",
    needs=("exp_c3_shadow",),
    evidence="rendered",
    readings=("opencv_detector", "pose_range"),
)
def judge_shadow(results, options):
    """CELECT unchanged within 5 points, OpenCV down by 15 or more."""
    result, poses = results["exp_c3_shadow"], options["pose_range"]
    ours = shadow_effects(result, CELECT, poses)
    plain = numbers_of(result, "plain", CELECT, poses=poses)
    unchanged = ours.within(-SAME, SAME)
    if unchanged == HOLDS and plain.mean() < MIN_PLAIN_SUCCESS:
        unchanged = UNDECIDED
    theirs = shadow_effects(result, options["opencv_detector"], poses)
    return Reading.of(
        all_of([unchanged, theirs.above(MIN_DROP - EDGE)]),
        theirs,
        "1",
        "loss of OpenCV's success to the shadow; CELECT loses "
        f"{100 * ours.value:.1f} points ({100 * ours.low:.1f} to "
        f"{100 * ours.high:.1f}) of {100 * plain.mean():.0f}, in {len(plain)} images",
    )


def partial_predicates(ours, theirs, method):
    """Return per run (n,) whether CELECT's parts are larger and nearer the border.

    Also returns the smaller of the two ratios of the counts, (n,).
    """
    runs = theirs.trials_per_condition
    holds, ratios = np.ones(runs, bool), np.full(runs, np.inf)
    for camera in CAMERAS:
        (count, border_px), (their_count, their_border_px) = (
            result.column(who, ("count", "border_px"), camera=camera)[:, :runs]
            for who, result in ((CELECT, ours), (method, theirs))
        )
        found = their_count > 0
        ratio = np.divide(count, their_count, out=np.full(runs, np.inf), where=found)
        holds &= ratio > MIN_RATIO
        if camera == NEARER_WITH:
            holds &= np.where(found, border_px < their_border_px, count > 0)
        ratios = np.minimum(ratios, ratio)
    return holds, ratios


@claim(
    "c3_partial_grid",
    needs=("fig_3_14_parts", "fig_3_14_parts_sb"),
    evidence="rendered",
    readings=("opencv_detector",),
)
def judge_partial_grid(results, options):
    """Larger by 1.3 for both cameras, and nearer to the frame by fisheye."""
    ours, of_sectors = results["fig_3_14_parts"], results["fig_3_14_parts_sb"]
    method = options["opencv_detector"]
    theirs = of_sectors if method == OPENCV_SB else ours
    holds, ratios = partial_predicates(ours, theirs, method)
    return Reading.of_seeds(
        holds,
        Estimate(np.median(ratios), ratios.min(), ratios.max()),
        "1",
        "corners of CELECT over OpenCV's, of the worse camera; "
        "median and range over the images. The predicate is true "
        f"for {holds.sum()} of {len(holds)} pairs of images",
    )


@claim(
    "c3_trace_direction",
    needs=("exp_c3_trace_direction",),
    evidence="rendered",
    readings=("pose_range",),
)
def judge_trace_direction(results, options):
    """Some images differ, fewer than a quarter."""
    result = results["exp_c3_trace_direction"]
    orders = all_orders(result, poses=options["pose_range"])
    found = proportion(differing(orders))
    decision = found.within(0, MAX_DIFFERING)
    if decision == HOLDS and not found.value:
        decision = UNDECIDED
    always, never = orders.min(axis=(0, 1)), 1 - orders.max(axis=(0, 1))
    return Reading.of(
        decision,
        found,
        "1",
        f"share of {len(always)} images in which the order of "
        f"the clicks decides over success; {100 * always.mean():.0f} "
        f"% succeed in all eight, {100 * never.mean():.0f} % in no order",
    )


@claim(
    "c3_first_corner",
    needs=("exp_c3_trace_direction",),
    evidence="rendered",
    readings=("pose_range",),
)
def judge_first_corner(results, options):
    """Smallest square first, less largest first: not below 0."""
    result = results["exp_c3_trace_direction"]
    smallest, *_, largest = all_orders(result, poses=options["pose_range"])[0]
    found = paired_gain(smallest, largest)
    decision = FAILS if found.high < 0 else UNDECIDED
    if found.low >= 0 < found.value:
        decision = HOLDS
    return Reading.of(
        decision,
        found,
        "1",
        "success from the corner of the smallest square less "
        f"that from the largest, same {len(smallest)} images and "
        "clicks, clockwise; from the smallest "
        f"{100 * smallest.mean():.0f} % succeed",
    )


@claim(
    "c3_size_variation_merge",
    needs=("exp_c3_shadow", "exp_c3_merge_images"),
    evidence="rendered",
    readings=("pose_range",),
)
def judge_size_variation(results, options):
    """Positive logistic slope, p < 0.05; ten failures at least."""
    ratio, failed = merging_of(results, poses=options["pose_range"])
    slope, error, _ = logistic_fit(ratio, failed)
    known, count = np.isfinite(slope), int(failed.sum())
    p = 2 * norm.sf(abs(slope) / error) if known else 1.0
    decision = HOLDS if p < 0.05 and slope > 0 else FAILS
    if count < MIN_FAILURES or not known:
        decision = UNDECIDED
    ends = (slope - 1.96 * error, slope + 1.96 * error)
    return Reading(
        DECISIONS[decision],
        slope if known else 0.0,
        interval=ends if np.isfinite(error) else None,
        unit="1",
        reason="rise of the log odds of a merge failure with the ratio of "
        f"longest to shortest step; p = {p:.2g}; {count} merge failures "
        f"in {len(failed)} images",
    )
