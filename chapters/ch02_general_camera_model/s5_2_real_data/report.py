"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.experiment import (
    STAGE_IMAGES,
    STEP_MM,
)
from chapters.shared.general import (
    FACADE_ZOOM,
    FOVS_DEG,
    OF_SEEDS,
    STAGE_ZOOM,
    ZOOMS,
    ZoomCase,
)
from chapters.shared.methods import METHODS, NAMES
from repro.page import INK, look_of, new_figure, value
from repro.run import (
    SIGNIFICANCE,
    Check,
    Drawing,
    Measured,
    Table,
    bootstrap,
    columns,
    figure,
    holm,
    table,
    trend,
    with_worst,
)

# Numbers of Table 2.2 and settings of section 2.5.2.


FIELD_SCALE, COARSE_SCALE = 50, 10
STEP_SCALE = 20
RMS_PX = ("calibration", "corrected", "rms_px")
STEP_SCATTER = ("stage", "grid", "deviation_mm")


def typical(trials):
    """Return the median over trials; a failed one counts as the worst."""
    return float(np.median(with_worst(trials)))


def ratio_of_sets(case):
    """Return the largest over the smallest generic residual of the three sets."""
    medians = [typical(case.residual("generic", zoom)) for zoom in ZOOMS]
    return max(medians) / min(medians)


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    primary, smooth = (
        ZoomCase(results, options) for options in ({}, {"interpolation": "smooth"})
    )
    shares = primary.column("generic_as_printed", STAGE_ZOOM, "share_of_image")
    value("ratio_as_found", ratio_of_sets(primary))
    value("ratio_smooth", ratio_of_sets(smooth))
    value("image_share_3", 100 * np.nanmedian(shares))
    for method in ("parametric", "generic"):
        scatter = primary.column(method, STAGE_ZOOM, *STEP_SCATTER)
        value(f"scatter_{method}", typical(scatter))


def distortion_level(angle_deg: float) -> float:
    """Return |r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def log_slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return slopes (...) of least-squares lines: log y (..., n) over x (n,)."""
    centred = x - x.mean()
    return np.sum(np.log(y) * centred, axis=-1) / np.sum(centred**2)


def swept_slopes(case):
    """Return the slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(
            levels,
            [case.trials(method, "mean_px", fov_deg=f) for f in FOVS_DEG],
            log_slope,
        )
        for method in ("parametric", "generic")
    ]


def rendered_slopes(case):
    """Return the slopes of both methods over the three sets, with intervals."""
    levels = np.array(
        [np.median(case.column("distortion_level", zoom)) for zoom in ZOOMS]
    )

    def slope(*trials):
        medians = np.stack([np.median(t, axis=-1) for t in trials], axis=-1)
        return log_slope(levels, medians)

    return [
        bootstrap(slope, *(with_worst(case.residual(name, zoom)) for zoom in ZOOMS))
        for name in ("parametric", "generic")
    ]


# Figures of section 2.5.2, drawn from its simulated runs.


@figure("fig_2_4", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_4(results):
    """Draw one image of each of the three sets, as the detector received it."""
    rendered = results["table_2_2_rendered"]
    drawn, axes = new_figure(1, 3, height_in=2.3)
    rows = []
    for panel, zoom in zip(axes, ZOOMS, strict=True):
        image = rendered.arrays("sample", zoom=zoom)[0]
        panel.imshow(image, cmap="gray", vmin=0, vmax=255)
        panel.set_title(f"Image set {zoom}")
        panel.set_axis_off()
        found = rendered.column("found", "calibration", zoom=zoom)
        rows.append((zoom, *image.shape[::-1], int(found[0])))
    levels = [
        np.median(rendered.column("distortion_level", zoom=zoom)) for zoom in ZOOMS
    ]
    return Drawing(
        drawn,
        columns(("set", "width_px", "height_px", "boards_found"), rows),
        "Rendered images of the three sets, from the longest to the shortest "
        "focal length: the first image of each set in which the board was "
        "detected.",
        Check(
            bool(np.all(np.diff(levels) > 0)),
            "the distortion over the boards rises from set to set: "
            + ", ".join(f"{level:.2f}" for level in levels),
        ),
    )


@figure("fig_2_5", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_5(results):
    """Draw the residual vectors of one image of set 3, with a scale."""
    rendered = results["table_2_2_rendered"]
    drawn, axes = new_figure(1, 2, height_in=4.0, sharex=True, sharey=True)
    rows = []
    panels = (
        ("a", "parametric", COARSE_SCALE, 5.0),
        ("b", "generic_as_printed", FIELD_SCALE, 1.0),
    )
    for panel, (letter, method, scale, bar) in zip(axes, panels, strict=True):
        field = rendered.arrays("field", method, zoom=STAGE_ZOOM)[0]
        u, v, du, dv = field[:, :4].T
        arrows = panel.quiver(
            u, v, du, dv, angles="xy", scale_units="xy",
            scale=1 / scale, width=0.004,
            color=look_of(NAMES[method])["color"],
        )  # fmt: skip
        panel.quiverkey(arrows, 0.8, 0.05, bar, f"{bar:g} px ", labelpos="W")
        panel.plot(u, v, "o", ms=1.2, color="0.4", zorder=0)
        rms = np.sqrt(np.nanmean(du**2 + dv**2))
        panel.set(
            title=f"({letter}) {NAMES[method]}\nRMS {rms:.2f} px, drawn x {scale}",
            aspect="equal",
            xlabel="u in the image (px)",
        )
        rows += [(method, *row) for row in field[:, :4]]
    axes[0].set(
        xlim=(u.min() - 60, u.max() + 60),
        ylim=(v.max() + 90, v.min() - 60),
        ylabel="v in the image (px)",
    )
    return Drawing(
        drawn,
        columns(("method", "u_px", "v_px", "du_px", "dv_px"), rows),
        "Residual vectors at the corners of the image of set 3 in Fig. 2.4, "
        "in px of the corrected view. The arrows at the lower right show the "
        f"scale. The thesis draws both {FIELD_SCALE} times as long. Here (a) "
        f"is drawn {COARSE_SCALE} times as long, because its vectors would "
        "leave the frame.",
    )


@figure(
    "fig_2_6", needs=("table_2_2_rendered", "table_2_2_redrawn"), evidence="rendered"
)
def fig_2_6(results):
    """Draw the recovered steps end to end, deviations twenty times as large."""
    drawn, axes = new_figure(1, 2, height_in=3.6, width_ratios=(3, 2))
    rows = []
    rendered = results["table_2_2_rendered"]
    axes[0].plot(
        STEP_MM * np.arange(STAGE_IMAGES), np.zeros(STAGE_IMAGES),
        "-", color="0.6", lw=5, zorder=0, label="true steps",
    )  # fmt: skip
    for method in METHODS:
        steps = rendered.arrays(method, "stage", "grid", "steps", zoom=STAGE_ZOOM)
        if not steps:
            continue
        path = path_of(steps[0])
        axes[0].plot(*path.T, **look_of(NAMES[method]), label=NAMES[method])
        rows += [(method, x, y) for x, y in path]
    axes[0].set(
        xlabel=f"Along the mean step, deviation x {STEP_SCALE} (mm)",
        ylabel=f"Across, deviation x {STEP_SCALE} (mm)",
        title="One rendered run",
    )
    trials = results["table_2_2_redrawn"].column(
        METHODS, *STEP_SCATTER, zoom=STAGE_ZOOM
    )
    axes[1].boxplot(
        [t[np.isfinite(t)] for t in trials],
        tick_labels=["standard\nperspective", "generic,\nas printed",
                     "generic, well\nconditioned"],
        showfliers=False, medianprops={"color": INK},
    )  # fmt: skip
    axes[1].tick_params(axis="x", labelsize=7.5)
    axes[1].set(
        yscale="log",
        ylabel="RMS deviation of a step (mm)",
        xlabel="Method",
        title="All redrawn runs",
    )
    drawn.legend(loc="outside lower center", ncols=2)
    return Drawing(
        drawn,
        columns(("method", "x_mm", "y_mm"), rows),
        f"Translations of {STEP_MM:g} mm recovered from homographies of "
        "five images, in the grid's frame. Left: the four steps of one "
        "rendered run end to end, with deviations from the mean step "
        f"{STEP_SCALE} times as large. Right: RMS deviation over the redrawn "
        "runs (box: quartiles, whiskers: 1.5 times their distance); "
        f"{np.isnan(trials).sum()} of {trials.size} have no value and are not drawn.",
    )


def path_of(steps):
    """Return the end-to-end path (n + 1, 2) in the plane of largest deviation."""
    mean = steps.mean(axis=0)
    shown = mean + STEP_SCALE * (steps - mean)
    along = mean / np.linalg.norm(mean)
    deviation = (steps - mean) - ((steps - mean) @ along)[:, None] * along
    across = np.linalg.svd(deviation)[2][0]
    flat = np.column_stack([shown @ along, shown @ across])
    return np.vstack([[0.0, 0.0], np.cumsum(flat, axis=0)])


# Table 2.2, and the same residuals with other corners.


# Methods in the order of the thesis, with their names in the registry's ids.
ROWS = (("parametric", "persp"), ("generic_as_printed", "gen"))
STATISTICS = {"rms": "RMS", "sd": "SD"}


@table(
    "table_2_2", needs=("table_2_2_redrawn", "table_2_2_rendered"), evidence="rendered"
)
def table_2_2(results):
    """Tabulate the residuals of the calibration images, in px of the corrected view."""
    redrawn = results["table_2_2_redrawn"]
    found = {
        "Method": [NAMES[method] for method, _ in ROWS for _ in STATISTICS],
        "Error type": [name for _ in ROWS for name in STATISTICS.values()],
    }
    printed = {}
    for zoom in ZOOMS:
        trials = redrawn.column(
            [method for method, _ in ROWS], "calibration", "corrected",
            [f"{statistic}_px" for statistic in STATISTICS], zoom=zoom,
        )  # fmt: skip
        found[f"Set {zoom} (px)"] = [*map(Measured.median_or_none, np.vstack(trials))]
        printed[f"Set {zoom} (px)"] = [
            f"t2_2_{short}_{statistic}_set{zoom}"
            for _, short in ROWS
            for statistic in STATISTICS
        ]
    return Table(
        found,
        "Distortion residuals after perspective correction, in px of the "
        f"corrected view: medians over {redrawn.trials_per_condition} simulated "
        "runs with 95 % intervals.",
        agreement(redrawn, results["table_2_2_rendered"]),
        printed=printed,
    )


LINES = {"parametric": "parametric", "generic_as_printed": "generic"}


@table("ext_table_2_2_readings", needs=OF_SEEDS, evidence="rendered")
def ext_table_2_2_readings(results):
    """Tabulate the section's results for other corner noise and interpolation."""
    rows = []
    for noise, between, method in (
        ("none", "homographic", "parametric"),
        ("none", "homographic", "generic_as_printed"),
        ("none", "smooth", "generic_as_printed"),
        ("none", "smooth", "opencv_fisheye"),
        *(
            (noise, "homographic", method)
            for noise in ("0.06 px", "0.45 px")
            for method in LINES
        ),
    ):
        case = ZoomCase(results, {"corner_noise": noise, "interpolation": between})
        residuals = [case.column(method, zoom, *RMS_PX) for zoom in ZOOMS]
        medians = [typical(trials) for trials in residuals]
        ratio = max(medians) / min(medians)
        steps = case.column(method, STAGE_ZOOM, *STEP_SCATTER)
        name = NAMES[method]
        off_lines = [np.nan]
        # Section 2.5.3 has its lines for two methods alone.
        if method in LINES:
            path = "generic_as_printed", LINES[method], "corrected"
            off_lines = case.column("lines", FACADE_ZOOM, *path)
            name += ", smooth" if between == "smooth" else ""
        rows.append(
            [noise, name, len(steps), *map(Measured.median_or_none, residuals)]
            + [ratio if np.isfinite(ratio) else None]
            + [Measured.median_or_none(trials) for trials in (steps, off_lines)]
        )
    names = [
        "Noise added", "Method", "Runs", *(f"Set {zoom} (px)" for zoom in ZOOMS),
        "Largest over smallest", "Scatter of steps, set 3 (mm)",
        "Distance from straight lines, set 2 (px)",
    ]  # fmt: skip
    return Table(
        columns(names, rows),
        "RMS residuals as in Table 2.2, with Gaussian noise added to the "
        "corners on each axis, and with a smooth surface between corners. "
        "Last columns: scatter of the steps of Fig. 2.6, and distance from "
        "straight lines near the edge of the boards, as in section 2.5.3. "
        "Medians over simulated runs with 95 % intervals.",
    )


def agreement(redrawn, rendered):
    """Check whether redrawn runs differ from rendered ones: rank tests, Holm.

    A large p-value does not show equality, so the text gives the ratios of
    the medians.
    """
    from scipy.stats import mannwhitneyu

    p, ratios = [], []
    for zoom in ZOOMS:
        first, second = (
            with_worst(ran.column(METHODS, *RMS_PX, zoom=zoom))
            for ran in (redrawn, rendered)
        )
        p += list(mannwhitneyu(first, second, axis=1).pvalue)
        ratios += list(np.median(first, axis=1) / np.median(second, axis=1))
    smallest = min(holm(p))
    return Check(
        bool(smallest > SIGNIFICANCE),
        "no difference shown between residuals of redrawn and rendered "
        f"runs: smallest corrected p of {len(p)} rank tests {smallest:.2g}; "
        f"medians of redrawn runs are {min(ratios):.2f} to {max(ratios):.2f} "
        f"times those of {second.shape[1]} rendered ones",
    )
