"""Non-central camera: a viewing camera and a clamped, flexible mirror sheet (5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    checked_array,
    checked_positive,
    checked_word,
    nested_fields,
)
from raxel.cameras.mirrors.curved import MirrorCamera, reflection_points, stationarity
from raxel.cameras.mirrors.profiles import PROFILES, RunningIntegral, checked_at_loads
from raxel.cameras.mirrors.sheet_surface import (
    EDGE_TOL,
    MAX_N_MEETING_STEPS,
    MAX_SLOPE,
    MEETING_TOL,
    N_WAVES,
    BentSheet,
    Unevenness,
)
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector

# Mirror sheet clamped along a straight edge and bent: intersection, reflection, chart.
# In the mirror's frame the clamped edge is on the y axis about the origin, x runs along
# the flat sheet to its free edge and z away from the light. With p a profile
# (`profiles`) the bent sheet is z(x, y) = h p(x / h), h = 1 + c y, a part of a cone
# with its apex on the line of the clamp, at y = -1 / c; for c = 0 a cylinder. Every
# such sheet is developable, with slope zero along the clamp line: rulings can be
# oblique only if they meet in a point of that line, since one that crosses it would
# bend only one side of the edge. `Unevenness` is added to the cone. Lengths are mm.


# Domain of the surface beyond the sheet's border, as a fraction of the sheet.
MAX_EXTRAPOLATION = 0.5
# Larger ruling angles bring the apex too close to the sheet.
MAX_RULING_ANGLE_RAD = np.radians(45)
GRID_SHAPE = (33, 17)


class ClampedMirror(BentSheet):
    """profile: a BeamProfile or ElasticaProfile of the line y = 0.

    size: (length from the clamp along the sheet, width), mm; rulings: angle, radians,
    between the ruling through the middle of the free edge and the clamp's line,
    positive where they spread towards +y; unevenness: an `Unevenness`; holder: length
    of sheet behind the clamp's holder, mm, which no ray meets.
    Raises InputError naming the invalid field, also for a sheet that is steeper than 45
    degrees anywhere.
    """

    def __init__(self, profile, size, rulings, unevenness, holder):
        self.profile, self.unevenness = profile, unevenness
        self.size = checked_positive("size", size, (2,))
        self.half_width = self.size[1] / 2
        self.rulings = float(checked_array("rulings", rulings, ()))
        self.holder = float(checked_array("holder", holder, ()))
        self._check()
        self._fan = np.tan(self.rulings) / self.size[0]
        self.radius = float(np.hypot(self.size[0] / 2, self.half_width))
        self._middle = np.array([self.size[0] / 2, 0.0])
        x, y = MAX_EXTRAPOLATION * self.size
        least = np.array([-x, -self.half_width - y])
        self._domain = least, np.array([self.size[0] + x, self.half_width + y])
        ends = np.append(profile.breaks, self.size[0] * (1 + MAX_EXTRAPOLATION))
        # Along the edge where the cone is narrowest a load may be outside the sheet.
        ends[-1] = max(ends[-1], 1.5 * profile.breaks[-1])
        self._length = RunningIntegral(ends, self._length_rate)
        self._check_slope()

    def _check(self):
        length, load = self.size[0], self.profile.loads[-1]
        if load > length:
            raise InputError(
                f"field 'loads': found one at {load:g} mm on a sheet {length:g} mm "
                "long; put it on the sheet"
            )
        if not 0 <= self.holder < length:
            raise InputError(
                f"field 'holder': found {self.holder:g} mm of a sheet {length:g} mm "
                "long; leave a part visible"
            )
        near = abs(np.tan(self.rulings)) * self.half_width / length
        if not (abs(self.rulings) <= MAX_RULING_ANGLE_RAD and near < 1 / 2):
            raise InputError(
                f"field 'rulings': {np.degrees(self.rulings):.3g} degrees bring the "
                "cone's apex up to the sheet; give a smaller angle"
            )

    def _check_slope(self):
        x, y = (self._middle + self.radius * self.nodes().reshape(-1, 2)).T
        _, by_x, by_y, *_ = self.height(x, y)
        slope = np.hypot(by_x, by_y).max()
        if not slope <= MAX_SLOPE:
            steep = np.degrees(np.arctan(slope))
            raise InputError(
                f"field 'deflections': the sheet is up to {steep:.0f} degrees steep; "
                "give at most 45"
            )

    def nodes(self):
        """Chart coordinates (17, 33, 2) spread over the sheet, its border included."""
        x = np.linspace(0, self.end, GRID_SHAPE[0])
        y = np.linspace(-self.half_width, self.half_width, GRID_SHAPE[1])
        return (np.stack(np.meshgrid(x, y), axis=-1) - self._middle) / self.radius

    @property
    def end(self):
        """x of the middle of the free edge, mm."""
        x = self.size[0]
        for _ in range(MAX_N_MEETING_STEPS):
            gap = self.flat(np.array([x]), np.zeros(1))[0][0] - self.size[0]
            x -= gap / np.hypot(1, self.profile.at(np.array([x]))[1][0])
            if abs(gap) <= MEETING_TOL * self.radius:
                break
        return float(x)

    def height(self, x, y):
        """Height (N,) at x, y (N,), then its derivatives by x, y, xx, xy and yy."""
        h = 1 + self._fan * y
        at = x / h
        z, slope, bend = self.profile.at(at)
        turn = -self._fan * at
        bend = bend / h
        heights = np.stack(
            [
                h * z,
                *(slope, self._fan * z + turn * slope),
                *(bend, turn * bend, turn**2 * bend),
            ]
        )
        return heights if self.unevenness.flat else heights + self.unevenness.at(x, y)

    def flat(self, x, y):
        """Position of x, y (N,) of the bent sheet on the flat one: x, y (N,), mm.

        The cone unrolls about its apex: distances from it stay, and angles about it
        become lengths of the profile as seen from there. Terms are ordered so that a
        cylinder is the limit without loss of digits.
        """
        c = self._fan
        h = 1 + c * y
        at = x / h
        z, _, _ = self.profile.at(at)
        rise = at**2 + z**2
        stretch = np.sqrt(1 + c**2 * rise)
        arc = self._length(at)
        turned = arc * np.sinc(c * arc / np.pi)
        inward = -c * (arc * np.sinc(c * arc / (2 * np.pi))) ** 2 / 2
        outward = c * rise / (stretch + 1) * np.cos(c * arc) + inward
        return h * stretch * turned, y * stretch * np.cos(c * arc) + outward

    def _length_rate(self, at):
        """Length on the flat sheet by x / h, at unit distance of the apex from it."""
        z, slope, _ = self.profile.at(at)
        c = self._fan
        across = c * (z - at * slope)
        return np.sqrt(1 + slope**2 + across**2) / (1 + c**2 * (at**2 + z**2))

    def carries(self, points):
        """Whether points (N, 3) of the surface are on the sheet, beyond its holder.

        The sheet does not stretch: its border is that of the flat one.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            x, y = self.flat(points[:, 0], points[:, 1])
            along = (x >= self.holder) & (x <= self.size[0] * (1 + EDGE_TOL))
            return along & (np.abs(y) <= self.half_width * (1 + EDGE_TOL))

    def point(self, p):
        """Surface points (N, 3) of chart coordinates p (N, 2): x, y from the sheet's
        middle over half its diagonal.

        Returns the points, their first derivatives (N, 3, 2) and second (N, 3, 2, 2).
        """
        x, y = (self._middle + self.radius * p).T
        z, by_x, by_y, xx, xy, yy = self.height(x, y)
        first = np.zeros((len(p), 3, 2))
        first[:, :2] = self.radius * np.eye(2)
        first[:, 2] = self.radius * np.column_stack([by_x, by_y])
        second = np.zeros((len(p), 3, 2, 2))
        bends = np.column_stack([xx, xy, xy, yy]).reshape(-1, 2, 2)
        second[:, 2] = self.radius**2 * bends
        return np.column_stack([x, y, z]), first, second


# Minimum angle of incidence, below which a sheet hides parts of itself, and minimum
# distance from the camera centre, where the sheet would touch the lens.
MIN_GRAZING_ANGLE_RAD, MIN_DISTANCE_MM = np.radians(5), 10.0
# Newton steps from the reflection in a plane, largest and last step, over half of the
# sheet's diagonal.
MAX_N_STEPS, MAX_STEP, STEP_TOL = 25, 0.3, 1e-12


class FlexibleMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a clamped sheet, pushed from behind or pulled.

    Frame: the viewer's. The mirror's x axis runs from the clamp to the free edge. Its y
    axis is the clamp's line with the origin mid-way, its z axis points away from the
    viewer. The pose is T_viewer_mirror, or else `offset` and `rotation` of the mirror's
    frame in the viewer's.

    Parameters
    ----------
    viewer : Camera
        Central camera with its centre at the origin of its frame, or an
        `OrthographicCamera`.
    size : array_like, shape (2,)
        (length from the clamp along the sheet, width along the clamp), mm.
    loads : float or array_like, shape (k,)
        Positions of the loads, mm from the clamp.
    deflections : array_like, shape (k,)
        Distance of the sheet from the flat one at the loads, mm, positive away from the
        viewer, which makes the mirror convex.
    law : str
        'elastica', which keeps the sheet's length, or 'beam', small deflections (5.1);
        see `profiles`.
    rulings : float
        Angle between the ruling through the middle of the free edge and the clamp's
        line, rad, see `ClampedMirror`.
    aberration : float
        RMS, mm, see `Unevenness`.
    wavelengths : array_like, shape (2,)
        (least, greatest), mm, see `Unevenness`.
    seed : int
        Seed of the unevenness.
    strain : float
        Strain of the free edges, mm, see `Unevenness`.
    strain_reach : float
        Reach of the strain, mm.
    holder : float
        Length of sheet that the clamp's holder hides, mm.
    offset : array_like, shape (3,)
        Position of the mirror, mm.
    rotation : array_like, shape (3,)
        Rotation vector, rad.
    T_viewer_mirror : array_like, shape (4, 4)
        Pose of the mirror, mm.

    Raises
    ------
    InputError
        The viewer is behind the sheet, touches it, or sees it at less than 5 degrees,
        or no such camera can have the values.

    References
    ----------
    Thesis 5.1.
    """

    kind = "flexible mirror"

    def __init__(
        self,
        viewer: Camera,
        size: ArrayLike,
        loads: ArrayLike,
        deflections: ArrayLike,
        law: str = "elastica",
        rulings: float = 0.0,
        aberration: float = 0.0,
        wavelengths: ArrayLike = (45.0, 110.0),
        seed: int = 0,
        strain: float = 0.0,
        strain_reach: float = 5.0,
        holder: float = 0.0,
        offset: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (0.0, 0.0, 0.0),
        T_viewer_mirror: ArrayLike | None = None,
    ) -> None:
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
        if not (self._parallel or near.max() < 1 / MIN_DISTANCE_MM):
            raise InputError(
                f"field 'T_viewer_mirror': the mirror is within {MIN_DISTANCE_MM:g} mm "
                "of the viewer's centre (touches the lens); move it away"
            )
        if incidence.min() < 0:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is behind the mirror; rotate it "
                "so that its z axis points away from the viewer"
            )
        if incidence.min() < np.sin(MIN_GRAZING_ANGLE_RAD):
            lowest = np.degrees(np.arcsin(incidence.min()))
            raise InputError(
                f"field 'T_viewer_mirror': the smallest viewing angle to the mirror is "
                f"{lowest:.1f} degrees; rotate it, or bend it less, for at least "
                f"{np.degrees(MIN_GRAZING_ANGLE_RAD):.0f}"
            )

    def _sheet_nodes(self):
        return self.mirror.point(self.mirror.nodes().reshape(-1, 2))

    def _incidence(self, M):
        """Sine of the angle between sheet and line of sight at M (N, 3), and inverse
        distance. The sine is negative from behind."""
        arrivals, near = self._arrivals(M)
        n = self.mirror.normals(M)
        return -np.sum(arrivals * n, axis=1) / np.linalg.norm(n, axis=1), near

    @property
    def central(self) -> bool:
        """False: the rays from a bent sheet have no common point."""
        return False

    @property
    def parameters(self) -> int:
        """Viewer, pose, deflections, rulings; heights and three angles of each wave;
        height and reach of the strain."""
        uneven = self.mirror.unevenness
        waves = N_WAVES * 4 if uneven.aberration else 0
        strain = 2 if uneven.strain else 0
        own = len(self.deflections) + int(self.mirror.rulings != 0) + waves + strain
        return self.viewer.parameters + 6 + own

    def deflected(self, deflections: ArrayLike) -> FlexibleMirrorCamera:
        """Return the same camera with its sheet at other deflections.

        Parameters
        ----------
        deflections : array_like, shape (k,)
            Deflections at the loads, mm.

        Returns
        -------
        FlexibleMirrorCamera
            New camera.
        """
        return FlexibleMirrorCamera(**self.arguments() | {"deflections": deflections})

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        A point that a hollow part of the sheet shows several times gets one of these
        pixels.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points that the mirror shows, to rounding.
        """
        return super().project(points)

    def _shown_at(self, points):
        """As every mirror's, but from the reflection in a plane where that suffices.

        If the path length over the sheet is a convex function, it has one stationary
        point, so Newton finds the only one.
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
        """Points (N, 3) to which no concave part can focus the viewer's light.

        In the plane of incidence the second derivative of the path's length is s (s (1
        / a + 1 / b) - 2 k), a and b the distances from the sheet, s the sine of the
        angle between sheet and light, k the curvature of the concave part; across that
        plane it is larger.
        """
        if not hasattr(self, "_least"):
            M, _, second = self._sheet_nodes()
            incidence, near = self._incidence(M)
            bend = second[:, 2] / self.mirror.radius**2
            hollow = -np.linalg.eigvalsh(bend)[:, 0].min()
            self._least = incidence.min(), near.min(), max(hollow, 0.0)
        incidence, near, hollow = self._least
        with np.errstate(divide="ignore"):
            separation = np.linalg.norm(
                points - [self.mirror.size[0] / 2, 0, 0], axis=1
            )
            reach = separation + self.mirror.radius
            return incidence * (near + 1 / reach) > 2 * hollow

    def _settled(self, points):
        """Chart points (N, 2) of stationary paths, and which rows (N,) have one."""
        p = self._plane_reflections(points)
        settled = np.zeros(len(p), bool)
        rows = np.flatnonzero(np.isfinite(p).all(axis=1))
        for _ in range(MAX_N_STEPS):
            with np.errstate(all="ignore"):
                g, H = stationarity(self.mirror, p[rows], points[rows], self._arrivals)
                step = -np.linalg.solve(H, g[..., None])[..., 0]
                length = np.linalg.norm(step, axis=1)
                step *= np.minimum(1, MAX_STEP / length)[:, None]
            p[rows] += step
            last = length <= STEP_TOL
            settled[rows[last]] = True
            going = ~last & np.isfinite(length) & (np.abs(p[rows]).max(axis=1) < 2)
            rows = rows[going]
            if not len(rows):
                break
        return p, settled

    def _plane_reflections(self, points):
        """Chart points (N, 2) of the reflections of points (N, 3) in a plane through
        the clamp and the sheet's end, projected onto the sheet."""
        end = self.mirror.end
        chord = self.mirror.height(np.array([end]), np.zeros(1))[0, 0] / end
        n = np.array([chord, 0.0, -1.0]) / np.hypot(chord, 1)
        if self._parallel:
            eye = -1e6 * self.mirror.radius * self._axis
        else:
            eye = self._eye
        near, errors = eye @ n, np.maximum(points @ n, 0)
        foot = points - (points @ n)[:, None] * n
        M = errors[:, None] * (eye - near * n) + near * foot
        M /= (near + errors)[:, None]
        ends = np.array([end, self.mirror.half_width])
        M[:, :2] = np.clip(M[:, :2], [0, -ends[1]], ends)
        return self.mirror.chart(M)

    def arguments(self):
        """The constructor's arguments by name, for a copy with or without changes."""
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
