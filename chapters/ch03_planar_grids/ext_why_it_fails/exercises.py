"""Answers to the exercises of the page on CELECT's failures."""

from __future__ import annotations

from raxel.features.celect import CelectSettings

PUBLISHED = CelectSettings()


def least_square(length_px, corners):
    """Smallest square (px) on a side that t8 does not merge: 0.8 s_i."""
    return (
        PUBLISHED.merge * length_px / (PUBLISHED.radius_divisor * corners)
    )


def widest_arc():
    """Arc (deg) of side 4 at which L4 comes within t4 of a radius at its end."""
    return 2 * (90 - PUBLISHED.first_angle_deg)


def largest_radius(curve_px):
    """Window radius (px) whose arc stays within t5 of its tangent.

    An arc of radius R leaves its tangent by r^2 / (2 R) at a distance r.
    """
    return 2 * PUBLISHED.edge_band * curve_px
