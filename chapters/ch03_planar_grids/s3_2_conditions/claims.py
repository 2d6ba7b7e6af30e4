"""The remarks of section 3.3.2 that are claims, tested on rendered pictures."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.stats import norm

from chapters.ch03_planar_grids.s3_2_conditions.results import (
    CAMERAS,
    SPOTS,
    all_orders,
    differing,
    in_light,
    levels_run,
    logistic_slope,
    merging_of,
    numbers_of,
    shadow_effects,
)
from chapters.shared.grid_detectors import CELECT, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import HARD, WHOLE
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    UNDECIDED,
    all_of,
    paired_gain,
    proportion,
)
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

DETECTORS_OF_TODAY = (OPENCV, OPENCV_SB)
POSE_RANGES = (WHOLE, HARD)
COPES = 0.7
LEAST_GAIN = 0.3
SAME, LEAST_DROP = 0.05, 0.15
LEAST_RATIO = 1.3
# The text speaks of the fisheye image alone.
NEARER_WITH = "fisheye"
# Who extracts fewer than this has nothing that a shadow could take.
ENOUGH = 0.2
SEEDS_THAT_HOLD = 0.9
MOST_DIFFERING = 0.25
FEWEST_FAILURES = 10
EDGE = 1e-9


@claim("c3_low_contrast", needs=("exp_c3_low_contrast",), evidence="rendered")
def judge_low_contrast(results):
    """CELECT at least 0.3 ahead in the lowest light in which it has 0.7."""
    result = results["exp_c3_low_contrast"]
    return [
        ahead_in_low_light(result, method, poses, spots)
        for method, poses, spots in product(DETECTORS_OF_TODAY, POSE_RANGES, SPOTS)
    ]


def ahead_in_low_light(result, method, poses, spots):
    """One reading of it."""
    ours, theirs = (
        {v: in_light(result, v, m, poses, spots) for v in levels_run(result)}
        for m in (CELECT, method)
    )
    rates = {v: found.mean() for v, found in ours.items()}
    copes = [v for v, rate in rates.items() if rate >= COPES]
    level = min(copes) if copes else max(rates, key=rates.get)
    found = paired_gain(ours[level], theirs[level])
    decision = found.above(LEAST_GAIN - EDGE)
    told = f"the lowest of which CELECT extracts {100 * COPES:.0f} %"
    if not copes:
        told = (
            f"in which CELECT extracts most, {100 * rates[level]:.0f} %, as it "
            f"extracts {100 * COPES:.0f} % in none"
        )
        decision = all_of([decision, proportion(ours[level]).above(COPES)])
    return Reading(
        DECISIONS[decision],
        found.value,
        interval=(found.low, found.high),
        reading={"opencv_detector": method, "pose_range": poses, "spots": spots},
        unit="1",
        reason=f"success of CELECT less OpenCV's in {level:g} of full light, "
        f"{told}; {len(ours[level])} images",
    )


@claim("c3_shadow", needs=("exp_c3_shadow",), evidence="rendered")
def judge_shadow(results):
    """CELECT unchanged within 5 points, OpenCV down by 15 or more."""
    result = results["exp_c3_shadow"]
    readings = []
    for method, poses in product(DETECTORS_OF_TODAY, POSE_RANGES):
        ours = shadow_effects(result, CELECT, poses)
        plain = numbers_of(result, f"plain.{CELECT}", poses)
        unchanged = ours.within(-SAME, SAME)
        if unchanged == HOLDS and plain.mean() < ENOUGH:
            unchanged = UNDECIDED
        theirs = shadow_effects(result, method, poses)
        decision = all_of([unchanged, theirs.above(LEAST_DROP - EDGE)])
        readings.append(
            Reading(
                DECISIONS[decision],
                theirs.value,
                interval=(theirs.low, theirs.high),
                reading={"opencv_detector": method, "pose_range": poses},
                unit="1",
                reason="loss of OpenCV's success to the shadow; CELECT loses "
                f"{100 * ours.value:.1f} points ({100 * ours.low:.1f} to "
                f"{100 * ours.high:.1f}) of {100 * plain.mean():.0f}, in "
                f"{len(plain)} images",
            )
        )
    return readings


def partial_predicates(ours, theirs, method):
    """Per seed (n,): whether CELECT's part is larger for both, and nearer by fisheye.

    Also the smaller of the two ratios of the counts, (n,).
    """
    seeds = theirs.trials_per_condition
    holds, ratios = np.ones(seeds, bool), np.full(seeds, np.inf)
    for camera in CAMERAS:
        a, b = (
            {
                name: result.column(f"{who}.{name}", camera=camera)[:seeds]
                for name in ("count", "border_px")
            }
            for who, result in ((CELECT, ours), (method, theirs))
        )
        ratio = np.divide(
            a["count"], b["count"], out=np.full(seeds, np.inf), where=b["count"] > 0
        )
        holds &= ratio > LEAST_RATIO
        if camera == NEARER_WITH:
            holds &= np.where(
                b["count"] > 0, a["border_px"] < b["border_px"], a["count"] > 0
            )
        ratios = np.minimum(ratios, ratio)
    return holds, ratios


@claim(
    "c3_partial_grid",
    needs=("fig_3_14_parts", "fig_3_14_parts_sb"),
    evidence="rendered",
)
def judge_partial_grid(results):
    """Larger by 1.3 for both cameras, and nearer to the frame by fisheye."""
    ours = results["fig_3_14_parts"]
    readings = []
    for method, theirs in ((OPENCV, ours), (OPENCV_SB, results["fig_3_14_parts_sb"])):
        holds, ratios = partial_predicates(ours, theirs, method)
        readings.append(
            Reading(
                DECISIONS[HOLDS if holds.mean() >= SEEDS_THAT_HOLD else FAILS],
                float(np.median(ratios)),
                interval=(float(ratios.min()), float(ratios.max())),
                reading={"opencv_detector": method},
                unit="1",
                reason="corners of CELECT over OpenCV's, of the worse camera; "
                "median and range over the pictures. The predicate is true "
                f"for {holds.sum()} of {len(holds)} pairs of pictures",
            )
        )
    return readings


@claim("c3_trace_direction", needs=("exp_c3_trace_direction",), evidence="rendered")
def judge_trace_direction(results):
    """Some images differ, fewer than a quarter."""
    readings = []
    for poses in POSE_RANGES:
        orders = all_orders(results["exp_c3_trace_direction"], poses=poses)
        found = proportion(differing(orders))
        decision = found.within(0, MOST_DIFFERING)
        if decision == HOLDS and not found.value:
            decision = UNDECIDED
        always, never = orders.min(axis=(0, 1)), 1 - orders.max(axis=(0, 1))
        readings.append(
            Reading(
                DECISIONS[decision],
                found.value,
                interval=(found.low, found.high),
                reading={"pose_range": poses},
                unit="1",
                reason=f"share of {len(always)} images in which the order of "
                f"the clicks decides over success; {100 * always.mean():.0f} "
                f"% succeed in all eight, {100 * never.mean():.0f} % in none",
            )
        )
    return readings


@claim("c3_first_corner", needs=("exp_c3_trace_direction",), evidence="rendered")
def judge_first_corner(results):
    """Smallest square first, less largest first: not below 0."""
    readings = []
    for poses in POSE_RANGES:
        orders = all_orders(results["exp_c3_trace_direction"], poses=poses)
        smallest, *_, largest = orders[0]
        found = paired_gain(smallest, largest)
        if found.low >= 0 < found.value:
            decision = HOLDS
        else:
            decision = FAILS if found.high < 0 else UNDECIDED
        readings.append(
            Reading(
                DECISIONS[decision],
                found.value,
                interval=(found.low, found.high),
                reading={"pose_range": poses},
                unit="1",
                reason="success from the corner of the smallest square less "
                f"that from the largest, same {len(smallest)} images and "
                "clicks, clockwise; from the smallest "
                f"{100 * smallest.mean():.0f} % succeed",
            )
        )
    return readings


@claim(
    "c3_size_variation_merge",
    needs=("exp_c3_shadow", "exp_c3_merge_images"),
    evidence="rendered",
)
def judge_size_variation(results):
    """Positive logistic slope, p < 0.05; ten failures at least."""
    return [slope_of_failures(results, poses) for poses in POSE_RANGES]


def slope_of_failures(results, poses):
    """One reading of it."""
    ratio, failed, _ = merging_of(results, poses=poses)
    slope, error = logistic_slope(ratio, failed)
    p = 2 * norm.sf(abs(slope) / error) if np.isfinite(slope) else 1.0
    count = int(failed.sum())
    if count < FEWEST_FAILURES or not np.isfinite(slope):
        decision, slope = UNDECIDED, slope if np.isfinite(slope) else 0.0
    else:
        decision = HOLDS if p < 0.05 and slope > 0 else FAILS
    interval = None
    if np.isfinite(error):
        interval = (slope - 1.96 * error, slope + 1.96 * error)
    return Reading(
        DECISIONS[decision],
        slope,
        interval=interval,
        reading={"pose_range": poses},
        unit="1",
        reason="rise of the log odds of a merge failure with the ratio of "
        f"longest to shortest step; p = {p:.2g}; {count} merge failures "
        f"in {len(failed)} images",
    )
