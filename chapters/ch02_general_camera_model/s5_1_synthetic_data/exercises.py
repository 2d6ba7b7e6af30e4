"""Expected answers of the exercises of section 2.5.1."""

import numpy as np

from chapters.shared.general import PRINCIPAL

NOISE_PX, GRIDS = 0.5, 3
FOV_DEG, STEP_AT_DEG = 120.0, 60.0
# From the image centre to its corner, half a pixel outside the last pixel centres.
HALF_DIAGONAL_PX = np.hypot(*(np.asarray(PRINCIPAL) + 0.5))


# RMS distance of a ray from one of its points over that from a new point.
FITTED_OVER_HELD_OUT = np.sqrt((1 - 1 / GRIDS) / (1 + 1 / GRIDS))
FOCAL_PX = HALF_DIAGONAL_PX / (np.radians(FOV_DEG) / 2)
# Radial stretch from the equidistance image to the corrected view.
STRETCH = 1 / np.cos(np.radians(STEP_AT_DEG)) ** 2


def residual_task():
    """The mean length of Gaussian noise on two axes is its SD times sqrt(pi / 2). The
    mean of n points with independent noise has 1 / sqrt(n) of that."""
    return {
        "expected": lambda: clean_residual(NOISE_PX, GRIDS),
        "hint": "what is the mean length of an error with two components?",
        "slips": {
            "That is the SD on one axis.": lambda: NOISE_PX / np.sqrt(GRIDS),
            "That is for one point; a ray is fitted to three.": lambda: clean_residual(
                NOISE_PX, 1
            ),
            "That is the RMS length, not the mean.": lambda: (
                NOISE_PX * np.sqrt(2 / GRIDS)
            ),
        },
    }


def held_out_task():
    """With noise of variance 1 the ray has 1 / 3. Its own points share that noise,
    which leaves 1 - 1 / 3. For a fourth point it adds, which makes 1 + 1 / 3."""
    return {
        "expected": lambda: FITTED_OVER_HELD_OUT,
        "hint": "which noise does the ray contain?",
        "slips": {
            "That is the ratio of the squares.": lambda: FITTED_OVER_HELD_OUT**2,
            "That is the other way round.": lambda: 1 / FITTED_OVER_HELD_OUT,
            "The ray has noise of its own at the fourth point, too.": lambda: np.sqrt(
                1 - 1 / GRIDS
            ),
        },
    }


def focal_task():
    """At the image's corner r = f theta, with r half the diagonal and theta half the
    field of view in radians."""
    return {
        "expected": lambda: FOCAL_PX,
        "hint": "which radius and which angle belong to the corner of the image?",
        "slips": {
            "The law takes radians.": lambda: HALF_DIAGONAL_PX / (FOV_DEG / 2),
            "The field of view has two sides.": lambda: (
                HALF_DIAGONAL_PX / np.radians(FOV_DEG)
            ),
            "The diagonal has two halves.": lambda: 2 * FOCAL_PX,
            "That is a pinhole.": lambda: (
                HALF_DIAGONAL_PX / np.tan(np.radians(FOV_DEG / 2))
            ),
        },
    }


def stretch_task():
    """The corrected view has the radius f tan(theta), the image f theta; the derivative
    of the tangent is one over the squared cosine."""
    return {
        "expected": lambda: STRETCH,
        "hint": "how does each radius grow with the angle?",
        "slips": {
            "That is the ratio of the radii, not of short steps.": lambda: (
                np.tan(np.radians(STEP_AT_DEG)) / np.radians(STEP_AT_DEG)
            ),
            "The plane is farther away there, and oblique to the ray too.": lambda: (
                np.sqrt(STRETCH)
            ),
            "That is the other way round.": lambda: 1 / STRETCH,
        },
    }


def clean_residual(noise, grids):
    """Return the mean length of a ray's error, for noise with an SD on each axis."""
    return noise * np.sqrt(np.pi / 2) / np.sqrt(grids)
