"""Catadioptric camera from its geometry: a viewer and a quadric mirror (2.2.3)."""

import numpy as np

from raxel.cameras.core.base import checked_array
from raxel.cameras.core.nested import nested_fields
from raxel.cameras.linear.orthographic import OrthographicCamera
from raxel.cameras.mirrors.conic_surface import ConicMirror
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.viewer import checked_viewer
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector, transform

# How far from the focus, mm, a viewer may be and still make a central camera.
AT_FOCUS = 1e-9
# Which way the mirror's axis +z (into the curve) points in an aligned viewer's frame.
FACING = {"outside": np.eye(3), "inside": np.diag([1.0, -1.0, -1.0])}


class QuadricMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a mirror of revolution. Frame: the viewer's.

    viewer: a central camera with its centre at the origin of its frame, or an
    OrthographicCamera. shape, axes, rim_radius, hole_radius, side: see ConicMirror;
    side is 'outside' (convex) unless given, for an ellipsoid 'inside'.
    T_viewer_mirror: (4, 4), mm; the mirror's frame has its origin at the apex and +z
    along the axis into the curve.

    A ray starts at the mirror and runs into the world. A pixel has one where the
    viewer's ray meets the silvered side first and does not meet the mirror again.
    The viewer's own body hides nothing. The camera is central with the viewer at one
    focus of the mirror, and `centre` then the other; for a paraboloid the viewer is
    orthographic and parallel to the axis. A viewer tilted about the focus it sits at
    remains central.
    Raises InputError for a mirror behind the viewer, a viewer behind the mirror, and
    values no mirror can have.
    Source: Baker, Nayar 1999, doi:10.1023/A:1008128724364; off the focus, Micusik,
    Pajdla 2004, Autocalibration and 3D reconstruction with non-central catadioptric
    cameras, CVPR.
    """

    kind = "quadric mirror"

    def __init__(
        self,
        viewer,
        shape,
        axes,
        rim_radius,
        T_viewer_mirror,
        side=None,
        hole_radius=0.0,
    ):
        viewer, self.shape = checked_viewer(viewer), shape
        self.side = usual_side(shape) if side is None else side
        mirror = ConicMirror(shape, axes, rim_radius, hole_radius, self.side)
        self._place(viewer, mirror, T_viewer_mirror)
        self.axes = checked_array("axes", np.atleast_1d(axes), (None,))
        self.rim_radius, self.hole_radius = mirror.rim, mirror.hole
        self._check_sides()
        self._focus = self._effective_focus()

    @classmethod
    def on_axis(cls, viewer, shape, axes, rim_radius, distance, **optional):
        """The mirror's apex `distance` mm ahead of the viewer, on the viewer's axis.

        optional: side, hole_radius. Central only if the distance happens to be right.
        """
        side = optional.get("side") or usual_side(shape)
        # A side that is neither is refused by the constructor, with its reason.
        T = pose(FACING.get(side, FACING["outside"]), [0, 0, distance])
        return cls(viewer, shape, axes, rim_radius, T, **optional)

    @classmethod
    def aligned(cls, viewer, shape, axes, rim_radius, **optional):
        """The central camera: a viewer at the focus, its axis along the mirror's.

        optional: side, hole_radius. An orthographic viewer belongs to a paraboloid
        and stands one focal length and a rim's depth off. Raises InputError for a
        combination that has no such place.
        """
        viewer = checked_viewer(viewer)
        side = optional.get("side") or usual_side(shape)
        mirror = ConicMirror(shape, axes, rim_radius, 0.0, side)
        if isinstance(viewer, OrthographicCamera) != (shape == "paraboloid"):
            raise InputError(
                f"field 'viewer': found {viewer.kind!r} with a {shape}; a paraboloid "
                "needs an orthographic viewer to be central, other mirrors do not"
            )
        if shape == "sphere" or (shape, side) == ("ellipsoid", "outside"):
            raise InputError(
                f"field 'shape': a {shape} silvered {side} makes no central camera; "
                "place the viewer with 'on_axis'"
            )
        if shape == "paraboloid":
            distance = mirror.foci[0] + mirror.height
        else:
            near, far = np.abs(mirror.foci)
            distance = near if (shape, side) == ("hyperboloid", "inside") else far
        return cls.on_axis(viewer, shape, axes, rim_radius, distance, **optional)

    @classmethod
    def misaligned(
        cls, viewer, shape, axes, rim_radius, offset, rotation=(0, 0, 0), **optional
    ):
        """The aligned camera with its mirror moved by `offset` and turned.

        offset: (3,) mm in the viewer's frame; rotation: (3,) rotation vector about
        the apex, radians, same frame; optional: as in `aligned`.
        """
        T = cls.aligned(viewer, shape, axes, rim_radius, **optional).T_viewer_mirror
        turn = rotation_from_vector(checked_array("rotation", rotation, (3,)))
        offset = checked_array("offset", offset, (3,))
        moved = pose(turn @ T[:3, :3], T[:3, 3] + offset)
        return cls(viewer, shape, axes, rim_radius, moved, **optional)

    @property
    def central(self):
        """Whether all rays, continued, meet in one point."""
        return self._focus is not None

    @property
    def centre(self):
        """The point (3,) where all rays meet, in the viewer's frame; else None."""
        if self._focus is None:
            return None
        return transform(self.T_viewer_mirror, self._focus)

    @property
    def parameters(self):
        """Viewer, axes and pose. A turn about the axis of the mirror is none.

        A central camera has two left of its pose: tilts, or shifts across parallel
        rays. Nor do turns of a sphere count, or shifts along parallel rays.
        """
        free = 3 if self.shape == "sphere" else 5
        free = 2 if self.central else free - self._parallel
        return self.viewer.parameters + len(self.axes) + free

    def project(self, points):
        """Pixels of points (N, 3) that the mirror shows.

        Central: the line from the focus to the point holds the mirror point. Else:
        the path from viewer to point is stationary (`reflection_points`), to rounding.
        A convex mirror shows a point once. A concave one may show a point short of
        its caustic several times: one of these pixels is given, and rarely, where two
        nearly coincide, none.
        """
        return super().project(points)

    def _shown_at(self, points):
        return (
            self._on_line_from_focus(points)
            if self.central
            else super()._shown_at(points)
        )

    def _on_line_from_focus(self, points):
        steps = self.mirror.quadric_meetings(
            np.broadcast_to(self._focus, points.shape), points - self._focus
        )
        found = np.full(points.shape, np.nan)
        for step in steps.T:
            with np.errstate(invalid="ignore"):
                M = self._focus + step[:, None] * (points - self._focus)
            good = self._retraces(M, points)
            found[good] = M[good]
        return found

    def _check_sides(self):
        apex = self.T_viewer_mirror[:3, 3]
        if not apex[2] > 0:
            raise InputError(
                f"field 'T_viewer_mirror': the mirror's apex is at z = {apex[2]:g} mm, "
                "behind the viewer; z must be positive"
            )
        if self._parallel:
            wrong = (self._axis[2] > 0) == self.mirror.inside
        elif self.mirror.inside:
            wrong = not self._eye[2] > 0
        else:
            wrong = self.mirror.encloses(self._eye[None])[0]
        if wrong:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is behind the mirror's silvered "
                f"side, which is its {self.side}; turn or move the mirror"
            )

    def _effective_focus(self):
        """The focus all rays point to, in the mirror's frame, or None."""
        near, far = self.mirror.foci
        if self._parallel:
            tilt = np.hypot(*self._axis[:2]) * self.mirror.radius
            fits = self.shape == "paraboloid" and tilt <= AT_FOCUS
            return np.array([0, 0, near]) if fits else None
        for here, other in ((near, far), (far, near)):
            gap = np.linalg.norm(self._eye - [0, 0, here]) if here < np.inf else np.inf
            if gap <= AT_FOCUS and np.isfinite(other):
                return np.array([0, 0, other])
        return None

    def _fields(self):
        return nested_fields("viewer", self.viewer) | {
            "shape": np.array(self.shape),
            "axes": self.axes,
            "rim_radius": np.array(self.rim_radius),
            "T_viewer_mirror": self.T_viewer_mirror,
            "side": np.array(self.side),
            "hole_radius": np.array(self.hole_radius),
        }

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.nested("viewer"),
            file.text("shape"),
            file.numbers("axes"),
            file.number("rim_radius"),
            file.numbers("T_viewer_mirror"),
            file.text("side"),
            file.number("hole_radius"),
        )


def usual_side(shape):
    """Convex mirrors are silvered outside; an ellipsoid has both foci inside."""
    return "inside" if shape == "ellipsoid" else "outside"
