"""Results of this page read: values of the prose, figures, tables."""

from dataclasses import replace
from itertools import product

import numpy as np
from matplotlib.ticker import MaxNLocator

from chapters.ch04_central_generic.s3_2_results.experiment import MULTIPLIED, solved
from chapters.shared.central import BENCH, FACTOR, FISH, NOISES, OMNI, OPTIONS, SWEPT
from chapters.shared.methods import LINEAR_NAMES, STANDARD_METHODS
from repro.page import INK, legend_below, new_figure, series, value
from repro.run import (
    Case,
    Check,
    Drawing,
    Measured,
    Table,
    Value,
    columns,
    figure,
    numbers,
    table,
)

# Section 4.3.2: the runs in one interpretation, and the numbers of the text.


RENDERED = "table_4_3_rendered"
REDRAWN = "table_4_3_redrawn"
BRACKETS = "exp_c4_small_misalign"
CAUSTIC = "exp_c4_caustic_floor"
ERRORS = "table_4_3_errors"

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
    """Values of all runs in one interpretation, at one noise level of the trials.

    The sweep of the factor has redrawn runs only. Otherwise the rendered runs come
    first. A method that failed has nan.
    """

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(READINGS, options)
        self.results, self.noise = results, noise

    def rendered(self, camera, key):
        """Return a value of each rendered run of a camera, (runs,)."""
        trials = self.results[RENDERED].select(camera=camera)
        return trials.column(f"{self.noise}.{key}")

    def of(self, camera, key):
        """Return a value of each run of a camera, (runs,)."""
        name = f"{self.noise}.{key}"
        redrawn = self.results[REDRAWN].column(name, camera=camera)
        if self.noise in SWEPT.values():
            return redrawn
        return np.concatenate([self.rendered(camera, key), redrawn])

    def both(self, camera, key):
        """Return a value of the standard method and of CGSP, (2, runs)."""
        methods = self["standard_method"], "cgsp"
        return np.array([self.of(camera, f"{method}.{key}") for method in methods])

    def ratio(self, camera, key):
        """Return the ratio of the standard method to CGSP, (runs,)."""
        return np.divide(*self.both(camera, key))

    def scatter(self, camera, key):
        """Return a measure of the scatter of both methods, (2, runs)."""
        return self.both(camera, f"{self['scatter_rays']}.{key}")

    def disagreement(self, camera, parameters=PARAMETERS):
        """Return the largest difference of CGSP from the standard, %, (runs,)."""
        pairs = [self.both(camera, name) for name in parameters]
        return np.max([100 * np.abs(b / a - 1) for a, b in pairs], axis=0)


def name_values(open_results):
    """Name the numbers that the text quotes."""
    results = {name: open_results(name) for name in (RENDERED, REDRAWN)}

    def ratio(camera, method, noise=BENCH):
        seeds = Seeds(results, {"standard_method": method}, noise)
        return np.nanmedian(seeds.ratio(camera, "ray_mean_mm"))

    rejected = Seeds(results).rendered(OMNI, "left_out")
    found = {
        "omni.well_conditioned.ratio": ratio(OMNI, "well conditioned"),
        "fish.well_conditioned.ratio": ratio(FISH, "well conditioned"),
        "lab.omni.as_printed.ratio": ratio(OMNI, "as printed", "laboratory"),
        "omni.left_out": 100 * np.median(rejected),
        "redrawn": results[REDRAWN].trials_per_condition,
        "factor": FACTOR,
    }
    for name, number in found.items():
        value(name, number)


# Fig. 4.6, and the factor of the thesis-matched level.


PANELS = ("as_printed", "cgsp")
MIN_SHARE = 0.98  # of the points inside a panel
TICKS = 5


@figure("fig_4_6", needs=("table_4_3_rendered",), evidence="rendered")
def fig_4_6(results):
    """Draw two cameras by two methods, each from the first rendered run."""
    result = results[RENDERED]
    drawn, axes = new_figure(2, 2, height_in=7.2, sharex="row", sharey="row")
    rows = []
    panels = product(CAMERAS.values(), PANELS)
    for panel, (camera, method) in zip(axes.flat, panels, strict=True):
        x, y, apart = crossings(result, camera, method)
        for good, colour, label in (
            (apart < 1, "#e69f00", "close points"),
            (apart > 0, "#0072b2", "separated points"),
        ):
            panel.plot(
                x[good], y[good], ".", color=colour, ms=2, alpha=0.5, label=label
            )
        panel.plot(0, 0, "+", color="#d00000", ms=14, mew=2, label="centre")
        reach = shown_reach(result, camera)
        outside = np.mean(np.maximum(abs(x), abs(y)) > reach)
        panel.set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal",
            title=f"{camera}:\n{LINEAR_NAMES[method]}",
            xlabel="x (mm)", ylabel="y (mm)",
        )  # fmt: skip
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(MaxNLocator(TICKS, prune="both"))
        panel.text(
            0.98, 0.02, f"outside: {100 * outside:.1f} %", ha="right", va="bottom",
            fontsize=8.5, transform=panel.transAxes,
        )  # fmt: skip
        points = zip(x.tolist(), y.tolist(), apart.tolist(), strict=True)
        rows += [(camera, LINEAR_NAMES[method], *point) for point in points]
    legend_below(drawn, axes[0, 0], ncols=3)
    return Drawing(
        drawn,
        columns(("camera", "method", "x_mm", "y_mm", "apart"), rows),
        "Crossings of the rays with the plane through the estimated centre (red "
        "cross): each ray is the line fitted to its three points, and the plane is the "
        "one most nearly perpendicular to the rays. Linear stage without adjustment, "
        "thesis-matched level. Orange: rays whose three points span less than a tenth "
        "of their distance, near grid crossings, so that the line is nearly "
        "undetermined. Both panels of a camera have one scale and contain at least "
        f"{100 * MIN_SHARE:.0f} % of the points; the share outside is stated. About "
        "3000 rays are drawn.",
    )


def crossings(result, camera, method):
    """Return x, y (N,) mm on the plane, and 1 where a ray's points are separated."""
    return result.select(camera=camera).arrays(f"{BENCH}.{method}.crossing")[0].T


def shown_reach(result, camera):
    """Return half the side of a camera's panels, mm, to hold MIN_SHARE of each."""
    return 1.15 * max(
        np.quantile(np.maximum(abs(x), abs(y)), MIN_SHARE)
        for x, y, _ in (crossings(result, camera, method) for method in PANELS)
    )


SOLVED_FROM = ("t4_3_omni_cgsp_mean_pre",)
NEAR = 0.01
TICKS_MM = (0.02, 0.05, 0.1, 0.2)
WORDS = {"bench": "correlated over 7 x 7 pixels", "white": "white"}


@figure(
    "ext_bench_factor",
    needs=("bench_factor",),
    evidence="rendered",
    published=SOLVED_FROM,
)
def ext_bench_factor(results, published):
    """Draw CGSP's ray-point error against the factor, and the factor solved."""
    result, printed = results["bench_factor"], published[SOLVED_FROM[0]]
    drawn, axes = new_figure(1, 1, height_in=3.2)
    rows, solutions, gaps = [], [], []
    for index, (noise, words) in enumerate(WORDS.items()):
        means = np.array(result.arrays("mean_mm", noise=noise))
        medians = np.median(means, axis=0)
        factor, chosen = solved(result, printed, noise), NOISES[noise].factor
        reached = np.median(result.column("chosen_mm", noise=noise))
        axes.plot(MULTIPLIED, medians, label=words, **series(index))
        axes.plot(chosen, reached, "+", color=INK, ms=13, mew=2)
        rows += [(words, *row) for row in zip(MULTIPLIED, medians, strict=True)]
        gaps.append(abs(reached / printed - 1))
        solution = "no solution" if factor is None else f"{factor:.3g}"
        solutions.append(f"{words}, {solution} ({chosen:g} is used)")
    axes.axhline(printed, color=INK, lw=1.0, ls="--", label="printed")
    axes.set(
        xscale="log", yscale="log",
        xlabel="Factor of the decoding errors (×)", ylabel="Mean ray-point error (mm)",
    )  # fmt: skip
    axes.set_xticks(MULTIPLIED, [f"{m:g}" for m in MULTIPLIED])
    axes.set_yticks(TICKS_MM, [f"{mm:g}" for mm in TICKS_MM])
    axes.minorticks_off()
    axes.legend()
    check = Check(
        max(gaps) <= NEAR,
        f"at the factors the median is within {100 * max(gaps):.1f} % of the printed "
        "number",
    )
    return Drawing(
        drawn,
        columns(("errors", "factor", "mean_mm"), rows),
        "Mean ray-point error of CGSP on the mirror camera, before adjustment, against "
        "the factor that multiplies the simulator's decoding errors: median over "
        f"{result.trials_per_condition} runs. The factors that give the printed "
        f"{printed:g} mm (crosses): {'; '.join(solutions)}. They are solved at full "
        "size.",
        check if result.trials_per_condition > 3 else None,
    )


# Tables 4.2 and 4.3, and their numbers.


TABLES_WORDS = {
    "cx": "centre, x (mm)",
    "cy": "centre, y (mm)",
    "cz": "centre, z (mm)",
    "r2": "rotation of grid 2 (deg)",
    "t2": "translation of grid 2 (mm)",
    "r3": "rotation of grid 3 (deg)",
    "t3": "translation of grid 3 (mm)",
}
SOLVED = (
    "the factor of the thesis-matched level is solved from this number: it is near "
    "the printed one by construction"
)
POSES_OF_THE_RIG = (
    "the grid poses of the rig are those of Table 4.2: this is near the printed "
    "value by construction"
)
# Names of methods and stages in the ids of the registry.
PRINTED_METHODS = {"std": "as_printed", "cgsp": "cgsp"}
PRINTED_STAGES = {"pre": "ray", "ba": "ba"}


@table("table_4_2", needs=("table_4_3_rendered",), evidence="rendered")
def table_4_2(results):
    """Tabulate centre and poses by each method, and the true ones, of the first set."""
    seeds = Seeds(results)
    rows = [
        (
            camera,
            TABLES_WORDS[name],
            *(
                float(seeds.rendered(camera, f"{which}.{name}")[0])
                for which in (*LINEAR_NAMES, "true")
            ),
        )
        for camera, name in product(CAMERAS.values(), PARAMETERS)
    ]
    printed = {
        LINEAR_NAMES[which]: [
            f"t4_2_{short}_{name}_{method}"
            for short, name in product(CAMERAS, PARAMETERS)
        ]
        for method, which in PRINTED_METHODS.items()
    }
    return Table(
        columns(("Camera", "Parameter", *LINEAR_NAMES.values(), "true"), rows),
        "Camera centre in the frame of the base grid, and rotation and translation "
        "magnitudes of grids 2 and 3 relative to it: first rendered run of each "
        "camera, thesis-matched level. *True* is the point nearest to all rays, since "
        "neither camera is exactly central.",
        printed=printed,
    )


HEADS = {
    "ray_mean_mm": "Mean (mm)",
    "ray_sd_mm": "SD (mm)",
    "ba_mean_mm": "Mean after BA (mm)",
    "ba_sd_mm": "SD after BA (mm)",
    "centre_off_mm": "Centre error (mm)",
}


@table("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def table_4_3(results):
    """Tabulate ray-point errors before and after adjustment, thesis-matched level."""
    known = {which: method for method, which in PRINTED_METHODS.items()}
    printed = {
        HEADS[f"{key}_{statistic}_mm"]: [
            f"t4_3_{short}_{known[which]}_{statistic}_{stage}"
            if which in known
            else None
            for short, which in product(CAMERAS, LINEAR_NAMES)
        ]
        for stage, key in PRINTED_STAGES.items()
        for statistic in ("mean", "sd")
    }
    seeds = Seeds(results)
    rows = [
        (
            camera,
            LINEAR_NAMES[method],
            *(Measured.median(seeds.of(camera, f"{method}.{key}")) for key in HEADS),
        )
        for camera, method in product(CAMERAS.values(), LINEAR_NAMES)
    ]
    return Table(
        columns(("Camera", "Method", *HEADS.values()), rows),
        "Ray-point errors: mean and standard deviation over all rays of the linear "
        "stage, before and after the thesis's bundle adjustment (BA), which keeps the "
        "centre. *Centre error*: distance from the point nearest to the true rays, "
        "before adjustment. Medians over rendered and redrawn runs with 95 % "
        "intervals, thesis-matched level. CGSP's mean on the omnidirectional camera "
        "is set by the factor of that level.",
        printed=printed,
    )


@numbers("table_4_2", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_2(results):
    """Return centre and pose magnitudes of the rendered runs, standard as printed."""
    seeds = Seeds(results)
    found = {
        f"t4_2_{short}_{name}_{method}": Value.of_seeds(
            seeds.rendered(camera, f"{which}.{name}"),
            UNITS[name],
            put_in=POSES_OF_THE_RIG,
        )
        for short, camera in CAMERAS.items()
        for name in PARAMETERS
        for method, which in PRINTED_METHODS.items()
    }
    agree = Value.of_seeds(seeds.disagreement(FISH), "%")
    return found | {"t4_2_fish_agree": agree}


@numbers("table_4_3", needs=SEEDS_OF_BOTH, evidence="rendered")
def numbers_of_table_4_3(results):
    """Return ray-point errors over all runs, standard as printed."""
    seeds = Seeds(results)
    errors = {
        f"t4_3_{short}_{method}_{statistic}_{stage}": Value.of_seeds(
            seeds.of(camera, f"{which}.{key}_{statistic}_mm"), "mm"
        )
        for short, camera in CAMERAS.items()
        for method, which in PRINTED_METHODS.items()
        for stage, key in PRINTED_STAGES.items()
        for statistic in ("mean", "sd")
    }
    solved_from = "t4_3_omni_cgsp_mean_pre"
    errors[solved_from] = replace(errors[solved_from], put_in=SOLVED)
    return errors | {
        f"s4_4_ratio_{short}": Value.of_seeds(
            seeds.ratio(camera, "ray_mean_mm"), "ratio"
        )
        for short, camera in CAMERAS.items()
    }
