"""The set of a command, from set.yaml or a plain folder, and the folder of results."""

import contextlib
import os
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from cv2 import aruco

from raxel.cli.outputs import check_written
from raxel.cli.terminal import Say
from raxel.errors import InputError
from raxel.features.boards import Board, SizeVote, read_boards, write_boards
from raxel.features.corner_files import STORAGE_ENDINGS, corner_set
from raxel.io.files import check_can_be_written, read_json
from raxel.report import new_report
from raxel.sets import (
    AprilGrid,
    Charuco,
    Chessboard,
    CircleGrid,
    ImageSet,
    folder_set,
    load_set,
    read_kalibr_target,
    write_set,
)
from raxel.sets.folder import UNKNOWN_BOARD, set_name
from raxel.sets.frames import save_frames
from raxel.sets.model import DESCRIPTION

KINDS = "charuco", "charuco-legacy", "aprilgrid", "circles", "staggered"
BOARD = re.compile(rf"(?:({'|'.join(KINDS)}):)?(\d{{1,4}})x(\d{{1,4}})(?::(\w+))?")
BOARD_EXAMPLES = (
    "charuco:9x6:4X4_50, aprilgrid:6x6 (tags), circles:9x7, staggered:4x11 (circles)"
)
MARKERS = {Charuco: "marker_mm", AprilGrid: "tag_mm"}
LENGTH = re.compile(r"([0-9.]+(?:e-?\d+)?) ?(mm|cm|m|in)?")
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
CAMERA, RESULT, CORNERS, REPORT = "camera.npz", "camera.json", "corners.json", "report"
FRAMES, EVERY = "images", 10
FOLDER_OPTIONS = "board", "pitch", "marker", "images"


def board(text: str) -> Chessboard:
    """Return the board of an option such as `9x6` or `charuco:9x6:4X4_50`, of which
    the lengths may be unknown, or of a YAML file of Kalibr."""
    if text.endswith(STORAGE_ENDINGS):
        return read_kalibr_target(text)
    found = BOARD.fullmatch(text)
    if not found:
        raise ValueError(f"expected interior corners as 9x6, or {BOARD_EXAMPLES}")
    kind, size, dictionary = found[1], (int(found[2]), int(found[3])), found[4]
    has_markers = bool(kind) and kind.startswith("charuco")
    if has_markers != bool(dictionary):
        raise ValueError("expected a dictionary of markers, as in charuco:9x6:4X4_50")
    if has_markers:
        name = dictionary.removeprefix("DICT_")
        if not hasattr(aruco, f"DICT_{name}"):
            raise ValueError(f"{name} is no dictionary of OpenCV, such as 4X4_50")
        return Charuco(*size, dictionary=name, legacy=kind.endswith("legacy"))
    if kind == "aprilgrid":
        return AprilGrid(2 * size[0], 2 * size[1])
    if kind:
        return CircleGrid(*size, staggered=kind == "staggered")
    return Chessboard(*size)


def length_mm(text: str) -> float:
    """Return the length in mm of an option such as `25`, `25mm`, `2.5cm` or `1in`."""
    found = LENGTH.fullmatch(text)
    if not found or not 0 < (length := float(found[1]) * MM[found[2] or "mm"]) <= 1e6:
        raise ValueError("expected a length such as 25mm, 2.5cm or 1in")
    return length


def opened_set(options: SimpleNamespace) -> ImageSet:
    """Return the set of a command: of its set.yaml, or the images of a plain folder."""
    if Path(options.set).suffix.lower() in STORAGE_ENDINGS:
        options.corners = options.set
        return corner_set(options.set)
    given = [name for name in FOLDER_OPTIONS if getattr(options, name, None)]
    described = (Path(options.set) / DESCRIPTION).exists()
    if described or not Path(options.set).is_dir():
        if described and given:
            raise InputError(
                f"--{given[0]}: {options.set} has a {DESCRIPTION}; correct it there, "
                "and leave the option out"
            )
        return load_set(options.set)
    for stream in (sys.stdout, sys.stderr):
        stream.names_options = True  # type: ignore[union-attr]
    pattern = getattr(options, "images", None)
    found = folder_set(options.set, _target(options), pattern)
    video = getattr(options, "video", None)
    return replace(found, name=set_name(Path(video).stem)) if video else found


def _target(options):
    """The target of --board, --pitch and --marker."""
    target = getattr(options, "board", None) or UNKNOWN_BOARD
    lengths = {"pitch_mm": getattr(options, "pitch", None) or target.pitch_mm}
    marker = getattr(options, "marker", None)
    if field := MARKERS.get(type(target)):
        lengths[field] = marker or getattr(target, field)
        if not all(lengths.values()):
            raise InputError(
                "--pitch, --marker: missing; give the distance of neighbouring squares "
                "(tags) and the side of a marker (tag)"
            )
    elif marker:
        raise InputError("--marker: not for this board; give it for charuco, aprilgrid")
    return replace(target, **lengths)


def new(options: SimpleNamespace, say: Say) -> None:
    """Write the set.yaml of a plain folder of images, to be edited."""
    path = Path(options.set) / DESCRIPTION
    if path.exists():
        raise InputError(f"{path}: exists; edit it, or remove it first")
    image_set = opened_set(options)
    write_set(replace(image_set, described_in=None))
    for name, reason in image_set.unused:
        print(f"{name}: not used: {reason}")
    size = f"{image_set.width} x {image_set.height} px"
    print(f"{path}: {len(image_set.views)} images of {size}")


@contextlib.contextmanager
def result_folder(options: SimpleNamespace, say: Say) -> Iterator[None]:
    """Set --out, --json and --report to files of the folder that --out names.

    `options.folder` is that folder, None where --out names a camera file. Frames of a
    --video are saved there and become the set. A new folder that stays empty is
    removed.
    """
    if options.every and not options.video:
        raise InputError(f"--every: found {options.every} without --video; remove it")
    if not options.set and not options.video:
        raise InputError("SET: missing; give a folder of images, or --video FILE")
    if options.set and options.video:
        raise InputError(f"--video: found with {options.set}; give one of the two")
    if options.out and Path(options.out).suffix.lower() == ".npz":
        if options.video:
            raise InputError(f"--out: found {options.out} with --video; give a folder")
        yield
        return
    source = Path(options.set or options.video).resolve()
    if not source.exists():
        raise InputError(f"{options.set or options.video}: not found; correct the name")
    name = source.name if source.is_dir() else source.stem
    default = source.with_name(f"{name}-calibration")
    folder = Path(options.out) if options.out else Path(os.path.relpath(default))
    options.folder, options.out = folder, str(folder / CAMERA)
    options.json = options.json or str(folder / RESULT)
    if source.is_file() and not options.video:  # corners without images
        options.report = None
    else:
        options.report = options.report or str(folder / REPORT)
    if folder.exists() and not folder.is_dir():
        raise InputError(
            f"{folder}: is a file; give a folder, or a camera file with ending .npz"
        )
    if not options.force and (folder / CAMERA).exists():
        raise InputError(
            f"{folder / CAMERA}: exists; give --force to replace the results in "
            f"{folder}, or --out for another folder"
        )
    if not folder.is_dir():
        check_can_be_written(folder)
        folder.mkdir()
    try:
        if options.video:
            options.set = str(folder / FRAMES)
            if options.force or not (folder / FRAMES).is_dir():
                with new_report(folder / FRAMES) as frames:
                    save_frames(options.video, frames, options.every or EVERY, say)
        yield
    finally:
        with contextlib.suppress(OSError):  # not empty, or never made
            folder.rmdir()


def check_result_folder(options: SimpleNamespace, image_set: ImageSet) -> None:
    """Raise InputError unless the files of a result folder can be written."""
    if options.folder:
        files = [options.folder / CORNERS]
        if options.folder.resolve() != Path(options.set).resolve():
            files.append(options.folder / DESCRIPTION)
        check_written(files, [image_set])


def kept_corners(
    options: SimpleNamespace, image_set: ImageSet, views: Sequence, detector: str
) -> tuple[dict[str, Board], bool]:
    """Return the boards by image that an earlier run found in the same images.

    Second, whether these are all, of one size. The file is used if it is newer than all
    images, of the same detector, and has a board of the target.
    """
    path = options.folder and options.folder / CORNERS
    if not path or not path.is_file():
        return {}, False
    with contextlib.suppress(InputError, OSError):
        times = [_time(image_set.folder / view.image) for view in views]
        boards = read_boards(path, image_set, views)
        data = read_json(path)
        searched = {entry["file"] for entry in data["images"]}
        found = {b.view.label: b for b in boards if b.view.label in searched}
        same = data["detector"] == detector and _any_found(boards)
        if same and max(times) < _time(path):
            sized = getattr(image_set.target, "columns", None) or "size" in data
            return found, bool(sized) and len(found) == len(views)
    return {}, False


def _any_found(boards):
    return any(board.detection.found for board in boards)


def _time(path):
    return path.stat().st_mtime


def write_corners(
    options: SimpleNamespace,
    image_set: ImageSet,
    detector: str,
    boards: list[Board],
    vote: SizeVote | None,
) -> None:
    """Write the corners into the result folder, for the next run, if there are any."""
    if options.folder and _any_found(boards):
        write_boards(options.folder / CORNERS, image_set, detector, boards, vote)


def write_used_set(
    options: SimpleNamespace, image_set: ImageSet, size: tuple[int, int] | None
) -> None:
    """Write the set.yaml that was used, with the size of the board that was found."""
    if not options.folder or options.corners == options.set:
        return
    target = image_set.target
    if isinstance(target, Chessboard) and target.columns is None and size:
        target = replace(target, columns=size[0], rows=size[1])
        image_set = replace(image_set, target=target)
    path = options.folder / DESCRIPTION
    write_set(replace(image_set, described_in=path, unused=()))
