"""What the trials of benchmarks share: scores of a set, checks of the laboratory."""

from functools import cache

import numpy as np

from chapters.shared.records import set_of
from chapters.shared.rigs import RIGS
from raxel.calibration import calibrate_generic, calibrate_zhang
from raxel.calibration.parametric.opencv_fisheye import calibrate_opencv_fisheye
from raxel.cameras.registry import CAMERAS, camera_from
from raxel.errors import InputError
from raxel.evaluation.benchmark import score_camera, scoring_grid
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import Plain, Rectangle, Sensor, TexturedScene, board_scene, render
from raxel.lab.corner_check import board_before, fitted_corners
from raxel.sets import Chessboard

SCORED = {
    "quick": ("coolpix-fce8-zoom-2",),
    "full": tuple(f"coolpix-fce8-zoom-{zoom}" for zoom in (1, 2, 3)),
}
VIEWS = {"quick": 3, "full": 5}
DETECTORS = ("raxel", "opencv", "opencv-sb")
RECORD = "detectors"  # of data/records
SIZE = {"width": 200, "height": 160}
CENTRE = [99.3, 79.6]
PLACES = ((101, 81), (58, 44))
VIEW_PX = 1000  # each way, of the picture whose time is taken
RENDERINGS = {"quick": 2, "full": 8}
NOISE = {"white_e": 20000.0, "read_noise_e": 20.0, "radiance": 0.4}


@cache
def rig_names():
    """Names of the repository's rigs."""
    return sorted(path.stem for path in RIGS.glob("*.yaml"))


def kept_scores(scored):
    """What the record keeps of the scores of a detector."""
    kept = "found", "right", "rms_px", "median_px", "max_px"
    return {name: scored[name] for name in kept}


def camera_scores(image_set, views, rng):
    """Scores of every calibration, or why there are none.

    Angles on the pixels that the general camera has a ray for; the share with a ray,
    of all that truly have one.
    """
    size = image_set.width, image_set.height
    builders = {
        "general": lambda: calibrate_generic(views, *size, rng=rng),
        "zhang": lambda: calibrate_zhang(views, *size),
        "opencv_fisheye": lambda: calibrate_opencv_fisheye(views, *size),
    }
    cameras, scores = {}, {}
    for name, build in builders.items():
        try:
            cameras[name] = build().camera
        except InputError as fault:
            scores[name] = {"reason": str(fault)}
    if "general" not in cameras:
        return scores
    pixels = scoring_grid(*size)
    shared = pixels[cameras["general"].rays(pixels).valid]
    for name, camera in cameras.items():
        share = score_camera(image_set, camera, pixels)["share_with_ray"]
        scores[name] = score_camera(image_set, camera, shared)
        scores[name]["share_with_ray"] = share
    return scores


def recorded_scores(condition):
    """What the record says of one set of photographs."""
    kept = set_of(RECORD, condition)
    told = {
        run["detector"]: {what: run[what] for what in ("right", "wrong")}
        for run in kept["scores"]
        if run["size"] == "given"
    }
    about = {name: kept[name] for name in ("camera", "source", "licence")}
    return {"images": kept["scores"][0]["images"], **told, **about}


@cache
def cameras():
    """One small camera of each listed kind."""
    K = [[150, 0.5, CENTRE[0]], [0, 145, CENTRE[1]], [0, 0, 1]]
    viewer = camera_from(
        "perspective",
        {
            "K": [[280, 0, CENTRE[0]], [0, 280, CENTRE[1]], [0, 0, 1]],
            "radial": [],
            **SIZE,
        },
    )
    at = {"principal_point": CENTRE, **SIZE}
    fisheye = {"focal_px": 60, "max_angle": 1.7, **at}
    made = {
        "perspective": {"K": K, "radial": [-0.15, 0.02], **SIZE},
        "brown": {"K": K, "radial": [-0.1], "tangential": [0.01, 0.02]},
        "division": {"K": K, "coefficients": [-0.3]},
        "field of view": {"K": K, "omega": 1.1},
        "fisheye": {"projection": "equidistance", **fisheye},
        "kannala-brandt": {"k": [1, -0.02, 0.003], "pixels_per_unit": [80, 78], **at},
        "unified sphere": {"xi": 0.9, "K": K},
    }
    named = {kind: camera_from(kind, SIZE | fields) for kind, fields in made.items()}
    mirror = CAMERAS["quadric mirror"]
    named["hyperboloidal mirror"] = mirror.aligned(viewer, "hyperboloid", (30, 40), 25)
    return named


def corners_check(condition, rng):
    """Fitted corners of two boards less their projections, px."""
    camera = cameras()[condition["camera"]]
    errors = []
    for middle in PLACES:
        board, T = board_before(camera, middle)
        image = render(camera, np.eye(4), board_scene(board, T))
        points = on_plane(board.points())
        pixels = camera.project(transform(T, points)).pixels
        found = fitted_corners(image, pixels)[0]
        errors.append(np.linalg.norm(found - pixels, axis=1))
    errors = np.concatenate(errors)
    return {"rms": float(np.sqrt(np.mean(errors**2))), "largest": float(errors.max())}


def _tilted_sheet(rng):
    """A picture of a white sheet turned in its plane, and its area in px."""
    scale, width, height = 2.0, 31.7, 22.3
    fields = {
        "pixels_per_mm": scale,
        "principal_point": [50, 40],
        "width": 100,
        "height": 80,
    }
    camera = camera_from("orthographic", fields)
    R = rotation_from_vector([0, 0, rng.uniform(0, np.pi / 2)])
    sheet = Rectangle(pose(R, [0, 0, 100]), width, height, (-width / 2, -height / 2))
    picture = render(camera, np.eye(4), TexturedScene(((sheet, Plain(1.0)),), 0.0))
    return picture, scale**2 * width * height


def area_check(condition, rng):
    """Light of a turned sheet against its area, as a share of it."""
    off = [
        picture.sum() / area - 1
        for picture, area in (_tilted_sheet(rng) for _ in range(8))
    ]
    return {
        "rms": float(np.sqrt(np.mean(np.square(off)))),
        "largest": float(np.abs(off).max()),
    }


def edge_check(condition, rng):
    """Pixels that an upright edge crosses against the share it covers."""
    fields = {"pixels_per_mm": 1, "principal_point": [0, 0], "width": 12, "height": 10}
    camera = camera_from("orthographic", fields)
    board = Chessboard(3, 3, 4.0)
    off = []
    for x in rng.uniform(-0.5, 0.5, 16):
        T = pose(np.eye(3), [x, 0, 100])
        scene = board_scene(board, T, 4.0, black=0.0, white=1.0)
        value = float(render(camera, np.eye(4), scene)[1, 0])
        off.append(abs(value - (0.5 - x)))
    return {"rms": float(np.sqrt(np.mean(np.square(off)))), "largest": float(max(off))}


def noise_check(condition, rng):
    """Spread of a plain picture against shot and read noise, as a share."""
    white, read = NOISE["white_e"], NOISE["read_noise_e"]
    sensor = Sensor(white_e=white, full_well_e=2 * white, read_noise_e=read, bits=16)
    plain = np.full((500, 500), NOISE["radiance"], np.float32)
    values = sensor.expose(plain, rng).astype(float) / (2**16 - 1)
    electrons = values / values.mean() * white * NOISE["radiance"]
    closed = np.sqrt(white * NOISE["radiance"] + read**2)
    off = abs(electrons.std() / closed - 1)
    return {"rms": float(off), "largest": float(off)}


CHECKS = {
    "corners": corners_check,
    "area": area_check,
    "edge": edge_check,
    "noise": noise_check,
}


def megapixel_trial(condition, rng):
    """One picture of a chessboard that fills a megapixel."""
    camera = camera_from(
        "perspective",
        {
            "K": [[900, 0, 499.5], [0, 900, 499.5], [0, 0, 1]],
            "radial": [-0.1],
            "width": VIEW_PX,
            "height": VIEW_PX,
        },
    )
    board = Chessboard(12, 9, 30.0)
    R = rotation_from_vector(rng.uniform(-0.3, 0.3, 3))
    T = pose(R, [0, 0, 430] - R @ [165, 120, 0])
    picture = render(camera, np.eye(4), board_scene(board, T, 30.0))
    return {"mean_radiance": float(picture.mean())}
