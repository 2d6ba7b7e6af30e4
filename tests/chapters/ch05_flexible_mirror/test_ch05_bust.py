"""The relief bust: its surface is its formula, and rays of every direction meet it."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_4_distortion.scenes import TALL, Bust, heights
from raxel.errors import InputError
from raxel.geometry import pose, rotation_from_vector, transform
from raxel.lab.surfaces import Relief

BUST = Bust(160.0, 20.0)
T = pose(rotation_from_vector([0.2, -0.4, 0.1]), [10.0, -5, 400])


def test_bust_relief_faces_viewer():
    x, y = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-TALL, TALL, 109))
    high = heights(x, y)
    assert high.min() == 0
    assert 0.9 < high.max() < 1.3
    np.testing.assert_allclose(high, high[:, ::-1], atol=1e-12)
    names, points = BUST.landmarks()
    assert len(set(names)) == len(points) > 15
    assert (points[:, 2] < 0).all()
    assert points[names.index("tip of the nose")][2] == points[:, 2].min()
    assert (np.abs(points[:, :2]) < np.array(BUST.size) / 2).all()


def test_rays_hit_bust_surface():
    points = BUST.landmarks()[1]
    surface, _ = BUST.part(T)
    away = transform(T, points)
    distance = np.linalg.norm(away, axis=1)
    hit = surface.hit(np.zeros((1, 3)), away / distance[:, None])
    # The forms bend by some hundredths of a mm between heights half a mm apart.
    front = hit.distance < distance - 0.5
    assert front.mean() < 0.2
    np.testing.assert_allclose(hit.distance[~front], distance[~front], atol=0.05)
    positions = hit.uv[~front] - np.array(BUST.size) / 2
    np.testing.assert_allclose(positions, points[~front, :2], atol=0.05)


def test_axis_parallel_ray_hits_relief():
    relief = Relief(np.eye(4), np.full((4, 4), 2.0) + np.diag([0, 1.0, 1.0, 0]), 10.0)
    hit = relief.hit(np.array([[-5.0, 13.7, 2.5]]), np.array([[1.0, 0, 0]]))
    x, y, z = hit.uv[0, 0] / 10, 1.37, 2.5
    i, fx, fy = int(x), x % 1, y - 1
    h = relief.heights[1:3, i : i + 2]
    assert ((h[0] * (1 - fy) + h[1] * fy) @ [1 - fx, fx]) == pytest.approx(z, abs=1e-9)
    assert np.isinf(relief.hit(np.array([[np.nan] * 3]), np.eye(3)[:1]).distance).all()


def test_bust_eyes_have_contrast():
    _, texture = BUST.part(T)
    positions = np.array([[-0.24, -0.185], [0.24, -0.185], [0.0, -0.5]]) * 80
    visible = texture.radiance(positions + np.array(BUST.size) / 2, None)
    assert visible.shape == (3, 3)
    assert (visible[:2].mean(axis=1) < 0.1).all()
    assert visible[2].mean() > 0.3
    assert texture.array.max() <= 1


def test_bust_without_size_is_rejected():
    with pytest.raises(InputError, match=r"width 160.0 and relief 0"):
        Bust(160.0, 0)
