"""Answers to the exercises of section 3.3.1."""

import math

FOCAL_PX, CORNER_PX = 300.0, 350.0
STEP_PX = (400.0, 450.0)
CLICK_SD_PX = 2.0


def yaw_task():
    """A yaw brings an outer corner nearer by its distance times the sine. It reaches
    the camera's plane when that is the focal length."""
    return {
        "expected": farthest_yaw,
        "hint": "by how much does a yaw reduce the depth of an outer corner?",
        "slips": {
            "That is in radians.": lambda: math.radians(farthest_yaw()),
            "At yaw 0 the board faces the camera.": lambda: 90 - farthest_yaw(),
            "A corner keeps its distance from the board's middle.": lambda: (
                math.degrees(math.atan(FOCAL_PX / CORNER_PX))
            ),
        },
    }


def step_task():
    """An end of the step at r has the angle theta = arctan(r / f), which the fisheye
    maps to 2 f sin(theta / 2). The answer is the difference of both ends."""
    return {
        "expected": shrunk_step,
        "hint": "which angle has each end, and to which radius does Eqn 2.7 map it?",
        "slips": {
            "That is the equidistance law.": lambda: (
                FOCAL_PX * (axis_angle(STEP_PX[1]) - axis_angle(STEP_PX[0]))
            ),
            "That is the radius of the step's far end.": lambda: bent(STEP_PX[1]),
            "That is the length of a step of 50 px from the centre.": lambda: bent(
                STEP_PX[1] - STEP_PX[0]
            ),
        },
    }


def click_task():
    """The distance of Gaussian clicks has a Rayleigh distribution, whose mean is the
    SD of an axis times sqrt(pi / 2)."""
    return {
        "expected": mean_click,
        "hint": "which distribution has the length of a 2D Gaussian vector?",
        "slips": {
            "That is the SD on one axis.": lambda: CLICK_SD_PX,
            "That is the RMS, not the mean.": lambda: CLICK_SD_PX * math.sqrt(2),
            "That is the mean on one axis.": lambda: (
                CLICK_SD_PX * math.sqrt(2 / math.pi)
            ),
        },
    }


def farthest_yaw():
    """Yaw in degrees at which the plane of the board contains the camera."""
    return math.degrees(math.asin(FOCAL_PX / CORNER_PX))


def axis_angle(flat_px):
    """Angle to the axis of a point of the undistorted image."""
    return math.atan(flat_px / FOCAL_PX)


def bent(flat_px):
    """Radius in px of a point of the undistorted image in the fisheye image."""
    return 2 * FOCAL_PX * math.sin(axis_angle(flat_px) / 2)


def shrunk_step():
    """Length of the step in px in the fisheye image."""
    return bent(STEP_PX[1]) - bent(STEP_PX[0])


def mean_click():
    """Mean distance in px of a click from its corner."""
    return CLICK_SD_PX * math.sqrt(math.pi / 2)
