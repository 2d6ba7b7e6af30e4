"""Trials of this page, their conditions and constants."""

from typing import NamedTuple

import numpy as np

from raxel.calibration import (
    DistanceCurve,
    HeightCurve,
    calibrate_reduced,
    dot,
    place_row,
    refine_reduced,
    reflected,
    viewing_rays,
)
from raxel.errors import CalibrationError

# Section 5.3.1's scene in the plane: camera, bent mirror, a row of corners.
#
# Frames and units as in `raxel.calibration.mirror.reduced`: the camera's centre is the
# origin, z its principal axis, and pixels are normalised coordinates u = x / z.


FOCAL_MM, LENGTH_MM, ANGLE_DEG = 26.0, 420.0, 67.5
IMAGE_PX = (516, 656)
# Width of the sensor over the pixels of the image's longer side; of the MegaPlus 1.4i
# two of its pixels of 6.8 um, for half of its 1317 x 1035.
PITCH_MM = {
    "megaplus": 2 * 0.0068,
    "d200": 23.6 / 656,
    "olympus": 5.76 / 656,
    "film": 36.0 / 656,
}
FILLED = 0.9
CORNERS, ROWS = 14, 13
TILT_DEG = 30.0
ENDS = ((0.03, 0.1), (0.9, 0.97))
MARGIN = 0.02
NEWTON_STEPS = 30

ALONG = np.array([np.sin(np.radians(ANGLE_DEG)), np.cos(np.radians(ANGLE_DEG))])
AWAY = np.array([-ALONG[1], ALONG[0]])


class PlaneRig(NamedTuple):
    """Camera and clamped mirror. foot: (2,) mm, the clamp; pixel: size of one in u."""

    foot: np.ndarray
    pixel: float

    @property
    def middle(self):
        """The middle (2,) of the unbent mirror, mm."""
        return self.foot + LENGTH_MM / 2 * ALONG

    @property
    def distance_mm(self):
        """From the camera to the middle of the unbent mirror."""
        return float(np.hypot(*self.middle))


def rig_of(pitch):
    """The rig in which the unbent mirror fills nine tenths of the image, centred."""
    pixel = PITCH_MM[pitch] / FOCAL_MM
    edge = FILLED * max(IMAGE_PX) * pixel / 2
    depth = LENGTH_MM * (ALONG[0] - edge * ALONG[1]) / (2 * edge)
    return PlaneRig(np.array([-edge * depth, depth]), pixel)


def beam(x, tip):
    """Deflection of the beam (5.1) at x (N,), its slope and its second derivative.

    The force is at the free edge, and ``tip`` mm the deflection there.
    """
    k = tip / (2 * LENGTH_MM**3)
    return (
        k * x**2 * (3 * LENGTH_MM - x),
        k * (6 * LENGTH_MM * x - 3 * x**2),
        k * (6 * LENGTH_MM - 6 * x),
    )


def bent(rig, x, tip):
    """Points and tangents (N, 2) of the mirror, x mm along its clamped line."""
    height, slope, _ = beam(x, tip)
    points = rig.foot + x[:, None] * ALONG + height[:, None] * AWAY
    return points, ALONG + slope[:, None] * AWAY


def pixels_of(points):
    """u (N,) of points (N, 2)."""
    return points[:, 0] / points[:, 1]


def view_of_flat(rig, points):
    """x (N,) on the unbent mirror where points (N, 2) are seen in it.

    Their mirror images lie as far behind it; the viewing ray to each cuts the mirror.
    """
    behind = points + 2 * ((rig.foot - points) @ AWAY)[:, None] * AWAY
    share = (rig.foot @ AWAY) / (behind @ AWAY)
    return (share[:, None] * behind - rig.foot) @ ALONG


def view_of_bent(rig, points, tip):
    """x (N,) on the bent mirror where points (N, 2) are seen in it; nan where not.

    The path from camera over mirror to point is shortest there (Fermat): Newton's steps
    on the derivative of its length, from where the point was seen before.
    """
    x = np.clip(view_of_flat(rig, points), 0, LENGTH_MM)
    for _ in range(NEWTON_STEPS):
        on, tangent = bent(rig, x, tip)
        pull, stiff = 0.0, 0.0
        for end in (np.zeros(2), points):
            way = on - end
            far = np.linalg.norm(way, axis=1)
            pull = pull + way / far[:, None]
            turned = dot(tangent, tangent) - (dot(tangent, way) / far) ** 2
            stiff = stiff + turned / far
        step = dot(tangent, pull) / (stiff + beam(x, tip)[2] * (pull @ AWAY))
        moved = np.clip(x - step, 0, LENGTH_MM)
        if np.all(np.abs(moved - x) < 1e-10):
            break
        x = moved
    return np.where(np.abs(step) < 1e-8, x, np.nan)


def draw_row(rng):
    """What is random about the grid: its tilt, and where it begins and ends."""
    tilt = np.radians(rng.uniform(-TILT_DEG, TILT_DEG))
    return tilt, [rng.uniform(*ends) for ends in ENDS]


def lay_row(rig, depth, tilt, ends, size_mm=None):
    """Corners (14, 2) of a row ``depth`` mm from the mirror, and their places (14,).

    The row crosses the scene ray of the mirror's middle at this depth, tilted from a
    right angle, between the scene rays from ``ends`` of the way along the unbent
    mirror; with a ``size_mm`` it has that length about the same middle instead.
    """
    x = LENGTH_MM * np.array([0.5, *ends])
    on, tangents = bent(rig, x, 0.0)
    V_r = reflected(viewing_rays(pixels_of(on))[0], tangents)
    at = on[0] + depth * V_r[0]
    c, s = np.cos(tilt), np.sin(tilt)
    way = np.array([-V_r[0, 1] * c - V_r[0, 0] * s, V_r[0, 0] * c - V_r[0, 1] * s])
    # Ray and row: on + range V_r = at + place way.
    ends_mm = [
        np.linalg.solve(np.column_stack([way, -ray]), start - at)[0]
        for start, ray in zip(on[1:], V_r[1:], strict=True)
    ]
    middle, size = np.mean(ends_mm), ends_mm[1] - ends_mm[0]
    if size_mm is not None:
        size = np.copysign(size_mm, size)
    places = middle + size * np.linspace(-0.5, 0.5, CORNERS)
    return at + places[:, None] * way, places


def visible(x):
    """Which places x (N,) on the mirror are in view, and not at its very edge."""
    with np.errstate(invalid="ignore"):
        return (x > MARGIN * LENGTH_MM) & (x < (1 - MARGIN) * LENGTH_MM)


# Section 5.3.1: calibrations of one scene, their errors, and the three sweeps.


TIP_MM, DEPTH_MM, NOISE_PX = 16.7, 1650.0, 1.0
DEFAULT = {"noise": NOISE_PX, "depth": DEPTH_MM, "bend": TIP_MM}
SWEEPS = {
    "noise": (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0),
    "depth": (400.0, 600.0, 900.0, 1200.0, 1650.0, 2200.0, 3000.0, 4500.0, 6000.0,
              8000.0),
    "bend": (5.0, 10.0, 16.7, 25.0, 35.0, 45.0, 53.0),
}  # fmt: skip
TRIALS = {"quick": 3, "full": 100}
# The set-up of the primary interpretations, and what one of them changes.
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
