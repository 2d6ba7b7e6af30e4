"""The camera zoo of section 2.2: one example camera of every model."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from raxel.cameras import Camera, GeneralCamera, camera_from

SIZE_PX = 200
MIDDLE = (SIZE_PX - 1) / 2
SIZE = {"width": SIZE_PX, "height": SIZE_PX}
CENTRE = [MIDDLE, MIDDLE]
# A lens of 183 degrees whose picture just fits the image.
HALF_ANGLE = np.radians(91.5)


class Model(NamedTuple):
    """An animal of the zoo.

    section: of the thesis; build() -> Camera, SIZE_PX square; can, cannot:
    what it represents and what it does not.
    """

    section: str
    build: Callable[[], Camera]
    can: str
    cannot: str


def K_of(focal_px):
    """A calibration matrix (2.1) with square pixels, mid-image."""
    return [[focal_px, 0, MIDDLE], [0, focal_px, MIDDLE], [0, 0, 1]]


def made(kind, **fields):
    """A builder of a camera of a kind, SIZE_PX square."""
    return lambda: camera_from(kind, fields | SIZE)


def fisheye(law, reach):
    """A fisheye of 183 degrees; reach: r at the rim for focal length 1."""
    return made(
        "fisheye",
        projection=law,
        focal_px=MIDDLE / reach,
        principal_point=CENTRE,
        max_angle=HALF_ANGLE,
    )


def mirror(shape, axes, focal_px=280, T=None):
    """A mirror 50 mm across before a pinhole, or parallel rays."""

    def build():
        from raxel.cameras import QuadricMirrorCamera

        viewer = made("perspective", K=K_of(focal_px), radial=[])()
        if shape == "paraboloid":
            scale = {"pixels_per_mm": 3.9, "principal_point": CENTRE}
            viewer = made("orthographic", **scale)()
        if shape == "sphere":
            return QuadricMirrorCamera.on_axis(viewer, shape, axes, 25, 100)
        if T is None:
            return QuadricMirrorCamera.aligned(viewer, shape, axes, 25)
        return QuadricMirrorCamera.misaligned(viewer, shape, axes, 25, *T)

    return build


def two_mirrors():
    """A pinhole that looks into two square mirrors, side by side."""
    poses, outline = [], [[-90, -90], [90, -90], [90, 90], [-90, 90]]
    for turn_deg, x in ((150, -80), (-150, 80)):
        c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
        poses.append([[c, 0, s, x], [0, 1, 0, 0], [-s, 0, c, 200]])
        poses[-1].append([0, 0, 0, 1])
    viewer = {"kind": "perspective", "K": K_of(130), "radial": []} | SIZE
    fields = {"viewer": viewer, "T_viewer_facets": np.array(poses)}
    return camera_from("planar mirrors", fields | {"outlines": [outline] * 2})


def bent_sheet():
    """A pinhole before a sheet of mirror, 400 mm square, bent by 3 cm."""
    viewer = made("perspective", K=K_of(130), radial=[])()
    heights = [[0, 0, 6], [0, 4, 0], [20, 0, 0], [5, 0, 0]]
    sheet = {"size": (400, 400), "heights": heights, "offset": (0, 0, 180)}
    return camera_from("bent mirror", {"viewer": viewer} | sheet)


def table():
    """A look-up table filled from the equidistance lens."""
    return GeneralCamera.from_camera(camera("equidistance"))


def rational_cubics():
    """Coefficients (4, 10) of a rational cubic, a little asymmetric."""
    c = np.zeros((4, 10))
    c[0] = [MIDDLE, 150, 1, 2, 1, -2, 5, -2, 6, 1]
    c[1] = [1, 0, 0, 0.2, 0.02, 0.2, 0.01, 0, 0.02, -0.01]
    c[2] = [MIDDLE, 1, 140, -2, 1, 1, 1, 6, 2, 5]
    c[3] = [1, 0, 0, 0.19, -0.02, 0.2, 0.01, 0.01, 0.02, 0.01]
    return c


def lifted(turn_px):
    """A (3, 6): rays (u, v, depth) that reach 90 degrees at turn_px."""
    square = turn_px**2 - 2 * MIDDLE**2
    depth = [-1, 0, -1, 2 * MIDDLE, 2 * MIDDLE, square]
    return np.array(
        [
            [0, 0, 0, 1, 0, -MIDDLE],
            [0, 0, 0, 0, 1, -MIDDLE],
            np.array(depth) / (2 * turn_px),
        ]
    )


ASYMMETRIC = {
    "radial_l": [0.01, 0.002, -0.001],
    "radial_i": [0.3, -0.2, 0.1, 0.2],
    "tangential_m": [0.005, 0.002, -0.001],
    "tangential_j": [0.1, -0.2, 0.1, -0.3],
}
SLITS = {
    "slit_points": [[0, 0, 40], [0, 0, 0]],
    "slit_directions": [[0, 1, 0], [1, 0, 0]],
    "image_distance": 100,
    "pixels_per_mm": [2, 2],
    "principal_point": CENTRE,
}
PLANE_END = "anything at 90° or more from the axis"
ONE_CENTRE = "rays that miss the centre; a lens that is not round"
ONE_SHAPE = "a mirror of another shape, or a viewer off the focus"

ZOO = {
    "radial": Model(
        "2.2.1",
        made("perspective", K=K_of(130), radial=[-0.12, 0.03]),
        "ordinary lenses, barrel or pincushion",
        PLANE_END,
    ),
    "radial and decentring": Model(
        "2.2.1",
        made("brown", K=K_of(130), radial=[-0.12, 0.03], tangential=[0.01, -0.02]),
        "ordinary lenses with elements off their axis",
        PLANE_END,
    ),
    "division": Model(
        "2.2.1",
        made("division", K=K_of(130), coefficients=[-0.25]),
        "strong barrel distortion with one number",
        PLANE_END,
    ),
    "rational cubic": Model(
        "2.2.1",
        made("rational cubic", coefficients=rational_cubics()),
        "smooth distortion of any direction",
        PLANE_END,
    ),
    "lifted rational": Model(
        "2.2.2",
        made("lifted rational", A=lifted(97)),
        "rays quadratic in the pixel, beyond 90° too; epipolar curves become lines",
        "laws of higher order; rays that miss the centre",
    ),
    "field of view": Model(
        "2.2.2",
        made("field of view", omega=1.2, K=K_of(120)),
        "wide lenses near equidistance, with one number",
        PLANE_END + ", as published",
    ),
    "Shah-Aggarwal": Model(
        "2.2.2",
        made(
            "shah-aggarwal",
            K=K_of(90),
            radial=[1.06, -0.24, -0.075, 0.047, -0.0063],
            tangential=[0.02, -0.03, 0.01, 0.002, -0.001],
        ),
        "wide lenses, round but for a twist about the axis",
        PLANE_END,
    ),
    "equidistance": Model(
        "2.2.2",
        fisheye("equidistance", HALF_ANGLE),
        "an ideal fisheye",
        ONE_CENTRE + "; any other law",
    ),
    "equisolid angle": Model(
        "2.2.2",
        fisheye("equisolid", 2 * np.sin(HALF_ANGLE / 2)),
        "an ideal fisheye; equal areas show equal solid angles",
        ONE_CENTRE + "; any other law",
    ),
    "stereographic": Model(
        "2.2.2",
        fisheye("stereographic", 2 * np.tan(HALF_ANGLE / 2)),
        "an ideal fisheye; small circles stay circles",
        ONE_CENTRE + "; any other law",
    ),
    "Micusik-Pajdla, rational": Model(
        "2.2.2",
        made(
            "micusik-pajdla", law="rational", a=1 / 60, b=3.9e-6, principal_point=CENTRE
        ),
        "the one lens it was found for, and like ones",
        ONE_CENTRE,
    ),
    "Micusik-Pajdla, sine": Model(
        "2.2.2",
        made("micusik-pajdla", law="sine", a=66, b=0.3, principal_point=CENTRE),
        "equidistance to orthographic laws, with one number",
        ONE_CENTRE,
    ),
    "Kannala-Brandt, symmetric": Model(
        "2.2.2",
        made(
            "kannala-brandt",
            k=[1, -0.02, 0.003],
            pixels_per_unit=[62, 62],
            principal_point=CENTRE,
        ),
        "any smooth round lens, as far as its terms go",
        ONE_CENTRE,
    ),
    "Kannala-Brandt, complete": Model(
        "2.2.2",
        made(
            "kannala-brandt",
            k=[1, -0.02, 0.003, -2e-4, 1e-5],
            pixels_per_unit=[62, 60],
            principal_point=CENTRE,
            **ASYMMETRIC,
        ),
        "fisheyes with tilted or decentred parts",
        "rays that miss the centre",
    ),
    "Tardif": Model(
        "2.2.3",
        made("tardif", coefficients=[62, -0.05, -6e-3], principal_point=CENTRE),
        "round cameras of any field of view below 360°",
        ONE_CENTRE,
    ),
    "Scaramuzza": Model(
        "2.2.3",
        made("scaramuzza", coefficients=[62, -6.6e-3, 1e-6], centre=CENTRE),
        "round cameras of any field of view; an oblique sensor",
        "rays that miss the centre",
    ),
    "unified sphere": Model(
        "2.2.3",
        made("unified sphere", xi=0.9, K=K_of(87)),
        "every central mirror, exactly; many fisheyes",
        "a viewer off the focus",
    ),
    "unified sphere with distortion": Model(
        "2.2.3",
        made(
            "unified sphere",
            xi=0.9,
            K=K_of(87),
            radial=[-0.05, 0.01, -0.001],
            tangential=[1e-3, -2e-3],
        ),
        "central mirrors with an imperfect viewer; fisheyes",
        "a viewer off the focus",
    ),
    "hyperboloid mirror": Model(
        "2.2.3", mirror("hyperboloid", (30, 20)), "its mirror", ONE_SHAPE
    ),
    "paraboloid mirror": Model(
        "2.2.3", mirror("paraboloid", (10,)), "its mirror", ONE_SHAPE
    ),
    "ellipsoid mirror": Model(
        "2.2.3", mirror("ellipsoid", (60, 40)), "its mirror", ONE_SHAPE
    ),
    "hyperboloid off the focus": Model(
        "2.2.3",
        mirror("hyperboloid", (30, 20), 280, ((3, -2, 10), (0.05, 0.02, 0))),
        "a quadric mirror in any pose before the viewer",
        "mirrors that are not quadrics",
    ),
    "spherical mirror": Model(
        "2.2.3",
        mirror("sphere", (30,), 360),
        "a ball before a camera",
        "mirrors of another shape",
    ),
    "two plane mirrors": Model(
        "2.2.3",
        two_mirrors,
        "stereo with one camera; jumps between facets",
        "curved mirrors",
    ),
    "bent mirror": Model(
        "2.2.3",
        bent_sheet,
        "a sheet of mirror of any gentle shape: the flexible mirror",
        "folds, facets, and sheets that show a point twice",
    ),
    "X-slits": Model(
        "2.2.4",
        made("x-slits", **SLITS),
        "mosaics of a moving camera; pinhole and pushbroom as limits",
        "rays that miss a slit",
    ),
    "pushbroom": Model(
        "2.2.4",
        made(
            "pushbroom",
            focal_px=150,
            principal_column=MIDDLE,
            velocity=[0.5, 8, 0],
            reference_row=MIDDLE,
        ),
        "a line sensor on a straight path",
        "a path that bends or turns",
    ),
    "axial": Model(
        "2.2.4",
        made(
            "axial",
            projection="equisolid",
            focal_px=69.5,
            principal_point=CENTRE,
            pupil_shift=[2.5, -0.3],
            max_angle=HALF_ANGLE,
        ),
        "real fisheyes near by, whose pupil moves; centred mirrors",
        "rays that miss the axis",
    ),
    "look-up table": Model(
        "2.3",
        table,
        "every camera of this list (section 2.3)",
        "pixels that no calibration reached; jumps inside a cell",
    ),
}
# Kinds of the library that have no cage here, and why.
ELSEWHERE = {
    "orthographic": "parallel rays, which section 2.2 does not name; it "
    "is the viewer of the paraboloid mirror",
    "ray spline": "a formula's rays with a smooth field on top, fitted to a "
    "camera; chapter 4 has it",
    "flexible mirror": "a clamped sheet of mirror with its loads; the bent mirror "
    "stands for it here, and chapter 5 has it",
    "moving pupil": "a fisheye law whose rays cross the axis at several "
    "places; chapter 4 has it",
    "spline mirror": "a viewer before a mirror whose shape is a spline over "
    "the picture; chapter 5 has it",
}


@cache
def camera(name):
    """The example camera of a model."""
    return ZOO[name].build()
