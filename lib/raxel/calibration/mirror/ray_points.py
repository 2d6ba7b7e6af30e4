"""Distances of scene points from the scene rays of a spline mirror (5.29), as vectors.

The length of the vector is the thesis's scalar distance: the sum of squares is the
same, but the root in the scalar makes Gauss-Newton stall, and the vector's Jacobian is
smooth. With the normal m = M c, linear in the coefficients c, the unit viewing ray V,
the scene ray V_r = V - 2 (V . m) m / m.m, q = P - S and a = V_r . q:

    r = (I - V_r V_r^T) q
    dr/dc = -(a I + V_r q^T) G M - (I - V_r V_r^T) dS/dc
    G = -2 [m V^T / m.m + (V . m) / m.m I - 2 (V . m) / (m.m)^2 m m^T]
"""

import numpy as np

from raxel.cameras.mirrors.spline_surface import depth_rows, normal_rows

STEP = 1e-6  # of normalised image coordinates, for the change with the viewing ray


class RayPoints:
    """Viewing rays fixed, coefficients to be found: what does not change is kept.

    p: (N, 2) normalised image coordinates, inside the grid's box; grid: SplineGrid;
    quantity: see `spline_surface`. It takes some 1.5 kB for each point and 21
    coefficients.
    """

    def __init__(self, p, grid, quantity):
        self.p, self.grid, self.quantity = p, grid, quantity
        rows = depth_rows(grid, p, quantity)
        self.depth_rows = rows[0]
        self.normal_rows = normal_rows(p, rows, quantity)
        self.w = np.column_stack([p, np.ones(len(p))])
        self.viewing = self.w / np.linalg.norm(self.w, axis=1, keepdims=True)

    def surface(self, c):
        """Mirror points (N, 3), unit scene directions (N, 3) of coefficients (K,)."""
        m = self.normal_rows @ c
        turn = 2 * _dot(self.viewing, m) / _dot(m, m)
        scene = self.viewing - turn[:, None] * m
        depth = self.depth_rows @ c
        depth = depth if self.quantity == "distance" else 1 / depth
        return depth[:, None] * self.w, scene

    def in_front(self, c):
        """Whether all mirror points lie before the viewer."""
        return bool(np.all(self.depth_rows @ c > 0))

    def residuals(self, c, points):
        """Vectors (N, 3), mm, from the scene rays to points (N, 3)."""
        S, scene = self.surface(c)
        q = points - S
        return q - _dot(scene, q)[:, None] * scene

    def jacobian(self, c, points):
        """(N, 3, K): change of the residuals with the coefficients."""
        S, scene = self.surface(c)
        by_direction, across = self._parts(scene, points - S)
        jacobian = (by_direction @ self._turning(c)) @ self.normal_rows
        sliding = np.einsum("nij,nj->ni", across, self._slide(c))
        jacobian -= sliding[:, :, None] * self.depth_rows[:, None, :]
        return jacobian

    def direction_jacobian(self, c):
        """(N, 3, K): change of the unit scene directions with the coefficients."""
        return self._turning(c) @ self.normal_rows

    def across(self, c):
        """(N, 3, 3): change of the residuals with the points."""
        scene = self.surface(c)[1]
        return np.eye(3) - scene[:, :, None] * scene[:, None, :]

    def picture_jacobian(self, c, points):
        """(N, 3, 2): change of the residuals with the viewing rays' p, by differences.

        One-sided where the other side lies outside the box.
        """
        shifts = STEP * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        ends = (self.p + shifts[:, None]).reshape(-1, 2)
        stay = np.tile(self.p, (4, 1))
        ends = np.where(self.grid.inside(ends)[:, None], ends, stay)
        off = RayPoints(ends, self.grid, self.quantity)
        off = off.residuals(c, np.tile(points, (4, 1))).reshape(2, 2, -1, 3)
        ends = ends.reshape(2, 2, -1, 2)
        width = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=2)
        return np.moveaxis((off[:, 0] - off[:, 1]) / width[:, :, None], 0, 2)

    def _parts(self, scene, q):
        a = _dot(scene, q)
        by_direction = -scene[:, :, None] * q[:, None, :]
        by_direction -= a[:, None, None] * np.eye(3)
        return by_direction, np.eye(3) - scene[:, :, None] * scene[:, None, :]

    def _turning(self, c):
        """G (N, 3, 3): change of scene directions with the normals m."""
        V, m = self.viewing, self.normal_rows @ c
        mm, Vm = _dot(m, m), _dot(V, m)
        G = m[:, :, None] * (V / mm[:, None])[:, None, :]
        G += (Vm / mm)[:, None, None] * np.eye(3)
        G -= (2 * Vm / mm**2)[:, None, None] * m[:, :, None] * m[:, None, :]
        return -2 * G

    def _slide(self, c):
        """(N, 3): change of mirror points with what the depth rows give."""
        if self.quantity == "distance":
            return self.w
        return -self.w / ((self.depth_rows @ c) ** 2)[:, None]


def _dot(a, b):
    return np.einsum("ni,ni->n", a, b)
