"""Answers to the exercises of section 3.1.3."""

import numpy as np

SURFACE = {"a": 0.5, "b": 12.0, "c": -0.5, "d": -3.0, "e": 4.0}
WINDOW_PX, HALF_WINDOW_PX = 9, 4
RADIUS_PX, BLUR_SD_PX = 400.0, 3.0


def saddle_task():
    """The gradient of the surface vanishes: 2 a x + b y + d = 0 and
    b x + 2 c y + e = 0."""
    return {
        "expected": stationary_point,
        "hint": "what is the slope of the surface at its saddle?",
        "slips": {
            "Both signs are reversed.": lambda: -stationary_point(),
            "That is (y, x).": lambda: stationary_point()[::-1],
            "The derivatives of the squares have factors of two.": lambda: level_at(
                *[SURFACE[name] for name in "abc"]
            ),
        },
    }


def start_task():
    """The half window is 4 px. A start may have an error of 4 px on both axes at
    once, which is 4 sqrt(2) px."""
    return {
        "expected": farthest_return,
        "hint": "each axis has its own limit",
        "slips": {
            "That is along one axis, and other directions allow more.": lambda: (
                HALF_WINDOW_PX
            ),
            "That is the full window on each axis.": lambda: WINDOW_PX * np.sqrt(2),
            "OpenCV's half window excludes the middle pixel.": lambda: (
                WINDOW_PX / 2 * np.sqrt(2)
            ),
        },
    }


def arc_task():
    """Blur moves an arc by its variance over twice the radius, here 9 / 800 px.

    The Laplacian of a straight edge is zero on the edge. That of an arc has a
    further term, the slope over the radius. Blur adds half the variance times
    the Laplacian.
    """
    return {
        "expected": lambda: pulled_edge(RADIUS_PX, BLUR_SD_PX),
        "hint": "see *Curved edges bias a corner*",
        "slips": {
            "That is twice as far.": lambda: BLUR_SD_PX**2 / RADIUS_PX,
            "Blur counts with its variance, not its SD.": lambda: (
                BLUR_SD_PX / (2 * RADIUS_PX)
            ),
        },
    }


def stationary_point():
    """Stationary point (x, y) of the exercise's surface, in px."""
    a, b, c = (SURFACE[name] for name in "abc")
    return level_at(2 * a, b, 2 * c)


def level_at(xx, xy, yy):
    """Stationary point of a surface with these second derivatives."""
    return np.linalg.solve([[xx, xy], [xy, yy]], [-SURFACE["d"], -SURFACE["e"]])


def farthest_return():
    """Largest distance in px from which OpenCV returns a corner."""
    return HALF_WINDOW_PX * np.sqrt(2)


def pulled_edge(radius_px, blur_sd_px):
    """Distance in px by which blur moves an arc towards its centre."""
    return blur_sd_px**2 / (2 * radius_px)
