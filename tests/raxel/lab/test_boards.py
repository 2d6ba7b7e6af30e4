"""Rendered boards of rigs: light, blemishes, windows, poses around a point."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from raxel.errors import InputError
from raxel.geometry import (
    on_plane,
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from raxel.lab import (
    Crop,
    Optics,
    Sensor,
    board_scene,
    load_rig,
    mirror_in_view,
    window_of,
)
from raxel.lab.lighting import BoardLight, Shadow
from raxel.lab.target_poses import SIGHT_LINES, ListedPoses, Visibility, _mirror_points
from tests.bent_mirror_scenes import bent
from tests.raised import raises_line
from tests.raxel.lab.test_rig import MIRROR, changed, leaf

RIGS = Path(__file__).resolve().parents[3] / "data" / "rigs"
AROUND = {
    "kind": "around",
    "count": leaf(2, "1"),
    "centre": leaf([5, 0, 0], "mm"),
    "axis": leaf([0, 0.6, 0.8], "1"),
    "polar": leaf([20, 30], "deg"),
    "tilt": leaf([30, 50], "deg"),
    "subtense": leaf([30, 45], "deg"),
    "turn": leaf([0, 360], "deg"),
    "margin": leaf(2, "px"),
    "least_spacing": leaf(3, "px"),
}


def rng(seed=0):
    return np.random.default_rng(seed)


def test_around_poses_have_drawn_angles(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml", poses=AROUND))
    poses = rig.draw_poses(rng(4), 30)
    corner, size = rig.extent
    box = corner + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size
    ends = transform(poses, on_plane(box)) - [5, 0, 0]
    lines = ends / np.linalg.norm(ends, axis=2, keepdims=True)
    cosine = np.einsum("nik,njk->nij", lines, lines).min(axis=(1, 2))
    subtense = np.degrees(np.arccos(cosine))
    assert 30 <= subtense.min() < 35 < 40 < subtense.max() <= 45
    middle = ends.mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    polar = np.degrees(np.arccos(middle @ [0, 0.6, 0.8]))
    assert 20 <= polar.min() < 23 < 27 < polar.max() <= 30
    tilt = np.degrees(np.arccos(np.sum(middle * poses[:, :3, 2], axis=1)))
    assert 30 <= tilt.min() < 36 < 44 < tilt.max() <= 50


def test_target_occluding_mirror_is_rejected(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml", camera=MIRROR))
    apex = rig.camera.T_viewer_mirror[2, 3]
    towards_mirror = pose(np.diag([1.0, -1.0, -1.0]), [-15, 10, apex / 2])
    corner, size = rig.extent
    outline = corner + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size
    lattice = rig.target.points().reshape(3, 4, 2)
    fault = rig.visibility.fault(rig.camera, towards_mirror, outline, lattice)
    assert fault == "between viewer and mirror"


def test_mirror_points_cover_oblong_image():
    """No place of it is farther from one than the steps between them."""
    camera = bent(5.0)
    pixels = rng().uniform(0, [camera.width - 1, camera.height - 1], (500, 2))
    positions = camera.rays(pixels).origins
    positions = positions[np.isfinite(positions[:, 0])]
    gaps = np.linalg.norm(positions[:, None] - _mirror_points(camera), axis=2)
    step_px = (camera.width - 1) / (SIGHT_LINES - 1)
    # Half a raster's diagonal, longer on a mirror that leans, and more at the rim.
    assert gaps.min(axis=1).max() < 1.3 * step_px * 410 / 7600


def test_lighting_shades_squares_and_edges(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml"))
    T = pose(np.eye(3), [-15, -10, 110])
    laboratory = rig.laboratory()
    images = [
        laboratory.irradiance(
            board_scene(rig.target, T, 10, background=0.0, light=light), np.eye(4)
        )
        for light in (None, BoardLight(0.5, np.zeros(2), np.zeros(2)))
    ]
    np.testing.assert_allclose(images[1], 0.5 * images[0], atol=1e-6)


def test_windowed_image_equals_part_of_image(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml"))
    T = pose(np.eye(3), [-15, -10, 110])
    scene = board_scene(rig.target, T, 10)
    optics = Optics((0.5, 1.0), 300.0, ((0, 100), (1.0, 0.5)), (1.002, 1, 0.998))
    laboratory = rig.laboratory().__class__(rig.camera, rig.sensor, optics)
    window = window_of(rig, T)
    assert window.width < rig.camera.width
    whole = laboratory.irradiance(scene, np.eye(4))
    part = laboratory.irradiance(scene, np.eye(4), window=window)
    inner = 8
    rows = slice(window.v + inner, window.v + window.height - inner)
    columns = slice(window.u + inner, window.u + window.width - inner)
    # Between the few uniform blurs it interpolates, which are the part's own.
    np.testing.assert_allclose(
        part[inner:-inner, inner:-inner], whole[rows, columns], atol=5e-4
    )
    distance = optics.apply(np.ones((10, 12)), window=Crop(3, 4, 12, 10, 160, 120))
    # Where fringes reach over its border a part repeats its outermost pixels.
    whole = optics.apply(np.ones((120, 160)))
    np.testing.assert_allclose(distance, whole[4:14, 3:15], atol=1e-4)


def test_board_window_is_tight(tmp_path):
    rig = load_rig(changed(tmp_path / "rig.yaml"))
    T = pose(np.eye(3), [-15, -10, 110])
    laboratory = rig.laboratory().__class__(rig.camera, rig.sensor, Optics())
    scene = board_scene(rig.target, T, rig.border_mm, background=0.0)
    v, u = np.nonzero(laboratory.irradiance(scene, np.eye(4)))
    window = window_of(rig, T)
    for low, size, visible in (
        (window.u, window.width, u),
        (window.v, window.height, v),
    ):
        assert 10 < visible.min() - low < 20
        assert 10 < low + size - visible.max() < 20


def test_mirror_mask_equals_valid_rays():
    camera = load_rig(RIGS / "hyperboloidal.yaml").camera
    visible = mirror_in_view(camera)
    pixels = rng(1).integers(0, [camera.width, camera.height], (4000, 2))
    valid = camera.rays(pixels.astype(float)).valid
    np.testing.assert_array_equal(visible[pixels[:, 1], pixels[:, 0]], valid)


def test_jpeg_keeps_colours_and_smooths_noise(tmp_path):
    noisy = Sensor(900.0, 1000.0)
    saved = Sensor(900.0, 1000.0, jpeg=70)
    colour = np.ones((64, 64, 3)) * [0.8, 0.4, 0.1]
    one, two = (s.expose(colour, rng(1), colour=True) for s in (noisy, saved))
    np.testing.assert_allclose(two.mean(axis=(0, 1)), one.mean(axis=(0, 1)), atol=1.5)
    assert (two.std(axis=(0, 1)) < one.std(axis=(0, 1))).all()
    with pytest.raises(InputError, match="field 'jpeg': value is 300"):
        Sensor(900.0, 1000.0, jpeg=300)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"light": {"level": leaf([2, 1], "1")}}, "light.level: "),
        ({"light": {"level": leaf([1], "1")}}, "light.level.value"),
        ({"light": {"tint": leaf([1, 1, 0], "1")}}, "light.tint.value"),
        ({"light": {"shade": leaf([1, 1], "1")}}, "light.shade: "),
        ({"blemishes": {"glare": leaf([2, 0], "1")}}, "blemishes.glare: "),
        ({"poses": AROUND | {"axis": leaf([0, 0, 2], "1")}}, "poses.axis.value"),
        ({"poses": AROUND | {"polar": leaf([9, 3], "deg")}}, "poses.polar.value"),
        ({"poses": AROUND | {"distance": leaf([9, 3], "mm")}}, "poses.distance: "),
    ],
)
def test_invalid_light_and_poses_are_rejected(tmp_path, changes, message):
    path = changed(tmp_path / "rig.yaml", **changes)
    with raises_line(message):
        load_rig(path)


@pytest.mark.parametrize("across", [True, False])
def test_corner_spacing_is_checked_along_both_axes(across):
    steps = (9.0, 12.0) if across else (12.0, 9.0)
    visible = np.stack(
        np.meshgrid(steps[0] * np.arange(5), steps[1] * np.arange(4)), -1
    )
    assert Visibility(least_spacing_px=9.5)._spacing_fault(visible) == "too small"
    assert not Visibility(least_spacing_px=8.5)._spacing_fault(visible)


def test_manual_setup_errors_have_stated_deviation():
    """1 mm along each axis of its middle, and 0.2 about each of three axes."""
    T = pose(rotation_from_vector([0.3, -0.2, 0.4]), [-300.0, 50.0, 900.0])
    listed = ListedPoses(T[None], (None,), (False,), (), 1.0, 0.2)
    extent = np.array([500.0, 100.0]), np.array([200.0, 300.0])
    middle = np.array([[600.0, 250.0, 0.0]])
    rng, moved, rotated = np.random.default_rng(14), [], []
    for _ in range(400):
        found = listed.draw(rng, 1, extent, lambda _: "")[0]
        moved.append((transform(found, middle) - transform(T, middle))[0])
        rotated.append(vector_from_rotation(found[:3, :3] @ T[:3, :3].T))
    # Of 400 draws a deviation is known to 3.5 %.
    np.testing.assert_allclose(np.std(moved, axis=0), 1.0, rtol=0.15)
    np.testing.assert_allclose(np.std(rotated, axis=0), 0.2, rtol=0.15)


def test_shadow_edge_is_gaussian():
    shadow = Shadow(np.array([3.0, -2.0]), 0.4, 40.0, 5.0)
    positions = shadow.middle + (40 + 5 * np.linspace(-2, 2, 9))[:, None] * [0.6, 0.8]
    expected = 1 - 0.4 * norm.sf(np.linspace(-2, 2, 9))
    np.testing.assert_allclose(shadow.passes(positions), expected, rtol=1e-9)
