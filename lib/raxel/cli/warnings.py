"""What a reader of results must know: one line each, `warning: ...`, with the results.

Commands collect their warnings, print them last, and write them into their JSON file.
"""

import math

OBLONG = 0.05  # of a side: pixels of monitors are square to far less


def print_warnings(warnings):
    """Print each on a line of its own to standard output."""
    for text in warnings:
        print(f"warning: {text}")


def of_handedness(mirrored):
    """A warning where some views are seen as in a mirror and others are not.

    mirrored: [(name of the view, whether it is, None where that cannot be told)].
    """
    told = {is_so: name for name, is_so in mirrored}
    if not {True, False} <= set(told):
        return []
    return [
        f"{told[True]} shows the grid as in a mirror, and {told[False]} does not; one "
        "of them has an axis reversed: check axis, and inverse of bit 0"
    ]


def of_left_out(left_out):
    """A warning for each image that went into no result: [{file, reason}]."""
    return [f"{entry['file']}: left out: {entry['reason']}" for entry in left_out]


def of_pixels(monitor):
    """A warning where the pixels of an ActiveGrid's monitor would not be square."""
    pixel = _pixel(monitor)
    if not pixel or abs(math.log(pixel[0] / pixel[1])) < OBLONG:
        return []
    return [
        f"the monitor's pixels would be {pixel[0]:.3g} x {pixel[1]:.3g} mm, not "
        "square: are monitor_px and monitor_mm right, width first?"
    ]


def of_swapped_sides(monitor):
    """That warning where width and height in mm, exchanged, give squarer pixels."""
    pixel = _pixel(monitor)
    if not pixel:
        return []
    wide, high = monitor.monitor_px
    swapped = pixel[1] * high / wide, pixel[0] * wide / high
    ratios = [abs(math.log(one / other)) for one, other in (pixel, swapped)]
    return of_pixels(monitor) if ratios[1] < ratios[0] else []


def _pixel(monitor):
    """(width, height) in mm of a pixel of the monitor, or None."""
    if monitor.monitor_mm is None:
        return None
    sides = zip(monitor.monitor_mm, monitor.monitor_px, strict=True)
    return tuple(mm / px for mm, px in sides)
