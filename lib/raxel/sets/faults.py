"""Faults of a set that its schema cannot express: files, counts, clicks, codes."""

from pathlib import PureWindowsPath

import numpy as np

from raxel.io.documents import shown
from raxel.sets.model import ActiveGrid, Charuco, Chessboard
from raxel.sets.pattern_faults import pattern_faults

# Of those whose name does not say it.
DICTIONARY_SIZES = {
    "ARUCO_ORIGINAL": 1024,
    "APRILTAG_16h5": 30,
    "APRILTAG_25h9": 35,
    "APRILTAG_36h10": 2320,
    "APRILTAG_36h11": 587,
}


def faults(image_set):
    """Each fault as (path of the field, what was found and what to do)."""
    target = image_set.target
    if isinstance(target, Chessboard) and (target.columns is None) != (
        target.rows is None
    ):
        unknown = "columns" if target.columns is None else "rows"
        fault = "found null beside a known count; give both counts, or null for both"
        yield ("target", unknown), fault
    if isinstance(target, Charuco):
        yield from _marker_faults(target)
    if isinstance(target, ActiveGrid):
        yield from _monitor_chessboard_faults(image_set)
    yield from _repeated_labels(image_set.views)
    yield from _file_faults(image_set)
    yield from _repeated_photographs(image_set)
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
        fault = f"found {target.marker_mm:g}, which does not fit into a square of"
        fault = f"{fault} {target.pitch_mm:g}; give the side of a marker, without rim"
        yield ("target", "marker_mm"), fault
    most = DICTIONARY_SIZES.get(target.dictionary)
    if most is None:
        most = int(target.dictionary.split("_")[1])
    if target.marker_count > most:
        fault = f"found {target.dictionary}, which has {most} markers; the board's"
        fault = f"{fault} {target.marker_count} white squares need as many"
        yield ("target", "dictionary"), f"{fault}; mend it, or columns and rows"


def _monitor_chessboard_faults(image_set):
    target = image_set.target
    board, shown = target.chessboard, [view.chessboard for view in image_set.views]
    if board is None:
        index = next((i for i, name in enumerate(shown) if name), None)
        if index is not None:
            fault = "found, but no target.chessboard; say there what it shows"
            yield ("views", index, "chessboard"), fault
        return
    squares = np.array([board.columns, board.rows]) * board.pitch_px
    low, high = np.array(board.origin_px) - board.pitch_px, board.origin_px + squares
    if np.any(low < 0) or np.any(high > target.monitor_px):
        width, height = target.monitor_px
        fault = f"its squares reach from {low.tolist()} to {high.tolist()}, beyond the"
        fault = f"{fault} monitor of {width} x {height} px; mend origin_px or pitch_px"
        yield ("target", "chessboard"), fault


def _repeated_labels(views):
    first = {}
    for index, view in enumerate(views):
        earlier = first.setdefault(view.label, index)
        if earlier != index:
            key = "image" if view.image else "name"
            fault = f"found {shown(view.label)}, which views[{earlier}] has already"
            yield ("views", index, key), f"{fault}; list each view once"


def _repeated_photographs(image_set):
    """A photograph under two names, which would be fitted and kept out at once.

    The file itself decides, not its name: ./a.jpg, a link, A.JPG where it is the same.
    An active grid shows something else in each of its photographs.
    """
    first = {}
    for path, name in _photographs(image_set.views):
        try:
            found = (image_set.folder / name).stat()
        except (OSError, ValueError):
            continue  # told as missing
        earlier, other = first.setdefault((found.st_dev, found.st_ino), (path, name))
        if earlier == path or (path[2] == "image" and other == name):
            continue  # the first one, or a label that is told as repeated
        where = f"views[{earlier[1]}]"
        if len(earlier) > 3:
            where += f".patterns[{earlier[3]}]"
        fault = f"found {shown(name)}, the same file as {shown(other)} of {where}"
        yield path, f"{fault}; list it once"


def _photographs(views):
    """(path of the field, name of the file) of all photographs."""
    for index, view in enumerate(views):
        for key in ("image", "white", "black", "chessboard"):
            if getattr(view, key):
                yield ("views", index, key), getattr(view, key)
        for number, pattern in enumerate(view.patterns):
            yield ("views", index, "patterns", number, "image"), pattern.image


def _file_faults(image_set):
    for path, name in _photographs(image_set.views):
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
        advice = "add it or mend the name"
        if "\\" in name:
            advice += ", with / between folders"
        yield path, f"no file {shown(name)} in {folder}; {advice}"


def _leaves_folder(name):
    path = PureWindowsPath(name)
    return bool(path.anchor) or ".." in path.parts


def _outside(name):
    return f"found {shown(name)}; name a file inside the set's folder, without .. or /"


def _outer_corner_faults(path, view, size):
    outside = list(_points_outside(path, view.outer_corners, size))
    yield from outside
    if not outside and _turns(np.array(view.outer_corners)).min() <= 0:
        fault = "the four points do not go once around clockwise as seen in the image"
        yield path, f"{fault}; list them clockwise from the first corner"


def _points_outside(path, points, size):
    """A fault for the first point that lies outside the image."""
    corners = np.array(points)
    inside = np.all((corners >= -0.5) & (corners <= np.array(size) - 0.5), axis=1)
    if not inside.all():
        index = int(np.argmin(inside))
        found = list(points[index])
        fault = f"found {found}, outside the image of {size[0]} x {size[1]}"
        yield (*path, index), f"{fault}; give (u, v) in pixels from the top left"


def _contour_faults(path, view, image_set):
    columns, rows = image_set.target.columns, image_set.target.rows
    if view.outer_corners is None:
        yield path, "found, but no outer_corners; give the four clicks as well"
        return
    if columns is None:
        yield path, "found, but target.columns is null; give columns and rows as well"
        return
    counts = {f"side {i}": (rows, columns)[i % 2] for i in range(1, 5)}
    counts |= {f"column {k}": rows for k in range(2, columns)}
    for name, points in view.contours:
        if name not in counts:
            fault = f"the board has columns 2 to {columns - 1} between sides 4 and 2"
            yield (*path, name), f"{fault}; mend the number"
        elif len(points) != counts[name]:
            fault = f"found {len(points)} points; give its {counts[name]} corners"
            yield (*path, name), f"{fault}, both ends included"
        else:
            size = image_set.width, image_set.height
            yield from _points_outside((*path, name), points, size)


def _turns(corners):
    """Sign of the turn at each corner of a polygon; positive = clockwise (v down)."""
    ahead = np.roll(corners, -1, axis=0) - corners
    after = np.roll(ahead, -1, axis=0)
    return ahead[:, 0] * after[:, 1] - ahead[:, 1] * after[:, 0]
