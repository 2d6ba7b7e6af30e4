"""What the user gives CELECT, checked: image, clicks, counts, contours by hand."""

import numpy as np

from raxel.errors import InputError

LEAST_COUNT = 2
LEAST_SQUARE_PX = 3.0


def checked_image(image):
    """The image as a grey array (h, w) of uint8 or uint16, or InputError."""
    image = np.asarray(image)
    if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16) or not image.size:
        raise InputError(
            f"image: found an array of shape {image.shape} and type {image.dtype}; "
            "give a grey image (height, width) of 8 or 16 bits"
        )
    return image


def checked_count(name, value):
    """A count of corners as an int, or InputError."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InputError(f"{name}: found {value!r}; give a whole number of corners")
    if value < LEAST_COUNT:
        raise InputError(f"{name}: found {value}; give {LEAST_COUNT} corners or more")
    return int(value)


def checked_points(name, points, count, image):
    """Points (count, 2) float64 inside the image, or InputError."""
    try:
        array = np.array(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != (count, 2) or not np.isfinite(array).all():
        raise InputError(
            f"{name}: found shape {array.shape}; give {count} finite points (u, v)"
        )
    height, width = image.shape
    beyond = (array < -0.5) | (array > (width - 0.5, height - 0.5))
    if beyond.any():
        index = int(beyond.any(axis=1).argmax())
        u, v = array[index]
        raise InputError(
            f"{name}[{index}]: found ({u:g}, {v:g}), outside the image of {width} x "
            f"{height} px; give points inside it"
        )
    return array


def checked_clicks(outer_corners, columns, rows, image):
    """The four clicks (4, 2), round the board and far enough apart, or InputError."""
    clicks = checked_points("outer_corners", outer_corners, 4, image)
    if _cross(*clicks) or _cross(*np.roll(clicks, 1, axis=0)):
        raise InputError(
            "outer_corners: found two sides that cross; give the four corners in order "
            "round the board"
        )
    sides = np.linalg.norm(np.roll(clicks, -1, axis=0) - clicks, axis=1)
    squares = sides / (np.array([columns, rows, columns, rows]) - 1)
    if squares.min() < LEAST_SQUARE_PX:
        raise InputError(
            f"outer_corners: found a side with squares of {squares.min():.2g} px; give "
            f"corners of a board with squares of {LEAST_SQUARE_PX:g} px or more"
        )
    return clicks


def checked_contours(given, columns, rows, image):
    """Corners by hand, {contour: (n, 2)}, of known names and counts, or InputError."""
    counts = contour_counts(columns, rows)
    checked = {}
    for name, points in (given or {}).items():
        if name not in counts:
            raise InputError(
                f"given_contours: found {name!r}; give one of {', '.join(counts)}"
            )
        field = f"given_contours[{name!r}]"
        checked[name] = checked_points(field, points, counts[name], image)
    return checked


def contour_counts(columns, rows):
    """How many corners each contour has, {name: count}, in the order of tracing."""
    counts = {f"side {i}": (columns, rows)[(i - 1) % 2] for i in range(1, 5)}
    return counts | {f"column {k}": rows for k in range(2, columns)}


def _cross(a, b, c, d):
    """Whether the segments ab and cd cross."""
    return _turn(a, b, c) * _turn(a, b, d) < 0 and _turn(c, d, a) * _turn(c, d, b) < 0


def _turn(a, b, c):
    (x, y), (p, q) = b - a, c - a
    return x * q - y * p
