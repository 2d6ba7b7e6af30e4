"""Results of section 3.1.2: recorded runs, names of parameters, quoted numbers."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.boards import (
    BIG_FOVS,
    BROKEN,
    MULTIPLIERS,
)
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import CAMERAS, LEAST_PX
from raxel.features.celect import CelectSettings
from repro.page.reader import value

NAMES = dict(zip(CAMERAS, ("fisheye", "sphere", "hyperboloid", "sheet"), strict=True))


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    broken = open_results("table_3_1_growth")
    grown = broken.one(**BROKEN["large squares with long breaks"])
    small = broken.one(**BROKEN["small squares with long breaks"])
    split = open_results("table_3_2_split")
    windows = split.conditions[0]["windows"]
    start = open_results("table_3_2_start")
    predicted = start.column("predicted")
    quoted = {
        "grown": percent(grown.column("published.success")),
        "fixed": percent(grown.column("no growth.success")),
        "small.grown": percent(small.column("published.success")),
        "small.fixed": percent(small.column("no growth.success")),
        "near_with": 100 * (split.column("published.near").mean() / windows),
        "near_without": 100 * (split.column("no averaging.near").mean() / windows),
        "cases": len(predicted),
        "agree": percent(predicted == start.column("went_wrong")),
        **of_cameras(open_results("fig_3_1_cameras")),
        **of_squares(open_results("exp_c3_big_square")),
        **of_windows(open_results("table_3_1_window")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_cameras(result):
    """Success of each camera, of small pictures, and candidates per corner."""
    large, small = (result.select(size_px=size) for size in LEAST_PX)
    ratio = large.column("candidates") / large.column("wanted")
    many = ratio[large.column("success") == 1]
    return {
        "worst.large": least_of_cameras(large),
        "worst.small": least_of_cameras(small),
        "tiny": percent(small.column("success")),
        "candidates": float(many.mean()) if len(many) else 0.0,
    }


def least_of_cameras(trials):
    """The least success of a camera in a selection of trials, in percent."""
    return min(
        percent(trials.select(camera=name).column("success")) for name in CAMERAS
    )


def of_windows(result):
    """Success with the published radius of the window, and with the ends of the range.

    The radius is a multiple of the published one.
    """
    ends = {"published": 1.0, "least": MULTIPLIERS[0], "most": MULTIPLIERS[-1]}
    runs = {
        name: result.column("success", multiplier=factor)
        for name, factor in ends.items()
    }
    return {
        "window.boards": len(runs["published"]),
        "window.smallest": ends["least"],
        "window.largest": ends["most"],
        "window.published": percent(runs["published"]),
        "window.least": percent(runs["least"]),
        "window.most": percent(runs["most"]),
    }


def of_squares(result):
    """Success with the largest and the smallest squares at the widest view."""
    fov = BIG_FOVS[0]
    sizes = result.by("squares_across", fov_deg=fov)
    return {
        "wide_fov": fov,
        "large_squares": percent(sizes[min(sizes)].column("success")),
        "small_squares": percent(sizes[max(sizes)].column("success")),
    }


def percent(flags):
    """Share of trials (n,) that are 1, in percent."""
    return 100 * float(np.mean(flags))


class Run:
    """The arrays of a recorded run (`trials.recorded`)."""

    def __init__(self, result):
        for name in [
            "steps",
            "corners",
            "edges",
            "lines",
            "merged",
            "outer",
            "grid",
            "s",
            "image",
        ]:
            setattr(self, name, result.arrays(name)[0])

    def step(self, index):
        """Of a step: centre, radius, line (R, theta), anchor."""
        row = self.steps[index]
        return row[1:3], row[3], row[4:6], row[6:8]

    def of_step(self, name, index):
        """What a step saw: (n, 2) of its `corners`, `edges` or `lines`."""
        rows = getattr(self, name)
        return rows[rows[:, 0] == index, 1:]

    def first_of(self, contour):
        """Index of the first step of a contour."""
        return int(np.flatnonzero(self.steps[:, 0] == contour)[0])

    def anchors(self, contour):
        """Anchors (n, 2) of a contour, its last one included."""
        rows = self.steps[self.steps[:, 0] == contour]
        return np.vstack((rows[:, 1:3], rows[-1:, 6:8]))


def turning_step(run):
    """The step of side 1, after the first, whose window has most near lines."""
    settings = CelectSettings()
    candidates = np.flatnonzero(run.steps[:, 0] == 0)[1:-1]

    def near(index):
        lines = run.of_step("lines", index)
        return (np.abs(lines[:, 0]) < settings.near_centre * run.s[0]).sum()

    return int(max(candidates, key=lambda i: (near(i), -i)))


def which_view(result):
    """Which of the random views is drawn, for a caption: the first that is read."""
    tried = int(result.column("tried")[0])
    return f", view {tried} of a random series: the first that is read"


SIDES = ("c1-c2", "c2-c3", "c3-c4", "c4-c1")
COUNTS = ("width", "height", "width", "height")
# Threshold -> field of CelectSettings, unit, and what it bounds.
THRESHOLDS = {
    "t1": ("split_peaks", "Hough bins", "peaks nearer than this are one"),
    "t2": ("wrap", "deg", "peaks this near to 0° and to 180° are one"),
    "t3": ("near_centre", "px", "distance of a line from the window's middle"),
    "t4": ("first_angle_deg", "deg", "angle that is too near to side 4, at c1"),
    "t5": ("edge_band", "px", "distance of edge pixels from the chosen line"),
    "t6": ("arrival", "px", "distance from the contour's end: it is reached"),
    "t7": ("corner_band", "px", "distance of candidates from the trace"),
    "t8": ("merge", "px", "candidates nearer than this are one corner"),
}


def interior(squares, border):
    """Corners between squares, less those next to a border of `border` squares."""
    return int(np.prod(np.array(squares) - 1 - 2 * border))


def line_ends(centre, radius, line):
    """Ends (2, 2) of the chord of a window that a line (R, theta in deg) cuts.

    A line beside the window has its two ends where it is nearest.
    """
    R, theta = line[0], np.radians(line[1])
    along = np.array([np.cos(theta), np.sin(theta)])
    foot = centre + R * np.array([-along[1], along[0]])
    half = np.sqrt(max(radius**2 - R**2, 0.0))
    return np.array([foot - half * along, foot + half * along])
