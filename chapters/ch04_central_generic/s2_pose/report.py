"""Results of this page read: values of the prose, figures, tables."""

from itertools import product
from types import SimpleNamespace

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
    TABULATED,
    lattice,
)
from chapters.shared.central import CENTRE_MM, LEVEL_NAMES, MATCHED
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

# Errors of section 4.2, and the numbers of the text.


PRIMARY = {"domain": "px", "rays": RAYS[0], "unit": "length"}
MEASURES = {
    "rotation_deg": "Rotation error (deg)",
    "translation_percent": "Translation error (%)",
}
TABLE_MEASURES = ("rotation_deg", "translation_mm")


def table_trials(result, estimator, measure, outliers=ADDED_OUTLIERS, noise=MATCHED):
    """Return errors (..., n) of the scenes or runs of Table 4.1, nan if it failed."""
    return result.select().column("errors", noise, outliers, estimator, measure)


def name_values(open_results):
    """Name the numbers that the text quotes: medians over trials."""
    trials = open_results("fig_4_4_noise").one(noise=0.5, **PRIMARY)
    names = ("three_points", "cgsp_ransac", "angular")
    for name, found in zip(names, trials.column(names, "rotation_deg"), strict=True):
        value(f"{name}_deg", np.median(found))
    errors = trials.column(("three_points", "standard"), "rotation_deg")
    value("refining", median_ratio(*errors).value)
    missing = open_results("exp_c4_3pt_no_solution").column(
        "any three points", "without"
    )
    value("lost_any", 100 * missing.mean() / DRAWS)


# Figs 4.3 and 4.4.


BASE, FURTHER, PLANE = (series(k)["color"] for k in (0, 1, 2))
SHEET = "#9aa5b1"
SIGHT = (0.35, 0.95, -0.42)
HALF_MM = PITCH_MM * (COLUMNS - 1) / 2 + 30.0, PITCH_MM * (ROWS - 1) / 2 + 30.0


def gaps(case):
    """Return relative errors of the drawn case.

    Distance of image points from ray and plane, residual of their homography, and
    error of the pose that follows.
    """
    sight = case.image - CENTRE_MM
    across = np.linalg.norm(np.cross(sight, case.rays), axis=1)
    height = np.abs(sight @ case.normal - PLANE_MM)
    flat = sight @ np.linalg.svd(case.normal[None])[2][1:].T
    H = homography_dlt(lattice(), flat)
    return (
        max(across.max(), height.max()) / PLANE_MM,
        np.abs(apply_homography(H, lattice()) - flat).max() / PLANE_MM,
        np.abs(case.found - case.true).max() / PLANE_MM,
    )


def sheet_at(T, x, y):
    """Return corners (2, 2, 3) of a sheet at a pose; x, y: half its size."""
    flat = np.array([[-x, -y, 0], [x, -y, 0], [-x, y, 0], [x, y, 0]])
    return transform(T, flat).reshape(2, 2, 3)


def parts_of(case):
    """Return what is drawn: camera, rays, two grids and the plane between."""
    centre = np.broadcast_to(CENTRE_MM, case.there.shape)
    base, origin = on_plane(lattice()), case.true[None, :3, 3]
    across = np.cross(case.normal, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    R = np.column_stack([across, np.cross(case.normal, across), case.normal])
    plane = sheet_at(pose(R, CENTRE_MM + PLANE_MM * case.normal), 110.0, 90.0)
    return [
        Segments(centre, case.there, SHEET, "calibrated rays", 1.0),
        Points(CENTRE_MM[None], INK, "camera centre", 11.0),
        Labels(CENTRE_MM[None] + [0, 0, 25], ["centre C"], INK),
        Surface(sheet_at(np.eye(4), *HALF_MM), BASE, 0.3, "base grid"),
        Points(base, BASE, "points X", 6.0),
        Labels(base[:1], ["base grid, X"], BASE),
        Surface(sheet_at(case.true, *HALF_MM), FURTHER, 0.3, "further grid"),
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
    names = ("there", "rays", "normal", "image", "true", "found")
    case = SimpleNamespace(
        **{name: results["fig_4_3_case"].arrays(name)[0] for name in names}
    )
    scene = framed(
        parts_of(case),
        SIGHT,
        up=(0.0, 0.0, 1.0),
        note="Rays from the camera centre intersect the further grid. Their "
        "intersections with the synthetic plane are a pinhole image of it.",
    )
    ray, bent, off = gaps(case)
    rows = [("there", *point) for point in case.there]
    rows += [("image", *point) for point in case.image]
    return Drawing(
        scene_figure(scene, height_in=4.6),
        columns(("points", "x_mm", "y_mm", "z_mm"), rows),
        "CGSP's linear pose estimation in a computed case. The rays that see a "
        "further grid (orange) intersect a chosen synthetic plane (green) in a "
        "pinhole image of the grid. The pose T maps the base grid (blue) to the "
        "further one.",
        Check(
            max(ray, bent, off) < 1e-9,
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
    for panel, (measure, label) in zip(axes, MEASURES.items(), strict=True):
        for estimator in ESTIMATORS:
            found = [
                median_interval(
                    result.column(estimator, measure, noise=level, **PRIMARY)
                )
                for level in levels
            ]
            name = NAMES[estimator]
            look = {"look": look_of(name), "label": name}
            rows += plot_estimates(panel, levels, found, (measure, estimator), **look)
        panel.set(xscale="log", yscale="log", xlabel="Noise SD (px)", ylabel=label)
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


# Estimators in the ids of the registry.
PRINTED = {"std_ransac": "standard", "cgsp": "cgsp", "cgsp_ransac": "cgsp_ransac"}
BOTH = ("table_4_1_rendered", "table_4_1_redrawn")


@table("table_4_1", needs=("table_4_1_rendered",), evidence="rendered")
def table_4_1(results):
    """Tabulate pose errors of the three estimators, from rendered images."""
    result = results["table_4_1_rendered"]
    errors = table_trials(result, tuple(PRINTED.values()), TABLE_MEASURES)
    rotation, translation = np.median(errors, axis=-1).T.tolist()
    rows = [("Rotation error (°)", *rotation), ("Translation error (mm)", *translation)]
    estimators = ("Standard + RANSAC", "CGSP", "CGSP + RANSAC")
    printed = {
        head: [f"t4_1_{short}_rot", f"t4_1_{short}_trans"]
        for head, short in zip(estimators, PRINTED, strict=True)
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
        choice = name, TABLE_MEASURES, outliers, noise
        middles = np.median(table_trials(rendered, *choice), axis=-1)
        turn, shift = map(Measured.median_or_none, table_trials(redrawn, *choice))
        cells = float(middles[0]), turn, float(middles[1]), shift
        rows.append((LEVEL_NAMES[noise], outliers, NAMES[name], *cells))
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
