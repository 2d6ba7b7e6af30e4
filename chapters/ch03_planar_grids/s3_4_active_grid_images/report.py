"""Results of this page read: values of the prose, figures, tables."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.experiment import (
    MM_PER_PX as STRAIGHT_MM_PER_PX,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.scenes import MM_PER_PX, rig_of
from repro.page import look_of, new_figure, value
from repro.run import Case, Check, Drawing, Measured, Table, columns, figure, table

# Results of section 3.3.4 by simulated run, and the numbers that its prose quotes.


CORNERS, FAR = "table_3_8_corners", "exp_c3_params_square"
FILTERED = "exp_c3_active_no_params"
LINES, HALF_PITCH = "fig_3_17_lines", "exp_c3_pitch_vertical"
FACETS = "fig_3_18_facets"
NATIVE = "exp_c3_t38_native"
BOTH_PIXELS = ("table_3_8_corners", "exp_c3_t38_native")
OF_CORNERS = ("table_3_8_corners", "exp_c3_params_square")
OF_LINES = ("fig_3_17_lines", "exp_c3_pitch_vertical")
# Questions that the text does not settle: option in the registry -> name in the trials.
NAMES = {
    "opencv_window": {"full window": "OpenCV", "half window": "OpenCV half"},
    "active_corner": {
        "four nearest pixels": "four nearest pixels",
        "local fit": "local fit",
    },
    "lens_left": {"as left by Zhang's method": "", "true lens": "true_lens."},
    "undistorted_bits": {"8 bits": "near", "16 bits": "16 bits"},
    "edge_blur": {
        "as on the camera's own pixels": "near",
        "as on larger pixels": "sharp",
    },
    "picture_pixels": {"binned 3 x 3": CORNERS, "native pixels": NATIVE},
    "room_view": {"long wall": "long wall", "corner": "corner"},
    "line_points": {
        "found in the picture": "found",
        "projected from truth": "projected",
    },
    "lines_of_a_picture": {"the worst one": np.max, "the median one": np.median},
    "static_grid": {"all facets together": "across", "each facet alone": "within"},
}
METHODS = ("derivative", "OpenCV", "saddle point", "active grid")
FAR_CASE = "far"
CASES = ("near", FAR_CASE)
VECTOR_SCALE = 200  # of Fig. 3.16


class Corners:
    """Table 3.8 in one interpretation. ran: its experiment; options: by question."""

    def __init__(self, ran, options=None, case=None):
        self.taken = Case(NAMES, options)
        changed = (self.taken[q] for q in ("undistorted_bits", "edge_blur"))
        self.case = case or next((name for name in changed if name != "near"), "near")
        self.trials = ran.select(case=self.case)

    def name(self, method):
        """Return the trial's name of a method."""
        questions = {"active grid": "active_corner", "OpenCV": "opencv_window"}
        return self.taken[questions[method]] if method in questions else method

    def statistic(self, method, which):
        """Return the mean or SD (runs,) px of the residuals with the best setting."""
        return self.trials.column(
            f"{self.name(method)}.{self.taken['lens_left']}{which}"
        )

    def arrays(self, method, which):
        """Return an array of each run."""
        return self.trials.arrays(f"{self.name(method)}.{which}")

    def settings(self, name):
        """Return the windows or blurs (n,) that were tried."""
        return np.array(self.trials.conditions[0][name])

    def curve(self, method):
        """Return (windows (n,), mean residual (n,)) of each run, valid windows only."""
        windows = self.settings("windows")
        best = [over_blurs(means) for means in self.arrays(method, "means")]
        return [(windows[np.isfinite(b)], b[np.isfinite(b)]) for b in best]

    def best_window(self, method):
        """Return the window (px) of the smallest mean residual of each run.

        OpenCV's half windows count as its function takes them.
        """
        return np.array([w[m.argmin()] for w, m in self.curve(method)])

    def best_blur(self):
        """Return the blur SD (px) of the saddle point method's best setting, by run."""
        means = self.arrays("saddle point", "means")
        return self.settings("blurs")[[one.min(axis=1).argmin() for one in means]]


def filtered(ran, case, which, options=None):
    """Return the active grid's mean residual (runs,) px near or far, with a filter."""
    taken = Case(NAMES, options)
    name = f"{which}.{taken['active_corner']}.{taken['lens_left']}mean"
    return ran.select(case=case).column(name)


def corners_of(results, options=None):
    """Return Table 3.8 in one interpretation, from the experiment with its pixels."""
    taken = Case(NAMES, options)
    return Corners(results[taken["picture_pixels"]], options)


def over_blurs(means):
    """Return mean residuals (windows,) with the best blur, where blurs were tried."""
    return means.min(axis=0) if means.ndim == 2 else means


class RoomLines(NamedTuple):
    """The edges of one remapped room. Shares of length, degrees; (edges,) each."""

    before: np.ndarray
    after: np.ndarray
    vertical: np.ndarray
    lean: np.ndarray
    predicted: np.ndarray
    place: np.ndarray
    pitch: float


def lines_of(ran, options=None, **condition):
    """Return `RoomLines` of each run that matches; options: by question."""
    kind, trials = Case(NAMES, options)["line_points"], ran.select(**condition)
    bends = f"before.{kind}", f"after.{kind}"
    others = "vertical", "lean_deg", "predicted_deg", "place"
    arrays = [trials.arrays(name) for name in (*bends, *others)]
    pitches = map(float, trials.column("pitch_deg"))
    return [RoomLines(*one) for one in zip(*arrays, pitches, strict=True)]


def spread_between(lines, of):
    """Return the angle (deg) between the leftmost and the rightmost vertical.

    of: their inclinations (edges,), found or predicted.
    """
    upright = np.flatnonzero(lines.vertical)
    x = lines.place[upright, 0]
    left, right = upright[x.argmin()], upright[x.argmax()]
    return float(of[right] - of[left])


def spread_gap(lines):
    """Return the difference (deg) of that angle from the predicted one."""
    return abs(
        spread_between(lines, lines.lean) - spread_between(lines, lines.predicted)
    )


def percent(share):
    """Return a share in percent."""
    return 100 * float(share)


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    wall = {"view": "long wall"}
    found = lines_of(open_results(LINES), **wall)
    half = lines_of(open_results(HALF_PITCH))
    rounded_less = Corners(open_results(CORNERS), {"undistorted_bits": "16 bits"})
    measured = open_results(FACETS).select().arrays("corner_squares")
    quoted = {
        "before.worst": percent(np.median([x.before.max() for x in found])),
        "after.worst": percent(np.median([x.after.max() for x in found])),
        "vertical.gap": float(max(spread_gap(x) for x in found + half)),
        "facets.corners": int(np.median([np.isfinite(e).sum() for e in measured])),
        "16_bits.active_grid": np.median(rounded_less.statistic("active grid", "mean")),
        "native.derivative": np.median(
            Corners(open_results(NATIVE)).statistic("derivative", "mean")
        ),
    }
    for name, number in quoted.items():
        value(name, number)


# Fig. 3.16: residual vectors of the four methods.


FINER_SCALE = 2000


@figure("fig_3_16", needs=("table_3_8_corners",), evidence="rendered")
def fig_3_16(results):
    """Draw residual vectors of the four methods, first simulated run."""
    case = Corners(results[CORNERS])
    drawn, axes = new_figure(2, 4, height_in=4.6, sharex=True, sharey=True)
    rows, worst = [], 0.0
    for k, method in enumerate(METHODS):
        corners, vectors = (case.arrays(method, n)[0] for n in ("corners", "vectors"))
        for panel, scale in zip(axes[:, k], (VECTOR_SCALE, FINER_SCALE), strict=True):
            panel.plot(*corners.T, ".", ms=1.5, color="0.6")
            panel.quiver(
                *corners.T,
                *(scale * vectors).T,
                angles="xy",
                scale_units="xy",
                scale=1,
                width=0.006,
                color=look_of(method)["color"],
            )
            panel.set(
                aspect="equal",
                title=f"({'abcd'[k]}) {method}" if panel in axes[0] else "",
            )
        mean = np.nanmean(np.linalg.norm(vectors, axis=1))
        worst = max(worst, abs(mean - case.statistic(method, "mean")[0]))
        rows += [(method, *at, *off) for at, off in zip(corners, vectors, strict=True)]
    axes[0, 0].invert_yaxis()
    for panel in axes[1]:
        panel.set_xlabel("u (px)")
    for panel, scale in zip(axes[:, 0], (VECTOR_SCALE, FINER_SCALE), strict=True):
        panel.set_ylabel(f"{scale} ×: v (px)")
    return Drawing(
        drawn,
        columns(("method", "u_px", "v_px", "du_px", "dv_px"), rows),
        "Residual vectors of all corners of the chessboard after a homography from the "
        "metric grid, with the best setting of each method; first simulated run. "
        f"Above: magnified {VECTOR_SCALE} times, as in the thesis. Below: "
        f"{FINER_SCALE} times.",
        Check(
            worst < 1e-9, "mean length of the drawn vectors is the mean of Table 3.8"
        ),
    )


# Fig. 3.18: the chessboard in the mirror ball, and its reassembled image.


GREYS = (0.45, 0.75)  # of the true grid
ORANGE = "#d55e00"


@figure("fig_3_18", needs=("fig_3_18_facets",), evidence="rendered")
def fig_3_18(results):
    """Draw the image, and its remapping over the true grid."""
    ran = results[FACETS].select()
    picture, laid, seen, metric, off = (
        ran.arrays(name)[0]
        for name in ("picture", "laid", "seen", "metric", "corner_squares")
    )
    drawn, axes = new_figure(1, 2, height_in=3.9, width_ratios=(0.9, 1.3))
    axes[0].imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    shown = np.where(seen, laid / 255.0, true_grid(laid.shape, metric))
    axes[1].imshow(shown, cmap="gray", vmin=0, vmax=1, interpolation="antialiased")
    known = np.isfinite(off)
    axes[1].plot(
        *(metric[known] / MM_PER_PX - 0.5).T,
        "o",
        ms=4,
        mfc="none",
        color=ORANGE,
        mew=0.8,
    )
    for panel, title in zip(axes, ("(a) in the ball", "(b) remapped"), strict=True):
        panel.set_axis_off()
        panel.set_title(title)
    rows = [(*place, error) for place, error in zip(metric, off, strict=True)]
    places = np.rint(metric / MM_PER_PX - 0.5).astype(int)
    return Drawing(
        drawn,
        columns(("x_mm", "y_mm", "off_squares"), rows),
        "(a) Image of a chessboard in a ball of flat mirrors. (b) The same image "
        "remapped by an active grid (black and white) over the true grid (grey). "
        "Circles: corners that can be localised.",
        Check(
            bool(known.any() and seen[tuple(places[known].T[::-1])].all()),
            "every circle is where the remapped image was decoded",
        ),
    )


def true_grid(shape, metric):
    """Return the chessboard in greys (h, w), white outside its squares."""
    square = np.linalg.norm(metric[1] - metric[0])
    side = int(np.sqrt(len(metric)))
    v, u = np.mgrid[: shape[0], : shape[1]]
    x, y = (
        (MM_PER_PX * (p + 0.5) - c) / square
        for p, c in zip((u, v), metric[0], strict=True)
    )
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    black = (column + row) % 2 != 0
    inside = (np.minimum(column, row) >= -1) & (np.maximum(column, row) <= side - 1)
    return np.where(black & inside, *GREYS)


# Fig. 3.17: the room through the fisheye, and remapped.


VIEW = "long wall"


@figure("fig_3_17", needs=("fig_3_17_lines",), evidence="rendered")
def fig_3_17(results):
    """Draw the room through the fisheye, and remapped to the active grid's plane."""
    ran = results[LINES]
    taken, laid = (ran.select(view=VIEW).arrays(name)[0] for name in ("taken", "laid"))
    lines = lines_of(ran, view=VIEW)[0]
    drawn, axes = new_figure(1, 2, height_in=2.9)
    for panel, picture, title in zip(
        axes, (taken, laid), ("(a) as taken", "(b) remapped"), strict=True
    ):
        panel.imshow(picture, interpolation="antialiased")
        panel.set_axis_off()
        panel.set_title(title)
    rows = zip(lines.before, lines.after, lines.vertical, strict=True)
    return Drawing(
        drawn,
        columns(("bent_before", "bent_after", "vertical"), rows),
        "(a) Image of a room through the 10.5 mm fisheye. (b) The same image remapped "
        f"to the plane of one active grid, {STRAIGHT_MM_PER_PX:g} mm per px. Black: "
        "not decoded. Verticals converge because the grid is pitched.",
        Check(
            bool(np.any(laid > 0)) and taken.shape[1] == rig_width(ran),
            "the image has the width of the rig's camera, and part of it is remapped",
        ),
    )


def rig_width(ran):
    """Return the width (px) of the rig's images."""
    return rig_of(ran.conditions[0]["rig"]).camera.width


# Table 3.8, and the numbers of Fig. 3.18.


# Names of the methods in the registry's ids.
PRINTED = ("derivative", "opencv", "saddle", "active")


of_seeds = Measured.of_seeds


@table("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def table_3_8(results):
    """Return the errors of four methods with their best settings."""
    case = Corners(results[CORNERS])
    windows = [of_seeds(case.best_window(m)) for m in METHODS[:3]]
    blur = of_seeds(case.best_blur())
    return Table(
        {
            "Method": list(METHODS),
            "Mean (px)": [of_seeds(case.statistic(m, "mean")) for m in METHODS],
            "SD (px)": [of_seeds(case.statistic(m, "sd")) for m in METHODS],
            "Best window (px)": [*windows, None],
            "Best blur SD (px)": [None, None, blur, None],
        },
        "Residuals of the corners of one chessboard after a homography from the "
        "metric grid, with the window and blur of the smallest mean residual: median "
        f"and range over {len(case.trials.conditions)} simulated runs. Images are "
        "undistorted with Zhang's calibration.",
        printed={
            "Mean (px)": [f"t3_8_{name}_mean" for name in PRINTED],
            "SD (px)": [f"t3_8_{name}_sd" for name in PRINTED],
            "Best window (px)": [*(f"t3_8_{name}_win" for name in PRINTED[:3]), None],
        },
    )


@table("ext_fig_3_18_numbers", needs=("fig_3_18_facets",), evidence="rendered")
def ext_fig_3_18_numbers(results):
    """Return the results of the mirror ball by simulated run."""
    trials = results[FACETS].select()
    off = trials.arrays("corner_squares")
    count = {
        name: [int(n) for n in trials.column(name)]
        for name in ("facets", "corners", "detector_found")
    }
    all_together, alone = (
        [float(100 * np.mean(one < 0.5)) for one in trials.arrays(name)]
        for name in NAMES["static_grid"].values()
    )
    return Table(
        {
            "Run": trials.levels("seed"),
            "Facets with the monitor": count["facets"],
            "Corners of the board": count["corners"],
            "Corners measured": [int(np.isfinite(e).sum()) for e in off],
            "Median error (squares)": [float(np.nanmedian(e)) for e in off],
            "Largest error (squares)": [float(np.nanmax(e)) for e in off],
            "Static grid fails, all facets (%)": all_together,
            "Static grid fails, each alone (%)": alone,
            "Boards found by a detector": count["detector_found"],
        },
        "Corners of the chessboard reassembled from the facets, by simulated run. A "
        "static grid fails on a facet if less than half of its pixels get a position "
        "within 0.1 square.",
    )
