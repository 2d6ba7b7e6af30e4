"""The three zoom settings of section 2.5.2: their rigs and true cameras."""

from functools import cache

from chapters.shared.rigs import rig_named

ZOOMS = (1, 2, 3)
STAGE_ZOOM, FACADE_ZOOM = 3, 2
# What the experiments with them read.
ZOOM_RIGS = (
    "data/rigs/coolpix-fce8-zoom-1.yaml",
    "data/rigs/coolpix-fce8-zoom-2.yaml",
    "data/rigs/coolpix-fce8-zoom-3.yaml",
)


@cache
def rig_of(zoom):
    """The rig of one zoom setting."""
    return rig_named(f"coolpix-fce8-zoom-{zoom}")


@cache
def simulator_of(zoom):
    """Camera, lens and sensor of one zoom setting."""
    return rig_of(zoom).laboratory()


def zoom_camera(zoom):
    """The true camera: for projecting and for scoring, not for calibrating."""
    return simulator_of(zoom).camera
