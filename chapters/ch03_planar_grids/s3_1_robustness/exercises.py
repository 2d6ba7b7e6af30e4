"""Answers to the exercises of section 3.3.1."""

import math

FOCAL_PX, CORNER_PX = 300.0, 350.0
STEP_PX = (400.0, 450.0)
CLICK_SD_PX = 2.0


def yaw_task():
    """Turned by the yaw, an outer corner comes nearer by its distance times the sine;
    it is beside the camera when that is the focal length."""
    return {
        "expected": farthest_yaw,
        "hint": "how much nearer does a yaw bring an outer corner?",
        "slips": {
            "That is in radians.": lambda: math.radians(farthest_yaw()),
            "At yaw 0 the board faces the camera.": lambda: 90 - farthest_yaw(),
            "A corner keeps its distance from the board's middle.": lambda: (
                math.degrees(math.atan(FOCAL_PX / CORNER_PX))
            ),
        },
    }


def step_task():
    """An end of the step at r is seen at theta = arctan(r / f), and the fisheye shows
    that at 2 f sin(theta / 2); the difference of the two ends is the answer."""
    return {
        "expected": shrunk_step,
        "hint": "at which angle is each end seen, and where does Eqn 2.7 put it?",
        "slips": {
            "That is the equidistance law.": lambda: (
                FOCAL_PX * (seen_at(STEP_PX[1]) - seen_at(STEP_PX[0]))
            ),
            "That is where the step ends.": lambda: bent(STEP_PX[1]),
            "That is where a step of 50 px from the middle ends.": lambda: bent(
                STEP_PX[1] - STEP_PX[0]
            ),
        },
    }


def click_task():
    """The distance of Gaussian clicks follows Rayleigh's law, whose mean is the SD of
    an axis times sqrt(pi / 2)."""
    return {
        "expected": mean_click,
        "hint": "a distance has two axes; which law does it follow?",
        "slips": {
            "That is the SD on one axis.": lambda: CLICK_SD_PX,
            "That is the RMS, not the mean.": lambda: CLICK_SD_PX * math.sqrt(2),
            "That is the mean on one axis.": lambda: (
                CLICK_SD_PX * math.sqrt(2 / math.pi)
            ),
        },
    }


def farthest_yaw():
    """Yaw in degrees at which the plane of the board holds the camera."""
    return math.degrees(math.asin(FOCAL_PX / CORNER_PX))


def seen_at(flat_px):
    """Angle from the axis of a point of the flat picture."""
    return math.atan(flat_px / FOCAL_PX)


def bent(flat_px):
    """Radius in px at which the fisheye shows a point of the flat picture."""
    return 2 * FOCAL_PX * math.sin(seen_at(flat_px) / 2)


def shrunk_step():
    """Length of the step in px, as the fisheye shows it."""
    return bent(STEP_PX[1]) - bent(STEP_PX[0])


def mean_click():
    """Mean distance in px of a click from its corner."""
    return CLICK_SD_PX * math.sqrt(math.pi / 2)
