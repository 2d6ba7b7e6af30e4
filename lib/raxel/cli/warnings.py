"""Warnings of a set: one line each, `warning: ...`, printed last.

Commands collect their warnings, print them, and write them into their JSON file.
"""

import math

from raxel.evaluation.diagnoses import diagnosis

NOT_SQUARE_TOL = 0.05  # of a side: pixels of monitors are square to far less


def print_warnings(warnings):
    """Print each on a line of its own to standard output."""
    for text in warnings:
        print(f"warning: {text}")


def warning_fields(warnings):
    """The warnings for JSON: texts, and for each its code, parts and values."""
    diagnoses = [warning.fields() for warning in warnings]
    return {"warnings": warnings, "diagnoses": diagnoses}


def of_handedness(mirrored):
    """A warning where some views are mirrored and others are not.

    mirrored: [(name of the view, whether it is, None where that is unknown)].
    """
    by_handedness = {is_so: name for name, is_so in mirrored}
    if not {True, False} <= set(by_handedness):
        return []
    names = {"mirrored": by_handedness[True], "upright": by_handedness[False]}
    return [diagnosis("mixed-handedness", **names)]


def of_left_out(left_out):
    """A warning for each image that went into no result: [{file, reason}]."""
    return [diagnosis("view-excluded", **entry) for entry in left_out]


def of_pixels(monitor):
    """A warning where the pixels of an ActiveGrid's monitor would not be square."""
    pixel = _pixel(monitor)
    if not pixel or abs(math.log(pixel[0] / pixel[1])) < NOT_SQUARE_TOL:
        return []
    sides = dict(zip(("width_mm", "height_mm"), pixel, strict=True))
    return [diagnosis("monitor-pixels-not-square", **sides)]


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
