"""Results of section 3.2.1: errors, slopes, the ridge, quoted numbers."""

from collections import namedtuple

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.interpolators import FOUR
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import (
    FOCAL_MM,
    MIDDLE_MM,
    RADIAL,
    SIDE_MM,
)
from repro.judge.statistics import loglog_slope
from repro.page.reader import value

READINGS = tuple(FOUR)
PRIMARY = READINGS[0]
MAGNIFIED = 300  # scale of the vectors of Fig. 3.6
STATED_MM = 20
BIN_EDGES_MM = np.linspace(0, MIDDLE_MM * np.sqrt(2), 5)
# Larger than the effect of rounding on the choice of corners, mm.
OTHER_CORNERS_TOL_MM = 1e-9

Vectors = namedtuple("Vectors", "points errors")


def trials_of_vectors(result, reading):
    """Vectors of every trial, (n, 2) and (n, 2) mm, without points that failed."""
    both = zip(result.arrays("points"), result.arrays(reading), strict=True)
    drawn = ((points, errors, np.isfinite(errors[:, 0])) for points, errors in both)
    return [Vectors(points[seen], errors[seen]) for points, errors, seen in drawn]


def radii(points):
    """Distance (n,) mm from the image centre."""
    return np.linalg.norm(points - MIDDLE_MM, axis=1)


def rank_of_growth(vectors):
    """Spearman's correlation of the error's length with the radius."""
    from scipy.stats import spearmanr

    size = np.linalg.norm(vectors.errors, axis=1)
    return float(spearmanr(radii(vectors.points), size).statistic)


def means_in_bins(vectors):
    """Mean size (4,) mm of the errors between BIN_EDGES_MM."""
    size = np.linalg.norm(vectors.errors, axis=1)
    place = np.digitize(radii(vectors.points), BIN_EDGES_MM[1:-1])
    return np.array([size[place == k].mean() for k in range(len(BIN_EDGES_MM) - 1)])


def radial_share(vectors):
    """Radial share of the squared errors."""
    out = (vectors.points - MIDDLE_MM) / radii(vectors.points)[:, None]
    along = np.sum(out * vectors.errors, axis=1)
    return float(np.sum(along**2) / np.sum(vectors.errors**2))


def radial_shares(result, reading):
    """`radial_share` of every trial (trials,)."""
    return np.array([radial_share(v) for v in trials_of_vectors(result, reading)])


def with_other_corners(result):
    """Flags (n,) per trial of points whose corners differ between the two choices."""
    return [
        np.abs(a - b).max(axis=1) > OTHER_CORNERS_TOL_MM
        for a, b in zip(*(result.arrays(name) for name in READINGS), strict=True)
    ]


def of_other_corners(result):
    """Vectors of those points in the first trial, with the nearest four."""
    other = with_other_corners(result)[0]
    points, errors = result.arrays("points"), result.arrays(PRIMARY)
    return Vectors(points[0][other], errors[0][other])


def swept(result, reading, key="pitch_mm"):
    """Levels (n,) of a sweep, and RMS errors (n, trials) mm at each level."""
    of_level = result.by(key)
    errors = [trials.column(f"{reading}.rms_mm") for trials in of_level.values()]
    return np.array(list(of_level), float), np.array(errors)


def formula_mm(pitch_mm):
    """RMS of the bias over the grid with k1 alone, in mm."""
    strength = abs(RADIAL[0]) / FOCAL_MM**2
    return strength * np.square(pitch_mm) * np.sqrt(11 / 90) * SIDE_MM / np.sqrt(6)


def gain_of_decoding(result, known, smoothing):
    """Ratio (trials,) of interpolation's to decoding's RMS near the ridge."""
    return result.column(f"{known}.rms_mm") / result.column(f"{smoothing}.rms_mm")


def name_values(open_results):
    """Name the numbers that the page quotes."""
    quoted = {
        **of_vectors(open_results("fig_3_6_vectors")),
        **of_pitches(open_results("fig_3_7_pitches")),
        "formula_20": formula_mm(STATED_MM),
        **of_breaks(open_results("exp_c3_interp_discontinuous")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_vectors(vectors):
    """Radial part of the errors of Fig. 3.6 with the nearest four, in percent."""
    return {"radial.nearest": 100 * np.median(radial_shares(vectors, PRIMARY))}


def of_pitches(pitches):
    """Slope of Fig. 3.7, and the enclosing cell's error at the pitch of Fig. 3.6."""
    levels, errors = swept(pitches, PRIMARY)
    inner = pitches.column(f"{READINGS[1]}.rms_mm", pitch_mm=STATED_MM)
    return {
        "slope": loglog_slope(levels, np.median(errors, axis=1)),
        "at_20": np.median(inner),
    }


def of_breaks(ridge):
    """Gross errors of interpolation and trusted pixels near the ridge, in percent."""
    return {
        "break.unknown.gross": 100 * np.median(ridge.column("unknown.gross")),
        "break.trusted": 100 * np.median(ridge.column("trusted")),
    }
