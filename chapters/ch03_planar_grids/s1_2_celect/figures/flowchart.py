"""Fig. 3.3: flowchart of CELECT with the stages of its code."""

from raxel.features.celect import CelectSettings
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

# Stage -> (x, y), text and function of its box.
BOXES = {
    "snap": (0, 0, "Corners $c_i$ nearest to\nthe four clicks", "snapped"),
    "window": (0, -1, "Window $A_{r,p_{cur}}$\nand its edges $S_c$", "Layers.edges"),
    "hough": (0, -2, "Hough transform", "vote"),
    "peaks": (
        0,
        -3,
        "Peaks $S_h$: suppression,\nwrap ($t_2$), averaging ($t_1$)",
        "peaks_of",
    ),
    "near": (0, -4, "Lines $S_d$ near the\ncentre ($t_3$)", "near_lines"),
    "first line": (
        1,
        -3.4,
        "First anchor: without the\nwrong contour ($t_4$)",
        "first_line",
    ),
    "next line": (1, -4.6, "Else: least turn\nfrom $\\theta_{prev}$", "next_line"),
    "anchor": (
        2,
        -4,
        "$p_{new}$: farthest forward\nin the band ($t_5$)",
        "next_anchor",
    ),
    "corners": (2, -2.5, "Candidates $n_q$\nby Harris", "Layers.corners"),
    "arrived": (2, -1, "Within $t_6$ of the\ncontour's end?", "Tracer._arrived"),
    "process": (
        2,
        0,
        "Inliers ($t_7$), merging ($t_8$),\norder along the contour",
        "processed",
    ),
}

GROWTH_PERCENT = f"{100 * CelectSettings().growth:.0f} %"
GROWN_LINE = f"no line: $r$ + {GROWTH_PERCENT}"
GROWN_ANCHOR = f"no anchor: $r$ + {GROWTH_PERCENT}"
# (from, to): label of the arrow, None for the start and the end.
ARROWS = {
    ("start", "snap"): None,
    ("snap", "window"): "",
    ("window", "hough"): "",
    ("hough", "peaks"): "",
    ("peaks", "near"): "",
    ("near", "first line"): "",
    ("near", "next line"): "",
    ("near", "window"): GROWN_LINE,
    ("first line", "anchor"): "",
    ("first line", "window"): GROWN_LINE,
    ("next line", "anchor"): "",
    ("anchor", "corners"): "",
    ("anchor", "window"): GROWN_ANCHOR,
    ("corners", "arrived"): "",
    ("arrived", "window"): "no: $p_{cur} = p_{new}$",
    ("arrived", "process"): "yes",
    ("process", "window"): "next side, then next column",
    ("process", "end"): None,
}
GROWTH = {("near", "window"), ("first line", "window"), ("anchor", "window")}
X_STEP, Y_STEP = 4.1, 1.55
WIDTH, HEIGHT = 3.0, 1.08


def transitions(result):
    """Count of each (stage, next stage) in the run."""
    return {
        tuple(name.split(" > ")): int(result.column(name)[0])
        for name in result.names()
        if " > " in name
    }


def centre_of(stage):
    """Centre (x, y) of a stage's box."""
    x, y = BOXES[stage][:2]
    return X_STEP * x, Y_STEP * y


def draw_box(axes, stage):
    """Draw the box of a stage with its function."""
    import matplotlib.patches as patches

    x, y = centre_of(stage)
    text, function = BOXES[stage][2:]
    axes.add_patch(
        patches.FancyBboxPatch(
            (x - WIDTH / 2, y - HEIGHT / 2),
            WIDTH,
            HEIGHT,
            boxstyle="round,pad=0.02,rounding_size=0.12",
            facecolor="#eef3f8",
            edgecolor="#1b1f24",
            linewidth=0.9,
        )
    )
    axes.text(x, y + 0.14, text, ha="center", va="center", fontsize=7.6)
    axes.text(
        x,
        y - HEIGHT / 2 + 0.13,
        function,
        ha="center",
        va="center",
        fontsize=6.2,
        family="monospace",
        color="#555555",
    )


def draw_arrow(axes, start, end, count):
    """Draw a straight arrow between neighbouring boxes, with its count."""
    (x0, y0), (x1, y1) = centre_of(start), centre_of(end)
    if x0 == x1:
        down = 1 if y1 < y0 else -1
        a = (x0, y0 - down * HEIGHT / 2)
        b = (x1, y1 + down * HEIGHT / 2)
        spot, side = (x0 + 0.1, (y0 + y1) / 2), "left"
    else:
        a, b = (x0 + WIDTH / 2, y0), (x1 - WIDTH / 2, y1)
        # Above the arrow if the box in the middle is the higher one, else below.
        up = 1 if (y0 < y1) == (x1 == X_STEP) else -1
        spot, side = ((a[0] + b[0]) / 2, (y0 + y1) / 2 + 0.4 * up), "center"
    axes.annotate("", b, a, arrowprops={"arrowstyle": "-|>", "color": "#1b1f24"})
    axes.text(*spot, f"{count}", fontsize=7, ha=side, va="center")


@figure("fig_3_3", needs=("fig_3_3_stages",), evidence="synthetic")
def fig_3_3(results):
    """Stages of the code, with the number of transitions in one run."""
    found = transitions(results["fig_3_3_stages"])
    drawn, axes = new_figure(height_in=6.2)
    for stage in BOXES:
        draw_box(axes, stage)
    for (start, end), label in ARROWS.items():
        if label == "" or (start, end) == ("arrived", "process"):
            draw_arrow(axes, start, end, found.get((start, end), 0))
    draw_returns(axes, found)
    axes.set(
        xlim=(-2.0, 2 * X_STEP + 1.9), ylim=(-4.6 * Y_STEP - 0.8, 1.45), aspect="equal"
    )
    axes.axis("off")
    pairs = sorted(set(ARROWS) | set(found))
    unknown = [" > ".join(p) for p in found if p not in ARROWS]
    return Drawing(
        drawn,
        {
            "from": [a for a, _ in pairs],
            "to": [b for _, b in pairs],
            "times": [found.get(p, 0) for p in pairs],
        },
        "Flowchart of CELECT: stages with the functions of the code. Numbers count "
        "the transitions in one run on the board of Fig. 3.10(b).",
        Check(
            not unknown,
            "every transition of the run is drawn"
            if not unknown
            else f"not drawn: {', '.join(unknown)}",
        ),
    )


def draw_returns(axes, found):
    """Draw the returns to the window: not arrived, growth, next contour."""
    x, y = centre_of("window")
    right = x + WIDTH / 2
    arrived, anchor, process = map(centre_of, ("arrived", "anchor", "process"))
    grown = sum(found.get(pair, 0) for pair in GROWTH)
    white = {"fc": "white", "ec": "none", "pad": 1}
    # Series, end and start of the arrow, height and text of its label.
    ways = (
        (
            2,
            (right, y),
            (arrived[0] - WIDTH / 2, arrived[1]),
            y + 0.15,
            f"no: $p_{{cur}} = p_{{new}}$   {found.get(('arrived', 'window'), 0)}",
            {},
        ),
        (
            1,
            (right, y - 0.3),
            (anchor[0] - 0.3 * WIDTH, anchor[1] + HEIGHT / 2),
            y - 1.6,
            f"no line or no $p_{{new}}$:\nwindow grows by {GROWTH_PERCENT}   {grown}",
            {"va": "center", "bbox": white},
        ),
        (
            0,
            (right, y + 0.3),
            (process[0] - WIDTH / 2, process[1]),
            process[1] + 0.1,
            f"next side, then next column   {found.get(('process', 'window'), 0)}",
            {"bbox": white},
        ),
    )
    for number, end, start, height, text, look in ways:
        arrow = {"arrowstyle": "-|>", "color": series(number)["color"]}
        axes.annotate("", end, start, arrowprops=arrow)
        look |= {"fontsize": 7, "ha": "center", "color": arrow["color"]}
        axes.text(X_STEP, height, text, **look)
    ends = (
        ("snap", "start", "image, clicks, counts"),
        ("process", "end", "corners in order, or the\ncontour that failed"),
    )
    for stage, kind, text in ends:
        x, y = centre_of(stage)
        top, far = (x, y + HEIGHT / 2), (x, y + HEIGHT / 2 + 0.42)
        start, end = (far, top) if kind == "start" else (top, far)
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>"})
        axes.text(x, far[1] + 0.05, text, fontsize=7.4, ha="center", va="bottom")
