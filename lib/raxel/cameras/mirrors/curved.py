"""Common part of all cameras with one curved mirror."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    checked_rigid,
    finite_rows,
)
from raxel.cameras.linear.line_cameras import OrthographicCamera
from raxel.errors import InputError
from raxel.geometry.poses import inverse_pose, rotate, transform

# A stationary path is a reflection if light retraces it: error relative to the mirror's
# radius, and as an angle. Newton ends far below; false solutions are far above.
RETRACE_LENGTH_TOL, RETRACE_ANGLE_TOL_RAD = 1e-7, 1e-7


class MirrorCamera(Camera):
    """Frame: that of the viewer, the camera that views the mirror. A ray starts at the
    mirror and points into the world.

    mirror: a surface with reflect, point, normals, chart, chart_extent, radius and
    inside, in its own frame, as `ConicMirror` and `SheetMirror`.
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

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays; origins on the mirror."""
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

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points: where the path from the viewer is stationary.
        """
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
        """Which viewer's rays to mirror points (N, 3) continue to points (N, 3)."""
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
            errors = np.linalg.norm(np.cross(reach, met.directions), axis=1)
            slack = RETRACE_LENGTH_TOL * self.mirror.radius
            straight = errors <= RETRACE_ANGLE_TOL_RAD * along + slack
            seen = self.viewer.project(transform(self.T_viewer_mirror, M)).valid
            return seen & met.valid & (miss <= slack) & (along > 0) & straight


# Test of the camera that views mirrors.


def checked_viewer(viewer):
    """The viewer, if a mirror camera accepts it.

    Raises InputError for anything but an OrthographicCamera or a central camera with
    its centre at the origin of its frame.
    """
    if not isinstance(viewer, Camera):
        raise InputError(
            f"field 'viewer': found {type(viewer).__name__}; give a camera"
        )
    if isinstance(viewer, OrthographicCamera):
        return viewer
    centre = getattr(viewer, "origins", None)
    if centre is None:
        centre = getattr(viewer, "centre", None)
    if not viewer.central or (centre is not None and np.any(centre)):
        raise InputError(
            f"field 'viewer': the rays of the {viewer.kind} camera do not all start at "
            "the origin; give a central or an orthographic camera"
        )
    return viewer


# The point of a mirror that shows a scene point to a viewer (Alhazen's problem). By
# Fermat the length of the path from the viewer over the mirror point M to the scene
# point is stationary. In the chart p of `ConicMirror.point` that is two equations
# g(p) = J^T (a + b) = 0, J the derivatives of M, a the unit direction in which light
# reaches M from the viewer's side, b the unit vector from the scene point to M.


BLOCK = 2048
# Rings and spokes of the grid of starts, and number of tried starts: a convex mirror
# has one reflection, a concave one may have several close together.
CONVEX_START_GRID, CONCAVE_START_GRID = (8, 16, 4), (12, 24, 24)
MAX_N_STEPS = 80
# Newton step at convergence, over the chart's extent at the edge.
STEP_TOL = 1e-12
MAX_STEP = 0.3
CHART_MARGIN = 1.5


def reflection_points(mirror, points, arrivals, accept):
    """Mirror points (N, 3) of scene points (N, 3), NaN without one.

    mirror: `ConicMirror`, everything in its frame, mm. arrivals(M (n, 3)) gives unit
    directions (n, 3) from the viewer to M and the curvature of their wave front (n,),
    one over the distance, zero for parallel rays. accept(M, points) -> (n,) bool
    selects the stationary points that are true reflections. Others, such as reflections
    off the back, are skipped for the next start. A point with several reflections, as
    on concave mirrors, gets the one with the best coarse start; the grid of starts may
    miss two nearly coincident reflections next to the caustic.
    """
    found = np.full((len(points), 3), np.nan)
    for first in range(0, len(points), BLOCK):
        block = points[first : first + BLOCK]
        starts = _starts(mirror, block, arrivals)
        open_rows = np.arange(len(block))
        for k in range(starts.shape[1]):
            p = starts[open_rows, k]
            scene = block[open_rows]
            known = np.isfinite(p[:, 0]) & np.isfinite(scene).all(axis=1)
            rows, p, scene = open_rows[known], p[known], scene[known]
            p, settled = _newton(mirror, p, scene, arrivals)
            M = mirror.point(p)[0]
            good = settled & accept(M, scene)
            found[first + rows[good]] = M[good]
            open_rows = np.setdiff1d(open_rows, rows[good], assume_unique=True)
    return found


def stationarity(mirror, p, points, arrivals):
    """Equations (N, 2) that vanish with g, and their derivative (N, 2, 2), in mm^2.

    They are g times the distance l from M to the scene point: J^T (l a + M - X). Near
    the mirror g alone changes abruptly, while these stay nearly linear.
    """
    M, J, second = mirror.point(p)
    a, a_curvature = arrivals(M)
    reach = M - points
    # A point on the mirror has no direction, and gets no reflection.
    distance = np.linalg.norm(reach, axis=1)
    distance = np.where(distance > 0, distance, np.nan)
    total = distance[:, None] * a + reach
    square = np.einsum("nik,nil->nkl", J, J)
    along_a = np.einsum("nik,ni->nk", J, a)
    along_b = np.einsum("nik,ni->nk", J, reach / distance[:, None])
    turn = square - along_a[:, :, None] * along_a[:, None, :]
    slope = np.einsum("nikl,ni->nkl", second, total) + square
    slope += (distance * a_curvature)[:, None, None] * turn
    slope += along_a[:, :, None] * along_b[:, None, :]
    return np.einsum("nik,ni->nk", J, total), slope


def _starts(mirror, points, arrivals):
    """Initial chart points (N, S, 2), NaN after the last of a row.

    They are the local minima, best first, on a polar grid over the mirror, of the angle
    between the bisector of the two directions and the normal; on a concave mirror other
    grid points follow. Last is the mirror position next to a point that is too close
    for the grid.
    """
    rings, spokes, count = CONCAVE_START_GRID if mirror.inside else CONVEX_START_GRID
    extent = mirror.chart_extent
    ring = extent * (np.arange(rings) + 0.5) / rings
    angle = 2 * np.pi * np.arange(spokes) / spokes
    p = ring[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    p = p.reshape(-1, 2)
    M = mirror.point(p)[0]
    n = mirror.normals(M)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    a, _ = arrivals(M)
    b = M - points[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        b /= np.linalg.norm(b, axis=2, keepdims=True)
        total = a + b
        across = np.sum(total**2, axis=2) - np.einsum("nki,ki->nk", total, n) ** 2
        behind = (np.einsum("nki,ki->nk", b, n) > 0) | (np.sum(a * n, axis=1) > 0)
    cost = np.where(behind, across + 4, across).reshape(-1, rings, spokes)
    cost = np.where(np.isfinite(cost), cost, np.inf)
    padded = np.pad(cost, ((0, 0), (1, 1), (0, 0)), constant_values=np.inf)
    lowest = (cost <= padded[:, :-2]) & (cost <= padded[:, 2:])
    lowest &= (cost <= np.roll(cost, 1, axis=2)) & (cost <= np.roll(cost, -1, axis=2))
    cost = np.where(lowest, cost, cost + 8 if mirror.inside else np.inf)
    cost = cost.reshape(len(points), -1)
    order = np.argsort(cost, axis=1, kind="stable")[:, :count]
    chosen = p[order]
    chosen[~np.isfinite(np.take_along_axis(cost, order, axis=1))] = np.nan
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        next_to = mirror.chart(points)
        length = np.linalg.norm(next_to, axis=1, keepdims=True)
        next_to *= np.minimum(1, extent / length)
    return np.concatenate([chosen, next_to[:, None]], axis=1)


def _newton(mirror, p, points, arrivals):
    """Solve g = 0 by Newton steps, halved until |g| falls. Returns p and convergence.

    Rows are independent, so results do not depend on neighbours.
    """
    extent = mirror.chart_extent
    limit = CHART_MARGIN * extent
    p, settled = p.copy(), np.zeros(len(p), bool)
    rows = np.arange(len(p))
    g, H = stationarity(mirror, p, points, arrivals)
    share = np.ones(len(p))
    for _ in range(MAX_N_STEPS):
        with np.errstate(all="ignore"):
            step = _solve(H, -g)
            length = np.linalg.norm(step, axis=1)
            share_now = share * np.minimum(1, MAX_STEP * extent / length)
        last = length <= STEP_TOL * extent
        trial = p[rows] + step * np.where(last, 1, share_now)[:, None]
        usable = np.linalg.norm(trial, axis=1) < limit
        trial = np.where(usable[:, None], trial, p[rows])
        new_g, new_H = stationarity(mirror, trial, points[rows], arrivals)
        better = np.sum(new_g**2, axis=1) < np.sum(g**2, axis=1)
        better = usable & (better | last)
        p[rows[better]] = trial[better]
        settled[rows[last & usable]] = True
        share = np.where(better, np.minimum(1, 2 * share), share / 2)
        g = np.where(better[:, None], new_g, g)
        H = np.where(better[:, None, None], new_H, H)
        going = ~last & np.isfinite(length) & (share > 1e-9)
        if not going.any():
            break
        rows, g, H, share = rows[going], g[going], H[going], share[going]
    return p, settled


def _solve(H, g):
    """H^-1 g for 2 x 2 matrices (N, 2, 2); not finite where singular."""
    det = H[:, 0, 0] * H[:, 1, 1] - H[:, 0, 1] * H[:, 1, 0]
    x = H[:, 1, 1] * g[:, 0] - H[:, 0, 1] * g[:, 1]
    y = H[:, 0, 0] * g[:, 1] - H[:, 1, 0] * g[:, 0]
    return np.column_stack([x, y]) / det[:, None]
