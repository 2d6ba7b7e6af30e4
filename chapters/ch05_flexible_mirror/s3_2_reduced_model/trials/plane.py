"""The plane of the reduced model, and the camera that its curve makes (5.3.2).

The plane is perpendicular to the clamp's line in the image: coordinates are rotated
about the principal axis until that line is vertical, and then the vertical one is
dropped. Nothing is lost for a mirror whose rulings are parallel to the image plane:
seen along the rulings, reflection at it is reflection at a curve. Points and
directions of the plane are rows (x, z), in mm.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.curves import DistanceCurve, HeightCurve
from raxel.calibration.mirror.sightings import normalised
from raxel.cameras import Rays


class ReducedCamera(NamedTuple):
    """A camera that views a mirror with the same curve at every height.

    angle: of the u axis in the image, radians; curve: a DistanceCurve or HeightCurve.
    """

    viewer: object
    angle: float
    curve: object

    def u(self, pixels):
        """Coordinates u (N,) of pixels (N, 2), NaN where there is no pixel."""
        return normalised(self.viewer, pixels) @ _axes(self.angle)[0, :2]

    def plane_rays(self, u):
        """Unit directions (N, 2) of the scene rays in the plane, NaN where u is."""
        known = np.isfinite(u)
        out = np.full((len(u), 2), np.nan)
        out[known] = self.curve.scene_rays(u[known])
        return out

    def rays(self, pixels):
        """Rays of pixels (N, 2), in the viewer's frame: the curve moved upwards."""
        axes = _axes(self.angle)
        view = self.viewer.rays(pixels).directions @ axes.T
        known = np.isfinite(view).all(axis=1)
        x, y, z = view[known].T
        S, tangents = self.curve.points(x / z), self.curve.tangents(x / z)
        n = np.column_stack([-tangents[:, 1], 0 * x, tangents[:, 0]])
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        away = view[known] - 2 * np.sum(view[known] * n, axis=1, keepdims=True) * n
        origins, directions = np.full((2, len(view), 3), np.nan)
        origins[known] = np.column_stack([S[:, 0], y / z * S[:, 1], S[:, 1]]) @ axes
        directions[known] = away @ axes
        return Rays(origins, directions, known)


def in_plane(points, angle):
    """Rows (x, z) (N, 2) of points or directions (N, 3) in the viewer's frame."""
    return np.asarray(points) @ _axes(angle)[[0, 2]].T


def plane_normals(viewing, scene, angle):
    """Normals (N, 2), unit, between viewing and scene rays (N, 3), unit (5.8).

    The components of both rays along the rulings are equal and cancel.
    """
    normals = in_plane(viewing - scene, angle)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def distances_next_to(points, span, normals=None):
    """The DistanceCurve of mirror points (N, 2); span: u at clamp and free edge.

    normals: (N, 2), then the points give its scale alone, and the normals its shape
    (5.15, 5.16), as published; without them it is fitted to the points' distances.
    """
    curve = DistanceCurve(np.zeros(4), span)
    u, distances = points[:, 0] / points[:, 1], np.linalg.norm(points, axis=1)
    powers = np.vander(2 * curve.way(u) - 1, 4, increasing=True)
    if normals is None:
        return curve.replaced(np.linalg.lstsq(powers, distances, rcond=None)[0])
    rows, _ = curve.slope_equations(u, normals)
    shape = np.linalg.svd(rows, full_matrices=False)[2][-1]
    scale = (powers @ shape) @ distances / np.sum((powers @ shape) ** 2)
    return curve.replaced(scale * shape)


def heights_next_to(points, clamp, free, normals):
    """The HeightCurve of points (N, 2) of a nearly flat mirror with normals (N, 2).

    clamp, free: u of both ends of the line fitted to the points. The normals give the
    slopes, and the points the distance.
    """
    middle = points.mean(axis=0)
    across = np.linalg.svd(points - middle, full_matrices=False)[2][1]
    foot, end = (
        np.array([u, 1.0]) * (middle @ across) / (across @ [u, 1.0])
        for u in (clamp, free)
    )
    length = float(np.linalg.norm(end - foot))
    along = (end - foot) / length
    flat = HeightCurve(np.zeros(4), foot, along, length)
    rows, sides = flat.slope_equations(points[:, 0] / points[:, 1], normals)
    slopes = np.linalg.lstsq(rows[:, 1:], sides, rcond=None)[0]
    powers = np.vander((points - foot) @ along / length, 4, increasing=True)
    heights = (points - foot) @ [-along[1], along[0]]
    shift = np.mean(heights - powers[:, 1:] @ slopes)
    return flat.replaced([shift, *slopes])


def _axes(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
