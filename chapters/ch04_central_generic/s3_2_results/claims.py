"""The claims of section 4.3.2 and of its discussion.

Most are judged run by run: a predicate takes the `Seeds` of an interpretation and
returns whether it is true (runs,), the measured value (runs,), its unit, and a reason.
"""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.report import (
    BRACKETS,
    CAMERAS,
    CAUSTIC,
    READINGS,
    SEEDS_OF_BOTH,
    Seeds,
)
from chapters.shared.central import FISH, OMNI, judged_by_seed, over_the_sweep
from repro.run import Case, Reading, claim, counterpart, proportion, with_worst

MAX_OF_ALIGNED, STATED_MM = 2.0, 1.0
STANDARD = ("decoding_noise", "standard_method")
SCATTERS = ("decoding_noise", "standard_method", "scatter_rays")
# With the simulation of 4.1.5.
WITH_SIMULATED = ("table_4_3_rendered", "table_4_3_redrawn", "fig_4_2_redrawn")


SIMULATED = "fig_4_2_redrawn"  # of 4.1.5
MIN_RATIO, MAX_SIMILAR, MIN_REDUCTION = 5.0, 2.0, 0.4
MAX_FISH, MIN_DEPTH = 5.0, 5.0
MIN_TIGHTER, SIMILAR = 2.0, (0.7, 1.5)
STAGES = ("ray_mean_mm", "ba_mean_mm")
ORDERS = (("CGSP", "standard"), ("adjusted", "standard"), ("CGSP", "adjusted"))


def error_pairs(seeds):
    """What ORDERS compares: its name here, and in the simulation of 4.1.5."""
    standard = seeds["standard_method"]
    return {
        "CGSP": ("cgsp.ray_mean_mm", "cgsp.linear.own_ray_mm"),
        "standard": (f"{standard}.ray_mean_mm", f"{standard}.linear.own_ray_mm"),
        "adjusted": (f"{standard}.ba_mean_mm", f"{standard}.ba.own_ray_mm"),
    }


def simulated_orders(seeds):
    """{pair of ORDERS: whether its first is smaller}, of medians at most levels."""
    result, names = seeds.results[SIMULATED], error_pairs(seeds)

    def median(name, level):
        found = result.column(names[name][1], domain="px", noise=level)
        return np.median(with_worst(found))

    levels = result.levels("noise")
    return {
        (small, large): sum(
            median(small, level) < median(large, level) for level in levels
        )
        > len(levels) / 2
        for small, large in ORDERS
    }


def centre_in_hull(seeds):
    """The centre lies in the hull with CGSP, and outside without."""
    standard, cgsp = seeds.scatter(FISH, "inside")
    return (
        (cgsp == 1) & (standard == 0),
        cgsp,
        "",
        f"seeds with the centre inside: CGSP {np.nansum(cgsp):.0f}, "
        f"standard {np.nansum(standard):.0f}",
    )


@claim("c4_omni_order_mag", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
@judged_by_seed(Seeds)
def order_of_magnitude(seeds):
    """Standard over CGSP on the mirror, before and after adjustment."""
    before, after = (seeds.ratio(OMNI, stage) for stage in STAGES)
    return (
        (before >= MIN_RATIO) & (after >= MIN_RATIO),
        before,
        "",
        f"ratio before adjustment; after it {np.nanmedian(after):.2f}",
    )


@claim(
    "c4_fish_smaller_gap", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
@judged_by_seed(Seeds)
def smaller_gap(seeds):
    """The fisheye's ratios lie between 1 and those of the other camera."""
    omni, fish = (
        np.array([seeds.ratio(camera, stage) for stage in STAGES])
        for camera in (OMNI, FISH)
    )
    return (
        np.all((fish > 1) & (fish < omni), axis=0),
        fish[0],
        "",
        f"fisheye's ratio before adjustment; after it {np.nanmedian(fish[1]):.3f}; "
        f"omnidirectional {np.nanmedian(omni[0]):.2f} and {np.nanmedian(omni[1]):.3f}",
    )


@claim("c4_ba_reduces", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
@judged_by_seed(Seeds)
def adjustment_reduces(seeds):
    """Adjustment takes 40 % of the standard error, on both cameras."""

    def gain(camera):
        before, after = (seeds.both(camera, stage)[0] for stage in STAGES)
        return 1 - after / before

    gains = np.array([gain(camera) for camera in CAMERAS.values()])
    omni, fish = 100 * np.nanmedian(gains, axis=1)
    return (
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
@judged_by_seed(Seeds)
def similar_cameras(seeds):
    """CGSP's errors are alike on both cameras, the standard method's are not."""
    omni, fish = (seeds.both(camera, "ray_mean_mm") for camera in (OMNI, FISH))
    standard, cgsp = np.maximum(omni / fish, fish / omni)
    return (
        (cgsp <= MAX_SIMILAR) & (standard >= MIN_RATIO),
        cgsp,
        "",
        "larger over smaller mean of CGSP; of the standard method "
        f"{np.nanmedian(standard):.2f}",
    )


@claim(
    "c4_accuracy_not_needed_ba",
    needs=SEEDS_OF_BOTH,
    evidence="rendered",
    readings=STANDARD,
)
@judged_by_seed(Seeds)
def unadjusted_ahead(seeds):
    """CGSP as it comes out against the adjusted standard method."""
    omni, fish = (
        seeds.both(camera, "ray_mean_mm")[1] / seeds.both(camera, "ba_mean_mm")[0]
        for camera in (OMNI, FISH)
    )
    return (
        omni < 1,
        omni,
        "",
        "CGSP before over standard after adjustment; on the fisheye "
        f"{np.nanmedian(fish):.2f}",
    )


@claim(
    "c4_agrees_simulated", needs=WITH_SIMULATED, evidence="rendered", readings=STANDARD
)
@judged_by_seed(Seeds)
def orders_as_simulated(seeds):
    """Ray-point errors stand in the order of the simulated ones, on both cameras."""
    simulated = simulated_orders(seeds)
    agreeing = []
    for camera in (OMNI, FISH):
        errors = {
            name: seeds.of(camera, here)
            for name, (here, _) in error_pairs(seeds).items()
        }
        agreeing += [
            (errors[small] < errors[large]) == simulated[small, large]
            for small, large in ORDERS
        ]
    return (
        np.all(agreeing, axis=0),
        100 * np.mean(agreeing, axis=0),
        "%",
        "orders of two ray-point errors, three for each camera, that are those of the "
        "simulation",
    )


@claim(
    "c4_params_fish_agree", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
@judged_by_seed(Seeds)
def parameters_agree(seeds):
    """Parameters of the fisheye agree, the depth of the other camera does not."""
    fish, depth = seeds.disagreement(FISH), seeds.disagreement(OMNI, ("cz",))
    return (
        (fish <= MAX_FISH) & (depth > MIN_DEPTH),
        fish,
        "%",
        "largest difference on the fisheye; omnidirectional depth "
        f"{np.nanmedian(depth):.2f} %",
    )


@claim(
    "c4_centrality_omni", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
@judged_by_seed(Seeds)
def omnidirectional_scatter(seeds):
    """Tighter by a factor of two, rounder, nearer to Gaussian."""
    (wide, tight), (flat, circular), (far, near) = (
        seeds.scatter(OMNI, key) for key in ("rms_mm", "eigenvalues", "kurtosis")
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
    return holds, tighter, "", f"RMS ratio; {shares}"


@claim(
    "c4_centrality_fish", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
@judged_by_seed(Seeds)
def fisheye_scatter(seeds):
    """Alike in size, and not less Gaussian with CGSP."""
    tighter = np.divide(*seeds.scatter(FISH, "rms_mm"))
    far, near = seeds.scatter(FISH, "kurtosis")
    alike = (tighter >= SIMILAR[0]) & (tighter <= SIMILAR[1])
    return (
        alike & (near <= far),
        tighter,
        "",
        f"RMS ratio; alike in {100 * np.mean(alike):.0f} %, "
        f"not less Gaussian in {100 * np.mean(near <= far):.0f} %",
    )


@claim("c4_scatter_plane", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS)
@judged_by_seed(Seeds)
def compact_across(seeds):
    """On no tilted plane is CGSP's scatter smaller than on the one across the rays."""
    least = np.min(
        [seeds.scatter(camera, "tilted_over_facing")[1] for camera in (OMNI, FISH)],
        axis=0,
    )
    return (
        least >= 1,
        least,
        "",
        "smallest RMS radius on a tilted plane over that on the plane across the rays",
    )


@claim(
    "c6_centrality_both", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
@judged_by_seed(Seeds)
def tighter_on_both(seeds):
    """The scatter is tighter with CGSP on both cameras."""
    tighter = np.array(
        [np.divide(*seeds.scatter(camera, "rms_mm")) for camera in (OMNI, FISH)]
    )
    omni, fish = np.nanmedian(tighter, axis=1)
    return (
        np.all(tighter > 1, axis=0),
        tighter.min(axis=0),
        "",
        f"smaller RMS ratio of the two; omnidirectional {omni:.2f}, fisheye {fish:.2f}",
    )


@claim("c4_hull", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS)
def judge_hull(results, options):
    """The centre lies in the hull with CGSP, and outside without, in most seeds."""

    def share_at(noise):
        holds, *_, words = centre_in_hull(Seeds(results, options, noise))
        return proportion(holds.astype(float)), words

    def reading_at(noise):
        share, words = share_at(noise)
        return Reading.of(share.value > 0.5, share, reason=words)

    def in_most_seeds(noise):
        return share_at(noise)[0].value > 0.5

    return over_the_sweep(Case(READINGS, options), reading_at, in_most_seeds)


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
