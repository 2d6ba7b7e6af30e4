"""`python -m tests.bench.records detectors|calibrations|stated [SET ...]`.

Writes the file of that name in data/records anew; SET are folders of image sets of
chessboards, of which `detectors` needs reference corners. `stated` draws its own.
"""

import platform
import subprocess
import sys
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np

from raxel.calibration import (
    BoardView,
    board_views,
    calibrate_generic,
    calibrate_opencv_fisheye,
    calibrate_zhang,
)
from raxel.errors import InputError
from raxel.evaluation.cross_validation import corner_errors, evaluate_camera, is_right
from raxel.features import DETECTORS, detect_boards
from raxel.io.files import read_json, write_json
from raxel.sets import load_reference, load_set, read_image
from tests.bench.stated import PARTS

RECORDS = Path("data/records")
RUNS = [(name, "given") for name in DETECTORS] + [("raxel", "not given")]
OUTCOMES = "right", "wrong", "unjudged", "refused"
METHODS = {
    "zhang": calibrate_zhang,
    "generic": lambda views, *size: calibrate_generic(
        views, *size, rng=np.random.default_rng(0)
    ),
    "opencv_fisheye": calibrate_opencv_fisheye,
}
SETS_OF_PARTS, DIGITS = 5, 4  # of photographs, each left out once; of numbers


def detectors(folders):
    """Return boards right and wrong by each detector, of every set."""
    return [_detected(load_set(folder)) for folder in folders]


def _detected(image_set):
    reference, board = load_reference(image_set), image_set.target
    counts = {run: Counter() for run in RUNS}
    for view in image_set.views:
        image = read_image(image_set, view)
        for name, size in RUNS:
            known = (board.columns, board.rows) if size == "given" else (None, None)
            found = DETECTORS[name](image, *known)
            counts[name, size][_outcome(found, reference.get(view.image))] += 1
    scores = [
        {"detector": name, "size": size, "images": of.total()}
        | {outcome: of[outcome] for outcome in OUTCOMES}
        for (name, size), of in counts.items()
    ]
    return _about(image_set) | {"scores": scores}


def _outcome(found, reference):
    if not found.found:
        return "refused"
    if reference is None:
        return "unjudged"
    return "right" if is_right(corner_errors(found, reference), reference) else "wrong"


def calibrations(folders):
    """Return errors of each method on images left out, of every set."""
    return [_calibrated(load_set(folder)) for folder in folders]


def _calibrated(image_set):
    views = board_views(image_set, detect_boards(image_set))
    size = image_set.width, image_set.height
    models = {}
    for name, method in METHODS.items():
        errors, reason = [], ""
        for part in range(SETS_OF_PARTS):
            rest = [v for k, v in enumerate(views) if k % SETS_OF_PARTS != part]
            try:
                camera = method(rest, *size).camera
            except InputError as fault:
                reason = fault.code
                continue
            errors += _errors(camera, views[part::SETS_OF_PARTS])
        models[name] = _medians(errors) | {"reason": reason}
    return {"name": image_set.name, "pictures": len(views), "models": models}


def _errors(camera, views: list[BoardView]):
    return [(one.rms_px, one.mean_deg) for one in evaluate_camera(camera, views).images]


def _medians(errors):
    known = np.array(errors).reshape(-1, 2)
    known = known[np.isfinite(known).all(axis=1)]
    px, deg = np.median(known, axis=0) if len(known) else (np.nan, np.nan)
    return {"photographs": len(known), "px": _rounded(px), "deg": _rounded(deg)}


def stated(folders):
    """Return the parts of `tests.bench.stated`, and those that other commits made."""
    kept = {one["part"]: one for one in read_json(RECORDS / "stated.json")["sets"]}
    for name, (measured, what) in PARTS.items():
        rows = [{key: _rounded(x) for key, x in row.items()} for row in measured()]
        kept[name] = {"part": name, "what": what, **_made(), "rows": rows}
    return list(kept.values())


def _about(image_set):
    about = {"name": image_set.name, "camera": image_set.camera}
    about["resolution_px"] = [image_set.width, image_set.height]
    about["board"] = [image_set.target.columns, image_set.target.rows]
    return about | dict(image_set.origin or {})


def _made():
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    today = datetime.now(UTC).strftime("%Y-%m-%d")
    return {"date": today, "raxel": f"commit {commit} of this repository"}


def _rounded(value):
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
    return value


KINDS = {"detectors": detectors, "calibrations": calibrations, "stated": stated}


def main(kind, *folders):
    """Write the record of this kind."""
    path = RECORDS / f"{kind}.json"
    kept = read_json(path)
    kept |= {"command": f"python -m tests.bench.records {kind}"}
    kept |= {"date": _made()["date"], "sets": KINDS[kind](folders)}
    versions = {"python": platform.python_version(), "numpy": np.__version__}
    kept["versions"] = versions | {"raxel": _made()["raxel"], "opencv": cv2.__version__}
    write_json(path, kept)


if __name__ == "__main__":
    main(*sys.argv[1:])
