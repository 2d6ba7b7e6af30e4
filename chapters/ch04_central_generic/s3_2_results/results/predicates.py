"""What the claims of 4.3.2 say of one seed, and what is measured there.

Each takes the `Seeds` of a reading and gives whether it is true (seeds,), what was
measured (seeds,), its unit, and words.
"""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results.seeds import CAMERAS, SIMULATED
from chapters.shared.central_sets import FISH, OMNI
from repro.judge.statistics import with_worst

MIN_RATIO, MAX_SIMILAR, MIN_REDUCTION = 5.0, 2.0, 0.4
MAX_FISH, MIN_DEPTH = 5.0, 5.0
MIN_TIGHTER, SIMILAR = 2.0, (0.7, 1.5)
# Before and after adjustment.
STAGES = ("ray_mean_mm", "ba_mean_mm")
# Pairs of ray-point errors (`error_pairs`) of which the first may be smaller.
ORDERS = (("CGSP", "standard"), ("adjusted", "standard"), ("CGSP", "adjusted"))


def order_of_magnitude(seeds):
    """Standard over CGSP on the mirror, before and after adjustment."""
    before, after = (seeds.ratio(OMNI, stage) for stage in STAGES)
    return (
        (before >= MIN_RATIO) & (after >= MIN_RATIO),
        before,
        "",
        f"ratio before adjustment; after it {np.nanmedian(after):.2f}",
    )


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


# Claims that are judged seed by seed.
BY_SEED = {
    "c4_omni_order_mag": order_of_magnitude,
    "c4_fish_smaller_gap": smaller_gap,
    "c4_ba_reduces": adjustment_reduces,
    "c4_raypoint_similar_cams": similar_cameras,
    "c4_accuracy_not_needed_ba": unadjusted_ahead,
    "c4_params_fish_agree": parameters_agree,
    "c4_centrality_omni": omnidirectional_scatter,
    "c4_centrality_fish": fisheye_scatter,
    "c4_scatter_plane": compact_across,
    "c4_agrees_simulated": orders_as_simulated,
    "c6_centrality_both": tighter_on_both,
}
