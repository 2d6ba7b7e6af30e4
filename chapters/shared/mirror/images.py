"""Rendered images of the two rigs of chapter 5, and the points found in them.

Only the window of the image that the mirror fills is rendered; all pixels that go in
and come out are those of the whole image of 3072 x 2304. Nothing is kept on disk.
"""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from raxel.cameras import PlanarMirrorsCamera
from raxel.features.active_grid import decode
from raxel.features.localise import saddle_point
from raxel.geometry import on_plane, pose, transform
from raxel.lab import (
    Disc,
    Laboratory,
    MonitorPattern,
    Plain,
    Rectangle,
    TexturedScene,
    board_scene,
    mirror_window,
    monitor_scene,
    points_seen,
    render_board,
    render_patterns,
    window_around,
    windowed,
)
from raxel.sets import BLACK, WHITE

# Half of the platter's ring as a polygon: corners along each of its two arcs.
ARC = 90
# The plate that board and platter are fixed to: radiance, and mm beyond the platter.
PLATE, PLATE_MARGIN_MM = 0.25, 4.0
# A corner is looked for in a window this wide, px; it has to be in the mirror whole,
# and beyond that nothing is lit: darker than this share of white, when smoothed.
CORNER_WINDOW, DARK, SMOOTH_PX = 31, 0.15, 2.0


class MirroredBoard(NamedTuple):
    """Its pixels (h, w) uint8, and its window, a `Crop` of the whole image."""

    image: np.ndarray
    window: tuple

    def corners(self, near):
        """Corners (N, 2) px found next to places (N, 2), NaN where no corner is found.

        The saddle points of the grey values (3.1.3). A place whose window reaches
        beyond the mirror has none, for what is seen there draws the corner aside.
        """
        first = np.array([self.window.u, self.window.v], float)
        found = np.full(np.shape(near), np.nan)
        place = near - first
        rows = np.flatnonzero(self._all_lit(place))
        got = saddle_point(self.image, place[rows], window=CORNER_WINDOW)
        there = got.converged & self._all_lit(got.corners)
        found[rows[there]] = got.corners[there] + first
        return found

    def _all_lit(self, place):
        """Whether windows about places (N, 2) of the image show the mirror alone."""
        height, width = self.image.shape
        at = np.rint(np.nan_to_num(place, nan=-1)).astype(int)
        inside = np.all((at >= 0) & (at < [width, height]), axis=1)
        soft = cv2.GaussianBlur(self.image, (0, 0), SMOOTH_PX)
        lit = (soft > DARK * np.quantile(soft, 0.99)).astype(np.uint8)
        reach = np.ones((CORNER_WINDOW + 2,) * 2, np.uint8)
        whole = cv2.erode(lit, reach, borderValue=0).astype(bool)
        inside[inside] = whole[at[inside, 1], at[inside, 0]]
        return inside


class MirroredGrid(NamedTuple):
    """Decoded points of a monitor's patterns, in one window of the image.

    pixels: (n, 2) decoded ones, of the whole image; points_mm: (n, 2) what they see of
    the monitor; sigma_mm: (n, 2) the decoder's own standard deviations; truth_mm: (n,
    2), for scoring and for the levels' noise alone. A pixel that was decoded though
    its own middle looks past the monitor or the mirror is left out.
    """

    pixels: np.ndarray
    points_mm: np.ndarray
    sigma_mm: np.ndarray
    truth_mm: np.ndarray


def board_image(rig, camera, T_camera_board, rng):
    """The `MirroredBoard` of a board of a `MirrorRig` by one of its cameras."""
    window = mirror_window(camera)
    taken = windowed(replace(rig.rig, camera=camera), window)
    return MirroredBoard(render_board(taken, T_camera_board, rng, rng), window)


def grid_image(rig, camera, T_camera_monitor, seed, window=None):
    """The `MirroredGrid` of the monitor of a `MirrorRig` in one pose.

    camera: one of the rig's, or `platter_camera`; seed: list of whole numbers; window:
    a `Crop`, all that the flexible mirror fills if not given (`raxel.lab.optics.
    bands` gives thinner ones).
    """
    window = mirror_window(camera) if window is None else window
    taken = windowed(replace(rig.monitor, camera=camera), window)
    exposures = dict(render_patterns(taken, T_camera_monitor, seed))
    white, black = exposures.pop(WHITE), exposures.pop(BLACK)
    target = taken.target
    images = np.array(list(exposures.values()))
    found = decode(
        images, list(exposures), target, white=white, black=black, linear=True
    )
    true = points_seen(taken.camera, T_camera_monitor, target.monitor_mm)
    rows, columns = np.nonzero(found.mask & np.isfinite(true[..., 0]))
    pixels = np.column_stack([columns + window.u, rows + window.v]).astype(float)
    fields = found.location, found.sigma, true
    return MirroredGrid(
        pixels, *(field[rows, columns].astype(float) for field in fields)
    )


def scene_image(rig, camera, scene, T_world_camera, rng):
    """The image (h, w) of a TexturedScene in the mirror, where the sheet of stage 0
    fills the image."""
    window = mirror_window(rig.camera(0.0))
    taken = windowed(replace(rig.rig, camera=camera), window)
    return taken.laboratory().render(scene, T_world_camera, rng)


def platter_camera(rig, platter):
    """The camera that sees the world in a `Platter`, its ring in two halves."""
    angle = np.linspace(0, np.pi, ARC)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    half = np.concatenate([platter.radius_mm * arc, platter.hub_mm * arc[::-1]])
    return PlanarMirrorsCamera(rig.viewer, [platter.T_camera_mirror] * 2, [half, -half])


def platter_window(rig, platter):
    """The `Crop` of the image that the platter fills."""
    angle = np.linspace(0, 2 * np.pi, ARC)
    rim = platter.radius_mm * np.column_stack([np.cos(angle), np.sin(angle)])
    points = transform(platter.T_camera_mirror, on_plane(rim))
    return window_around(rig.viewer, rig.viewer.project(points).pixels)


def platter_image(rig, platter, rng, T_camera_monitor=None, pattern=None):
    """The whole image (H, W) of a platter on its chessboard (Fig. 5.3b).

    The room's light is on the board; the platter shows the monitor, where its pose
    (4, 4) and a `raxel.sets.Pattern` are given, else a dark room.
    """
    paper = rig.rig.radiances | {"border_mm": rig.rig.border_mm}
    scene = board_scene(platter.board, platter.T_camera_board, **paper)
    ring = Disc(platter.T_camera_mirror, platter.radius_mm, platter.hub_mm)
    parts = (ring, Plain(0.0)), *scene.parts, (_plate(platter), Plain(PLATE))
    scene = replace(scene, parts=parts)
    light = _light(rig, rig.viewer, scene)
    if pattern is not None:
        target = rig.monitor.target
        size = target.monitor_px, target.monitor_mm
        shown = MonitorPattern(*size, pattern, rig.monitor.monitor.radiance)
        shown = monitor_scene(target, T_camera_monitor, shown, **rig.monitor.radiances)
        light = light + _light(rig, platter_camera(rig, platter), shown)
    return rig.rig.sensor.expose(light, rng, colour=False)


def _plate(platter):
    """The plate behind board and platter, a hair behind the board's sheet."""
    low = platter.centre_mm - platter.radius_mm - PLATE_MARGIN_MM
    size = np.full(2, 2 * (platter.radius_mm + PLATE_MARGIN_MM))
    behind = platter.T_camera_board @ pose(np.eye(3), [0, 0, 1e-3])
    return Rectangle(behind, *size, low)


def _light(rig, camera, scene: TexturedScene):
    laboratory = Laboratory(camera, rig.rig.sensor, rig.rig.optics)
    return laboratory.irradiance(scene, np.eye(4))
