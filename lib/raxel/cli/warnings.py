"""What a reader of results must know: one line each, `warning: ...`, with the results.

Commands collect their warnings, print them last, and write them into their JSON file.
"""


def print_warnings(warnings):
    """Print each on a line of its own to standard output."""
    for text in warnings:
        print(f"warning: {text}")


def of_left_out(left_out):
    """A warning for each image that went into no result: [{file, reason}]."""
    return [f"{entry['file']}: left out: {entry['reason']}" for entry in left_out]
