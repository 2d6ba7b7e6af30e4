"""What a reader of results must know: one line each, `warning: ...`, with the results.

Commands collect their warnings, print them last, and write them into their JSON file.
"""


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
