"""The claims of Fig. 5.10, and the numbers of Figs 5.9 and 5.10."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_calibration.results import (
    FANS,
    MOVED,
    fan_ratios,
    moved_px,
)
from chapters.shared.mirror_runs import PUBLISHED
from chapters.shared.mirror_sweep import READINGS, over_the_levels
from raxel.geometry.spline_grid import spline_grid
from repro.judge.statistics import median_interval
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value
from repro.run.readings import Case

DOUBLE = (1.6, 2.4)
FUNCTIONS, POINTS, UNITY = 21, 10_000, 1e-12


@claim(
    "c5_fov_doubles",
    needs=("fig_5_10_fans",),
    evidence="synthetic",
    readings=("mirror_bench", "mirror_geometry"),
)
def judge_field_of_view(results, options):
    """Test that the fan of rays at stage 3 is 1.6 to 2.4 times that at stage 0."""
    case = Case(READINGS, options)

    def reading_at(level):
        found = {g: fan_ratios(results[FANS], g, level) for g in "ABC"}
        ratio = median_interval(found[case["mirror_geometry"]])
        medians = ", ".join(f"{g} {np.median(of):.2f}" for g, of in found.items())
        return Reading.of(
            bool(DOUBLE[0] <= ratio.low and ratio.high <= DOUBLE[1]),
            ratio,
            reason="angle between the outermost rays of the mirror's middle line, "
            f"stage 3 over stage 0; on geometries {medians}",
        )

    return over_the_levels(case, reading_at)


@claim("c5_displacement", needs=("fig_5_10_moved",), evidence="synthetic")
def judge_displacement(results):
    """Test that the mean displacement of the features rises with every deflection."""
    moved = moved_px(results[MOVED], "A")
    least = np.diff(moved, axis=1).min()
    return Reading.of(
        bool(least > 0),
        float(least),
        "px",
        "least growth of the mean way from one deflection to the next, over "
        f"{len(moved)} places of the board on geometry A; up to "
        f"{moved[:, -1].max():.0f} px at 15 mm",
    )


@claim("c5_basis21", needs=(), evidence="analytic")
def judge_basis(results):
    """Test that 7 x 3 quadratic functions are 21, and sum to one everywhere."""
    grid = spline_grid(np.array([[0.0, 0.0], [5.0, 1.0]]), PUBLISHED.shape)
    points = np.random.default_rng(0).uniform([0, 0], [5, 1], (POINTS, 2))
    off = np.abs(grid.rows(points)[0].sum(axis=1) - 1).max()
    return Reading.of(
        grid.size == FUNCTIONS and off < UNITY,
        float(off),
        "1",
        f"largest distance of the sum from 1 at {POINTS} points; {grid.size} functions "
        f"of degree {grid.degree[0]}",
    )


@numbers("fig_5_9", needs=(), evidence="analytic")
def numbers_fig_5_9(results):
    """The numbers of basis functions, and their degree."""
    along, across = PUBLISHED.shape
    degree = PUBLISHED.settings.degree[0]
    return {
        "fig5_9_kf": Value(along, unit="count"),
        "fig5_9_kg": Value(across, unit="count"),
        "fig5_9_n": Value(along * across, unit="count"),
        "fig5_9_deg": Value(degree, unit="count"),
    }


@numbers("fig_5_10", needs=("fig_5_10_fans",), evidence="synthetic")
def numbers_fig_5_10(results):
    """Growth of the fan of rays."""
    ratios = fan_ratios(results[FANS], "A", "laboratory")
    return {"fig5_10_fov": Value.median(ratios, unit="ratio")}
