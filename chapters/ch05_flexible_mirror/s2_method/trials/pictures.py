"""The platter on its chessboard, photographed (Fig. 5.3)."""

from chapters.shared.mirror_pictures import platter_picture
from chapters.shared.mirror_rigs import mirror_rig
from raxel.sets.patterns import patterns_of

# Which of the monitor's pictures the platter reflects: the first of its sines.
SHOWN = "phase-x-0.png"


def platter_trial(condition, rng):
    """The picture (576, 768), uint8, of the platter that shows the monitor.

    A quarter of the camera's pixels each way, for drawing alone.
    """
    rig = mirror_rig("A", small=True)
    (shown,) = (p for p in patterns_of(rig.monitor.patterns) if p.image == SHOWN)
    T = rig.monitor_poses()[0]
    return {"picture": platter_picture(rig, rig.platter(), rng, T, shown)}
