"""Scenes in space, drawn by pyvista: pictures, and pages on which they turn.

Needs the extra `show` (`pip install raxel[show]`).
`rendering_missing` returns what pictures need and is missing.
Ready-made scenes: `camera_scene` here, `rigs.rig_scene` and `sets.set_scene`.
"""

from raxel.io.rendering import RenderingError, rendering_missing
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
from raxel.show.rendering import html, picture, picture_array
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
from raxel.show.view import board, framed, plate, polygon

__all__ = [
    "CLEAR",
    "SAME",
    "Arrows",
    "Labels",
    "Points",
    "Polyline",
    "RenderingError",
    "Scene",
    "SceneError",
    "Segments",
    "Surface",
    "axes",
    "board",
    "camera_scene",
    "caustics",
    "field_of_view",
    "framed",
    "frustum",
    "html",
    "mirrors",
    "moved",
    "picture",
    "picture_array",
    "plate",
    "polygon",
    "rays",
    "rendering_missing",
]
