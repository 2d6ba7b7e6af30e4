"""Known lenses, boards in front of them, and fits of each model."""

import numpy as np

from raxel.calibration import BoardView, calibrate_lens, calibrate_zhang
from raxel.cameras import KannalaBrandtCamera, MovingPupilCamera, UnifiedSphereCamera
from raxel.errors import CalibrationError
from raxel.evaluation import evaluate_camera
from raxel.geometry import on_plane, pose, rotation_from_vector, transform

SIZE = (1280, 960)
COLUMNS, ROWS, PITCH_MM = 9, 6, 30.0
BOARD = PITCH_MM * np.stack(
    np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1
).reshape(-1, 2)
MIDDLE = np.append(BOARD.mean(axis=0), 0.0)
DISTANCE_MM = (230.0, 450.0)
TILT = 0.5  # radians, about each axis of a board that faces the camera
FITTED, HELD_OUT = 12, 8  # boards
NOISE_PX = 0.1  # of the corners that are fitted; the others are exact
RINGS = np.linspace(0, 500, 11)  # px from the image centre
TRIALS = {"quick": 1, "full": 8}

FISHEYE = KannalaBrandtCamera(
    [1.0, -0.03, 0.004, -0.001], (290.0, 289.0), (651.0, 470.0), *SIZE
)
# Each with the range of angles from the axis for the boards.
LENSES = {
    "fisheye": (FISHEYE, (0.0, 1.3)),
    "mirror": (
        UnifiedSphereCamera(
            0.96,
            [[420.0, 0.0, 625.0], [0.0, 418.0, 492.0], [0.0, 0.0, 1.0]],
            *SIZE,
            radial=[-0.02, 0.002],
            tangential=(-0.02, 0.006),
            prism=(-0.02, 0.03),
        ),
        (0.7, 1.3),
    ),
    "pupil": (MovingPupilCamera(FISHEYE, [4.0, 1.0]), (0.0, 1.3)),
}
MODELS = ("zhang", "kannala-brandt", "unified", "pupil")

SETTINGS = {
    "size_px": list(SIZE),
    "boards_fitted": FITTED,
    "boards_kept_out": HELD_OUT,
    "corners_a_board": COLUMNS * ROWS,
    "noise_px": NOISE_PX,
    "distance_mm": list(DISTANCE_MM),
    "pupil_shift_mm": LENSES["pupil"][0].pupil_shift.tolist(),
}


def boards(camera, angles, count, rng, noise_px):
    """Views of boards at random poses, all of them whole in the image."""
    views = []
    while len(views) < count:
        pixels, seen = camera.project(transform(_held(angles, rng), on_plane(BOARD)))
        if seen.all() and camera.in_image(pixels).all():
            pixels = pixels + noise_px * rng.normal(size=pixels.shape)
            views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"board {len(views)}"))
    return views


def _held(angles, rng):
    """Pose of a board in front of the camera, off the axis by one of the angles."""
    polar, azimuth = rng.uniform(*angles), rng.uniform(0, 2 * np.pi)
    faced = rotation_from_vector(
        polar * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    )
    turned = rotation_from_vector([*rng.uniform(-TILT, TILT, 2), 0.0])
    R = faced @ turned @ rotation_from_vector([0, 0, rng.uniform(-3, 3)])
    return pose(R, rng.uniform(*DISTANCE_MM) * faced[:, 2] - R @ MIDDLE)


def fitted(model, views):
    """(Camera, PupilTest or None) of one of MODELS."""
    if model == "zhang":
        return calibrate_zhang(views, *SIZE).camera, None
    law = "kannala-brandt" if model == "pupil" else model
    pupil = "by test" if model == "pupil" else "fixed"
    # The boards are drawn flat, and scored as flat.
    found = calibrate_lens(views, *SIZE, law, pupil=pupil, board="flat")
    return found.camera, found.pupil


def lens_trial(condition, rng):
    """Every model on the same boards; errors on exact held-out boards."""
    camera, angles = LENSES[condition["lens"]]
    views = boards(camera, angles, FITTED, rng, NOISE_PX)
    exact = boards(camera, angles, HELD_OUT, rng, 0.0)
    result = {}
    for model in MODELS:
        try:
            found, test = fitted(model, views)
        except CalibrationError as refusal:
            result[model] = {"failed": refusal.code}
            continue
        result[model] = held_out_errors(found, exact)
        if test is not None:
            result[model]["test"] = {
                "moves": float(test.moves),
                "p_value": test.p_value,
                "shift_mm": test.shift if test.moves else 0.0,
                "shift_sd_mm": test.shift_sd,
            }
    return result


def held_out_errors(camera, views):
    """RMS distance (px) over boards, and in rings about the image centre."""
    scored = evaluate_camera(camera, views)
    squares = np.concatenate([np.sum(i.residuals_px**2, axis=1) for i in scored.images])
    pixels = np.concatenate([view.pixels for view in views])
    radius = np.linalg.norm(pixels - (np.array(SIZE) - 1) / 2, axis=1)
    ring, seen = np.digitize(radius, RINGS) - 1, np.isfinite(squares)
    by_ring = [
        np.sqrt(np.mean(squares[seen & (ring == k)]))
        if np.any(seen & (ring == k))
        else np.nan
        for k in range(len(RINGS) - 1)
    ]
    return {
        "rms_px": np.sqrt(np.mean(squares[seen])),
        "share_with_ray": scored.share_with_ray,
        "ring_px": np.array(by_ring),
    }
