"""Estimates of section 4.1.1, from its results."""

import numpy as np

from repro.judge.statistics import bootstrap, median_interval, with_worst
from repro.page.reader import value

CAMERAS = (
    "radial lens, 100°",
    "equidistance, 183°",
    "hyperboloid mirror",
    "no lens: rays at random",
)
LENSES = ("radial, 100°", "equidistance, 150°")
SOLVERS = {"CGSP": "Sturm-Maybank", "CGSP circle": "circles"}


def name_values(open_results):
    """Name the numbers that the prose quotes."""
    exact = open_results("exp_c4_any_pinhole")
    noisy = open_results("exp_c4_sm_vs_wl")
    ratios = [centre_ratio(noisy, condition).value for condition in noisy.conditions]
    boards = open_results("exp_c4_interp_bias_centre")
    found = {
        "residual": over_cameras(open_results("exp_c4_synth_pinhole"), "residual"),
        "exact_mm": max(over_cameras(exact, name) for name in SOLVERS),
        "ratio_most": max(ratios),
        **{
            f"board.{name}": median_interval(boards.column(name)).value
            for name in ("base_mm", "noise_mm")
        },
    }
    for name, number in found.items():
        value(name, number)


def largest(found, name, **condition):
    """Return the largest error over trials; a failed trial counts as infinite."""
    return float(with_worst(found.column(name, **condition)).max())


def over_cameras(found, name, cameras=CAMERAS):
    """Return the largest error over the trials with the given cameras."""
    return max(largest(found, name, camera=camera) for camera in cameras)


def centre_ratio(found, condition):
    """Return the median ratio of the circles' error to Sturm-Maybank's, an Estimate."""
    one, other = (
        found.column(solver, **condition) for solver in ("CGSP", "CGSP circle")
    )
    both = np.isfinite(one) & np.isfinite(other)
    return median_interval(other[both] / one[both])


def straightness(lattice):
    """Return the largest deviation of a lattice's lines from straight, per length.

    lattice: (rows, columns, 2).
    """
    worst = 0.0
    for line in [*lattice, *np.swapaxes(lattice, 0, 1)]:
        along = line[-1] - line[0]
        length = np.linalg.norm(along)
        x, y = (line - line[0]).T
        off = np.abs(along[0] * y - along[1] * x) / length
        worst = max(worst, float(off.max() / length))
    return worst


def difference(found, one, other):
    """Return the median difference within trials, an Estimate."""
    a, b = (with_worst(found.column(name)) for name in (one, other))
    return bootstrap(lambda x: np.median(x, axis=-1), a - b)
