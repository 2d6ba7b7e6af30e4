"""What section 4.1.1 found, read from its results."""

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
    """Name the numbers that the prose of the page quotes."""
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
    """Largest error over trials; a trial without a result is infinitely off."""
    return float(with_worst(found.column(name, **condition)).max())


def over_cameras(found, name, cameras=CAMERAS):
    """Largest error over the trials with some cameras, or all."""
    return max(largest(found, name, camera=camera) for camera in cameras)


def centre_ratio(found, condition):
    """Median over trials of the circles' error over Sturm-Maybank's: Estimate."""
    one, other = (
        found.column(solver, **condition) for solver in ("CGSP", "CGSP circle")
    )
    both = np.isfinite(one) & np.isfinite(other)
    return median_interval(other[both] / one[both])


def straightness(lattice):
    """Largest distance of a lattice's lines from straight ones, by their length.

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
    """Median of the differences within trials: Estimate."""
    a, b = (with_worst(found.column(name)) for name in (one, other))
    return bootstrap(lambda x: np.median(x, axis=-1), a - b)
