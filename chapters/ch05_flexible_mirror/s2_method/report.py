"""Results of this page read: values of the prose, figures, tables."""

from typing import NamedTuple

import matplotlib.patches as patches
import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch05_flexible_mirror.s2_method.experiment import (
    REFUSED,
    SHAPES,
    STAGES,
    STEPS_MM,
)
from chapters.shared.mirror import (
    BENCHES,
    CONTRASTED,
    FIRST,
    LEVEL,
    SAID,
    STAGES_MM,
    SWEPT,
    mirror_rig,
    platter_camera,
    shape_name,
)
from raxel.calibration.mirror.platter import platter_plane, reflected_pose
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.show import Labels, Points, Polyline, Segments, Surface, framed
from raxel.show.boards import board, plate
from raxel.show.cameras import frustum, mirrors
from repro.page import INK, legend_below, new_figure, series, value
from repro.page.space import draw_scene
from repro.run import SHARE_OF_SEEDS, Check, Drawing, columns, figure, median_interval

# Results of section 5.2, and the numbers that its page quotes.


BOTH = ("exp_c5_linear_enough", "exp_c5_linear_enough_swept")
STARTS, STARTS_SWEPT = BOTH
RUN, KNOTS = "fig_5_4_run", "exp_c5_knot_tradeoff"
STATIC, LOOPS = "exp_c5_static_grid_bias", "table_5_5_runs"
# Of the mirrors in the test of static grids.
UNEVEN_UM = BENCHES[FIRST].aberration_um
# Of Table 5.5: the steps from stage 3 back to stage 0, after the last of which the
# single step from stage 3 ends as well.
BACK = ("step4", "step5", "step6")
SAME = 0.01
MAX_DEG = 1.0  # mean ray error up to which a step is tolerated


class Starts(NamedTuple):
    """Trials of one error level: end points of the refinement, start by start."""

    trials: object
    bench: str

    @classmethod
    def on(cls, results, bench):
        """Return the trials of a level by its name, from both Results."""
        result = results[STARTS_SWEPT if bench in SWEPT else STARTS]
        return cls(result.select(geometry="A"), bench)

    def of(self, start, name):
        """A value of each run, (seeds,), NaN where it was rejected."""
        return self.trials.column(f"{self.bench}.{start}.{name}")

    def off(self, start, name):
        """Relative difference of a value from that of the start at the true surface."""
        return np.abs(self.of(start, name) / self.of("true", name) - 1)

    def most_off(self, start, name):
        """Largest of these differences, in percent."""
        off = self.off(start, name)
        return 100 * float(np.max(off[np.isfinite(off)], initial=0.0))

    def same(self, start="linear"):
        """Whether a start ends where the true surface does (seeds,): equal cost and
        equal deflection. A rejected run does not."""
        return (self.off(start, "cost_mm2") <= SAME) & (
            self.off(start, "deflection_mm") <= SAME
        )

    @property
    def completed(self):
        """Which runs (seeds,) have an end from the linear estimate and the truth."""
        return np.isfinite(self.off("linear", "cost_mm2"))

    @property
    def refused(self):
        """Number of runs without an end from the linear estimate or from the truth."""
        names = ("refused", "linear.refused", "true.refused")
        texts = zip(
            *(self.trials.texts(f"{self.bench}.{n}") for n in names), strict=True
        )
        return sum(any(said) for said in texts)


class Ran(NamedTuple):
    """One logged run. ways: {(stage, stage): count}; numbers: of the trial, by
    name; steps: of the refinement, for each calibrated stage."""

    ways: dict
    numbers: dict
    steps: tuple

    @classmethod
    def of(cls, result):
        """Return the run of the Result of `fig_5_4_run`."""
        trial = {name: result.texts(name)[0] for name in result.names()}
        ways = {
            tuple(name.removeprefix("ways.").split(" > ")): trial[name]
            for name in trial
            if name.startswith("ways.")
        }
        steps = [trial.get(f"stage{k}.steps") for k in (1, 2, 3)]
        return cls(ways, trial, tuple(n for n in steps if n is not None))

    @property
    def accepted(self):
        """Number of calibrated stages."""
        return len(self.steps)

    def times(self, start, end):
        """Count of a transition. Between two stages of the code a person bends the
        mirror, which is not logged: transitions to and from there are the same."""
        if start == "bend":
            return sum(n for (_, other), n in self.ways.items() if other == end)
        if end == "bend":
            end = "pose"
        return self.ways.get((start, end), 0)

    def beyond(self, drawn, can_refuse):
        """Transitions of the run that are not among these, as text."""
        known = {(a, "pose" if b == "bend" else b) for a, b in drawn}
        known |= {(stage, "refused") for stage in can_refuse}
        return [" > ".join(way) for way in self.ways if way not in known]

    def amounts(self):
        """Numbers in the boxes of the flowchart."""
        steps = " + ".join(f"{n}" for n in self.steps) or "no"
        return self.numbers | {"steps": steps}


class StepSizes(NamedTuple):
    """Three steps of 5 mm and one of 15 mm, from stage 3 to 0, at one error level."""

    result: object
    bench: str

    def common(self, way):
        """Corners (seeds,) that both images of a step show; 0 where rejected.

        way: "staged", the mean of the three steps, or "single".
        """
        places = BACK if way == "staged" else ("single",)
        found = [self._of(place, "common") for place in places]
        return np.mean(np.nan_to_num(found, nan=0.0), axis=0)

    def back(self, way):
        """Back-projection errors (seeds,) mm at stage 0, NaN where it was rejected."""
        return self._of(BACK[-1] if way == "staged" else "single", "back_mm")

    def _of(self, place, name):
        return self.result.column(f"{self.bench}.{place}.{name}")


def surfaces(results, aberration_um, points, stage="linear"):
    """Errors (trials,) mm of the surface before any deflection.

    points: "pixel", each pixel's own, or "grid", interpolated; stage: "linear", as
    published, or "refined".
    """
    return results[STATIC].column(f"{points}.{stage}_mm", aberration_um=aberration_um)


class Knots(NamedTuple):
    """One step of each size with several numbers of knots."""

    trials: object

    @classmethod
    def of(cls, results):
        """Return the trials from the Results, by name."""
        return cls(results[KNOTS].select(geometry="A"))

    def shares(self, shape):
        """Share (steps,) of the runs with a mean ray error below MAX_DEG; a rejected
        run is not below."""
        angles = np.array(self.trials.arrays(f"{shape_name(shape)}.angles_deg"))
        with np.errstate(invalid="ignore"):
            return np.mean(angles < MAX_DEG, axis=0)

    def largest_step(self, shape):
        """The largest step, mm, with nine of ten runs below MAX_DEG, 0 if none."""
        borne = np.array(STEPS_MM)[self.shares(shape) >= SHARE_OF_SEEDS]
        return float(borne.max(initial=0.0))

    def noise_free(self, shape):
        """Estimate of the shape's median error without noise, mm."""
        name = f"{shape_name(shape)}.noise_free_mm"
        return median_interval(self.trials.column(name))


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, number in quoted(open_results).items():
        value(name, number)


def quoted(open_results):
    """Name -> number, of what the prose quotes."""
    results = {name: open_results(name) for name in (*BOTH, STATIC, KNOTS)}
    starts, knots = Starts.on(results, LEVEL), Knots.of(results)
    found = {
        f"{LEVEL}.{start}.same": 100 * float(np.mean(starts.same(start)))
        for start in ("linear", "before")
    }
    found |= {
        f"static.uneven.{points}.linear": 1000
        * float(np.median(surfaces(results, UNEVEN_UM, points)))
        for points in ("pixel", "grid")
    }
    return found | {
        f"{shape_name(shape)}.step": knots.largest_step(shape)
        for shape in (SHAPES[0], SHAPES[-1])
    }


# Fig. 5.3: pose of a monitor that the camera sees in a reference mirror.


# From above, from behind the camera and its right, where the monitor shows its face.
SIGHT, BODY_MM, RIM = (-0.45, 0.5, 0.85), 45.0, 96
SILVER, GREY = "#9fb4c7", "#6b7785"
NEAR, FAR, IMAGE = (series(k)["color"] for k in (0, 2, 1))
ON_BOARD, RAY = "platter on its board", "rays"
SEEN, EXACT_PX = 3, 1e-6
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
    drawn, (space, photograph) = new_figure(1, 2, height_in=4.0)
    drawn.set_layout_engine("none")
    space.set_position([0.0, 0.0, 0.6, 0.94])
    photograph.set_position([0.62, 0.12, 0.37, 0.8])
    photograph.imshow(
        results["fig_5_3_platter"].arrays("picture")[0], cmap="gray", vmin=0, vmax=255
    )
    photograph.set_axis_off()
    for panel, letter in ((space, "(a)"), (photograph, "(b)")):
        drawn.text(panel.get_position().x0 + 0.01, 0.94, letter, fontsize=9)
    draw_scene(space, scene)
    off = _off_by_tracing(rig, platter, poses[0], virtual[0], seen)
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
    """Points (SEEN, 2), mm, on the monitor that the camera sees in the platter."""
    corner, size = rig.monitor.extent
    shares = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 61)]), axis=-1).reshape(-1, 2)
    points = corner + size * shares
    _, met = _over_the_platter(platter, transform(T_virtual, on_plane(points)))
    wanted = 0.75 * platter.radius_mm * _around(SEEN)
    return points[[np.argmin(np.linalg.norm(met - at, axis=1)) for at in wanted]]


def setup_parts(rig, platter, poses, T_virtual, seen):
    """Objects in the camera's frame; seen: (n, 2) mm of the near monitor."""
    image, there = (transform(T, on_plane(seen)) for T in (T_virtual, poses[0]))
    met, _ = _over_the_platter(platter, image)
    parts = [
        frustum(rig.viewer, BODY_MM, label=""),
        *mirrors(rig.rig.camera, "flexible mirror", opacity=0.7),
    ]
    parts += board(platter.board, platter.T_camera_board, label=ON_BOARD)
    parts += [_ring(platter)]
    parts += board(rig.monitor.target, poses[0], label="monitor", colour=NEAR)
    parts += [
        *_outline(rig, poses[1], FAR, "second position"),
        *_outline(rig, T_virtual, IMAGE, "its mirror image"),
        Segments(np.zeros_like(met), met, GREY, RAY, 1.4),
        Segments(met, there, GREY, RAY, 1.4),
        Segments(met, image, IMAGE, RAY, 1.4),
        Points(met, INK, RAY, 5.0),
    ]
    return parts + _names(rig, platter, poses, T_virtual)


def _ring(platter):
    rim = _around(RIM, closed=True)
    flat = np.concatenate([platter.radius_mm * rim, platter.hub_mm * rim])
    points = transform(platter.T_camera_mirror, on_plane(flat))
    return Surface(points.reshape(2, RIM, 3), SILVER, 1.0, ON_BOARD)


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


def _off_by_tracing(rig, platter, T, T_virtual, seen):
    """Distance (px) between the direct image and the one traced over the platter."""
    straight = rig.viewer.project(transform(T_virtual, on_plane(seen))).pixels
    traced = platter_camera(rig, platter).project(transform(T, on_plane(seen))).pixels
    return float(np.abs(straight - traced).max())


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
HANDS = "a person"
CAN_REFUSE = ("order", "knots", "open")
WAYS = (
    *(("viewer", "platter"), ("platter", "line"), ("line", "rays")),
    *(("rays", "points"), ("points", "shape"), ("shape", "scale")),
    *(("scale", "first"), ("first", "held"), ("held", "bend"), ("bend", "pose")),
    *(("pose", "order"), ("order", "knots"), ("knots", "linear")),
    *(("linear", "refine"), ("refine", "open")),
)
X_STEP, Y_STEP, WIDTH, HEIGHT = 4.0, 1.6, 3.15, 1.15


@figure("fig_5_4", needs=("fig_5_4_run",), evidence="rendered")
def fig_5_4(results):
    """Draw the stages of the code, with the count of each transition in a run."""
    ran = Ran.of(results[RUN])
    said = ran.amounts()
    drawn, axes = new_figure(height_in=6.0)
    for stage in BOXES:
        _draw_box(axes, stage, said)
    for way in WAYS:
        _draw_way(axes, *way, ran.times(*way))
    _draw_again(axes, ran.times("open", "bend"))
    _draw_ends(axes, ran)
    axes.set(
        xlim=(-1.9, 2 * X_STEP + 4.0), ylim=(-5 * Y_STEP - 1.8, 1.5), aspect="equal"
    )
    axes.axis("off")
    undrawn = ran.beyond(WAYS + (("open", "bend"),), CAN_REFUSE)
    rows = [(*way, ran.times(*way)) for way in (*WAYS, ("open", "bend"))]
    rows += [(stage, REFUSED, ran.times(stage, REFUSED)) for stage in CAN_REFUSE]
    return Drawing(
        drawn,
        columns(("from", "to", "times"), rows),
        "Flowchart of SPFC2: its stages with the functions of the code, and the count "
        "of each transition in one run of three deflections on rig A. Primary "
        "calibration goes down the left column and up the middle one; dynamic "
        "calibration goes down the right one, once for each deflection.",
        Check(
            not undrawn,
            "every transition of the run is drawn"
            if not undrawn
            else f"not drawn: {', '.join(undrawn)}",
        ),
    )


def _place(stage):
    column, row = BOXES[stage][:2]
    return X_STEP * column, -Y_STEP * row


def _draw_box(axes, stage, said):
    x, y = _place(stage)
    function = STAGES[stage].rpartition(".")[2] if stage in STAGES else HANDS
    axes.add_patch(
        patches.FancyBboxPatch(
            (x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT,
            boxstyle="round,pad=0.02,rounding_size=0.12",
            facecolor="#eef3f8" if stage in STAGES else "#fdf3e3",
            edgecolor=INK, linewidth=0.9,
        )
    )  # fmt: skip
    centred = {"ha": "center", "va": "center"}
    axes.text(x, y + 0.15, BOXES[stage][2].format(**said), fontsize=7.0, **centred)
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


def _draw_ends(axes, ran):
    """Draw where a stage can be rejected, and where a run ends."""
    colour = series(2)["color"]
    for stage in CAN_REFUSE:
        x, y = _place(stage)
        a = (x + WIDTH / 2, y - 0.3)
        axes.annotate(
            "", (a[0] + 0.6, a[1]), a, arrowprops={"arrowstyle": "-|>", "color": colour}
        )
        axes.text(a[0] + 0.62, a[1], f"no: refused  {ran.times(stage, REFUSED)}",
                  fontsize=6.5, color=colour, ha="left", va="center",
                  bbox={"fc": "white", "ec": "none", "pad": 1}, zorder=5)  # fmt: skip
    x, y = _place("open")
    low = y - HEIGHT / 2
    axes.annotate("", (x, low - 0.5), (x, low), arrowprops={"arrowstyle": "-|>"})
    axes.text(x, low - 0.55, f"calibrated camera   {ran.accepted}", fontsize=7,
              ha="center", va="top")  # fmt: skip
    x, y = _place("viewer")
    axes.text(x, y + HEIGHT / 2 + 0.12, "primary calibration, once", fontsize=7.4,
              ha="center", va="bottom", style="italic")  # fmt: skip
    x, y = _place("pose")
    axes.text(x, y + HEIGHT / 2 + 0.12, "dynamic calibration", fontsize=7.4,
              ha="center", va="bottom", style="italic")  # fmt: skip


# Where the refinement starts, and where it ends.


NAMES = {
    "before": "mirror\nas it was",
    "linear": "linear\nestimate",
    "true": "true\nsurface",
}
LOOKS = {"before": "mirror as it was", "linear": "linear estimate"}
MIN_SHOWN = 1e-8
SPREAD = 0.28


@figure("ext_linear_start", needs=BOTH, evidence="rendered")
def ext_linear_start(results):
    """Deflection at each start and where it leads; how equal the ends are."""
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    on_bench = Starts.on(results, LEVEL)
    rows = _draw_ways(left, on_bench)
    for bench, line in zip(reversed(CONTRASTED), ("--", "-"), strict=True):
        of_bench = Starts.on(results, bench)
        for start, name in LOOKS.items():
            off = np.sort(of_bench.off(start, "cost_mm2"))
            share = np.arange(1, len(off) + 1) / len(off)
            right.plot(
                100 * np.maximum(off, MIN_SHOWN), share, linestyle=line, marker="",
                color=series(list(NAMES).index(start))["color"],
                label=f"{name}, {SAID[bench]}",
            )  # fmt: skip
    right.axvline(100 * SAME, color=INK, linestyle=":", marker="", label="1 %")
    right.set(xscale="log", xlabel="Difference of the final costs (%)")
    right.set_ylabel("Share of the runs")
    legend_below(drawn, right, ncols=2)
    return Drawing(
        drawn,
        columns(("seed", "start", "start_mm", "end_mm", "cost_mm2", "steps"), rows),
        "Refinement from three starts: the linear estimate, the true surface, and the "
        "mirror before the deflection. Left: deflection at the start (hollow) and "
        "after the refinement (filled), one line for each run, at the second solved "
        "level; dotted: the true 5 mm. Right: cumulative share of the runs over the "
        "relative difference of the final cost from that of the start at the true "
        "surface.",
    )


def _draw_ways(axes, starts):
    """Rows of the data: (seed, start, start_mm, end_mm, cost_mm2, steps)."""
    rows = []
    for place, start in enumerate(NAMES):
        from_mm, to_mm, cost, steps = (
            starts.of(start, name)
            for name in ("start_mm", "deflection_mm", "cost_mm2", "steps")
        )
        at = place + SPREAD * np.linspace(-1, 1, len(from_mm))
        colour = series(place)["color"]
        axes.vlines(at, from_mm, to_mm, color=colour, linewidth=0.4)
        look = {"color": colour, "linestyle": "", "marker": "o", "markersize": 2.5}
        axes.plot(at, from_mm, **look, markerfacecolor="none")
        axes.plot(at, to_mm, **look)
        rows += [
            (seed, start, *values)
            for seed, values in enumerate(zip(from_mm, to_mm, cost, steps, strict=True))
        ]
    axes.axhline(STAGES_MM[1], color=INK, linestyle=":", marker="")
    axes.set_xticks(range(len(NAMES)))
    axes.xaxis.set_major_formatter(FixedFormatter(list(NAMES.values())))
    axes.set_ylabel("Deflection at the load (mm)")
    return rows
