"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

from functools import cache, partial
from itertools import product
from typing import NamedTuple

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.experiment import (
    BOTH,
    CONTOUR,
    DONE,
    FINE,
    MEASURES,
    MERGED,
    METHODS,
    MISSED,
    REFERENCE,
    SPLIT,
    SPOTLESS,
    SPOTLESS_SEED,
    TRUTH,
)
from chapters.shared.grids import (
    CELECT,
    CLICKLESS,
    HARD,
    LINEAR,
    OPENCV,
    OPENCV_SB,
    WHOLE,
)
from repro.page import legend_below, look_of, new_figure, plot_interval, value
from repro.run import (
    Check,
    Drawing,
    Estimate,
    Measured,
    Table,
    Value,
    bootstrap,
    columns,
    figure,
    numbers,
    proportion,
    table,
)

# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# All four: what the claims on sixty images need.
GRIDS = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
# Smallest distances of their corners.
SPACING = "exp_c3_same_after_loc"
# Smallest distance of neighbouring corners (px) in the interpretations.
MIN_SPACING_PX = {"9 px or more": 9.0, "15 px or more": 15.0}
TITLES = {
    "spherical": "Spherical",
    "hyperboloidal": "Hyperboloidal",
    "fisheye": "Fisheye",
    "flexible-mirror": "Flexible Mirror",
}
SPOTTED, CLEAN = "600 spots", "no spots"
# The window that a table shows; the accuracy claims are judged with both.
WINDOW = "half window"


class Which(NamedTuple):
    """Selection of images: the range of their poses, and the ball's spots."""

    poses: str = WHOLE
    spots: str = SPOTTED

    @classmethod
    def of(cls, options):
        """Return the selection of one interpretation."""
        return cls(options["pose_range"], options["spots"])


PRIMARY = Which()


def images_of(result, which=PRIMARY, seed=None):
    """Return the selected images of an experiment, of one run or of all."""
    if which.spots == CLEAN:
        seed = SPOTLESS_SEED
    of_seed = {} if seed is None else {"seed": seed}
    return result.select(poses=which.poses, **of_seed)


def seeds_of(results, which=PRIMARY):
    """Return the seed of each selected run; all four experiments share them."""
    return images_of(next(iter(results.values())), which).levels("seed")


def path_of(result, which, *path):
    """Return the path to a value: only the ball has images without spots."""
    spotless = which.spots == CLEAN and result.settings["set"] == "spherical"
    return ("spotless", *path) if spotless else path


def numbers_of(result, *path, which=PRIMARY, seed=None):
    """Return a number of each selected image, (n,)."""
    return images_of(result, which, seed).column(*path_of(result, which, *path))


def right(result, method, which=PRIMARY, seed=None):
    """Return whether each image's grid was found and in order, (n,) bool."""
    return numbers_of(result, method, "success", which=which, seed=seed) == 1


def right_by_run(results, method, which=PRIMARY):
    """Return `right` of every run, (runs, n), over the images of all four sets."""
    return np.array(
        [
            np.concatenate([right(results[e], method, which, seed) for e in GRIDS])
            for seed in seeds_of(results, which)
        ]
    )


@cache
def _errors_of_images(result, *path):
    """Return {(image, seed, poses): errors (methods, 7, corners)}."""
    return {
        tuple(c.values()): found
        for c in result.conditions
        for found in result.arrays(*path, **c)
    }


def errors(
    result, method, when, reference, which=PRIMARY, seed=None, window=WINDOW, apart=None
):
    """Return errors (px) of the corners of correct grids, one array (n,) per grid.

    when: 'before' or 'after' localisation; reference: one of REFERENCES;
    window: of the localiser, where it applies; apart: None, or (Result of SPACING,
    smallest distance (px) of neighbouring corners in the grids that count).
    """
    path = path_of(result, which, "errors")
    methods = METHODS if path == ("errors",) else SPOTLESS
    as_detected = when == "before" and reference == TRUTH
    row = MEASURES.index((when, reference, None if as_detected else window))
    stored = _errors_of_images(result, *path)
    images = images_of(result, which, seed).conditions
    counts = right(result, method, which, seed)
    if apart:
        spacing, min_px = apart
        steps = [spacing.column("least_px", **image)[0] for image in images]
        counts &= np.array(steps) >= min_px
    return [
        stored[tuple(image.values())][methods.index(method), row]
        for image, counted in zip(images, counts, strict=True)
        if counted
    ]


def causes(results, which, seed, experiments=GRIDS):
    """Return the causes of CELECT's failures, one text per failed image of a run."""
    return [
        cause
        for result in map(results.get, experiments)
        for cause in images_of(result, which, seed).texts(
            *path_of(result, which, CELECT, "cause")
        )
        if cause != DONE
    ]


def spread(values):
    """Return the mean of one value per run, with the range of the runs."""
    return Estimate(*(float(of(values)) for of in (np.mean, np.min, np.max)))


# Regenerated numbers of 3.3.2, and those that its page quotes.


# Names of sets, methods and published columns in the ids of the registry.
SHORT = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
PRINTED_METHODS = {OPENCV: "opencv", CELECT: "celect"}
# Merging distance of CELECT below which squares are small.
SMALL_T8_PX = 4.5
RANGE_OF_RUNS = "mean and range of the rendered runs"
STATISTICS = {"mean": np.mean, "max": np.max, "sd": partial(np.std, ddof=1)}


@numbers("table_3_3", needs=GRIDS, evidence="rendered")
def numbers_table_3_3(results):
    """Return the settings as they were run."""
    found = {}
    for set_name, experiment in EXPERIMENTS.items():
        ran = results[experiment].settings
        size = [Value(px, unit="px") for px in ran["image_px"]]
        ids = ids_of_set(set_name, ran["grids"])
        for row, grid, pitch in zip(ids, ran["grids"], ran["pitch_mm"], strict=True):
            corners = Value("{}x{}".format(*grid), unit="count")
            values = (*size, corners, Value(pitch, unit="mm"))
            found |= dict(zip(row, values, strict=False))
    total = sum(results[EXPERIMENTS["spherical"]].settings["images"])
    return found | {"t3_3_images": Value(total, unit="count")}


def ids_of_set(set_name, grids):
    """Return the ids of published values of a set, one row per grid."""
    named, alone = f"t3_3_{SHORT[set_name]}", len(grids) == 1
    return [
        (
            f"{named}_w",
            f"{named}_h",
            f"{named}_grid_{wide}x{high}",
            f"{named}_pitch" if alone else f"{named}_pitch_{wide}x{high}",
            "t3_3_images" if alone else None,
        )
        for wide, high in grids
    ]


def joined(found):
    """Return all errors of several grids in one array."""
    return np.concatenate([np.empty(0), *found])


def mean_of_runs(found, reason, unit=""):
    """Return the mean of one number per run, with the range of the runs."""
    mean, low, high, _ = spread(found)
    return Value(mean, (low, high), unit, reason)


def numbered(results):
    """Return the number of a set's table in the registry's ids, and its result."""
    ((experiment, result),) = results.items()
    return experiment.removeprefix("table_").removesuffix("_grids"), result


@numbers("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
@numbers("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
@numbers("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
@numbers("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def numbers_of_set(results):
    """Return counts and errors of OpenCV's and CELECT's rows of one table."""
    number, result = numbered(results)
    runs = images_of(result).levels("seed")
    stages = (("pre", "before", TRUTH), ("post", "after", REFERENCE))
    found = {}
    for method, name in PRINTED_METHODS.items():
        counts = [right(result, method, seed=s).sum() for s in runs]
        found[f"t{number}_{name}_count"] = mean_of_runs(
            counts, RANGE_OF_RUNS, "count (of 15)"
        )
        for label, when, reference in stages:
            of_runs = [
                joined(errors(result, method, when, reference, seed=s)) for s in runs
            ]
            every, of_runs = joined(of_runs), [e for e in of_runs if len(e)]
            for statistic, taken in STATISTICS.items():
                found[f"t{number}_{name}_{label}_{statistic}"] = Value(
                    float(taken(every)) if of_runs else "no right grid",
                    spread(list(map(taken, of_runs)))[1:3] if of_runs else None,
                    "px",
                    f"all runs together, and range of the runs; against {reference}",
                )
    return found


def largest_after(results, apart=None):
    """Return the largest error (px) after localisation, of OpenCV and CELECT."""
    found = [
        error
        for name, method in product(GRIDS, (OPENCV, CELECT))
        for error in errors(results[name], method, "after", REFERENCE, apart=apart)
    ]
    return float(joined(found).max(initial=0.0))


@numbers("sec_3_3_2", needs=GRIDS, evidence="rendered")
def numbers_sec_3_3_2(results):
    """Return totals over the four sets, and causes of CELECT's failures."""
    ball, hyperboloidal, *_ = map(results.get, GRIDS)
    precision_px = ball.settings["localiser"]["precision_px"]
    ours, theirs = (right_by_run(results, method) for method in (CELECT, OPENCV))
    runs = seeds_of(results)

    def caused(*kinds, of=GRIDS):
        stated = [causes(results, PRIMARY, seed, of) for seed in runs]
        return [sum(map(one.count, kinds)) for one in stated]

    def cleared(without):
        again = (numbers_of(hyperboloidal, CELECT, without, seed=s) for s in runs)
        return [np.count_nonzero(found == 1) for found in again]

    of_runs = {
        "opencv_only": (theirs & ~ours).sum(axis=1),
        "celect_only": (ours & ~theirs).sum(axis=1),
        "celect_rate": 100 * ours.mean(axis=1),
        "opencv_rate": 100 * theirs.mean(axis=1),
        "contour_fail": caused(CONTOUR),
        "sph_missed_fail": caused(MISSED, of=("table_3_4_grids",)),
        "hyp_dirt_fail": cleared("right_without_spots"),
        "hyp_glare_fail": cleared("right_without_glare"),
        "fish_merge_fail": caused(MERGED, SPLIT, of=("table_3_6_grids",)),
    }
    reasons = {
        "hyp_dirt_fail": "right once the mirror has no dirt; ",
        "hyp_glare_fail": "right once there is no glare; ",
        "fish_merge_fail": "first failed contour: corners merged, or split; ",
    }
    spotted, clean = (
        right(ball, CELECT, Which(WHOLE, spots), SPOTLESS_SEED)
        for spots in (SPOTTED, CLEAN)
    )
    return {
        f"s3_3_2_{name}": mean_of_runs(of_run, reasons.get(name, "") + RANGE_OF_RUNS)
        for name, of_run in of_runs.items()
    } | {
        "s3_3_2_sph_noise_fail": Value(
            int((clean & ~spotted).sum()),
            reason="right once the mirror has no flaws; of the 15 images of one run",
        ),
        "s3_3_2_total": Value(ours.shape[1], unit="count"),
        "s3_3_2_prec": Value(precision_px, unit="px"),
        "s3_3_2_excess": Value(
            largest_after(results) - precision_px,
            unit="px",
            reason="both methods, all runs; against cornerSubPix from the truth",
        ),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in GRIDS}
    lost = np.concatenate(
        [numbers_of(one, "t8_px")[~right(one, CELECT)] for one in results.values()]
    )
    stated = [c for s in seeds_of(results) for c in causes(results, PRIMARY, s)]
    far_apart = open_results(SPACING), MIN_SPACING_PX["15 px or more"]
    quoted = {
        "whole.celect-linear": 100 * right_by_run(results, LINEAR).mean(),
        "whole.raxel": 100 * right_by_run(results, CLICKLESS).mean(),
        "contours": stated.count(CONTOUR),
        "largest.apart": largest_after(results, far_apart),
        "whole.lost": len(lost),
        "small.whole.lost": int((lost < SMALL_T8_PX).sum()),
    }
    for name, number in quoted.items():
        value(name, number)


# Figs 3.12 and 3.13: images selected by the outcome of detection.


# Class of an image -> (CELECT correct, OpenCV correct).
CLASSES = {
    "both": (True, True),
    "CELECT only": (True, False),
    "neither": (False, False),
}
RED, YELLOW, GREEN = "#e0281c", "#f2c400", "#2f9e3f"


def draw_panel(panel, result, condition):
    """Draw an image with CELECT's corners: circles, joined where ordered."""
    image, (u, v, factor) = (
        result.arrays(name, **condition)[0] for name in ("picture", "place")
    )
    panel.imshow(image, cmap="gray", vmin=0, vmax=255)
    height, width = image.shape[:2]

    def placed(points):
        return (points - (u, v) + 0.5) / factor - 0.5

    for points in result.arrays("detected", **condition):
        panel.plot(*placed(points).T, "o", ms=4, mfc="none", mec=RED, mew=0.8)
    for lattice in map(placed, result.arrays("lattice", **condition)):
        panel.plot(*lattice.transpose(2, 1, 0), "-", color=YELLOW, lw=1.0)
        panel.plot(*lattice.transpose(2, 0, 1), "-", color=GREEN, lw=1.0)
    panel.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


@figure("fig_3_12", needs=("table_3_4_grids", "table_3_5_grids"), evidence="rendered")
@figure("fig_3_13", needs=("table_3_6_grids", "table_3_7_grids"), evidence="rendered")
def examples(results):
    """Draw the first image of each class: a column per set, a row per class."""
    drawn, panels = new_figure(3, 2, height_in=9.6)
    rows = []
    pairs = product(results.values(), CLASSES.items())
    for panel, letter, (result, (name, wanted)) in zip(
        panels.T.flat, "acebdf", pairs, strict=True
    ):
        found = np.array([right(result, method) for method in (CELECT, OPENCV)])
        fits = np.flatnonzero((wanted == found.T).all(axis=1))
        first = {"image": None, "seed": None}
        title = TITLES[result.settings["set"]]
        panel.set_axis_off()
        panel.set_title(f"({letter}) {title}: {name} ({len(fits)})")
        if len(fits):
            first = images_of(result).conditions[fits[0]]
            draw_panel(panel, result, first)
        else:
            centred = {"transform": panel.transAxes, "ha": "center", "va": "center"}
            panel.text(0.5, 0.5, "no such image", **centred)
        rows.append((letter, title, name, len(fits), first["image"], first["seed"]))
    return Drawing(
        drawn,
        columns(("panel", "set", "class", "images", "image", "seed"), rows),
        "Images in which CELECT and OpenCV's findChessboardCorners both succeed, "
        "only CELECT does, or neither does: the first of each class and, in "
        "parentheses, their number, whole range of poses, all simulated runs. "
        "Circles: corners detected by CELECT. Lines: its ordered corners, rows "
        "yellow, columns green. Images are cropped to the board.",
    )


# Share of correct grids by set and range of poses.


SHOWN = {
    CELECT: "CELECT",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}
OFFSET = 0.16


@figure("ext_grid_rates", needs=GRIDS, evidence="rendered")
def ext_grid_rates(results):
    """Draw the share of correct grids of four detectors by set, in both ranges."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    drawn, panels = new_figure(2, 1, height_in=6.4, sharex=True)
    titles = [*TITLES.values(), "Spherical,\nno spots"]
    rows = []
    for panel, poses in zip(panels, (WHOLE, HARD), strict=True):
        for index, (method, label) in enumerate(SHOWN.items()):
            found = [right(results[e], method, Which(poses)) for e in GRIDS]
            if method != CLICKLESS:
                found.append(right(results[GRIDS[0]], method, Which(poses, CLEAN)))
            shares = [proportion(grids) for grids in found]
            at = np.arange(len(found)) + OFFSET * (index - 1.5)
            percent = 100 * np.array([share[:3] for share in shares]).T
            look = look_of(label) | {"linestyle": "none"}
            plot_interval(panel, at, *percent, look=look, label=label, bars=True)
            rows += [
                (poses, label, title.replace("\n", " "), grids.sum(), len(grids))
                + share[1:3]
                for title, grids, share in zip(titles, found, shares, strict=False)
            ]
        panel.set(ylim=(-3, 103), ylabel="Correct grids (%)", title=f"poses: {poses}")
    panels[-1].xaxis.set_major_locator(FixedLocator(range(len(titles))))
    panels[-1].xaxis.set_major_formatter(FixedFormatter(titles))
    legend_below(drawn, panels[0], ncols=2)
    return Drawing(
        drawn,
        columns(("poses", "series", "x", "correct", "images", "low", "high"), rows),
        "Share of correct grids by camera and detector, with exact 95 % "
        "intervals. Above: whole range of poses, three simulated runs. Below: "
        "hard range, one run. Last column: the mirror ball again without "
        "spots, one run.",
    )


# Tables of section 3.3.2.


FULL = "full window"
ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone (ext.)",
    FINE: "CELECT, finer Harris (ext.)",
    BOTH: "CELECT, both (ext.)",
    CLICKLESS: "without clicks (ext.)",
}
PRINTED_COLUMNS = {
    "Correct": "count",
    "Mean before (px)": "pre_mean",
    "Max before (px)": "pre_max",
    "SD before (px)": "pre_sd",
    "Mean after (px)": "post_mean",
    "Max after (px)": "post_max",
    "SD after (px)": "post_sd",
}


@table("table_3_3", needs=GRIDS, evidence="rendered")
def table_3_3(results):
    """Return the four sets as rendered, one row per grid."""
    rows, printed, stated = [], [], []
    for set_name, experiment in EXPERIMENTS.items():
        ran = results[experiment].settings
        stated += corners_as_stated(results[experiment])
        camera = ran["camera"].split(" (thesis")[0].split(", 9 x")[0]
        rows += [
            [TITLES[set_name], camera, *ran["image_px"], *grid, pitch, images]
            for grid, pitch, images in zip(
                ran["grids"], ran["pitch_mm"], ran["images"], strict=True
            )
        ]
        printed += ids_of_set(set_name, ran["grids"])
    of_image = ("Width (px)", "Height (px)", "Columns")
    heads = ("Image set", "Camera", *of_image, "Rows", "Pitch (mm)", "Images")
    return Table(
        columns(heads, rows),
        "Configurations of the rendered sets. Columns and rows count interior "
        "corners. The rig files state the origin of every value.",
        Check(
            bool(stated) and all(stated),
            f"{sum(stated)} of {len(stated)} images show as many corners as the "
            "columns and rows of their grid have",
        ),
        printed=columns((*of_image, "Pitch (mm)", "Images"), printed),
    )


def corners_as_stated(result):
    """Return for each image whether it shows as many corners as its settings state."""
    ran = result.settings
    of_image = np.repeat([wide * high for wide, high in ran["grids"]], ran["images"])
    images = [c["image"] for c in result.conditions]
    return (result.select().column("corners") == of_image[images]).tolist()


def statistics(grids):
    """Return mean, maximum and SD (px) of the errors of correct grids, or None.

    The mean has a 95 % interval, by bootstrap over whole grids.
    """
    if not grids:
        return [None] * 3
    sums, counts = np.array([[e.sum(), len(e)] for e in grids]).T

    def mean(total, number):
        return total.sum(axis=-1) / number.sum(axis=-1)

    every = np.concatenate(grids)
    middle = Measured(*bootstrap(mean, sums, counts, paired=True)[:3])
    return [middle, float(every.max()), float(every.std(ddof=1))]


@table("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
@table("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
@table("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
@table("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def table_of_set(results):
    """Return counts and errors of every method in one set."""
    number, result = numbered(results)
    rows = []
    for method, name in ROWS.items():
        found = right(result, method)
        after = partial(errors, result, method, "after")
        rows.append(
            [name, int(found.sum()), len(found)]
            + statistics(errors(result, method, "before", TRUTH))
            + statistics(after(REFERENCE))
            + statistics(after(REFERENCE, window=FULL))[:2]
            + statistics(after(TRUTH))[1:2]
        )
    half = result.settings["localiser"]["half_window_px"]
    heads = (
        *("Method", "Correct", "Images", *list(PRINTED_COLUMNS)[1:]),
        "Mean after, full window (px)",
        "Max after, full window (px)",
        "Max after, against truth (px)",
    )
    return Table(
        columns(heads, rows),
        f"{TITLES[result.settings['set']]} set: numbers of correct grids and errors "
        "of their corners, whole range of poses, all simulated runs. Errors before "
        "localisation are relative to the true corners. Errors after it are relative "
        "to the true corners refined by the same localiser, as in the thesis, with a "
        f"half-window of {half[WINDOW]} px (full window: {half[FULL]} px). "
        "Brackets: 95 % interval of the mean over grids.",
        printed={
            head: [
                f"t{number}_{PRINTED_METHODS[method]}_{what}"
                if method in PRINTED_METHODS
                else None
                for method in ROWS
            ]
            for head, what in PRINTED_COLUMNS.items()
        },
    )
