"""Ready-made scenes: a chessboard, a monitor, a room, a building front."""

from raxel.lab.facade import facade
from raxel.lab.patterns import monitor_scene
from raxel.lab.room import room
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import ChessboardTexture

__all__ = ["TexturedScene", "board_scene", "facade", "monitor_scene", "room"]


def board_scene(
    chessboard,
    T_world_target,
    border_mm=None,
    black=0.05,
    white=0.9,
    background=0.4,
    light=None,
):
    """A chessboard (`raxel.sets.Chessboard`) on its sheet before an even background.

    T_world_target: pose of the board's frame (first interior corner at the origin).
    border_mm: white margin around the squares, one pitch if not given. A board of
    unknown pitch has squares of one unit. light: how much of the light reaches each
    place of the board, uv (N, 2) in mm -> (N,); None: all of it.
    """
    pitch = float(chessboard.pitch_mm or 1)
    border = pitch if border_mm is None else border_mm
    texture = ChessboardTexture(
        chessboard.columns, chessboard.rows, pitch, border, black, white, light
    )
    corner, size = texture.extent
    sheet = Rectangle(T_world_target, *size, corner)
    return TexturedScene(((sheet, texture),), background)
