"""Tests of the claims of section 4.1.1, as the registry states them."""

from chapters.ch04_central_generic.s1_1_synthetic_pinhole.results import (
    CAMERAS,
    SOLVERS,
    centre_ratio,
    difference,
    largest,
    over_cameras,
)
from repro.judge.statistics import Estimate, all_of, median_interval
from repro.run.experiment import claim, numbers
from repro.run.outcomes import NOT_COMPARABLE, Reading, Value

DISTORTION_FREE = 1e-9
EXACT_MM = 1e-6
WIDE = ("equidistance, 183°", "hyperboloid mirror")
BIAS_MM = 0.1


@claim("c4_synth_pinhole", needs=("exp_c4_synth_pinhole",), evidence="analytic")
def judge_picture(results):
    """Every pair lies on one homography, for any central camera."""
    found = results["exp_c4_synth_pinhole"]
    worst = over_cameras(found, "residual")
    in_mm = over_cameras(found, "residual_mm")
    scenes = found.trials_per_condition * len(CAMERAS)
    return Reading.of(
        worst < DISTORTION_FREE,
        worst,
        reason=f"largest residual of {scenes} scenes with four kinds of "
        f"camera, in normalised coordinates; {in_mm:.1g} mm",
    )


@claim("c4_any_pinhole", needs=("exp_c4_any_pinhole",), evidence="analytic")
def judge_centres(results):
    """Both solvers, for the fisheye of 183 deg and the hyperboloid."""
    found = results["exp_c4_any_pinhole"]
    worst, others = (
        max(over_cameras(found, solver, cameras) for solver in SOLVERS)
        for cameras in (WIDE, CAMERAS)
    )
    return Reading.of(
        worst < EXACT_MM,
        worst,
        "mm",
        "largest error of Sturm-Maybank and the circles over "
        f"{found.trials_per_condition} scenes each; with the radial lens "
        f"and rays at random as well {others:.1g} mm",
    )


@claim("c4_sm_vs_wl", needs=("exp_c4_sm_vs_wl",), evidence="synthetic")
def judge_methods(results):
    """Not comparable without Wang and Liu's paper; reports the ratio to the circles."""
    found = results["exp_c4_sm_vs_wl"]
    ratios = [centre_ratio(found, c) for c in found.conditions]
    values = sorted(ratio.value for ratio in ratios)
    return Reading.of(
        NOT_COMPARABLE,
        Estimate(values[len(values) // 2], values[0], values[-1]),
        "1",
        "the method of Wang and Liu is not "
        "described. Shown: error of the circle construction over that of "
        "Sturm-Maybank, median within trials, and its range over "
        f"{len(ratios)} levels of noise and fields of view",
    )


@claim(
    "c4_interp_bias_centre", needs=("exp_c4_interp_bias_centre",), evidence="synthetic"
)
def judge_interpolation(results):
    """Above 0.1 mm, and above the effect of 0.1 px noise."""
    found = results["exp_c4_interp_bias_centre"]
    bias, noise, boards, gap = (
        median_interval(found.column(name))
        for name in ("base_mm", "noise_mm", "all_mm", "gap_mm")
    )
    more = difference(found, "base_mm", "noise_mm")
    return Reading.of(
        all_of([bias.above(BIAS_MM), more.above(0.0)]),
        bias,
        "mm",
        f"0.1 px of noise with per-pixel data: {noise.value:.2g} "
        f"mm; all three grids interpolated: {boards.value:.2g} mm. The "
        f"points on the base are off by {gap.value:.2g} mm (median)",
    )


@numbers("sec_4_1_1", needs=("sec_4_1_1_grids",), evidence="analytic")
def values_of_grids(results):
    """Smallest number of grids that give the correct centre."""
    found = results["sec_4_1_1_grids"]
    enough = [
        grids
        for grids in found.levels("grids")
        if largest(found, "centre_mm", grids=grids) < EXACT_MM
    ]
    return {"s4_1_2_grids": Value(float(min(enough)))}
