"""Claims of section 3.3.4, run by run, and its regenerated numbers."""

from functools import partial
from itertools import pairwise

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.experiment import (
    AS_TEXT,
    FILTERS,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.report import (
    FACETS,
    LINES,
    METHODS,
    NAMES,
    PRINTED,
    VECTOR_SCALE,
    VIEW,
    Corners,
    lines_of,
    spread_between,
    spread_gap,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.scenes import rig_of
from raxel.features.localise import TERMINATION_PX
from repro.run import Case, Value, claim, counterpart, numbers

BOTH_PIXELS = ("table_3_8_corners", "exp_c3_t38_native")
OF_CORNERS = ("table_3_8_corners", "exp_c3_params_square")
OF_LINES = ("fig_3_17_lines", "exp_c3_pitch_vertical")
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
    means = Corners(results, options).statistic("mean")
    mean = dict(zip(METHODS, means, strict=True))
    order = ("derivative", "active grid", "OpenCV", "saddle point")
    steps = [mean[a] < mean[b] for a, b in pairwise(order)]
    best, worst = means.argmin(axis=0), means.argmax(axis=0)
    medians = ", ".join(f"{m} {np.median(mean[m]):.4f}" for m in METHODS)
    return counterpart(
        np.all(steps, axis=0),
        np.sum(steps, axis=0),
        "1",
        f"how many of the three orderings hold; median means {medians} px; "
        f"derivative the best in {np.sum(best == 0)} simulated runs, saddle point the "
        f"worst in {np.sum(worst == 2)}",
    )


@claim("c3_t38_close", needs=BOTH_PIXELS, evidence="rendered", readings=OF_TABLE)
def judge_close(results, options):
    """Means of derivative, active grid and OpenCV within a factor of 1.25."""
    without_saddle = ("derivative", "OpenCV", "active grid")
    means = Corners(results, options).statistic("mean", without_saddle)
    ratio = means.max(axis=0) / means.min(axis=0)
    return counterpart(
        ratio <= MAX_RATIO, ratio, "1", "largest of the three means over the smallest"
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

    curves = Corners(results, options).curve("derivative")
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
    near, far = (
        np.array([Corners(results, options, far).best_window(m) for m in METHODS[:3]])
        for far in (False, True)
    )
    smallest = np.abs(near - far).min(axis=0)
    best = "; ".join(
        f"{m} {', '.join(map(str, a))} and {', '.join(map(str, b))}"
        for m, a, b in zip(METHODS, near, far, strict=False)
    )
    return counterpart(
        smallest > 0,
        smallest,
        "px",
        "smallest difference over the three methods; best windows (px) near and "
        f"far by simulated run: {best}",
    )


@claim(
    "c3_active_no_params",
    needs=("exp_c3_active_no_params",),
    evidence="rendered",
    readings=("active_corner", "lens_left"),
)
def judge_no_params(results, options):
    """The same filters serve squares of half the apparent size; no other is better."""
    taken = Case(NAMES, options)
    path = list(FILTERS), taken["active_corner"], *taken["lens_left"], "mean"
    ran = results["exp_c3_active_no_params"]
    left = np.array([ran.select(case=case).column(*path) for case in ("near", "far")])
    near, far = left[:, list(FILTERS).index(AS_TEXT)]
    loss = np.max([near, far] / left.min(axis=1), axis=0)
    of_near, of_far = (
        ", ".join(f"{w} {m:.4f}" for w, m in zip(FILTERS, medians, strict=True))
        for medians in np.median(left, axis=2)
    )
    return counterpart(
        (far <= MAX_RATIO * near) & (loss <= MAX_LOSS),
        far / near,
        "1",
        "mean residual where squares look half as large over that near; with the "
        f"filters of 3.2.2 at most {loss.max():.3f} x the smallest of any filter; "
        f"median means (px) by filter: near {of_near}; far {of_far}",
    )


def radial_residuals(case, method):
    """Return signed radial residuals (n,) px of the outer quintile of each run."""

    def of_run(corners, vectors, middle):
        away = corners - middle
        radius = np.linalg.norm(away, axis=1)
        outer = radius >= np.nanquantile(radius, OUTER)
        return (vectors * away).sum(axis=1)[outer] / radius[outer]

    both = (case.arrays(method, name) for name in ("corners", "vectors"))
    return list(map(of_run, *both, case.trials.arrays("middle")))


@claim(
    "c3_residual_radial",
    needs=("table_3_8_corners",),
    evidence="rendered",
    readings=("active_corner",),
)
def judge_radial(results, options):
    """The mean radial residual of the outer quintile is not 0."""
    from scipy.stats import ttest_1samp

    case = Corners(results, options)
    found = [radial_residuals(case, method) for method in METHODS]
    p = np.array([[ttest_1samp(run, 0).pvalue for run in runs] for runs in found])
    worst = p.max(axis=0)
    means = ", ".join(
        f"{m} {np.median([x.mean() for x in runs]):+.4f} (p {np.median(of_method):.2g})"
        for m, runs, of_method in zip(METHODS, found, p, strict=True)
    )
    return counterpart(
        worst < SIGNIFICANCE,
        worst,
        "1",
        "largest p of the four methods; median over simulated runs of the mean "
        f"radial residual (px): {means}",
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
        f"{100 * np.median(before):.2f} %",
    )


@claim(
    "c3_pitch_vertical", needs=OF_LINES, evidence="rendered", readings=("line_points",)
)
def judge_pitch(results, options):
    """Verticals straight to 1 %, and converging as the pitch predicts to 1 deg."""
    lines = [x for ran in OF_LINES for x in lines_of(results[ran], options, view=VIEW)]
    gaps = np.array([spread_gap(x) for x in lines])
    bent = np.array([x.after[x.vertical].max() for x in lines])
    angles = [f"{x.pitch:.1f}: {spread_between(x, x.lean):.2f}" for x in lines]
    return counterpart(
        (gaps <= MAX_ANGLE_DEG) & (bent < MAX_BENT),
        gaps,
        "deg",
        "difference of the angle between the outermost verticals from the "
        f"predicted one; found, by pitch (deg): {', '.join(angles)}; "
        f"most bent vertical {100 * bent.max():.2f} % (simulated runs and pitches)",
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
    shares = trials.arrays(Case(NAMES, options)["static_grid"])
    failed = np.array([np.mean(one < 0.5) for one in shares])
    return counterpart(
        (errors <= MAX_SQUARES) & (failed >= FACETS_FAILED),
        errors,
        "squares",
        "median distance of remapped corners from their places; the static "
        f"grid fails on {100 * failed.min():.0f} % of the facets or more",
    )


@numbers("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def numbers_of_table(results):
    """Return means, SDs and best settings of Table 3.8."""
    case, of_runs = Corners(results), partial(Value.of_seeds, unit="px")
    return {
        **{
            f"t3_8_{name}_{which}": of_runs(found)
            for which in ("mean", "sd")
            for name, found in zip(PRINTED.values(), case.statistic(which), strict=True)
        },
        **{
            f"t3_8_{PRINTED[method]}_win": of_runs(case.best_window(method))
            for method in METHODS[:3]
        },
        "t3_8_saddle_blur": of_runs(case.best_blur()),
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
