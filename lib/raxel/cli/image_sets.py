"""Image sets and their chessboards: `raxel check` and `raxel corners`."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import cast

from raxel.cli.findings import (
    of_cut_boards,
    of_pitch,
    of_pixels,
    of_unused,
    reported,
    unused_text,
)
from raxel.cli.outputs import check_outputs, check_writable
from raxel.cli.sets import kept_corners, opened_set, write_corners
from raxel.cli.terminal import Say, on_one_line
from raxel.errors import InputError
from raxel.features.boards import (
    CLICK_DETECTORS,
    DEFAULT_DETECTOR,
    TARGET_DETECTORS,
    Board,
    SizeVote,
    agree_on_size,
    check_chessboard,
    detect_boards,
    marker_warning,
    read_boards,
    write_boards,
)
from raxel.sets import (
    ActiveGrid,
    AprilGrid,
    Charuco,
    Chessboard,
    CircleGrid,
    ImageSet,
    MirrorSet,
    Pattern,
    View,
    is_mirror_set,
    load_mirror_set,
    load_reference,
    read_image,
)
from raxel.sets.image_files import has_orientation
from raxel.sets.model import words_of
from raxel.sets.patterns import cell_width

SIZE_DETECTORS = ("opencv", "celect")  # which require the size of the board
# Where the reasons of images name another target.
ADVICE = "correct the target as stated for the images"
N_SEARCHED = 4  # images in which `check` searches for the board


def check(options: SimpleNamespace, say: Say) -> None:
    """Read all files of an image set or mirror set and print what they contain.

    Of a chessboard, a few images spread over the set are searched.
    """
    if not is_mirror_set(options.set):
        _check_images(opened_set(options), say)
        return
    mirror_set = load_mirror_set(options.set)
    for field, image_set in mirror_set.image_sets.items():
        print(f"-- {field}")
        _check_images(image_set, say)
    print("-- mirror")
    _describe_mirror(mirror_set)


def _describe_mirror(mirror_set: MirrorSet) -> None:
    clamp, viewer = mirror_set.clamp, mirror_set.viewer
    hidden = f", mirror hidden up to {clamp.hidden_mm:g} mm from it"
    picked = f"{len(clamp.points)} points, SD {clamp.sd_px:g} px"
    deflections = [step.deflection_mm for step in mirror_set.steps]
    listed = ", ".join(
        "not stated" if mm is None else f"{mm:g} mm" for mm in deflections
    )
    n_boards = sum(len(step.evaluate) for step in mirror_set.steps)
    _print_fields(
        ("viewer", "" if isinstance(viewer, ImageSet) else on_one_line(viewer.name)),
        ("platter", f"{mirror_set.thickness_mm:g} mm in front of its board"),
        ("clamp", picked + hidden * (clamp.hidden_mm > 0)),
        (
            "stages",
            f"{len(deflections)} deflections ({listed}), {n_boards} "
            f"board{'s' * (n_boards != 1)} to evaluate",
        ),
    )


def _check_images(image_set: ImageSet, say: Say) -> None:
    reference = load_reference(image_set)
    files = list(dict.fromkeys(name for v in image_set.views for name in v.files))
    depths: Counter[int] = Counter()
    n_oriented = 0
    for number, name in enumerate(files, 1):
        depths[read_image(image_set, name).dtype.itemsize * 8] += 1
        n_oriented += has_orientation(image_set.folder / name)
        say(f"{number}/{len(files)} {name}")
    bits = ", ".join(f"{count} of {depth} bit" for depth, count in depths.items())
    uses = Counter(view.use for view in image_set.views)
    boards = _sampled_boards(image_set)
    found = sum(board.detection.found for board in boards)
    _print_fields(
        ("set", image_set.name),
        ("camera", on_one_line(image_set.camera) or "not described"),
        ("images", f"{bits}, {image_set.width} x {image_set.height} px"),
        ("target", _target(image_set.target)),
        ("views", ", ".join(f"{n} to {use}" for use, n in uses.items())),
        *(("patterns", line) for line in _pattern_lines(image_set)),
        ("boards", f"found in {found} of {len(boards)} searched images" * bool(boards)),
        ("reference", f"corners of {len(reference)} images" if reference else ""),
        ("truth", image_set.truth),
        *(("not used", f"{name}: {reason}") for name, reason in image_set.unused),
    )
    reported(of_pitch(image_set.target) + of_cut_boards(boards, image_set))
    if n_oriented:
        print(
            f"warning: {n_oriented} of {len(files)} images: EXIF orientation ignored, "
            "pixels are used in sensor order"
        )


def _sampled_boards(image_set: ImageSet) -> list[Board]:
    if not isinstance(image_set.target, Chessboard):
        return []
    step = math.ceil(len(image_set.views) / N_SEARCHED)
    return detect_boards(image_set, DEFAULT_DETECTOR, image_set.views[::step])


def _print_fields(*fields: tuple[str, str | None]) -> None:
    print("\n".join(f"{title:10} {text}" for title, text in fields if text))


def _target(target: Chessboard | ActiveGrid) -> str:
    if isinstance(target, ActiveGrid):
        grid = (
            f"active grid on a monitor of {' x '.join(map(str, target.monitor_px))} px"
        )
        if target.monitor_mm is None:
            return f"{grid}, size in mm unknown (unit of length: its pixel pitch)"
        width, height = target.monitor_mm
        return "; ".join([f"{grid}, {width:g} x {height:g} mm", *of_pixels(target)])
    size = f"{target.columns} x {target.rows} interior corners"
    if target.columns is None:
        size = "unknown number of corners"
    pitch = f"pitch {target.pitch_mm} mm"
    if target.pitch_mm is None:
        pitch = "pitch unknown (unit of length: the pitch)"
    if isinstance(target, AprilGrid):
        size = " x ".join(map(str, target.tags))
        return (
            f"AprilTag grid, {size} tags of {target.family} from {target.first_id}, "
            f"{pitch}, tags {target.tag_mm:g} mm"
        )
    if isinstance(target, CircleGrid):
        kind = "staggered " * target.staggered + "grid of circles"
        return f"{kind}, {target.columns} x {target.rows} circles, {pitch}"
    if isinstance(target, Charuco):
        return (
            f"ChArUco board, {size}, {pitch}, markers {target.dictionary}, "
            f"{target.marker_mm:g} mm"
        )
    return f"chessboard, {size}, {pitch}"


def _pattern_lines(image_set: ImageSet) -> Iterator[str]:
    """Yield a line for all views with the same patterns, in the order of the set."""
    views: dict[str, list[str]] = {}
    if isinstance(image_set.target, ActiveGrid):
        for view in image_set.views:
            described = _patterns(view, image_set.target.monitor_px)
            views.setdefault(described, []).append(on_one_line(view.name))
    for described, names in views.items():
        more = f" and {len(names) - 1} more" * (len(names) > 1)
        yield f"{names[0]}{more}: {described}"


def _patterns(view: View, monitor_px: tuple[int, int]) -> str:
    codes: dict[tuple, list[Pattern]] = {}
    for one in view.patterns:
        code = one.axis, one.kind, one.of, one.periods, one.cell_px, one.offset
        codes.setdefault(code, []).append(one)
    levels = [name for name in ("white", "black") if getattr(view, name)]
    return ", ".join([*(_code(p, monitor_px) for p in codes.values()), *levels])


def _code(patterns: Sequence[Pattern], monitor_px: tuple[int, int]) -> str:
    """Describe the patterns of one code along one axis."""
    first = patterns[0]
    size = monitor_px["xy".index(first.axis)]
    if first.periods is None:
        inverses = sum(pattern.inverse for pattern in patterns)
        width = cell_width(first, monitor_px)
        count = min(math.ceil(size / width - 1e-9), 2**first.of)
        return (
            f"{first.axis} gray {len({p.bit for p in patterns})} of {first.of} bits"
            f"{f' and {inverses} inverses' if inverses else ''} "
            f"({count} cells of {width:g} px)"
        )
    offset = f", offset {first.offset:g}" if first.offset else ""
    return (
        f"{first.axis} phase {len({p.step for p in patterns})} of {first.of} steps "
        f"({first.periods:.4g} periods of {size / first.periods:.4g} px{offset})"
    )


def corners(options: SimpleNamespace, say: Say) -> None:
    """Detect the board in every view of the set.

    Raises InputError if there is no board in any view. The corners of rejected boards
    are then written too, but an existing file is kept.
    """
    check_writable(options.json)
    image_set = opened_set(options)
    check_outputs(options, image_set)
    boards, vote = detected(image_set, options, image_set.views, say)
    found = sum(board.detection.found for board in boards)
    kept = options.json and not found and Path(options.json).exists()
    if options.json and not kept:
        write_boards(
            options.json, image_set, _detector_name(image_set, options), boards, vote
        )
    words = words_of(image_set.target)
    print(f"{image_set.name}: board found in {found} of {len(boards)} images")
    if vote:
        print(f"{image_set.name}: {vote.line()}")
    for view, detection, _ in boards:
        if not detection.found:
            print(f"  {view.label}: {detection.reason}")
        elif detection.missing:
            print(
                f"  {view.label}: {detection.missing} of {len(detection.corners)} "
                f"{words.point}s are missing"
            )
    reported(
        of_unused(image_set)
        + of_pitch(image_set.target)
        + of_cut_boards(boards, image_set)
    )
    if not found:
        named = any(detection.other_target for _, detection, _ in boards)
        raise InputError(
            f"{image_set.description}: views: no usable board in any image"
            f"{f' ({options.json} is kept)' if kept else ''}{unused_text(image_set)}; "
            f"{ADVICE if named else words.check}"
        )


def boards_for(
    image_set: ImageSet, views: Sequence[View], options: SimpleNamespace, say: Say
) -> tuple[list[Board], SizeVote | None]:
    """Return the boards of the views, from --corners or detected, as `detected`.

    In a result folder, those of an earlier run are used again, and those that an
    interrupted run found are kept.
    """
    if options.corners:
        return read_boards(options.corners, image_set, views), None
    detector = _detector_name(image_set, options)
    found, complete = kept_corners(options, image_set, views, detector)
    if found:
        say(f"{len(found)} images: corners of {options.folder} are used again")
    if complete:
        return [found[view.label] for view in views], None
    try:
        boards, vote = detected(image_set, options, views, say, found)
    except KeyboardInterrupt:
        write_corners(options, image_set, detector, [*found.values()], None)
        raise
    write_corners(options, image_set, detector, boards, vote)
    return boards, vote


def detected(
    image_set: ImageSet,
    options: SimpleNamespace,
    views: Sequence[View],
    say: Say,
    found: dict[str, Board] | None = None,
) -> tuple[list[Board], SizeVote | None]:
    """Return the boards that --detector detects, and the vote for an unknown size.

    `found` is that of `detect_boards`.

    Raises InputError if the set lacks what the detector requires, or if the images do
    not agree on the size.
    """
    detector = _detector_name(image_set, options)
    check_chessboard(image_set)
    where, target = image_set.description, cast(Chessboard, image_set.target)
    if type(target) in TARGET_DETECTORS and options.detector:
        raise InputError(
            f"{where}: target.kind: {detector} has its own detector; remove "
            f"--detector {options.detector}"
        )
    if detector in SIZE_DETECTORS and target.columns is None:
        raise InputError(
            f"{where}: target.columns: found null, but --detector {detector} requires "
            f"the board size; give columns and rows, or use {DEFAULT_DETECTOR}"
        )
    if detector in CLICK_DETECTORS and not any(view.outer_corners for view in views):
        raise InputError(
            f"{where}: views: found no outer_corners in {len(views)} views, but "
            f"--detector {detector} requires them; add the four clicked corners, or "
            f"use {DEFAULT_DETECTOR}"
        )
    boards = detect_boards(image_set, detector, views, say, found)
    if markers := marker_warning(image_set, boards):
        say(markers)
    if target.columns is not None:
        return boards, None
    return agree_on_size(image_set, boards, detector, say)


def _detector_name(image_set: ImageSet, options: SimpleNamespace) -> str:
    """Return the detector of --detector or of the set's target."""
    if type(image_set.target) in TARGET_DETECTORS:
        return TARGET_DETECTORS[type(image_set.target)][0]
    return options.detector or DEFAULT_DETECTOR
