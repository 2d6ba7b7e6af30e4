"""Rays and points of a mirror that are told in another frame or unit than asked for.

A result that is far off may be a poor calibration, which is scored, or a good one told
wrongly, which is refused: with another unit, frame, direction or order of coordinates
in mind it would fit. What fits by none is refused as well: no ray and no point of it
comes near the mirror, and its score would say nothing.

A mistake is tried by the truth alone; nothing that is scored is changed by it.
"""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import inverse_pose, transform

# What rays may be off, by their medians: degrees, and the distance from the place on
# the mirror as a share of its half diagonal.
MOST_DEG, MOST_ASIDE = 30.0, 1.0
# And points: how far over the sheet or beside it, as a share of its shorter side.
MOST_HEIGHT, MOST_BESIDE = 0.5, 0.25
# A mistake is taken for one where a result is off by more than this share of the above,
# and so many times less without the mistake.
DOUBTFUL, BETTER = 0.05, 10.0
FLIPPED = np.array([1.0, -1.0, -1.0])
UNITS = {"in metres": 1000.0, "in centimetres": 10.0, "in inches": 25.4}
FRAMES = {"with y up and z towards the viewer": FLIPPED}
ADVICE = "give mm in the viewer's frame: x right, y down, z into the scene"


def check_rays(name, rays, true):
    """Raise InputError unless SampledRays may be those of a true camera's stage.

    name: of the rays in the message; true: the FlexibleMirrorCamera. Pixels where it
    has no ray do not count.
    """
    off = _rays_off(*rays, true)
    if off <= DOUBTFUL:
        return
    pixels, origins, directions = rays
    mistakes = {
        "from the scene towards the mirror": (pixels, origins, -directions),
        "at pixels (row, column)": (pixels[:, ::-1], origins, directions),
    }
    for told, factor in UNITS.items():
        mistakes[told] = pixels, factor * origins, directions
    for told, turn in FRAMES.items():
        mistakes[told] = pixels, turn * origins, turn * directions
    told = _mistake(
        off, {told: _rays_off(*one, true) for told, one in mistakes.items()}
    )
    if told:
        raise InputError(f"{name}: the rays fit as ones given {told}; {_cure(told)}")
    if off >= 1:
        angle, aside = _medians(*rays, true)
        if not np.isfinite(angle):
            raise InputError(
                f"{name}: none of its {len(pixels)} pixels shows the mirror; give "
                "pixels as (column, row), of this set"
            )
        raise InputError(
            f"{name}: the rays are {angle:.0f} degrees from the true ones and pass "
            f"their places on the mirror by {aside:.0f} mm (medians); {ADVICE}"
        )


def check_points(name, points, true):
    """The same for points (M, 3) of the mirror's face."""
    off = _points_off(points, true)
    if off <= DOUBTFUL:
        return
    mistakes = {told: factor * points for told, factor in UNITS.items()}
    mistakes |= {told: turn * points for told, turn in FRAMES.items()}
    mistakes["in the mirror's frame"] = transform(true.T_viewer_mirror, points)
    told = _mistake(off, {k: _points_off(one, true) for k, one in mistakes.items()})
    if told:
        raise InputError(f"{name}: the points fit as ones given {told}; {ADVICE}")
    if off >= 1:
        place, sheet = (np.median(where, axis=0) for where in (points, _nodes(true)))
        raise InputError(
            f"{name}: the points lie about {_shown(place)} mm, and the mirror about "
            f"{_shown(sheet)} mm; {ADVICE}"
        )


def _mistake(off, others):
    """Which of the mistakes {told: off without it} was made, or None."""
    told = min(others, key=others.get)
    return told if others[told] < min(off / BETTER, 1) else None


def _cure(told):
    if told.startswith("from"):
        return "give directions from the mirror towards the scene"
    if told.startswith("at"):
        return "give pixels as (column, row)"
    return ADVICE


def _rays_off(pixels, origins, directions, true):
    """How far rays are off; from 1 on they are none of this mirror."""
    angle, aside = _medians(pixels, origins, directions, true)
    return max(angle / MOST_DEG, aside / (MOST_ASIDE * true.mirror.radius))


def _medians(pixels, origins, directions, true):
    """Medians of angles, degrees, and of distances, mm; inf where no pixel counts."""
    seen = true.rays(pixels)
    if not seen.valid.any():
        return np.inf, np.inf
    angles = angles_between(directions, seen.directions)
    aside = distances_aside(origins, directions, seen.origins)
    return np.median(angles[seen.valid]), np.median(aside[seen.valid])


def angles_between(first, second):
    """Angles (N,), degrees, between unit vectors (N, 3), exact for small ones."""
    half = np.linalg.norm(first - second, axis=1) / 2
    return np.degrees(2 * np.arcsin(np.minimum(half, 1)))


def distances_aside(origins, directions, places):
    """Distances (N,) of places (N, 3) from lines through origins (N, 3) along unit
    directions (N, 3)."""
    return np.linalg.norm(np.cross(directions, places - origins), axis=1)


def _points_off(points, true):
    """As `_rays_off`, for points."""
    mirror, side = true.mirror, true.mirror.size.min()
    x, y, z = transform(inverse_pose(true.T_viewer_mirror), points).T
    over = np.abs(z - _height(mirror, x, y)) / (MOST_HEIGHT * side)
    return np.median(np.maximum(over, _beside(mirror, x, y) / (MOST_BESIDE * side)))


def _beside(mirror, x, y):
    """How far places x, y (N,), mm, of the mirror's frame lie beside the sheet, mm."""
    across = np.abs(y) - mirror.half_width
    along = np.maximum(-x, x - mirror.end)
    return np.maximum(np.maximum(across, along), 0)


def _height(mirror, x, y):
    """Height of the sheet at its places nearest to x, y."""
    x = np.clip(x, 0, mirror.end)
    return mirror.height(x, np.clip(y, -mirror.half_width, mirror.half_width))[0]


def _nodes(true):
    mirror = true.mirror
    return transform(
        true.T_viewer_mirror, mirror.point(mirror.nodes().reshape(-1, 2))[0]
    )


def _shown(place):
    return "(" + ", ".join(f"{c:.3g}" for c in place) + ")"
