"""How many corners a deflection leaves in both pictures."""

import numpy as np

from chapters.shared.mirror_rigs import mirror_rig

# Deflections from stage 0, mm.
DEFLECTIONS_MM = (2.5, 5.0, 7.5, 10.0, 15.0, 20.0)


def losses_trial(condition, rng):
    """Corners (deflections,) that are seen before and after, of a board held by hand
    where the mirror of stage 0 shows it."""
    rig = mirror_rig(condition["geometry"])
    T = rig.board_pose(rng)
    _, before = rig.corners(rig.camera(0.0), T)
    after = [rig.corners(rig.camera(mm), T)[1] for mm in DEFLECTIONS_MM]
    return {"common": np.array([np.count_nonzero(before & seen) for seen in after])}
