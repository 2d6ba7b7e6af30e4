"""The camera zoo of section 2.2: one example camera of every model."""

from __future__ import annotations

from functools import cache

import numpy as np

from raxel.cameras import GeneralCamera, camera_from

SIZE_PX = 200
MIDDLE = (SIZE_PX - 1) / 2
SIZE = {"width": SIZE_PX, "height": SIZE_PX}
CENTRE = [MIDDLE, MIDDLE]
# A lens of 183 degrees whose image circle just fits the image.
HALF_ANGLE = np.radians(91.5)


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
    """A mirror 50 mm across in front of a pinhole, or parallel rays."""

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
    """A pinhole in front of a sheet of mirror, 400 mm square, bent by 3 cm."""
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

# Model -> builder of its example camera, by section of the thesis.
ZOO = {
    "radial": made("perspective", K=K_of(130), radial=[-0.12, 0.03]),
    "radial and decentring": made(
        "brown", K=K_of(130), radial=[-0.12, 0.03], tangential=[0.01, -0.02]
    ),
    "division": made("division", K=K_of(130), coefficients=[-0.25]),
    "rational cubic": made("rational cubic", coefficients=rational_cubics()),
    "lifted rational": made("lifted rational", A=lifted(97)),
    "field of view": made("field of view", omega=1.2, K=K_of(120)),
    "Shah-Aggarwal": made(
        "shah-aggarwal",
        K=K_of(90),
        radial=[1.06, -0.24, -0.075, 0.047, -0.0063],
        tangential=[0.02, -0.03, 0.01, 0.002, -0.001],
    ),
    "equidistance": fisheye("equidistance", HALF_ANGLE),
    "equisolid angle": fisheye("equisolid", 2 * np.sin(HALF_ANGLE / 2)),
    "stereographic": fisheye("stereographic", 2 * np.tan(HALF_ANGLE / 2)),
    "Micusik-Pajdla, rational": made(
        "micusik-pajdla", law="rational", a=1 / 60, b=3.9e-6, principal_point=CENTRE
    ),
    "Micusik-Pajdla, sine": made(
        "micusik-pajdla", law="sine", a=66, b=0.3, principal_point=CENTRE
    ),
    "Kannala-Brandt, symmetric": made(
        "kannala-brandt",
        k=[1, -0.02, 0.003],
        pixels_per_unit=[62, 62],
        principal_point=CENTRE,
    ),
    "Kannala-Brandt, complete": made(
        "kannala-brandt",
        k=[1, -0.02, 0.003, -2e-4, 1e-5],
        pixels_per_unit=[62, 60],
        principal_point=CENTRE,
        **ASYMMETRIC,
    ),
    "Tardif": made("tardif", coefficients=[62, -0.05, -6e-3], principal_point=CENTRE),
    "Scaramuzza": made("scaramuzza", coefficients=[62, -6.6e-3, 1e-6], centre=CENTRE),
    "unified sphere": made("unified sphere", xi=0.9, K=K_of(87)),
    "unified sphere with distortion": made(
        "unified sphere",
        xi=0.9,
        K=K_of(87),
        radial=[-0.05, 0.01, -0.001],
        tangential=[1e-3, -2e-3],
    ),
    "hyperboloid mirror": mirror("hyperboloid", (30, 20)),
    "paraboloid mirror": mirror("paraboloid", (10,)),
    "ellipsoid mirror": mirror("ellipsoid", (60, 40)),
    "hyperboloid off the focus": mirror(
        "hyperboloid", (30, 20), 280, ((3, -2, 10), (0.05, 0.02, 0))
    ),
    "spherical mirror": mirror("sphere", (30,), 360),
    "two plane mirrors": two_mirrors,
    "bent mirror": bent_sheet,
    "X-slits": made("x-slits", **SLITS),
    "pushbroom": made(
        "pushbroom",
        focal_px=150,
        principal_column=MIDDLE,
        velocity=[0.5, 8, 0],
        reference_row=MIDDLE,
    ),
    "axial": made(
        "axial",
        projection="equisolid",
        focal_px=69.5,
        principal_point=CENTRE,
        pupil_shift=[2.5, -0.3],
        max_angle=HALF_ANGLE,
    ),
    "look-up table": table,
}


@cache
def camera(name):
    """The example camera of a model."""
    return ZOO[name]()
