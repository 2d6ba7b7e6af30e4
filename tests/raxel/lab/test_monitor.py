"""A rig's monitor: fast images of patterns, its chessboard, poses set up by hand."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from lab_cameras import EVERY
from raxel.cameras import load_camera, pixel_grid
from raxel.errors import InputError
from raxel.features.active_grid import decode
from raxel.features.localise import saddle_point
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.io.files import read_json
from raxel.lab import MonitorLevel, MonitorPattern, load_rig, monitor_scene, trace
from raxel.lab.set_rendering import MonitorSight, points_seen, render_set
from raxel.sets import (
    ActiveGrid,
    ImageSet,
    Pattern,
    View,
    chessboard_image,
    load_set,
    patterns_of,
    read_image,
    write_set,
)
from raxel.sets.model import MonitorChessboard
from raxel.sets.patterns import chessboard_of_corners
from tests.raised import raises_line
from tests.raxel.lab.test_rig import leaf


def small_rig(**target):
    """Plain data of a webcam and a monitor with 8 x 8 cells and 7 x 7 corners."""
    position = {"translation": leaf([-60, -60, 210], "mm")}
    return {
        "raxel_rig": 1,
        "name": "small-monitor",
        "camera": {
            "kind": "perspective",
            "K": leaf([[190, 0, 95.5], [0, 190, 71.2], [0, 0, 1]], "px"),
            "radial": leaf([0, 0], "1"),
            "width": leaf(192, "px"),
            "height": leaf(144, "px"),
        },
        "sensor": {
            "white": leaf(240000, "e"),
            "full_well": leaf(270000, "e"),
            "bits": leaf(8, "bit"),
        },
        "target": {
            "kind": "active_grid",
            "monitor_px": leaf([160, 160], "px"),
            "monitor_mm": leaf([120, 120], "mm"),
            "gamma": leaf(2.2, "1"),
            "black_level": leaf(0.01, "1"),
            "falloff_exponent": leaf(2, "1"),
            **target,
        },
        "poses": {
            "kind": "listed",
            "margin": leaf(0, "px"),
            "least_spacing": leaf(0, "px"),
            "whole": False,
            "list": [
                {**position, "name": "near", "rotation": leaf([0, 20, 0], "deg")},
                {**position, "patterns_only": True, "rotation": leaf([0, 0, 0], "deg")},
            ],
        },
    }


BOARD = {
    "columns": leaf(7, "1"),
    "rows": leaf(7, "1"),
    "pitch": leaf(20, "px"),
    "origin": leaf([20, 20], "px"),
}
CELLS = {"cells": leaf([8, 8], "1"), "chessboard": BOARD}


def rig_of(tmp_path, data):
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump(data), "utf-8")
    return load_rig(path)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_fast_pattern_shading_matches_renderer(tmp_path, turn):
    """Pixels inside, across edges of the code, at the border, outside the monitor."""
    rig = rig_of(tmp_path, small_rig(**CELLS))
    T = pose(rotation_from_vector([0.2, turn, 0.1]), [-55, -62, 150])
    sight = MonitorSight(rig, T)
    traced = trace(rig.camera, np.eye(4), monitor_scene(rig.target, T, **rig.radiances))
    respond, size = rig.monitor.radiance, (rig.target.monitor_px, rig.target.monitor_mm)
    for pattern in patterns_of(rig.patterns):
        exact = traced.shade({0: MonitorPattern(*size, pattern, respond)})
        np.testing.assert_allclose(sight.pattern(pattern), exact, atol=2e-6)
    exact = traced.shade({0: MonitorLevel(0.5, respond)})
    np.testing.assert_allclose(sight.level(0.5), exact, atol=2e-6)
    assert 0 < np.count_nonzero(exact == exact[0, 0]) < exact.size


@pytest.mark.parametrize("name", ["perspective", "hyperboloid", "planar mirrors"])
def test_monitor_truth_matches_camera_rays(name):
    camera, size = EVERY[name][0], np.array([150.0, 110.0])
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    middle = np.flatnonzero(rays.valid)[np.count_nonzero(rays.valid) // 3]
    stage = rays.directions[middle]
    across = np.cross([0.3, 1.0, 0.2], stage)
    across /= np.linalg.norm(across)
    R = np.column_stack([across, np.cross(stage, across), stage])
    T = pose(R, rays.origins[middle] + 200 * stage - R @ [*(size / 2), 0])
    met, _, forward = intersect_rays_plane(rays.origins, rays.directions, T)
    on = forward & (rays.directions @ T[:3, 2] > 0)
    on &= ((met >= 0) & (met <= size)).all(axis=1)
    assert 100 < np.count_nonzero(on) < 0.9 * len(on)
    expected = np.where(on[:, None], met, np.nan).astype(np.float32)
    np.testing.assert_array_equal(points_seen(camera, T, size).reshape(-1, 2), expected)


def test_chessboard_and_patterns_share_pose(tmp_path):
    """Corners found in its image, looked up in the decoded grid, are its points."""
    rendered = render_set(rig_of(tmp_path, small_rig(**CELLS)), tmp_path / "set", 3)
    assert [view.label for view in rendered.views] == ["near", "pose-001"]
    assert [view.chessboard for view in rendered.views] == ["near/chessboard.png", None]
    assert len(rendered.views[0].files) == len(rendered.views[1].files) + 1
    view = rendered.views[0]
    true = read_json(tmp_path / "set" / "truth" / "corners.json")["images"]
    assert list(true) == [view.chessboard]
    true = np.array(true[view.chessboard]["corners"])
    camera = load_camera(tmp_path / "set" / "truth" / "camera.npz")
    poses = read_json(tmp_path / "set" / "truth" / "poses.json")["T_camera_target"]
    points = rendered.target.chessboard_points()
    np.testing.assert_allclose(points[[0, -1]], [[15, 15], [105, 105]])
    visible = camera.project(transform(np.array(poses["near"]), on_plane(points)))
    np.testing.assert_allclose(true, visible.pixels, atol=1e-9)
    board = read_image(rendered, view.chessboard)
    found = saddle_point(board, true + 0.7, window=9, blur_sd=1.0)
    assert found.converged.all()
    # Squares of 12 px without blur.
    assert np.sqrt(np.mean((found.corners - true) ** 2)) < 0.08
    images = np.stack([read_image(rendered, p.image) for p in view.patterns])
    decoded = decode(images, view.patterns, rendered.target)
    nearest = np.rint(true).astype(int)
    there = decoded.location[nearest[:, 1], nearest[:, 0]]
    # Half a pixel away at most, and a pixel sees some 0.8 mm.
    assert np.nanmax(np.abs(there - points)) < 0.8
    assert np.isfinite(there).all(axis=1).mean() > 0.9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cells": leaf([80, 8], "1")}, "target: cells: 80 "),
        ({**CELLS, "gray_bits": leaf([3, 3], "1")}, "gray_bits: "),
        (
            {**CELLS, "chessboard": BOARD | {"origin": leaf([10, 20], "px")}},
            r"target\.chessboard\.origin\.value: .* -10 to 150 ",
        ),
    ],
)
def test_invalid_monitor_targets_are_rejected(tmp_path, change, message):
    with raises_line(message):
        rig_of(tmp_path, small_rig(**change))


def test_monitor_chessboard_set_round_trips(tmp_path):
    phases = [
        Pattern(f"{k}.png", "x", "phase", 3, step=k, periods=8.0) for k in range(3)
    ]
    for name in ("board.png", *(phase.image for phase in phases)):
        (tmp_path / name).write_bytes(b"")
    view = View(name="a", chessboard="board.png", patterns=tuple(phases))
    board = MonitorChessboard(15, 15, 64.0, (64.0, 64.0))
    grid = ActiveGrid((1024, 1024), None, board)
    written = ImageSet("a-set", 64, 48, grid, (view,), tmp_path)
    write_set(written)
    assert load_set(tmp_path) == written
    with pytest.raises(InputError, match=r"views\[0\]\.chessboard"):
        write_set(replace(written, target=ActiveGrid((1024, 1024))))
    too_wide = replace(board, pitch_px=70.0)
    with pytest.raises(InputError, match=r"target\.chessboard: "):
        write_set(replace(written, target=ActiveGrid((1024, 1024), None, too_wide)))


def test_chessboard_image_has_corners():
    board = chessboard_of_corners((1280, 1024), 15, 15)
    assert board == MonitorChessboard(15, 15, 64.0, (192.0, 64.0))
    image = chessboard_image(board, (1280, 1024))
    assert image.shape == (1024, 1280)
    for x, y in board.points_px().astype(int):
        four = image[y - 1 : y + 1, x - 1 : x + 1]
        assert four[0, 0] == four[1, 1] != four[0, 1] == four[1, 0]
    assert np.all(image[:, :128] == 255)
    assert image[100, 200] == 255
    with pytest.raises(InputError, match="2 x 15 corners"):
        chessboard_of_corners((1280, 1024), 2, 15)
