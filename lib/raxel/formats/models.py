"""Models of other programs: formulas for refits, and equal cameras of Raxel.

A formula maps directions to points (x, y), which fx, fy, s, cx, cy map to pixels.
"""

from collections import defaultdict

import numpy as np

from raxel.cameras.lenses.fisheye import FisheyeCamera, KannalaBrandtCamera
from raxel.cameras.lenses.perspective import BrownCamera, PerspectiveCamera
from raxel.cameras.lenses.polynomials import (
    DivisionCamera,
    FieldOfViewCamera,
    ScaramuzzaCamera,
)
from raxel.cameras.lenses.rational import UnifiedSphereCamera

# Values of parameters that a model lacks; all others are 0.
LACKING = {"fx": 1.0, "fy": 1.0, "beta": 1.0, "c": 1.0}


def parameters(names, values):
    """Parameters by name, with those that are not given; f is fx and fy."""
    p = defaultdict(float, LACKING | dict(zip(names, values, strict=True)))
    if "f" in p:
        p["fx"] = p["fy"] = p.pop("f")
    return p


def pixels(formula, p, directions):
    """Pixels (N, 2) of directions (N, 3); not finite where the formula has none."""
    with np.errstate(all="ignore"):
        x, y = FORMULAS[formula](p, *directions.T)
        return np.column_stack(
            [p["fx"] * x + p["s"] * y + p["cx"], p["fy"] * y + p["cy"]]
        )


def _series(p, names, s):
    """c1 s + c2 s^2 + ... with the coefficients of these names."""
    return s * np.polyval([p[name] for name in names.split()[::-1]], s)


def _decentred(p, x, y, radial=1.0):
    r2 = x * x + y * y
    return (
        x * radial
        + (2 * p["p1"] * x * y + p["p2"] * (r2 + 2 * x * x))
        + _series(p, "s1 s2", r2),
        y * radial
        + (p["p1"] * (r2 + 2 * y * y) + 2 * p["p2"] * x * y)
        + _series(p, "s3 s4", r2),
    )


def _pinhole(p, x, y, z):
    x, y = x / z, y / z
    r2 = x * x + y * y
    radial = 1 + _series(p, "k1 k2 k3", r2)
    return _decentred(p, x, y, radial / (1 + _series(p, "k4 k5 k6", r2)))


def _theta(p, x, y, z, names="k1 k2 k3 k4"):
    across = np.hypot(x, y)
    theta = np.arctan2(across, z)
    radius = theta * (1 + _series(p, names, theta**2))
    scale = np.where(across > 0, radius / across, 0.0)
    return scale * x, scale * y


def _prism_fisheye(p, x, y, z):
    return _decentred(p, *_theta(p, x, y, z, "k1 k2 k3 k4 k5 k6"))


def _omni(p, x, y, z):
    depth = z + p["xi"] * np.sqrt(x * x + y * y + z * z)
    x, y = x / depth, y / depth
    return _decentred(p, x, y, 1 + _series(p, "k1 k2 k3", x * x + y * y))


def _eucm(p, x, y, z):
    length = np.sqrt(p["beta"] * (x * x + y * y) + z * z)
    depth = p["alpha"] * length + (1 - p["alpha"]) * z
    return x / depth, y / depth


def _double_sphere(p, x, y, z):
    z = z + p["xi"] * np.sqrt(x * x + y * y + z * z)
    return _eucm(p | {"beta": 1.0}, x, y, z)


def _stereographic(p, x, y, z):
    depth = (np.sqrt(x * x + y * y + z * z) + z) / 2
    return x / depth, y / depth


def _ocam(p, x, y, z):
    camera = _camera_of_ocam(p, 1, 1)
    return (camera.project(np.column_stack([x, y, z])).pixels - camera.centre).T


FORMULAS = {
    "pinhole": _pinhole,
    "fisheye": _theta,
    "prism fisheye": _prism_fisheye,
    "omni": _omni,
    "eucm": _eucm,
    "ds": _double_sphere,
    "ocam": _ocam,
    "stereographic": _stereographic,
}


# Cameras of Raxel, exactly.


def equals_of(camera):
    """(formula, parameters) of all formulas that equal a camera; may be none."""
    match camera:
        case PerspectiveCamera() | BrownCamera() if len(camera.radial) <= 3:
            yield "pinhole", _affine(camera.K) | _distortion(camera)
        case KannalaBrandtCamera(symmetric=True):
            focal, k = camera.pixels_per_unit * camera.k[0], camera.k[1:] / camera.k[0]
            yield "fisheye", _plain(focal, camera.principal_point) | _numbered("k", k)
        case FisheyeCamera(projection="equidistance"):
            yield "fisheye", _plain([camera.focal_px] * 2, camera.principal_point)
        case FisheyeCamera(projection="stereographic"):
            f, centre = camera.focal_px, camera.principal_point
            yield "stereographic", _plain([f, f], centre)
            yield "omni", _plain([2 * f, 2 * f], centre) | {"xi": 1.0}
            yield "eucm", _plain([f, f], centre) | {"alpha": 0.5, "beta": 1.0}
        case UnifiedSphereCamera() if (
            len(camera.radial) <= 3 and not camera.prism.any()
        ):
            K, distortion = camera.K.copy(), _distortion(camera)
            yield "omni", _affine(K) | distortion | {"xi": camera.xi}
            if not any(distortion.values()):
                K[:2, :2] /= 1 + camera.xi
                alpha = camera.xi / (1 + camera.xi)
                yield "eucm", _affine(K) | {"alpha": alpha, "beta": 1.0}
        case FieldOfViewCamera() if not camera.radial.any():
            yield "fov", _affine(camera.K) | {"omega": camera.omega}
        case DivisionCamera() if len(camera.coefficients) == 1:
            yield "division", _affine(camera.K) | _numbered("k", camera.coefficients)
        case ScaramuzzaCamera():
            a0, *powers = camera.coefficients
            values = [a0, *camera.affine, *camera.centre]
            p = dict(zip(("a0", "c", "d", "e", "cx", "cy"), values, strict=True))
            yield "ocam", p | _numbered("a", powers, 2)


def _affine(K):
    return _plain([K[0, 0], K[1, 1]], K[:2, 2]) | {"s": K[0, 1]}


def _plain(focal, centre):
    return dict(zip(("fx", "fy", "cx", "cy"), [*focal, *centre], strict=True))


def _numbered(letter, values, first=1):
    return {f"{letter}{k}": float(value) for k, value in enumerate(values, first)}


def _distortion(camera):
    tangential = getattr(camera, "tangential", np.zeros(2))
    return _numbered("k", camera.radial) | _numbered("p", tangential)


def camera_of(formula, p, width, height):
    """Camera of Raxel that equals a formula with these parameters, or None."""
    K = np.array([[p["fx"], p["s"], p["cx"]], [0, p["fy"], p["cy"]], [0, 0, 1]])
    size = width, height
    centre, focal = K[:2, 2], (p["fx"], p["fy"])
    radial = np.trim_zeros([p["k1"], p["k2"], p["k3"]], "b")
    tangential = p["p1"], p["p2"]
    further = any(p[name] for name in ("k4", "k5", "k6", "s1", "s2", "s3", "s4"))
    match formula:
        case "pinhole" if not further and any(tangential):
            return BrownCamera(K, radial, tangential, *size)
        case "pinhole" if not further:
            return PerspectiveCamera(K, radial, *size)
        case "fisheye":
            k = [1, p["k1"], p["k2"], p["k3"], p["k4"]]
            return KannalaBrandtCamera(k, focal, centre, *size)
        case "omni":
            prism = p["s1"], p["s3"]
            return UnifiedSphereCamera(
                p["xi"], K, *size, radial, tangential, prism=prism
            )
        case "eucm" if p["beta"] == 1 and p["alpha"] < 1:
            xi = p["alpha"] / (1 - p["alpha"])
            K[:2, :2] *= 1 + xi
            return UnifiedSphereCamera(xi, K, *size)
        case "fov":
            return FieldOfViewCamera(p["omega"], K, *size)
        case "division":
            return DivisionCamera(K, [p["k1"]], *size)
        case "stereographic" if p["fx"] == p["fy"]:
            return FisheyeCamera("stereographic", p["fx"], centre, *size)
        case "ocam":
            return _camera_of_ocam(p, *size)
    return None


def _camera_of_ocam(p, width, height):
    names = [f"a{k}" for k in range(2, 25)]
    powers = np.trim_zeros([p[name] for name in names], "b")
    affine = p["c"], p["d"], p["e"]
    centre = p["cx"], p["cy"]
    return ScaramuzzaCamera([p["a0"], *powers], centre, width, height, affine)
