"""The image set, version 1: a folder of images with a set.yaml that describes them."""

from pathlib import Path

import yaml

from raxel.errors import InputError
from raxel.io.documents import field_name, read_yaml, validate
from raxel.io.files import write_whole
from raxel.sets.faults import faults
from raxel.sets.model import (
    DESCRIPTION,
    ActiveGrid,
    Charuco,
    Chessboard,
    ImageSet,
    MonitorChessboard,
    Motion,
    Pattern,
    View,
)

SCHEMA = Path(__file__).with_name("image_set.schema.json")


def load_set(folder):
    """Read and check the set in `folder`.

    Raises InputError (one line: file, field, found, what to do) for a folder that is
    no set, YAML that cannot be read, unknown, missing or wrong keys, and named files
    that are not there. The images themselves are checked by `read_image`.
    """
    folder = Path(folder)
    description = folder / DESCRIPTION
    if not folder.is_dir():
        what = "a file" if folder.is_file() else "nothing"
        raise InputError(f"{folder}: found {what}; give the folder of an image set")
    if not description.is_file():
        raise InputError(f"{folder}: no {DESCRIPTION} in it; not an image set")
    return _checked(read_yaml(description), folder)


def write_set(image_set):
    """Write `image_set.folder`/set.yaml, whole or not at all.

    The images must be in the folder already. Raises InputError where `load_set` would
    refuse what is written.
    """
    _checked(_plain(image_set), image_set.folder)
    write_whole(image_set.description, set_text(image_set))


def set_text(image_set):
    """What `write_set` writes, unchecked: the text of a set.yaml."""
    return yaml.safe_dump(
        _plain(image_set),
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=100,
    )


def _checked(data, folder):
    where = folder / DESCRIPTION
    validate(data, where, SCHEMA)
    image_set = _from_plain(data, folder)
    for path, fault in faults(image_set):
        raise InputError(f"{where}: {field_name(path)}: {fault}")
    return image_set


def _from_plain(data, folder):
    width, height = map(int, data["resolution"])
    return ImageSet(
        name=data["name"],
        width=width,
        height=height,
        target=_target(data["target"]),
        views=tuple(map(_view, data["views"])),
        folder=folder,
        camera=data.get("camera", ""),
        origin=dict(data.get("origin", {})),
        reference=data.get("reference"),
        truth=data.get("truth"),
    )


def _target(data):
    if data["kind"] in ("chessboard", "charuco"):
        counts = [_integer(data[key]) for key in ("columns", "rows")]
        board = *counts, _float(data.get("pitch_mm"))
        if data["kind"] == "chessboard":
            return Chessboard(*board)
        markers = data["dictionary"], float(data["marker_mm"])
        return Charuco(*board, *markers, data.get("legacy", False))
    size_mm, board = data.get("monitor_mm"), data.get("chessboard")
    return ActiveGrid(
        tuple(map(int, data["monitor_px"])),
        size_mm and tuple(map(float, size_mm)),
        board and _monitor_chessboard(board),
    )


def _monitor_chessboard(data):
    origin = tuple(map(float, data["origin_px"]))
    counts = int(data["columns"]), int(data["rows"])
    return MonitorChessboard(*counts, float(data["pitch_px"]), origin)


def _view(data):
    data = dict(data)
    if "outer_corners" in data:
        data["outer_corners"] = tuple(
            tuple(map(float, point)) for point in data["outer_corners"]
        )
    if "contours" in data:
        data["contours"] = tuple(
            (name, tuple(tuple(map(float, point)) for point in points))
            for name, points in data["contours"].items()
        )
    if "motion" in data:
        data["motion"] = Motion(
            **{key: tuple(map(float, three)) for key, three in data["motion"].items()}
        )
    data["patterns"] = tuple(map(_pattern, data.get("patterns", ())))
    return View(**data)


def _pattern(data):
    whole = {key: int(data[key]) for key in ("bit", "step", "of") if key in data}
    lengths = ("periods", "cell_px", "offset")
    lengths = {key: float(data[key]) for key in lengths if key in data}
    return Pattern(**{**data, **whole, **lengths})


def _integer(value):
    return None if value is None else int(value)


def _float(value):
    return None if value is None else float(value)


def _plain(image_set):
    """The set as set.yaml holds it: dicts, lists, numbers and texts."""
    data = {"raxel_set": 1, "name": image_set.name}
    if image_set.camera:
        data["camera"] = image_set.camera
    data["resolution"] = [int(image_set.width), int(image_set.height)]
    data["target"] = _plain_target(image_set.target)
    data["views"] = [_plain_view(view) for view in image_set.views]
    for key in ("origin", "reference", "truth"):
        if getattr(image_set, key):
            data[key] = getattr(image_set, key)
    return data


def _plain_target(target):
    if isinstance(target, Chessboard):
        counts = {"columns": _integer(target.columns), "rows": _integer(target.rows)}
        board = {**counts, "pitch_mm": _float(target.pitch_mm)}
        if not isinstance(target, Charuco):
            return {"kind": "chessboard", **board}
        markers = {"dictionary": target.dictionary, "marker_mm": target.marker_mm}
        return {"kind": "charuco", **board, **markers, "legacy": bool(target.legacy)}
    size_mm = target.monitor_mm and [float(length) for length in target.monitor_mm]
    size_px = [int(count) for count in target.monitor_px]
    data = {"kind": "active_grid", "monitor_px": size_px, "monitor_mm": size_mm}
    if target.chessboard:
        data["chessboard"] = _plain_monitor_chessboard(target.chessboard)
    return data


def _plain_monitor_chessboard(board):
    return {
        "columns": int(board.columns),
        "rows": int(board.rows),
        "pitch_px": float(board.pitch_px),
        "origin_px": [float(c) for c in board.origin_px],
    }


def _plain_view(view):
    data = {
        key: getattr(view, key)
        for key in ("image", "name", "white", "black", "chessboard")
        if getattr(view, key)
    }
    if view.patterns:
        data["patterns"] = [_plain_pattern(pattern) for pattern in view.patterns]
    if view.outer_corners is not None:
        data["outer_corners"] = [[float(c) for c in p] for p in view.outer_corners]
    if view.contours:
        data["contours"] = {
            name: [[float(c) for c in p] for p in points]
            for name, points in view.contours
        }
    if view.use != "calibrate":
        data["use"] = view.use
    if view.motion is not None:
        data["motion"] = {
            "translation_mm": [float(c) for c in view.motion.translation_mm],
            "rotation_deg": [float(c) for c in view.motion.rotation_deg],
        }
    return data


def _plain_pattern(pattern):
    data = {"image": pattern.image, "axis": pattern.axis, "kind": pattern.kind}
    if pattern.kind == "gray":
        width = {"cell_px": float(pattern.cell_px)} if pattern.cell_px else {}
        return {
            **data,
            "bit": int(pattern.bit),
            "of": int(pattern.of),
            "inverse": bool(pattern.inverse),
            **width,
        }
    data |= {"step": int(pattern.step), "of": int(pattern.of)}
    data["periods"] = float(pattern.periods)
    return data | ({"offset": float(pattern.offset)} if pattern.offset else {})
