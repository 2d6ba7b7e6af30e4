"""Content of the formats' files: how each one states model, parameters and size.

Pixels and axes are those of the format. A reader returns (model or None, parameters,
width, height). It raises KeyError for a missing field, and other built-in errors for
one of a wrong form.
"""

import ast
import json
import re
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
import yaml

from raxel.io.documents import read_yaml
from raxel.io.files import check_file, read_text

MAX_BYTES = 1_000_000
INVERSE_DEGREE = 14


class Record(NamedTuple):
    """A model of a format, its parameters by name in the order of the file, the size of
    the image in px, and lines about the export."""

    model: str
    p: dict[str, float]
    width: int
    height: int
    notes: list[str]


def _matrix_and_distortion(record):
    p = record.p
    K = [[p["fx"], p.get("s", 0.0), p["cx"]], [0.0, p["fy"], p["cy"]], [0.0, 0.0, 1.0]]
    return K, [v for name, v in p.items() if name[0] in "kps" and name != "s"]


_yaml = partial(yaml.safe_dump, sort_keys=False, default_flow_style=None)


def _commented(record, text):
    return "".join(f"# {line}\n" for line in record.notes) + text


def _nine(K):
    """The numbers of a matrix, by rows."""
    if len(K) != 9:
        raise ValueError(f"camera_matrix: found {len(K)} numbers, expected 9")
    return K


def _plain(K, *rest):
    """Parameters (fx, fy, cx, cy, ...) of a matrix without skew."""
    if K[1]:
        raise ValueError(f"camera_matrix: skew {K[1]:g}, which the model ignores")
    return [K[0], K[4], K[2], K[5], *rest]


def _lines(path):
    """Lines of a text that are neither empty nor a comment."""
    lines = map(str.strip, read_text(path, MAX_BYTES).splitlines())
    return [line for line in lines if line and not line.startswith("#")]


# OpenCV: the keys of its calibration sample, as XML or YAML.


def _to_opencv(record, suffix):
    mode = cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY
    file = cv2.FileStorage(".xml" if suffix == ".xml" else ".yml", mode)
    file.writeComment("\n".join(record.notes))
    K, further = map(np.atleast_2d, _matrix_and_distortion(record))
    size = {"image_width": record.width, "image_height": record.height}
    content = size | {"camera_matrix": K, "distortion_coefficients": further}
    content |= {"xi": record.p["xi"]} if "xi" in record.p else {}
    for name, value in content.items():
        file.write(name, value)
    return file.releaseAndGetString()


def _from_opencv(path, terms=12, omnidir=False):
    check_file(path, MAX_BYTES)

    def value(name):
        node = file.getNode(name)
        if node.empty():
            raise KeyError(name)
        return np.ravel(node.mat() if node.isMap() else node.real()).tolist()

    try:
        file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        K, further = _nine(value("camera_matrix")), value("distortion_coefficients")
        size = value("image_width") + value("image_height")
    except (cv2.error, SystemError) as fault:
        raise ValueError("no matrices in XML or YAML of OpenCV") from fault
    if omnidir:
        affine = [K[0], K[4], K[1], K[2], K[5]]
        return None, value("xi") + affine + further, *size
    # Terms beyond the number that a file has are 0.
    further = np.trim_zeros(further, "b")
    return None, _plain(K, *further, *[0.0] * (terms - len(further))), *size


# ROS: camera_info.


def _to_ros(record, _):
    def matrix(rows):
        data = [float(x) for row in rows for x in row]
        return {"rows": len(rows), "cols": len(rows[0]), "data": data}

    K, further = _matrix_and_distortion(record)
    data = {
        "image_width": record.width,
        "image_height": record.height,
        "camera_name": "camera",
        "camera_matrix": matrix(K),
        "distortion_model": record.model,
        "distortion_coefficients": matrix([further]),
        "rectification_matrix": matrix(np.eye(3)),
        "projection_matrix": matrix([[*row, 0.0] for row in K]),
    }
    return _commented(record, _yaml(data))


def _from_ros(path):
    data = read_yaml(path)
    model, further = data["distortion_model"], data["distortion_coefficients"]["data"]
    if model == "plumb_bob":
        further = [*further, 0.0][:5]  # some files have four
    values = _plain(_nine(data["camera_matrix"]["data"]), *further)
    return model, values, data["image_width"], data["image_height"]


# Kalibr: camchain.yaml.


def _to_kalibr(record, _):
    camera, distortion = record.model.split("-")
    values = list(record.p.values())
    count = {"pinhole": 4, "omni": 5}.get(camera, 6)
    data = {
        "camera_model": camera,
        "intrinsics": values[:count],
        "distortion_model": distortion,
        "distortion_coeffs": values[count:],
        "resolution": [record.width, record.height],
    }
    return _commented(record, _yaml({"cam0": data}))


def _from_kalibr(path):
    data = read_yaml(path)
    cameras = [str(name) for name in data if re.fullmatch(r"cam\d+", str(name))]
    if len(cameras) > 1:
        raise ValueError(f"{len(cameras)} cameras; keep one of {', '.join(cameras)}")
    data = data["cam0"]
    model = f"{data['camera_model']}-{data['distortion_model']}"
    values = [*data["intrinsics"], *data["distortion_coeffs"]]
    return model, values, *data["resolution"]


# Basalt: calibration.json, with neutral values for the IMU.


def _to_basalt(record, _):
    p = {{"omega": "w"}.get(name, name): v for name, v in record.p.items()}
    noise = ("accel_noise_std", "gyro_noise_std", "accel_bias_std", "gyro_bias_std")
    data = {
        "T_imu_cam": [dict.fromkeys(("px", "py", "pz", "qx", "qy", "qz"), 0.0)],
        "intrinsics": [{"camera_type": record.model, "intrinsics": p}],
        "resolution": [[record.width, record.height]],
        "calib_accel_bias": [0.0] * 9,
        "calib_gyro_bias": [0.0] * 12,
        "imu_update_rate": 200.0,
        "cam_time_offset_ns": 0,
        "vignette": [],
    } | dict.fromkeys(noise, [0.0] * 3)
    data["T_imu_cam"][0]["qw"] = 1.0
    return json.dumps({"value0": data, "raxel_export": record.notes}, indent=1)


# COLMAP: cameras.txt.


def _to_colmap(record, _):
    head = f"1 {record.model} {record.width} {record.height}"
    return _commented(record, f"{head} {' '.join(map(repr, record.p.values()))}\n")


def _from_colmap(path):
    lines = _lines(path)
    if len(lines) != 1:
        raise ValueError(f"{len(lines)} cameras; keep one line")
    _, model, width, height, *values = lines[0].split()
    return model, values, width, height


# nerfstudio: transforms.json, to which the frames are to be added.


def _to_nerfstudio(record, _):
    p = {
        {"fx": "fl_x", "fy": "fl_y"}.get(name, name): v for name, v in record.p.items()
    }
    data = {"camera_model": record.model, "w": record.width, "h": record.height} | p
    return json.dumps(data | {"frames": [], "raxel_export": record.notes}, indent=1)


# mrcal: .cameramodel.


def _to_mrcal(record, _):
    data = {
        "lensmodel": record.model,
        "intrinsics": list(record.p.values()),
        "extrinsics": [0.0] * 6,
        "imagersize": [record.width, record.height],
    }
    return _commented(record, f"{data}\n")


def _from_mrcal(path):
    data = ast.literal_eval("\n".join(_lines(path)))
    return data["lensmodel"], data["intrinsics"], *data["imagersize"]


# OCamCalib: calib_results.txt, blocks of numbers after one line of comment each. Rows
# come first, and z is backward.


def _swapped(polynomial, affine):
    """Polynomial (a0, a2, ...) and affine map with x and y swapped and z reversed: from
    Raxel's to OCamCalib's, and back."""
    (a0, *powers), (c, d, e) = polynomial, affine
    turned = [-a0 * c, *(-a * c ** (1.0 - k) for k, a in enumerate(powers, 2))]
    return turned, [1 / c, e / c, d / c]


def _to_ocamcalib(record, _):
    *polynomial, c, d, e, u, v = record.p.values()
    polynomial, affine = _swapped(np.trim_zeros(polynomial, "b"), (c, d, e))
    forward = [polynomial[0], 0.0, *polynomial[1:]]
    corner = np.maximum([u, v], [record.width - u, record.height - v])
    backward, error = _inverse(forward, np.hypot(*corner))
    blocks = {
        f"ss, polynomial of cam2world; {'; '.join(record.notes)}": forward,
        f"invpol, polynomial of world2cam, error up to {error:.2g} px": backward,
        "row and column of the centre, from 0": [v, u],
        "affine parameters c, d, e": affine,
        "height and width": [record.height, record.width],
    }
    lines = [[head, " ".join(f"{x:.17g}" for x in row)] for head, row in blocks.items()]
    for line, row in zip(lines[:2], (forward, backward), strict=True):
        line[1] = f"{len(row)} {line[1]}"
    return "\n".join(f"#{head}\n\n{numbers}\n" for head, numbers in lines)


def _inverse(forward, reach):
    """Ascending polynomial of the elevation that gives the radius, up to `reach` or to
    the end of the rising part, and its largest error, px."""
    radius = np.linspace(0, reach, 2000)
    elevation = np.arctan2(np.polyval(forward[::-1], radius), radius)
    end = int(np.argmin(np.diff(elevation, append=-np.inf) > 0)) + 1
    radius, elevation = radius[:end], elevation[:end]
    fit = np.polynomial.Polynomial.fit(elevation, radius, INVERSE_DEGREE).convert()
    return fit.coef, np.abs(fit(elevation) - radius).max()


def _from_ocamcalib(path):
    rows = [[float(word) for word in line.split()] for line in _lines(path)]
    (_, a0, a1, *powers), _, (v, u), affine, (height, width) = rows
    if a1:
        raise ValueError(f"ss: found a1 = {a1:g}; the toolbox has 0")
    polynomial, affine = _swapped([a0, *powers], affine)
    polynomial += [0.0] * (24 - len(polynomial))
    return None, [*polynomial, *affine, u, v], width, height


WRITERS = {
    **dict.fromkeys(("opencv", "opencv-fisheye", "opencv-omnidir"), _to_opencv),
    "ros": _to_ros,
    "kalibr": _to_kalibr,
    "basalt": _to_basalt,
    "colmap": _to_colmap,
    "nerfstudio": _to_nerfstudio,
    "mrcal": _to_mrcal,
    "ocamcalib": _to_ocamcalib,
}
READERS: dict[str, Callable] = {
    "opencv": _from_opencv,
    "opencv-fisheye": partial(_from_opencv, terms=4),
    "opencv-omnidir": partial(_from_opencv, omnidir=True),
    "ros": _from_ros,
    "kalibr": _from_kalibr,
    "colmap": _from_colmap,
    "mrcal": _from_mrcal,
    "ocamcalib": _from_ocamcalib,
}
