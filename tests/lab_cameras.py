"""One camera or more of every kind, each with pixels where a small board is seen."""

import math

import numpy as np

from raxel.cameras import (
    CAMERAS,
    FisheyeCamera,
    GeneralCamera,
    PerspectiveCamera,
    camera_from,
    pixel_grid,
)

W, H = 200, 160
SIZE = {"width": W, "height": H}
C = [99.3, 79.6]
K = [[150, 0.5, C[0]], [0, 145, C[1]], [0, 0, 1]]
WIDE = PerspectiveCamera([[110, 0, C[0]], [0, 110, C[1]], [0, 0, 1]], [], W, H)
CUBIC = np.zeros((4, 10))
CUBIC[0] = [C[0], 150, 1, 2, 1, -2, 5, -2, 6, 1]
CUBIC[1] = [1, 0, 0, 0.2, 0.02, 0.2, 0.01, 0, 0.02, -0.01]
CUBIC[2] = [C[1], 1, 140, -2, 1, 1, 1, 6, 2, 5]
CUBIC[3] = [1, 0, 0, 0.19, -0.02, 0.2, 0.01, 0.01, 0.02, 0.01]
LIFTED = np.array(
    [
        [0, 0, 0, 1, 0, -C[0]],
        [0, 0, 0, 0, 1, -C[1]],
        np.array([-1, 0, -1, 2 * C[0], 2 * C[1], 75**2 - C[0] ** 2 - C[1] ** 2]) / 150,
    ]
)
MIDDLE, ASIDE = (101, 81), (58, 44)


def facet(turn_deg, x):
    """A square mirror at (x, 0, 200) turned about y."""
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    T = np.array([[c, 0, s, x], [0, 1, 0, 0], [-s, 0, c, 200], [0, 0, 0, 1]])
    return T, [[-90, -90], [90, -90], [90, 90], [-90, 90]]


def table():
    """A general camera whose table has been filled from a fisheye."""
    fisheye = FisheyeCamera("equidistance", 70, C, W, H, 1.9)
    rays = fisheye.rays(pixel_grid(W, H))
    directions = np.where(rays.valid[:, None], rays.directions, 1.0)
    return GeneralCamera(directions.reshape(H, W, 3), rays.valid.reshape(H, W))


def mirror(shape, parameters, T=None, **more):
    """A mirror 25 mm wide ahead of a pinhole or, for a paraboloid, parallel rays."""
    camera = CAMERAS["quadric mirror"]
    focal = 360 if shape == "sphere" else 280
    K = [[focal, 0, C[0]], [0, focal, C[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [], W, H)
    if shape == "paraboloid":
        viewer = CAMERAS["orthographic"](3.2, C, W, H)
    if shape == "sphere":
        return camera.on_axis(viewer, shape, parameters, 25, 100)
    if T is not None:
        return camera.misaligned(viewer, shape, parameters, 25, *T)
    return camera.aligned(viewer, shape, parameters, 25, **more)


def _named():
    def make(kind, **fields):
        return camera_from(kind, fields)

    for law in ("equidistance", "equisolid", "stereographic"):
        named = make(
            "fisheye",
            projection=law,
            focal_px=60,
            principal_point=C,
            max_angle=1.7,
            **SIZE,
        )
        yield law, named, (MIDDLE, ASIDE)
    one = (MIDDLE, ASIDE)
    yield "perspective", make("perspective", K=K, radial=[-0.15, 0.02], **SIZE), one
    yield "general", table(), one
    yield (
        "brown",
        make("brown", K=K, radial=[-0.1], tangential=[0.01, -0.02], **SIZE),
        one,
    )
    yield "division", make("division", K=K, coefficients=[-0.3], **SIZE), one
    law = {"radial": [1.06, -0.24, -0.075, 0.047, -0.0063]}
    law |= {"tangential": [0.05, -0.1, 0.02, 0.01, -0.005], "K": K}
    yield "shah-aggarwal", make("shah-aggarwal", **law, **SIZE), one
    yield "field of view", make("field of view", omega=1.1, K=K, **SIZE), one
    yield "rational cubic", make("rational cubic", coefficients=CUBIC, **SIZE), one
    yield "lifted rational", make("lifted rational", A=LIFTED, **SIZE), one
    turn = {
        "radial_l": [0.01, 0.002, -0.001],
        "radial_i": [0.3, -0.2, 0.1, 0.2],
        "tangential_m": [0.005, 0.002, -0.001],
        "tangential_j": [0.1, -0.2, 0.1, -0.3],
    }
    law = {"k": [1, -0.02, 0.003], "pixels_per_unit": [80, 78], "principal_point": C}
    yield "kannala-brandt", make("kannala-brandt", **law, **turn, **SIZE), one
    law = {"law": "sine", "a": 90, "b": 0.6, "principal_point": C}
    yield "micusik-pajdla", make("micusik-pajdla", **law, **SIZE), one
    law = {"coefficients": [75, -3e-3, 1e-6], "centre": C}
    yield "scaramuzza", make("scaramuzza", **law, **SIZE), one
    law = {"coefficients": [80, -0.1, -1e-3], "principal_point": C}
    yield "tardif", make("tardif", **law, **SIZE), one
    sphere = {"xi": 0.9, "K": K, "radial": [-0.1, 0.02], "tangential": [0.001, -0.002]}
    yield "unified sphere", make("unified sphere", **sphere, **SIZE), one
    law = {"pixels_per_mm": 0.2, "principal_point": C}
    yield "orthographic", make("orthographic", **law, **SIZE), one
    slits = {
        "slit_points": [[0, 0, 2.0], [1, 0, -2.0]],
        "slit_directions": [[0.1, 1, 0], [1, 0.05, 0.1]],
        "image_distance": 8.0,
        "pixels_per_mm": [20, 15],
        "principal_point": C,
    }
    yield "x-slits", make("x-slits", **slits, **SIZE), one
    law = {"focal_px": 150, "principal_column": C[0], "velocity": [0.3, 4, -0.4]}
    yield "pushbroom", make("pushbroom", **law, reference_row=20, **SIZE), one
    law = {"projection": "equisolid", "focal_px": 60, "principal_point": C}
    law |= {"pupil_shift": [2.5, -0.3], "max_angle": 1.7}
    yield "axial", make("axial", **law, **SIZE), one
    law = {"k": [1, -0.02, 0.003], "pixels_per_unit": [60, 60], "principal_point": C}
    lens = make("kannala-brandt", **law, max_angle=1.7, **SIZE)
    yield "moving pupil", make("moving pupil", lens=lens, pupil_shift=[2.5, -0.3]), one
    rim = ((126, 94), (66, 62))
    yield "hyperboloid", mirror("hyperboloid", (30, 20)), rim
    yield "paraboloid", mirror("paraboloid", (10,)), rim
    yield "ellipsoid", mirror("ellipsoid", (60, 40)), rim
    off = ((3, -2, 10), (0.05, 0.02, 0))
    yield "hyperboloid off its axis", mirror("hyperboloid", (30, 20), off), rim
    yield "sphere", mirror("sphere", (30,)), rim
    sheet = {"viewer": WIDE, "size": (400, 320), "offset": (0, 0, 180)}
    sheet |= {"heights": [[0, 0, 6], [0, 4, 0], [20, 0, 0], [5, 0, 0]]}
    yield "bent mirror", make("bent mirror", **sheet), one
    wavy = np.random.default_rng(4).uniform(5.45e-3, 5.55e-3, (5, 4))
    knots = [[-1] * 3 + [-0.3, 0.2] + [1] * 3, [-0.8] * 3 + [0.0] + [0.8] * 3]
    made = make("spline mirror", viewer=WIDE, coefficients=wavy, angle=0.1,
                knots_u=knots[0], knots_v=knots[1])  # fmt: skip
    yield "spline mirror", made, one
    pushed = {"viewer": WIDE, "size": (400, 320), "offset": (-190, 0, 180)}
    pushed |= {"loads": 390, "deflections": 25, "aberration": 0.02}
    yield "flexible mirror", make("flexible mirror", **pushed), one
    poses, outlines = zip(facet(150, -80), facet(-150, 80), strict=True)
    two = CAMERAS["planar mirrors"](WIDE, np.array(poses), outlines)
    yield "planar mirrors", two, ((62, 70), (138, 90))
    control = np.random.default_rng(3).uniform(-2, 2, (7, 8, 2))
    law = {"spacing_px": 40, "control": control, **SIZE}
    yield "ray spline", make("ray spline", trend=WIDE, **law), one


EVERY = {name: (camera, places) for name, camera, places in _named()}
