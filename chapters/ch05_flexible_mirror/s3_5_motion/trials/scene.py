"""A cylinder with marks that a stage moves in front of the bent mirror (5.3.5).

The cylinder is upright in the field of the mirror and moves sideways. Its position is
chosen by one criterion: all marks are in view in all six positions. Frame: that of the
viewer; mm.
"""

from typing import NamedTuple

import numpy as np

from raxel.geometry.poses import pose, rotation_from_vector, transform

RADIUS_MM, MARKS = 62.98, 25
STEP_MM, STEPS = 25.0, 5
# Distance from mirror to axis; half the marked height; angular range of the marks, on
# the side towards the mirror.
AWAY_MM, HALF_MM, AROUND = 450.0, 75.0, np.radians(65)
TILT = np.radians(5)  # of the axis and of the stage, standard deviation
NOISE_PX = 0.2
RIM_PX = 8.0
TRIED, MAX_N_TRIES = 90, 50
TURNS = np.arange(6) * np.pi / 3


class PlacedCylinder(NamedTuple):
    """Pose and motion of the cylinder.

    axes (3, 3): in columns, the cylinder's axis second and the direction away from the
    mirror last; middle (3,): of the axis at first; along (3,): direction of motion.
    """

    axes: np.ndarray
    middle: np.ndarray
    along: np.ndarray

    @property
    def axis(self):
        """Unit vector (3,) along the cylinder."""
        return self.axes[:, 1]

    def points(self, turn, height):
        """Points (N, 3) of the surface.

        turn: angle from the side that faces the mirror, radians; height: mm.
        """
        local = np.column_stack(
            [RADIUS_MM * np.sin(turn), height, -RADIUS_MM * np.cos(turn)]
        )
        return self.middle + local @ self.axes.T

    def motions(self):
        """T (6, 4, 4): motions of the cylinder after 0 to 5 steps."""
        steps = STEP_MM * np.arange(STEPS + 1)[:, None] * self.along
        return np.array([pose(np.eye(3), step) for step in steps])


class MovedCylinder(NamedTuple):
    """Marks, motions and image points of the cylinder.

    points (25, 3): marks at first; T (6, 4, 4): their motions after 0 to 5 steps;
    pixels (6, 25, 2): true image points; axis (3,): unit vector along the cylinder.
    """

    points: np.ndarray
    T: np.ndarray
    pixels: np.ndarray
    axis: np.ndarray


def moved_cylinder(camera, rng):
    """The MovedCylinder seen by a true camera. RuntimeError where none is visible."""
    for _ in range(MAX_N_TRIES):
        placed = placed_cylinder(camera, rng)
        turn = rng.uniform(-AROUND, AROUND, TRIED)
        points = placed.points(turn, rng.uniform(-HALF_MM, HALF_MM, TRIED))
        pixels, seen = seen_in_all(camera, points, placed.motions())
        keep = np.flatnonzero(seen)[:MARKS]
        if len(keep) == MARKS:
            T = placed.motions()
            return MovedCylinder(points[keep], T, pixels[:, keep], placed.axis)
    raise RuntimeError(f"of {TRIED} marks fewer than {MARKS} are seen in all places")


def seen_in_all(camera, points, T):
    """(pixels (V, N, 2), seen (N,)) of points under motions (V, 4, 4).

    seen: visible in all.
    """
    found = [camera.project(transform(one, points)) for one in T]
    seen = np.all([f.valid & shown(camera, f.pixels) for f in found], axis=0)
    return np.array([f.pixels for f in found]), seen


def shown(camera, pixels):
    """Whether a camera has rays for pixels (N, 2) and all around them, (N,) bool."""
    around = RIM_PX * np.column_stack([np.cos(TURNS), np.sin(TURNS)])
    places = np.where(np.isfinite(pixels), pixels, -1.0) + around[:, None]
    inside = camera.in_image(places.reshape(-1, 2))
    rays = camera.rays(places.reshape(-1, 2))
    return (inside & rays.valid).reshape(len(around), -1).all(axis=0)


def placed_cylinder(camera, rng):
    """The PlacedCylinder, in the middle of a camera's field after half its steps."""
    size = np.array([camera.width, camera.height])
    rays = camera.rays(size * rng.uniform(0.05, 0.95, (TRIED, 2)))
    o, d = np.nanmean(rays.origins, axis=0), np.nanmean(rays.directions, axis=0)
    d /= np.linalg.norm(d)
    x = np.cross([0.0, 1.0, 0.0], d)
    axes = np.column_stack([x / np.linalg.norm(x), np.zeros(3), d])
    axes[:, 1] = np.cross(d, axes[:, 0])
    axes = axes @ rotation_from_vector(rng.normal(0, TILT, 3))
    along = axes @ rotation_from_vector(rng.normal(0, TILT, 3))[:, 0]
    return PlacedCylinder(axes, o + AWAY_MM * d - STEPS * STEP_MM / 2 * along, along)
