"""Results of section 3.1.2: recorded runs, parameter names, quoted numbers."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.boards import BROKEN, MULTIPLIERS
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import CAMERAS, MIN_SQUARE_PX
from raxel.features.celect import CelectSettings
from repro.page.reader import value

NAMES = dict(zip(CAMERAS, ("fisheye", "sphere", "hyperboloid", "sheet"), strict=True))


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    broken = open_results("table_3_1_growth")
    grown = broken.one(**BROKEN["large squares with long breaks"])
    quoted = {
        "grown": percent(grown.column("published.success")),
        "fixed": percent(grown.column("no growth.success")),
        **of_cameras(open_results("fig_3_1_cameras")),
        **of_windows(open_results("table_3_1_window")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_cameras(result):
    """Success of the worst camera, with large and with small squares."""
    large, small = (result.select(size_px=size) for size in MIN_SQUARE_PX)
    return {
        "worst.large": worst_camera_success(large),
        "worst.small": worst_camera_success(small),
    }


def worst_camera_success(trials):
    """Return the lowest success of a camera in a selection of trials, in percent."""
    return min(
        percent(trials.select(camera=name).column("success")) for name in CAMERAS
    )


def of_windows(result):
    """Success at both ends of the range of window radii."""
    ends = {"least": MULTIPLIERS[0], "most": MULTIPLIERS[-1]}
    return {
        f"window.{name}": percent(result.column("success", multiplier=factor))
        for name, factor in ends.items()
    }


def percent(flags):
    """Share of trials (n,) with the flag 1, in percent."""
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
        """Rows (n, 2) of `corners`, `edges` or `lines` of one step."""
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
    """Return the later step on side 1 with most lines near the window's centre."""
    settings = CelectSettings()
    candidates = np.flatnonzero(run.steps[:, 0] == 0)[1:-1]

    def near(index):
        lines = run.of_step("lines", index)
        return (np.abs(lines[:, 0]) < settings.near_centre * run.s[0]).sum()

    return int(max(candidates, key=lambda i: (near(i), -i)))


def which_view(result):
    """Part of a caption: the number of the drawn view, the first correct one."""
    tried = int(result.column("tried")[0])
    return f", view {tried} of a random series (the first correct one)"


SIDES = ("c1-c2", "c2-c3", "c3-c4", "c4-c1")
COUNTS = ("width", "height", "width", "height")
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
