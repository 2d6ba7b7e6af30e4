"""Windows of rig images, and measurements in the images of the mirror rigs."""

from dataclasses import replace

import numpy as np
import pytest

from chapters.shared.mirror.images import (
    MirroredBoard,
    grid_image,
    platter_camera,
    platter_window,
)
from chapters.shared.mirror.rigs import mirror_rig
from chapters.shared.rigs import rig_named
from raxel.errors import InputError
from raxel.geometry import pose
from raxel.lab import board_scene
from raxel.lab.optics import (
    MARGIN_PX,
    Crop,
    bands,
    mirror_window,
    window_around,
    windowed,
)
from tests.raised import raises_code


def test_window_equals_part_of_whole_image():
    rig = rig_named("ordinary-lens")
    scene = board_scene(rig.target, rig.draw_poses(np.random.default_rng(0), 1)[0])
    size = rig.camera.width, rig.camera.height
    window = Crop(size[0] // 2, size[1] // 6, 160, 120, *size)
    whole = rig.laboratory().irradiance(scene, np.eye(4), window=window)
    part = windowed(rig, window)
    again = part.laboratory().irradiance(scene, np.eye(4))
    np.testing.assert_allclose(again, whole, atol=2e-5)
    pixels = np.array([[3.0, 5.0], [100.5, 80.0]])
    rays = part.camera.rays(pixels)
    there = rig.camera.rays(pixels + [window.u, window.v])
    np.testing.assert_array_equal(rays.directions, there.directions)
    back = part.camera.project(rays.directions * 500).pixels
    np.testing.assert_allclose(back, pixels, atol=1e-9)
    assert windowed(rig, window).camera is part.camera


def test_window_contains_its_content():
    camera = mirror_rig("A").camera(15.0)
    window = mirror_window(camera)
    u, v = (np.linspace(0, n - 1, 61) for n in (camera.width, camera.height))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    seen = pixels[camera.rays(pixels).valid]
    first = np.array([window.u, window.v])
    assert np.all((seen > first) & (seen < first + [window.width, window.height] - 1))
    with raises_code("outside-image"):
        window_around(camera, np.array([[-500.0, 10.0], [np.nan, np.nan]]))
    size = camera.width, camera.height
    assert window_around(camera, np.array(size)[None] - 1.0) == Crop(
        *(n - 1 - MARGIN_PX for n in size), *2 * [1 + MARGIN_PX], *size
    )
    parts = bands(window, 10, 24)
    assert [part.height for part in parts] == [24] * 10
    assert parts[0].v > window.v
    assert parts[-1].v + 24 < window.v + window.height
    with pytest.raises(InputError, match="100 of 24 rows"):
        bands(window, 100, 24)


def test_window_decoding_uses_whole_image_pixels():
    rig = mirror_rig("A")
    camera = rig.camera(5.0, aberration_um=10, seed=1)
    (band,) = bands(mirror_window(camera), 1, 40)
    near, _ = rig.monitor_poses()
    found = grid_image(rig, camera, near, [0, 1], band)
    assert len(found.pixels) > 40_000
    assert found.pixels[:, 1].min() >= band.v
    error = found.points_mm - found.truth_mm
    assert np.sqrt(np.mean(error**2)) < 0.08
    rays = camera.rays(found.pixels[::500])
    depth = (near[:3, 3] - rays.origins) @ near[:3, 2] / (rays.directions @ near[:3, 2])
    points = rays.origins + depth[:, None] * rays.directions
    on_monitor = (points - near[:3, 3]) @ near[:3, :2]
    np.testing.assert_allclose(on_monitor, found.truth_mm[::500], atol=1e-4)


def test_corner_search_stays_inside_mirror():
    """Squares of 40 px, 195 px wide, in an image that is dark around them."""
    v, u = np.mgrid[0:280, 0:280]
    squares = ((u + 20) // 40 + (v + 20) // 40) % 2 * 140 + 60
    inside = (u >= 45) & (u < 240) & (v >= 40) & (v < 240)
    result = np.where(inside, squares, 5).astype(np.uint8)
    taken = MirroredBoard(result, Crop(1000, 500, 280, 280, 3072, 2304))
    corners = np.array([[139.5, 99.5], [179.5, 139.5], [59.5, 139.5], [500, 10]])
    found = taken.corners(corners + [1004, 499])
    np.testing.assert_allclose(found[0], corners[0] + [1000, 500], atol=0.02)
    # The third is 15 px from the border: looked for from farther in, yet not taken.
    np.testing.assert_array_equal(np.isfinite(found[:, 0]), [True, True, False, False])
    assert np.isnan(taken.corners(np.array([[1239.5, 639.5]]))).all()


def test_flat_mirror_shows_monitor_in_window():
    rig = mirror_rig("B")
    platter = rig.platter()
    camera, window = platter_camera(rig, platter), platter_window(rig, platter)
    rng = np.random.default_rng(0)
    low = np.array([window.u, window.v])
    rays = camera.rays(low + rng.uniform(0, [window.width, window.height], (2000, 2)))
    ring = np.pi * (platter.radius_mm**2 - platter.hub_mm**2)
    box = (2 * platter.radius_mm) ** 2
    assert rays.valid.mean() == pytest.approx(ring / box, rel=0.12)
    in_disc = (rays.origins - platter.T_camera_mirror[:3, 3])[rays.valid]
    radius = np.linalg.norm(in_disc, axis=1)
    assert radius.min() > platter.hub_mm - 0.01
    assert radius.max() < platter.radius_mm + 0.01
    face = platter.T_camera_board @ pose(np.eye(3), [0, 0, -platter.thickness_mm])
    np.testing.assert_allclose(in_disc @ face[:3, 2], 0, atol=1e-9)
    assert replace(rig.monitor, camera=camera).shows(rig.monitor_poses()[0])
