"""The claims of section 4.3.2 and of its discussion, seed by seed."""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results import (
    BRACKETS,
    CAUSTIC,
    READINGS,
    SEEDS_OF_BOTH,
    Seeds,
    adjustment_reduces,
    centre_in_hull,
    compact_across,
    fisheye_scatter,
    omnidirectional_scatter,
    order_of_magnitude,
    orders_as_simulated,
    parameters_agree,
    similar_cameras,
    smaller_gap,
    tighter_on_both,
    unadjusted_ahead,
)
from chapters.shared.noise_sweep import counterpart_over_the_sweep, over_the_sweep
from repro.judge.statistics import proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import Case, counterpart

MAX_OF_ALIGNED, STATED_MM = 2.0, 1.0
STANDARD = ("decoding_noise", "standard_method")
SCATTERS = ("decoding_noise", "standard_method", "scatter_rays")
# With the simulation of 4.1.5.
WITH_SIMULATED = ("table_4_3_rendered", "table_4_3_redrawn", "fig_4_2_redrawn")


def _by_seed(results, options, predicate):
    """The Reading of a predicate of `Seeds`, over the sweep of the noise."""
    return counterpart_over_the_sweep(
        Case(READINGS, options), lambda noise: predicate(Seeds(results, options, noise))
    )


@claim("c4_omni_order_mag", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
def judge_order_of_magnitude(results, options):
    """Standard over CGSP, before and after adjustment."""
    return _by_seed(results, options, order_of_magnitude)


@claim(
    "c4_fish_smaller_gap", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
def judge_smaller_gap(results, options):
    """The fisheye's ratios lie between 1 and those of the other camera."""
    return _by_seed(results, options, smaller_gap)


@claim("c4_ba_reduces", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD)
def judge_adjustment(results, options):
    """Adjustment takes 40 % of the standard error, on both cameras."""
    return _by_seed(results, options, adjustment_reduces)


@claim(
    "c4_raypoint_similar_cams",
    needs=SEEDS_OF_BOTH,
    evidence="rendered",
    readings=STANDARD,
)
def judge_similar_cameras(results, options):
    """CGSP's errors are alike on both cameras, the standard method's are not."""
    return _by_seed(results, options, similar_cameras)


@claim(
    "c4_accuracy_not_needed_ba",
    needs=SEEDS_OF_BOTH,
    evidence="rendered",
    readings=STANDARD,
)
def judge_unadjusted(results, options):
    """CGSP as it comes out against the adjusted standard method."""
    return _by_seed(results, options, unadjusted_ahead)


@claim(
    "c4_agrees_simulated", needs=WITH_SIMULATED, evidence="rendered", readings=STANDARD
)
def judge_agreement_with_simulation(results, options):
    """Ray-point errors stand in the orders that 4.1.5 simulates."""
    return _by_seed(results, options, orders_as_simulated)


@claim(
    "c4_params_fish_agree", needs=SEEDS_OF_BOTH, evidence="rendered", readings=STANDARD
)
def judge_agreement(results, options):
    """Parameters of the fisheye agree, the depth of the other camera does not."""
    return _by_seed(results, options, parameters_agree)


@claim(
    "c4_centrality_omni", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_omnidirectional_scatter(results, options):
    """Tighter by a factor of two, rounder, nearer to Gaussian."""
    return _by_seed(results, options, omnidirectional_scatter)


@claim(
    "c4_centrality_fish", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_fisheye_scatter(results, options):
    """Alike in size, and not less Gaussian with CGSP."""
    return _by_seed(results, options, fisheye_scatter)


@claim("c4_scatter_plane", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS)
def judge_plane_of_scatter(results, options):
    """No tilted plane has a smaller scatter than the one across the rays."""
    return _by_seed(results, options, compact_across)


@claim(
    "c6_centrality_both", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS
)
def judge_both_cameras(results, options):
    """The scatter is tighter with CGSP on both cameras."""
    return _by_seed(results, options, tighter_on_both)


@claim("c4_hull", needs=SEEDS_OF_BOTH, evidence="rendered", readings=SCATTERS)
def judge_hull(results, options):
    """The centre lies in the hull with CGSP, and outside without, in most seeds."""

    def share_at(noise):
        holds, *_, words = centre_in_hull(Seeds(results, options, noise))
        return proportion(holds.astype(float)), words

    def reading_at(noise):
        share, words = share_at(noise)
        return Reading.of(share.value > 0.5, share, reason=words)

    def in_most_seeds(noise):
        return share_at(noise)[0].value > 0.5

    return over_the_sweep(Case(READINGS, options), reading_at, in_most_seeds)


@claim("c4_small_misalign", needs=("exp_c4_small_misalign",), evidence="rendered")
def judge_misalignment(results):
    """CGSP's error with a bracket 1 mm off against one that is right."""
    errors = {
        offset: seeds.column("cgsp.ray_mean_mm")
        for offset, seeds in results[BRACKETS].by("offset_mm").items()
    }
    aligned = errors.pop(0.0)
    ratios = {offset: found / aligned for offset, found in errors.items()}
    words = ", ".join(
        f"{mm:g} mm {np.median(found):.2f}" for mm, found in ratios.items()
    )
    stated = ratios[STATED_MM]
    return counterpart(
        stated <= MAX_OF_ALIGNED,
        stated,
        reason=f"error over that of an aligned bracket: {words}",
    )


@claim("c4_caustic_floor", needs=("exp_c4_caustic_floor",), evidence="synthetic")
def judge_caustic(results):
    """Exact rays scatter after CGSP by no less than their caustic spreads."""
    scattered, caustic = (
        results[CAUSTIC].column(name) for name in ("scatter_mm", "caustic_mm")
    )
    over = scattered / caustic
    return counterpart(
        (caustic > 0) & (over >= 1),
        over,
        reason=f"scatter over the caustic's spread of {np.median(caustic):.2f} mm",
    )
