"""A viewer that sees the world in one curved mirror: what all such cameras share."""

import numpy as np

from raxel.cameras.core.base import Camera, Projection, Rays, as_rows
from raxel.cameras.core.nested import checked_rigid, finite_rows
from raxel.cameras.linear.orthographic import OrthographicCamera
from raxel.cameras.mirrors.reflection_point import reflection_points
from raxel.cameras.mirrors.viewer import checked_viewer
from raxel.geometry.poses import inverse_pose, rotate, transform

# A stationary path is a reflection if light retraces it: misses relative to the
# mirror's radius, and as an angle. Newton ends far below; false solutions far above.
RETRACE_LENGTH, RETRACE_ANGLE = 1e-7, 1e-7


class MirrorCamera(Camera):
    """Frame: the viewer's. A ray starts at the mirror and runs into the world.

    mirror: a surface with reflect, point, normals, chart, chart_extent, radius and
    inside, in its own frame, as `ConicMirror` and `SheetMirror` have them.
    """

    def _place(self, viewer, mirror, T_viewer_mirror):
        self.viewer, self.mirror = checked_viewer(viewer), mirror
        self.width, self.height = self.viewer.width, self.viewer.height
        self.T_viewer_mirror = checked_rigid("T_viewer_mirror", T_viewer_mirror)
        self._T_mirror_viewer = inverse_pose(self.T_viewer_mirror)
        self._parallel = isinstance(self.viewer, OrthographicCamera)
        # In the mirror's frame: the viewer's centre and its axis.
        self._eye = self._T_mirror_viewer[:3, 3]
        self._axis = self._T_mirror_viewer[:3, 2]

    def rays(self, pixels):
        """Rays of pixels (N, 2); origins on the mirror."""
        seen = self.viewer.rays(as_rows(pixels, 2))
        met = self.mirror.reflect(
            transform(self._T_mirror_viewer, seen.origins),
            rotate(self._T_mirror_viewer, seen.directions),
        )
        return Rays(
            transform(self.T_viewer_mirror, met.points),
            rotate(self.T_viewer_mirror, met.directions),
            met.valid,
        )

    def project(self, points):
        """Pixels of points (N, 3): where the path from the viewer is stationary."""
        points = transform(self._T_mirror_viewer, finite_rows(points))
        M = self._shown_at(points)
        pixels, valid = self.viewer.project(transform(self.T_viewer_mirror, M))
        return Projection(pixels, valid)

    def _shown_at(self, points):
        """Mirror points (N, 3) of scene points (N, 3), in the mirror's frame."""
        return reflection_points(self.mirror, points, self._arrivals, self._retraces)

    def _arrivals(self, M):
        """Directions from viewer to mirror points (N, 3), and one over the distance."""
        if self._parallel:
            return np.broadcast_to(self._axis, M.shape), np.zeros(len(M))
        reach = M - self._eye
        with np.errstate(divide="ignore", invalid="ignore"):
            near = 1 / np.linalg.norm(reach, axis=1)
            return reach * near[:, None], near

    def _retraces(self, M, points):
        """Which viewer's rays to mirror points (N, 3) go on to the points (N, 3)."""
        directions, _ = self._arrivals(M)
        if self._parallel:
            with np.errstate(invalid="ignore"):
                height = (M - self._eye) @ self._axis
                origins = M - height[:, None] * self._axis
        else:
            origins = np.broadcast_to(self._eye, M.shape)
        met = self.mirror.reflect(origins, directions)
        with np.errstate(invalid="ignore"):
            miss = np.linalg.norm(met.points - M, axis=1)
            reach = points - M
            along = np.sum(reach * met.directions, axis=1)
            off = np.linalg.norm(np.cross(reach, met.directions), axis=1)
            slack = RETRACE_LENGTH * self.mirror.radius
            straight = off <= RETRACE_ANGLE * along + slack
            seen = self.viewer.project(transform(self.T_viewer_mirror, M)).valid
            return seen & met.valid & (miss <= slack) & (along > 0) & straight
