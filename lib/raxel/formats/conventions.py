"""Conventions of the formats as data: pixels, axes, units, models, order of parameters.

Parameters have the names of the formulas in `models`, for all formats alike: OpenCV's
k, p and s, xi, alpha, beta and omega, and fx, fy, s (skew), cx, cy of the affine map.
"""

from typing import NamedTuple

import numpy as np


class Model(NamedTuple):
    """A camera model of a format.

    formula: its name in `models.FORMULAS`; names: parameters in the order of the file;
    max_angle_deg: largest angle to the axis that the reader's code accepts; refit: the
    parameters of a refit to other cameras, none if a richer model of the format exists.
    """

    formula: str
    names: str
    max_angle_deg: float = 180.0
    refit: str = ""


class Format(NamedTuple):
    """first_pixel: coordinate of the centre of the first pixel; R_format_camera: axes
    of the format in those of Raxel (x right, y down, z forward)."""

    models: dict[str, Model]
    first_pixel: float = 0.0
    axes: str = "x right, y down, z forward"
    R_format_camera: np.ndarray = np.eye(3)
    unit: str = "any"


# Formulas of tan(theta) end at 90 degrees. A refit stops before: the weight of a pixel
# in theta vanishes there, and the polynomials diverge.
PLANE, REFIT_PLANE = 90.0, 80.0
AFFINE = "fx fy cx cy"
RADTAN = f"{AFFINE} k1 k2 p1 p2"
PRISM = f"{RADTAN} k3 k4 k5 k6 s1 s2 s3 s4"
FISHEYE = f"{AFFINE} k1 k2 k3 k4"
EUCM, DOUBLE_SPHERE = f"{AFFINE} alpha beta", f"{AFFINE} xi alpha"
OMNIDIR = "xi fx fy s cx cy k1 k2 p1 p2"
RAD_TAN_THIN_PRISM = f"{AFFINE} k1 k2 k3 k4 k5 k6 p2 p1 s1 s2 s3 s4"
POWERS = " ".join(f"a{k}" for k in range(2, 25))
OCAM_REFIT = "a0 a2 a3 a4 a5 a6 c d e cx cy"
# In mm, metres or any other unit, central models have the same parameters.

_pinhole = Model("pinhole", AFFINE, PLANE)
_radtan = Model("pinhole", RADTAN, PLANE)
_plumb_bob = Model("pinhole", f"{RADTAN} k3", PLANE)
_rational = Model("pinhole", f"{RADTAN} k3 k4 k5 k6", PLANE)
_equidistant = Model("fisheye", FISHEYE, PLANE, FISHEYE)
FORMATS = {
    "opencv": Format(
        {
            "radial 3": _plumb_bob,
            "radial 6": _rational,
            "radial 6, prism": Model("pinhole", PRISM, PLANE, PRISM),
        }
    ),
    "opencv-fisheye": Format({"fisheye": _equidistant}),
    "opencv-omnidir": Format({"omnidir": Model("omni", OMNIDIR, 180, OMNIDIR)}),
    "ros": Format(
        {
            "plumb_bob": _plumb_bob,
            "rational_polynomial": _rational._replace(refit=_rational.names),
            "equidistant": _equidistant,
        },
        unit="m",
    ),
    "kalibr": Format(
        {
            "pinhole-none": _pinhole,
            "pinhole-radtan": _radtan._replace(refit=RADTAN),
            "pinhole-equidistant": _equidistant,
            "pinhole-fov": Model("fov", f"{AFFINE} omega", PLANE),
            "omni-none": Model("omni", f"xi {AFFINE}"),
            "omni-radtan": Model("omni", f"xi {RADTAN}", 180, f"xi {RADTAN}"),
            "eucm-none": Model("eucm", f"alpha beta {AFFINE}", 180, EUCM),
            "ds-none": Model("ds", f"xi alpha {AFFINE}", 180, DOUBLE_SPHERE),
        },
        unit="m",
    ),
    "basalt": Format(
        {
            "pinhole": _pinhole,
            "kb4": Model("fisheye", FISHEYE, 180, FISHEYE),
            "fov": Model("fov", f"{AFFINE} omega", PLANE),
            "ucm": Model("eucm", f"{AFFINE} alpha"),
            "eucm": Model("eucm", EUCM, 180, EUCM),
            "ds": Model("ds", DOUBLE_SPHERE, 180, DOUBLE_SPHERE),
        },
        unit="m",
    ),
    "colmap": Format(
        {
            "PINHOLE": _pinhole,
            "OPENCV": _radtan,
            "FULL_OPENCV": _rational._replace(refit=_rational.names),
            "FISHEYE": Model("fisheye", AFFINE, PLANE),
            "OPENCV_FISHEYE": _equidistant._replace(refit=""),
            "RAD_TAN_THIN_PRISM_FISHEYE": Model(
                "prism fisheye", RAD_TAN_THIN_PRISM, PLANE, RAD_TAN_THIN_PRISM
            ),
            "FOV": Model("fov", f"{AFFINE} omega", PLANE),
            "DIVISION": Model("division", f"{AFFINE} k1", PLANE),
            "EUCM": Model("eucm", EUCM, PLANE),
            # For import only; f stands for fx and fy.
            "SIMPLE_PINHOLE": Model("pinhole", "f cx cy", PLANE),
            "SIMPLE_RADIAL": Model("pinhole", "f cx cy k1", PLANE),
            "RADIAL": Model("pinhole", "f cx cy k1 k2", PLANE),
            "SIMPLE_FISHEYE": Model("fisheye", "f cx cy", PLANE),
            "SIMPLE_RADIAL_FISHEYE": Model("fisheye", "f cx cy k1", PLANE),
            "RADIAL_FISHEYE": Model("fisheye", "f cx cy k1 k2", PLANE),
            "SIMPLE_DIVISION": Model("division", "f cx cy k1", PLANE),
        },
        first_pixel=0.5,
    ),
    "nerfstudio": Format(
        {
            "PINHOLE": _pinhole,
            "OPENCV": _plumb_bob._replace(refit=_plumb_bob.names),
            "OPENCV_FISHEYE": Model("fisheye", FISHEYE, 180, FISHEYE),
        },
        first_pixel=0.5,
        axes="x right, y up, z backward",
        R_format_camera=np.diag([1.0, -1, -1]),
    ),
    "mrcal": Format(
        {
            "LENSMODEL_PINHOLE": _pinhole,
            "LENSMODEL_STEREOGRAPHIC": Model("stereographic", AFFINE),
            "LENSMODEL_OPENCV4": _radtan,
            "LENSMODEL_OPENCV5": _plumb_bob,
            "LENSMODEL_OPENCV8": _rational,
            "LENSMODEL_OPENCV12": Model("pinhole", PRISM, PLANE, PRISM),
        },
        unit="m",
    ),
    "ocamcalib": Format(
        {"scaramuzza": Model("ocam", f"a0 {POWERS} c d e cx cy", 180, OCAM_REFIT)},
        axes="x down, y right, z backward",
        R_format_camera=np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    ),
}
# Formats of pixel tables: no model.
TABLES = "maps", "table"
