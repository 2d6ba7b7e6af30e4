"""`raxel check SET`"""

from collections import Counter

from raxel.cli.terminal import on_one_line
from raxel.sets import ActiveGrid, Charuco, load_reference, load_set, read_image


def check(options, say):
    """Read everything in the set; what is printed is what a calibration would get."""
    image_set = load_set(options.set)
    reference = load_reference(image_set)
    files = list(dict.fromkeys(name for v in image_set.views for name in v.files))
    depths = Counter()
    for number, name in enumerate(files, 1):
        depths[read_image(image_set, name).dtype.itemsize * 8] += 1
        say(f"{number}/{len(files)} {name}")
    bits = ", ".join(f"{count} of {depth} bit" for depth, count in depths.items())
    uses = Counter(view.use for view in image_set.views)
    print(f"set        {image_set.name}")
    print(f"camera     {on_one_line(image_set.camera) or 'not described'}")
    print(f"images     {bits}, {image_set.width} x {image_set.height} px")
    print(f"target     {_target(image_set.target)}")
    print(f"views      {', '.join(f'{n} to {use}' for use, n in uses.items())}")
    if isinstance(image_set.target, ActiveGrid):
        for view in image_set.views:
            print(f"patterns   {on_one_line(view.name)}: {_patterns(view)}")
    if reference:
        print(f"reference  corners of {len(reference)} images")
    if image_set.truth:
        print(f"truth      {image_set.truth}")


def _target(target):
    if isinstance(target, ActiveGrid):
        size = f"{target.monitor_px[0]} x {target.monitor_px[1]} px"
        return f"active grid on a monitor of {size}"
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


def _patterns(view):
    present = {}
    for pattern in view.patterns:
        number = pattern.bit if pattern.kind == "gray" else pattern.step
        code = pattern.axis, pattern.kind, pattern.of
        present.setdefault(code, set()).add(number)
    names = {"gray": "bits", "phase": "steps"}
    return ", ".join(
        f"{axis} {kind} {len(numbers)} of {of} {names[kind]}"
        for (axis, kind, of), numbers in present.items()
    )
