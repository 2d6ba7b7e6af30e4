"""Several planar mirrors before one viewer: catadioptric stereo (2.2.3)."""

from functools import cached_property

import numba
import numpy as np

from raxel.cameras.base import Camera, Projection, Rays, as_rows, checked_array
from raxel.cameras.mirror_ball import ball_facets
from raxel.cameras.nested import (
    checked_rigid,
    checked_viewer,
    finite_rows,
    nested_fields,
)
from raxel.cameras.orthographic import OrthographicCamera
from raxel.errors import InputError
from raxel.geometry.poses import transform

# Along a leaving ray, mm: nearer hits are the facet it leaves.
LEAVING = 1e-9
# Of a squared distance to a facet, in telling whether a ray passes it by.
ROUNDING = 1e-12
# Facets that share a sphere, which most rays miss.
GROUP = 6


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
    continuous = False

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

    @classmethod
    def on_ball(cls, viewer, **ball):
        """The facets of a mirror ball, `ball_facets(**ball)`, before a viewer."""
        return cls(viewer, *ball_facets(**ball))

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
        if other_than is None:
            other_than = np.full(len(directions), -1)
        origins = np.broadcast_to(origins, directions.shape)
        return _nearest_facet(
            np.ascontiguousarray(origins, float),
            np.ascontiguousarray(directions, float),
            other_than.astype(np.int64),
            *self._bounds,
        )

    @cached_property
    def _bounds(self):
        """What `_nearest_facet` asks: facets, their outlines, spheres about groups."""
        counts = np.array([len(outline) for outline in self.outlines])
        corners, ends = np.vstack(self.outlines), np.cumsum(counts)
        of = np.repeat(np.arange(self.facets), counts)
        T = self.T_viewer_facets
        places = T[of, :3, 3] + np.einsum("kij,kj->ki", T[of, :3, :2], corners)
        middles = np.add.reduceat(places, ends - counts) / counts[:, None]
        groups = _near_ones(middles)
        spheres = []
        for group in groups:
            inside = places[np.isin(of, group)]
            middle = inside.mean(axis=0)
            square = ((inside - middle) ** 2).sum(axis=1).max()
            spheres.append([*middle, square * (1 + ROUNDING)])
        stops = np.cumsum(list(map(len, groups)))
        return T, corners, ends, np.array(spheres), np.concatenate(groups), stops

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


def _near_ones(places):
    """Groups of numbers of places (F, 3): halved along the longest side until small."""
    groups, open_ones = [], [np.arange(len(places))]
    while open_ones:
        group = open_ones.pop()
        if len(group) <= GROUP:
            groups.append(group)
            continue
        axis = np.argmax(np.ptp(places[group], axis=0))
        group = group[np.argsort(places[group, axis], kind="stable")]
        open_ones += [group[: len(group) // 2], group[len(group) // 2 :]]
    return groups


@numba.njit(cache=True, error_model="numpy")
def _nearest_facet(
    origins, directions, other_than, T, corners, ends, spheres, members, stops
):
    """(facet (N,), distance (N,)) of the first facet on each ray; -1 and NaN for none.

    corners (C, 2) of all outlines, ends (F,): where each stops. spheres (G, 4): middle
    and squared radius of a sphere around each group of facets; members (F,): facets by
    group, stops (G,): where each stops. Of facets equally far the first by number.
    """
    count = len(directions)
    facet, distance = np.full(count, -1), np.full(count, np.nan)
    for n in range(count):
        o, d = origins[n], directions[n]
        nearest = np.inf
        for g in range(len(stops)):
            x, y, z = spheres[g, 0] - o[0], spheres[g, 1] - o[1], spheres[g, 2] - o[2]
            along = x * d[0] + y * d[1] + z * d[2]
            square = x * x + y * y + z * z
            # So written that NaN does not pass.
            if not square - along * along <= spheres[g, 3] + ROUNDING * square:
                continue
            for m in range(stops[g - 1] if g else 0, stops[g]):
                k = members[m]
                if k == other_than[n]:
                    continue
                R, t = T[k, :3, :3], T[k, :3, 3]
                height, slope = 0.0, 0.0
                for i in range(3):
                    height += (o[i] - t[i]) * R[i, 2]
                    slope += d[i] * R[i, 2]
                far = -height / slope
                if not LEAVING < far <= nearest or (far == nearest and k > facet[n]):
                    continue
                u, v = 0.0, 0.0
                for i in range(3):
                    place = o[i] + far * d[i] - t[i]
                    u += place * R[i, 0]
                    v += place * R[i, 1]
                if _encloses(corners[ends[k - 1] if k else 0 : ends[k]], u, v):
                    nearest, facet[n], distance[n] = far, k, far
    return facet, distance


@numba.njit(cache=True)
def _encloses(outline, x, y):
    """Whether a polygon (n, 2) encloses a point: odd edges to its right.

    A point on an edge belongs to one of the polygons that share it.
    """
    inside = False
    x0, y0 = outline[-1]
    for x1, y1 in outline:
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
        x0, y0 = x1, y1
    return inside
