"""The claims of section 3.3.4, seed by seed, and its regenerated numbers."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import (
    CORNERS,
    FACETS,
    FAR,
    HALF_PITCH,
    LINES,
    METHODS,
    OF_CORNERS,
    OF_LINES,
    QUESTIONS,
    SHARE_OF_SEEDS,
    VECTOR_SCALE,
    Corners,
    lines_of,
    options_of,
    percent,
    seeds_of,
    spread_between,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import rig_of
from raxel.features.localise.subpix import TERMINATION_PX
from repro.judge.statistics import median_interval, proportion
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

SENSOR_MM = 23.6  # width of the camera's sensor
MOST_RATIO = 1.25
MOST_SPEARMAN = -0.8
MOST_BENT, LEAST_BENT = 0.01, 0.05
MOST_ANGLE_DEG = 1.0
MOST_SQUARES, FACETS_FAILED = 0.1, 0.5
SIGNIFICANCE = 0.01
OUTER = 0.8  # quantile of the radius that begins the outer quintile
VIEW, POINTS, WHICH = "room_view", "line_points", "lines_of_a_picture"


def decided(holds, measured, reading, unit, reason):
    """The Reading of a counterpart: true in at least 90 % of the seeds, or not.

    holds: (seeds,) bool; measured: (seeds,) what was measured.
    """
    share = proportion(np.array(holds, float))
    middle = median_interval(np.array(measured, float))
    told = (
        f"{reason}; true in {sum(holds)} of {len(holds)} seeds "
        f"({share.low:.2f} to {share.high:.2f})"
    )
    good = share.value >= SHARE_OF_SEEDS
    return Reading(
        "reproduced" if good else "differs",
        middle.value,
        reading=reading,
        interval=(float(np.min(measured)), float(np.max(measured))),
        unit=unit,
        reason=told,
    )


OF_TABLE = (
    "opencv_window", "active_corner", "lens_left", "undistorted_bits", "edge_blur",
)  # fmt: skip


@claim("c3_t38_order", needs=("table_3_8_corners",), evidence="rendered")
def judge_order(results):
    """Derivative below active grid below OpenCV below saddle point."""
    readings = []
    for options in options_of(OF_TABLE):
        case = Corners(results[CORNERS], options)
        mean = {m: case.statistic(m, "mean") for m in METHODS}
        steps = (
            mean["derivative"] < mean["active grid"],
            mean["active grid"] < mean["OpenCV"],
            mean["OpenCV"] < mean["saddle point"],
        )
        rest = [m for m in METHODS if m != "derivative"]
        best = np.all([mean["derivative"] < mean[m] for m in rest], axis=0)
        others = [m for m in METHODS if m != "saddle point"]
        worst = np.all([mean["saddle point"] > mean[m] for m in others], axis=0)
        told = ", ".join(f"{m} {np.median(mean[m]):.4f}" for m in METHODS)
        readings.append(
            decided(
                list(np.all(steps, axis=0)),
                np.sum(steps, axis=0),
                options,
                "1",
                f"how many of the three orderings hold; median means {told} px; "
                f"derivative the best in {best.sum()} seeds, saddle point the worst "
                f"in {worst.sum()}",
            )
        )
    return readings


@claim("c3_t38_close", needs=("table_3_8_corners",), evidence="rendered")
def judge_close(results):
    """Means of derivative, active grid and OpenCV within a factor of 1.25."""
    readings = []
    for options in options_of(OF_TABLE):
        case = Corners(results[CORNERS], options)
        means = np.array(
            [case.statistic(m, "mean") for m in METHODS if "saddle" not in m]
        )
        ratio = means.max(axis=0) / means.min(axis=0)
        readings.append(
            decided(
                list(ratio <= MOST_RATIO),
                ratio,
                options,
                "1",
                "largest of the three means over the least",
            )
        )
    return readings


@claim("c3_deriv_window", needs=("table_3_8_corners",), evidence="rendered")
def judge_window(results):
    """Spearman of window and mean residual at most -0.8."""
    from scipy.stats import spearmanr

    readings = []
    for options in options_of(("undistorted_bits", "edge_blur")):
        case = Corners(results[CORNERS], options)
        curves = case.curve("derivative")
        ranks = [float(spearmanr(*curve).statistic) for curve in curves]
        last = ", ".join(f"{w[-1]:g}" for w, _ in curves)
        readings.append(
            decided(
                [rank <= MOST_SPEARMAN for rank in ranks],
                ranks,
                options,
                "1",
                f"Spearman over windows of 5 px to those that still fit: {last} px",
            )
        )
    return readings


@claim("c3_params_square", needs=OF_CORNERS, evidence="rendered")
def judge_square(results):
    """The best window differs where squares look half as large."""
    readings = []
    for options in options_of(("opencv_window",)):
        near = Corners(results[CORNERS], options)
        far = FarCorners(results[FAR], options)
        apart, told = [], []
        for method in METHODS[:3]:
            one, two = near.best_window(method), far.best_window(method)
            apart.append(np.abs(one - two))
            told.append(f"{method} {listed(one)} and {listed(two)}")
        least = np.min(apart, axis=0)
        readings.append(
            decided(
                list(least > 0),
                least,
                options,
                "px",
                "least difference over the three methods; best windows (px) near and "
                f"far by seed: {'; '.join(told)}",
            )
        )
    return readings


class FarCorners(Corners):
    """Table 3.8 at twice the distance."""

    @property
    def case(self):
        """The trial's name of the pictures."""
        return "far"


def listed(values):
    """Numbers in a row."""
    return ", ".join(f"{v:g}" for v in values)


def radial_residuals(case, method, middle):
    """Signed radial residuals (n,) px of the outer quintile of each seed."""
    out = []
    for corners, vectors, centre in zip(
        case.arrays(method, "corners"),
        case.arrays(method, "vectors"),
        middle,
        strict=True,
    ):
        away = corners - centre
        radius = np.linalg.norm(away, axis=1)
        known = np.isfinite(radius)
        outer = known & (radius >= np.quantile(radius[known], OUTER))
        out.append((vectors * away).sum(axis=1)[outer] / radius[outer])
    return out


@claim("c3_residual_radial", needs=("table_3_8_corners",), evidence="rendered")
def judge_radial(results):
    """The mean radial residual of the outer quintile is not 0."""
    from scipy.stats import ttest_1samp

    readings = []
    for options in options_of(("active_corner",)):
        case = Corners(results[CORNERS], options)
        middle = [
            case.ran.arrays("middle", case=case.case, seed=s)[0] for s in case.seeds
        ]
        worst, told = np.zeros(len(middle)), []
        for method in METHODS:
            found = radial_residuals(case, method, middle)
            p = [float(ttest_1samp(one, 0).pvalue) for one in found]
            worst = np.maximum(worst, p)
            told.append(
                f"{method} {np.median([x.mean() for x in found]):+.4f} "
                f"(p {np.median(p):.2g})"
            )
        readings.append(
            decided(
                list(worst < SIGNIFICANCE),
                worst,
                options,
                "1",
                "largest p of the four methods; median over seeds of the mean radial "
                f"residual (px): {', '.join(told)}",
            )
        )
    return readings


@claim("c3_active_undistort", needs=("fig_3_17_lines",), evidence="rendered")
def judge_undistort(results):
    """Lines bent by at least 5 % before, and by at most 1 % after."""
    ran, readings = results[LINES], []
    for options in options_of((VIEW, POINTS, WHICH)):
        measure = np.max if options[WHICH] == QUESTIONS[WHICH][0] else np.median
        before, after = [], []
        for seed in seeds_of(ran, view=options[VIEW]):
            lines = lines_of(ran, options[POINTS], seed=seed, view=options[VIEW])
            before.append(measure(lines.before))
            after.append(measure(lines.after))
        holds = [
            a <= MOST_BENT and b >= LEAST_BENT
            for b, a in zip(before, after, strict=True)
        ]
        readings.append(
            decided(
                holds,
                [percent(a) for a in after],
                options,
                "%",
                "largest distance from the line over its length, after; before it is "
                f"{percent(np.median(before)):.2f} %",
            )
        )
    return readings


@claim("c3_pitch_vertical", needs=OF_LINES, evidence="rendered")
def judge_pitch(results):
    """Verticals straight to 1 %, and converging as the pitch says to 1 deg."""
    readings = []
    for options in options_of((POINTS,)):
        gaps, bent, angles, holds = [], [], [], []
        for ran in (results[LINES], results[HALF_PITCH]):
            for seed in seeds_of(ran, view=QUESTIONS[VIEW][0]):
                lines = lines_of(
                    ran, options[POINTS], seed=seed, view=QUESTIONS[VIEW][0]
                )
                found = spread_between(lines, lines.lean)
                gaps.append(abs(found - spread_between(lines, lines.predicted)))
                bent.append(lines.after[lines.vertical].max())
                angles.append(f"{lines.pitch:.1f}: {found:.2f}")
                holds.append(gaps[-1] <= MOST_ANGLE_DEG and bent[-1] < MOST_BENT)
        readings.append(
            decided(
                holds,
                gaps,
                options,
                "deg",
                "difference of the angle between the outermost verticals from the "
                f"predicted one; found, by pitch (deg): {', '.join(angles)}; "
                f"most bent vertical {percent(max(bent)):.2f} % (seeds and pitches)",
            )
        )
    return readings


@claim("c3_disco", needs=("fig_3_18_facets",), evidence="rendered")
def judge_disco(results):
    """Remapped corners within 0.1 square, where a static grid fails on half."""
    ran, readings = results[FACETS], []
    for options in options_of(("static_grid",)):
        whole = options["static_grid"] == QUESTIONS["static_grid"][0]
        name = "across" if whole else "within"
        errors, failed = [], []
        for seed in seeds_of(ran):
            errors.append(np.nanmedian(ran.arrays("corner_squares", seed=seed)[0]))
            right = ran.arrays(name, seed=seed)[0]
            failed.append(float(np.mean(right < 0.5)))
        holds = [
            e <= MOST_SQUARES and f >= FACETS_FAILED
            for e, f in zip(errors, failed, strict=True)
        ]
        readings.append(
            decided(
                holds,
                errors,
                options,
                "squares",
                "median distance of remapped corners from their places; the static "
                f"grid fails on {percent(min(failed)):.0f} % of the facets or more",
            )
        )
    return readings


def of_seeds(values, unit):
    """A Value of one number by seed: median and range."""
    middle = float(np.median(values))
    return Value(middle, (float(np.min(values)), float(np.max(values))), unit)


@numbers("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def numbers_of_table(results):
    """Means, SDs and best settings of Table 3.8."""
    case = Corners(results[CORNERS], {})
    short = dict(
        zip(METHODS, ("derivative", "opencv", "saddle", "active"), strict=True)
    )
    found = {}
    for method, name in short.items():
        for which in ("mean", "sd"):
            found[f"t3_8_{name}_{which}"] = of_seeds(
                case.statistic(method, which), "px"
            )
        if method != "active grid":
            found[f"t3_8_{name}_win"] = of_seeds(case.best_window(method), "px")
    found["t3_8_saddle_blur"] = of_seeds(case.best_blur(), "px")
    found["t3_8_term"] = Value(TERMINATION_PX, unit="px")
    return found


@numbers("fig_3_16", needs=(), evidence="rendered")
def numbers_of_vectors(results):
    """How much longer vectors are drawn than they are."""
    return {"fig3_16_scale": Value(VECTOR_SCALE)}


@numbers("fig_3_17", needs=("fig_3_17_lines",), evidence="rendered")
def numbers_of_fisheye(results):
    """The focal length of the rig, from its focal length in px and its pixels."""
    rig = rig_of(results[LINES].conditions[0]["rig"])
    pixel_mm = SENSOR_MM / rig.camera.width
    return {"fig3_17_f": Value(round(rig.camera.focal_px * pixel_mm, 1), unit="mm")}
