"""A photograph of a board by a rig: its light, its blemishes, and only its own rays.

What lies around a board is an even background, so rays are traced where the board is
and the rest of the picture is laid in.
"""

from functools import lru_cache

import numpy as np

from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.lab.blemishes import Blemishes
from raxel.lab.lighting import Lighting
from raxel.lab.scenes import board_scene
from raxel.lab.sight import Crop
from raxel.lab.target_poses import outline_of

# Around the board's outline: blur and its repeated border pixels reach less far.
MARGIN_PX = 16
# Whether a pixel has a ray is asked of every n-th each way, for the background alone.
RAY_STEP = 8


def photograph_board(rig, T_camera_board, rng, specimen):
    """A picture of the rig's chessboard as its camera saves it.

    T_camera_board: (4, 4), the whole board in view. rng: numpy Generator of this
    picture (light, glare, noise); specimen: numpy Generator of the rig's own spots.
    Returns (H, W, 3) uint8 or uint16, red, green, blue, where the rig is coloured,
    else (H, W).
    """
    if rig.light == Lighting() and rig.blemishes == Blemishes():
        return _plain_photograph(rig, T_camera_board, rng)
    return saved(rig, light_of_board(rig, T_camera_board, rng), rng, specimen)


def light_of_board(rig, T_camera_board, rng):
    """Light on the rig's sensor, (H, W) or (H, W, 3), through clean mirror and glass.

    rng: draws the light on the board.
    """
    light = rig.light.draw(rng, rig.extent)
    scene = board_scene(
        rig.target, T_camera_board, rig.border_mm, light=light, **rig.radiances
    )
    window = window_of(rig, T_camera_board)
    mosaic = rig.sensor.bayer is not None
    part = rig.laboratory().irradiance(scene, np.eye(4), colour=mosaic, window=window)
    beside, whole = light_of_room(rig)
    if mosaic:
        beside, whole = (np.repeat(x[..., None], 3, axis=2) for x in (beside, whole))
    whole[window.place] = beside[window.place] + part
    return whole


def light_of_room(rig):
    """Light on the sensor without a board, (H, W): beside the mirror; everywhere."""
    mirror = mirror_in_view(rig.camera)
    shade = rig.optics.vignetting(rig.camera.width, rig.camera.height)
    beside = rig.light.surround * (1 - mirror) * shade
    return beside, beside + rig.radiances["background"] * mirror * shade


def saved(rig, irradiance, rng, specimen):
    """The file that light on the sensor leaves; see `photograph_board`."""
    mirror = mirror_in_view(rig.camera)
    whole = rig.blemishes.apply(irradiance, mirror, specimen, rng)
    if rig.light.coloured:
        whole = rig.light.tinted(whole)
    return rig.sensor.expose(whole, rng, colour=whole.ndim == 3)


def _plain_photograph(rig, T_camera_board, rng):
    """A picture in even light through clean glass, with every ray traced."""
    scene = board_scene(rig.target, T_camera_board, rig.border_mm, **rig.radiances)
    colour = rig.sensor.bayer is not None
    return rig.laboratory().photograph(scene, np.eye(4), rng, colour=colour)


def grey_of(picture):
    """A picture (H, W) or (H, W, 3) in grey, as OpenCV makes it grey."""
    import cv2

    return picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)


def window_of(rig, T_camera_board):
    """The `Crop` of the rig's picture that holds the whole board."""
    camera = rig.camera
    outline = on_plane(outline_of(*rig.extent))
    seen = camera.project(transform(T_camera_board, outline)).pixels
    full = np.array([camera.width, camera.height])
    low = np.clip(np.floor(seen.min(axis=0)) - MARGIN_PX, 0, full).astype(int)
    high = np.clip(np.ceil(seen.max(axis=0)) + MARGIN_PX, 0, full).astype(int)
    return Crop(*map(int, (*low, *(high - low), *full)))


@lru_cache(maxsize=8)
def mirror_in_view(camera):
    """1 where a pixel (H, W) has a ray, else 0; float32.

    Asked of a coarse grid of pixels first, then of those between unlike neighbours.
    """
    import cv2

    size = camera.width, camera.height
    u, v = (np.arange(0, n + RAY_STEP, RAY_STEP) for n in size)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2).astype(float)
    coarse = camera.rays(grid).valid.reshape(len(v), len(u)).astype(np.float32)
    # warpAffine puts node (i, j) at pixel RAY_STEP (i, j), which resize would not.
    onto = np.array([[RAY_STEP, 0, 0], [0, RAY_STEP, 0]], float)
    seen = cv2.warpAffine(coarse, onto, size)
    rows, columns = np.nonzero((seen > 0) & (seen < 1))
    rays = camera.rays(np.column_stack([columns, rows]).astype(float))
    seen[rows, columns] = rays.valid
    return seen
