"""Non-central camera: a viewer before a clamped sheet of mirror that bends (5)."""

import numpy as np

from raxel.cameras.core.base import checked_array, checked_positive, checked_word
from raxel.cameras.core.nested import nested_fields
from raxel.cameras.mirrors.clamped_surface import ClampedMirror
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.profiles import PROFILES, checked_at_loads
from raxel.cameras.mirrors.reflection_point import reflection_points, stationarity
from raxel.cameras.mirrors.unevenness import WAVES, Unevenness
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector

# A sheet seen at a smaller angle hides parts of itself, and one so near to the
# viewer's centre, in mm, touches its lens.
GRAZING, TOUCHING = np.radians(5), 10.0
# Newton's steps from the reflection in a plane, the longest of them and the last one
# needed, as shares of the sheet's half diagonal.
STEPS, LONGEST_STEP, LAST_STEP = 25, 0.3, 1e-12


class FlexibleMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a clamped sheet, pushed from behind or pulled.

    Frame: the viewer's. viewer: a central camera with its centre at the origin of its
    frame, or an OrthographicCamera. size: (length from the clamp along the sheet,
    width along the clamp), mm. loads: (k,) or one, mm from the clamp, where the sheet
    is `deflections` (k,) mm off the flat one, positive away from the viewer, which
    makes the mirror convex. law: 'elastica', which keeps the sheet's length, or 'beam',
    small deflections (5.1), see `profiles`. rulings: radians, the angle between the
    ruling through the middle of the free edge and the clamp's line, see
    `ClampedMirror`. aberration (RMS), wavelengths (least, greatest), strain of the free
    edges, its reach: mm; seed: see `Unevenness`. holder: length of sheet that the
    clamp's holder hides, mm. T_viewer_mirror: (4, 4), mm; the mirror's x axis runs
    from the clamp to the free edge, its y axis is the clamp's line with the origin
    mid-way, its z axis points away from the viewer. Or `offset` (3,), mm, and
    `rotation` (3,), a rotation vector in radians, of the mirror's frame in the
    viewer's.

    Raises InputError for a sheet that the viewer is behind, touches, or sees at less
    than 5 degrees, and for values no such camera can have.
    Source: thesis 5.1.
    """

    kind = "flexible mirror"

    def __init__(
        self,
        viewer,
        size,
        loads,
        deflections,
        law="elastica",
        rulings=0.0,
        aberration=0.0,
        wavelengths=(45.0, 110.0),
        seed=0,
        strain=0.0,
        strain_reach=5.0,
        holder=0.0,
        offset=(0.0, 0.0, 0.0),
        rotation=(0.0, 0.0, 0.0),
        T_viewer_mirror=None,
    ):
        self.law = checked_word("law", law, tuple(PROFILES))
        profile = PROFILES[self.law].deflected(loads, deflections)
        size = checked_positive("size", size, (2,))
        uneven = Unevenness(size, aberration, wavelengths, seed, strain, strain_reach)
        mirror = ClampedMirror(profile, size, rulings, uneven, holder)
        self.deflections = checked_at_loads("deflections", deflections, profile.loads)
        if T_viewer_mirror is None:
            R = rotation_from_vector(checked_array("rotation", rotation, (3,)))
            T_viewer_mirror = pose(R, checked_array("offset", offset, (3,)))
        self._place(viewer, mirror, T_viewer_mirror)
        self._check_view()

    def _check_view(self):
        nodes, _, _ = self._sheet_nodes()
        incidence, near = self._incidence(nodes)
        if not (self._parallel or near.max() < 1 / TOUCHING):
            raise InputError(
                f"field 'T_viewer_mirror': the mirror comes within {TOUCHING:g} mm of "
                "the viewer's centre and touches its lens; move it away"
            )
        if incidence.min() < 0:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is behind the mirror; turn it so "
                "that its z axis points away from the viewer"
            )
        if incidence.min() < np.sin(GRAZING):
            lowest = np.degrees(np.arcsin(incidence.min()))
            raise InputError(
                f"field 'T_viewer_mirror': the viewer sees the mirror at down to "
                f"{lowest:.1f} degrees; turn it, or bend it less, until all of it is "
                f"seen at {np.degrees(GRAZING):.0f} or more"
            )

    def _sheet_nodes(self):
        return self.mirror.point(self.mirror.nodes().reshape(-1, 2))

    def _incidence(self, M):
        """Sine of the angle between sheet and line of sight at M (N, 3), one over the
        distance. The sine is negative seen from behind."""
        arrivals, near = self._arrivals(M)
        n = self.mirror.normals(M)
        return -np.sum(arrivals * n, axis=1) / np.linalg.norm(n, axis=1), near

    @property
    def central(self):
        """False: a bent sheet sends the rays of a viewer through no common point."""
        return False

    @property
    def parameters(self):
        """Viewer, pose, deflections, rulings; heights and three angles of each wave;
        height and reach of the strain."""
        uneven = self.mirror.unevenness
        waves = WAVES * 4 if uneven.aberration else 0
        strain = 2 if uneven.strain else 0
        own = len(self.deflections) + int(self.mirror.rulings != 0) + waves + strain
        return self.viewer.parameters + 6 + own

    def deflected(self, deflections):
        """The same camera with its sheet at other deflections, (k,) mm."""
        return FlexibleMirrorCamera(**self.arguments() | {"deflections": deflections})

    def project(self, points):
        """Pixels of points (N, 3) that the mirror shows, to rounding.

        A point that a hollow part of the sheet shows several times gets one of these
        pixels.
        """
        return super().project(points)

    def _shown_at(self, points):
        """As every mirror's, but from the reflection in a plane where that will do.

        A path over the sheet whose length is a convex function has one stationary
        point, so what Newton finds is all there is.
        """
        p, settled = self._settled(points)
        found = np.full(points.shape, np.nan)
        M = self.mirror.point(p[settled])[0]
        good = self._retraces(M, points[settled])
        rows = np.flatnonzero(settled)
        found[rows[good]] = M[good]
        left = ~settled | ~self._seen_once(points)
        left[rows[good]] = False
        left &= np.isfinite(points).all(axis=1)
        if left.any():
            found[left] = reflection_points(
                self.mirror, points[left], self._arrivals, self._retraces
            )
        return found

    def _seen_once(self, points):
        """Points (N, 3) to which no hollow of the sheet can focus the viewer's light.

        In the plane of incidence the second derivative of the path's length is
        s (s (1 / a + 1 / b) - 2 k), a and b the distances from the sheet, s the sine
        of the angle between sheet and light, k the curvature of the hollow; across
        that plane it is larger.
        """
        if not hasattr(self, "_least"):
            M, _, second = self._sheet_nodes()
            incidence, near = self._incidence(M)
            bend = second[:, 2] / self.mirror.radius**2
            hollow = -np.linalg.eigvalsh(bend)[:, 0].min()
            self._least = incidence.min(), near.min(), max(hollow, 0.0)
        incidence, near, hollow = self._least
        with np.errstate(divide="ignore"):
            apart = np.linalg.norm(points - [self.mirror.size[0] / 2, 0, 0], axis=1)
            reach = apart + self.mirror.radius
            return incidence * (near + 1 / reach) > 2 * hollow

    def _settled(self, points):
        """Chart points (N, 2) of stationary paths, and which rows (N,) have one."""
        p = self._plane_reflections(points)
        settled = np.zeros(len(p), bool)
        rows = np.flatnonzero(np.isfinite(p).all(axis=1))
        for _ in range(STEPS):
            with np.errstate(all="ignore"):
                g, H = stationarity(self.mirror, p[rows], points[rows], self._arrivals)
                step = -np.linalg.solve(H, g[..., None])[..., 0]
                length = np.linalg.norm(step, axis=1)
                step *= np.minimum(1, LONGEST_STEP / length)[:, None]
            p[rows] += step
            last = length <= LAST_STEP
            settled[rows[last]] = True
            going = ~last & np.isfinite(length) & (np.abs(p[rows]).max(axis=1) < 2)
            rows = rows[going]
            if not len(rows):
                break
        return p, settled

    def _plane_reflections(self, points):
        """Chart points (N, 2) that a plane through the clamp and the sheet's end would
        show the points (N, 3) at, drawn onto the sheet."""
        end = self.mirror.end
        chord = self.mirror.height(np.array([end]), np.zeros(1))[0, 0] / end
        n = np.array([chord, 0.0, -1.0]) / np.hypot(chord, 1)
        if self._parallel:
            eye = -1e6 * self.mirror.radius * self._axis
        else:
            eye = self._eye
        near, off = eye @ n, np.maximum(points @ n, 0)
        foot = points - (points @ n)[:, None] * n
        M = off[:, None] * (eye - near * n) + near * foot
        M /= (near + off)[:, None]
        ends = np.array([end, self.mirror.half_width])
        M[:, :2] = np.clip(M[:, :2], [0, -ends[1]], ends)
        return self.mirror.chart(M)

    def arguments(self):
        """The constructor's arguments by name: the same camera again, or one of them
        changed."""
        mirror, uneven = self.mirror, self.mirror.unevenness
        return {
            "viewer": self.viewer,
            "size": mirror.size,
            "loads": mirror.profile.loads,
            "deflections": self.deflections,
            "law": self.law,
            "rulings": mirror.rulings,
            "aberration": uneven.aberration,
            "wavelengths": uneven.wavelengths,
            "seed": uneven.seed,
            "strain": uneven.strain,
            "strain_reach": uneven.reach,
            "holder": mirror.holder,
            "T_viewer_mirror": self.T_viewer_mirror,
        }

    def _fields(self):
        values = self.arguments()
        viewer = nested_fields("viewer", values.pop("viewer"))
        return viewer | {name: np.array(value) for name, value in values.items()}

    @classmethod
    def _from_file(cls, file):
        numbers = ("size", "loads", "deflections", "wavelengths", "T_viewer_mirror")
        single = ("rulings", "aberration", "seed", "strain", "strain_reach", "holder")
        return cls(
            viewer=file.nested("viewer"),
            law=file.text("law"),
            **{name: file.numbers(name) for name in numbers},
            **{name: file.number(name) for name in single},
        )
