"""Fig. 5.4: SPFC2 as a flowchart of the stages that its code runs through."""

import matplotlib.patches as patches

from chapters.ch05_flexible_mirror.s2_method.results import RUN, Ran
from chapters.ch05_flexible_mirror.s2_method.trials.run import REFUSED, STAGES
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

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
