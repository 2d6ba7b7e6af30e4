"""The claims of section 4.3.2 and of its discussion, seed by seed."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results import (
    BRACKETS,
    CAUSTIC,
    SCATTER,
    SEEDS_OF_BOTH,
    STANDARD,
    bracket_errors,
    by_seed,
    cases,
    disagreement,
)
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.counterpart import decided
from repro.judge.statistics import proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading

LEAST_RATIO, MOST_SIMILAR, LEAST_REDUCTION = 5.0, 2.0, 0.4
MOST_FISH, LEAST_DEPTH = 5.0, 5.0
LEAST_TIGHTER, SIMILAR = 2.0, (0.7, 1.5)
MOST_OF_ALIGNED, STATED_MM, WITHIN = 2.0, 1.0, 0.2
SCATTERS = ("standard_method", "scatter_rays")


def _means(results, camera, options, stage="ray"):
    """Ray-point errors of the standard method and of CGSP, (seeds,) each."""
    standard = STANDARD[options["standard_method"]]
    return [
        by_seed(results, camera, f"{method}.{stage}_mean_mm")
        for method in (standard, "cgsp")
    ]


def _ratio(results, camera, options, stage):
    standard, cgsp = _means(results, camera, options, stage)
    return standard / cgsp


@claim("c4_omni_order_mag", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_order_of_magnitude(results):
    """Standard over CGSP, before and after adjustment."""
    readings = []
    for options in cases("standard_method"):
        before, after = (
            _ratio(results, OMNI, options, stage) for stage in ("ray", "ba")
        )
        readings.append(
            decided(
                (before >= LEAST_RATIO) & (after >= LEAST_RATIO),
                before,
                options,
                "",
                f"ratio before adjustment; after it {np.nanmedian(after):.2f}",
            )
        )
    return readings


@claim("c4_fish_smaller_gap", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_smaller_gap(results):
    """The fisheye's ratios lie between 1 and those of the other camera."""
    readings = []
    for options in cases("standard_method"):
        omni, fish = (
            np.array([_ratio(results, camera, options, s) for s in ("ray", "ba")])
            for camera in (OMNI, FISH)
        )
        readings.append(
            decided(
                np.all((fish > 1) & (fish < omni), axis=0),
                fish[0],
                options,
                "",
                "fisheye's ratio before adjustment; after it "
                f"{np.nanmedian(fish[1]):.3f}; omnidirectional "
                f"{np.nanmedian(omni[0]):.2f} and {np.nanmedian(omni[1]):.3f}",
            )
        )
    return readings


@claim("c4_ba_reduces", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_adjustment(results):
    """Adjustment takes 40 % of the standard error, on both cameras."""
    readings = []
    for options in cases("standard_method"):
        gain = np.array(
            [
                1
                - _means(results, camera, options, "ba")[0]
                / _means(results, camera, options)[0]
                for camera in (OMNI, FISH)
            ]
        )
        readings.append(
            decided(
                np.all(gain >= LEAST_REDUCTION, axis=0),
                100 * gain.min(axis=0),
                options,
                "%",
                f"smaller reduction of the two; omnidirectional "
                f"{100 * np.nanmedian(gain[0]):.0f} %, fisheye "
                f"{100 * np.nanmedian(gain[1]):.0f} %",
            )
        )
    return readings


@claim("c4_raypoint_similar_cams", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_similar_cameras(results):
    """CGSP's errors are alike on both cameras, the standard method's are not."""
    readings = []
    for options in cases("standard_method"):
        omni, fish = (_means(results, camera, options) for camera in (OMNI, FISH))
        apart = [np.maximum(a / b, b / a) for a, b in zip(omni, fish, strict=True)]
        readings.append(
            decided(
                (apart[1] <= MOST_SIMILAR) & (apart[0] >= LEAST_RATIO),
                apart[1],
                options,
                "",
                "larger over smaller mean of CGSP; of the standard method "
                f"{np.nanmedian(apart[0]):.2f}",
            )
        )
    return readings


@claim("c4_accuracy_not_needed_ba", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_unadjusted(results):
    """CGSP as it comes out against the adjusted standard method."""
    readings = []
    for options in cases("standard_method"):
        omni, fish = (
            _means(results, camera, options)[1]
            / _means(results, camera, options, "ba")[0]
            for camera in (OMNI, FISH)
        )
        readings.append(
            decided(
                omni < 1,
                omni,
                options,
                "",
                "CGSP before over standard after adjustment; on the fisheye "
                f"{np.nanmedian(fish):.2f}",
            )
        )
    return readings


@claim("c4_params_fish_agree", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_agreement(results):
    """Parameters of the fisheye agree, the depth of the other camera does not."""
    readings = []
    for options in cases("standard_method"):
        standard = STANDARD[options["standard_method"]]
        fish = disagreement(results, FISH, standard)
        a, b = (by_seed(results, OMNI, f"{m}.cz") for m in (standard, "cgsp"))
        depth = 100 * np.abs(b / a - 1)
        readings.append(
            decided(
                (fish <= MOST_FISH) & (depth > LEAST_DEPTH),
                fish,
                options,
                "%",
                "largest difference on the fisheye; omnidirectional depth "
                f"{np.nanmedian(depth):.2f} %",
            )
        )
    return readings


def _scatter(results, camera, options, key):
    """A measure of the scatter, standard and CGSP, (seeds,) each."""
    which = SCATTER[options.get("scatter_rays", "all rays")]
    methods = STANDARD[options["standard_method"]], "cgsp"
    return [by_seed(results, camera, f"{m}.{which}.{key}") for m in methods]


@claim("c4_centrality_omni", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_omnidirectional_scatter(results):
    """Tighter by a factor of two, rounder, nearer to Gaussian."""
    readings = []
    for options in cases(*SCATTERS):
        (wide, tight), (flat, circular), (far, near) = (
            _scatter(results, OMNI, options, key)
            for key in ("rms_mm", "eigenvalues", "kurtosis")
        )
        ratio = wide / tight
        parts = ratio >= LEAST_TIGHTER, circular > flat, near < far
        told = ", ".join(
            f"{word} in {100 * np.mean(part):.0f} %"
            for word, part in zip(
                ("tighter", "rounder", "nearer to Gaussian"), parts, strict=True
            )
        )
        readings.append(
            decided(np.all(parts, axis=0), ratio, options, "", f"RMS ratio; {told}")
        )
    return readings


@claim("c4_centrality_fish", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_fisheye_scatter(results):
    """Alike in size, and not less Gaussian with CGSP."""
    readings = []
    for options in cases(*SCATTERS):
        wide, tight = _scatter(results, FISH, options, "rms_mm")
        far, near = _scatter(results, FISH, options, "kurtosis")
        ratio = wide / tight
        alike = (ratio >= SIMILAR[0]) & (ratio <= SIMILAR[1])
        told = f"RMS ratio; alike in {100 * np.mean(alike):.0f} %, "
        told += f"not less Gaussian in {100 * np.mean(near <= far):.0f} %"
        readings.append(decided(alike & (near <= far), ratio, options, "", told))
    return readings


@claim("c4_hull", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_hull(results):
    """The centre lies in the hull with CGSP, and outside without."""
    readings = []
    for options in cases(*SCATTERS):
        standard, cgsp = _scatter(results, FISH, options, "inside")
        told = f"seeds with the centre inside: CGSP {np.nansum(cgsp):.0f}, "
        told += f"standard {np.nansum(standard):.0f}"
        holds = (cgsp == 1) & (standard == 0)
        share = proportion(holds.astype(float))
        readings.append(
            Reading(
                "reproduced" if share.value > 0.5 else "differs",
                share.value,
                reading=options,
                interval=(share.low, share.high),
                reason=told,
            )
        )
    return readings


@claim("c6_centrality_both", needs=SEEDS_OF_BOTH, evidence="rendered")
def judge_both_cameras(results):
    """The scatter is tighter with CGSP on both cameras."""
    readings = []
    for options in cases(*SCATTERS):
        ratio = np.array(
            [
                np.divide(*_scatter(results, camera, options, "rms_mm"))
                for camera in (OMNI, FISH)
            ]
        )
        readings.append(
            decided(
                np.all(ratio > 1, axis=0),
                ratio.min(axis=0),
                options,
                "",
                "smaller RMS ratio of the two; omnidirectional "
                f"{np.nanmedian(ratio[0]):.2f}, fisheye {np.nanmedian(ratio[1]):.2f}",
            )
        )
    return readings


@claim("c4_small_misalign", needs=("exp_c4_small_misalign",), evidence="rendered")
def judge_misalignment(results):
    """CGSP's error with a bracket 1 mm off against one that is right."""
    result = results[BRACKETS]
    offsets = sorted({c["offset_mm"] for c in result.conditions})
    found = {offset: bracket_errors(result, offset) for offset in offsets}
    ratio = found[STATED_MM] / found[0.0]
    told = ", ".join(
        f"{offset:g} mm {np.median(found[offset] / found[0.0]):.2f}"
        for offset in offsets[1:]
    )
    told = f"error over that of an aligned bracket: {told}"
    return [decided(ratio <= MOST_OF_ALIGNED, ratio, {}, "", told)]


@claim("c4_caustic_floor", needs=("exp_c4_caustic_floor",), evidence="synthetic")
def judge_caustic(results):
    """The scatter of exact rays after CGSP against the caustic's own."""
    result = results[CAUSTIC]
    scatter, caustic = (result.column(k) for k in ("scatter_mm", "caustic_mm"))
    ratio = scatter / caustic
    told = f"scatter over the caustic's spread of {np.median(caustic):.2f} mm"
    return [decided((scatter > 0) & (np.abs(ratio - 1) <= WITHIN), ratio, {}, "", told)]
