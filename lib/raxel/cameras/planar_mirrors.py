"""Several planar mirrors before one viewer: catadioptric stereo (2.2.3)."""

import numpy as np

from raxel.cameras.base import Camera, Projection, Rays, as_rows, checked_array
from raxel.cameras.nested import (
    checked_rigid,
    checked_viewer,
    finite_rows,
    nested_fields,
)
from raxel.cameras.orthographic import OrthographicCamera
from raxel.errors import InputError
from raxel.geometry.poses import inverse_pose, rotate, transform

# Along a leaving ray, mm: nearer hits are the facet it leaves.
LEAVING = 1e-9


class PlanarMirrorsCamera(Camera):
    """A viewer that sees the world in flat facets. Frame: the viewer's.

    viewer: as for QuadricMirrorCamera. T_viewer_facets: (F, 4, 4), mm; facet k lies in
    z = 0 of its frame. outlines: F polygons (n, 2), n >= 3, the facet's corners in its
    plane in order, mm, without crossing edges. The side towards the viewer is silvered.

    A pixel has a ray where its viewer's ray meets a facet and, once turned, no other.
    The camera is discontinuous, and never central: every facet has its own centre,
    the viewer's mirror image. A point may have a pixel in each facet.
    Raises InputError for a facet behind the viewer or edge on to it, and for outlines
    that enclose nothing.
    Source: Gluckman, Nayar 2001, Catadioptric stereo using planar mirrors,
    International Journal of Computer Vision 44(1).
    """

    kind = "planar mirrors"
    central = False

    def __init__(self, viewer, T_viewer_facets, outlines):
        self.viewer = checked_viewer(viewer)
        self.width, self.height = self.viewer.width, self.viewer.height
        if len(T_viewer_facets) == 0 or len(T_viewer_facets) != len(outlines):
            raise InputError(
                f"field 'outlines': found {len(outlines)} outlines for "
                f"{len(T_viewer_facets)} poses; each facet needs one of both"
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

    @property
    def facets(self):
        """Number of facets."""
        return len(self.outlines)

    @property
    def parameters(self):
        """The viewer's, and three per facet: its plane. Outlines bound the field."""
        return self.viewer.parameters + 3 * self.facets

    def facet_of(self, pixels):
        """Number of the facet (N,) that pixels (N, 2) show, -1 where there is none."""
        seen = self.viewer.rays(as_rows(pixels, 2))
        facet, _ = self._first_facet(seen.origins, seen.directions)
        return facet

    def rays(self, pixels):
        """Rays of pixels (N, 2); origins on the facets."""
        seen = self.viewer.rays(as_rows(pixels, 2))
        facet, distance = self._first_facet(seen.origins, seen.directions)
        valid = facet >= 0
        normals = self.T_viewer_facets[facet, :3, 2]
        with np.errstate(invalid="ignore"):
            origins = seen.origins + distance[:, None] * seen.directions
            towards = np.sum(seen.directions * normals, axis=1)
            directions = seen.directions - 2 * towards[:, None] * normals
        again, _ = self._first_facet(origins, directions, other_than=facet)
        valid &= again < 0
        keep = valid[:, None]
        return Rays(
            np.where(keep, origins, np.nan), np.where(keep, directions, np.nan), valid
        )

    def project(self, points):
        """Pixels of points (N, 3) in the first facet, by number, that shows them."""
        pixels = np.full((len(points), 2), np.nan)
        for k in range(self.facets):
            seen = self.project_facet(points, k)
            take = seen.valid & np.isnan(pixels[:, 0])
            pixels[take] = seen.pixels[take]
        return Projection(pixels, np.isfinite(pixels[:, 0]))

    def project_facet(self, points, facet):
        """Pixels of points (N, 3) in one facet: the viewer sees their mirror images."""
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
        """Sign of the side of facet k, along its z, that its viewer sees."""
        T = self.T_viewer_facets[k]
        return np.sign(-T[2, 2] if self._parallel else -T[:3, 3] @ T[:3, 2])

    def _first_facet(self, origins, directions, other_than=None):
        """Facet (N,) that rays meet first, distance to it; -1 and NaN for none."""
        nearest = np.full(len(origins), np.inf)
        facet = np.full(len(origins), -1)
        for k, T in enumerate(self.T_viewer_facets):
            T_facet_viewer = inverse_pose(T)
            o = transform(T_facet_viewer, origins)
            d = rotate(T_facet_viewer, directions)
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = -o[:, 2] / d[:, 2]
                place = o[:, :2] + distance[:, None] * d[:, :2]
                hit = (distance > LEAVING) & (distance < nearest)
            if other_than is not None:
                hit &= other_than != k
            hit[hit] = inside_outline(place[hit], self.outlines[k])
            nearest[hit], facet[hit] = distance[hit], k
        return facet, np.where(facet >= 0, nearest, np.nan)

    def _check_facet(self, k):
        T, outline = self.T_viewer_facets[k], self.outlines[k]
        x, y = outline.T
        area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
        if len(outline) < 3 or abs(area) < 1e-12 * np.ptp(outline) ** 2:
            raise InputError(
                f"field 'outlines[{k}]': found {len(outline)} corners around no area; "
                "give at least three that are not on one line"
            )
        corners = transform(T, np.column_stack([outline, np.zeros(len(outline))]))
        if corners[:, 2].max() <= 0:
            raise InputError(
                f"field 'T_viewer_facets[{k}]': the facet is behind the viewer; its "
                "corners need z > 0"
            )
        height = T[2, 2] if self._parallel else T[:3, 3] @ T[:3, 2]
        scale = 1 if self._parallel else np.linalg.norm(corners, axis=1).max()
        if abs(height) <= 1e-9 * scale:
            raise InputError(
                f"field 'T_viewer_facets[{k}]': the viewer sees the facet edge on; "
                "turn it"
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
                f"field 'corner_counts': adds up to {counts.sum()} for {len(corners)} "
                "corners; save it anew"
            )
        return cls(
            file.nested("viewer"),
            file.numbers("T_viewer_facets", axes=3),
            np.split(corners, np.cumsum(counts)[:-1]),
        )


def inside_outline(points, outline):
    """Which points (N, 2) a polygon (n, 2) encloses: odd edges to their right.

    Points on an edge belong to one of the polygons that share it.
    """
    x, y = points.T
    inside = np.zeros(len(points), bool)
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if y0 == y1:
            continue
        crosses = (y0 > y) != (y1 > y)
        inside ^= crosses & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return inside
