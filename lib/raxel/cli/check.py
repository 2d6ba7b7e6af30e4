"""`raxel check SET`"""

import math
from collections import Counter

from raxel.cli.terminal import on_one_line
from raxel.cli.warnings import of_pixels, print_warnings
from raxel.sets import (
    ActiveGrid,
    Charuco,
    ImageSet,
    is_mirror_set,
    load_mirror_set,
    load_reference,
    load_set,
    read_image,
)
from raxel.sets.image_files import has_orientation
from raxel.sets.patterns import cell_width

TURNED = "EXIF orientation ignored; pixels stay where the sensor had them"


def check(options, say):
    """Read everything in the set; what is printed is what a calibration would get."""
    if is_mirror_set(options.set):
        _check_mirror_set(load_mirror_set(options.set), say)
    else:
        _check_images(load_set(options.set), say)


def _check_mirror_set(mirror_set, say):
    """Every image set of a mirror set, then what is its own."""
    for field, image_set in mirror_set.image_sets.items():
        print(f"-- {field}")
        _check_images(image_set, say)
    print("-- mirror")
    if not isinstance(mirror_set.viewer, ImageSet):
        print(f"viewer     {on_one_line(mirror_set.viewer.name)}")
    clamp = mirror_set.clamp
    hidden = f", up to {clamp.hidden_mm:g} mm before the clamp" * (clamp.hidden_mm > 0)
    print(f"platter    {mirror_set.thickness_mm:g} mm before its board")
    print(f"clamp      {len(clamp.points)} points, SD {clamp.sd_px:g} px{hidden}")
    moved = [step.deflection_mm for step in mirror_set.steps]
    stated = ", ".join("not stated" if mm is None else f"{mm:g} mm" for mm in moved)
    scored = sum(len(step.evaluate) for step in mirror_set.steps)
    boards = f"{scored} board{'s' * (scored != 1)} to evaluate"
    print(f"stages     {len(moved)} deflections ({stated}), {boards}")


def _check_images(image_set, say):
    reference = load_reference(image_set)
    files = list(dict.fromkeys(name for v in image_set.views for name in v.files))
    depths, turned = Counter(), 0
    for number, name in enumerate(files, 1):
        depths[read_image(image_set, name).dtype.itemsize * 8] += 1
        turned += has_orientation(image_set.folder / name)
        say(f"{number}/{len(files)} {name}")
    bits = ", ".join(f"{count} of {depth} bit" for depth, count in depths.items())
    uses = Counter(view.use for view in image_set.views)
    print(f"set        {image_set.name}")
    print(f"camera     {on_one_line(image_set.camera) or 'not described'}")
    print(f"images     {bits}, {image_set.width} x {image_set.height} px")
    print(f"target     {_target(image_set.target)}")
    print(f"views      {', '.join(f'{n} to {use}' for use, n in uses.items())}")
    if isinstance(image_set.target, ActiveGrid):
        for line in _shown(image_set):
            print(f"patterns   {line}")
    if reference:
        print(f"reference  corners of {len(reference)} images")
    if image_set.truth:
        print(f"truth      {image_set.truth}")
    if turned:
        print_warnings([f"{turned} of {len(files)} images: {TURNED}"])


def _target(target):
    if isinstance(target, ActiveGrid):
        size = f"{target.monitor_px[0]} x {target.monitor_px[1]} px"
        if target.monitor_mm is None:
            return (
                f"active grid on a monitor of {size}, size in mm unknown (lengths come "
                "out in pitches of its pixels, taken for square)"
            )
        width, height = target.monitor_mm
        told = f"active grid on a monitor of {size}, {width:g} x {height:g} mm"
        return "; ".join([told, *of_pixels(target)])
    pitch = f"pitch {target.pitch_mm} mm"
    if target.pitch_mm is None:
        pitch = "pitch unknown (lengths come out in pitches)"
    counts = "unknown counts of corners"
    if target.columns is not None:
        counts = f"{target.columns} x {target.rows} interior corners"
    if isinstance(target, Charuco):
        markers = f"markers {target.dictionary}, {target.marker_mm:g} mm"
        return f"ChArUco board, {counts}, {pitch}, {markers}"
    return f"chessboard, {counts}, {pitch}"


def _shown(image_set):
    """A line for the views whose patterns are alike, in the order of the set."""
    views = {}
    for view in image_set.views:
        told = _patterns(view, image_set.target.monitor_px)
        views.setdefault(told, []).append(on_one_line(view.name))
    for told, names in views.items():
        those = names[0]
        if len(names) > 1:
            those = f"{names[0]} and {len(names) - 1} more"
        yield f"{those}: {told}"


def _patterns(view, monitor_px):
    present = {}
    for pattern in view.patterns:
        code = pattern.axis, pattern.kind, pattern.of, pattern.periods, pattern.cell_px
        present.setdefault((*code, pattern.offset), []).append(pattern)
    levels = [name for name in ("white", "black") if getattr(view, name)]
    return ", ".join([*(_code(p, monitor_px) for p in present.values()), *levels])


def _code(patterns, monitor_px):
    """What the pictures of one code along one axis show."""
    first = patterns[0]
    size = monitor_px["xy".index(first.axis)]
    if first.kind == "gray":
        bits = len({pattern.bit for pattern in patterns})
        inverses = sum(pattern.inverse for pattern in patterns)
        width = cell_width(first, monitor_px)
        count = min(math.ceil(size / width - 1e-9), 2**first.of)
        return (
            f"{first.axis} gray {bits} of {first.of} bits"
            f"{f' and {inverses} inverses' if inverses else ''} "
            f"({count} cells of {width:g} px)"
        )
    steps = len({pattern.step for pattern in patterns})
    offset = f", offset {first.offset:g}" if first.offset else ""
    return (
        f"{first.axis} phase {steps} of {first.of} steps "
        f"({first.periods:.4g} periods of {size / first.periods:.4g} px{offset})"
    )
