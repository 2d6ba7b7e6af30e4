"""Answers to the exercises of section 3.2.1."""

import numpy as np

K1, FOCAL_MM, SIDE_MM = -0.8, 680.0, 300.0
RADIUS_MM, PITCH_MM = 200.0, 20.0
NOISE_PX, WIDTH_PX = 0.1, 4000


def largest_task():
    """S and T are largest in the middle of the square, h^2/4 each, so the bias is
    |k1| / f^2 times the radius times h^2/2."""
    return {
        "expected": largest_bias,
        "hint": "where in a square are S and T largest?",
        "slips": {
            "S and T add.": lambda: largest_bias() / 2,
            "That is the RMS over the square, not the largest.": lambda: (
                strength() * RADIUS_MM * PITCH_MM**2 * np.sqrt(11 / 90)
            ),
            "S is s(h - s): it is largest at h/2.": lambda: (
                strength() * RADIUS_MM * PITCH_MM**2
            ),
        },
    }


def balance_task():
    """Noise of 0.1 px is 0.1 * 300 / 4000 mm on the grid. Its RMS, sqrt(52/45) times
    that, equals |k1| / f^2 h^2 sqrt(11/90) a / sqrt(6) at the answer."""
    return {
        "expected": balanced_pitch,
        "hint": "express both RMS on the grid, in mm, and solve for the pitch",
        "slips": {
            "The pitch enters squared.": lambda: balanced_pitch() ** 2,
            "One px of this camera is not 0.3 mm.": lambda: (
                balanced_pitch() * np.sqrt(4)
            ),
            "The RMS of the interpolated point is larger than the noise.": lambda: (
                balanced_pitch() * (45 / 52) ** 0.25
            ),
        },
    }


def strength():
    """|k1| / f^2, per mm^2."""
    return abs(K1) / FOCAL_MM**2


def largest_bias():
    """Largest bias in mm in a square at RADIUS_MM."""
    return strength() * RADIUS_MM * PITCH_MM**2 / 2


def balanced_pitch():
    """Pitch in mm at which corner noise and bias have the same RMS."""
    noise = np.sqrt(52 / 45) * NOISE_PX * SIDE_MM / WIDTH_PX
    per_area = strength() * np.sqrt(11 / 90) * SIDE_MM / np.sqrt(6)
    return np.sqrt(noise / per_area)
