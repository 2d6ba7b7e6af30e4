"""A figure for each case: a pair of runs side by side, and what became of all runs."""

from collections import Counter

from chapters.ch03_planar_grids.ext_why_it_fails.figures.drawing import (
    draw_overview,
    draw_stages,
    draw_window,
    window_legend,
)
from chapters.ch03_planar_grids.ext_why_it_fails.results import (
    counted,
    shares_of,
    stages_of,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import CASES
from chapters.ch03_planar_grids.ext_why_it_fails.trials.windows import OVERVIEW, WINDOW
from repro.page.style import figure as new_figure
from repro.run.experiment import figures
from repro.run.outcomes import Drawing


def example(stages, drawn):
    """The first trial in which the drawn levels come out as they usually do."""
    usual = {level: Counter(stages[level]).most_common(1)[0][0] for level in drawn}
    outcomes = zip(*(stages[level] for level in drawn), strict=True)
    as_usual = [of_trial == tuple(usual.values()) for of_trial in outcomes]
    return as_usual.index(True) if any(as_usual) else 0


# Case -> label of the levels, and the caption.
SHOWN = {
    # The edge of the sheet too close to the outermost corners.
    "clearance": (
        "Squares from the outermost corners to the edge of the sheet (1)",
        "Clearance. Top: the picture with the anchors of every contour; below: "
        "the window in which the trace was lost, and the same place where it "
        "was not. Bars: what became of the random variations, by how far the "
        "sheet goes on beyond the outermost corners.",
    ),
    # The right contour within t4 of L4.
    "first_corner": (
        "Arc of the board (deg), clicked first: c2, in the last bar c1",
        "First corner, first condition: the right contour must not be within "
        "15° of the line from the fourth corner to the first. It is where the "
        "fourth side is an arc of more than 150°.",
    ),
    # The wrong contour more than t4 from L4, and closer to L1.
    "wrong_contour": (
        "Bow of the columns (deg), clicked first: c1, in the last bar c2",
        "First corner, second condition: the wrong contour must not be more "
        "than 15° from L4 and closer to L1 than the right one. From a bow of "
        "2° on it is.",
    ),
    # Eight ways to click one picture.
    "direction": (
        "First corner, and direction of the clicks",
        "Direction of tracing: one half ring clicked from each corner, "
        "clockwise (cw) and counterclockwise (ccw).",
    ),
    # Windows too small and too large.
    "window": (
        "Radius of the window over the published one (1)",
        "Size of the window, on an arc of 130° with noise of 10 grey levels. "
        "The thresholds stay as they are.",
    ),
    # Large squares on a strong bend.
    "curvature": (
        "Squares along the arc of 120°, and across it (1)",
        "Curvature: one bend divided into fewer or more squares. The window "
        "grows with the squares, the bend within it as well.",
    ),
    # Squares that grow along a contour.
    "size_variation": (
        "Largest over smallest square of a contour (1)",
        "Variation of size: the window and t8 follow the mean square of a "
        "side. Corners of the smallest squares are merged.",
    ),
    # Blur, and noise.
    "blur_noise": (
        "SD of the blur (px), SD of the noise (grey levels)",
        "Blur and noise on the ordinary board with squares of about 55 px.",
    ),
}


@figures(
    {
        "ext_why_clearance": ("ext_why_clearance",),
        "ext_why_first_corner": ("ext_why_first_corner",),
        "ext_why_wrong_contour": ("ext_why_wrong_contour",),
        "ext_why_direction": ("ext_why_direction",),
        "ext_why_window": ("ext_why_window",),
        "ext_why_curvature": ("ext_why_curvature",),
        "ext_why_size_variation": ("ext_why_size_variation",),
        "ext_why_blur_noise": ("ext_why_blur_noise",),
    },
    evidence="rendered",
)
def draw_case(results, identifier):
    """Overview and window of the drawn levels, and bars of all levels."""
    case, result = identifier.removeprefix("ext_why_"), results[identifier]
    label, caption = SHOWN[case]
    drawn = CASES[case]["drawn"]
    stages = stages_of(result)
    trial = example(stages, drawn.values())
    figure_, panels = new_figure(
        3,
        len(drawn),
        height_in=8.4 if len(drawn) == 2 else 6.9,
        height_ratios=(3, 3, 2),
    )
    for place, (title, level) in enumerate(drawn.items()):
        kept = kept_of(result, level, trial)
        draw_overview(panels[0, place], kept, title)
        panels[0, place].set_xlabel(stages[level][trial])
        if kept["cut"].size:
            draw_window(panels[1, place], kept)
        else:
            panels[1, place].set_axis_off()
    grid = panels[2, 0].get_gridspec()
    for panel in panels[2]:
        panel.remove()
    draw_stages(figure_.add_subplot(grid[2, :]), shares_of(stages), label)
    figure_.legend(*window_legend(), loc="outside lower center", ncols=3)
    return Drawing(figure_, counted(stages), caption)


def kept_of(result, level, trial):
    """Arrays of one level of one trial."""
    return {
        part: result.arrays(f"{level}.{part}")[trial] for part in (*OVERVIEW, *WINDOW)
    }
