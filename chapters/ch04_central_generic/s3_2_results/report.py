"""Results of this page read: values of the prose, figures, tables."""

from dataclasses import replace
from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_2_results.experiment import MULTIPLIED, solved
from chapters.shared.central import (
    FACTOR,
    FISH,
    MATCHED,
    NOISES,
    OMNI,
    OPTIONS,
    CentralRuns,
)
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

# The experiments of section 4.3.2, and the numbers of the text.


RENDERED, REDRAWN = BOTH = ("table_4_3_rendered", "table_4_3_redrawn")
ERRORS = "table_4_3_errors"
QUESTIONS = {
    "decoding_noise": OPTIONS,
    "standard_method": STANDARD_METHODS,
    "scatter_rays": {"all rays": "all", "rays whose points lie apart": "apart"},
}
CAMERAS = {"omni": OMNI, "fish": FISH}
PARAMETERS = {
    "cx": "centre, x (mm)",
    "cy": "centre, y (mm)",
    "cz": "centre, z (mm)",
    "r2": "rotation of grid 2 (deg)",
    "t2": "translation of grid 2 (mm)",
    "r3": "rotation of grid 3 (deg)",
    "t3": "translation of grid 3 (mm)",
}


def runs_of(results, noise=MATCHED, names=BOTH, **options):
    """Return the `CentralRuns` at one noise level in one interpretation, the primary if
    no option is given; the rendered runs come first."""
    return CentralRuns(
        [results[name] for name in names], Case(QUESTIONS, options), noise
    )


def disagreement(runs, camera, parameters=tuple(PARAMETERS)):
    """Return the largest difference of CGSP from the standard method, %, (runs,)."""
    standard, cgsp = runs.both(camera, parameters)
    return np.max(100 * np.abs(cgsp / standard - 1), axis=0)


def name_values(open_results):
    """Name the numbers that the text quotes."""
    results = {name: open_results(name) for name in BOTH}

    def ratio(camera, method, noise=MATCHED):
        runs = runs_of(results, noise, standard_method=method)
        return np.nanmedian(np.divide(*runs.both(camera, "ray_mean_mm")))

    value("omni.well_conditioned.ratio", ratio(OMNI, "well conditioned"))
    value("fish.well_conditioned.ratio", ratio(FISH, "well conditioned"))
    value("lab.omni.as_printed.ratio", ratio(OMNI, "as printed", "laboratory"))
    rejected = results[RENDERED].select(camera=OMNI).column(MATCHED, "left_out")
    value("omni.left_out", 100 * np.median(rejected))
    value("redrawn", results[REDRAWN].trials_per_condition)
    value("factor", FACTOR)


# Fig. 4.6, and the factor of the thesis-matched level.


DRAWN = ("as_printed", "cgsp")
MIN_SHARE = 0.98  # of the points inside a panel


@figure("fig_4_6", needs=("table_4_3_rendered",), evidence="rendered")
def fig_4_6(results):
    """Draw two cameras by two methods, each from the first rendered run."""
    from matplotlib.ticker import MaxNLocator

    result = results[RENDERED]
    drawn, axes = new_figure(2, 2, height_in=7.2, sharex="row", sharey="row")
    rows = []
    shown = product(CAMERAS.values(), DRAWN)
    for panel, (camera, method) in zip(axes.flat, shown, strict=True):
        x, y, separated = crossings(result, camera, method)
        for good, colour, label in (
            (separated < 1, "#e69f00", "close points"),
            (separated > 0, "#0072b2", "separated points"),
        ):
            panel.plot(
                x[good], y[good], ".", color=colour, ms=2, alpha=0.5, label=label
            )
        panel.plot(0, 0, "+", color="#d00000", ms=14, mew=2, label="centre")
        # Half the side of a camera's panels: each holds MIN_SHARE of its points.
        reach = 1.15 * max(
            np.quantile(
                np.abs(crossings(result, camera, each)[:2]).max(axis=0), MIN_SHARE
            )
            for each in DRAWN
        )
        outside = np.mean(np.maximum(abs(x), abs(y)) > reach)
        panel.set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal",
            title=f"{camera}:\n{LINEAR_NAMES[method]}",
            xlabel="x (mm)", ylabel="y (mm)",
        )  # fmt: skip
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(MaxNLocator(5, prune="both"))
        panel.text(
            0.98, 0.02, f"outside: {100 * outside:.1f} %", ha="right", va="bottom",
            fontsize=8.5, transform=panel.transAxes,
        )  # fmt: skip
        points = np.column_stack([x, y, separated]).tolist()
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
    return result.select(camera=camera).arrays(MATCHED, method, "crossing")[0].T


SOLVED_FROM = ("t4_3_omni_cgsp_mean_pre",)
TICKS_MM = (0.02, 0.05, 0.1, 0.2)


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
    errors = {MATCHED: "correlated over 7 x 7 pixels", "white": "white"}
    for index, (noise, words) in enumerate(errors.items()):
        medians = np.median(result.arrays("mean_mm", noise=noise), axis=0)
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
        max(gaps) <= 0.01,
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


# Names of methods and columns in the ids of the registry.
PRINTED_METHODS = {"std": "as_printed", "cgsp": "cgsp"}
PRINTED_COLUMNS = {
    "mean_pre": "ray_mean_mm",
    "sd_pre": "ray_sd_mm",
    "mean_ba": "ba_mean_mm",
    "sd_ba": "ba_sd_mm",
}


@table("table_4_2", needs=("table_4_3_rendered",), evidence="rendered")
def table_4_2(results):
    """Tabulate centre and poses by each method, and the true ones, of the first set."""
    runs = runs_of(results, names=(RENDERED,))
    methods = (*LINEAR_NAMES, "true")
    cells = [
        runs.of(camera, methods, tuple(PARAMETERS))[..., 0].T
        for camera in CAMERAS.values()
    ]
    found = np.concatenate(cells).tolist()
    places = product(CAMERAS.values(), PARAMETERS.values())
    printed = {
        LINEAR_NAMES[method]: [
            f"t4_2_{short}_{name}_{abbreviation}"
            for short, name in product(CAMERAS, PARAMETERS)
        ]
        for abbreviation, method in PRINTED_METHODS.items()
    }
    return Table(
        columns(
            ("Camera", "Parameter", *LINEAR_NAMES.values(), "true"),
            [(*place, *row) for place, row in zip(places, found, strict=True)],
        ),
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


@table("table_4_3", needs=BOTH, evidence="rendered")
def table_4_3(results):
    """Tabulate ray-point errors before and after adjustment, thesis-matched level."""
    runs = runs_of(results)
    printed = {
        HEADS[key]: [
            f"t4_3_{short}_{abbreviation}_{column}" if abbreviation else None
            for short, abbreviation in product(CAMERAS, ("std", None, "cgsp"))
        ]
        for column, key in PRINTED_COLUMNS.items()
    }
    rows = [
        (
            camera,
            LINEAR_NAMES[method],
            *map(Measured.median, runs.of(camera, method, tuple(HEADS))),
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


@numbers("table_4_2", needs=BOTH, evidence="rendered")
def numbers_of_table_4_2(results):
    """Return centre and pose magnitudes of the rendered runs, standard as printed."""
    rendered = runs_of(results, names=(RENDERED,))
    found = {
        f"t4_2_{short}_{name}_{abbreviation}": Value.of_seeds(
            rendered.of(camera, method, name),
            "deg" if name in ("r2", "r3") else "mm",
            put_in="the grid poses of the rig are those of Table 4.2: this is near the "
            "printed value by construction",
        )
        for short, camera in CAMERAS.items()
        for name in PARAMETERS
        for abbreviation, method in PRINTED_METHODS.items()
    }
    agree = Value.of_seeds(disagreement(runs_of(results), FISH), "%")
    return found | {"t4_2_fish_agree": agree}


@numbers("table_4_3", needs=BOTH, evidence="rendered")
def numbers_of_table_4_3(results):
    """Return ray-point errors over all runs, standard as printed."""
    runs, (solved_from,) = runs_of(results), SOLVED_FROM
    found = {
        f"t4_3_{short}_{abbreviation}_{column}": Value.of_seeds(
            runs.of(camera, method, key), "mm"
        )
        for short, camera in CAMERAS.items()
        for abbreviation, method in PRINTED_METHODS.items()
        for column, key in PRINTED_COLUMNS.items()
    }
    for short, camera in CAMERAS.items():
        ratio = np.divide(*runs.both(camera, "ray_mean_mm"))
        found[f"s4_4_ratio_{short}"] = Value.of_seeds(ratio, "ratio")
    solved_value = replace(
        found[solved_from],
        put_in="the factor of the thesis-matched level is solved from this number: it "
        "is near the printed one by construction",
    )
    return found | {solved_from: solved_value}
