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


CORNERS, FAR_CORNERS = "table_3_8_corners", "exp_c3_params_square"
LINES, HALF_PITCH = "fig_3_17_lines", "exp_c3_pitch_vertical"
FACETS, NATIVE = "fig_3_18_facets", "exp_c3_t38_native"
# Questions that the text does not settle: option in the registry -> name in the trials.
NAMES = {
    "opencv_window": {"full window": "OpenCV", "half window": "OpenCV half"},
    "active_corner": {
        "four nearest pixels": "four nearest pixels",
        "local fit": "local fit",
    },
    "lens_left": {"as left by Zhang's method": (), "true lens": ("true_lens",)},
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
VECTOR_SCALE = 200  # of Fig. 3.16
VIEW = "long wall"


class Corners:
    """Table 3.8 in one interpretation: results by experiment, options by question.

    far: whether the chessboard is that of half the apparent size.
    """

    def __init__(self, results, options=None, far=False):
        taken = Case(NAMES, options)
        changed = {taken["undistorted_bits"], taken["edge_blur"]} - {"near"}
        case = "far" if far else min(changed, default="near")
        self.trials = results[FAR_CORNERS if far else taken["picture_pixels"]].select(
            case=case
        )
        self.lens = taken["lens_left"]
        self.names = dict(zip(METHODS, METHODS, strict=True)) | {
            "OpenCV": taken["opencv_window"],
            "active grid": taken["active_corner"],
        }

    def statistic(self, which, methods=METHODS):
        """Return the mean or SD (methods, runs) px of residuals, best setting."""
        names = [self.names[method] for method in methods]
        return self.trials.column(names, *self.lens, which)

    def arrays(self, method, which):
        """Return an array of each run."""
        return self.trials.arrays(self.names[method], which)

    def settings(self, name):
        """Return the windows or blurs (n,) that were tried."""
        return np.array(self.trials.conditions[0][name])

    def curve(self, method):
        """Return (windows (n,), mean residual (n,)) of each run, valid windows only.

        Means are those with the best blur, where blurs were tried.
        """
        windows = self.settings("windows")
        means = [one.reshape(-1, len(windows)) for one in self.arrays(method, "means")]
        best = [one.min(axis=0) for one in means]
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
    paths = (
        *(("before", kind), ("after", kind)),
        *(("vertical",), ("lean_deg",), ("predicted_deg",), ("place",)),
    )
    arrays = [trials.arrays(*path) for path in paths]
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


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    found = lines_of(open_results(LINES), view=VIEW)
    half = lines_of(open_results(HALF_PITCH))
    results = {name: open_results(name) for name in (CORNERS, NATIVE)}
    in_16_bits = Corners(results, {"undistorted_bits": "16 bits"})
    native = Corners(results, {"picture_pixels": "native pixels"})
    measured = open_results(FACETS).select().arrays("corner_squares")
    quoted = {
        "before.worst": 100 * np.median([x.before.max() for x in found]),
        "after.worst": 100 * np.median([x.after.max() for x in found]),
        "vertical.gap": float(max(spread_gap(x) for x in found + half)),
        "facets.corners": int(np.median([np.isfinite(e).sum() for e in measured])),
        "16_bits.active_grid": np.median(in_16_bits.statistic("mean")[3]),
        "native.derivative": np.median(native.statistic("mean")[0]),
    }
    for name, number in quoted.items():
        value(name, number)


# Fig. 3.16: residual vectors of the four methods.


FINER_SCALE = 2000


@figure("fig_3_16", needs=("table_3_8_corners",), evidence="rendered")
def fig_3_16(results):
    """Draw residual vectors of the four methods, first simulated run."""
    case = Corners(results)
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
                xlabel="u (px)" if panel in axes[1] else "",
                ylabel=f"{scale} ×: v (px)" if k == 0 else "",
            )
        mean = np.nanmean(np.linalg.norm(vectors, axis=1))
        worst = max(worst, abs(mean - case.statistic("mean")[k, 0]))
        rows += [(method, *at, *off) for at, off in zip(corners, vectors, strict=True)]
    axes[0, 0].invert_yaxis()
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
    image, laid, seen, metric, off = (
        ran.arrays(name)[0]
        for name in ("picture", "laid", "seen", "metric", "corner_squares")
    )
    drawn, axes = new_figure(1, 2, height_in=3.9, width_ratios=(0.9, 1.3))
    axes[0].imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
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


@figure("fig_3_17", needs=("fig_3_17_lines",), evidence="rendered")
def fig_3_17(results):
    """Draw the room through the fisheye, and remapped to the active grid's plane."""
    ran = results[LINES]
    images = [ran.select(view=VIEW).arrays(name)[0] for name in ("taken", "laid")]
    lines = lines_of(ran, view=VIEW)[0]
    drawn, axes = new_figure(1, 2, height_in=2.9)
    for panel, image, title in zip(
        axes, images, ("(a) as taken", "(b) remapped"), strict=True
    ):
        panel.imshow(image, interpolation="antialiased")
        panel.set_axis_off()
        panel.set_title(title)
    rows = zip(lines.before, lines.after, lines.vertical, strict=True)
    width = rig_of(ran.conditions[0]["rig"]).camera.width
    return Drawing(
        drawn,
        columns(("bent_before", "bent_after", "vertical"), rows),
        "(a) Image of a room through the 10.5 mm fisheye. (b) The same image remapped "
        f"to the plane of one active grid, {STRAIGHT_MM_PER_PX:g} mm per px. Black: "
        "not decoded. Verticals converge because the grid is pitched.",
        Check(
            bool(np.any(images[1] > 0)) and images[0].shape[1] == width,
            "the image has the width of the rig's camera, and part of it is remapped",
        ),
    )


# Table 3.8, and the numbers of Fig. 3.18.


# Method -> its name in the registry's ids.
PRINTED = {
    "derivative": "derivative",
    "OpenCV": "opencv",
    "saddle point": "saddle",
    "active grid": "active",
}


@table("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def table_3_8(results):
    """Return the errors of four methods with their best settings."""
    case, of_runs = Corners(results), Measured.of_seeds
    return Table(
        {
            "Method": METHODS,
            "Mean (px)": [of_runs(mean) for mean in case.statistic("mean")],
            "SD (px)": [of_runs(sd) for sd in case.statistic("sd")],
            "Best window (px)": [
                *(of_runs(case.best_window(m)) for m in METHODS[:3]),
                None,
            ],
            "Best blur SD (px)": [None, None, of_runs(case.best_blur()), None],
        },
        "Residuals of the corners of one chessboard after a homography from the "
        "metric grid, with the window and blur of the smallest mean residual: median "
        f"and range over {len(case.trials.conditions)} simulated runs. Images are "
        "undistorted with Zhang's calibration.",
        printed={
            "Mean (px)": [f"t3_8_{name}_mean" for name in PRINTED.values()],
            "SD (px)": [f"t3_8_{name}_sd" for name in PRINTED.values()],
            "Best window (px)": [
                *(f"t3_8_{PRINTED[method]}_win" for method in METHODS[:3]),
                None,
            ],
        },
    )


@table("ext_fig_3_18_numbers", needs=("fig_3_18_facets",), evidence="rendered")
def ext_fig_3_18_numbers(results):
    """Return the results of the mirror ball by simulated run."""
    trials = results[FACETS].select()
    off = trials.arrays("corner_squares")
    facets, corners, found = trials.column(("facets", "corners", "detector_found"))
    all_together, alone = (
        [float(100 * np.mean(one < 0.5)) for one in trials.arrays(name)]
        for name in NAMES["static_grid"].values()
    )
    return Table(
        {
            "Run": trials.levels("seed"),
            "Facets with the monitor": facets.astype(int),
            "Corners of the board": corners.astype(int),
            "Corners measured": [int(np.isfinite(e).sum()) for e in off],
            "Median error (squares)": [float(np.nanmedian(e)) for e in off],
            "Largest error (squares)": [float(np.nanmax(e)) for e in off],
            "Static grid fails, all facets (%)": all_together,
            "Static grid fails, each alone (%)": alone,
            "Boards found by a detector": found.astype(int),
        },
        "Corners of the chessboard reassembled from the facets, by simulated run. A "
        "static grid fails on a facet if less than half of its pixels get a position "
        "within 0.1 square.",
    )
