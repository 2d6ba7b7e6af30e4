"""Section 5.3.1: calibrations of one scene, their errors, and the three sweeps."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_1_simulated.trials.scene import (
    ALONG,
    ANGLE_DEG,
    AWAY,
    CORNERS,
    ENDS,
    FILLED,
    FOCAL_MM,
    IMAGE_PX,
    LENGTH_MM,
    MARGIN,
    PITCH_MM,
    ROWS,
    TILT_DEG,
    PlaneRig,
    beam,
    bent,
    draw_row,
    lay_row,
    pixels_of,
    rig_of,
    view_of_bent,
    view_of_flat,
    visible,
)
from raxel.calibration.mirror.curves import (
    DistanceCurve,
    HeightCurve,
    reflected,
    viewing_rays,
)
from raxel.calibration.mirror.reduced import (
    calibrate_reduced,
    place_row,
    refine_reduced,
)
from raxel.errors import CalibrationError

TIP_MM, DEPTH_MM, NOISE_PX = 16.7, 1650.0, 1.0
DEFAULT = {"noise": NOISE_PX, "depth": DEPTH_MM, "bend": TIP_MM}
SWEEPS = {
    "noise": (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0),
    "depth": (400.0, 600.0, 900.0, 1200.0, 1650.0, 2200.0, 3000.0, 4500.0, 6000.0,
              8000.0),
    "bend": (5.0, 10.0, 16.7, 25.0, 35.0, 45.0, 53.0),
}  # fmt: skip
TRIALS = {"quick": 3, "full": 100}
# The set-up of the primary readings, and what one of them changes.
BASE = {"pitch": "megaplus", "rows": 1, "sense": 1, "grid": "fills"}
OTHERS = ({"pitch": "d200"}, {"pitch": "olympus"}, {"pitch": "film"}, {"rows": ROWS},
          {"sense": -1}, {"grid": "one size"})  # fmt: skip
SETTINGS = {
    "focal_mm": FOCAL_MM,
    "image_px": list(IMAGE_PX),
    "pitch_mm": PITCH_MM,
    "mirror_mm": LENGTH_MM,
    "mirror_angle_deg": ANGLE_DEG,
    "picture_filled": FILLED,
    "corners": CORNERS,
    "tilt_deg": TILT_DEG,
    "ends": [list(ends) for ends in ENDS],
    "margin": MARGIN,
    "default": DEFAULT,
    "sweeps": {name: list(levels) for name, levels in SWEEPS.items()},
}
ALL_ALONG = np.linspace(0, LENGTH_MM, 101)


class RowViews(NamedTuple):
    """One row of corners seen before and after bending.

    before, after: (N,) u without noise, nan where not seen; on: (N, 2) mm, where they
    are seen on the bent mirror; noise: (2, N) standard deviates; points: (N, 2) mm;
    places: (N,) mm along the row; tip: mm.
    """

    rig: PlaneRig
    before: np.ndarray
    after: np.ndarray
    on: np.ndarray
    noise: np.ndarray
    points: np.ndarray
    places: np.ndarray
    tip: float


def conditions():
    """Every sweep in the primary set-up, and with each change of it."""
    return [
        {"sweep": sweep} | BASE | other for other in ({}, *OTHERS) for sweep in SWEEPS
    ]


def look(condition, depth, tip, drawn):
    """RowViews of one draw of grid and noise, at a depth and a tip's deflection.

    tip: mm at the free edge, positive away from the camera (convex).
    """
    row, noise = drawn
    rig, size = rig_of(condition["pitch"]), None
    if condition["grid"] == "one size":
        _, places = lay_row(rig, DEPTH_MM, *row)
        size = np.ptp(places)
    points, places = (
        np.repeat(v, condition["rows"], axis=0) for v in lay_row(rig, depth, *row, size)
    )
    u, on = [], []
    for x, bend in (
        (view_of_flat(rig, points), 0.0),
        (view_of_bent(rig, points, tip), tip),
    ):
        on.append(bent(rig, x, bend)[0])
        u.append(np.where(visible(x), pixels_of(on[-1]), np.nan))
    return RowViews(rig, *u, on[-1], noise, points, places, tip)


def draw(condition, rng):
    """A grid and the noise of two images: the same at every level of a sweep."""
    count = CORNERS * condition["rows"]
    return draw_row(rng), rng.standard_normal((2, count))


def located(views, noise_px):
    """Directions and positions of the corners from the noisy image before bending.

    The mirror is flat and known. The row is fitted to the rays of all visible corners.
    Returns V_r and points, (N, 2) each, rows of nan where a corner was not visible.
    """
    rig = views.rig
    u = views.before + noise_px * rig.pixel * views.noise[0]
    seen = np.isfinite(u)
    on, V_r = flat_rays(rig, u)
    foot, way = place_row(on[seen], V_r[seen], views.places[seen])
    points = foot + views.places[:, None] * way
    return V_r, np.where(seen[:, None], points, np.nan)


def flat_rays(rig, u):
    """Where viewing rays u (N,) meet the flat mirror (N, 2), and their scene rays."""
    V = viewing_rays(u)[0]
    on = ((rig.foot @ AWAY) / (V @ AWAY))[:, None] * V
    return on, reflected(V, np.broadcast_to(ALONG, V.shape))


def before_bending(rig, kind, tip):
    """The curve before, as `calibrate_reduced` wants it, and the clamp."""
    ends = pixels_of(bent(rig, np.array([0.0, LENGTH_MM]), tip)[0])
    clamp = float(ends[0]), float(np.hypot(*rig.foot))
    if kind == "height":
        return HeightCurve(np.zeros(4), rig.foot, ALONG, LENGTH_MM), clamp
    return DistanceCurve(np.zeros(4), tuple(ends)), clamp


def calibrate(views, noise_px, kind="distance", known=False):
    """Calibration of one bent mirror from a row of corners; kind: of the curve.

    known: the row's position is known, without noise in the image before.
    """
    V_r, points = located(views, 0.0 if known else noise_px)
    u = after_bending(views, noise_px)
    both = in_both(views)
    before, clamp = before_bending(views.rig, kind, views.tip)
    return calibrate_reduced(before, u[both], V_r[both], points[both], clamp)


def after_bending(views, noise_px):
    """Noisy u (N,) of the corners in the image after bending."""
    return views.after + noise_px * views.rig.pixel * views.noise[1]


def in_both(views):
    """Whether both images show each corner (N,)."""
    return np.isfinite(views.before) & np.isfinite(views.after)


def restarted(found, views, noise_px):
    """How far the refinement goes elsewhere from the true mirror: mean distance, mm.

    It starts once more, from the cubic next to the true mirror in place of the linear
    estimate, on the same data as the primary method.
    """
    true = bent(views.rig, ALL_ALONG, views.tip)[0]
    u_true = pixels_of(true)
    slide, _ = found.curve.changes(u_true)
    nearest = np.linalg.lstsq(slide, np.linalg.norm(true, axis=1), rcond=None)[0]
    _, points = located(views, noise_px)
    u, both = after_bending(views, noise_px), in_both(views)
    _, clamp = before_bending(views.rig, "distance", views.tip)
    start = found.curve.replaced(nearest)
    again = refine_reduced(start, u[both], points[both], clamp)
    apart = again.curve.points(u_true) - found.curve.points(u_true)
    return float(np.mean(np.linalg.norm(apart, axis=1)))


def errors(curve, views):
    """Errors of an estimated curve against the true mirror.

    across_mm: mean over the whole mirror of the distance at right angles to it;
    along_mm: mean over the corners of that along the viewing rays. tip_ratio: estimated
    over true deflection, on the viewing ray of the free edge.
    """
    on, tangents = bent(views.rig, ALL_ALONG, views.tip)
    found = curve.points(pixels_of(on))
    across = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    off = np.einsum("ij,ij->i", found - on, across)
    true = views.on[in_both(views)]
    ranges = curve.distances(pixels_of(true)) - np.linalg.norm(true, axis=1)
    tip = (found[-1] - views.rig.foot) @ AWAY
    return {
        "across_mm": float(np.mean(np.abs(off))),
        "along_mm": float(np.mean(np.abs(ranges))),
        "tip_ratio": float(tip / views.tip),
    }


# What is calibrated in the primary set-up; with a change of it, the first alone.
METHODS = {"distance": {}, "height": {"kind": "height"}, "known": {"known": True}}


def methods_of(condition):
    """The methods that are run in a set-up."""
    primary = all(condition[name] == value for name, value in BASE.items())
    return METHODS if primary else {"distance": METHODS["distance"]}


def measure(condition, noise_px, depth, tip, drawn):
    """Errors of every method at one level, linear and final."""
    views = look(condition, depth, condition["sense"] * tip, drawn)
    _, slope, _ = beam(ALL_ALONG, views.tip)
    out = {
        "slope2": float(np.max(slope**2)),
        "corners": int(np.count_nonzero(in_both(views))),
    }
    for name, choice in methods_of(condition).items():
        try:
            found = calibrate(views, noise_px, **choice)
            out[name] = {
                "linear": errors(found.linear, views),
                "final": errors(found.curve, views),
                "reach": found.reach,
            }
            if name == "distance":
                out[name]["restart_mm"] = restarted(found, views, noise_px)
        except CalibrationError as fault:
            out[name] = {"failed": fault.code}
    return out


def each_level(condition, drawn):
    """Errors at every level of a sweep, with one draw of grid and noise."""
    sweep = condition["sweep"]
    out = {}
    for number, level in enumerate(SWEEPS[sweep]):
        at = DEFAULT | {sweep: level}
        out[f"level_{number}"] = measure(
            condition, at["noise"], at["depth"], at["bend"], drawn
        )
    return out
