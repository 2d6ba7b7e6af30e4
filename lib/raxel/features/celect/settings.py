"""Every value of CELECT in one place: the thesis's, and those it leaves open."""

from dataclasses import dataclass


@dataclass(frozen=True)
class CelectSettings:
    """Values of Tables 3.1 and 3.2, the column rules, and what the thesis leaves open.

    A share is one of s, the contour's length scale in px: s_i of Table 3.1 for side i,
    and the window radius of the previous column's rule for a column (errata E-3.05).
    t1 and t2 take the number as Hough bins and degrees (E-3.02). Names that end in px
    or deg have that unit. Exceptions: `column_radius` is a share of the previous
    column's mean side, `column_merge` of its least distance of corners, `growth` of
    the radius, `integration` of the smoothing, `harris_share`, `canny_high` and
    `canny_low` of what is clear in the clicked windows, `least_votes` of the first
    peak's votes. `smoothing` is one of the smallest s_i.

    An ablation is another value (`most_growths=0`, `split_peaks=0`, `wrap=0`).
    """

    # Table 3.1 and section 3.1.2: the window radius.
    radius_divisor: float = 1.9
    column_radius: float = 0.5
    growth: float = 0.2
    # Table 3.2.
    split_peaks: float = 0.5  # t1
    wrap: float = 0.125  # t2
    near_centre: float = 0.4  # t3
    first_angle_deg: float = 15.0  # t4
    edge_band: float = 0.1  # t5
    arrival: float = 0.56  # t6
    corner_band: float = 0.4  # t7
    merge: float = 0.8  # t8
    column_merge: float = 0.47
    peaks: tuple[int, int] = (2, 5)

    # Not stated in the thesis.
    radius_scale: float = 1.0
    most_growths: int = 4
    steps_per_square: int = 6
    smoothing: float = 0.085
    smoothing_limits_px: tuple[float, float] = (0.5, 1.5)
    integration: float = 1.0
    harris_k: float = 0.04
    harris_share: float = 0.1
    canny_high: float = 0.3
    canny_low: float = 0.12
    suppression_deg: int = 10
    suppression_radius: float = 0.2
    least_votes: float = 0.5
    least_band_px: float = 1.0
