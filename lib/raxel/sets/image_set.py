"""The image set, version 1: a folder of images with a set.yaml that describes them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath

import numpy as np
import yaml

from raxel.errors import InputError
from raxel.io.documents import field_name, read_yaml, shown, validate
from raxel.io.files import write_whole
from raxel.sets.folder import image_names
from raxel.sets.image_files import stored_size
from raxel.sets.model import (
    DESCRIPTION,
    ActiveGrid,
    AprilGrid,
    Charuco,
    Chessboard,
    CircleGrid,
    ImageSet,
    MonitorChessboard,
    Motion,
    Pattern,
    View,
)
from raxel.sets.patterns import pattern_faults

# Checks of a set that its schema cannot express: files, counts, clicks, codes.


# Number of images listed of each wrong size.
MAX_NAMES = 10
# Number of markers of dictionaries whose name does not contain it.
DICTIONARY_SIZES = {
    "ARUCO_ORIGINAL": 1024,
    "APRILTAG_16h5": 30,
    "APRILTAG_25h9": 35,
    "APRILTAG_36h10": 2320,
    "APRILTAG_36h11": 587,
}
TAG_COUNTS = {
    name.removeprefix("APRILTAG_"): size for name, size in DICTIONARY_SIZES.items()
}


def faults(image_set: ImageSet) -> Iterator[tuple[tuple, str]]:
    """Yield each fault of a set as (path of the field, problem and what to do).

    Parameters
    ----------
    image_set : ImageSet
        The set.

    Yields
    ------
    tuple of (tuple, str)
        Path of the field, and the message.
    """
    target = image_set.target
    if isinstance(target, Chessboard) and (target.columns is None) != (
        target.rows is None
    ):
        unknown = "columns" if target.columns is None else "rows"
        fault = "null, but the other count is known; give both counts, or null for both"
        yield ("target", unknown), fault
    if isinstance(target, Charuco):
        yield from _marker_faults(target)
    if isinstance(target, AprilGrid):
        yield from _tag_faults(target)
    if isinstance(target, ActiveGrid):
        yield from _monitor_chessboard_faults(image_set)
    yield from _repeated_labels(image_set.views)
    yield from _file_faults(image_set)
    yield from _repeated_images(image_set)
    yield from _size_faults(image_set)
    for index, view in enumerate(image_set.views):
        path = ("views", index)
        if view.outer_corners is not None:
            size = image_set.width, image_set.height
            yield from _outer_corner_faults((*path, "outer_corners"), view, size)
        if view.contours:
            yield from _contour_faults((*path, "contours"), view, image_set)
        if view.patterns:
            yield from pattern_faults((*path, "patterns"), view.patterns, target)


def _marker_faults(target):
    if target.marker_mm >= target.pitch_mm:
        sizes = f"{target.marker_mm:g} mm is not below pitch_mm {target.pitch_mm:g} mm"
        fault = f"{sizes}; give the side of a marker without its white border"
        yield ("target", "marker_mm"), fault
    size = DICTIONARY_SIZES.get(target.dictionary)
    if size is None:
        size = int(target.dictionary.split("_")[1])
    if target.marker_count > size:
        fault = f"{target.dictionary} has {size} markers for {target.marker_count}"
        advice = "correct dictionary, or columns and rows"
        yield ("target", "dictionary"), f"{fault} white squares; {advice}"


def _tag_faults(target):
    if target.tag_mm >= target.pitch_mm:
        sizes = f"{target.tag_mm:g} mm is not below pitch_mm {target.pitch_mm:g} mm"
        fault = f"{sizes}; Kalibr's pitch is tagSize * (1 + tagSpacing)"
        yield ("target", "tag_mm"), fault
    columns, rows = target.tags
    last, size = target.first_id + columns * rows - 1, TAG_COUNTS[target.family]
    if last >= size:
        fault = f"the last tag is {last}, but {target.family} has {size}"
        yield ("target", "first_id"), f"{fault}; correct it, or columns and rows"


def _monitor_chessboard_faults(image_set):
    target = image_set.target
    board, shown = target.chessboard, [view.chessboard for view in image_set.views]
    if board is None:
        index = next((i for i, name in enumerate(shown) if name), None)
        if index is not None:
            fault = "target.chessboard is missing; add columns, rows and pitch_px there"
            yield ("views", index, "chessboard"), fault
        return
    squares = np.array([board.columns, board.rows]) * board.pitch_px
    low, high = np.array(board.origin_px) - board.pitch_px, board.origin_px + squares
    if np.any(low < 0) or np.any(high > target.monitor_px):
        width, height = target.monitor_px
        fault = f"squares from {low.tolist()} to {high.tolist()} px exceed the monitor"
        advice = "correct origin_px or pitch_px"
        yield ("target", "chessboard"), f"{fault} of {width} x {height} px; {advice}"


def _repeated_labels(views):
    first = {}
    for index, view in enumerate(views):
        earlier = first.setdefault(view.label, index)
        if earlier != index:
            key = "image" if view.image else "name"
            fault = f"{shown(view.label)} is the {key} of views[{earlier}] as well"
            yield ("views", index, key), f"{fault}; list each view once"


def _repeated_images(image_set):
    """Yield a fault for each image under two names.

    It could be used for calibration and for evaluation at once. Files are compared, not
    names: ./a.jpg, a link, A.JPG on some file systems. Each image of an active grid
    shows another pattern.
    """
    first = {}
    for path, name in _images(image_set.views):
        try:
            found = (image_set.folder / name).stat()
        except (OSError, ValueError):
            continue  # reported as missing
        earlier, other = first.setdefault((found.st_dev, found.st_ino), (path, name))
        if earlier == path or (path[2] == "image" and other == name):
            continue  # the first one, or a label that is reported as repeated
        where = f"views[{earlier[1]}]"
        if len(earlier) > 3:
            where += f".patterns[{earlier[3]}]"
        fault = f"{shown(name)} is the same file as {shown(other)} of {where}"
        yield path, f"{fault}; list it once"


def _images(views):
    """Yield (path of the field, name of the file) of all images."""
    for index, view in enumerate(views):
        for key in ("image", "white", "black", "chessboard"):
            if getattr(view, key):
                yield ("views", index, key), getattr(view, key)
        for number, pattern in enumerate(view.patterns):
            yield ("views", index, "patterns", number, "image"), pattern.image


def _file_faults(image_set):
    for path, name in _images(image_set.views):
        yield from _missing(path, name, image_set.folder)
    if image_set.reference is not None:
        yield from _missing(("reference",), image_set.reference, image_set.folder)
    if image_set.truth is not None and _leaves_folder(image_set.truth):
        yield ("truth",), _outside(image_set.truth)


def _missing(path, name, folder):
    if _leaves_folder(name):
        yield path, _outside(name)
        return
    try:
        found = (folder / name).is_file()
    except OSError:
        found = False
    if not found:
        advice = "add the file or correct the name"
        if "\\" in name:
            advice += ", with / between folders"
        yield path, f"no file {shown(name)} in {folder}; {advice}"


def _size_faults(image_set):
    """Yield a fault for all images of a wrong size, grouped by size."""
    size, groups = (image_set.width, image_set.height), {}
    for name in dict.fromkeys(name for _, name in _images(image_set.views)):
        groups.setdefault(stored_size(image_set.folder / name), []).append(name)
    groups.pop(None, None)
    right = len(groups.pop(size, ()))
    texts = [f"{right} of {sum(map(len, groups.values())) + right} images"]
    for other, names in sorted(groups.items(), key=lambda group: -len(group[1])):
        rotated = ", rotated" if other == size[::-1] else ""
        more = f" and {len(names) - MAX_NAMES} more" * (len(names) > MAX_NAMES)
        listed = ", ".join(names[:MAX_NAMES])
        verb = "is" if len(names) == 1 else "are"
        texts.append(
            f"{len(names)} {verb} {other[0]} x {other[1]}{rotated} ({listed}{more})"
        )
    if groups:
        fault = f"{size[0]} x {size[1]} px fits {', '.join(texts)}"
        yield ("resolution",), f"{fault}; remove or rotate these, or correct resolution"


def _leaves_folder(name):
    path = PureWindowsPath(name)
    return bool(path.anchor) or ".." in path.parts


def _outside(name):
    return f"{shown(name)} is outside the set's folder; give a path without .. or root"


def _outer_corner_faults(path, view, size):
    outside = list(_points_outside(path, view.outer_corners, size))
    yield from outside
    if not outside and _turns(np.array(view.outer_corners)).min() <= 0:
        fault = "the four points are not in clockwise order in the image"
        yield path, f"{fault}; list them clockwise from the first corner"


def _points_outside(path, points, size):
    """Yield a fault for the first point outside the image."""
    corners = np.array(points)
    inside = np.all((corners >= -0.5) & (corners <= np.array(size) - 0.5), axis=1)
    if not inside.all():
        index = int(np.argmin(inside))
        found = list(points[index])
        fault = f"{found} is outside the image of {size[0]} x {size[1]} px"
        yield (*path, index), f"{fault}; give (u, v) in px from the top left"


def _contour_faults(path, view, image_set):
    columns, rows = image_set.target.columns, image_set.target.rows
    if view.outer_corners is None:
        yield path, "outer_corners are missing; add the four corners"
        return
    if columns is None:
        yield path, "target.columns is null; give columns and rows as well"
        return
    counts = {f"side {i}": (rows, columns)[i % 2] for i in range(1, 5)}
    counts |= {f"column {k}": rows for k in range(2, columns)}
    for name, points in view.contours:
        if name not in counts:
            fault = f"not a column of the board; give 2 to {columns - 1}"
            yield (*path, name), f"{fault}, between sides 4 and 2"
        elif len(points) != counts[name]:
            fault = f"{len(points)} points; give its {counts[name]} corners"
            yield (*path, name), f"{fault}, including both ends"
        else:
            size = image_set.width, image_set.height
            yield from _points_outside((*path, name), points, size)


def _turns(corners):
    """Return the signed area at each corner of a polygon; clockwise is positive."""
    side = np.roll(corners, -1, axis=0) - corners
    after = np.roll(side, -1, axis=0)
    return side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0]


SCHEMA = Path(__file__).with_name("image_set.schema.json")


def load_set(folder: str | Path) -> ImageSet:
    """Read and check the image set in a folder.

    `read_image` checks the images themselves.

    Parameters
    ----------
    folder : str or Path
        Folder with a set.yaml.

    Returns
    -------
    ImageSet
        The set.

    Raises
    ------
    InputError
        If the folder is no set, the YAML cannot be read, keys are unknown, missing or
        wrong, or named files are missing. The message has one line: file, field,
        problem, what to do.
    """
    folder = Path(folder)
    description = folder / DESCRIPTION
    if not folder.is_dir():
        fault = "is a file" if folder.is_file() else "no such folder"
        raise InputError(f"{folder}: {fault}; give the folder of an image set")
    if not description.is_file():
        raise InputError(
            f"{folder}: not an image set (no {DESCRIPTION}); give a folder with one"
        )
    return _checked(read_yaml(description), description)


def write_set(image_set: ImageSet) -> None:
    """Write the set.yaml of a set, at its `description`, whole or not at all.

    The images must be in their folder already.

    Parameters
    ----------
    image_set : ImageSet
        The set.

    Raises
    ------
    InputError
        If `load_set` would reject the written file.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from raxel.sets import Chessboard, ImageSet, View, load_set, write_set
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "a.png").write_bytes(b"image")
    ...     board = Chessboard(columns=9, rows=6, pitch_mm=25.0)
    ...     write_set(ImageSet("demo", 64, 48, board, (View("a.png"),), Path(folder)))
    ...     image_set = load_set(folder)
    >>> image_set.name, image_set.target.columns, image_set.views[0].label
    ('demo', 9, 'a.png')
    """
    _checked(_plain(image_set), image_set.description)
    write_whole(image_set.description, set_text(image_set))


def set_text(image_set: ImageSet) -> str:
    """Return the text of a set.yaml, as `write_set` writes it, unchecked."""
    return yaml.safe_dump(
        _plain(image_set),
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=100,
    )


def _checked(data, where):
    validate(data, where, SCHEMA)
    image_set = _from_plain(data, where)
    for path, fault in faults(image_set):
        raise InputError(f"{where}: {field_name(path)}: {fault}")
    return image_set


def _from_plain(data, where):
    width, height = map(int, data["resolution"])
    folder = where.parent / data.get("folder", "")
    return ImageSet(
        name=data["name"],
        width=width,
        height=height,
        target=_target(data["target"]),
        views=_views(data, where, folder),
        folder=folder,
        camera=data.get("camera", ""),
        origin=dict(data.get("origin", {})),
        reference=data.get("reference"),
        truth=data.get("truth"),
        described_in=where if "folder" in data else None,
    )


def _views(data, where, folder):
    """The views that are listed, and the other images that the pattern matches."""
    views = [*map(_view, data.get("views", ()))]
    if pattern := data.get("images"):
        listed = {view.label for view in views}
        try:
            names = image_names(folder, pattern)
        except InputError as fault:
            raise InputError(f"{where}: images: {fault}") from fault
        views += [View(name) for name in names if name not in listed]
    elif not views:
        raise InputError(
            f"{where}: views: key missing; list the images, or give images: '*.jpg'"
        )
    return tuple(views)


def _target(data):
    if data["kind"] in ("chessboard", "charuco"):
        counts = [_integer(data[key]) for key in ("columns", "rows")]
        board = *counts, _float(data.get("pitch_mm"))
        if data["kind"] == "chessboard":
            return Chessboard(*board)
        markers = data["dictionary"], float(data["marker_mm"])
        return Charuco(*board, *markers, data.get("legacy", False))
    if data["kind"] == "aprilgrid":
        counts = [2 * int(data[key]) for key in ("columns", "rows")]
        lengths = [float(data[key]) for key in ("pitch_mm", "tag_mm")]
        family, first = data.get("family", "36h11"), int(data.get("first_id", 0))
        return AprilGrid(*counts, *lengths, family, first)
    if data["kind"] == "circles":
        counts = [int(data[key]) for key in ("columns", "rows")]
        return CircleGrid(
            *counts, _float(data.get("pitch_mm")), data.get("staggered", False)
        )
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
    """Return the set as in set.yaml: dicts, lists, numbers and texts."""
    data = {"raxel_set": 1, "name": image_set.name}
    if image_set.camera:
        data["camera"] = image_set.camera
    data["resolution"] = [int(image_set.width), int(image_set.height)]
    own = image_set.description.parent
    if image_set.folder.resolve() != own.resolve():
        data["folder"] = os.path.relpath(image_set.folder, own)
    data["target"] = _plain_target(image_set.target)
    data["views"] = [_plain_view(view) for view in image_set.views]
    for key in ("origin", "reference", "truth"):
        if getattr(image_set, key):
            data[key] = getattr(image_set, key)
    return data


def _plain_target(target):
    if isinstance(target, AprilGrid):
        columns, rows = map(int, target.tags)
        lengths = {"pitch_mm": float(target.pitch_mm), "tag_mm": float(target.tag_mm)}
        tags = {"family": target.family, "first_id": int(target.first_id)}
        return {"kind": "aprilgrid", "columns": columns, "rows": rows} | lengths | tags
    if isinstance(target, Chessboard):
        counts = {"columns": _integer(target.columns), "rows": _integer(target.rows)}
        board = {**counts, "pitch_mm": _float(target.pitch_mm)}
        if isinstance(target, CircleGrid):
            return {"kind": "circles", **board, "staggered": bool(target.staggered)}
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
