"""Section 4.3.2: its seeds in one reading, what claims ask of them, and the prose.

A predicate takes the `Seeds` of a reading and returns whether it is true (seeds,), what
was measured (seeds,), its unit, and words.
"""

from itertools import product

import numpy as np

from chapters.shared.bench_noise import BENCH, FACTOR, OPTIONS, SWEPT, WHITE_FACTOR
from chapters.shared.central_sets import FISH, OMNI
from chapters.shared.methods import STANDARD_METHODS
from repro.judge.statistics import with_worst
from repro.page.reader import value
from repro.run.readings import Case

RENDERED = "table_4_3_rendered"
REDRAWN = "table_4_3_redrawn"
BRACKETS = "exp_c4_small_misalign"
CAUSTIC = "exp_c4_caustic_floor"
ERRORS = "table_4_3_errors"
SIMULATED = "fig_4_2_redrawn"  # of 4.1.5
SEEDS_OF_BOTH = ("table_4_3_rendered", "table_4_3_redrawn")
SCATTER = {"all rays": "all", "rays whose points lie apart": "apart"}
READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": STANDARD_METHODS,
    "scatter_rays": SCATTER,
}
CAMERAS = {"omni": OMNI, "fish": FISH}
PARAMETERS = ("cx", "cy", "cz", "r2", "t2", "r3", "t3")
UNITS = dict.fromkeys(PARAMETERS, "mm") | {"r2": "deg", "r3": "deg"}


class Seeds(Case):
    """What every seed gives in one reading, at the noise that trials call so.

    Those of the sweep of the factor are redrawn alone; else the rendered ones come
    first. A method that failed has nan.
    """

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.results, self.noise = results, noise

    def rendered(self, camera, key):
        """A value of every rendered set of a camera, (seeds,)."""
        trials = self.results[RENDERED].select(camera=camera)
        return trials.column(f"{self.noise}.{key}")

    def of(self, camera, key):
        """A value of every seed of a camera, (seeds,)."""
        name = f"{self.noise}.{key}"
        redrawn = self.results[REDRAWN].column(name, camera=camera)
        if self.noise in SWEPT.values():
            return redrawn
        return np.concatenate([self.rendered(camera, key), redrawn])

    def both(self, camera, key):
        """A value of the standard method and of CGSP, (2, seeds)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{method}.{key}") for method in methods])

    def ratio(self, camera, key):
        """The standard method over CGSP, (seeds,)."""
        return np.divide(*self.both(camera, key))

    def scatter(self, camera, key):
        """A measure of the scatter of both methods, (2, seeds)."""
        return self.both(camera, f"{self['scatter_rays']}.{key}")

    def disagreement(self, camera, parameters=PARAMETERS):
        """Largest difference of CGSP from the standard method, %, (seeds,)."""
        pairs = [self.both(camera, name) for name in parameters]
        return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)


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


NOISES = {"": "bench", "lab.": "laboratory"}
RATIOS = (
    ("as_printed.ratio", "as printed", "ray"),
    ("as_printed.ba_ratio", "as printed", "ba"),
    ("well_conditioned.ratio", "well conditioned", "ray"),
)


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}
    brackets, caustic = open_results(BRACKETS), open_results(CAUSTIC)
    errors = open_results(ERRORS).select()
    bench = Seeds(results)
    apart = bench.of(OMNI, "cgsp.share_apart")
    found = {
        **_of_noises(results),
        **{
            f"{prefix}{short}.left_out": 100
            * np.median(Seeds(results, noise=noise).rendered(camera, "left_out"))
            for prefix, noise in NOISES.items()
            for short, camera in CAMERAS.items()
        },
        "omni.true_scatter_mm": np.median(bench.rendered(OMNI, "true_scatter_mm")),
        **{
            f"inside.{method}": int(np.nansum(bench.of(FISH, f"{method}.all.inside")))
            for method in ("as_printed", "cgsp")
        },
        "inside.seeds": len(apart),
        "omni.left_close": 100 * (1 - np.nanmedian(apart)),
        "rendered": len(bench.rendered(OMNI, "rays")),
        "redrawn": results[REDRAWN].trials_per_condition,
        **{
            f"bracket.{offset}": np.median(
                brackets.select(offset_mm=offset).column("cgsp.ray_mean_mm")
            )
            for offset in (0, 1)
        },
        **{
            f"caustic.{key}": np.median(caustic.column(key))
            for key in ("scatter_mm", "caustic_mm")
        },
        "omni.errors.bias_mm_rms": errors.column("bias_mm_rms")[0],
        "factor": FACTOR,
        "factor.white": WHITE_FACTOR,
    }
    for name, number in found.items():
        value(name, number)


def _of_noises(results):
    """Ratios of ray-point errors, and errors of centres, at both noises."""
    found = {}
    for (prefix, noise), (short, camera) in product(NOISES.items(), CAMERAS.items()):
        for name, option, stage in RATIOS:
            seeds = Seeds(results, {"standard_method": option}, noise)
            ratio = seeds.ratio(camera, f"{stage}_mean_mm")
            found[f"{prefix}{short}.{name}"] = np.nanmedian(ratio)
        for method, key in product(
            ("as_printed", "well_conditioned", "cgsp"), ("centre_off_mm", "ray_mean_mm")
        ):
            errors = Seeds(results, noise=noise).of(camera, f"{method}.{key}")
            found[f"{prefix}{short}.{method}.{key}"] = np.nanmedian(errors)
    return found
