"""The board's shape as it was found with a camera, in words and as JSON."""

from pathlib import Path

import numpy as np

from raxel.calibration.parametric.lens_formula import MIN_N_SHAPE_IMAGES, STRETCH
from raxel.calibration.views.correspondence import BENDS, TERMS, BoardShape, BoardView
from raxel.cli.scores import known
from raxel.errors import InputError
from raxel.io.documents import shown, validate
from raxel.io.files import read_json

PER_CENT = 100.0
SCHEMA = Path(__file__).with_name("board_shape.schema.json")
# How far a board may reach beyond, or end within, the one whose shape is taken: of its
# outermost corners, some may have been seen in no photograph.
BEYOND, WITHIN = 0.01, 0.5
STEEPEST = 0.5  # of half a side, or in length: beyond, it is no board


def shape_fields(test, views):
    """A BoardTest as JSON; None where there is none. Lengths are in the unit of the
    result; `middle` and `size` are of what the corners of the views span; `corners` is
    [columns, rows] of a chessboard, None of a monitor."""
    if test is None:
        return None
    shape = test.shape
    values = {
        name: {"value": float(value), "sd": float(sd), "used": name in test.used}
        for name, value, sd in zip(TERMS, shape.values, test.sd, strict=True)
    }
    return values | {
        "corners": _corners_of(views),
        "middle": shape.middle.tolist(),
        "size": (2 * shape.half).tolist(),
        "p_bends": test.p_bends,
        "p_stretch": test.p_stretch,
        "flat_px": known(test.flat_px),
        "shaped_px": known(test.shaped_px),
    }


def read_shape(path, unit, views):
    """The BoardShape with which a camera was fitted, None for a board as stated.

    path: of what `raxel calibrate --json` wrote; unit: of the set that is looked at;
    views: BoardViews or DenseViews of it. Raises InputError for another file or board.
    """
    data = read_json(path)
    if not isinstance(data, dict) or "board_shape" not in data:
        raise InputError(
            f"{path}: board_shape: missing; give the file that raxel calibrate --json "
            "wrote"
        )
    if data["board_shape"] is None:
        return None
    kept = {name: data.get(name) for name in ("unit", "board_shape")}
    validate(kept, path, SCHEMA)
    if kept["unit"] != unit:
        raise InputError(
            f"{path}: unit: found {shown(kept['unit'])}, and the set is in {unit}; "
            "give the file of a camera from the same board"
        )
    found = kept["board_shape"]
    shape = BoardShape(
        np.array(found["middle"]),
        np.array(found["size"]) / 2,
        np.array([found[name]["value"] * found[name]["used"] for name in TERMS]),
    )
    _check_board(path, shape, found["corners"], views)
    return shape if shape.values.any() else None


def _corners_of(views):
    board = isinstance(views[0], BoardView)
    return [views[0].columns, views[0].rows] if board else None


def _check_board(path, shape, corners, views):
    """Raise InputError for a shape of another board, or of none that there can be."""
    own = _corners_of(views)
    if corners != own:
        raise InputError(
            f"{path}: board_shape.corners: found {_of(corners)}, and the set has "
            f"{_of(own)}; give the file of a camera from the same board"
        )
    points = np.concatenate(
        [view.points[np.isfinite(view.pixels[:, 0])] for view in views]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    ends = shape.middle - shape.half, shape.middle + shape.half
    beyond = np.maximum(ends[0] - low, high - ends[1]).max() / shape.half.max()
    if beyond > BEYOND or (high - low < 2 * WITHIN * shape.half).any():
        raise InputError(
            f"{path}: board_shape: found one from {_place(ends[0])} to "
            f"{_place(ends[1])}, and the set's corners lie from {_place(low)} to "
            f"{_place(high)}; give the file of a camera from the same board"
        )
    steepest = np.abs(shape.values / [*[shape.half.min()] * 3, 1.0]).max()
    if steepest > STEEPEST:
        raise InputError(
            f"{path}: board_shape: found bends or a stretch of {steepest:.2g} of the "
            f"board; {STEEPEST:g} is the most; give the file as it was written"
        )


def _of(corners):
    return f"{corners[0]} x {corners[1]} corners" if corners else "a monitor"


def _place(point):
    return f"({point[0]:.4g}, {point[1]:.4g})"


def shape_line(test, unit, target):
    """How flat the board is, for people."""
    if test is None:
        return (
            f"shape of the {target}: taken as stated; to ask takes "
            f"{MIN_N_SHAPE_IMAGES} {target}s at other places and a formula, or smooth "
            "rays on one"
        )
    wide, high = 2 * test.shape.half
    (bend_x, bend_y, twist), stretch = test.shape.values[:3], test.shape.values[3]
    sd = test.sd
    return (
        f"shape of the {target}: over its {wide:.4g} x {high:.4g} {unit} the ends of x "
        f"lie {_with_sd(bend_x, sd[0], unit)} behind the middle, those of y "
        f"{_with_sd(bend_y, sd[1], unit)}, twisted by {_with_sd(twist, sd[2], unit)}: "
        f"{_taken(BENDS, test, 'as flat')}; x longer against y by "
        f"{_with_sd(PER_CENT * stretch, PER_CENT * sd[3], '%')}: "
        f"{_taken(STRETCH, test, 'as stated')}"
    )


def not_asked(test, boards, target):
    """What to add where a camera does not fit and nobody asked for the board's shape:
    "" where there were boards enough."""
    if test is not None or boards >= MIN_N_SHAPE_IMAGES:
        return ""
    return (
        f"; a {target} that is bent does so, too: its shape was not asked for, which "
        f"takes {MIN_N_SHAPE_IMAGES} {target}s and a formula"
    )


def shape_warnings(test, unit, target):
    """What to say of a board that is not as it is said to be."""
    if test is None or not test.used:
        return []
    told = []
    if set(BENDS) <= set(test.used):
        most = np.abs(test.shape.values[:3]).max()
        told.append(f"it bends by up to {most:.2g} {unit}")
    if set(STRETCH) <= set(test.used):
        longer = PER_CENT * test.shape.values[3]
        told.append(f"its x is longer against y by {longer:.2g} %")
    return [
        f"the {target} is not as stated: {' and '.join(told)}; the camera was fitted "
        f"with that ({test.flat_px:.3g} px RMS on {target}s kept out without it, "
        f"{test.shaped_px:.3g} px with it); measure the {target}, or take a stiffer "
        "one; raxel evaluate takes the shape with --board"
    ]


def _with_sd(value, sd, unit):
    digits = max(0, 1 - int(np.floor(np.log10(max(sd, 1e-9)))))
    return f"{value:.{digits}f} +- {sd:.{digits}f} {unit}"


def _taken(names, test, stated):
    return "used" if set(names) <= set(test.used) else f"taken {stated}"
