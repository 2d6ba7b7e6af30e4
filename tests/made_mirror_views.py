"""A mirror set's views, made up: geometry A with wide pixels, nothing rendered."""

from functools import lru_cache

import numpy as np

from raxel.calibration.mirror.stages import ClampPicks, MirrorViews, StepViews
from raxel.geometry.poses import transform
from tests.mirror_scenes import (
    BOARD,
    SHEET,
    THICKNESS,
    board_pose,
    flexible_camera,
    lit_views,
    monitor_pose,
    platter_scene,
    small,
    view,
)

SHARE = 16  # of a pixel's width to that of the usual viewer
VIEWER = small(SHARE)
NOISE_PX = 0.2 / SHARE


@lru_cache
def sheet(deflection):
    """The true camera at a deflection, mm."""
    return flexible_camera(deflection, viewer=VIEWER, holder=0.0)


def board_view(deflection, T_camera_board, name, rng):
    """BoardView of 14 x 13 corners in the mirror, with noise; NaN where not seen."""
    found = view(sheet(deflection), T_camera_board, BOARD, 14, 13, rng, NOISE_PX)
    found.pixels[~VIEWER.in_image(found.pixels)] = np.nan
    return found._replace(name=name)


def edge(x, count=9):
    """Pixels (count, 2) along a line of the flat sheet, x mm from the clamp."""
    y = np.linspace(-45, 45, count)
    points = np.column_stack([np.full(count, x), y, np.zeros(count)])
    return VIEWER.project(transform(SHEET, points)).pixels


def step_views(k, pair, rng, moved_mm=0.0):
    """StepViews of step k between two deflections; moved_mm: by how much somebody
    touched the board between the images."""
    T = board_pose([5, 8, 5] * rng.standard_normal(3))
    touched = T.copy()
    touched[:3, 3] += moved_mm * (T[:3, 0] + T[:3, 2]) / np.sqrt(2)
    before = board_view(pair[0], T, f"s{k}-before", rng)
    after = board_view(pair[1], touched, f"s{k}-after", rng)
    return StepViews(before, after, pair[1] - pair[0])


def made_views(deflections=(0.0, 5.0), seed=0, far_mm=100.0):
    """MirrorViews: the monitor in two places, far_mm apart as the bent mirror shows
    it and 100 mm in the platter, and a step for each deflection."""
    rng = np.random.default_rng(seed)
    platter = [_in_wide_pixels(picture) for picture in platter_scene(rng, 0.2)[0]]
    poses = np.stack([monitor_pose(0.0), monitor_pose(far_mm)])
    grids = lit_views(sheet(0.0), poses)
    grids = [
        one._replace(name=n) for one, n in zip(grids, ("near", "far"), strict=True)
    ]
    steps = [
        step_views(k, deflections[k - 1 : k + 1], rng)
        for k in range(1, len(deflections))
    ]
    clamp = ClampPicks(edge(0.1), 0.02)
    return MirrorViews(
        VIEWER, tuple(grids), tuple(platter), THICKNESS, clamp, tuple(steps)
    )


def _in_wide_pixels(picture):
    """A FlatMirrorImage of the viewer with narrow pixels, as VIEWER takes it."""

    def wide(one):
        return one._replace(pixels=one.pixels / SHARE, sd=one.sd / SHARE)

    return picture._replace(board=wide(picture.board), grid=wide(picture.grid))
