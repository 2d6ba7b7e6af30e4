"""Values of the prose and figures of section 5.2, from its results."""

from itertools import pairwise

import numpy as np

from chapters.ch05_flexible_mirror.s2_method.experiment import (
    REJECTED,
    SHAPES,
    STAGES,
    STEPS_MM,
)
from chapters.shared.mirror import (
    BENCHES,
    FIRST,
    LEVEL,
    SWEPT,
    mirror_rig,
    platter_camera,
    shape_name,
)
from raxel.calibration import platter_plane, reflected_pose
from raxel.geometry import on_plane, transform
from raxel.show import (
    Labels,
    Points,
    Polyline,
    Segments,
    Surface,
    board,
    framed,
    frustum,
    mirrors,
    plate,
)
from repro.page import INK, new_figure, series, value
from repro.page.space import draw_scene
from repro.run import SHARE_OF_SEEDS, Check, Drawing, columns, figure

BOTH = ("exp_c5_linear_enough", "exp_c5_linear_enough_swept")
STARTS, STARTS_SWEPT = BOTH
KNOTS = "exp_c5_knot_tradeoff"
STATIC, LOOPS = "exp_c5_static_grid_bias", "table_5_5_runs"
# Of the mirrors in the test of static grids.
UNEVEN_UM = BENCHES[FIRST].aberration_um
# Of Table 5.5: the steps from stage 3 back to stage 0, after the last of which the
# single step from stage 3 ends as well.
BACK = ("step4", "step5", "step6")
SAME = 0.01
MAX_DEG = 1.0  # mean ray error up to which a step is tolerated


def end_differences(results, level, start="linear"):
    """Relative differences (2, runs) of cost and deflection at the end of the
    refinement from those of the start at the true surface; nan where rejected."""
    result = results[STARTS_SWEPT if level in SWEPT else STARTS]
    ends = result.column(level, (start, "true"), ("cost_mm2", "deflection_mm"))
    return np.abs(ends[0] / ends[1] - 1)


def same_ends(differences):
    """Whether cost and deflection (2, runs) agree; a rejected run does not."""
    return np.all(differences <= SAME, axis=0)


def largest_step(result, shape):
    """The largest step, mm, with nine of ten mean ray errors below MAX_DEG, else 0.

    A rejected run is not below.
    """
    angles = np.array(result.arrays(shape_name(shape), "angles_deg"))
    tolerated = np.mean(angles < MAX_DEG, axis=0) >= SHARE_OF_SEEDS
    return float(np.max(np.array(STEPS_MM)[tolerated], initial=0.0))


def name_values(open_results):
    """Name the numbers of the prose."""
    starts, knots = {STARTS: open_results(STARTS)}, open_results(KNOTS)
    surfaces = open_results(STATIC)
    for start in ("linear", "before"):
        same = same_ends(end_differences(starts, LEVEL, start))
        value(f"{LEVEL}.{start}.same", 100 * float(np.mean(same)))
    for points in ("pixel", "grid"):
        errors = surfaces.column(points, "linear_mm", aberration_um=UNEVEN_UM)
        value(f"static.uneven.{points}.linear", 1000 * float(np.median(errors)))
    for shape in (SHAPES[0], SHAPES[-1]):
        value(f"{shape_name(shape)}.step", largest_step(knots, shape))


# Fig. 5.3: pose of a monitor that the camera sees in a reference mirror.


# From above, from behind the camera and its right, where the monitor shows its face.
SIGHT, BODY_MM, RIM = (-0.45, 0.5, 0.85), 45.0, 96
SILVER, GREY = "#9fb4c7", "#6b7785"
NEAR_COLOUR, FAR_COLOUR, IMAGE = (series(k)["color"] for k in (0, 2, 1))
ON_BOARD, RAY = "platter on its board", "rays"
N_POINTS, EXACT_PX = 3, 1e-6
NOTE = (
    "Grey lines run from the camera over the platter to the monitor; orange ones go on "
    "behind the platter to the mirror image, where the camera sees the monitor."
)


@figure("fig_5_3", needs=("fig_5_3_platter",), evidence="rendered", scene=True)
def fig_5_3(results):
    """Camera, platter on its board, flexible mirror, monitor and its image."""
    rig = mirror_rig("A")
    platter, poses = rig.platter(), rig.monitor_poses()
    plane = platter_plane(platter.T_camera_board, platter.thickness_mm)
    virtual = [reflected_pose(T, plane) for T in poses]
    seen = points_in_platter(rig, platter, virtual[0])
    parts = setup_parts(rig, platter, poses, virtual[0], seen)
    scene = framed(parts, SIGHT, aspect=1.2, note=NOTE)
    drawn, (space, recorded) = new_figure(1, 2, height_in=4.0)
    drawn.set_layout_engine("none")
    space.set_position([0.0, 0.0, 0.6, 0.94])
    recorded.set_position([0.62, 0.12, 0.37, 0.8])
    recorded.imshow(
        results["fig_5_3_platter"].arrays("picture")[0], cmap="gray", vmin=0, vmax=255
    )
    recorded.set_axis_off()
    for panel, letter in ((space, "(a)"), (recorded, "(b)")):
        drawn.text(panel.get_position().x0 + 0.01, 0.94, letter, fontsize=9)
    draw_scene(space, scene)
    traced = platter_camera(rig, platter).project(transform(poses[0], on_plane(seen)))
    straight = rig.viewer.project(transform(virtual[0], on_plane(seen)))
    off = np.abs(straight.pixels - traced.pixels).max()
    named = {
        "platter": platter.T_camera_mirror,
        "monitor, first position": poses[0],
        "monitor, second position": poses[1],
        "mirror image, first position": virtual[0],
        "mirror image, second position": virtual[1],
    }
    rows = [(name, *T[:3, 3]) for name, T in named.items()]
    return Drawing(
        drawn,
        columns(("what", "x_mm", "y_mm", "z_mm"), rows),
        "Set-up for the pose of the monitor. (a) Rig A in the camera's frame: a hard "
        "disk's platter on a chessboard is between camera and flexible mirror. The "
        "camera sees the board and, in the platter, the monitor's mirror image "
        "(orange). Reflected in the plane of the platter, the image's pose is the "
        "monitor's (blue; green: second position). (b) Rendered image of the platter "
        "on its board, reflecting a sinusoidal pattern.",
        Check(
            bool(off < EXACT_PX),
            "straight lines from the camera to the mirror image meet the image where "
            f"rays traced over the platter do, to {off:.0e} px",
        ),
        scene,
    )


def points_in_platter(rig, platter, T_virtual):
    """Points (N_POINTS, 2), mm, on the monitor that the camera sees in the platter."""
    corner, size = rig.monitor.extent
    shares = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 61)]), axis=-1).reshape(-1, 2)
    points = corner + size * shares
    _, met = _over_the_platter(platter, transform(T_virtual, on_plane(points)))
    wanted = 0.75 * platter.radius_mm * _around(N_POINTS)
    return points[[np.argmin(np.linalg.norm(met - at, axis=1)) for at in wanted]]


def setup_parts(rig, platter, poses, T_virtual, seen):
    """Objects in the camera's frame; seen: (n, 2) mm of the near monitor."""
    image, there = (transform(T, on_plane(seen)) for T in (T_virtual, poses[0]))
    met, _ = _over_the_platter(platter, image)
    rim = _around(RIM, closed=True)
    ring = np.concatenate([platter.radius_mm * rim, platter.hub_mm * rim])
    ring = transform(platter.T_camera_mirror, on_plane(ring)).reshape(2, RIM, 3)
    return [
        frustum(rig.viewer, BODY_MM, label=""),
        *mirrors(rig.rig.camera, "flexible mirror", opacity=0.7),
        *board(platter.board, platter.T_camera_board, label=ON_BOARD),
        Surface(ring, SILVER, 1.0, ON_BOARD),
        *board(rig.monitor.target, poses[0], label="monitor", colour=NEAR_COLOUR),
        *_outline(rig, poses[1], FAR_COLOUR, "second position"),
        *_outline(rig, T_virtual, IMAGE, "its mirror image"),
        Segments(np.zeros_like(met), met, GREY, RAY, 1.4),
        Segments(met, there, GREY, RAY, 1.4),
        Segments(met, image, IMAGE, RAY, 1.4),
        Points(met, INK, RAY, 5.0),
        *_names(rig, platter, poses, T_virtual),
    ]


def _outline(rig, T, colour, label):
    sheet = plate(T, *rig.monitor.extent, colour=colour, opacity=0.18, label=label)
    rim = sheet.points[[0, 0, 1, 1, 0], [0, 1, 1, 0, 0]]
    return [sheet, Polyline(rim, colour, label, 2.0)]


def _names(rig, platter, poses, T_virtual):
    corner, size = rig.monitor.extent
    above = on_plane((corner + size * [0.5, -0.08])[None])
    mirror = rig.rig.camera
    named = {
        "camera": np.array([0.0, -BODY_MM, 0.0]),
        "monitor": transform(poses[0], above)[0],
        "mirror image": transform(T_virtual, above)[0],
        "platter": platter.T_camera_mirror[:3, 3] + [0, platter.radius_mm + 22, 0],
        "flexible mirror": mirror.T_viewer_mirror[:3, 3]
        + mirror.T_viewer_mirror[:3, :2] @ [mirror.mirror.end / 2, 75.0],
    }
    return [Labels(at[None], [name], INK) for name, at in named.items()]


def _over_the_platter(platter, points):
    """Where lines from the camera to points (N, 3) meet the platter's face: (N, 3) in
    the camera's frame, and (N, 2) from its middle in its plane."""
    T = platter.T_camera_mirror
    normal = T[:3, 2]
    met = points * (normal @ T[:3, 3] / (points @ normal))[:, None]
    return met, (met - T[:3, 3]) @ T[:3, :2]


def _around(count, closed=False):
    turn = np.linspace(0, 2 * np.pi, count, endpoint=closed) + np.pi / 2
    return np.column_stack([np.cos(turn), np.sin(turn)])


# Fig. 5.4: SPFC2 as a flowchart of the stages that its code runs through.


# Stage -> column, row, and the text in its box above the function's name.
BOXES = {
    "viewer": (0, 0, "Camera alone:\n{boards} boards seen directly"),
    "platter": (0, 1, "Monitor's {positions} positions\nin the platter (5.26, 5.27)"),
    "line": (0, 2, "Clamp: a straight line\nthrough picked pixels"),
    "rays": (0, 3, "Scene rays $V_r$ of\n{pixels} pixels (2.12)"),
    "points": (0, 4, "Mirror points: where\n$V_l$ and $V_r$ meet"),
    "shape": (1, 4, "Normals: spline up to\nscale (5.15, 5.16)"),
    "scale": (1, 3, "Scale, from the\nmirror points"),
    "first": (1, 2, "Refinement:\n{primary_steps} steps"),
    "held": (1, 1, "Depth along the clamp:\nfixed from now on (5.19)"),
    "bend": (1, 0, "Bend; one fixed board\nis seen before and after"),
    "pose": (2, 0, "Board's pose, with the\nprevious mirror (2.26)"),
    "order": (2, 1, "Images in order?"),
    "knots": (2, 2, "Knots anew; corners in\ntheir end intervals?"),
    "linear": (2, 3, "Linear: $V_r' \\approx V_r$,\nclamp (5.28, 5.22)"),
    "refine": (2, 4, "Ray-point vectors (5.29):\n{steps} steps"),
    "open": (2, 5, "Rays at all knots\ndetermined?"),
}
REJECTING = ("order", "knots", "open")
WAYS, AGAIN = (*pairwise(BOXES),), ("open", "bend")
X_STEP, Y_STEP, WIDTH, HEIGHT = 4.0, 1.6, 3.15, 1.15


def transitions(result):
    """{(stage, stage): count} of the logged run.

    A person bends the mirror before the pose of the board: this stage is not logged.
    """
    ways = {}
    for name in result.names():
        if name.startswith("ways."):
            start, end = name.removeprefix("ways.").split(" > ")
            ways[start, "bend" if end == "pose" else end] = result.texts(name)[0]
    return ways | {
        ("bend", "pose"): sum(n for (_, end), n in ways.items() if end == "bend")
    }


@figure("fig_5_4", needs=("fig_5_4_run",), evidence="rendered")
def fig_5_4(results):
    """Draw the stages of the code, with the count of each transition in a run."""
    result = results["fig_5_4_run"]
    ways = transitions(result)
    rejections = [(stage, REJECTED) for stage in REJECTING]
    rows = [(*way, ways.get(way, 0)) for way in (*WAYS, AGAIN, *rejections)]
    undrawn = [way for way in ways if way not in (*WAYS, AGAIN, *rejections)]
    steps = result.column(("stage1", "stage2", "stage3"), "steps")[:, 0]
    calibrated = steps[np.isfinite(steps)]
    amounts = {name: result.texts(name)[0] for name in result.names()}
    amounts["steps"] = " + ".join(f"{n:g}" for n in calibrated) or "no"
    drawn, axes = new_figure(height_in=6.0)
    for stage in BOXES:
        _draw_box(axes, stage, amounts)
    for way in WAYS:
        _draw_way(axes, *way, ways.get(way, 0))
    _draw_again(axes, ways.get(AGAIN, 0))
    _draw_ends(axes, ways, len(calibrated))
    axes.set(
        xlim=(-1.9, 2 * X_STEP + 4.0), ylim=(-5 * Y_STEP - 1.8, 1.5), aspect="equal"
    )
    axes.axis("off")
    return Drawing(
        drawn,
        columns(("from", "to", "times"), rows),
        "Flowchart of SPFC2: its stages with the functions of the code, and the count "
        "of each transition in one run of three deflections on rig A. Primary "
        "calibration goes down the left column and up the middle one; dynamic "
        "calibration goes down the right one, once for each deflection.",
        Check(
            not undrawn,
            f"not drawn: {undrawn}"
            if undrawn
            else "every transition of the run is drawn",
        ),
    )


def _place(stage):
    column, row = BOXES[stage][:2]
    return X_STEP * column, -Y_STEP * row


def _draw_box(axes, stage, amounts):
    from matplotlib import patches

    x, y = _place(stage)
    function = STAGES[stage].rpartition(".")[2] if stage in STAGES else "a person"
    axes.add_patch(
        patches.FancyBboxPatch(
            (x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT,
            boxstyle="round,pad=0.02,rounding_size=0.12",
            facecolor="#eef3f8" if stage in STAGES else "#fdf3e3",
            edgecolor=INK, linewidth=0.9,
        )
    )  # fmt: skip
    centred = {"ha": "center", "va": "center"}
    axes.text(x, y + 0.15, BOXES[stage][2].format(**amounts), fontsize=7.0, **centred)
    axes.text(x, y - HEIGHT / 2 + 0.15, function, fontsize=6.0, family="monospace",
              color="#555555", **centred)  # fmt: skip


def _draw_way(axes, start, end, times):
    """A straight arrow between neighbouring boxes, with its count."""
    (x0, y0), (x1, y1) = _place(start), _place(end)
    if x0 == x1:
        down = 1 if y1 < y0 else -1
        a, b = (x0, y0 - down * HEIGHT / 2), (x1, y1 + down * HEIGHT / 2)
        spot, align = (x0 + 0.12, (y0 + y1) / 2), {"ha": "left", "va": "center"}
    else:
        a, b = (x0 + WIDTH / 2, y0), (x1 - WIDTH / 2, y1)
        spot, align = ((a[0] + b[0]) / 2, y0 + 0.1), {"ha": "center", "va": "bottom"}
    axes.annotate("", b, a, arrowprops={"arrowstyle": "-|>", "color": INK})
    axes.text(*spot, f"{times}", fontsize=7, **align)


def _draw_again(axes, times):
    """Draw the arrow from the last stage to the next deflection, at the right edge."""
    (x, y), (bend, top) = _place("open"), _place("bend")
    colour, right, above = series(1)["color"], x + WIDTH / 2 + 2.2, top + 1.05
    line = [(x + WIDTH / 2, y), (right, y), (right, above), (bend, above)]
    axes.plot(*zip(*line, strict=True), color=colour, linestyle="-", marker="", lw=1.0)
    arrow = {"arrowstyle": "-|>", "color": colour}
    axes.annotate("", (bend, top + HEIGHT / 2), (bend, above), arrowprops=arrow)
    axes.text(x, above + 0.07, f"yes, and bent again   {times}", fontsize=7,
              color=colour, ha="center", va="bottom")  # fmt: skip


def _draw_ends(axes, ways, calibrated):
    """Draw where a stage can be rejected, and where a run ends."""
    colour = series(2)["color"]
    for stage in REJECTING:
        x, y = _place(stage)
        a = (x + WIDTH / 2, y - 0.3)
        axes.annotate(
            "", (a[0] + 0.6, a[1]), a, arrowprops={"arrowstyle": "-|>", "color": colour}
        )
        axes.text(a[0] + 0.62, a[1], f"no: rejected  {ways.get((stage, REJECTED), 0)}",
                  fontsize=6.5, color=colour, ha="left", va="center",
                  bbox={"fc": "white", "ec": "none", "pad": 1}, zorder=5)  # fmt: skip
    x, y = _place("open")
    low = y - HEIGHT / 2
    axes.annotate("", (x, low - 0.5), (x, low), arrowprops={"arrowstyle": "-|>"})
    axes.text(x, low - 0.55, f"calibrated camera   {calibrated}", fontsize=7,
              ha="center", va="top")  # fmt: skip
    for stage, title in (
        ("viewer", "primary calibration, once"), ("pose", "dynamic calibration"),
    ):  # fmt: skip
        x, y = _place(stage)
        axes.text(x, y + HEIGHT / 2 + 0.12, title, fontsize=7.4, ha="center",
                  va="bottom", style="italic")  # fmt: skip
