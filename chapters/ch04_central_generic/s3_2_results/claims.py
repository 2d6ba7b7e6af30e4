"""The claims of section 4.3.2 and of its discussion, seed by seed."""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results import (
    BRACKETS,
    CAMERAS,
    CAUSTIC,
    SEEDS_OF_BOTH,
    both,
    disagreement,
    ratio,
    scatter,
)
from chapters.shared.central_sets import FISH, OMNI
from repro.judge.statistics import proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import counterpart

MIN_RATIO, MAX_SIMILAR, MIN_REDUCTION = 5.0, 2.0, 0.4
MAX_FISH, MIN_DEPTH = 5.0, 5.0
MIN_TIGHTER, SIMILAR = 2.0, (0.7, 1.5)
MAX_OF_ALIGNED, STATED_MM = 2.0, 1.0
STANDARD = ("standard_method",)
SCATTERS = ("standard_method", "scatter_rays")
# Before and after adjustment.
STAGES = ("ray_mean_mm", "ba_mean_mm")


@claim("c4_omni_order_mag", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
def judge_order_of_magnitude(results, options):
    """Standard over CGSP, before and after adjustment."""
    before, after = (ratio(results, OMNI, options, stage) for stage in STAGES)
    return counterpart(
        (before >= MIN_RATIO) & (after >= MIN_RATIO),
        before,
        reason=f"ratio before adjustment; after it {np.nanmedian(after):.2f}",
    )


@claim(
    "c4_fish_smaller_gap", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
def judge_smaller_gap(results, options):
    """The fisheye's ratios lie between 1 and those of the other camera."""
    omni, fish = (
        np.array([ratio(results, camera, options, stage) for stage in STAGES])
        for camera in (OMNI, FISH)
    )
    return counterpart(
        np.all((fish > 1) & (fish < omni), axis=0),
        fish[0],
        reason=f"fisheye's ratio before adjustment; after it "
        f"{np.nanmedian(fish[1]):.3f}; omnidirectional "
        f"{np.nanmedian(omni[0]):.2f} and {np.nanmedian(omni[1]):.3f}",
    )


@claim("c4_ba_reduces", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
def judge_adjustment(results, options):
    """Adjustment takes 40 % of the standard error, on both cameras."""

    def gain(camera):
        before, after = (both(results, camera, options, stage)[0] for stage in STAGES)
        return 1 - after / before

    gains = np.array([gain(camera) for camera in CAMERAS.values()])
    omni, fish = 100 * np.nanmedian(gains, axis=1)
    return counterpart(
        np.all(gains >= MIN_REDUCTION, axis=0),
        100 * gains.min(axis=0),
        "%",
        f"smaller reduction of the two; omnidirectional {omni:.0f} %, "
        f"fisheye {fish:.0f} %",
    )


@claim(
    "c4_raypoint_similar_cams",
    needs=SEEDS_OF_BOTH,
    evidence="rendered",
    readings=STANDARD,
)
def judge_similar_cameras(results, options):
    """CGSP's errors are alike on both cameras, the standard method's are not."""
    omni, fish = (
        both(results, camera, options, "ray_mean_mm") for camera in (OMNI, FISH)
    )
    standard, cgsp = np.maximum(omni / fish, fish / omni)
    return counterpart(
        (cgsp <= MAX_SIMILAR) & (standard >= MIN_RATIO),
        cgsp,
        reason="larger over smaller mean of CGSP; of the standard method "
        f"{np.nanmedian(standard):.2f}",
    )


@claim(
    "c4_accuracy_not_needed_ba",
    needs=SEEDS_OF_BOTH,
    evidence="rendered",
    readings=STANDARD,
)
def judge_unadjusted(results, options):
    """CGSP as it comes out against the adjusted standard method."""
    omni, fish = (
        both(results, camera, options, "ray_mean_mm")[1]
        / both(results, camera, options, "ba_mean_mm")[0]
        for camera in (OMNI, FISH)
    )
    return counterpart(
        omni < 1,
        omni,
        reason="CGSP before over standard after adjustment; on the fisheye "
        f"{np.nanmedian(fish):.2f}",
    )


@claim(
    "c4_params_fish_agree", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
def judge_agreement(results, options):
    """Parameters of the fisheye agree, the depth of the other camera does not."""
    fish = disagreement(results, FISH, options)
    depth = disagreement(results, OMNI, options, ("cz",))
    return counterpart(
        (fish <= MAX_FISH) & (depth > MIN_DEPTH),
        fish,
        "%",
        "largest difference on the fisheye; omnidirectional depth "
        f"{np.nanmedian(depth):.2f} %",
    )


@claim(
    "c4_centrality_omni", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_omnidirectional_scatter(results, options):
    """Tighter by a factor of two, rounder, nearer to Gaussian."""
    (wide, tight), (flat, circular), (far, near) = (
        scatter(results, OMNI, options, key)
        for key in ("rms_mm", "eigenvalues", "kurtosis")
    )
    tighter = wide / tight
    parts = {
        "tighter": tighter >= MIN_TIGHTER,
        "rounder": circular > flat,
        "nearer to Gaussian": near < far,
    }
    shares = ", ".join(
        f"{word} in {100 * np.mean(part):.0f} %" for word, part in parts.items()
    )
    holds = np.all(list(parts.values()), axis=0)
    return counterpart(holds, tighter, reason=f"RMS ratio; {shares}")


@claim(
    "c4_centrality_fish", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_fisheye_scatter(results, options):
    """Alike in size, and not less Gaussian with CGSP."""
    tighter = np.divide(*scatter(results, FISH, options, "rms_mm"))
    far, near = scatter(results, FISH, options, "kurtosis")
    alike = (tighter >= SIMILAR[0]) & (tighter <= SIMILAR[1])
    return counterpart(
        alike & (near <= far),
        tighter,
        reason=f"RMS ratio; alike in {100 * np.mean(alike):.0f} %, "
        f"not less Gaussian in {100 * np.mean(near <= far):.0f} %",
    )


@claim("c4_hull", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS)
def judge_hull(results, options):
    """The centre lies in the hull with CGSP, and outside without."""
    standard, cgsp = scatter(results, FISH, options, "inside")
    share = proportion(((cgsp == 1) & (standard == 0)).astype(float))
    return Reading.of(
        share.value > 0.5,
        share,
        reason=f"seeds with the centre inside: CGSP {np.nansum(cgsp):.0f}, "
        f"standard {np.nansum(standard):.0f}",
    )


@claim(
    "c6_centrality_both", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_both_cameras(results, options):
    """The scatter is tighter with CGSP on both cameras."""
    tighter = np.array(
        [
            np.divide(*scatter(results, camera, options, "rms_mm"))
            for camera in (OMNI, FISH)
        ]
    )
    omni, fish = np.nanmedian(tighter, axis=1)
    return counterpart(
        np.all(tighter > 1, axis=0),
        tighter.min(axis=0),
        reason=f"smaller RMS ratio of the two; omnidirectional {omni:.2f}, "
        f"fisheye {fish:.2f}",
    )


@claim("c4_small_misalign", needs=("exp_c4_small_misalign",), evidence="rendered")
def judge_misalignment(results):
    """CGSP's error with a bracket 1 mm off against one that is right."""
    errors = {
        offset: seeds.column("cgsp.ray_mean_mm")
        for offset, seeds in results[BRACKETS].by("offset_mm").items()
    }
    aligned = errors.pop(0.0)
    ratios = {offset: found / aligned for offset, found in errors.items()}
    words = ", ".join(
        f"{mm:g} mm {np.median(found):.2f}" for mm, found in ratios.items()
    )
    stated = ratios[STATED_MM]
    return counterpart(
        stated <= MAX_OF_ALIGNED,
        stated,
        reason=f"error over that of an aligned bracket: {words}",
    )


@claim("c4_caustic_floor", needs=("exp_c4_caustic_floor",), evidence="synthetic")
def judge_caustic(results):
    """Exact rays scatter after CGSP by no less than their caustic spreads."""
    scattered, caustic = (
        results[CAUSTIC].column(name) for name in ("scatter_mm", "caustic_mm")
    )
    over = scattered / caustic
    return counterpart(
        (caustic > 0) & (over >= 1),
        over,
        reason=f"scatter over the caustic's spread of {np.median(caustic):.2f} mm",
    )
