"""An unknown scene in front of the mirror: a wall, a plane, an object (5.4).

Depths are measured from the mirror's middle, along the mean direction of its rays when
flat. The plane and the object occlude parts of the wall, in vertical stripes.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from chapters.shared.mirror_runs import lattice

# From the mirror, mm (Fig. 5.26); NEAR_MM: what only the bent mirror shows, at its end.
DEPTHS_MM = {"wall": 5000.0, "plane": 3980.0, "object": 4950.0}
NEAR_MM = 1200.0
STRIPE, LATTICE_PX = np.radians(3), 32
EACH, ALONE = 40, 0.1  # features drawn for each state; share outside a cluster
MIDDLE = 0.2  # share of the mirror's height where features cluster


class SceneFrame(NamedTuple):
    """Frame of the scene.

    middle (3,); axis (3,), unit; edge: smallest x component of a flat mirror's ray.
    """

    middle: np.ndarray
    axis: np.ndarray
    edge: float

    @classmethod
    def of(cls, flat):
        """Return the frame of the true camera of stage 0."""
        rays = flat.rays(lattice(flat, 96))
        axis = rays.directions.mean(axis=0)
        axis /= np.linalg.norm(axis)
        return cls(rays.origins.mean(axis=0), axis, rays.directions[:, 0].min())

    def depth(self, points):
        """(N,) mm of points (N, 3)."""
        return (points - self.middle) @ self.axis

    def placed(self, origins, directions, depth):
        """Points (N, 3) where rays reach depths (N,) mm."""
        along = (depth - self.depth(origins)) / (directions @ self.axis)
        return origins + along[:, None] * directions


class Field:
    """A true camera and a lattice of its pixels with their rays, made once."""

    def __init__(self, camera):
        self.camera = camera
        self.pixels = lattice(camera, LATTICE_PX)
        self.rays = camera.rays(self.pixels)
        self.middle = self.rays.origins.mean(axis=0)

    def shows(self, points):
        """Whether points (N, 3) are inside the field of the lattice.

        Near points are tested on their own: for them the size of the mirror matters.
        """
        away = points - self.middle
        reach = np.linalg.norm(away, axis=1)
        near = reach < np.median(reach) / 2
        seen = np.zeros(len(points), bool)
        for group in (near, ~near):
            if not group.any():
                continue
            at = self.rays.origins + np.median(reach[group]) * self.rays.directions
            edges = ConvexHull(_slopes(at - self.middle)).equations
            beyond = _slopes(away[group]) @ edges[:, :2].T + edges[:, 2]
            seen[group] = np.all(beyond <= 0, axis=1)
        return seen

    def pictured(self, points, errors, rng, pick_px=0.0):
        """Pixels (N, 2) of points with errors, NaN where not visible.

        Points outside the field of the lattice are excluded. pick_px: standard
        deviation of picking by hand, added to the errors.
        """
        found = np.full((len(points), 2), np.nan)
        there = np.flatnonzero(self.shows(points))
        pixels, valid = self.camera.project(points[there])
        seen = valid & self.camera.in_image(pixels)
        found[there[seen]] = pixels[seen]
        # Equally many draws whatever is visible: all levels and scenes are drawn alike.
        found = errors.corners(found, rng)
        return found + pick_px * rng.standard_normal(found.shape)


def features(view, fields, rng, clustered=False, near=False):
    """Points (N, 3) and their surfaces (N,), of features drawn in each Field.

    clustered: nine in ten lie in the middle fifth of the mirror's height; near: what
    the flat mirror does not show at its end is NEAR_MM away.
    """
    points, names = [], []
    for field in fields:
        weight = _weights(field.pixels, clustered)
        chosen = rng.choice(len(weight), EACH, replace=False, p=weight / weight.sum())
        rays = field.rays.directions[chosen]
        of = np.array(["wall", "plane", "wall", "object"])[_stripe(rays) % 4]
        depth = np.array([DEPTHS_MM[name] for name in of])
        if near:
            depth = np.where(rays[:, 0] < view.edge, NEAR_MM, depth)
        points.append(view.placed(field.rays.origins[chosen], rays, depth))
        names.append(of)
    return np.vstack(points), np.concatenate(names)


def _weights(pixels, clustered):
    if not clustered:
        return np.ones(len(pixels))
    off = np.abs(pixels[:, 1] - pixels[:, 1].mean()) / np.ptp(pixels[:, 1])
    inside = off < MIDDLE / 2
    return np.where(inside, (1 - ALONE) / inside.sum(), ALONE / (~inside).sum())


def _stripe(d):
    return np.floor(np.arctan2(d[:, 0], -d[:, 2]) / STRIPE).astype(int)


def _slopes(away):
    return np.column_stack([away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]])
