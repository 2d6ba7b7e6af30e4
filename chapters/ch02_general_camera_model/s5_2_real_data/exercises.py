"""Expected answers of the exercises of section 2.5.2."""

import numpy as np

LENS_MM, CONVERTER = 16.0, 0.21
SENSOR_MM, WIDTH_PX = 7.18, 1024
RADIUS_PX, FOCAL_PX = 384.0, 235.0
MEAN_PX, SD_PX = 0.65, 0.35


# Of the lens behind its converter.
ZOOM_FOCAL_PX = LENS_MM * CONVERTER * WIDTH_PX / SENSOR_MM
# Of the equidistance law at the upper edge of the image.
EDGE_DEG = np.degrees(RADIUS_PX / FOCAL_PX)


def zoom_task():
    """The focal length in mm, shortened by the converter, divided by the width of a
    pixel: the sensor's width over the number of pixels across."""
    return {
        "expected": lambda: ZOOM_FOCAL_PX,
        "hint": "which length of the sensor is known in mm and in px?",
        "slips": {
            "That is in mm.": lambda: LENS_MM * CONVERTER,
            "That is without the converter.": lambda: ZOOM_FOCAL_PX / CONVERTER,
            "The converter shortens the lens.": lambda: ZOOM_FOCAL_PX / CONVERTER**2,
        },
    }


def edge_task():
    """theta = r / f, in radians first."""
    return {
        "expected": lambda: EDGE_DEG,
        "hint": "which angle does the law contain, and in which unit?",
        "slips": {
            "That is in radians.": lambda: RADIUS_PX / FOCAL_PX,
            "That is a pinhole.": lambda: np.degrees(np.arctan(RADIUS_PX / FOCAL_PX)),
            "The question is about one edge, not both.": lambda: 2 * EDGE_DEG,
        },
    }


def rms_task():
    """The mean square is the squared mean plus the squared SD."""
    return {
        "expected": lambda: np.hypot(MEAN_PX, SD_PX),
        "hint": "write the SD in terms of the mean square",
        "slips": {
            "Mean and SD do not add directly.": lambda: MEAN_PX + SD_PX,
            "An RMS is never less than the mean.": lambda: np.sqrt(
                MEAN_PX**2 - SD_PX**2
            ),
        },
    }
