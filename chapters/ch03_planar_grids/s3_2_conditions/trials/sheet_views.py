"""A board rendered once, with its light changed afterwards.

Radiance is linear, and light changes little over a point spread. An image in other
light is therefore the image in full, even light times the light at the board position
that each pixel sees. Blemishes and the sensor follow, in physical order.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.grid_rigs import HARD, SETS, rig_of
from chapters.shared.lattices import clockwise
from raxel.geometry import intersect_rays_plane, on_plane, transform
from raxel.lab.board_photograph import grey_of, light_of_room, mirror_in_view, window_of
from raxel.lab.rig import Rig
from raxel.lab.scenes import board_scene
from raxel.lab.sight import Raster
from raxel.lab.target_poses import outline_of

LIGHT_LEVELS = (0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125)
CUT_PX = 24
# Blur extends less than this from the edge of a board.
EDGE_PX = 3


def level_name(level):
    """Return the key of a light level in a trial's values."""
    return f"light {level:g}".replace(".", "_")


class Sheet(NamedTuple):
    """A board in front of a rig's camera, in full and even light.

    irradiance: (h, w) or (h, w, 3) of the part of the image from pixel `first` (u,
    v) on that contains the board; uv: (h, w, 2) mm, the position on the board's
    plane that a pixel sees, also outside the board, nan where there is none;
    points: (rows, columns, 2) mm and lattice: the same in px of the whole image,
    rows and columns turning clockwise in it; specimen, exposure: seeds of the
    mirror's flaws, and of glare and noise.
    """

    rig: Rig
    T_camera_board: np.ndarray
    irradiance: np.ndarray
    first: tuple[int, int]
    uv: np.ndarray
    points: np.ndarray
    lattice: np.ndarray
    specimen: int
    exposure: int

    def place(self, points):
        """Return true pixels (N, 2) of positions on the board (N, 2), mm."""
        seen = transform(self.T_camera_board, on_plane(points))
        return self.rig.camera.project(seen).pixels


def sheet_of(set_name, rng, poses=HARD):
    """Return a board of a set (key of `grid_rigs.SETS`), with random pose and seeds.

    poses: range of the poses; that of the rig's file, or WHOLE of `grid_rigs`.
    """
    number = rng.integers(sum(count for _, count in SETS[set_name]))
    rig = rig_of(set_name, int(number), poses)
    pose = rig.draw_poses(rng, 1)[0]
    scene = board_scene(rig.target, pose, rig.border_mm, **rig.radiances)
    window = window_of(rig, pose)
    irradiance = rig.laboratory().irradiance(
        scene, np.eye(4), colour=rig.sensor.bayer is not None, window=window
    )
    columns, rows = rig.target.columns, rig.target.rows
    points = rig.target.points().reshape(rows, columns, 2)
    specimen, exposure = (int(seed) for seed in rng.integers(2**31, size=2))
    sheet = Sheet(
        rig,
        pose,
        irradiance,
        (window.u, window.v),
        _visible_positions(rig, pose, window),
        points,
        points,
        specimen,
        exposure,
    )
    lattice = sheet.place(points.reshape(-1, 2)).reshape(points.shape)
    if clockwise(lattice) is not lattice:
        points, lattice = points[:, ::-1], lattice[:, ::-1]
    return sheet._replace(points=points, lattice=lattice)


def lit_sheet(set_name, rng, poses):
    """Return a board of a set and its illumination, both drawn at random."""
    sheet = sheet_of(set_name, rng, poses)
    return sheet, sheet.rig.light.draw(rng, sheet.rig.extent)


def photograph(sheet, light):
    """Return the whole image (H, W) uint8 in a light: positions (N, 2) mm -> (N,)."""
    return _exposed(sheet, light, None)


def cut_photograph(sheet, light):
    """Return the image cropped to the board and 24 px around it, and its true lattice.

    The lattice (rows, columns, 2) is in px of the cropped image. The rest is never
    exposed, so the noise differs from that of `photograph`.
    """
    height, width = sheet.irradiance.shape[:2]
    low = np.array(sheet.first) - CUT_PX // 2
    high = np.array(sheet.first) + (width, height) + CUT_PX // 2
    camera = sheet.rig.camera
    low = np.maximum(low, 0) // 2 * 2
    high = np.minimum(high, (camera.width, camera.height))
    cut = slice(low[1], high[1]), slice(low[0], high[0])
    return _exposed(sheet, light, cut), sheet.lattice - low


def contrast(image, lattice):
    """Return the median difference of grey levels between neighbouring squares."""
    middles = (
        lattice[:-1, :-1] + lattice[1:, 1:] + lattice[:-1, 1:] + lattice[1:, :-1]
    ) / 4
    u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
    grey = image[v, u].astype(float)
    return float(np.median(np.abs(np.diff(grey, axis=1))))


def outline_px(sheet, low, high):
    """Return the true outline (100, 2) px of a rectangle of the board."""
    return sheet.place(outline_of(low, np.asarray(high) - low))


def _exposed(sheet, light, cut):
    """Return the image, or only its part `cut` (slices of rows and columns)."""
    rig = sheet.rig
    rng = np.random.default_rng(sheet.exposure)
    beside, whole = light_of_room(rig)
    if sheet.irradiance.ndim == 3:
        beside, whole = (np.repeat(x[..., None], 3, axis=2) for x in (beside, whole))
    (u, v), (height, width) = sheet.first, sheet.uv.shape[:2]
    place = slice(v, v + height), slice(u, u + width)
    whole[place] = beside[place] + _lit(sheet, light)
    mirror = mirror_in_view(rig.camera)
    specimen = np.random.default_rng(sheet.specimen)
    whole = rig.blemishes.apply(whole, mirror, specimen, rng)
    whole = whole if cut is None else whole[cut]
    if rig.light.coloured:
        whole = rig.light.tinted(whole)
    return grey_of(rig.sensor.expose(whole, rng, colour=whole.ndim == 3))


def _lit(sheet, light):
    """Return the board's part of the image in a light; the room keeps its own.

    At the edge of the board a pixel sees a mixture of paper and room, blurred by
    the lens. There the share of paper follows from the irradiance.
    """
    full, rig = sheet.irradiance, sheet.rig
    seen = np.isfinite(sheet.uv[..., 0])
    share = np.ones(seen.shape, np.float32)
    share[seen] = light(sheet.uv[seen])
    share = share.reshape(share.shape + (1,) * (full.ndim - 2))
    lens = _lens_shade(sheet).reshape(share.shape)
    white, room = (rig.radiances[name] for name in ("white", "background"))
    paper = np.clip((full / lens - room) / (white - room), 0, 1)
    at_edge = full + lens * paper * white * (share - 1)
    inside, around = (m.reshape(share.shape) for m in _inside_and_around(sheet))
    return np.where(inside, full * share, np.where(around, at_edge, full))


def _lens_shade(sheet):
    """Return the share of light (h, w) that the lens transmits, where the board is."""
    camera = sheet.rig.camera
    shade = sheet.rig.optics.vignetting(camera.width, camera.height)
    (u, v), (height, width) = sheet.first, sheet.uv.shape[:2]
    return shade[v : v + height, u : u + width]


def _inside_and_around(sheet):
    """Return pixels (h, w) certainly on the board, and those possibly on it."""
    corner, size = sheet.rig.extent
    with np.errstate(invalid="ignore"):
        on = (sheet.uv >= corner) & (sheet.uv <= corner + size)
    on = on.all(axis=2).astype(np.uint8)
    reach = np.ones((2 * EDGE_PX + 1,) * 2, np.uint8)
    return (f(on, reach) > 0 for f in (cv2.erode, cv2.dilate))


def _visible_positions(rig, T_camera_board, window):
    """Return positions (h, w, 2) mm on the board's plane that pixels see, or nan."""
    raster = Raster(rig.camera, window=window)
    rays = raster.grid(np.arange(raster.width), np.arange(raster.height))
    met = intersect_rays_plane(*rays[:2], T_camera_board).points
    return met.reshape(raster.height, raster.width, 2)
