"""Number of corners that both images of a deflection show."""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig

# How far the mirror goes, mm: back from stage 3, as in the thesis's large deflection,
# and out from stage 0.
DEFLECTIONS_MM = (2.5, 5.0, 7.5, 10.0, 12.5, 15.0)


def losses_trial(condition, rng):
    """Corners (deflections,) that are visible before and after, of a board in a random
    pose that the mirror shows before the deflection: `back` and `out`."""
    rig = mirror_rig(condition["geometry"])
    ways = {
        "back": (STAGES_MM[-1], [STAGES_MM[-1] - mm for mm in DEFLECTIONS_MM]),
        "out": (STAGES_MM[0], [STAGES_MM[0] + mm for mm in DEFLECTIONS_MM]),
    }
    found = {}
    for way, (start, ends) in ways.items():
        T = rig.board_pose(rng, deflections=(start,))
        _, before = rig.corners(rig.camera(start), T)
        after = [rig.corners(rig.camera(end), T)[1] for end in ends]
        found[way] = np.array([np.count_nonzero(before & seen) for seen in after])
    return found
