"""Cameras whose model a format holds exactly, with the name of the model there."""

import numpy as np

from raxel.cameras import (
    BrownCamera,
    DivisionCamera,
    FieldOfViewCamera,
    FisheyeCamera,
    KannalaBrandtCamera,
    PerspectiveCamera,
    ScaramuzzaCamera,
    UnifiedSphereCamera,
)

SIZE, CENTRE = (640, 480), (330.0, 250.0)
K = np.array([[300, 0, 330], [0, 280, 250], [0, 0, 1.0]])
SKEW = K + [[0, 1.5, 0], [0, 0, 0], [0, 0, 0]]
CAMERAS = {
    "pinhole": PerspectiveCamera(K, [], *SIZE),
    "perspective": PerspectiveCamera(K, [-0.2, 0.03], *SIZE),
    "brown": BrownCamera(K, [-0.2, 0.03], [0.002, -0.003], *SIZE),
    "brown 3": BrownCamera(K, [-0.2, 0.04, -0.003], [0.002, -0.003], *SIZE),
    "kannala-brandt": KannalaBrandtCamera(
        [0.9, -0.02, 0.003, -0.001, 0.0001], (170, 160), CENTRE, *SIZE
    ),
    "equidistant": FisheyeCamera("equidistance", 150, CENTRE, *SIZE),
    "stereographic": FisheyeCamera("stereographic", 150, CENTRE, *SIZE),
    "sphere": UnifiedSphereCamera(0.8, K, *SIZE),
    "mei-rives": UnifiedSphereCamera(0.9, K, *SIZE, [-0.1, 0.02], [0.001, -0.002]),
    "mei-rives, skew": UnifiedSphereCamera(0.9, SKEW, *SIZE, [-0.1, 0.02]),
    "division": DivisionCamera(K, [-0.2], *SIZE),
    "field of view": FieldOfViewCamera(1.2, K, *SIZE),
    "scaramuzza": ScaramuzzaCamera(
        [150, -2e-3, 1e-7, -1e-9], CENTRE, *SIZE, affine=(1.01, 0.003, -0.002)
    ),
}
SKEWED = {
    "perspective, skew": PerspectiveCamera(SKEW, [-0.2, 0.03], *SIZE),
    "unified sphere, skew": UnifiedSphereCamera(0.8, SKEW, *SIZE),
}
EXACT = {
    "opencv": {"pinhole": "radial 3", "perspective": "radial 3", "brown 3": "radial 3"},
    "opencv-fisheye": {"kannala-brandt": "fisheye", "equidistant": "fisheye"},
    "opencv-omnidir": {
        "sphere": "omnidir",
        "mei-rives": "omnidir",
        "mei-rives, skew": "omnidir",
        "stereographic": "omnidir",
    },
    "ros": {
        "pinhole": "plumb_bob",
        "brown 3": "plumb_bob",
        "kannala-brandt": "equidistant",
        "equidistant": "equidistant",
    },
    "kalibr": {
        "pinhole": "pinhole-none",
        "perspective": "pinhole-radtan",
        "brown": "pinhole-radtan",
        "kannala-brandt": "pinhole-equidistant",
        "equidistant": "pinhole-equidistant",
        "field of view": "pinhole-fov",
        "sphere": "omni-none",
        "mei-rives": "omni-radtan",
    },
    "basalt": {
        "pinhole": "pinhole",
        "kannala-brandt": "kb4",
        "sphere": "ucm",
        "field of view": "fov",
    },
    "colmap": {
        "pinhole": "PINHOLE",
        "brown": "OPENCV",
        "brown 3": "FULL_OPENCV",
        "equidistant": "FISHEYE",
        "kannala-brandt": "OPENCV_FISHEYE",
        "field of view": "FOV",
        "division": "DIVISION",
        "sphere": "EUCM",
    },
    "nerfstudio": {
        "pinhole": "PINHOLE",
        "brown 3": "OPENCV",
        "kannala-brandt": "OPENCV_FISHEYE",
    },
    "mrcal": {
        "pinhole": "LENSMODEL_PINHOLE",
        "brown": "LENSMODEL_OPENCV4",
        "brown 3": "LENSMODEL_OPENCV5",
        "stereographic": "LENSMODEL_STEREOGRAPHIC",
    },
    "ocamcalib": {"scaramuzza": "scaramuzza"},
}
# Cells of this dictionary, (format, name of the camera).
CELLS = [(form, name) for form, cells in EXACT.items() for name in cells]
