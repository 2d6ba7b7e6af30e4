"""The claims about the synthetic plane, tested as the ledger words them."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import (
    TABLE_MEASURES,
    ratio,
    ratio_reading,
)
from chapters.ch04_central_generic.s2_pose.trials.planes import TILTS_DEG
from repro.judge.statistics import all_of, wins
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

EXACT = 1e-8
PLANE_RAYS = {"those that all planes see": "common", "all that a plane sees": "own"}


@claim(
    "c4_plane_orientation", needs=("exp_c4_plane_orientation",), evidence="synthetic"
)
def judge_orientation(results):
    """The best plane not worse than one at 30 deg, better than at 60."""
    result, out = results["exp_c4_plane_orientation"], []
    for option, kind in PLANE_RAYS.items():
        decisions, ratios = [], []
        for measure in TABLE_MEASURES:
            best, thirty, sixty = (
                result.column(f"{kind}.{tilt}.{measure}") for tilt in (0, 30, 60)
            )
            ratios.append(ratio(thirty, best))
            decisions += [ratios[-1].above(1.0), wins([(best, sixty)])[0].decision]
        out.append(
            ratio_reading(
                all_of(decisions),
                min(ratios, key=lambda r: r.value),
                "error at 30 degrees over that of the best plane, the "
                "smaller ratio of rotation and translation; at 60 degrees "
                + (
                    "the best plane wins in both"
                    if decisions[1] == decisions[3] == "holds"
                    else "it does not win in both"
                ),
                {"plane_rays": option},
            )
        )
    return out


@claim("c4_plane_free", needs=("exp_c4_plane_free",), evidence="analytic")
def judge_free(results):
    """Without noise an exact pose on planes at every tilt."""
    result = results["exp_c4_plane_free"]
    shift, turn = (
        max(
            scale * result.column(f"{kind}.{tilt}.{measure}").max()
            for kind in PLANE_RAYS.values()
            for tilt in TILTS_DEG
        )
        for measure, scale in (("translation_mm", 1.0), ("rotation_deg", np.pi / 180))
    )
    return [
        Reading(
            DECISIONS["holds" if max(shift, turn) < EXACT else "fails"],
            float(shift),
            unit="mm",
            reason="largest error of a translation over all tilts and "
            f"scenes; of a rotation {turn:.1g} rad",
        )
    ]
