"""A film of a board in a mirror that bends: rendered, of geometry A's small rig."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror.rigs import mirror_rig
from raxel.calibration import clamp_of_camera, normalised
from raxel.cameras import PerspectiveCamera, SplineMirrorCamera
from raxel.geometry import on_plane, spline_grid, transform
from raxel.lab.set_rendering import render_board

MOST_MM = 3.0  # the board is seen up to this deflection


class Frame(NamedTuple):
    """picture (H, W) uint8; true (182, 2) px, NaN where no corner is seen."""

    picture: np.ndarray
    true: np.ndarray


class MirrorScene(NamedTuple):
    """A rig of another width, a board's pose in it, and its lattice."""

    rig: object
    T_camera_board: np.ndarray

    @property
    def size(self):
        """(columns, rows) of the board's corners."""
        return self.rig.board.columns, self.rig.board.rows

    @property
    def scene_points(self):
        """Corners (182, 3) mm, viewer's frame."""
        return transform(self.T_camera_board, on_plane(self.rig.board.points()))

    def frame(self, deflection):
        """The Frame at a deflection, mm."""
        camera = self.rig.camera(deflection)
        seed = round(1000 * deflection)
        rngs = (np.random.default_rng([seed, k]) for k in range(2))
        picture = render_board(
            replace(self.rig.rig, camera=camera), self.T_camera_board, *rngs
        )
        pixels, seen = self.rig.corners(camera, self.T_camera_board)
        return Frame(picture, np.where(seen[:, None], pixels, np.nan))

    def spline(self, deflection=0.0, room=0.08):
        """The spline nearest to the true mirror; its knots have room beyond it."""
        camera = self.rig.camera(deflection)
        u, v = np.meshgrid(*(np.arange(0, n, n // 50) for n in self._pixels))
        pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
        points = camera.rays(pixels).origins
        there = np.isfinite(points[:, 0])
        p = normalised(camera.viewer, pixels[there])
        middle = p.mean(axis=0)
        grid = spline_grid(middle + (1 + room) * (p - middle))
        return SplineMirrorCamera.fitted(camera.viewer, grid, points[there])

    def clamp(self, camera):
        """The Clamp that a spline has at the true clamp's pixels."""
        return clamp_of_camera(camera, self.rig.clamp_pixels(self.rig.camera(0.0)))

    @property
    def _pixels(self):
        return self.rig.viewer.width, self.rig.viewer.height


def film_scene(width):
    """The MirrorScene in pictures that are `width` px wide and 3/4 as high."""
    rig = mirror_rig("A", small=True)
    seen = rig.viewer
    share = width / seen.width
    K = seen.K.copy()
    K[:2] *= share
    K[:2, 2] = (seen.K[:2, 2] + 0.5) * share - 0.5
    viewer = PerspectiveCamera(K, seen.radial, width, 3 * width // 4)
    fields = rig.rig.camera.arguments() | {"viewer": viewer}
    camera = type(rig.rig.camera)(**fields)
    rig = replace(rig, rig=replace(rig.rig, camera=camera))
    rng = np.random.default_rng(0)
    return MirrorScene(rig, rig.board_pose(rng, deflections=(0.0, MOST_MM)))
