"""Pixels of directions by the code that reads each format, or by its source's formula.

Needs numpy, PyYAML and the reader only: `make test-formats` runs it in environments of
their own. Directions (N, 3) are in the camera frame of the format, pixels in its image.
"""

import json
import sys
from functools import partial
from pathlib import Path

import numpy as np

ZERO = np.zeros(3)


def opencv(path, d, project=None):
    import cv2

    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    names = ("camera_matrix", "distortion_coefficients")
    K, D = (file.getNode(name).mat() for name in names)
    if project == "omnidir":
        xi = file.getNode("xi").real()
        return cv2.omnidir.projectPoints(d[:, None], ZERO, ZERO, K, xi, D)[0][:, 0]
    project = cv2.fisheye.projectPoints if project else cv2.projectPoints
    return project(d[:, None], ZERO, ZERO, K, D)[0][:, 0]


def ros(path, d):
    import cv2
    import yaml

    data = yaml.safe_load(path.read_text())
    K = np.reshape(data["camera_matrix"]["data"], (3, 3))
    D = np.array(data["distortion_coefficients"]["data"])
    equidistant = data["distortion_model"] == "equidistant"
    project = cv2.fisheye.projectPoints if equidistant else cv2.projectPoints
    return project(d[:, None], ZERO, ZERO, K, D)[0][:, 0]


def colmap(path, d):
    import pycolmap

    (path.parent / "cameras.txt").write_text(path.read_text())
    for name in ("images", "points3D", "rigs", "frames"):
        (path.parent / f"{name}.txt").touch()
    scene = pycolmap.Reconstruction()
    scene.read_text(str(path.parent))
    return scene.cameras[1].img_from_cam(d)


def mrcal(path, d):
    import mrcal

    return mrcal.project(d, *mrcal.cameramodel(str(path)).intrinsics())


# Formulas of the sources.


def theta_polynomial(d, k):
    r = np.hypot(*d[:, :2].T)
    theta = np.arctan2(r, d[:, 2])
    turned = theta + sum(c * theta ** (2 * n + 3) for n, c in enumerate(k))
    return turned[:, None] * d[:, :2] / r[:, None]


def radtan(p, k1, k2, p1, p2, k3=0.0):
    x, y = p.T
    r = x * x + y * y
    f = k1 * r + k2 * r * r + k3 * r**3
    return np.column_stack(
        [
            x + x * f + 2 * p1 * x * y + p2 * (r + 2 * x * x),
            y + y * f + 2 * p2 * x * y + p1 * (r + 2 * y * y),
        ]
    )


def fov(d, w):
    r = np.hypot(*d[:, :2].T)
    turned = np.arctan2(2 * r * np.tan(w / 2), d[:, 2]) / w
    return turned[:, None] * d[:, :2] / r[:, None]


def eucm(d, alpha, beta):
    x, y, z = d.T
    depth = alpha * np.sqrt(beta * (x * x + y * y) + z * z) + (1 - alpha) * z
    return d[:, :2] / depth[:, None]


def kalibr(path, d):
    """aslam_cv: projection, then distortion of the normalised point."""
    import yaml

    camera = yaml.safe_load(path.read_text())["cam0"]
    *shape, fu, fv, pu, pv = camera["intrinsics"]
    k = camera["distortion_coeffs"]
    if camera["camera_model"] == "eucm":
        p = eucm(d, *shape)
    elif camera["distortion_model"] == "equidistant":
        p = theta_polynomial(d, k)
    elif camera["distortion_model"] == "fov":
        p = fov(d, *k)
    else:
        xi = shape[0] if shape else 0.0
        p = d[:, :2] / (d[:, 2] + xi * np.linalg.norm(d, axis=1))[:, None]
        p = radtan(p, *k) if k else p
    return p * [fu, fv] + [pu, pv]


def basalt(path, d):
    """basalt-headers: camera/*.hpp."""
    data = json.loads(path.read_text())["value0"]["intrinsics"][0]
    p = data["intrinsics"]
    match data["camera_type"]:
        case "kb4":
            points = theta_polynomial(d, [p[f"k{n}"] for n in (1, 2, 3, 4)])
        case "fov":
            points = fov(d, p["w"])
        case "pinhole":
            points = d[:, :2] / d[:, 2:]
        case "ucm" | "eucm":
            points = eucm(d, p["alpha"], p.get("beta", 1.0))
    return points * [p["fx"], p["fy"]] + [p["cx"], p["cy"]]


def nerfstudio(path, d):
    """cameras.py: the axes are OpenGL's."""
    data = json.loads(path.read_text())
    d = d * [1, -1, -1]
    if data["camera_model"] == "OPENCV_FISHEYE":
        p = theta_polynomial(d, [data[f"k{n}"] for n in (1, 2, 3, 4)])
    else:
        names = ("k1", "k2", "p1", "p2", "k3")
        p = radtan(d[:, :2] / d[:, 2:], *(data.get(name, 0.0) for name in names))
    return p * [data["fl_x"], data["fl_y"]] + [data["cx"], data["cy"]]


def ocamcalib(path, d):
    """ocam_functions.c: world2cam, and (u, v) from (row, column)."""
    lines = [x for x in path.read_text().splitlines() if x and x[0] != "#"]
    _, (_, *inverse), (xc, yc), (c, d_, e), _ = (
        [float(word) for word in line.split()] for line in lines
    )
    across = np.hypot(*d[:, :2].T)
    rho = np.polyval(inverse[::-1], np.arctan(d[:, 2] / across))
    x, y = rho * d[:, 0] / across, rho * d[:, 1] / across
    return np.column_stack([x * e + y + yc, x * c + y * d_ + xc])


READERS = {
    "opencv": opencv,
    "opencv-fisheye": partial(opencv, project="fisheye"),
    "opencv-omnidir": partial(opencv, project="omnidir"),
    "ros": ros,
    "kalibr": kalibr,
    "basalt": basalt,
    "colmap": colmap,
    "nerfstudio": nerfstudio,
    "mrcal": mrcal,
    "ocamcalib": ocamcalib,
}


def exported(form, camera, folder):
    """The export, its file, 1 000 pixels, their directions in the format's frame."""
    path = folder / f"camera{'.yaml' if form.startswith('opencv') else '.txt'}"
    from raxel.formats import export_camera

    made = export_camera(camera, path, form, allow_residual=True)
    pixels = np.random.default_rng(5).uniform(0, [639, 479], (1000, 2))
    rays = camera.rays(pixels)
    held = rays.valid & (rays.directions[:, 2] > np.cos(np.radians(made.angle_deg)))
    assert held.sum() > 400
    return made, path, pixels[held], rays.directions[held] @ made.R_format_camera.T


if __name__ == "__main__":
    # Pixels of exported cameras: FORMAT FILE..., with FILE.npy of directions.
    for name in sys.argv[2:]:
        found = READERS[sys.argv[1]](Path(name), np.load(f"{name}.npy"))
        np.save(f"{name}.pixels.npy", found)
