"""The camera, the board shape and the test of centrality as JSON, and read back."""

from pathlib import Path

import numpy as np

from raxel.calibration.views.correspondence import (
    TERMS,
    BoardShape,
    BoardView,
    displaced,
)
from raxel.errors import InputError
from raxel.evaluation.coverage import board_counts, field_of_view
from raxel.evaluation.diagnoses import known
from raxel.io.documents import shown, validate

SCHEMA = Path(__file__).with_name("board_shape.schema.json")
# How far a board may extend beyond, or end within, the one whose shape is used: some of
# its outermost corners may be visible in no image.
MAX_EXTENSION, MIN_EXTENT = 0.01, 0.5
MAX_SLOPE = 0.5  # of half a side, or in length: more is no board
ADVICE = "give the file of a camera from the same board"


def camera_fields(camera, views):
    """The camera as JSON: its kind and size, its numbers, and what it sees."""
    size = {"width": camera.width, "height": camera.height}
    fields = {"kind": camera.kind, **size, **_formula_fields(camera)}
    if camera.kind == "general":
        fields |= {"units": camera.units, "centre": camera.origins.tolist()}
        fields["share_of_image_with_ray"] = camera.share_with_ray
    angles = field_of_view(camera).items()
    return fields | {
        "field_of_view_deg": {name: known(angle) for name, angle in angles},
        "share_of_image_under_boards": float(np.mean(board_counts(views, **size) > 0)),
    }


def _formula_fields(camera):
    """The parameters of a formula; focal lengths are px per radian near the axis."""
    if camera.kind == "ray spline":
        return _formula_fields(camera.trend)
    if camera.kind == "moving pupil":
        return _formula_fields(camera.lens) | {
            "pupil_shift": camera.pupil_shift.tolist()
        }
    if camera.kind == "kannala-brandt":
        focal, centre = camera.k[0] * camera.pixels_per_unit, camera.principal_point
        terms = {"radial": (camera.k[1:] / camera.k[0]).tolist()}
    elif camera.kind in ("perspective", "unified sphere"):
        xi = getattr(camera, "xi", 0.0)
        focal, centre = np.diag(camera.K)[:2] / (1 + xi), camera.K[:2, 2]
        terms = {"K": camera.K.tolist(), "radial": camera.radial.tolist()}
        if camera.kind == "unified sphere":
            terms["xi"] = xi
    else:
        return {}
    for name in ("tangential", "prism"):
        if np.any(getattr(camera, name, 0)):
            terms[name] = getattr(camera, name).tolist()
    return terms | {"focal_px": focal.tolist(), "principal_point_px": centre.tolist()}


def shape_fields(test, views):
    """A BoardTest, or None, as JSON. Lengths are in the unit of the
    result; `middle` and `size` are of the area that the corners of the views span."""
    if test is None:
        return None
    shape = test.shape
    values = {
        name: {"value": float(value), "sd": float(sd), "used": name in test.used}
        for name, value, sd in zip(TERMS, shape.values, test.sd, strict=True)
    }
    return values | {
        "corners": corners_of(views),
        "middle": shape.middle.tolist(),
        "size": (2 * shape.half).tolist(),
        "p_bends": test.p_bends,
        "p_stretch": test.p_stretch,
        "flat_px": known(test.flat_px),
        "shaped_px": known(test.shaped_px),
    }


def corners_of(views):
    """[columns, rows] of a chessboard, None of a monitor."""
    board = isinstance(views[0], BoardView)
    return [views[0].columns, views[0].rows] if board else None


def central_fields(test):
    """A CentralTest, or None, as JSON; lengths in the unit of the result."""
    return test and {
        "central": test.central,
        "p_value": test.p_value,
        "distance": test.distance_mm,
        "at_least": test.at_least_mm,
        "at_most": test.at_most_mm,
        "noise_over_stated": known(test.noise_ratio),
        "rays": test.rays,
    }


def read_shape(data, path, unit, views):
    """The BoardShape with which a camera was fitted, None for a board as specified.

    data: JSON of `raxel calibrate`, or that part of it which a camera file has; path:
    of the file; unit: of the evaluated set; views: BoardViews or DenseViews of it.
    Raises InputError for other data or another board.
    """
    if not isinstance(data, dict) or "board_shape" not in data:
        raise InputError(
            f"{path}: board_shape: missing; give the file of raxel calibrate --json"
        )
    corners = data.get("board_corners")
    if isinstance(corners, dict) and not corners.get("used"):
        corners = None
    if data["board_shape"] is None and corners is None:
        return None
    board = {key: data.get(key) for key in ("unit", "board_shape")}
    validate(board | {"board_corners": corners}, path, SCHEMA)
    if data["unit"] != unit:
        raise InputError(
            f"{path}: unit: found {shown(data['unit'])}, and the set is in {unit}; "
            + ADVICE
        )
    found, shape = data["board_shape"], None
    if found is not None:
        values = [found[name]["value"] * found[name]["used"] for name in TERMS]
        half = np.array(found["size"]) / 2
        shape = BoardShape(np.array(found["middle"]), half, np.array(values))
        _check_counts(f"{path}: board_shape.corners", found["corners"], views)
        _check_board(path, shape, views)
        shape = shape if shape.values.any() else None
    if corners is None:
        return shape
    size = [corners["columns"], len(corners["offsets"]) // corners["columns"]]
    _check_counts(f"{path}: board_corners", size, views)
    points = views[0].points
    pitch = np.linalg.norm(points[1] - points[0])
    if not np.isclose(corners["pitch"], pitch) or size[0] * size[1] != len(points):
        raise InputError(
            f"{path}: board_corners.pitch: found {corners['pitch']:g} {unit}, and the "
            f"set has {pitch:g} {unit}; {ADVICE}"
        )
    return displaced(shape, points, np.array(corners["offsets"]))


def _check_counts(where, corners, views):
    """Raise InputError for a board with other numbers of corners."""
    own = corners_of(views)
    if corners != own:
        raise InputError(
            f"{where}: found {_counted(corners)}, and the set has {_counted(own)}; "
            + ADVICE
        )


def _check_board(path, shape, views):
    """Raise InputError for a shape of another board, or of an impossible one."""
    points = np.concatenate(
        [view.points[np.isfinite(view.pixels[:, 0])] for view in views]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    ends = shape.middle - shape.half, shape.middle + shape.half
    extension = np.maximum(ends[0] - low, high - ends[1]).max() / shape.half.max()
    small = (high - low < 2 * MIN_EXTENT * shape.half).any()
    if extension > MAX_EXTENSION or small:
        span, area = (
            " to ".join(f"({x:.4g}, {y:.4g})" for x, y in pair)
            for pair in (ends, (low, high))
        )
        raise InputError(
            f"{path}: board_shape: found one from {span}, and the set's corners are in "
            f"{area}; {ADVICE}"
        )
    steepest = np.abs(shape.values / [*[shape.half.min()] * 3, 1.0]).max()
    if steepest > MAX_SLOPE:
        raise InputError(
            f"{path}: board_shape: found bends or a stretch of {steepest:.2g} of the "
            f"board (at most {MAX_SLOPE:g}); give the file as it was written"
        )


def _counted(corners):
    return f"{corners[0]} x {corners[1]} corners" if corners else "a monitor"
