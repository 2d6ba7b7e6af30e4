"""Figs. 5.14 to 5.19: the circle and the face in the mirror, and corrected."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    SCALE,
    STAGES,
    WAYS,
    CircleRuns,
    PictureRuns,
)
from chapters.shared.mirror_bench import LEVEL
from raxel.multiview.fits.circles import circle_distances
from raxel.multiview.fits.conics import algebraic_conic, conic_distances, value
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

RED = "#d62728"
EXACT = 1e-9


LOOKS = {"true": look_of("true mirror"), "published": series(0)}
CORRECTED_BY = {"published": "the calibrated mirror", "true": "the true mirror"}


def two_panels(results, stage):
    """The circle at one stage: in the image, and on the board after correction."""
    runs = PictureRuns(results, bench=LEVEL)
    way, run = runs.drawn()
    picture = runs.picture(stage, run)
    line, points, left, centre = (
        runs.array(way, stage, name, run)
        for name in ("line_px", "points_mm", "residuals_mm", "centre_mm")
    )
    radius = runs.of(stage, "radius_mm", way)[run]
    drawn, (raw, board) = new_figure(1, 2, height_in=3.4)
    conic = algebraic_conic(line)
    off, _ = conic_distances(conic, line)
    raw.imshow(picture, cmap="gray")
    rows, across = picture.shape
    u, v = np.meshgrid(np.arange(across), np.arange(rows))
    q = value(conic, np.column_stack([u.ravel(), v.ravel()]).astype(float))
    raw.contour(u, v, q.reshape(rows, across), [0.0], colors=RED, linewidths=0.9)
    raw.set(xticks=[], yticks=[], title="(a) image and best conic")
    outward = points - centre
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    feet = points - left[:, None] * outward
    ends = feet + SCALE * left[:, None] * outward
    angle = np.linspace(0, 2 * np.pi, 361)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    circle = centre + radius * around
    board.plot(*circle.T, color=INK, lw=0.8, marker="")
    look = {"color": series(0)["color"], "lw": 0.9, "ls": "-", "marker": ""}
    board.plot(*np.stack([feet, ends], axis=-1).transpose(1, 2, 0), **look)
    board.set_aspect("equal")
    board.invert_yaxis()
    board.set(xlabel="x on the board (mm)", ylabel="y on the board (mm)")
    board.set_title(f"(b) corrected, residuals × {SCALE}")
    ring = np.array([[*centre, radius]])
    gap = float(np.abs(circle_distances(ring, points)[0] - left).max())
    return Drawing(
        drawn,
        columns(
            ("u_px", "v_px", "off_conic_px", "x_mm", "y_mm", "residual_mm"),
            [
                (*p, o, *x, r)
                for p, o, x, r in zip(line, off, points, left, strict=True)
            ],
        ),
        f"The circle at stage {stage}: (a) rendered image of {across} x {rows} px with "
        "the conic of least algebraic error, at a mean distance of "
        f"{np.abs(off).mean():.2f} px; (b) after correction by {CORRECTED_BY[way]}, "
        f"residuals from the best circle, magnified {SCALE} times. Their mean is "
        f"{np.abs(left).mean():.2f} mm, the radius {radius:.2f} mm. One run, geometry "
        "A, second solved level.",
        Check(
            gap < EXACT,
            f"drawn residuals equal the distances from the circle, to {gap:.0e} mm",
        ),
    )


@figure("fig_5_14", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_14(results):
    """The circle at stage 0."""
    return two_panels(results, 0)


@figure("fig_5_15", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_15(results):
    """The circle at stage 1."""
    return two_panels(results, 1)


@figure("fig_5_16", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_16(results):
    """The circle at stage 2."""
    return two_panels(results, 2)


@figure("fig_5_17", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_17(results):
    """The circle at stage 3."""
    return two_panels(results, 3)


@figure("fig_5_18", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_18(results):
    """The image of stage 3, rectified to the board."""
    runs = PictureRuns(results, bench=LEVEL)
    way, run = runs.drawn()
    picture = runs.corrected(run)
    drawn, axes = new_figure(height_in=4.4)
    axes.imshow(picture, cmap="gray")
    axes.set(xticks=[], yticks=[])
    rows, across = picture.shape
    return Drawing(
        drawn,
        columns(("rows", "columns", "mean_grey"), [(rows, across, picture.mean())]),
        "The image of Fig. 5.17 rectified to the board, in the pose estimated with "
        f"{CORRECTED_BY[way]}. Black: outside the mirror.",
    )


@figure("fig_5_19", needs=("fig_5_19_picture",), evidence="rendered")
def fig_5_19(results):
    """The bust in the mirror, and corrected to a nearly perspective view."""
    result = results["fig_5_19_picture"]
    drawn, axes = new_figure(1, 2, height_in=3.8)
    for panel, name, title in zip(
        axes, ("picture", "corrected"), ("(a) image", "(b) corrected"), strict=True
    ):
        (picture,) = result.arrays(name)
        panel.imshow(picture, cmap="gray")
        panel.set(xticks=[], yticks=[], title=title)
    (ideal,) = result.arrays("ideal_px")
    way = "published" if result.column("calibrated")[0] else "true"
    axes[1].plot(*ideal.T, ls="", marker="+", color=RED, ms=4)
    return Drawing(
        drawn,
        columns(("ideal_u_px", "ideal_v_px"), [tuple(p) for p in ideal]),
        "A bust in low relief, in place of the thesis's face, in a mirror pushed by "
        f"12 mm: (a) camera image, (b) corrected by {CORRECTED_BY[way]} as a plane. "
        "Crosses: landmarks in the desired pinhole view.",
    )


@figure("ext_circle_blind", needs=("table_5_6_runs",), evidence="rendered")
def ext_circle_blind(results):
    """Radius errors and ray errors over the stages."""
    drawn, panels = new_figure(1, 2, height_in=3.3)
    runs, rows = CircleRuns(results, bench=LEVEL), []
    for way in WAYS:
        for panel, name, values in (
            (panels[0], "radius_percent", np.abs(radius_errors(runs, way))),
            (panels[1], "angle_deg", angles_of(runs, way)),
        ):
            came = {
                stage: median_interval(trials[np.isfinite(trials)])
                for stage, trials in zip(STAGES, values, strict=True)
                if np.isfinite(trials).any()
            }
            if not came:
                continue
            look = {"look": LOOKS[way], "label": WAYS[way]}
            whose = (WAYS[way], name)
            rows += plot_estimates(
                panel, list(came), list(came.values()), whose, **look
            )
    for panel, words in zip(
        panels, ("Radius error (%)", "Mean ray error (°)"), strict=True
    ):
        panel.set(xlabel="Stage", ylabel=words, xticks=STAGES, ylim=(0, None))
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(("mirror", "measure", "stage", "value", "low", "high"), rows),
        "Error of the circle's radius (left), and mean angle between calibrated and "
        "true rays over the mirror (right), by stage. Medians over the completed runs "
        "with 95 % intervals; geometry A, second level. The rays of the true mirror "
        "are exact; its radius has the errors of corners and edges.",
    )


def angles_of(runs, way):
    """Angles (stages, seeds) to the true rays; zero for the true mirror."""
    if way == "true":
        return np.zeros((len(STAGES), runs.seeds))
    return runs.at("angle_deg", way)
