"""The true mirror in place of the laser scan, and distances of curves from it (5.3.2).

The scan is the middle line, in the plane of the reduced model. It is compared in the
camera's frame, and after rigid motions: the camera's pose relative to a scanner is
unknown.
"""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.plane import in_plane
from raxel.geometry import transform

PLACES = 101
# Fraction of the largest effect of a motion: motions of the scan along itself have less
# and are excluded.
ALONG_ITSELF = 0.05


class Scan(NamedTuple):
    """x (N,) mm from the clamp, points (N, 2) mm, and normals (N, 2), unit, in the
    direction of the deflection; at_load: index of the point closest to the load."""

    x: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    at_load: int

    def off(self, curve):
        """Distances (N,) mm of a curve from the scan, along the normals.

        At the points where the viewing rays of the scan's points meet the curve.
        """
        found = curve.points(self.points[:, 0] / self.points[:, 1])
        return np.einsum("ij,ij->i", found - self.points, self.normals)

    def moved(self, centre):
        """Changes (N, 3) of `off` by two shifts and a rotation about a centre.

        centre: (2,) mm; shifts in mm, the rotation in radians.
        """
        from_centre = self.points - centre
        turn = self.normals[:, 1] * from_centre[:, 0]
        turn -= self.normals[:, 0] * from_centre[:, 1]
        return np.column_stack([self.normals, turn])


def scan_of(rig, camera, angle):
    """The Scan of a true camera's mirror; angle: of the u axis, radians."""
    mirror = camera.mirror
    x = np.linspace(0, mirror.end, PLACES)
    on = np.column_stack([x, 0 * x, mirror.height(x, 0 * x)[0]])
    points = in_plane(transform(camera.T_viewer_mirror, on), angle)
    along = np.gradient(points, axis=0)
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals *= np.sign(normals[0] @ in_plane(rig.deflection_direction(), angle))
    load = np.argmin(np.abs(x - camera.mirror.profile.places[0]))
    return Scan(x, points, normals, int(load))


def aligned(scans, off):
    """Offsets (N,) from two scans after the motion that fits the first best.

    scans: those before and after, by a static scanner; off: the offsets of a curve from
    each, in the camera's frame.
    """
    centre = scans[0].points.mean(axis=0)
    motion = _motion(scans[0].moved(centre), off[0])
    return [o - scan.moved(centre) @ motion for scan, o in zip(scans, off, strict=True)]


def alone(scan, off):
    """Offsets (N,) from one scan after the motion that fits it best."""
    change = scan.moved(scan.points.mean(axis=0))
    return off - change @ _motion(change, off)


def _motion(change, off):
    """Least-squares shifts and rotation (3,), without motion along the scan."""
    # Equal weight of both shifts: the smallest motion has no part along the scan.
    size = np.array([1.0, 1.0, np.sqrt(len(off)) / np.linalg.norm(change[:, 2])])
    return size * np.linalg.lstsq(change * size, off, rcond=ALONG_ITSELF)[0]
