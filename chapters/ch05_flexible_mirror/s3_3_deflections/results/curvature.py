"""Rotation of a scene ray when its reflection point is shifted slightly."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_scores import angles_between
from raxel.geometry import inverse_pose

COUNT, SPACING_MM = 60, 0.01
# Of the largest: where the mirror bends less, 5 % of twice that is not meaningful.
CURVED = 0.1


class RayTurns(NamedTuple):
    """Along the middle line of a mirror, from clamp to load.

    x (n,) mm from the clamp; curvature (n,) 1/mm, along that line; mirror (n,) and
    whole (n,), radians per mm of that line: rotation of the scene ray with a constant
    viewing ray, and with the viewing ray of each point.
    """

    x: np.ndarray
    curvature: np.ndarray
    mirror: np.ndarray
    whole: np.ndarray

    @property
    def curved(self):
        """Where (n,) the curvature is at least a tenth of the largest."""
        size = np.abs(self.curvature)
        return size >= CURVED * size.max()

    def over_twice(self, turn):
        """A rotation over twice the curvature, at the points that are curved."""
        return (turn / (2 * np.abs(self.curvature)))[self.curved]


def ray_turns(camera):
    """RayTurns of a FlexibleMirrorCamera, by reflection at points SPACING_MM away."""
    mirror = camera.mirror
    eye = inverse_pose(camera.T_viewer_mirror)[:3, 3]
    x = mirror.profile.places[0] * np.linspace(0.01, 0.99, COUNT)

    def seen(x):
        """Points, and normals not of unit length, in the mirror's frame (n, 3)."""
        z, by_x, by_y, *_ = mirror.height(x, 0 * x)
        return (
            np.column_stack([x, 0 * x, z]),
            np.column_stack([-by_x, -by_y, np.ones_like(x)]),
        )

    def scene(points, normals):
        """Unit directions (n, 3) of scene rays, with the viewing rays to points."""
        view, n = _unit(points - eye), _unit(normals)
        return view - 2 * np.sum(view * n, axis=1, keepdims=True) * n

    here, _ = seen(x)
    (low, low_normals), (high, high_normals) = (
        seen(x + step) for step in (-SPACING_MM, SPACING_MM)
    )
    way = np.linalg.norm(high - low, axis=1)
    kept = scene(here, low_normals), scene(here, high_normals)
    moved = scene(low, low_normals), scene(high, high_normals)
    _, by_x, by_y, by_xx, *_ = mirror.height(x, 0 * x)
    curvature = by_xx / ((1 + by_x**2) * np.sqrt(1 + by_x**2 + by_y**2))
    turns = (np.radians(angles_between(*rays)) / way for rays in (kept, moved))
    return RayTurns(x, curvature, *turns)


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
