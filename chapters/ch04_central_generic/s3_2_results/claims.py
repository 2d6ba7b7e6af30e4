"""The claims of section 4.3.2 and of its discussion.

Most are judged run by run: a predicate takes the `CentralRuns` of an interpretation. It
returns whether it is true (runs,), the measured value (runs,), its unit, and a reason.
"""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.report import (
    BOTH,
    CAMERAS,
    QUESTIONS,
    disagreement,
    runs_of,
)
from chapters.shared.central import (
    FISH,
    OMNI,
    counterpart_over_the_sweep,
    judged_by_run,
    over_the_sweep,
)
from repro.run import Case, Reading, claim, counterpart, proportion, with_worst

MIN_RATIO, MAX_SIMILAR, MIN_REDUCTION = 5.0, 2.0, 0.4
MAX_FISH, MIN_DEPTH = 5.0, 5.0  # % of a parameter
MIN_TIGHTER, SIMILAR = 2.0, (0.7, 1.5)
STANDARD = ("decoding_noise", "standard_method")
SCATTERS = ("decoding_noise", "standard_method", "scatter_rays")
WITH_SIMULATED = ("table_4_3_rendered", "table_4_3_redrawn", "fig_4_2_redrawn")
STAGES = ("ray_mean_mm", "ba_mean_mm")  # before and after adjustment


def ratios(runs, camera):
    """Return standard over CGSP of the errors at both STAGES, (2, runs)."""
    return np.divide(*runs.both(camera, STAGES))


def scatter(runs, camera, *path):
    """Return a measure of the scatter of both methods, (2, ..., runs)."""
    return runs.both(camera, runs.case["scatter_rays"], *path)


@claim("c4_omni_order_mag", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def order_of_magnitude(runs):
    """Standard over CGSP on the mirror, before and after adjustment."""
    before, after = ratios(runs, OMNI)
    return (
        (before >= MIN_RATIO) & (after >= MIN_RATIO),
        before,
        "",
        f"ratio before adjustment; after it {np.nanmedian(after):.2f}",
    )


@claim("c4_fish_smaller_gap", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def smaller_gap(runs):
    """The fisheye's ratios lie between 1 and those of the other camera."""
    omni, fish = ratios(runs, OMNI), ratios(runs, FISH)
    return (
        np.all((fish > 1) & (fish < omni), axis=0),
        fish[0],
        "",
        f"fisheye's ratio before adjustment; after it {np.nanmedian(fish[1]):.3f}; "
        f"omnidirectional {np.nanmedian(omni[0]):.2f} and {np.nanmedian(omni[1]):.3f}",
    )


@claim("c4_ba_reduces", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def adjustment_reduces(runs):
    """Adjustment takes 40 % of the standard error, on both cameras."""
    errors = [runs.both(camera, STAGES)[0] for camera in CAMERAS.values()]
    gains = np.array([1 - after / before for before, after in errors])
    omni, fish = 100 * np.nanmedian(gains, axis=1)
    return (
        np.all(gains >= MIN_REDUCTION, axis=0),
        100 * gains.min(axis=0),
        "%",
        f"smaller reduction of the two; omnidirectional {omni:.0f} %, "
        f"fisheye {fish:.0f} %",
    )


@claim("c4_raypoint_similar_cams", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def similar_cameras(runs):
    """CGSP's errors are alike on both cameras, the standard method's are not."""
    omni, fish = (runs.both(camera, "ray_mean_mm") for camera in (OMNI, FISH))
    standard, cgsp = np.maximum(omni / fish, fish / omni)
    return (
        (cgsp <= MAX_SIMILAR) & (standard >= MIN_RATIO),
        cgsp,
        "",
        "larger over smaller mean of CGSP; of the standard method "
        f"{np.nanmedian(standard):.2f}",
    )


@claim("c4_accuracy_not_needed_ba", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def better_unadjusted(runs):
    """CGSP before adjustment is better than the adjusted standard method."""
    omni, fish = (
        cgsp[0] / standard[1]
        for standard, cgsp in (runs.both(camera, STAGES) for camera in (OMNI, FISH))
    )
    return (
        omni < 1,
        omni,
        "",
        "CGSP before over standard after adjustment; on the fisheye "
        f"{np.nanmedian(fish):.2f}",
    )


def orders(cgsp, standard, adjusted):
    """Return which of three errors is smaller in each pair, (3, ...)."""
    return np.array([cgsp < standard, adjusted < standard, cgsp < adjusted])


@claim(
    "c4_agrees_simulated", needs=WITH_SIMULATED, evidence="rendered", readings=STANDARD
)
def judge_agreement(results, options):
    """Ray-point errors have the order of the simulated ones, on both cameras."""
    case = Case(QUESTIONS, options)
    standard = case["standard_method"]
    levels = results["fig_4_2_redrawn"].by("noise", domain="px").values()
    medians = [
        [np.median(with_worst(level.column(*path, "own_ray_mm"))) for level in levels]
        for path in (("cgsp", "linear"), (standard, "linear"), (standard, "ba"))
    ]
    simulated = orders(*np.array(medians)).sum(axis=1) > len(levels) / 2

    def found_at(noise):
        runs = runs_of(results, noise, **options)
        agreeing = [
            orders(cgsp[0], *errors) == simulated[:, None]
            for errors, cgsp in (runs.both(camera, STAGES) for camera in (OMNI, FISH))
        ]
        return (
            np.all(agreeing, axis=(0, 1)),
            100 * np.mean(agreeing, axis=(0, 1)),
            "%",
            "orders of two ray-point errors, three for each camera, that are those of "
            "the simulation",
        )

    return counterpart_over_the_sweep(case, found_at)


@claim("c4_params_fish_agree", needs=BOTH, evidence="rendered", readings=STANDARD)
@judged_by_run(QUESTIONS, *BOTH)
def parameters_agree(runs):
    """Parameters of the fisheye agree, the depth of the other camera does not."""
    fish, depth = disagreement(runs, FISH), disagreement(runs, OMNI, ("cz",))
    return (
        (fish <= MAX_FISH) & (depth > MIN_DEPTH),
        fish,
        "%",
        "largest difference on the fisheye; omnidirectional depth "
        f"{np.nanmedian(depth):.2f} %",
    )


@claim("c4_centrality_omni", needs=BOTH, evidence="rendered", readings=SCATTERS)
@judged_by_run(QUESTIONS, *BOTH)
def omnidirectional_scatter(runs):
    """Tighter by a factor of two, rounder, nearer to Gaussian."""
    standard, cgsp = scatter(runs, OMNI, ("rms_mm", "eigenvalues", "kurtosis"))
    tighter = standard[0] / cgsp[0]
    parts = {
        "tighter": tighter >= MIN_TIGHTER,
        "rounder": cgsp[1] > standard[1],
        "nearer to Gaussian": cgsp[2] < standard[2],
    }
    shares = ", ".join(
        f"{word} in {100 * np.mean(part):.0f} %" for word, part in parts.items()
    )
    return np.all(list(parts.values()), axis=0), tighter, "", f"RMS ratio; {shares}"


@claim("c4_centrality_fish", needs=BOTH, evidence="rendered", readings=SCATTERS)
@judged_by_run(QUESTIONS, *BOTH)
def fisheye_scatter(runs):
    """Alike in size, and not less Gaussian with CGSP."""
    standard, cgsp = scatter(runs, FISH, ("rms_mm", "kurtosis"))
    tighter, gaussian = standard[0] / cgsp[0], cgsp[1] <= standard[1]
    alike = (tighter >= SIMILAR[0]) & (tighter <= SIMILAR[1])
    return (
        alike & gaussian,
        tighter,
        "",
        f"RMS ratio; alike in {100 * np.mean(alike):.0f} %, "
        f"not less Gaussian in {100 * np.mean(gaussian):.0f} %",
    )


@claim("c4_scatter_plane", needs=BOTH, evidence="rendered", readings=SCATTERS)
@judged_by_run(QUESTIONS, *BOTH)
def compact_across(runs):
    """On no tilted plane is CGSP's scatter smaller than on the one across the rays."""
    ratio = [scatter(runs, camera, "tilted_over_facing")[1] for camera in (OMNI, FISH)]
    smallest = np.min(ratio, axis=0)
    return (
        smallest >= 1,
        smallest,
        "",
        "smallest RMS radius on a tilted plane over that on the plane across the rays",
    )


@claim("c6_centrality_both", needs=BOTH, evidence="rendered", readings=SCATTERS)
@judged_by_run(QUESTIONS, *BOTH)
def tighter_on_both(runs):
    """The scatter is tighter with CGSP on both cameras."""
    tighter = np.array(
        [np.divide(*scatter(runs, camera, "rms_mm")) for camera in (OMNI, FISH)]
    )
    omni, fish = np.nanmedian(tighter, axis=1)
    return (
        np.all(tighter > 1, axis=0),
        tighter.min(axis=0),
        "",
        f"smaller RMS ratio of the two; omnidirectional {omni:.2f}, fisheye {fish:.2f}",
    )


@claim("c4_hull", needs=BOTH, evidence="rendered", readings=SCATTERS)
def judge_hull(results, options):
    """The centre lies in the hull with CGSP, and outside without, in most runs."""

    def reading_at(noise):
        runs = runs_of(results, noise, **options)
        standard, cgsp = scatter(runs, FISH, "inside")
        share = proportion(np.asarray((cgsp == 1) & (standard == 0), float))
        return Reading.of(
            share.value > 0.5,
            share,
            reason=f"runs with the centre inside: CGSP {np.nansum(cgsp):.0f}, "
            f"standard {np.nansum(standard):.0f}",
        )

    return over_the_sweep(
        Case(QUESTIONS, options),
        reading_at,
        lambda noise: reading_at(noise).verdict == "reproduced",
    )


@claim("c4_small_misalign", needs=("exp_c4_small_misalign",), evidence="rendered")
def judge_misalignment(results):
    """CGSP's error with a bracket offset of 1 mm is at most twice that without."""
    errors = {
        offset: runs.column("cgsp", "ray_mean_mm")
        for offset, runs in results["exp_c4_small_misalign"].by("offset_mm").items()
    }
    over_aligned = {mm: found / errors[0.0] for mm, found in errors.items() if mm}
    words = ", ".join(f"{mm:g} mm {np.median(r):.2f}" for mm, r in over_aligned.items())
    return counterpart(
        over_aligned[1.0] <= 2.0,
        over_aligned[1.0],
        reason=f"error over that of an aligned bracket: {words}",
    )


@claim("c4_caustic_floor", needs=("exp_c4_caustic_floor",), evidence="synthetic")
def judge_caustic(results):
    """Exact rays scatter after CGSP by no less than their caustic spreads."""
    result = results["exp_c4_caustic_floor"]
    scattered, caustic = result.column(("scatter_mm", "caustic_mm"))
    over = scattered / caustic
    return counterpart(
        (caustic > 0) & (over >= 1),
        over,
        reason=f"scatter over the caustic's spread of {np.median(caustic):.2f} mm",
    )
