"""Expected answers of the exercises of section 2.2."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.report import free_of_cubics
from chapters.shared.general import camera

# Of the FOV model that is the equidistance law.
OMEGA_DEG = np.degrees(2 * np.arctan(0.5))
# Semi-axes (mm) of the hyperboloid, along its axis and across.
ALONG_MM, ACROSS_MM = 30, 20


def xi(e):
    """Return xi of the unified sphere for a mirror's eccentricity."""
    return 2 * e / (1 + e**2)


def sphere_of_hyperboloid():
    """Return xi of the unified sphere equivalent to the hyperboloid."""
    return xi(np.hypot(ALONG_MM, ACROSS_MM) / ALONG_MM)


def divided_edge():
    """Return the radius (px) at which the division model reaches 90 deg."""
    model = camera("division")
    return model.K[0, 0] / np.sqrt(-model.coefficients[0])


def omega_task():
    """The law is r proportional to theta; arctan undoes tan where the factor
    2 tan(omega / 2) is 1, so omega is 2 arctan(1/2)."""
    return {
        "expected": lambda: OMEGA_DEG,
        "hint": "when does the arctangent undo the tangent?",
        "slips": {
            "That is in radians.": lambda: np.radians(OMEGA_DEG),
            "That is half of it.": lambda: OMEGA_DEG / 2,
        },
    }


def sphere_task():
    """With eccentricity e = sqrt(30^2 + 20^2) / 30, the sphere has
    xi = 2 e / (1 + e^2)."""
    return {
        "expected": sphere_of_hyperboloid,
        "hint": "xi depends on the eccentricity alone, and it is below 1",
        "slips": {
            "That is the eccentricity.": lambda: (
                np.hypot(ALONG_MM, ACROSS_MM) / ALONG_MM
            ),
            "The eccentricity is relative to the 30 mm.": lambda: xi(
                np.hypot(ALONG_MM, ACROSS_MM) / ACROSS_MM
            ),
        },
    }


def edge_task():
    """At 90 degrees the denominator 1 + lambda r^2 is 0: r = 1 / sqrt(0.25) = 2
    in units of the focal length."""
    return {
        "expected": divided_edge,
        "hint": "what happens to a ratio at 90 degrees?",
        "slips": {"That is in units of the focal length.": lambda: 2.0},
    }


def cubics_task():
    """Four cubics of two variables have 10 coefficients each; in each of the two
    ratios one common factor does not count."""
    return {
        "expected": lambda: free_of_cubics(2),
        "hint": "how many coefficients does a cubic of two variables have?",
        "slips": {
            "A common factor of a ratio does not count.": lambda: 40,
            "Both ratios have a numerator and a denominator.": lambda: 20,
        },
    }
