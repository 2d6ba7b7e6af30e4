"""Results of section 3.3.4 by seed, and the numbers that its prose quotes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.filters import AS_TEXT
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.native import NO_RASTER
from repro.judge.statistics import median_interval
from repro.page.reader import value
from repro.run.readings import Case

CORNERS, FAR = "table_3_8_corners", "exp_c3_params_square"
FILTERED = "exp_c3_active_no_params"
LINES, HALF_PITCH = "fig_3_17_lines", "exp_c3_pitch_vertical"
FACETS = "fig_3_18_facets"
NATIVE = "exp_c3_t38_native"
BOTH_PIXELS = ("table_3_8_corners", "exp_c3_t38_native")
OF_CORNERS = ("table_3_8_corners", "exp_c3_params_square")
OF_LINES = ("fig_3_17_lines", "exp_c3_pitch_vertical")
# What the text leaves open here: option of the ledger -> its name in the trials.
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
    """Table 3.8 in one reading. ran: its experiment; options: by question."""

    def __init__(self, ran, options=None, case=None):
        self.taken = Case(NAMES, options)
        changed = (self.taken[q] for q in ("undistorted_bits", "edge_blur"))
        self.case = case or next((name for name in changed if name != "near"), "near")
        self.trials = ran.select(case=self.case)

    def name(self, method):
        """The trial's name of a method."""
        questions = {"active grid": "active_corner", "OpenCV": "opencv_window"}
        return self.taken[questions[method]] if method in questions else method

    def statistic(self, method, which):
        """Mean or SD (seeds,) px of the residuals with the best setting."""
        return self.trials.column(
            f"{self.name(method)}.{self.taken['lens_left']}{which}"
        )

    def arrays(self, method, which):
        """An array of each seed."""
        return self.trials.arrays(f"{self.name(method)}.{which}")

    def settings(self, name):
        """Windows or blurs (n,) that were tried."""
        return np.array(self.trials.conditions[0][name])

    def curve(self, method):
        """(windows (n,), mean residual (n,) at each) of each seed, whole ones alone."""
        windows = self.settings("windows")
        best = [over_blurs(means) for means in self.arrays(method, "means")]
        return [(windows[np.isfinite(b)], b[np.isfinite(b)]) for b in best]

    def best_window(self, method):
        """Window (px) of the least mean residual of each seed.

        Of OpenCV's half windows the number that its function is given.
        """
        return np.array([w[m.argmin()] for w, m in self.curve(method)])

    def best_blur(self):
        """Blur SD (px) of the saddle point method's best setting of each seed."""
        means = self.arrays("saddle point", "means")
        return self.settings("blurs")[[one.min(axis=1).argmin() for one in means]]


def filtered(ran, case, which, options=None):
    """Mean residual (seeds,) px of the active grid near or far, with a filter."""
    taken = Case(NAMES, options)
    name = f"{which}.{taken['active_corner']}.{taken['lens_left']}mean"
    return ran.select(case=case).column(name)


def corners_of(results, options=None):
    """Table 3.8 in one reading, from the experiment that has its pixels."""
    taken = Case(NAMES, options)
    return Corners(results[taken["picture_pixels"]], options)


def over_blurs(means):
    """Mean residuals (windows,) with the best blur, where blurs were tried."""
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
    """`RoomLines` of each seed that fits; options: by question."""
    kind, trials = Case(NAMES, options)["line_points"], ran.select(**condition)
    bends = f"before.{kind}", f"after.{kind}"
    others = "vertical", "lean_deg", "predicted_deg", "place"
    arrays = [trials.arrays(name) for name in (*bends, *others)]
    pitches = map(float, trials.column("pitch_deg"))
    return [RoomLines(*one) for one in zip(*arrays, pitches, strict=True)]


def spread_between(lines, of):
    """Angle (deg) between the leftmost and the rightmost vertical.

    of: their leans (edges,), found or predicted.
    """
    upright = np.flatnonzero(lines.vertical)
    x = lines.place[upright, 0]
    left, right = upright[x.argmin()], upright[x.argmax()]
    return float(of[right] - of[left])


def spread_gap(lines):
    """How far (deg) that angle is from the predicted one."""
    return abs(
        spread_between(lines, lines.lean) - spread_between(lines, lines.predicted)
    )


def percent(share):
    """A share in percent."""
    return 100 * float(share)


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    quoted = {
        **of_corners(open_results(CORNERS)),
        **of_native(open_results(NATIVE)),
        **of_filters(open_results(FILTERED)),
        **of_lines(open_results(LINES), open_results(HALF_PITCH)),
        **of_facets(open_results(FACETS).select()),
    }
    for name, number in quoted.items():
        value(name, number)


def of_corners(ran):
    """What the prose says of Table 3.8."""
    near = Corners(ran)
    found = {
        "seeds": len(near.trials.conditions),
        "largest_window": near.trials.column("largest_window_px").min(),
        "square": np.median(near.trials.column("square_px")),
        "saddle.window": np.median(near.best_window("saddle point")),
        "saddle.blur": np.median(near.best_blur()),
    }
    for (before, after), options in {
        ("", ".mean"): {},
        ("true_lens.", ""): {"lens_left": "true lens"},
        ("16_bits.", ""): {"undistorted_bits": "16 bits"},
    }.items():
        for method in METHODS:
            mean = median_interval(Corners(ran, options).statistic(method, "mean"))
            found[f"{before}{method.replace(' ', '_')}{after}"] = mean.value
    return found


def of_filters(ran):
    """What the active grid leaves near and far, with the text's filters and none."""
    return {
        f"grid.{lens}{case}{end}": float(np.median(filtered(ran, case, which, options)))
        for lens, options in (("", {}), ("true.", {"lens_left": "true lens"}))
        for case in CASES
        for end, which in (("", AS_TEXT), (".none", "none"))
    }


def of_native(ran):
    """What the prose says of Table 3.8 at the camera's own pixels."""
    native = Corners(ran)
    curves = [means for _, means in native.curve("derivative")]
    found = {
        "native.derivative.narrow": np.median([means[0] for means in curves]),
        "native.derivative.wide": np.median([means[-1] for means in curves]),
        "native.widest": native.settings("windows").max(),
        "native.saddle.blur": np.median(native.best_blur()),
    }
    for method in METHODS:
        mean = np.median(native.statistic(method, "mean"))
        found[f"native.{method.replace(' ', '_')}"] = mean
    smooth = Corners(ran, case=NO_RASTER)
    for method in METHODS[:3]:
        mean = np.median(smooth.statistic(method, "mean"))
        found[f"no_raster.{method.replace(' ', '_')}"] = mean
    return found


def of_lines(ran, half_pitched):
    """What the prose says of the fisheye."""
    wall = {"view": "long wall"}
    found, half = lines_of(ran, **wall), lines_of(half_pitched)
    projected = lines_of(ran, {"line_points": "projected from truth"}, **wall)
    trials = ran.select(**wall)

    return {
        "before.worst": percent(np.median([x.before.max() for x in found])),
        "after.worst": percent(np.median([x.after.max() for x in found])),
        "after.projected": percent(np.median([x.after.max() for x in projected])),
        "vertical.gap": float(max(spread_gap(x) for x in found + half)),
        "share_seen": percent(trials.column("share_seen")[0]),
        "half_angle.most": float(trials.column("half_angle_deg")[0]),
    }


def of_facets(trials):
    """What the prose says of the mirror ball."""
    errors = trials.arrays("corner_squares")
    elsewhere, decoded = (
        trials.column(name)[0] for name in ("decoded_elsewhere", "decoded")
    )
    return {
        "facets.worst": float(np.max([np.nanmax(e) for e in errors])),
        "facets.corners": int(np.median([np.isfinite(e).sum() for e in errors])),
        "ball.corners": int(trials.column("corners")[0]),
        "ball.share_of_grid": percent(trials.column("share_of_grid")[0]),
        "ball.elsewhere": percent(elsewhere / (decoded + elsewhere)),
    }
