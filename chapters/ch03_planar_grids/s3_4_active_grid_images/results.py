"""Results of section 3.3.4 by simulated run, and the numbers that its prose quotes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
