"""What trials call a number of basis functions."""


def name_of(shape):
    """Such as "7x3", along u and v."""
    return f"{shape[0]}x{shape[1]}"
