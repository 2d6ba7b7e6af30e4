"""6.3.1: further stages of CELECT against the published ones, near where it fails."""

from dataclasses import replace

from chapters.ch03_planar_grids.ext_corner_detection.trials.bent_boards import (
    CORNERS,
    SLOPES,
    SQUARE_PX,
    WAVELENGTHS,
    bent_at_random,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.bent_boards import (
    SIZE_PX as BENT_PX,
)
from chapters.shared.synthetic_board import SIZE_PX, SyntheticBoard, clicks
from raxel.features.celect import CelectSettings, celect
from raxel.features.celect.clustering import clustered
from raxel.features.celect.curvature import curved_side
from raxel.features.celect.symmetric import symmetric_corners

PUBLISHED = "published"
_STAGES = {
    "symmetry": {"detect_corners": symmetric_corners},
    "clusters": {"merge_corners": clustered},
    "curvature": {"column_length": curved_side},
}
METHODS = {PUBLISHED: CelectSettings()} | {
    name: replace(CelectSettings(), **stage) for name, stage in _STAGES.items()
}
METHODS["all three"] = replace(
    CelectSettings(),
    **{field: f for stage in _STAGES.values() for field, f in stage.items()},
)
OTHERS = tuple(name for name in METHODS if name != PUBLISHED)

DEFAULT = {"square_px": 100.0, "fov_deg": 134.0, "yaw_deg": 0.0}
PICTURES = {
    "noise SD 40": {"noise_sd": 40.0},
    "blur SD 5 px": {"blur_px": 5.0},
    "squares of 50 px": {"square_px": 50.0},
    "FOV 146°": {"fov_deg": 146.0},
    "FOV 152°": {"fov_deg": 152.0},
    "yaw 40°": {"yaw_deg": 40.0},
    "bent at random": {"noise_sd": 5.0},
}
TRIALS = {"quick": 1, "full": 40}
SETTINGS = {
    "image_px": SIZE_PX,
    "defaults": DEFAULT | {"blur_px": 1.0, "noise_sd": 0.0},
    "clicks": {"sd_px": 2.0, "cap_px": 4.0},
    "lost_px": 8.0,
    "bent_boards": {
        "image_px": BENT_PX,
        "square_px": SQUARE_PX,
        "corners": [CORNERS, CORNERS],
        "slopes": SLOPES,
        "wavelengths_in_squares": WAVELENGTHS,
    },
}


def conditions():
    """One condition for every kind of picture."""
    return [{"picture": name} for name in PICTURES]


def picture_of(name, rng):
    """(board, image) of a kind of picture."""
    changed = dict(PICTURES[name])
    blur, noise = changed.pop("blur_px", 1.0), changed.pop("noise_sd", 0.0)
    if name == "bent at random":
        board = bent_at_random(rng)
    else:
        board = SyntheticBoard(**(DEFAULT | changed))
    return board, board.image(blur, noise, rng)


def split_trial(condition, rng):
    """The first side of one picture: the candidates on it, by either detector."""
    board, image = picture_of(condition["picture"], rng)
    outer = clicks(board.outer_corners, rng)
    values = {"picture": image, "corners": board.corners}
    for name in (PUBLISHED, "symmetry"):
        settings = METHODS[name]
        result = celect(image, outer, board.columns, board.rows, settings=settings)
        side = result.contours[0]
        values[name] = {"inliers": side.inliers, "merged": side.merged}
    return values
