"""Rendered image of the platter on its chessboard (Fig. 5.3)."""

from chapters.shared.mirror_pictures import platter_picture
from chapters.shared.mirror_rigs import mirror_rig
from raxel.sets.patterns import patterns_of

# Index of the monitor's image in the platter: the first of its sinusoids.
SHOWN = "phase-x-0.png"


def platter_trial(condition, rng):
    """Image (576, 768), uint8, of the platter that shows the monitor.

    A quarter of the camera's pixels in each direction, for drawing only.
    """
    rig = mirror_rig("A", small=True)
    (shown,) = (p for p in patterns_of(rig.monitor.patterns) if p.image == SHOWN)
    T = rig.monitor_poses()[0]
    return {"picture": platter_picture(rig, rig.platter(), rng, T, shown)}
