"""Section 5.3.1's scene in the plane: camera, bent mirror, a row of corners.

Frames and units as in `raxel.calibration.mirror.curves`: the camera's centre is the
origin, z its principal axis, and pixels are normalised coordinates u = x / z.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.curves import dot, reflected, viewing_rays

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
