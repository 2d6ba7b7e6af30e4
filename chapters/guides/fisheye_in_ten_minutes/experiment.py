"""Trials of this page, their conditions and constants."""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from chapters.shared.general import T_world_camera
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    board_views,
    calibrate_generic,
    calibrate_lens,
    calibrate_opencv_fisheye,
    calibrate_zhang,
)
from raxel.cameras import camera_from, load_camera
from raxel.cli import main
from raxel.errors import CalibrationError
from raxel.evaluation import angular_residual, evaluate_camera, scoring_grid
from raxel.features import read_boards
from raxel.geometry import nearest_rotation, pose, rotation_from_vector
from raxel.lab import Visibility, facade, render_board
from raxel.multiview import perspective_view, resample, share_seen, source_pixels
from raxel.sets import Chessboard, ImageSet, View, load_set, write_set

# The lens, the board, and its poses by a plan.


LENS = "coolpix-fce8-zoom-3"
BORDER_MM = 7.5
# Corners closer than about 5 px are imprecise; the limit here is larger.
VISIBLE = Visibility(margin_px=4.0, least_spacing_px=8.0)
# Largest deviation of a hand-held board from its planned pose, to either side.
POLAR_DEG, AZIMUTH_DEG, TILT_DEG, NEARER = 2.0, 5.0, 5.0, 0.05


class Ring(NamedTuple):
    """Boards at one angle from the optical axis, all around it.

    A positive tilt turns the outer edge of a board towards the camera.
    """

    boards: int
    polar_deg: float
    distance_mm: float
    tilt_deg: float
    first_deg: float


class Walk(NamedTuple):
    """Size of the example calibration.

    Width and height as shares of the lens's own image, blur as a share of its own; the
    board; the plan, ring by ring; and the number of held-out boards."""

    scale: float
    blur: float
    columns: int
    rows: int
    pitch_mm: float
    plan: tuple[Ring, ...]
    kept_out: int


SIZES = {
    "quick": Walk(
        0.4, 0.0, 7, 5, 33.0,
        (
            Ring(1, 8.0, 150.0, 25.0, 30.0),
            Ring(3, 35.0, 150.0, 15.0, 10.0),
            Ring(4, 62.0, 220.0, -20.0, 0.0),
        ),
        1,
    ),
    "full": Walk(
        1.0, 1.0, 17, 12, 15.0,
        (
            Ring(1, 8.0, 150.0, 25.0, 30.0),
            Ring(5, 35.0, 150.0, 15.0, 10.0),
            Ring(5, 75.0, 280.0, -20.0, 0.0),
            Ring(5, 75.0, 280.0, -20.0, 36.0),
        ),
        4,
    ),
}  # fmt: skip
RIM_DEG = 60.0  # rings farther out than this are outer rings


def rig_of(size):
    """Return the rig of the lens with the board of this size."""
    rig = rig_named(LENS)
    lens, scale = rig.camera, size.scale
    camera = camera_from(
        lens.kind,
        {
            "k": lens.k.tolist(),
            "pixels_per_unit": [scale * x for x in lens.pixels_per_unit],
            "principal_point": [scale * (x + 0.5) - 0.5 for x in lens.principal_point],
            "max_angle": lens.max_angle,
            "width": round(scale * lens.width),
            "height": round(scale * lens.height),
        },
    )
    blur = tuple(size.blur * sd for sd in rig.optics.blur_sd_px)
    return replace(
        rig,
        camera=camera,
        optics=replace(rig.optics, blur_sd_px=blur),
        target=Chessboard(size.columns, size.rows, size.pitch_mm),
        border_mm=BORDER_MM,
        visibility=VISIBLE,
    )


def places_of(plan):
    """Return the plan board by board: (polar, azimuth, distance, tilt), deg and mm."""
    return [
        (ring.polar_deg, ring.first_deg + k * 360 / ring.boards, *ring[2:4])
        for ring in plan
        for k in range(ring.boards)
    ]


def inner_boards(plan):
    """Return the number of boards in the inner rings, which come first."""
    return sum(ring.boards for ring in plan if ring.polar_deg < RIM_DEG)


def held_at(rig, place, rng):
    """Return the pose (4, 4) of a hand-held board near its place, fully visible."""
    polar, azimuth, distance, tilt = place
    while True:
        T = placed(
            rig,
            polar + rng.uniform(-POLAR_DEG, POLAR_DEG),
            azimuth + rng.uniform(-AZIMUTH_DEG, AZIMUTH_DEG),
            distance * (1 + rng.uniform(-NEARER, NEARER)),
            tilt + rng.uniform(-TILT_DEG, TILT_DEG),
        )
        if rig.shows(T):
            return T


def placed(rig, polar_deg, azimuth_deg, distance_mm, tilt_deg):
    """Return the pose (4, 4) of a board with rows along a circle about the axis."""
    polar, azimuth = np.radians([polar_deg, azimuth_deg])
    around = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    ahead = np.array(
        [
            np.sin(polar) * np.cos(azimuth),
            np.sin(polar) * np.sin(azimuth),
            np.cos(polar),
        ]
    )
    facing = np.column_stack([around, np.cross(ahead, around), ahead])
    R = facing @ rotation_from_vector([np.radians(tilt_deg), 0.0, 0.0])
    corner, extent = rig.extent
    return pose(R, distance_mm * ahead - R @ [*(corner + extent / 2), 0.0])


def board_image(size, view, rng):
    """Return one image, a PNG file as bytes (uint8).

    The boards of the plan come first, then the held-out ones. The latter repeat
    positions of the plan, spread over its rings.
    """
    import cv2

    rig, places = rig_of(size), places_of(size.plan)
    again = [k * len(places) // size.kept_out for k in range(size.kept_out)]
    place = [*places, *(places[k] for k in again)][view]
    T = held_at(rig, place, rng)
    image = render_board(rig, T, rng, np.random.default_rng(0))
    return {"png": cv2.imencode(".png", image)[1].ravel()}


# The commands of this page, run as they are typed, and their output.


SET = "fisheye"
CHECK = ("check", SET)
CORNERS = ("corners", SET, "--json", "corners.json")
CALIBRATE = (
    "calibrate", SET, "--model", "auto", "--corners", "corners.json",
    "--out", "camera.npz", "--json", "fit.json",
)  # fmt: skip
EVALUATE = (
    "evaluate", "camera.npz", SET, "--corners", "corners.json",
    "--json", "held_out.json",
)  # fmt: skip
UNDISTORT = ("undistort", "camera.npz", SET, "--out", "straight")
FILES = {"corners": "corners.json", "camera": "camera.npz"}


@contextlib.contextmanager
def desk(size, images, **files):
    """Provide a working directory with the set in it.

    files: result of a trial that keeps the bytes of a file under this name.
    """
    with tempfile.TemporaryDirectory() as room:
        write_images(size, images, Path(room) / SET)
        for name, result in files.items():
            path = Path(room) / FILES[name]
            path.write_bytes(result.arrays(name)[0].tobytes())
        with contextlib.chdir(room):
            yield


def write_images(size, images, folder):
    """Write the images as files, with the set.yaml that a user writes."""
    folder.mkdir()
    rig, views = rig_of(size), []
    for condition in images.conditions:
        index = condition["view"]
        name = f"{index + 1:02d}.png"
        png = images.arrays("png", view=index)[0]
        (folder / name).write_bytes(png.tobytes())
        fits = index < len(places_of(size.plan))
        use = "calibrate" if fits else "evaluate"
        views.append(View(image=name, use=use))
    write_set(
        ImageSet(
            name=SET,
            width=rig.camera.width,
            height=rig.camera.height,
            target=rig.target,
            views=tuple(views),
            folder=folder,
            camera="fisheye converter, 183 degrees",
        )
    )


def typed(arguments):
    """Run one command of raxel; return its output."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        status = main(list(arguments))
    if status:
        raise RuntimeError(f"raxel {' '.join(arguments)}: status {status}")
    return out.getvalue()


def find_corners(size, images):
    """Run `raxel check` and `raxel corners`; return output, corners and counts."""
    with desk(size, images):
        output = {"check": typed(CHECK), "corners": typed(CORNERS)}
        boards = read_boards("corners.json", load_set(SET))
        content = json.loads(Path("corners.json").read_text("utf-8"))
    for entry in content["images"]:
        entry["milliseconds"] = None  # a result holds no times
    return {
        "output": output,
        "boards": len(boards),
        "found": sum(board.detection.found for board in boards),
        "corners": np.frombuffer(json.dumps(content).encode(), np.uint8),
    }


def views_of(size, images, found):
    """Return the views to calibrate with and the held-out ones."""
    with desk(size, images, corners=found):
        image_set = load_set(SET)
        boards = read_boards("corners.json", image_set)
    return tuple(
        board_views(image_set, [b for b in boards if b.view.use == use])
        for use in ("calibrate", "evaluate")
    )


def calibrate(size, images, found):
    """Run `raxel calibrate` and `raxel evaluate`; return camera and residuals."""
    fit_views, held_out = views_of(size, images, found)
    with desk(size, images, corners=found):
        output = {"calibrate": typed(CALIBRATE), "evaluate": typed(EVALUATE)}
        file = Path("camera.npz").read_bytes()
        camera = load_camera("camera.npz")
        fit = json.loads(Path("fit.json").read_text("utf-8"))
    return {
        "output": output,
        "camera": np.frombuffer(file, np.uint8),
        "model": fit["model"],
        "covered_share": fit["camera"]["share_of_image_under_boards"],
        "fitted_px": evaluate_camera(camera, fit_views).rms_px,
        "held_out_px": evaluate_camera(camera, held_out).rms_px,
    }


def look_through(size, images, calibrated, rng):
    """Run `raxel undistort`; return it with a street through the same pinhole."""
    street = rig_of(size).laboratory().render(facade(), T_world_camera(), rng)
    with desk(size, images, camera=calibrated):
        output = {"undistort": typed(UNDISTORT)}
        camera = load_camera("camera.npz")
    sources = source_pixels(camera, perspective_view(camera))
    return {
        "output": output,
        "street": street,
        "ahead": resample(street, sources),
        "seen_share": share_seen(sources, camera),
    }


# Four calibrations from the same corners, and their coverage.


def model_scores(size, fit_views, held_out, rng):
    """Return {model: scores} of cameras from `fit_views`, on held-out views."""
    rig = rig_of(size)
    return {"boards": len(fit_views)} | {
        name: scored(rig, build, fit_views, held_out, rng)
        for name, build in MODELS.items()
    }


def scored(rig, build, fit_views, held_out, rng):
    """Return the scores of one calibration, or the code of its error."""
    camera = rig.camera
    try:
        made = build(fit_views, camera.width, camera.height, rng=rng).camera
    except CalibrationError as error:
        return {"reason": error.code}
    fitted = evaluate_camera(made, fit_views)
    kept = evaluate_camera(made, held_out)
    return {
        "reason": "",
        "fitted_px": fitted.rms_px,
        "held_out_px": kept.rms_px,
        "held_out_deg": kept.mean_deg,
        "corners_with_ray": kept.share_with_ray,
        **against_truth(made, camera),
    }


def against_truth(made, true):
    """Return the share of the lens's pixels with a ray, and the angle to true rays."""
    pixels = scoring_grid(true.width, true.height)
    truly = true.rays(pixels)
    rays = made.rays(pixels[truly.valid])
    found = rays.directions[rays.valid]
    wanted = truly.directions[truly.valid][rays.valid]
    turned = found @ nearest_rotation(wanted.T @ found).T
    angles = np.degrees(angular_residual(turned, wanted, aligned=False))
    return {
        "image_with_ray": float(rays.valid.mean()),
        "ray_deg": float(np.median(angles)),
    }


MODELS = {
    "zhang": lambda views, *size, rng: calibrate_zhang(views, *size),
    "opencv_fisheye": lambda views, *size, rng: calibrate_opencv_fisheye(views, *size),
    "kannala_brandt": lambda views, *size, rng: calibrate_lens(
        views, *size, "kannala-brandt"
    ),
    "generic": calibrate_generic,
}
