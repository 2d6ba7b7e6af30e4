"""The virtual laboratory: scenes in front of any camera, photographed.

World frame, mm. Radiance is linear; 1.0 is a white diffuse surface in full light.
"""

from raxel.lab.optics import Optics, visible_share
from raxel.lab.rendering import Traced, render, trace
from raxel.lab.rig import Laboratory, Monitor, Rig, load_rig
from raxel.lab.scene import TexturedScene
from raxel.lab.scenes import (
    MonitorLevel,
    MonitorPattern,
    board_scene,
    facade,
    monitor_scene,
    room,
)
from raxel.lab.sensor import Sensor
from raxel.lab.set_rendering import render_set
from raxel.lab.surfaces import (
    Cylinder,
    Disc,
    Hit,
    Rectangle,
    Relief,
    TracedSurface,
    box,
)
from raxel.lab.textures import (
    ChessboardTexture,
    ImageTexture,
    Panels,
    Plain,
    Stripes,
    Texture,
    Tiles,
)

__all__ = [
    "ChessboardTexture",
    "Cylinder",
    "Disc",
    "Hit",
    "ImageTexture",
    "Laboratory",
    "Monitor",
    "MonitorLevel",
    "MonitorPattern",
    "Optics",
    "Panels",
    "Plain",
    "Rectangle",
    "Relief",
    "Rig",
    "Sensor",
    "Stripes",
    "Texture",
    "TexturedScene",
    "Tiles",
    "Traced",
    "TracedSurface",
    "board_scene",
    "box",
    "facade",
    "load_rig",
    "monitor_scene",
    "render",
    "render_set",
    "room",
    "trace",
    "visible_share",
]
