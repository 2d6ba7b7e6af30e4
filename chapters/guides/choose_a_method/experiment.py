"""Methods scored on rendered sets, and the content of the records."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from chapters.shared.records import record, set_of
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    board_views,
    calibrate_generic,
    calibrate_opencv_fisheye,
    calibrate_zhang,
)
from raxel.errors import InputError
from raxel.evaluation import score_camera, score_corners, scoring_grid
from raxel.features import detect_boards
from raxel.lab import render_set

SCORED = {
    "quick": ("coolpix-fce8-zoom-2",),
    "full": tuple(f"coolpix-fce8-zoom-{zoom}" for zoom in (1, 2, 3)),
}
VIEWS = {"quick": 3, "full": 5}
DETECTORS = ("raxel", "opencv")
# Of data/records.
DETECTOR_RECORD, STATED_RECORD = "detectors", "stated"
# Quantity -> part of the record of predicted errors, and a filter of its rows.
STATED = {
    "corners, drawn": ("corners", lambda row: row["truth_px"] == 0),
    "corners, photographed": ("corners", lambda row: row["truth_px"] > 0),
    "active-grid places": ("decoding", lambda row: True),
    "active-grid places, hard cases": ("decoding_hard", lambda row: True),
    "focal lengths": ("calibration", lambda row: row["case"].startswith("sound")),
    "focal lengths, bent board": ("calibration", lambda row: "bent" in row["case"]),
}


def score_rig(name, views, rng):
    """Render a set of this rig; score the detectors and the calibrations.

    The cameras are compared on the pixels where the general one has a ray.
    """
    rig = replace(rig_named(name), count=views, evaluate=0)
    seed = int(rng.integers(2**31))
    with tempfile.TemporaryDirectory() as room:
        image_set = render_set(rig, Path(room) / "set", seed)
        boards = {one: detect_boards(image_set, one) for one in DETECTORS}
        scores = {
            one: {"rms_px": score_corners(image_set, found)["rms_px"]}
            for one, found in boards.items()
        }
        found = board_views(image_set, boards[DETECTORS[0]])
        return scores | camera_scores(image_set, found, rng)


def camera_scores(image_set, views, rng):
    """Return the scores of every calibration, or the code of its error.

    Angles: on the pixels where the general camera has a ray. Share with a ray: of all
    pixels that truly have one.
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
            scores[name] = {"reason": fault.code}
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
    """Return correct and wrong boards in one set of real images, from the record."""
    kept = set_of(DETECTOR_RECORD, condition)
    counts = {
        run["detector"]: {what: run[what] for what in ("right", "wrong")}
        for run in kept["scores"]
        if run["size"] == "given"
    }
    return {"images": kept["scores"][0]["images"], **counts}


def stated_errors(condition):
    """Return predicted and actual errors of one quantity, over the recorded cases."""
    part, wanted = STATED[condition["quantity"]]
    rows = next(
        one["rows"] for one in record(STATED_RECORD)["sets"] if one["part"] == part
    )
    rows = [row for row in rows if row.get("ratio") is not None and wanted(row)]
    ratios = [row["ratio"] for row in rows]
    found = {
        "cases": len(rows),
        "errors": sum(row["count"] for row in rows),
        "ratio": {
            "least": min(ratios), "median": np.median(ratios), "most": max(ratios)
        },
        "within3": np.median([row["within3"] for row in rows]),
    }  # fmt: skip
    for name in ("sd_px", "error_px"):
        known = [row[name] for row in rows if row.get(name) is not None]
        if known:
            found[name] = np.median(known)
    return found
