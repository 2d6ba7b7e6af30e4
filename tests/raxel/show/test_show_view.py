"""Marks, names and directions in a scene are those of what they belong to."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera
from raxel.cli.images import _scene
from raxel.geometry.poses import pose, rotation_from_vector
from raxel.io import rendering
from raxel.show.cameras import _name, facing_sight, frustum
from raxel.show.meshes import HEAD_LENGTH, HEAD_RADIUS, _arrows
from raxel.show.rendering import THEMES, _legend_rows, _written, legend_entries
from raxel.show.scene import Points, Scene, Segments, finite_points
from raxel.show.view import _length_text

MISSING = rendering.rendering_missing()
has_pyvista = pytest.mark.skipif("pyvista" in MISSING, reason=MISSING)


def test_camera_symbol_marks_upper_side():
    K = [[100.0, 0, 49.5], [0, 100, 29.5], [0, 0, 1]]
    y = finite_points(frustum(PerspectiveCamera(K, [], 100, 60), 10.0))[:, 1]
    # Up is negative y: a quarter of the image's height above it, and nothing below.
    assert (y.max(), y.min()) == (pytest.approx(2.95), pytest.approx(-1.5 * y.max()))


def test_view_direction_shows_most_fronts():
    """Fronts look along negative z of the target, against the sight."""
    forward, back = np.eye(4), pose(rotation_from_vector([0.0, np.pi, 0.0]), [0, 0, 0])
    side = pose(rotation_from_vector([0.0, -np.pi / 2, 0.0]), [0, 0, 0])
    assert facing_sight(np.stack([forward, forward, back]))[2] > 0
    assert facing_sight(np.stack([forward, back, back]))[2] < 0
    assert facing_sight(np.stack([forward, side]))[0] < 0


def test_label_is_above_centre():
    label = _name("mirror", np.array([[0.0, -3, 10], [4, 5, 20], [1, 1, 11]]), 2.0)
    np.testing.assert_array_equal(label.points, [[2.0, -5.0, 15.0]])
    assert list(label.texts) == ["mirror"]


@pytest.mark.parametrize(
    ("length", "unit", "text"),
    [
        (500.0, "mm", "500 mm"),
        (2000.0, "mm", "2 m"),
        (2000.0, "pitches", "2000 pitches"),
    ],
)
def test_long_lengths_are_in_metres(length, unit, text):
    assert _length_text(length, unit) == text


def test_legend_uses_part_colours():
    ends = [[0.0, 0, 0]], [[1.0, 0, 0]]
    parts = [Segments(*ends, "#d55e00", "rays"), Points(ends[0], "#0072b2", "centre")]
    scene = Scene(parts, view_from=(0, 0, -5), look_at=(0, 0, 1))
    rows = _legend_rows(legend_entries(scene), 400)
    blank = np.zeros((100, 400, 3), np.uint8)
    legend = _written(scene, blank, rows, 60, THEMES["light"])[100:]
    shown = set(map(tuple, legend.reshape(-1, 3).tolist()))
    assert {(0xD5, 0x5E, 0x00), (0x00, 0x72, 0xB2)} <= shown


@has_pyvista
def test_arrow_head_is_at_end():
    width = 0.5
    points = np.asarray(_arrows(np.array([[[0.0, 0, 0], [10, 0, 0]]]), width).points)
    radius = np.hypot(points[:, 1], points[:, 2])
    assert radius.max() == pytest.approx(HEAD_RADIUS * width, rel=1e-5)
    widest = points[radius > 0.99 * radius.max(), 0]
    np.testing.assert_allclose(widest, 10 - HEAD_LENGTH * width, rtol=1e-5)
    assert points[:, 0].max() == pytest.approx(10)


def test_rig_scene_uses_seed(monkeypatch):
    monkeypatch.setattr("raxel.lab.load_rig", lambda path: SimpleNamespace(name="made"))
    monkeypatch.setattr("raxel.show.cameras.rig_scene", lambda rig, seed=0: seed)
    options = SimpleNamespace(what="made.yaml", camera=None, corners=None, seed=5)
    assert _scene(options, None, lambda line: None) == (5, "made: a rig")


def test_legend_wraps_rows():
    entries = 12 * [("name", "#d55e00", "x")]
    rows = _legend_rows(entries, 800)
    assert sum(map(len, rows)) == 12
    step = rows[0][1][0] - rows[0][0][0]
    assert all(x + step <= 800 for row in rows for x, *_ in row)
    assert rows[0][-1][0] + 2 * step > 800 - 36
