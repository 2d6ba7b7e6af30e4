"""The claims about the synthetic plane, tested as the ledger words them."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import TABLE_MEASURES
from chapters.ch04_central_generic.s2_pose.trials.planes import TILTS_DEG
from repro.judge.statistics import HOLDS, all_of, median_ratio, wins
from repro.run.experiment import claim
from repro.run.outcomes import Reading

EXACT = 1e-8
PLANE_RAYS = {"those that all planes see": "common", "all that a plane sees": "own"}


@claim(
    "c4_plane_orientation",
    needs=("exp_c4_plane_orientation",),
    evidence="synthetic",
    readings=("plane_rays",),
)
def judge_orientation(results, options):
    """The best plane not worse than one at 30 deg, better than at 60."""
    result = results["exp_c4_plane_orientation"]
    kind, ratios, won = PLANE_RAYS[options["plane_rays"]], [], []
    for measure in TABLE_MEASURES:
        best, thirty, sixty = (
            result.column(f"{kind}.{tilt}.{measure}") for tilt in (0, 30, 60)
        )
        ratios.append(median_ratio(thirty, best, paired=True))
        won.append(wins([(best, sixty)])[0].decision)
    at_60 = "the best plane wins" if all_of(won) == HOLDS else "it does not win"
    return Reading.of(
        all_of([*won, *(found.above(1.0) for found in ratios)]),
        min(ratios, key=lambda r: r.value),
        "x",
        "error at 30 degrees over that of the best plane, the smaller ratio of "
        f"rotation and translation; at 60 degrees {at_60} in both",
    )


@claim("c4_plane_free", needs=("exp_c4_plane_free",), evidence="analytic")
def judge_free(results):
    """Without noise an exact pose on planes at every tilt."""
    result = results["exp_c4_plane_free"]
    shift, turn = (
        max(
            scale * result.column(f"{kind}.{tilt}.{measure}").max()
            for kind, tilt in product(PLANE_RAYS.values(), TILTS_DEG)
        )
        for measure, scale in (("translation_mm", 1.0), ("rotation_deg", np.pi / 180))
    )
    return Reading.of(
        max(shift, turn) < EXACT,
        float(shift),
        "mm",
        "largest error of a translation over all tilts and "
        f"scenes; of a rotation {turn:.1g} rad",
    )
