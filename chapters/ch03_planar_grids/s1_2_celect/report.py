"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.experiment import (
    BROKEN,
    CAMERAS,
    MIN_SQUARE_PX,
    MULTIPLIERS,
)
from raxel.features.celect import CelectSettings, angle_difference
from repro.page import new_figure, series, value
from repro.run import (
    Check,
    Drawing,
    Measured,
    Table,
    columns,
    figure,
    proportion,
    table,
)

# Results of section 3.1.2: recorded runs, parameter names, quoted numbers.


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    growth, windows = (open_results(f"table_3_1_{n}") for n in ("growth", "window"))
    broken = growth.one(**BROKEN["large squares with long breaks"])
    cameras = open_results("fig_3_1_cameras")
    large, small = (
        min(percent(runs) for runs in cameras.by("camera", size_px=size).values())
        for size in MIN_SQUARE_PX
    )
    quoted = {
        "grown": percent(broken, "published"),
        "fixed": percent(broken, "no growth"),
        "worst.large": large,
        "worst.small": small,
        "window.least": percent(windows.one(multiplier=MULTIPLIERS[0])),
        "window.most": percent(windows.one(multiplier=MULTIPLIERS[-1])),
    }
    for name, number in quoted.items():
        value(name, number)


def percent(trials, *settings):
    """Share of correct boards in a selection of trials, in percent."""
    return 100 * float(trials.column(*settings, "success").mean())


ARRAYS = ("steps", "corners", "edges", "lines", "outer", "grid", "s", "image")


class Run:
    """The arrays of a recorded run (`trials.recorded`)."""

    def __init__(self, result):
        for name in ARRAYS:
            setattr(self, name, result.arrays(name)[0])

    def step(self, index):
        """Of a step: centre, radius, line (R, theta), anchor."""
        row = self.steps[index]
        return row[1:3], row[3], row[4:6], row[6:8]

    def of_step(self, name, index):
        """Rows (n, 2) of `corners`, `edges` or `lines` of one step."""
        rows = getattr(self, name)
        return rows[rows[:, 0] == index, 1:]

    def anchors(self, contour):
        """Anchors (n, 2) of a contour, its last one included."""
        rows = self.steps[self.steps[:, 0] == contour]
        return np.vstack((rows[:, 1:3], rows[-1:, 6:8]))


def turning_step(run):
    """Return the later step on side 1 with most lines near the window's centre."""
    candidates = np.flatnonzero(run.steps[:, 0] == 0)[1:-1]
    near = np.abs(run.lines[:, 1]) < CelectSettings().near_centre * run.s[0]
    counts = np.bincount(run.lines[near, 0].astype(int), minlength=len(run.steps))
    return int(candidates[counts[candidates].argmax()])


def which_view(result):
    """Part of a caption: the number of the drawn view, the first correct one."""
    tried = int(result.column("tried")[0])
    return f", view {tried} of a random series (the first correct one)"


# Threshold -> field of CelectSettings, unit, bounded quantity.
THRESHOLDS = {
    "t1": ("split_peaks", "Hough bins", "distance of peaks that are averaged"),
    "t2": ("wrap", "deg", "distance to 0° and 180° of peaks that are merged"),
    "t3": ("near_centre", "px", "distance of a line from the window's centre"),
    "t4": ("first_angle_deg", "deg", "angle to side 4 of lines excluded at c1"),
    "t5": ("edge_band", "px", "distance of edge pixels from the chosen line"),
    "t6": ("arrival", "px", "distance to the contour's end that ends the trace"),
    "t7": ("corner_band", "px", "distance of candidates from the trace"),
    "t8": ("merge", "px", "distance of candidates that are averaged"),
}


def interior(squares, border):
    """Number of interior corners of a board with a border of `border` squares."""
    return int(np.prod(np.array(squares) - 1 - 2 * border))


def line_ends(centre, radius, line):
    """Ends (2, 2) of the chord of a window that a line (R, theta in deg) cuts.

    For a line outside the window both ends are its nearest point.
    """
    R, theta = line[0], np.radians(line[1])
    along = np.array([np.cos(theta), np.sin(theta)])
    foot = centre + R * np.array([-along[1], along[0]])
    half = np.sqrt(max(radius**2 - R**2, 0.0))
    return np.array([foot - half * along, foot + half * along])


# Fig. 3.3: flowchart of CELECT with the stages of its code.


# Stage -> (x, y), text and function of its box.
BOXES = {
    "snap": (0, 0, "Corners $c_i$ nearest to\nthe four clicks", "snapped"),
    "window": (0, -1, "Window $A_{r,p_{cur}}$\nand its edges $S_c$", "Layers.edges"),
    "hough": (0, -2, "Hough transform", "vote"),
    "peaks": (0, -3, "Peaks $S_h$, wrapped ($t_2$)\nand averaged ($t_1$)", "peaks_of"),
    "near": (0, -4, "Lines $S_d$ near the\ncentre ($t_3$)", "near_lines"),
    "first line": (1, -3.4, "First anchor: no wrong\ncontour ($t_4$)", "first_line"),
    "next line": (1, -4.6, "Else: smallest turn\nfrom $\\theta_{prev}$", "next_line"),
    "anchor": (2, -4, "$p_{new}$: farthest forward\nin band ($t_5$)", "next_anchor"),
    "corners": (2, -2.5, "Candidates $n_q$\nby Harris", "Layers.corners"),
    "arrived": (2, -1, "Within $t_6$ of the\ncontour's end?", "Tracer._arrived"),
    "process": (2, 0, "Inliers ($t_7$), merged ($t_8$)\nand ordered", "processed"),
}

GROWTH_PERCENT = f"{100 * CelectSettings().growth:.0f} %"
STRAIGHT = (
    ("snap", "window"),
    ("window", "hough"),
    ("hough", "peaks"),
    ("peaks", "near"),
    ("near", "first line"),
    ("near", "next line"),
    ("first line", "anchor"),
    ("next line", "anchor"),
    ("anchor", "corners"),
    ("corners", "arrived"),
    ("arrived", "process"),
)
GROWTH = (("near", "window"), ("first line", "window"), ("anchor", "window"))
OTHER_RETURNS = (("arrived", "window"), ("process", "window"))
ARROWS = {("start", "snap"), *STRAIGHT, *GROWTH, *OTHER_RETURNS, ("process", "end")}
X_STEP, Y_STEP = 4.1, 1.55
WIDTH, HEIGHT = 3.0, 1.08


def centre_of(stage):
    """Centre (x, y) of a stage's box."""
    x, y = BOXES[stage][:2]
    return X_STEP * x, Y_STEP * y


def draw_box(axes, stage):
    """Draw the box of a stage with its function."""
    import matplotlib.patches as patches

    x, y = centre_of(stage)
    text, function = BOXES[stage][2:]
    box = {"boxstyle": "round,pad=0.02,rounding_size=0.12", "linewidth": 0.9}
    corner = (x - WIDTH / 2, y - HEIGHT / 2)
    colours = {"facecolor": "#eef3f8", "edgecolor": "#1b1f24"}
    axes.add_patch(patches.FancyBboxPatch(corner, WIDTH, HEIGHT, **box, **colours))
    look = {"ha": "center", "va": "center"}
    axes.text(x, y + 0.14, text, fontsize=7.6, **look)
    look |= {"fontsize": 6.2, "family": "monospace", "color": "#555555"}
    axes.text(x, y - HEIGHT / 2 + 0.13, function, **look)


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
    result = results["fig_3_3_stages"]
    found = {
        tuple(name.split(" > ")): int(result.column(name)[0])
        for name in result.names()
        if " > " in name
    }
    drawn, axes = new_figure(height_in=6.2)
    for stage in BOXES:
        draw_box(axes, stage)
    for start, end in STRAIGHT:
        draw_arrow(axes, start, end, found.get((start, end), 0))
    draw_returns(axes, found)
    axes.set(
        xlim=(-2.0, 2 * X_STEP + 1.9), ylim=(-4.6 * Y_STEP - 0.8, 1.45), aspect="equal"
    )
    axes.axis("off")
    pairs = sorted(ARROWS | set(found))
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
        ("snap", "-|>", "image, clicks, counts"),
        ("process", "<|-", "corners in order, or the\ncontour that failed"),
    )
    look = {"fontsize": 7.4, "ha": "center", "va": "bottom"}
    for stage, style, text in ends:
        x, y = np.add(centre_of(stage), (0, HEIGHT / 2))
        arrow = {"arrowstyle": style}
        axes.annotate(text, (x, y), (x, y + 0.45), arrowprops=arrow, **look)


# Figs 3.1, 3.2 and 3.4, from recorded runs.


BLUE, RED, GREEN, PINK = (series(i)["color"] for i in range(4))
YELLOW = series(5)["color"]


def draw_image(axes, image):
    """Draw the image of a run, with axes in pixels."""
    axes.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.grid(False)
    axes.set(xlabel="u (px)", ylabel="v (px)")


def mark(axes, point, text, offset):
    """Label a point, with an arrow."""
    look = {"xytext": offset, "textcoords": "offset points", "fontsize": 9.5}
    box = {"boxstyle": "round,pad=0.15", "fc": "white", "alpha": 0.9}
    arrow = {"arrowstyle": "-", "color": "white", "linewidth": 1.0}
    axes.annotate(text, point, color="black", bbox=box, arrowprops=arrow, **look)


def draw_window(axes, run, index, band):
    """Draw a window: image, circle, edge pixels, chosen line with its band."""
    import matplotlib.patches as patches

    centre, radius, line, anchor = run.step(index)
    draw_image(axes, run.image)
    axes.add_patch(patches.Circle(centre, radius, fill=False, color=YELLOW, lw=2))
    edges, corners = (run.of_step(name, index).T for name in ("edges", "corners"))
    axes.plot(*edges, "s", color=BLUE, ms=2.4, label="edge pixels $S_c$")
    ends = line_ends(centre, radius, line)
    axes.plot(*ends.T, "-", color=RED, linewidth=1.6, label="line $L_w$")
    for side in (-1, 1):
        shifted = line_ends(centre, radius, line + [side * band, 0])
        axes.plot(*shifted.T, ":", color=RED, linewidth=1.0)
    axes.plot(*corners, "x", color=PINK, ms=9, mew=2, label="candidates $n_q$")
    axes.plot(*centre, "o", color=YELLOW, ms=6)
    axes.plot(*anchor, "o", color=GREEN, ms=6)
    (u, v), across = centre, 2.6 * np.array([-radius, radius])
    axes.set(xlim=u + across, ylim=v - across)


def towards(axes, start, end, text, colour):
    """Draw a labelled dashed line from a corner towards another one."""
    axes.plot(*np.array([start, end]).T, "--", color=colour, linewidth=1.3)
    reach = np.linalg.norm(end - start)
    width = abs(np.diff(axes.get_xlim())[0])
    spot = start + (end - start) / reach * min(reach, 0.36 * width)
    draw_label(axes, spot, text, colour)


def draw_label(axes, spot, text, colour):
    """Label a line at a point."""
    box = {"boxstyle": "round,pad=0.12", "fc": colour, "alpha": 0.85}
    axes.text(*spot, text, color="black", fontsize=9, ha="center", bbox=box)


@figure("fig_3_1", needs=("fig_3_1_run", "fig_3_1_cameras"), evidence="rendered")
def fig_3_1(results):
    """The first window of a run, at the first corner."""
    run = Run(results["fig_3_1_run"])
    drawn, (whole, axes) = new_figure(1, 2, height_in=3.9)
    draw_window(axes, run, 0, CelectSettings().edge_band * run.s[0])
    corners = run.outer
    towards(axes, corners[0], corners[1], "$L_1$", GREEN)
    towards(axes, corners[0], corners[3], "$L_4$", PINK)
    mark(axes, run.step(0)[0], "$p_{cur} = c_1$", (-62, 26))
    mark(axes, run.step(0)[3], "$p_{new}$", (-44, 20))
    axes.legend(loc="lower left", fontsize=7.5)
    axes.set_title("Window at $c_1$")
    draw_image(whole, run.image)
    whole.plot(*corners[[0, 1, 2, 3, 0]].T, "--", color=GREEN, linewidth=1.3)
    for k, corner in enumerate(corners):
        mark(whole, corner, f"$c_{k + 1}$", (8, 8))
        middle = (corner + corners[(k + 1) % 4]) / 2
        draw_label(whole, middle, f"$L_{k + 1}$", GREEN)
    for contour in range(len(run.s)):
        colour = YELLOW if contour < 4 else BLUE
        whole.plot(*run.anchors(contour).T, ".-", color=colour, lw=1, ms=3)
    whole.set_title("Corners, side lines, traces")
    numbers = ("u_px", "v_px", "radius_px", "R_px", "theta_deg")
    data = {
        "step": list(range(len(run.steps))),
        "contour": run.steps[:, 0].astype(int).tolist(),
        **dict(zip(numbers, run.steps[:, 1:6].T.tolist(), strict=True)),
    }
    return Drawing(
        drawn,
        data,
        "Quantities of CELECT in a run on a rendered fisheye image"
        f"{which_view(results['fig_3_1_run'])}. Left: "
        "corners $c_i$, side lines $L_i$, anchors on the four sides (yellow) and "
        "in the columns (blue). Right: the first window, of radius $r = s_1$, "
        "with edge pixels $S_c$, the line $L_w$ and its band $t_5$ (dotted), "
        "candidate corners $n_q$ and the next anchor $p_{new}$.",
        window_check(run),
    )


def window_check(run):
    """Check that every anchor is within its window and within t5 of its line."""
    settings, ratios = CelectSettings(), []
    for index in np.flatnonzero(run.steps[1:, 0] == run.steps[:-1, 0]):
        centre, radius, line, anchor = run.step(index)
        start, end = line_ends(centre, radius, line)
        along = (end - start) / np.linalg.norm(end - start)
        off = abs(np.cross(along, anchor - start))
        s = run.s[int(run.steps[index, 0])]
        band = max(settings.edge_band * s, settings.min_band_px)
        ratios += [off / band, np.linalg.norm(anchor - centre) / radius]
    return Check(
        max(ratios) <= 1 + 1e-9,
        f"all {len(run.steps)} anchors are in their window and within t5 of their line",
    )


@figure("fig_3_2", needs=("fig_3_1_run", "fig_3_1_cameras"), evidence="rendered")
def fig_3_2(results):
    """A later window: the line nearest in orientation to the previous one."""
    run = Run(results["fig_3_1_run"])
    settings = CelectSettings()
    index = turning_step(run)
    drawn, (axes, hough) = new_figure(1, 2, height_in=3.9, width_ratios=(1.25, 1))
    s = run.s[int(run.steps[index, 0])]
    draw_window(axes, run, index, settings.edge_band * s)
    centre, radius, line, anchor = run.step(index)
    previous, before = run.steps[index - 1, 1:3], run.steps[index - 1, 5]
    axes.plot(*previous, "o", color=RED, ms=6)
    along = np.array([np.cos(np.radians(before)), np.sin(np.radians(before))])
    tip = centre + 1.25 * radius * (along * np.sign(along @ (centre - previous)))
    arrow = {"arrowstyle": "->", "color": GREEN, "linewidth": 1.6}
    axes.annotate("", tip, centre, arrowprops=arrow)
    mark(axes, tip, r"$\theta_{prev}$", (-44, 12))
    mark(axes, previous, "$p_{prev}$", (-40, 22))
    mark(axes, centre, "$p_{cur}$", (-8, 30))
    mark(axes, anchor, "$p_{new}$", (8, 24))
    axes.legend(loc="lower left", fontsize=7.5)
    axes.set_title("Window at $p_{cur}$")
    lines = run.of_step("lines", index)
    near = settings.near_centre * s
    hough.axhspan(-near, near, color=GREEN, alpha=0.15, label="$|R| < t_3$")
    hough.plot(*lines[:, ::-1].T, "o", color=BLUE, label="peaks $S_h$")
    chosen = {"color": RED, "ms": 11, "fillstyle": "none", "label": "chosen $h_p$"}
    hough.plot(*line[::-1], "o", **chosen)
    hough.axvline(before, color=GREEN, linestyle="--", label=r"$\theta_{prev}$")
    hough.set(
        xlim=(0, 180),
        ylim=(-radius, radius),
        xlabel=r"Orientation $\theta$ (deg)",
        ylabel="Distance $R$ from the centre (px)",
        title="Lines in Hough space",
    )
    hough.legend(loc="upper right", fontsize=7.5)
    return Drawing(
        drawn,
        {
            "R_px": lines[:, 0].tolist(),
            "theta_deg": lines[:, 1].tolist(),
            "chosen": [bool(np.allclose(row, line)) for row in lines],
        },
        "A window away from the corners, in the same run. Left: quantities as in "
        "Fig. 3.1, with the previous anchor and orientation. Right: the lines of "
        "this window in Hough space. Of the lines with $|R| < t_3$, the one "
        "nearest in orientation to the previous line is chosen (3.11).",
        turn_check(run),
    )


def turn_check(run):
    """Check (3.11) at every step except the first of a contour."""
    nearest = []
    for index in 1 + np.flatnonzero(run.steps[1:, 0] == run.steps[:-1, 0]):
        lines, before = run.of_step("lines", index), run.steps[index - 1, 5]
        limit = CelectSettings().near_centre * run.s[int(run.steps[index, 0])]
        turns = angle_difference(lines[np.abs(lines[:, 0]) < limit, 1], before)
        nearest.append(
            angle_difference(run.steps[index, 5], before) <= turns.min() + 1e-9
        )
    return Check(
        all(nearest),
        f"the line nearest in orientation was chosen at all {len(nearest)} later steps",
    )


@figure("fig_3_4", needs=("fig_3_4_run",), evidence="rendered")
def fig_3_4(results):
    """Candidates and corners of a run on a mirror image."""
    run = Run(results["fig_3_4_run"])
    drawn, (traces, corners) = new_figure(1, 2, height_in=3.9)
    raw = np.unique(run.corners[:, 1:], axis=0)
    low, high = raw.min(axis=0) - 20, raw.max(axis=0) + 20
    for axes in (traces, corners):
        draw_image(axes, run.image)
        axes.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    for contour in range(len(run.s)):
        traces.plot(*run.anchors(contour).T, ".-", color=YELLOW, lw=1, ms=3)
    traces.plot(*raw.T, "x", color=RED, ms=4)
    traces.set_title(f"Traces, {len(raw)} candidates")
    grid = run.grid.reshape(-1, 2)
    corners.plot(*grid.T, "o", color=RED, ms=5, fillstyle="none")
    corners.set_title(f"{len(grid)} corners")
    order = {
        "row": np.repeat(np.arange(len(run.grid)), run.grid.shape[1]).tolist(),
        "column": np.tile(np.arange(run.grid.shape[1]), len(run.grid)).tolist(),
        "u_px": grid[:, 0].tolist(),
        "v_px": grid[:, 1].tolist(),
    }
    largest = float(results["fig_3_4_run"].column("max_px")[0])
    return Drawing(
        drawn,
        order,
        "CELECT on a rendered image of a hyperboloidal mirror"
        f"{which_view(results['fig_3_4_run'])}. Left: anchors and "
        "all candidate corners, several per corner. Right: corners after "
        "merging.",
        Check(
            len(raw) > len(grid) and largest <= 8,
            f"{len(raw)} candidates were merged into {len(grid)} corners, none "
            f"more than {largest:.1f} px from its true position",
        ),
    )


# Tables 3.1 and 3.2, and the success of CELECT with four cameras.


@table("table_3_1", needs=("fig_3_1_run", "table_3_1_window"), evidence="synthetic")
def table_3_1(results):
    """The formula of each side's window radius, and its value in the run."""
    divisor = CelectSettings().radius_divisor
    run = Run(results["fig_3_1_run"])
    sides = np.linalg.norm(np.roll(run.outer, -1, axis=0) - run.outer, axis=1)
    height, width = run.grid.shape[:2]
    counts = np.array([width, height, width, height])
    return Table(
        {
            "Radius": [f"$s_{i}$" for i in range(1, 5)],
            "Formula": [
                rf"$\lvert c_{i} - c_{i % 4 + 1} \rvert / ({divisor:g}\,{count})$"
                for i, count in enumerate("whwh", 1)
            ],
            "Length of the side (px)": sides.tolist(),
            "Corners": counts.tolist(),
            "Run of Fig. 3.1 (px)": run.s[:4].tolist(),
        },
        "Window radius on the four sides: formula, and value in the run of Fig. 3.1.",
        Check(
            bool(np.allclose(sides / (divisor * counts), run.s[:4])),
            "the run's radii are those of the formula",
        ),
        printed={"Formula": [f"t3_1_s{i}" for i in range(1, 5)]},
    )


@table("table_3_2", needs=("fig_3_1_run", "table_3_2_start"), evidence="synthetic")
def table_3_2(results):
    """All thresholds, with unit and value on side 1 of the run."""
    settings = CelectSettings()
    side_1 = float(Run(results["fig_3_1_run"]).s[0])

    def on_side_1(name, field):
        """(fraction of s_1, value on side 1) of a threshold; t4 is no fraction."""
        number = getattr(settings, field)
        return (None, number) if name == "t4" else (number, number * side_1)

    rows = [
        (f"$t_{name[1]}$", bounds, *on_side_1(name, field), unit, f"`{field}`")
        for name, (field, unit, bounds) in THRESHOLDS.items()
    ]
    names = (
        "Threshold", "Bounded quantity", "Fraction of $s_i$", "Side 1", "Unit",
        "Field of `CelectSettings`",
    )  # fmt: skip
    return Table(
        columns(names, rows),
        "Thresholds of CELECT. All except $t_4$ are fractions of the window radius "
        "$s_i$. Side 1: value in the run of Fig. 3.1.",
        printed={
            "Fraction of $s_i$": [
                None if name == "t4" else f"t3_2_{name}" for name in THRESHOLDS
            ],
            "Side 1": [f"t3_2_{name}" if name == "t4" else None for name in THRESHOLDS],
        },
    )


@table("ext_celect_cameras", needs=("fig_3_1_cameras",), evidence="rendered")
def camera_table(results):
    """Share of correct boards for each camera and smallest square."""
    result = results["fig_3_1_cameras"]

    rows = []
    names = ("fisheye", "sphere", "hyperboloid", "sheet")
    for camera, name in zip(CAMERAS, names, strict=True):
        runs = result.by("size_px", camera=camera).values()
        shares = [proportion(of_size.column("success"))[:3] for of_size in runs]
        rows.append((name, *(Measured(*(100 * np.array(s))) for s in shares)))
    heads = [f"Correct, squares from {side} px (%)" for side in MIN_SQUARE_PX.values()]
    return Table(
        columns(("Camera", *heads), rows),
        "Share of correct boards for four cameras and two image sizes, with exact "
        f"95 % intervals, from {result.trials_per_condition} random poses each.",
    )
