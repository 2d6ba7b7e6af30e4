"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

import math
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator

from chapters.ch03_planar_grids.s3_2_grid_sets.experiment import (
    BOTH,
    CONTOUR,
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
    Reading,
    Table,
    Value,
    bootstrap,
    figure,
    numbers,
    proportion,
    table,
)
from repro.run import columns as as_csv

# Rendered images of 3.3.2: selection by interpretation, and detection results.


# Set -> the experiment that ran it.
EXPERIMENTS = {
    "spherical": "table_3_4_grids",
    "hyperboloidal": "table_3_5_grids",
    "fisheye": "table_3_6_grids",
    "flexible-mirror": "table_3_7_grids",
}
# All four: what the claims on sixty images need.
GRIDS = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
# Smallest distances of their corners, and the experiments of the claim on these.
SPACING = "exp_c3_same_after_loc"
GRIDS_AND_SPACING = (
    "table_3_4_grids",
    "table_3_5_grids",
    "table_3_6_grids",
    "table_3_7_grids",
    "exp_c3_same_after_loc",
)
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


def pictures_of(result, which=PRIMARY, seed=None):
    """Return the selected images of an experiment, of one run or of all."""
    if which.spots == CLEAN:
        seed = SPOTLESS_SEED
    of_seed = {} if seed is None else {"seed": seed}
    return result.select(poses=which.poses, **of_seed)


def seeds_of(results, which=PRIMARY):
    """Return the runs of the selected images, which all four experiments share."""
    return pictures_of(next(iter(results.values())), which).levels("seed")


def prefix_of(result, which):
    """Return the prefix of a value's name: only the ball has images without spots."""
    spherical = result.settings["set"] == "spherical"
    return "spotless." if spherical and which.spots == CLEAN else ""


def numbers_of(result, name, which=PRIMARY, seed=None):
    """Return a number of each selected image, (n,)."""
    return pictures_of(result, which, seed).column(prefix_of(result, which) + name)


def right(result, method, which=PRIMARY, seed=None):
    """Return whether each image's grid was found and in order, (n,) bool."""
    return numbers_of(result, f"{method}.success", which, seed) == 1


def all_right(results, method, which, seed):
    """Return `right` of a run's images of all sets, in the order of the sets."""
    return np.concatenate(
        [right(results[name], method, which, seed) for name in EXPERIMENTS.values()]
    )


def of_each_seed(results, detector, which):
    """Yield which images CELECT and a detector extract correctly, run by run.

    Each item is (seed, (n,) bool, (n,) bool), over the images of all four sets.
    """
    for seed in seeds_of(results, which):
        ours, theirs = (
            all_right(results, method, which, seed) for method in (CELECT, detector)
        )
        yield seed, ours, theirs


@cache
def _errors_of_pictures(result, name):
    """Return {(image, seed, poses): errors (methods, 7, corners)}."""
    return {
        tuple(c.values()): found
        for c in result.conditions
        for found in result.arrays(name, **c)
    }


def errors(result, method, when, reference, which=PRIMARY, seed=None, window=WINDOW):
    """Return errors (px) of the corners of correct grids, one array (n,) per grid.

    when: 'before' or 'after' localisation; reference: one of REFERENCES;
    window: of the localiser, where it applies.
    """
    prefix = prefix_of(result, which)
    methods = SPOTLESS if prefix else METHODS
    as_detected = when == "before" and reference == TRUTH
    row = MEASURES.index((when, reference, None if as_detected else window))
    stored = _errors_of_pictures(result, f"{prefix}errors")
    return [
        stored[tuple(c.values())][methods.index(method), row]
        for c, good in zip(
            pictures_of(result, which, seed).conditions,
            right(result, method, which, seed),
            strict=True,
        )
        if good
    ]


def apart(found, result, spacing, least_px, method, which=PRIMARY, seed=None):
    """Return those `errors` of grids with neighbouring corners at least this far apart.

    spacing: Result of SPACING.
    """
    pictures = pictures_of(result, which, seed).conditions
    good = right(result, method, which, seed)
    steps = [
        spacing.column("least_px", **picture)[0]
        for picture, is_right in zip(pictures, good, strict=True)
        if is_right
    ]
    return [one for one, step in zip(found, steps, strict=True) if step >= least_px]


def texts(result, name, which=PRIMARY, seed=None):
    """Return one text of each image, None where it has none."""
    return pictures_of(result, which, seed).texts(prefix_of(result, which) + name)


def causes(results, which, seed, set_name=None):
    """Return the causes of CELECT's failures, one text per failed image of a run."""
    names = EXPERIMENTS if set_name is None else [set_name]
    found = []
    for name in names:
        result = results[EXPERIMENTS[name]]
        lost = ~right(result, CELECT, which, seed)
        stated = texts(result, f"{CELECT}.cause", which, seed)
        found += [cause for cause, bad in zip(stated, lost, strict=True) if bad]
    return found


def cleared(result, blemish, seed):
    """Return how many failures of CELECT succeed with a clean mirror."""
    name = f"{CELECT}.right_without_{blemish}"
    return int((numbers_of(result, name, PRIMARY, seed) == 1).sum())


def opened_all(open_results):
    """Return the four results by the names of their experiments."""
    return {name: open_results(name) for name in EXPERIMENTS.values()}


def spread(values):
    """Return the mean of one value per run, with the range of the runs."""
    return Estimate(*(float(of(values)) for of in (np.mean, np.min, np.max)))


# Regenerated numbers of 3.3.2, and those that its page quotes.


# Short names of sets in the registry's numbers.
SHORT = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
# Merging distance of CELECT below which squares are small.
SMALL_T8_PX = 4.5
SEEDS_RANGE = "mean and range of the rendered seeds"


def chance_of_split(only_one, only_other):
    """Return the exact two-sided p-value of McNemar's test for a split of images."""
    count = only_one + only_other
    fewer = min(only_one, only_other)
    tail = sum(math.comb(count, k) for k in range(fewer + 1))
    return min(1.0, 2 * tail / 2**count)


@numbers("table_3_3", needs=GRIDS, evidence="rendered")
def numbers_table_3_3(results):
    """Return the settings as they were run."""
    found = {}
    for set_name, short in SHORT.items():
        ran = results[EXPERIMENTS[set_name]].settings
        width, height = ran["image_px"]
        found[f"t3_3_{short}_w"] = Value(width, unit="px")
        found[f"t3_3_{short}_h"] = Value(height, unit="px")
        single = len(ran["grids"]) == 1
        for (columns, rows), pitch in zip(ran["grids"], ran["pitch_mm"], strict=True):
            size = f"{columns}x{rows}"
            found[f"t3_3_{short}_grid_{size}"] = Value(size, unit="count")
            tail = "" if single else f"_{size}"
            found[f"t3_3_{short}_pitch{tail}"] = Value(pitch, unit="mm")
    total = sum(results[EXPERIMENTS["spherical"]].settings["images"])
    return found | {"t3_3_images": Value(total, unit="count")}


def joined(found):
    """Return all errors of several grids in one array."""
    return np.concatenate([np.empty(0), *found])


def mean_of_seeds(found, reason, unit=""):
    """Return the mean of one number per run, with the range of the runs."""
    mean, low, high, _ = spread(found)
    return Value(mean, (low, high), unit, reason)


def of_table(result, table_id):
    """Return counts and errors of OpenCV's and CELECT's rows of one table."""
    found = {}
    for name, method in (("opencv", OPENCV), ("celect", CELECT)):
        by_seed = pictures_of(result).levels("seed")
        counts = [right(result, method, PRIMARY, s).sum() for s in by_seed]
        found[f"t{table_id}_{name}_count"] = mean_of_seeds(
            counts, SEEDS_RANGE, "count (of 15)"
        )
        for label, when, reference in (
            ("pre", "before", TRUTH),
            ("post", "after", REFERENCE),
        ):
            seeds = [
                joined(errors(result, method, when, reference, seed=s)) for s in by_seed
            ]
            sizes, seeds = joined(seeds), [s for s in seeds if len(s)]
            for statistic, taken in (
                ("mean", np.mean),
                ("max", np.max),
                ("sd", lambda e: e.std(ddof=1)),
            ):
                key = f"t{table_id}_{name}_{label}_{statistic}"
                found[key] = Value(
                    float(taken(sizes)) if seeds else "no right grid",
                    interval=spread([taken(s) for s in seeds])[1:3] if seeds else None,
                    unit="px",
                    reason="all seeds together, and range of the seeds; "
                    f"against {reference}",
                )
    return found


@numbers("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def numbers_table_3_4(results):
    """Return the numbers of the Spherical set."""
    return of_table(results["table_3_4_grids"], "3_4")


@numbers("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def numbers_table_3_5(results):
    """Return the numbers of the Hyperboloidal set."""
    return of_table(results["table_3_5_grids"], "3_5")


@numbers("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def numbers_table_3_6(results):
    """Return the numbers of the Fisheye set."""
    return of_table(results["table_3_6_grids"], "3_6")


@numbers("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def numbers_table_3_7(results):
    """Return the numbers of the Flexible Mirror set."""
    return of_table(results["table_3_7_grids"], "3_7")


def largest_after(results, reference):
    """Return the largest error (px) after localisation, of OpenCV and CELECT."""
    sizes = [
        joined(errors(result, method, "after", reference))
        for result in results.values()
        for method in (OPENCV, CELECT)
    ]
    return float(np.concatenate(sizes).max(initial=0.0))


def largest_far_apart(results, spacing):
    """Return the same for grids with all neighbouring corners at least 15 px apart."""
    least_px = MIN_SPACING_PX["15 px or more"]
    sizes = [
        one
        for result in results.values()
        for method in (OPENCV, CELECT)
        for one in apart(
            errors(result, method, "after", REFERENCE),
            result,
            spacing,
            least_px,
            method,
        )
    ]
    return float(joined(sizes).max(initial=0.0))


def spared_by_clean_ball(result):
    """Return how many failures of CELECT succeed without the spots."""
    spotted = right(result, CELECT, PRIMARY, SPOTLESS_SEED)
    clean = right(result, CELECT, Which(WHOLE, CLEAN), SPOTLESS_SEED)
    return int((clean & ~spotted).sum())


@numbers("sec_3_3_2", needs=GRIDS, evidence="rendered")
def numbers_sec_3_3_2(results):
    """Return totals over the four sets, and causes of CELECT's failures."""
    precision = results["table_3_4_grids"].settings["localiser"]
    hyperboloidal = results[EXPERIMENTS["hyperboloidal"]]

    def caused(seed, *kinds, of=None):
        stated = causes(results, PRIMARY, seed, of)
        return sum(stated.count(kind) for kind in kinds)

    totals = {
        "opencv_only": lambda ours, theirs: (theirs & ~ours).sum(),
        "celect_only": lambda ours, theirs: (ours & ~theirs).sum(),
        "celect_rate": lambda ours, theirs: 100 * ours.mean(),
        "opencv_rate": lambda ours, theirs: 100 * theirs.mean(),
    }
    counts = {
        "contour_fail": lambda s: caused(s, CONTOUR),
        "sph_missed_fail": lambda s: caused(s, MISSED, of="spherical"),
        "hyp_dirt_fail": lambda s: cleared(hyperboloidal, "spots", s),
        "hyp_glare_fail": lambda s: cleared(hyperboloidal, "glare", s),
        "fish_merge_fail": lambda s: caused(s, MERGED, SPLIT, of="fisheye"),
    }
    reasons = {
        "hyp_dirt_fail": "right once the mirror has no dirt",
        "hyp_glare_fail": "right once there is no glare",
        "fish_merge_fail": "first failed contour: corners merged, or split",
    }
    by_seed = list(of_each_seed(results, OPENCV, PRIMARY))
    of_seeds = {
        name: [count(*pair) for _, *pair in by_seed] for name, count in totals.items()
    } | {name: [count(s) for s, *_ in by_seed] for name, count in counts.items()}
    found = {
        f"s3_3_2_{name}": mean_of_seeds(
            of_seed, "; ".join(filter(None, [reasons.get(name), SEEDS_RANGE]))
        )
        for name, of_seed in of_seeds.items()
    }
    return found | {
        "s3_3_2_sph_noise_fail": Value(
            spared_by_clean_ball(results[EXPERIMENTS["spherical"]]),
            reason="right once the mirror has no flaws; of the 15 pictures of one seed",
        ),
        "s3_3_2_total": Value(len(by_seed[0][1]), unit="count"),
        "s3_3_2_prec": Value(precision["precision_px"], unit="px"),
        "s3_3_2_excess": Value(
            largest_after(results, REFERENCE) - precision["precision_px"],
            unit="px",
            reason="both methods, all seeds; against cornerSubPix from the truth",
        ),
    }


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = opened_all(open_results)
    stated = [c for s in seeds_of(results) for c in causes(results, PRIMARY, s)]
    quoted = {
        f"{WHOLE}.{method}": mean_rate(results, method)
        for method in (LINEAR, CLICKLESS)
    } | {
        "contours": stated.count(CONTOUR),
        "largest.apart": largest_far_apart(results, open_results(SPACING)),
        **of_lost(results),
    }
    for name, number in quoted.items():
        value(name, number)


def mean_rate(results, method):
    """Return the mean over the runs of a method's success, in percent."""
    rates = [
        100 * all_right(results, method, PRIMARY, s).mean() for s in seeds_of(results)
    ]
    return float(np.mean(rates))


def of_lost(results):
    """Return how many grids CELECT fails on, and how many have small squares."""
    reach = [
        numbers_of(result, "t8_px")[~right(result, CELECT)]
        for result in results.values()
    ]
    lost = np.concatenate(reach)
    return {
        f"{WHOLE}.lost": len(lost),
        f"small.{WHOLE}.lost": int((lost < SMALL_T8_PX).sum()),
    }


# Verdicts of predicates that are tested run by run.


def seed_by_seed(holds, found, reason, unit=""):
    """Return the Reading of a predicate from the runs that it applies to.

    found: what was measured, as `Reading.of` takes it.
    """
    seeds = f"true of {int(np.sum(holds))} of {len(holds)} seeds"
    seeds = seeds if holds else "no seed has any"
    return Reading.of_seeds(holds, found, unit, f"{reason}; {seeds}")


# Figs 3.12 and 3.13: images selected by the outcome of detection.


# Class of an image -> (CELECT correct, OpenCV correct).
CLASSES = {
    "both": (True, True),
    "CELECT only": (True, False),
    "neither": (False, False),
}
RED, YELLOW, GREEN = "#e0281c", "#f2c400", "#2f9e3f"


def example(result, which):
    """Return the first image of a class, or None, and the size of the class."""
    ours, theirs = (right(result, m) for m in (CELECT, OPENCV))
    wanted_ours, wanted_theirs = CLASSES[which]
    fits = (ours == wanted_ours) & (theirs == wanted_theirs)
    first = pictures_of(result).conditions[int(np.argmax(fits))]
    return (first if fits.any() else None), int(fits.sum())


def draw_panel(panel, result, condition):
    """Draw an image with CELECT's corners: circles, joined where ordered."""
    (picture,) = result.arrays("picture", **condition)
    u, v, factor = result.arrays("place", **condition)[0]
    colours = {"cmap": "gray", "vmin": 0, "vmax": 255}
    panel.imshow(picture, **({} if picture.ndim == 3 else colours))
    height, width = picture.shape[:2]

    def placed(points):
        return (points - (u, v) + 0.5) / factor - 0.5

    for name in result.arrays("detected", **condition):
        panel.plot(*placed(name).T, "o", ms=4, mfc="none", mec=RED, mew=0.8)
    for lattice in result.arrays("lattice", **condition):
        for row in placed(lattice):
            panel.plot(*row.T, "-", color=YELLOW, lw=1.0)
        for column in placed(lattice).transpose(1, 0, 2):
            panel.plot(*column.T, "-", color=GREEN, lw=1.0)
    panel.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def examples(results, set_names):
    """Return the drawing of one figure: a column per set, a row per class."""
    drawn, panels = new_figure(3, 2, height_in=9.6)
    rows = []
    for column, set_name in enumerate(set_names):
        result = results[EXPERIMENTS[set_name]]
        for row, which in enumerate(CLASSES):
            panel = panels[row, column]
            letter = "abcdef"[2 * row + column]
            condition, count = example(result, which)
            panel.set_title(f"({letter}) {TITLES[set_name]}: {which} ({count})")
            panel.set(xticks=[], yticks=[])
            panel.grid(visible=False)
            panel.spines[:].set_visible(False)
            if condition is None:
                centred = {"transform": panel.transAxes, "ha": "center", "va": "center"}
                panel.text(0.5, 0.5, "no such image", **centred)
            else:
                draw_panel(panel, result, condition)
            first = condition or {"image": None, "seed": None}
            named = letter, TITLES[set_name], which, count
            rows.append((*named, first["image"], first["seed"]))
    caption = (
        "Images in which CELECT and OpenCV's findChessboardCorners both succeed, "
        "only CELECT does, or neither does: the first of each class and, in "
        "parentheses, their number, whole range of poses, all simulated runs. "
        "Circles: corners detected by CELECT. Lines: its ordered corners, rows "
        "yellow, columns green. Images are cropped to the board."
    )
    heads = ("panel", "set", "class", "images", "image", "seed")
    return Drawing(drawn, as_csv(heads, rows), caption)


@figure("fig_3_12", needs=("table_3_4_grids", "table_3_5_grids"), evidence="rendered")
def fig_3_12(results):
    """Draw examples of the Spherical and Hyperboloidal sets."""
    return examples(results, ("spherical", "hyperboloidal"))


@figure("fig_3_13", needs=("table_3_6_grids", "table_3_7_grids"), evidence="rendered")
def fig_3_13(results):
    """Draw examples of the Fisheye and Flexible Mirror sets."""
    return examples(results, ("fisheye", "flexible-mirror"))


# Share of correct grids by set and range of poses.


SHOWN = {
    CELECT: "CELECT",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}
SPOTLESS_TITLE = "Spherical,\nno spots"
OFFSET = 0.16
HEADS = ("series", "x", "correct", "images", "low", "high")


def plot_shares(panel, at, trials, label):
    """Draw the shares (%) of correct grids of one detector.

    Returns the figure's data of each: correct, images, ends of the interval.
    """
    found = [proportion(right_of) for right_of in trials]
    shares = 100 * np.array([share[:3] for share in found])
    plot_interval(panel, at, *shares.T, look=look_of(label), label=label, bars=True)
    return [
        (int(right_of.sum()), len(right_of), share.low, share.high)
        for right_of, share in zip(trials, found, strict=True)
    ]


@figure("ext_grid_rates", needs=GRIDS, evidence="rendered")
def ext_grid_rates(results):
    """Draw the share of correct grids of four detectors by set, in both ranges."""
    drawn, panels = new_figure(2, 1, height_in=6.4, sharex=True)
    titles = [*TITLES.values(), SPOTLESS_TITLE]
    rows = []
    for panel, poses in zip(panels, (WHOLE, HARD), strict=True):
        for index, (method, label) in enumerate(SHOWN.items()):
            found = [
                right(results[e], method, Which(poses)) for e in EXPERIMENTS.values()
            ]
            if method != CLICKLESS:
                ball = results[EXPERIMENTS["spherical"]]
                found.append(right(ball, method, Which(poses, CLEAN)))
            at = np.arange(len(found)) + OFFSET * (index - 1.5)
            shares = plot_shares(panel, at, found, label)
            rows += [
                (poses, label, title.replace("\n", " "), *share)
                for title, share in zip(titles, shares, strict=False)
            ]
            for line in panel.lines:
                line.set_linestyle("none")
        panel.set(ylim=(-3, 103), ylabel="Correct grids (%)", title=f"poses: {poses}")
    panels[-1].xaxis.set_major_locator(FixedLocator(range(len(titles))))
    panels[-1].xaxis.set_major_formatter(FixedFormatter(titles))
    legend_below(drawn, panels[0], ncols=2)
    return Drawing(
        drawn,
        as_csv(("poses", *HEADS), rows),
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
# Names of sets, methods and published columns in the registry's ids.
PRINTED_SETS = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
PRINTED_METHODS = {OPENCV: "opencv", CELECT: "celect"}
PRINTED_COLUMNS = {
    "Correct": "count",
    "Mean before (px)": "pre_mean",
    "Max before (px)": "pre_max",
    "SD before (px)": "pre_sd",
    "Mean after (px)": "post_mean",
    "Max after (px)": "post_max",
    "SD after (px)": "post_sd",
}
PRINTED_CONFIGURATION = ("Width (px)", "Height (px)", "Columns", "Pitch (mm)", "Images")
TABLES_HEADS = (
    "Method",
    "Correct",
    "Images",
    "Mean before (px)",
    "Max before (px)",
    "SD before (px)",
    "Mean after (px)",
    "Max after (px)",
    "SD after (px)",
    "Mean after, full window (px)",
    "Max after, full window (px)",
    "Max after, against truth (px)",
)


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
        printed += configuration(PRINTED_SETS[set_name], ran["grids"])
    heads = (
        "Image set",
        "Camera",
        "Width (px)",
        "Height (px)",
        "Columns",
        "Rows",
        "Pitch (mm)",
        "Images",
    )
    return Table(
        as_csv(heads, rows),
        "Configurations of the rendered sets. Columns and rows count interior "
        "corners. The rig files state the origin of every value.",
        Check(
            bool(stated) and all(stated),
            f"{sum(stated)} of {len(stated)} images show as many corners as the "
            "columns and rows of their grid have",
        ),
        printed=as_csv(PRINTED_CONFIGURATION, printed),
    )


def configuration(short, grids):
    """Return the ids of published values of a set, one row per grid."""
    named = [(f"_grid_{wide}x{high}", f"_{wide}x{high}") for wide, high in grids]
    alone = len(grids) == 1
    return [
        (
            *(f"t3_3_{short}{of}" for of in ("_w", "_h", grid)),
            f"t3_3_{short}_pitch{'' if alone else size}",
            "t3_3_images" if alone else None,
        )
        for grid, size in named
    ]


def corners_as_stated(result):
    """Return for each image whether it shows as many corners as its settings state."""
    ran = result.settings
    of_image = np.repeat([wide * high for wide, high in ran["grids"]], ran["images"])
    images = [c["image"] for c in result.conditions]
    return (result.select().column("corners") == of_image[images]).tolist()


def mean_of(grids):
    """Return the mean over all corners; 95 % bootstrap interval over whole grids."""
    sums, counts = np.array([[e.sum(), len(e)] for e in grids]).T

    def statistic(total, number):
        return total.sum(axis=-1) / number.sum(axis=-1)

    return Measured(*bootstrap(statistic, sums, counts, paired=True)[:3])


def statistics(grids):
    """Return mean, maximum and SD (px) of the errors of correct grids, or None."""
    if not grids:
        return [None] * 3
    every = np.concatenate(grids)
    return [mean_of(grids), float(every.max()), float(every.std(ddof=1))]


def error_table(result, number):
    """Return counts and errors of every method in one set, as in Table 3.``number``."""
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
    title = TITLES[result.settings["set"]]
    half = result.settings["localiser"]["half_window_px"]
    return Table(
        as_csv(TABLES_HEADS, rows),
        f"{title} set: numbers of correct grids and errors of their corners, whole "
        "range of poses, all simulated runs. Errors before localisation are "
        "relative to the true corners. Errors after it are relative to the true "
        "corners refined by the same localiser, as in the thesis, with a "
        f"half-window of {half[WINDOW]} px (full window: {half[FULL]} px). "
        "Brackets: 95 % interval of the mean over grids.",
        printed={
            head: [
                f"t3_{number}_{PRINTED_METHODS[method]}_{what}"
                if method in PRINTED_METHODS
                else None
                for method in ROWS
            ]
            for head, what in PRINTED_COLUMNS.items()
        },
    )


@table("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def table_3_4(results):
    """Return the table of the Spherical set."""
    return error_table(results["table_3_4_grids"], 4)


@table("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def table_3_5(results):
    """Return the table of the Hyperboloidal set."""
    return error_table(results["table_3_5_grids"], 5)


@table("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def table_3_6(results):
    """Return the table of the Fisheye set."""
    return error_table(results["table_3_6_grids"], 6)


@table("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def table_3_7(results):
    """Return the table of the Flexible Mirror set."""
    return error_table(results["table_3_7_grids"], 7)
