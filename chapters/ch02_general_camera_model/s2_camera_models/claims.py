"""The claim of section 2.2.2: no plane in front of 180 degrees."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.results import feasible_shares
from chapters.ch02_general_camera_model.s2_camera_models.trials.planes import FOVS_DEG
from repro.run.experiment import claim
from repro.run.outcomes import Reading


@claim("c2_fov180", needs=("exp_c2_fov180",), evidence="analytic")
def judge_fov180(results):
    """Infeasible from 180 degrees on, feasible below, in every trial."""
    shares = feasible_shares(results["exp_c2_fov180"])
    below = np.array(FOVS_DEG) < 180
    verdict = "differs"
    if not np.isfinite(shares).all():
        verdict = "undecided"
    elif (shares[below] == 1).all() and (shares[~below] == 0).all():
        verdict = "reproduced"
    feasible = [fov for fov, share in zip(FOVS_DEG, shares, strict=True) if share > 0]
    reason = "share of trials with a plane: " + ", ".join(
        f"{share:.2f} at {fov} deg" for fov, share in zip(FOVS_DEG, shares, strict=True)
    )
    if verdict == "reproduced":
        reason = (
            "with both ends of a diameter of the rim among the rays, the "
            "programme has no solution from 180 deg on"
        )
    return Reading(
        verdict,
        "a plane up to "
        f"{max(feasible, default=0)} deg, none from "
        f"{min((f for f in FOVS_DEG if f not in feasible), default=0)} "
        "deg on",
        reason=reason,
    )
