"""Scenes in space, drawn by pyvista: pictures, and pages on which they turn.

Needs the extra `show` (`pip install raxel[show]`); `available` says whether it is here.
"""

from raxel.show.boards import board, plate, polygon
from raxel.show.cameras import (
    axes,
    camera_scene,
    caustics,
    field_of_view,
    frustum,
    mirrors,
    moved,
    rays,
)
from raxel.show.page import html
from raxel.show.picture import picture, picture_array
from raxel.show.rendering import RenderingError, available
from raxel.show.rigs import rig_scene
from raxel.show.scene import (
    CLEAR,
    SAME,
    Arrows,
    Labels,
    Points,
    Polyline,
    Scene,
    SceneError,
    Segments,
    Surface,
)
from raxel.show.view import framed
