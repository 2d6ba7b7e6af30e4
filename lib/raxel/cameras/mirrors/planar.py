"""Several planar mirrors and one viewing camera: catadioptric stereo (2.2.3)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    checked_array,
    checked_rigid,
    finite_rows,
    nested_fields,
)
from raxel.cameras.linear.line_cameras import OrthographicCamera
from raxel.cameras.mirrors.bent import ball_facets
from raxel.cameras.mirrors.curved import checked_viewer
from raxel.errors import InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

# Along a reflected ray: closer intersections are the facet that it leaves.
MIN_HIT_MM = 1e-9
# Of a squared distance to a facet, in the test for a miss.
DISTANCE_TOL = 1e-11


class PlanarMirrorsCamera(Camera):
    """A viewer that sees the world in flat facets. Frame: the viewer's.

    The side towards the viewer is silvered. A pixel has a ray where its viewer's ray
    meets a facet and, once reflected, no other. The camera is discontinuous, and never
    central: every facet has its own centre, the viewer's mirror image. A point may have
    a pixel in each facet.

    Parameters
    ----------
    viewer : Camera
        As for `QuadricMirrorCamera`.
    T_viewer_facets : array_like, shape (F, 4, 4)
        Poses, mm; facet k is in z = 0 of its frame.
    outlines : sequence of F array_like, shape (n, 2)
        Corners of each facet in its plane in order, n >= 3, mm, without crossing edges.

    Raises
    ------
    InputError
        A facet is behind the viewer or edge on to it, or an outline encloses nothing.

    References
    ----------
    Gluckman, Nayar 2001, Catadioptric stereo using planar mirrors, International
    Journal of Computer Vision 44(1).
    """

    kind = "planar mirrors"
    central = False
    continuous = False

    def __init__(
        self,
        viewer: Camera,
        T_viewer_facets: Sequence[ArrayLike],
        outlines: Sequence[ArrayLike],
    ) -> None:
        self.viewer = checked_viewer(viewer)
        self.width, self.height = self.viewer.width, self.viewer.height
        if len(T_viewer_facets) == 0 or len(T_viewer_facets) != len(outlines):
            raise InputError(
                f"field 'outlines': found {len(outlines)} outlines for "
                f"{len(T_viewer_facets)} poses; give one of each per facet"
            )
        self.T_viewer_facets = np.stack(
            [
                checked_rigid(f"T_viewer_facets[{k}]", T)
                for k, T in enumerate(T_viewer_facets)
            ]
        )
        self.outlines = [
            checked_array(f"outlines[{k}]", outline, (None, 2))
            for k, outline in enumerate(outlines)
        ]
        self._parallel = isinstance(self.viewer, OrthographicCamera)
        for k in range(len(self.outlines)):
            self._check_facet(k)

    @classmethod
    def on_ball(cls, viewer: Camera, **ball: Any) -> PlanarMirrorsCamera:
        """Return the camera of a mirror ball, see `ball_facets`, and a viewer."""
        return cls(viewer, *ball_facets(**ball))

    @property
    def facets(self) -> int:
        """Number of facets."""
        return len(self.outlines)

    @property
    def parameters(self) -> int:
        """The viewer's, and three per facet: its plane. Outlines bound the field."""
        return self.viewer.parameters + 3 * self.facets

    def facet_of(self, pixels: ArrayLike) -> NDArray[np.intp]:
        """Return the facets `(N,)` that pixels `(N, 2)` show, -1 for none."""
        seen = self.viewer.rays(as_rows(pixels, 2))
        facet, _ = self._first_facet(seen.origins, seen.directions)
        return facet

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays; origins on the facets."""
        seen = self.viewer.rays(as_rows(pixels, 2))
        facet, distance = self._first_facet(seen.origins, seen.directions)
        valid = facet >= 0
        normals = self.T_viewer_facets[facet, :3, 2]
        with np.errstate(invalid="ignore"):
            origins = seen.origins + distance[:, None] * seen.directions
            towards = np.sum(seen.directions * normals, axis=1)
            directions = seen.directions - 2 * towards[:, None] * normals
        valid &= ~_meets_another(
            origins, directions, facet, *self._polygons, *self._ahead
        )
        keep = valid[:, None]
        return Rays(
            np.where(keep, origins, np.nan), np.where(keep, directions, np.nan), valid
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
            Pixels of points in the first facet, by number, that shows them.
        """
        pixels = np.full((len(points), 2), np.nan)  # type: ignore[arg-type]
        for k in range(self.facets):
            seen = self.project_facet(points, k)
            take = seen.valid & np.isnan(pixels[:, 0])
            pixels[take] = seen.pixels[take]
        return Projection(pixels, np.isfinite(pixels[:, 0]))

    def project_facet(self, points: ArrayLike, facet: int) -> Projection:
        """Return the pixels of points in one facet.

        The viewer sees their mirror images.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the viewer's frame, mm.
        facet : int
            Number of the facet.

        Returns
        -------
        Projection
            Pixels.
        """
        points = finite_rows(points)
        T = self.T_viewer_facets[facet]
        height = (points - T[:3, 3]) @ T[:3, 2]
        front = height * self._side_of_viewer(facet) > 0
        images = points - 2 * height[:, None] * T[:3, 2]
        pixels, valid = self.viewer.project(np.where(front[:, None], images, np.nan))
        valid &= self.facet_of(pixels) == facet
        valid &= self.rays(pixels).valid
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def _side_of_viewer(self, k):
        """Sign of the side of facet k, along its z, that the viewer sees."""
        T = self.T_viewer_facets[k]
        return np.sign(-T[2, 2] if self._parallel else -T[:3, 3] @ T[:3, 2])

    def _first_facet(self, origins, directions):
        """First facet (N,) on rays, and distance to it; -1 and NaN for none."""
        origins = np.ascontiguousarray(np.broadcast_to(origins, directions.shape))
        directions = np.ascontiguousarray(directions)
        return _nearest_facet(origins, directions, *self._polygons, *self._spheres)

    @cached_property
    def _polygons(self):
        """Poses of the facets, corners (C, 2) of all outlines, where each stops."""
        counts = [len(outline) for outline in self.outlines]
        return self.T_viewer_facets, np.vstack(self.outlines), np.cumsum(counts)

    @cached_property
    def _pieces(self):
        """The corners of each facet, (n, 3), in the viewer's frame."""
        return [
            transform(T, on_plane(outline))
            for T, outline in zip(self.T_viewer_facets, self.outlines, strict=True)
        ]

    @cached_property
    def _spheres(self):
        return _tree_of_spheres(self._pieces)

    @cached_property
    def _ahead(self):
        """For each facet, the others that a reflected ray may meet; end of each list.

        A facet that is nowhere in front of the plane of another is not met from there.
        """
        corners = np.vstack(self._pieces)
        starts = np.append(0, self._polygons[2][:-1])
        found = []
        for k, T in enumerate(self.T_viewer_facets):
            height = (corners - T[:3, 3]) @ T[:3, 2] * self._side_of_viewer(k)
            others = np.flatnonzero(np.maximum.reduceat(height, starts) > MIN_HIT_MM)
            found.append(others[others != k])
        return np.concatenate(found), np.cumsum([len(others) for others in found])

    def _check_facet(self, k):
        T, outline = self.T_viewer_facets[k], self.outlines[k]
        x, y = outline.T
        area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
        if len(outline) < 3 or abs(area) < 1e-12 * np.ptp(outline) ** 2:
            raise InputError(
                f"field 'outlines[{k}]': {len(outline)} corners enclose no area; give "
                "at least three that are not collinear"
            )
        corners = transform(T, np.column_stack([outline, np.zeros(len(outline))]))
        if corners[:, 2].max() <= 0:
            raise InputError(
                f"field 'T_viewer_facets[{k}]': the facet is behind the viewer; give "
                "corners with z > 0"
            )
        height = T[2, 2] if self._parallel else T[:3, 3] @ T[:3, 2]
        scale = 1 if self._parallel else np.linalg.norm(corners, axis=1).max()
        if abs(height) <= 1e-9 * scale:
            raise InputError(
                f"field 'T_viewer_facets[{k}]': the viewer sees the facet edge-on; "
                "rotate it"
            )

    def _fields(self):
        return nested_fields("viewer", self.viewer) | {
            "T_viewer_facets": self.T_viewer_facets,
            "corners": np.vstack(self.outlines),
            "corner_counts": np.array([len(outline) for outline in self.outlines]),
        }

    @classmethod
    def _from_file(cls, file):
        counts = file.numbers("corner_counts", axes=1)
        corners = file.numbers("corners", axes=2)
        whole = counts.dtype.kind in "iu" and (counts >= 0).all()
        if not whole or counts.sum() != len(corners):
            raise InputError(
                f"field 'corner_counts': the sum is {counts.sum()} for {len(corners)} "
                "corners; save the file anew"
            )
        return cls(
            file.nested("viewer"),
            file.numbers("T_viewer_facets", axes=3),
            np.split(corners, np.cumsum(counts)[:-1]),
        )


def _tree_of_spheres(pieces):
    """Spheres about the corners of F facets, each (n, 3), halved down to one facet.

    Returns spheres (S, 4), middle and squared radius, the first about all; after each
    come those inside it. beyond (S,): the next one that is not inside; only (S,): its
    facet if it holds one alone, else -1.
    """
    middles = np.array([piece.mean(axis=0) for piece in pieces])
    spheres, beyond, only = [], [], []

    def add(group):
        inside = np.vstack([pieces[k] for k in group])
        middle = inside.mean(axis=0)
        number = len(spheres)
        spheres.append([*middle, ((inside - middle) ** 2).sum(axis=1).max()])
        beyond.append(None)
        only.append(group[0] if len(group) == 1 else -1)
        if len(group) > 1:
            axis = np.argmax(np.ptp(middles[group], axis=0))
            group = group[np.argsort(middles[group, axis], kind="stable")]
            add(group[: len(group) // 2])
            add(group[len(group) // 2 :])
        beyond[number] = len(spheres)

    add(np.arange(len(pieces)))
    return np.array(spheres), np.array(beyond), np.array(only)


@numba.njit(cache=True, error_model="numpy")
def _nearest_facet(origins, directions, T, corners, ends, spheres, beyond, only):
    """(facet (N,), distance (N,)) of the first facet on each ray; -1 and NaN for none.

    T, corners, ends: `PlanarMirrorsCamera._polygons`; spheres, beyond, only: as
    `_tree_of_spheres`. Among equally distant facets the first by number counts.
    """
    count = len(directions)
    facet, distance = np.full(count, -1), np.full(count, np.nan)
    for n in range(count):
        nearest, s = np.inf, 0
        while s < len(spheres):
            square, along = 0.0, 0.0
            for i in range(3):
                difference = spheres[s, i] - origins[n, i]
                square += difference * difference
                along += difference * directions[n, i]
            # This form is false for NaN.
            if not square - along * along <= spheres[s, 3] + DISTANCE_TOL * square:
                s = beyond[s]
                continue
            k = only[s]
            if k >= 0:
                far = _distance(origins[n], directions[n], k, T, corners, ends)
                if far < nearest or (far == nearest < np.inf and k < facet[n]):
                    nearest, facet[n], distance[n] = far, k, far
            s += 1
    return facet, distance


@numba.njit(cache=True, error_model="numpy")
def _meets_another(origins, directions, facet, T, corners, ends, ahead, stops):
    """Whether rays (N, 3) that leave a facet (N,) meet any of those in front of it."""
    met = np.zeros(len(directions), np.bool_)
    for n in range(len(directions)):
        k = facet[n]
        if k < 0:
            continue
        for m in range(stops[k - 1] if k else 0, stops[k]):
            far = _distance(origins[n], directions[n], ahead[m], T, corners, ends)
            if far < np.inf:
                met[n] = True
                break
    return met


@numba.njit(cache=True, error_model="numpy")
def _distance(o, d, k, T, corners, ends):
    """Distance along a ray to facet k, infinite for a miss."""
    x, y, z = o[0] - T[k, 0, 3], o[1] - T[k, 1, 3], o[2] - T[k, 2, 3]
    height = x * T[k, 0, 2] + y * T[k, 1, 2] + z * T[k, 2, 2]
    slope = d[0] * T[k, 0, 2] + d[1] * T[k, 1, 2] + d[2] * T[k, 2, 2]
    far = -height / slope
    if not far > MIN_HIT_MM:
        return np.inf
    x, y, z = x + far * d[0], y + far * d[1], z + far * d[2]
    u = x * T[k, 0, 0] + y * T[k, 1, 0] + z * T[k, 2, 0]
    v = x * T[k, 0, 1] + y * T[k, 1, 1] + z * T[k, 2, 1]
    inside = _encloses(corners, ends[k - 1] if k else 0, ends[k], u, v)
    return far if inside else np.inf


@numba.njit(cache=True)
def _encloses(corners, first, end, x, y):
    """Whether the polygon corners[first:end] contains a point: odd edges to its right.

    A point on an edge belongs to one of the polygons that share it.
    """
    inside = False
    before = end - 1
    for i in range(first, end):
        x0, y0 = corners[before, 0], corners[before, 1]
        x1, y1 = corners[i, 0], corners[i, 1]
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
        before = i
    return inside
