"""Rigs with a ball of facets before their viewer."""

import numpy as np
import pytest
import yaml

from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector
from raxel.lab.rig import load_rig
from tests.raxel.lab.test_rig import leaf, small_rig


def mirror_ball(path, **camera):
    """Write the small rig with a ball of facets before its fisheye."""
    data = small_rig()
    data["camera"] = {
        "kind": "planar mirrors",
        "viewer": data["camera"],
        "ball_radius": leaf(60, "mm"),
        "distance": leaf(150, "mm"),
        "facet_size": leaf(18, "mm"),
        "gap": leaf(2, "mm"),
        "cap": leaf(60, "deg"),
        "tilt_sd": leaf(1, "deg"),
    } | camera
    data["target"] = {
        "kind": "active_grid",
        "monitor_px": leaf([160, 120], "px"),
        "monitor_mm": leaf([160, 120], "mm"),
        "gamma": leaf(2.2, "1"),
        "gray_bits": leaf([3, 3], "1"),
    }
    pose = {
        "translation": leaf([80, -60, -20], "mm"),
        "rotation": leaf([0, 180, 0], "deg"),
    }
    data["poses"] = {
        "kind": "listed",
        "margin": leaf(0, "px"),
        "least_spacing": leaf(0, "px"),
        "list": [pose],
    }
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def test_facet_ball_is_in_front_of_viewer(tmp_path):
    camera = load_rig(mirror_ball(tmp_path / "ball.yaml")).camera
    assert camera.kind == "planar mirrors"
    assert camera.facets > 20
    middles = camera.T_viewer_facets[:, :3, 3]
    np.testing.assert_allclose(np.linalg.norm(middles - [0, 0, 210], axis=1), 60)


def test_facets_have_stated_poses(tmp_path):
    path = mirror_ball(tmp_path / "facets.yaml")
    data = yaml.safe_load(path.read_text("utf-8"))
    T = pose(rotation_from_vector(np.array([0.1, 3.0, 0])), [5, -10, 200])
    square = [[-40, -30], [40, -30], [40, 30], [-40, 30]]
    data["camera"] = {
        "kind": "planar mirrors",
        "viewer": data["camera"]["viewer"],
        "T_viewer_facets": leaf([T.tolist()], "1"),
        "outlines": leaf([square], "mm"),
    }
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    camera = load_rig(path).camera
    np.testing.assert_allclose(camera.T_viewer_facets, T[None], atol=1e-12)
    np.testing.assert_array_equal(camera.outlines[0], square)


@pytest.mark.parametrize(
    ("field", "entry", "words"),
    [
        ("gaps", leaf(2, "mm"), "camera.gaps: "),
        ("cap", leaf(60, "1"), "camera.cap.unit: .*'deg'"),
        ("gap", leaf(-1, "mm"), "camera.gap: .* -1"),
    ],
)
def test_invalid_ball_is_rejected(tmp_path, field, entry, words):
    path = mirror_ball(tmp_path / "ball.yaml", **{field: entry})
    with pytest.raises(InputError, match=words):
        load_rig(path)


def test_facet_camera_requires_visible_monitor(tmp_path):
    rig = load_rig(mirror_ball(tmp_path / "ball.yaml"))
    visible = pose(rotation_from_vector(np.array([0, np.pi, 0])), [80, -60, -20])
    assert rig.shows(visible)
    assert not rig.shows(pose(np.eye(3), [-80, -60, 400]))
    assert not rig.shows(pose(np.eye(3), [-80, -60, -20]))


def test_chessboard_with_facets_is_rejected(tmp_path):
    path = mirror_ball(tmp_path / "ball.yaml")
    data = yaml.safe_load(path.read_text("utf-8")) | {"target": small_rig()["target"]}
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.raises(InputError, match=r"target.kind"):
        load_rig(path)
