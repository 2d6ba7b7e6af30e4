"""Results of this page read: values of the prose, figures, tables."""

from functools import partial
from itertools import product

import numpy as np

from chapters.ch04_central_generic.s2_pose.experiment import (
    ADDED_OUTLIERS,
    COLUMNS,
    DRAWS,
    ESTIMATORS,
    NAMES,
    OUTLIERS,
    PITCH_MM,
    PLANE_MM,
    RAYS,
    ROWS,
    STANDARD,
    TABULATED,
    lattice,
)
from chapters.shared.central import BENCH, CENTRE_MM, OPTIONS
from raxel.geometry import apply_homography, homography_dlt, on_plane, pose, transform
from raxel.show import Arrows, Labels, Points, Segments, Surface, framed
from repro.page import (
    INK,
    legend_below,
    look_of,
    new_figure,
    plot_estimates,
    series,
    value,
)
from repro.page.space import scene_figure
from repro.run import (
    Case,
    Check,
    Drawing,
    Measured,
    Table,
    columns,
    figure,
    median_interval,
    median_ratio,
    table,
)

# Errors, ratios and counts of section 4.2, and the numbers of the text.


# Bounds of the claims about Table 4.1.
MIN_RANSAC_GAIN, MIN_ORDER_RATIO, MAX_STANDARD_RATIO = 1.5, 1.0, 2.0
PRIMARY = {"domain": "px", "rays": RAYS[0], "unit": "length"}
MEASURES = ("rotation_deg", "translation_percent")
TABLE_MEASURES = ("rotation_deg", "translation_mm")
IN_WORDS = {
    "rotation_deg": "rotation",
    "translation_percent": "translation",
    "translation_mm": "translation",
}
QUOTED_NOISE_PX = 0.5
ANY_TRIPLES = "any three points"  # of `APART`


def trials_of(result, estimator, measure, noise, **condition):
    """Return errors (n,) of an estimator at one noise level, nan where it failed."""
    condition = PRIMARY | condition
    return result.column(f"{estimator}.{measure}", noise=noise, **condition)


def table_trials(result, estimator, measure, outliers=ADDED_OUTLIERS, noise=BENCH):
    """Return errors (n,) of the scenes or runs of Table 4.1, nan where it failed."""
    return result.select().column(f"errors.{noise}.{outliers}.{estimator}.{measure}")


class Scenes(Case):
    """Redrawn scenes of Table 4.1 in one interpretation, at one noise level."""

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(
            {"decoding_noise": OPTIONS, "standard_pose": STANDARD}, options
        )
        self.result, self.noise = results["table_4_1_redrawn"], noise

    def ratio(self, over, under, measure):
        """Return the ratio of median errors of two estimators, Estimate."""
        errors = [
            table_trials(self.result, name, measure, noise=self.noise)
            for name in (over, under)
        ]
        return median_ratio(*errors, paired=True)


def gains_of_ransac(scenes):
    """Return {measure: CGSP without over with RANSAC}, Estimates."""
    return {m: scenes.ratio("cgsp", "cgsp_ransac", m) for m in TABLE_MEASURES}


def ratios_of_neighbours(scenes):
    """Return {(measure, step): worse estimator over better}, Estimates."""
    standard = scenes["standard_pose"]
    steps = {
        "standard over CGSP + RANSAC": (standard, "cgsp_ransac"),
        "CGSP over standard": ("cgsp", standard),
    }
    return {
        (measure, step): scenes.ratio(*steps[step], measure)
        for measure, step in product(TABLE_MEASURES, steps)
    }


def standard_over_cgsp(scenes):
    """Return {translation: standard over CGSP, both with RANSAC}, an Estimate."""
    measure = "translation_mm"
    return {measure: scenes.ratio(scenes["standard_pose"], "cgsp_ransac", measure)}


def without_solution(result, kind):
    """Return (triples without a pose, all triples) of one kind."""
    lost = result.column(f"{kind}.without")
    return int(lost.sum()), DRAWS * len(lost)


def finite_of_four(result, plane):
    """Return (samples of four points with a finite pose, all samples)."""
    finite = result.column(f"finite.{plane}")
    return int(finite.sum()), DRAWS * len(finite)


def name_values(open_results):
    """Name the numbers that the text quotes: medians over trials."""
    rotations = partial(
        trials_of,
        open_results("fig_4_4_noise"),
        measure="rotation_deg",
        noise=QUOTED_NOISE_PX,
    )
    for name in ("three_points", "cgsp_ransac", "angular"):
        value(f"{name}_deg", np.median(rotations(name)))
    refining = median_ratio(rotations("three_points"), rotations("standard"))
    value("refining", refining.value)
    counts = open_results("exp_c4_3pt_no_solution")
    value("lost_any", 100 * np.divide(*without_solution(counts, ANY_TRIPLES)))


# Figs 4.3 and 4.4.


EXACT = 1e-9
BASE, FURTHER, PLANE = (series(k)["color"] for k in (0, 1, 2))
SHEET = "#9aa5b1"
SIGHT = (0.35, 0.95, -0.42)
UP = (0.0, 0.0, 1.0)
LABELS = {
    "rotation_deg": "Rotation error (deg)",
    "translation_percent": "Translation error (%)",
}


class DrawnPose:
    """The computed case of Fig. 4.3."""

    def __init__(self, result):
        for name in ("there", "rays", "normal", "image", "true", "found"):
            setattr(self, name, result.arrays(name)[0])

    def gaps(self):
        """Return relative errors of the drawn case.

        Distance of image points from ray and plane, residual of their homography,
        and error of the pose that follows.
        """
        sight = self.image - CENTRE_MM
        across = np.linalg.norm(np.cross(sight, self.rays), axis=1)
        height = np.abs(sight @ self.normal - PLANE_MM)
        axes = np.linalg.svd(self.normal[None])[2][1:]
        flat = sight @ axes.T
        H = homography_dlt(lattice(), flat)
        return (
            max(across.max(), height.max()) / PLANE_MM,
            np.abs(apply_homography(H, lattice()) - flat).max() / PLANE_MM,
            np.abs(self.found - self.true).max() / PLANE_MM,
        )


def sheet_of(T, margin_mm):
    """Return corners (2, 2, 3) of a grid's sheet at a pose."""
    x, y = (PITCH_MM * (n - 1) / 2 + margin_mm for n in (COLUMNS, ROWS))
    flat = np.array([[[-x, -y, 0], [x, -y, 0]], [[-x, y, 0], [x, y, 0]]])
    return transform(T, flat.reshape(-1, 3)).reshape(2, 2, 3)


def plane_sheet(case):
    """Return corners (2, 2, 3) of a piece of the synthetic plane."""
    middle = CENTRE_MM + PLANE_MM * case.normal
    across = np.cross(case.normal, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    T = pose(
        np.column_stack([across, np.cross(case.normal, across), case.normal]), middle
    )
    x, y = 110.0, 90.0
    flat = np.array([[-x, -y, 0], [x, -y, 0], [-x, y, 0], [x, y, 0]])
    return transform(T, flat).reshape(2, 2, 3)


def parts_of(case):
    """Return what is drawn: camera, rays, two grids and the plane between."""
    centre = np.broadcast_to(CENTRE_MM, case.there.shape)
    base = on_plane(lattice())
    origin = case.true[None, :3, 3]
    plane = plane_sheet(case)
    return [
        Segments(centre, case.there, SHEET, "calibrated rays", 1.0),
        Points(CENTRE_MM[None], INK, "camera centre", 11.0),
        Labels(CENTRE_MM[None] + [0, 0, 25], ["centre C"], INK),
        Surface(sheet_of(np.eye(4), 30.0), BASE, 0.3, "base grid"),
        Points(base, BASE, "points X", 6.0),
        Labels(base[:1], ["base grid, X"], BASE),
        Surface(sheet_of(case.true, 30.0), FURTHER, 0.3, "further grid"),
        Points(case.there, FURTHER, "points X'", 6.0),
        Labels(case.there[-1:], ["further grid, X'"], FURTHER),
        Surface(plane, PLANE, 0.35, "synthetic plane"),
        Points(case.image, PLANE, "image x'", 6.0),
        Labels(plane[0, :1], ["synthetic plane, x'"], PLANE),
        Arrows(np.zeros((1, 3)), origin, INK, "pose T", 3.0),
        Labels(origin / 2, ["T"], INK),
    ]


@figure("fig_4_3", needs=("fig_4_3_case",), evidence="analytic", scene=True)
def fig_4_3(results):
    """Draw the further grid's image on the synthetic plane, in 3-D."""
    case = DrawnPose(results["fig_4_3_case"])
    scene = framed(
        parts_of(case),
        SIGHT,
        up=UP,
        note="Rays from the camera centre intersect the further grid. Their "
        "intersections with the synthetic plane are a pinhole image of it.",
    )
    ray, bent, off = case.gaps()
    rows = [
        (name, *point) for name in ("there", "image") for point in getattr(case, name)
    ]
    return Drawing(
        scene_figure(scene, height_in=4.6),
        columns(("points", "x_mm", "y_mm", "z_mm"), rows),
        "CGSP's linear pose estimation in a computed case. The rays that see a "
        "further grid (orange) intersect a chosen synthetic plane (green) in a "
        "pinhole image of the grid. The pose T maps the base grid (blue) to the "
        "further one.",
        Check(
            max(ray, bent, off) < EXACT,
            "image points lie on their rays and on the plane, are a "
            f"homography of the grid, and give its pose: to {ray:.0e}, "
            f"{bent:.0e} and {off:.0e} of the plane's distance",
        ),
        scene,
    )


@figure("fig_4_4", needs=("fig_4_4_noise",), evidence="synthetic")
def fig_4_4(results):
    """Draw errors of rotation and translation against the noise."""
    result = results["fig_4_4_noise"]
    levels = result.levels("noise")
    drawn, axes = new_figure(1, 2, height_in=3.9)
    rows = []
    for panel, measure in zip(axes, MEASURES, strict=True):
        for estimator in ESTIMATORS:
            found = [
                median_interval(trials_of(result, estimator, measure, level))
                for level in levels
            ]
            rows += plot_estimates(
                panel,
                levels,
                found,
                (measure, estimator),
                look=look_of(NAMES[estimator]),
                label=NAMES[estimator],
            )
        panel.set(
            xscale="log", yscale="log", xlabel="Noise SD (px)", ylabel=LABELS[measure]
        )
        panel.set_xticks(levels, [f"{level:g}" for level in levels])
        panel.minorticks_off()
    legend_below(drawn, axes[0], ncols=3)
    return Drawing(
        drawn,
        columns(("measure", "estimator", "noise_px", "median", "low", "high"), rows),
        "Rotation and translation errors of a further grid's pose against image "
        "noise: medians over trials with 95 % intervals. The standard pose is plotted "
        "from three points alone and refined on all inliers (4.2.2). Angular "
        "refinement is not in the thesis.",
    )


# Table 4.1, from rendered images and redrawn scenes.


PRINTED = ("standard", "cgsp", "cgsp_ransac")
BOTH = ("table_4_1_rendered", "table_4_1_redrawn")
LEVELS = {"bench": "thesis-matched", "laboratory": "low-noise"}


@table("table_4_1", needs=("table_4_1_rendered",), evidence="rendered")
def table_4_1(results):
    """Tabulate pose errors of the three estimators, from rendered images."""
    result = results["table_4_1_rendered"]
    units = ("Rotation error (°)", "Translation error (mm)")
    rows = [
        (unit, *(float(np.median(table_trials(result, e, measure))) for e in PRINTED))
        for unit, measure in zip(units, TABLE_MEASURES, strict=True)
    ]
    estimators = ("Standard + RANSAC", "CGSP", "CGSP + RANSAC")
    printed = {
        head: [f"t4_1_{short}_rot", f"t4_1_{short}_trans"]
        for head, short in zip(
            estimators, ("std_ransac", "cgsp", "cgsp_ransac"), strict=True
        )
    }
    return Table(
        columns(("Error", *estimators), rows),
        "Errors of the relative pose of two active grids, decoded from rendered images "
        f"at the thesis-matched level, with {ADDED_OUTLIERS} of outliers added: "
        f"medians over {len(result.conditions)} runs, against a laser scan. The "
        "standard pose is refined on its inliers.",
        printed=printed,
    )


@table("ext_table_4_1", needs=BOTH, evidence="rendered")
def all_of_table_4_1(results):
    """Tabulate every estimator, with and without outliers, rendered and redrawn."""
    rendered, redrawn = (results[name] for name in BOTH)
    rows = []
    for noise, outliers, name in product(TABULATED, OUTLIERS, ESTIMATORS):
        cells = []
        for measure in TABLE_MEASURES:
            of_seeds, of_scenes = (
                table_trials(result, name, measure, outliers, noise)
                for result in (rendered, redrawn)
            )
            cells += [float(np.median(of_seeds)), Measured.median_or_none(of_scenes)]
        rows.append((LEVELS[noise], outliers, NAMES[name], *cells))
    return Table(
        columns(
            (
                "Noise level",
                "Outliers",
                "Estimator",
                "Rotation, rendered (°)",
                "Rotation, redrawn (°)",
                "Translation, rendered (mm)",
                "Translation, redrawn (mm)",
            ),
            rows,
        ),
        "Errors of the relative pose of two active grids, by estimator: medians over "
        f"{len(rendered.conditions)} rendered runs, and over "
        f"{redrawn.trials_per_condition} redrawn scenes with 95 % intervals, at both "
        "noise levels.",
    )
