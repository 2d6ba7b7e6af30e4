"""What is worked out some rows at a time, to bound memory, is what it is at once.

Blocks are so large that a test's few points make one; so they are made small here, and
of a size that divides nothing.
"""

from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration import (
    adjust_consistent,
    rays_from_known_motion,
    relax_centrality,
)
from raxel.calibration.smooth.table import _displacements
from raxel.cameras import GeneralCamera
from raxel.cameras.core.smooth_rays import SmoothRays
from raxel.cameras.tables.general import TableInverse
from raxel.geometry.poses import pose, rotation_from_vector
from raxel.lab.set_rendering import points_seen
from raxel.multiview.plane_points import plane_locations
from raxel.multiview.views import PerspectiveView, source_pixels
from tests.calibration_scenes import scene
from tests.camera_zoo import ZOO
from tests.lab_cameras import EVERY, H, W
from tests.raxel.calibration.test_correspondence import view as board_view

RNG = np.random.default_rng(11)
SPHERE, FISHEYE = EVERY["sphere"][0], EVERY["stereographic"][0]
PLANE = pose(rotation_from_vector([0.1, -0.2, 0.3]), [-30.0, -20, 150])
PIXELS = RNG.uniform(0, [W - 1, H - 1], (90, 2))
INSIDE = RNG.uniform(0, [29, 19], (50, 2))
BLANK = np.zeros((H, W), np.uint8)


def in_view(camera, pixels=PIXELS, far=300.0):
    rays = camera.rays(pixels)
    return (rays.origins + far * rays.directions)[rays.valid]


def small_table():
    """A non-central table of 30 x 20 pixels, taken from the middle of a mirror."""
    part = SimpleNamespace(
        width=30,
        height=20,
        central=False,
        rays=lambda pixels: SPHERE.rays(pixels + [85.0, 70.0]),
    )
    return GeneralCamera.from_camera(part)


def rays_of_table():
    table = small_table()
    return table.directions, table.origins, table.mask


def searched():
    """The complete search, as for points on which the walk gave up."""
    table = small_table()
    inverse = TableInverse(table._table)
    inverse._tree = None
    return inverse.project(in_view(table, INSIDE))


def view():
    K = np.array([[60.0, 0, 24.5], [0, 60, 19.5], [0, 0, 1]])
    return PerspectiveView(K, np.eye(3), np.zeros(3), 50, 40)


def free_lines():
    centre, T, _, points = scene(3, grids=4, count=60)
    noisy = points + np.random.default_rng(3).normal(0, 0.01, points.shape)
    central = adjust_consistent(noisy, None, centre, T, sigma=0.01)
    lines = relax_centrality(noisy, central, iterations=3)
    return lines.T_base_grid, lines.directions, lines.origins


def known_motion():
    _, T, _, points = scene(3, grids=4, count=60)
    points = points + np.random.default_rng(4).normal(0, 0.01, points.shape)
    return tuple(rays_from_known_motion(points, T))


CASES = {
    "rays of a table": ("raxel.cameras.tables.general.BLOCK", 70, rays_of_table),
    "a table's pixels": (
        "raxel.cameras.tables.general.BLOCK",
        7,
        lambda: (table := small_table()).project(in_view(table, INSIDE)).pixels,
    ),
    "a table searched": ("raxel.cameras.tables.general.SEARCH_BLOCK", 7, searched),
    "a lens undone": (
        "raxel.cameras.lenses.plane_map.BLOCK",
        7,
        lambda: ZOO["brown"].rays(3 * PIXELS).directions,
    ),
    "reflections": (
        "raxel.cameras.mirrors.curved.BLOCK",
        7,
        lambda: SPHERE.project(in_view(SPHERE)).pixels,
    ),
    "smooth rays": (
        "raxel.cameras.core.smooth_rays.TILE_BLOCK",
        3,
        lambda: tuple(
            SmoothRays(FISHEYE).grid(np.arange(0.0, W, 3), np.arange(0.0, H, 3))
        ),
    ),
    "an undistorted view": (
        "raxel.multiview.views.BLOCK",
        170,
        lambda: source_pixels(FISHEYE, view()),
    ),
    "places on a plane": (
        "raxel.multiview.plane_points.PIXELS_AT_ONCE",
        7 * W,
        lambda: plane_locations(FISHEYE, BLANK, PLANE),
    ),
    "places on a monitor": (
        "raxel.lab.set_rendering.PIXELS_PER_BLOCK",
        7 * W,
        lambda: points_seen(FISHEYE, PLANE, (200.0, 150.0)),
    ),
    "pixels located": (
        "raxel.calibration.views.correspondence.BLOCK",
        7,
        lambda: board_view().locate(PIXELS),
    ),
    "whole pixels located": (
        "raxel.calibration.views.correspondence.BLOCK",
        70,
        lambda: board_view().whole_pixels(300, 240, 3),
    ),
    "known motion": ("raxel.calibration.generic.known_motion.BLOCK", 7, known_motion),
    "free lines": ("raxel.calibration.adjust.free_lines.BLOCK", 7, free_lines),
    "displacements": (
        "raxel.calibration.smooth.table.BLOCK",
        7,
        lambda: _displacements(FISHEYE, PLANE, PIXELS, FISHEYE.rays(PIXELS)[1]),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_block_size_does_not_change_results(name, monkeypatch):
    constant, size, work = CASES[name]
    whole = work()
    module, _, attribute = constant.rpartition(".")
    assert getattr(import_module(module), attribute) > 20 * size
    monkeypatch.setattr(import_module(module), attribute, size)
    again = work()
    pairs = (
        zip(whole, again, strict=True) if isinstance(whole, tuple) else [(whole, again)]
    )
    for one, other in pairs:
        assert np.isfinite(np.asarray(one, float)).any()
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)
