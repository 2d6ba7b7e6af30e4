"""Results of this page read: values of the prose, figures, tables."""

import re

import numpy as np

from chapters.shared.mirror.rigs import STAGES_MM
from repro.page import checkout, legend_below, look_of, new_figure, series
from repro.run import Drawing, Film, Panel, Table, columns, figure, table

# Times of the commands, from the README.


ROW = re.compile(r"^\| `make (\w+)` \| (\d+ (?:min|s)) \|$", re.MULTILINE)


def stated_times():
    """Return command -> its time as text, from the table of the README."""
    return dict(ROW.findall((checkout() / "README.md").read_text("utf-8")))


# One figure for each lesson: a slider over stored results. On paper it has the first
# value.


HEIGHT_IN = 2.9
RAYS = ("origins", "directions", "pixels")
PLANES_MM = (-150, -100, -60, -30, 0, 30, 60, 100, 150)
CAMERAS = {"fisheye": "Fisheye", "faceted": "Four plane mirrors"}
POSE_ERRORS = (0.1, 0.2, 0.5, 1, 2)
POSE_UNITS = {"translation": "mm", "rotation": "°"}
LENS_METHODS = {
    "parametric": "pinhole, two radial terms",
    "generic_as_printed": "central generic, as printed",
    "generic_well_conditioned": "central generic, well conditioned",
}
ORDERS = tuple(map(str, range(2, 18)))
CENTRE_METHODS = {
    "as_printed": "standard, as printed",
    "well_conditioned": "standard, well conditioned",
    "cgsp": "CGSP",
}


def slider(draw, frames, data, caption):
    """Return a Drawing of the first frame, with a slider over all of them.

    draw: value -> figure; frames: value -> its text next to the slider.
    """
    panel = Panel("", caption, [draw(value) for value in frames])
    film = Film([panel], list(frames.values()), per_second=0)
    return Drawing(draw(next(iter(frames))), data, caption, scene=film)


def strip_slider(found, looks, texts, names, axis, caption):
    """Return a slider over strips: the trials of each method, with their median.

    A trial without a value counts as the largest in the median, and has no mark.
    found: level -> {method: values (trials,)}; looks: those of the methods, in order;
    texts: level -> text; names: columns of the data; axis: label.
    """
    every = np.array([list(rows.values()) for rows in found.values()])
    limits = np.nanmin(every) / 1.3, np.nanmax(every) * 1.3

    def draw(level):
        drawn, axes = new_figure(height_in=HEIGHT_IN - 0.6)
        for y, (values, look) in enumerate(
            zip(found[level].values(), looks, strict=True)
        ):
            places = y + np.linspace(-0.25, 0.25, len(values))
            axes.plot(values, places, **look | {"linestyle": ""}, alpha=0.5)
            middle = [np.median(np.nan_to_num(values, nan=np.inf))] * 2
            axes.plot(middle, [y - 0.4, y + 0.4], "-", color=look["color"], marker="")
        axes.set(xscale="log", xlim=limits, xlabel=axis, ylim=(len(looks) - 0.5, -0.5))
        axes.set_yticks(range(len(looks)), list(found[level]))
        axes.set(ylabel=names[1].capitalize(), title=texts[level])
        return drawn

    rows = [
        (level, method, value)
        for level, by_method in found.items()
        for method, values in by_method.items()
        for value in values.tolist()
    ]
    return slider(draw, texts, columns(names, rows), caption)


def crossings(result, camera):
    """Return where rays cross planes parallel to the image, (planes, rays, 2) mm.

    Plane 0 is where the rays of each quarter of the image come closest to each other.
    """
    origins, directions, pixels = (result.arrays(n, camera=camera)[0] for n in RAYS)
    slopes = directions[:, :2] / directions[:, 2:]
    points = origins[:, :2] - origins[:, 2:] * slopes
    quarters = pixels > pixels.mean(axis=0)
    spread, growth = points.copy(), slopes.copy()
    for quarter in np.unique(quarters, axis=0):
        one = (quarters == quarter).all(axis=1)
        spread[one] -= points[one].mean(axis=0)
        growth[one] -= slopes[one].mean(axis=0)
    depth = -np.sum(spread * growth) / np.sum(growth**2)
    planes = depth + np.array(PLANES_MM)
    return points + planes[:, None, None] * slopes


@figure("ext_lesson_rays", needs=("fig_2_1_tables",), evidence="analytic", scene=True)
def ext_lesson_rays(results):
    """Draw where the rays of two cameras cross a plane that moves."""
    found = {c: crossings(results["fig_2_1_tables"], c) for c in CAMERAS}
    frames = {k: f"Plane at {z} mm" for k, z in enumerate(PLANES_MM)}

    def draw(k):
        drawn, panels = new_figure(1, 2, height_in=HEIGHT_IN + 0.6)
        for axes, (camera, name) in zip(panels, CAMERAS.items(), strict=True):
            axes.plot(*found[camera][k].T, **series(0) | {"linestyle": ""}, mfc="none")
            half = 1.05 * np.abs(found[camera]).max()
            axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
            axes.set(title=f"{name}, {PLANES_MM[k]} mm")
            axes.set(xlabel="x (mm)", ylabel="y (mm)")
        return drawn

    rows = [
        (camera, z, *point)
        for camera, planes in found.items()
        for z, points in zip(PLANES_MM, planes, strict=True)
        for point in points.tolist()
    ]
    return slider(
        draw,
        frames,
        columns(("camera", "plane_mm", "x_mm", "y_mm"), rows),
        "Points where the rays of two cameras cross a plane parallel to the image, "
        "which the slider moves. At 0 mm all rays of the fisheye meet in its centre. "
        "The rays of the camera with four plane mirrors meet in four points.",
    )


@figure("ext_lesson_grids", needs=("fig_2_2_error",), evidence="synthetic", scene=True)
def ext_lesson_grids(results):
    """Draw the ray error from two grids against the error of a pose."""
    result = results["fig_2_2_error"]
    found = {
        level: {
            f"{kind} ({unit})": result.column("ray_deg", level, kind=kind)
            for kind, unit in POSE_UNITS.items()
        }
        for level in POSE_ERRORS
    }
    return strip_slider(
        found,
        [series(0), series(1)],
        {level: f"Pose error {level} mm or {level}°" for level in found},
        ("pose_error", "part", "ray_deg"),
        "Ray error (deg)",
        "Ray error from two grids in known poses, where the translation or the "
        "rotation of one pose is wrong. The slider sets that error. One mark for each "
        "simulated run, lines: medians.",
    )


@figure("ext_lesson_residual", needs=("fig_2_3_fov",), evidence="synthetic", scene=True)
def ext_lesson_residual(results):
    """Draw ray error against residual, by method and field of view."""
    chosen = results["fig_2_3_fov"].select(domain="px", extent="unbounded")
    found = {
        fov: np.stack(
            [
                some.column(tuple(LENS_METHODS), "noisy", "source", "mean_px"),
                some.column(tuple(LENS_METHODS), "ray_deg"),
            ],
            axis=1,
        )
        for fov, some in chosen.by("fov_deg").items()
    }
    every = np.array(list(found.values()))
    low, high = np.nanpercentile(every, (0, 100), axis=(0, 1, 3)) * [[0.75], [1.3]]

    def draw(fov):
        drawn, axes = new_figure(height_in=HEIGHT_IN + 0.4)
        for name, errors in zip(LENS_METHODS.values(), found[fov], strict=True):
            look = look_of(name) | {"linestyle": ""}
            axes.plot(*errors, label=name, alpha=0.6, **look)
        axes.set(xscale="log", xlim=(low[0], high[0]), xlabel="Residual (px)")
        axes.set(yscale="log", ylim=(low[1], high[1]), ylabel="Ray error (deg)")
        axes.set_title(frames[fov])
        legend_below(drawn, axes, ncols=2)
        return drawn

    frames = {fov: f"Field of view {fov}°" for fov in found}
    rows = [
        (fov, method, *pair)
        for fov, methods in found.items()
        for method, errors in zip(LENS_METHODS, methods, strict=True)
        for pair in errors.T.tolist()
    ]
    return slider(
        draw,
        frames,
        columns(("fov_deg", "method", "residual_px", "ray_deg"), rows),
        "Ray error against residual for three methods at a noise of 0.5 px. The slider "
        "sets the field of view. One mark for each simulated run. The residual is the "
        "mean distance to the points that were fitted.",
    )


@figure(
    "ext_lesson_steps", needs=("ext_orders_of_steps",), evidence="analytic", scene=True
)
def ext_lesson_steps(results):
    """Draw the phase error of each order of the profile, by number of steps."""
    ran = results["ext_orders_of_steps"]
    found = {
        steps: some.column(("sine", "cosine"), ORDERS)[..., 0].max(axis=0)
        for steps, some in ran.by("steps").items()
    }
    frames = {steps: f"{steps} phase steps" for steps in found}

    def draw(steps):
        drawn, axes = new_figure(height_in=HEIGHT_IN)
        axes.bar(ORDERS, 1000 * found[steps], color=series(0)["color"])
        axes.set(ylim=(0, 12), ylabel="Phase error (mrad)", title=frames[steps])
        axes.set_xlabel("Order of the profile")
        return drawn

    rows = [
        (steps, int(order), error)
        for steps, errors in found.items()
        for order, error in zip(ORDERS, errors.tolist(), strict=True)
    ]
    return slider(
        draw,
        frames,
        columns(("steps", "order", "error_rad"), rows),
        "Largest phase error where one order of the brightness profile has "
        f"{100 * ran.settings['amplitude']:g} % of the first order. The slider sets "
        "the number of phase steps.",
    )


@figure(
    "ext_lesson_centre", needs=("fig_4_2_redrawn",), evidence="synthetic", scene=True
)
def ext_lesson_centre(results):
    """Draw the error of the centre by method and noise."""
    chosen = results["fig_4_2_redrawn"].select(domain="px")
    found = {
        noise: {
            name: some.column(method, "linear", "centre_mm")
            for method, name in CENTRE_METHODS.items()
        }
        for noise, some in chosen.by("noise").items()
    }
    return strip_slider(
        found,
        [look_of(name) for name in CENTRE_METHODS.values()],
        {noise: f"Noise {noise:g} px" for noise in found},
        ("noise_px", "method", "centre_mm"),
        "Error of the centre (mm)",
        "Error of the camera centre after the linear stage, by method. The slider sets "
        "the noise. One mark for each simulated run, lines: medians. A run without a "
        "camera has no mark and counts as the largest error.",
    )


@figure("ext_lesson_mirror", needs=("fig_5_10_fans",), evidence="synthetic", scene=True)
def ext_lesson_mirror(results):
    """Draw the fan of rays of the mirror's middle line on three rigs, by stage."""
    fans = {
        rig: np.median(some.arrays("laboratory"), axis=0)
        for rig, some in results["fig_5_10_fans"].by("geometry").items()
    }
    frames = {k: f"Deflection {d:g} mm" for k, d in enumerate(STAGES_MM)}

    def draw(stage):
        drawn, axes = new_figure(height_in=HEIGHT_IN - 0.6)
        for y, degrees in enumerate(fans.values()):
            for k, look in ((0, series(6)), (stage, series(0))):
                ends = np.array([-0.5, 0.5]) * degrees[k]
                axes.plot(ends, [y + 0.2 * (k > 0)] * 2, **look)
        half = 0.55 * max(map(max, fans.values()))
        axes.set(xlim=(-half, half), ylim=(2.5, -0.5), title=frames[stage])
        axes.set_yticks(range(len(fans)), list(fans))
        axes.set(xlabel="Direction from the middle of the fan (deg)", ylabel="Rig")
        return drawn

    rows = [
        (rig, deflection, fan)
        for rig, degrees in fans.items()
        for deflection, fan in zip(STAGES_MM, degrees.tolist(), strict=True)
    ]
    return slider(
        draw,
        frames,
        columns(("rig", "deflection_mm", "fan_deg"), rows),
        "Angle between the outermost rays of the mirror's middle line, on three rigs: "
        "flat (dotted) and at the deflection that the slider sets (solid). Medians "
        "over simulated runs.",
    )


# Conditions and trials of the experiments that a class can repeat.


@table(
    "ext_class_runs",
    needs=(
        "fig_2_2_error",
        "fig_2_3_noise",
        "fig_2_3_fov",
        "fig_2_3_laws",
        "fig_3_11_noise",
        "fig_3_11_blur",
    ),
    evidence="synthetic",
)
def ext_class_runs(results):
    """Tabulate conditions and trials of the experiments of the lessons."""
    return Table(
        {
            "Experiment": list(results),
            "Conditions": [len(r.conditions) for r in results.values()],
            "Trials each": [r.trials_per_condition for r in results.values()],
        },
        "Conditions and trials of the experiments of Figs. 2.2, 2.3 and 3.11.",
    )
