"""Results of section 5.1 and the numbers that its page quotes."""

import numpy as np

from chapters.ch05_flexible_mirror.s1_model.trials.plane import ANCHORS
from chapters.ch05_flexible_mirror.s1_model.trials.splines import SHAPE
from repro.page.reader import value
from repro.run.readings import Case

BEAM = {
    "beam_compared": {
        "bent to the same deflection": "same_deflection",
        "by the same force": "same_force",
    }
}
# Squared slopes: the largest that the thesis states, and that of its usual deflection.
SMALL = 0.036
USUAL = 0.0036
MIN_PAIRS = -(-(SHAPE[0] * SHAPE[1] - 1) // 2)
"""ceil((K_f K_g - 1) / 2), two equations from each pair of rays (E-5.07)."""
OFF_ANCHOR = [number for number, factor in enumerate(ANCHORS) if factor != 1.0]


def compared_beams(result, options=None):
    """Differences (levels,) of elastica and cubic in a reading, and their levels."""
    name = Case(BEAM, options)["beam_compared"]
    levels = result.levels("slope2")
    found = [float(result.column(name, slope2=level)[0]) for level in levels]
    return np.array(levels), np.array(found)


def slope_over(result, key, name):
    """Log-log slope of a value over a condition's ``key``, and the values."""
    levels = result.levels(key)
    found = [float(np.mean(result.column(name, **{key: at}))) for at in levels]
    return float(np.polyfit(np.log(levels), np.log(found), 1)[0]), found


def rank_range(result, kind, pairs):
    """Smallest and largest rank over the trials of a number of pairs."""
    ranks = result.column(kind, pairs=pairs)
    return int(ranks.min()), int(ranks.max())


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, number in quoted(open_results).items():
        value(name, number)


def quoted(open_results):
    """Name -> number, of what the prose quotes."""
    levels, found = compared_beams(open_results("exp_c5_beam_cubic"))
    shapes = open_results("exp_c5_shape_ambiguity")
    pairs = open_results("exp_c5_min_pairs")
    edges = open_results("exp_c5_edge_refine")
    usual, at_end = (
        float(found[np.argmin(abs(levels - slope2))]) for slope2 in (USUAL, SMALL)
    )
    return {
        "beam.usual": 100 * usual,
        "beam.end": 100 * at_end,
        "shapes.off": min(
            shapes.column(f"anchor_{n}.beyond_scale_mm")[0] for n in OFF_ANCHOR
        ),
        "pairs.random": float(np.median(pairs.column("random", pairs=MIN_PAIRS))),
        **{
            f"edge.{name}": float(np.nanmedian(edges.column(f"{name}_mm")))
            for name in ("pick.picked", "pick.refined")
        },
    }
