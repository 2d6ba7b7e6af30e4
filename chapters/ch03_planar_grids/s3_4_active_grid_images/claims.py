"""Claims of section 3.3.4, run by run, and its regenerated numbers."""

from functools import partial
from itertools import pairwise

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.experiment import (
    AS_TEXT,
    FILTERS,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.report import (
    BOTH_PIXELS,
    CASES,
    CORNERS,
    FACETS,
    FAR,
    FAR_CASE,
    FILTERED,
    LINES,
    METHODS,
    NAMES,
    OF_CORNERS,
    OF_LINES,
    VECTOR_SCALE,
    Corners,
    corners_of,
    filtered,
    lines_of,
    percent,
    spread_between,
    spread_gap,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.scenes import rig_of
from raxel.features.localise.subpix import TERMINATION_PX
from repro.run import Case, Value, claim, counterpart, numbers

SENSOR_MM = 23.6  # width of the camera's sensor
MAX_RATIO, MAX_LOSS = 1.25, 1.05
MAX_SPEARMAN = -0.8
MAX_BENT, MIN_BENT = 0.01, 0.05
MAX_ANGLE_DEG = 1.0
MAX_SQUARES, FACETS_FAILED = 0.1, 0.5
SIGNIFICANCE = 0.01
OUTER = 0.8  # quantile of the radius that begins the outer quintile
OF_TABLE = (
    "opencv_window",
    "active_corner",
    "lens_left",
    "undistorted_bits",
    "edge_blur",
    "picture_pixels",
)


@claim("c3_t38_order", needs=BOTH_PIXELS, evidence="rendered", readings=OF_TABLE)
def judge_order(results, options):
    """Derivative below active grid below OpenCV below saddle point."""
    case = corners_of(results, options)
    mean = {m: case.statistic(m, "mean") for m in METHODS}
    order = ("derivative", "active grid", "OpenCV", "saddle point")
    steps = [mean[a] < mean[b] for a, b in pairwise(order)]
    best = np.all([mean["derivative"] < mean[m] for m in METHODS[1:]], axis=0)
    others = [mean[m] for m in METHODS if m != "saddle point"]
    worst = np.all(mean["saddle point"] > others, axis=0)
    medians = ", ".join(f"{m} {np.median(mean[m]):.4f}" for m in METHODS)
    return counterpart(
        np.all(steps, axis=0),
        np.sum(steps, axis=0),
        "1",
        f"how many of the three orderings hold; median means {medians} px; "
        f"derivative the best in {best.sum()} seeds, saddle point the worst "
        f"in {worst.sum()}",
    )


@claim("c3_t38_close", needs=BOTH_PIXELS, evidence="rendered", readings=OF_TABLE)
def judge_close(results, options):
    """Means of derivative, active grid and OpenCV within a factor of 1.25."""
    case = corners_of(results, options)
    means = np.array([case.statistic(m, "mean") for m in METHODS if "saddle" not in m])
    ratio = means.max(axis=0) / means.min(axis=0)
    return counterpart(
        ratio <= MAX_RATIO, ratio, "1", "largest of the three means over the least"
    )


@claim(
    "c3_deriv_window",
    needs=BOTH_PIXELS,
    evidence="rendered",
    readings=("undistorted_bits", "edge_blur", "picture_pixels"),
)
def judge_window(results, options):
    """Spearman of window and mean residual at most -0.8."""
    from scipy.stats import spearmanr

    curves = corners_of(results, options).curve("derivative")
    ranks = np.array([spearmanr(*curve).statistic for curve in curves])
    last = ", ".join(f"{w[-1]:g}" for w, _ in curves)
    return counterpart(
        ranks <= MAX_SPEARMAN,
        ranks,
        "1",
        f"Spearman over windows of 5 px to those that still fit: {last} px",
    )


@claim(
    "c3_params_square",
    needs=OF_CORNERS,
    evidence="rendered",
    readings=("opencv_window",),
)
def judge_square(results, options):
    """The best window differs with squares of half the apparent size."""
    near = Corners(results[CORNERS], options)
    far = Corners(results[FAR], options, FAR_CASE)
    windows = {m: (near.best_window(m), far.best_window(m)) for m in METHODS[:3]}
    least = np.min([np.abs(one - two) for one, two in windows.values()], axis=0)
    best = [f"{m} {listed(a)} and {listed(b)}" for m, (a, b) in windows.items()]
    return counterpart(
        least > 0,
        least,
        "px",
        "least difference over the three methods; best windows (px) near and "
        f"far by seed: {'; '.join(best)}",
    )


@claim(
    "c3_active_no_params",
    needs=("exp_c3_active_no_params",),
    evidence="rendered",
    readings=("active_corner", "lens_left"),
)
def judge_no_params(results, options):
    """The same filters serve squares of half the apparent size, and none is better."""
    left = {
        case: {w: filtered(results[FILTERED], case, w, options) for w in FILTERS}
        for case in CASES
    }
    near, far = (one[AS_TEXT] for one in left.values())
    loss = np.max([of_best(AS_TEXT, one) for one in left.values()], axis=0)
    medians = "; ".join(
        f"{case} " + ", ".join(f"{w} {np.median(m):.4f}" for w, m in one.items())
        for case, one in left.items()
    )
    return counterpart(
        (far <= MAX_RATIO * near) & (loss <= MAX_LOSS),
        far / near,
        "1",
        "mean residual where squares look half as large over that near; with the "
        f"filters of 3.2.2 at most {loss.max():.3f} x the least of any filter; "
        f"median means (px) by filter: {medians}",
    )


def of_best(which, left):
    """Return residuals with a filter over the smallest; left: filter -> (runs,)."""
    return left[which] / np.min([*left.values()], axis=0)


def listed(values):
    """Return numbers as text."""
    return ", ".join(f"{v:g}" for v in values)


def radial_residuals(case, method):
    """Return signed radial residuals (n,) px of the outer quintile of each run."""

    def of_seed(corners, vectors, middle):
        away = corners - middle
        radius = np.linalg.norm(away, axis=1)
        outer = radius >= np.nanquantile(radius, OUTER)
        return (vectors * away).sum(axis=1)[outer] / radius[outer]

    both = (case.arrays(method, name) for name in ("corners", "vectors"))
    return list(map(of_seed, *both, case.trials.arrays("middle")))


@claim(
    "c3_residual_radial",
    needs=("table_3_8_corners",),
    evidence="rendered",
    readings=("active_corner",),
)
def judge_radial(results, options):
    """The mean radial residual of the outer quintile is not 0."""
    from scipy.stats import ttest_1samp

    case = Corners(results[CORNERS], options)
    found = {method: radial_residuals(case, method) for method in METHODS}
    p = {m: [ttest_1samp(one, 0).pvalue for one in seeds] for m, seeds in found.items()}
    worst = np.max([*p.values()], axis=0)
    means = ", ".join(
        f"{m} {np.median([x.mean() for x in found[m]]):+.4f} (p {np.median(p[m]):.2g})"
        for m in METHODS
    )
    return counterpart(
        worst < SIGNIFICANCE,
        worst,
        "1",
        "largest p of the four methods; median over seeds of the mean radial "
        f"residual (px): {means}",
    )


@claim(
    "c3_active_undistort",
    needs=("fig_3_17_lines",),
    evidence="rendered",
    readings=("room_view", "line_points", "lines_of_a_picture"),
)
def judge_undistort(results, options):
    """Lines bent by at least 5 % before, and by at most 1 % after."""
    taken = Case(NAMES, options)
    lines = lines_of(results[LINES], options, view=taken["room_view"])
    measure = taken["lines_of_a_picture"]
    before, after = (
        np.array([measure(getattr(one, when)) for one in lines])
        for when in ("before", "after")
    )
    return counterpart(
        (after <= MAX_BENT) & (before >= MIN_BENT),
        100 * after,
        "%",
        "largest distance from the line over its length, after; before it is "
        f"{percent(np.median(before)):.2f} %",
    )


@claim(
    "c3_pitch_vertical", needs=OF_LINES, evidence="rendered", readings=("line_points",)
)
def judge_pitch(results, options):
    """Verticals straight to 1 %, and converging as the pitch predicts to 1 deg."""
    wall = {"view": "long wall"}
    lines = [x for ran in OF_LINES for x in lines_of(results[ran], options, **wall)]
    gaps = np.array([spread_gap(x) for x in lines])
    bent = np.array([x.after[x.vertical].max() for x in lines])
    angles = [f"{x.pitch:.1f}: {spread_between(x, x.lean):.2f}" for x in lines]
    return counterpart(
        (gaps <= MAX_ANGLE_DEG) & (bent < MAX_BENT),
        gaps,
        "deg",
        "difference of the angle between the outermost verticals from the "
        f"predicted one; found, by pitch (deg): {', '.join(angles)}; "
        f"most bent vertical {percent(bent.max()):.2f} % (seeds and pitches)",
    )


@claim(
    "c3_disco",
    needs=("fig_3_18_facets",),
    evidence="rendered",
    readings=("static_grid",),
)
def judge_disco(results, options):
    """Remapped corners within 0.1 square, where a static grid fails on half."""
    trials = results[FACETS].select()
    errors = np.array([np.nanmedian(e) for e in trials.arrays("corner_squares")])
    right = trials.arrays(Case(NAMES, options)["static_grid"])
    failed = np.array([np.mean(one < 0.5) for one in right])
    return counterpart(
        (errors <= MAX_SQUARES) & (failed >= FACETS_FAILED),
        errors,
        "squares",
        "median distance of remapped corners from their places; the static "
        f"grid fails on {percent(failed.min()):.0f} % of the facets or more",
    )


@numbers("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def numbers_of_table(results):
    """Return means, SDs and best settings of Table 3.8."""
    case = Corners(results[CORNERS])
    short = dict(
        zip(METHODS, ("derivative", "opencv", "saddle", "active"), strict=True)
    )
    of_seeds = partial(Value.of_seeds, unit="px")
    return {
        **{
            f"t3_8_{name}_{which}": of_seeds(case.statistic(method, which))
            for method, name in short.items()
            for which in ("mean", "sd")
        },
        **{
            f"t3_8_{name}_win": of_seeds(case.best_window(method))
            for method, name in short.items()
            if method != "active grid"
        },
        "t3_8_saddle_blur": of_seeds(case.best_blur()),
        "t3_8_term": Value(TERMINATION_PX, unit="px"),
    }


@numbers("fig_3_16", needs=(), evidence="rendered")
def numbers_of_vectors(results):
    """Return the magnification of the plotted vectors."""
    return {"fig3_16_scale": Value(VECTOR_SCALE)}


@numbers("fig_3_17", needs=("fig_3_17_lines",), evidence="rendered")
def numbers_of_fisheye(results):
    """Return the focal length (mm) of the rig, from that in px and its pixels."""
    rig = rig_of(results[LINES].conditions[0]["rig"])
    pixel_mm = SENSOR_MM / rig.camera.width
    return {"fig3_17_f": Value(round(rig.camera.focal_px * pixel_mm, 1), unit="mm")}
