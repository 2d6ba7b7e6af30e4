"""Flat mirror (ring) on a board: its position, reflection and hub."""

import numpy as np
import pytest

from raxel.cameras import pixel_grid
from raxel.geometry.poses import pose, transform
from raxel.lab.mirror_set_rig import PLATTER_PLATE as PLATE
from raxel.lab.mirror_set_rig import PlatterRing, camera_in_platter, render_plate
from raxel.lab.rig import load_rig
from tests.raxel.lab.test_rig import changed

RING = PlatterRing((75.0, 10.0), 16.0, 6.0, 3.0)
T = pose(np.eye(3), [-55.0, -10.0, 110.0])
MIDDLE = np.array([20.0, 0.0, 107.0])


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    return load_rig(changed(tmp_path_factory.mktemp("rig") / "rig.yaml"))


def positions(rig):
    """Of all pixels: how far from the ring's axis their rays meet its face, mm."""
    pixels = pixel_grid(rig.camera.width, rig.camera.height)
    d = rig.camera.rays(pixels).directions
    met = d * (MIDDLE[2] / d[:, 2:])
    return pixels, d, met, np.linalg.norm(met - MIDDLE, axis=1)


def test_ring_rays_start_on_its_face(rig):
    camera = camera_in_platter(rig.camera, RING, T)
    pixels, d, met, distance = positions(rig)
    rays = camera.rays(pixels)
    # A polygon of 2 degrees a side lies within 0.003 mm of its circle.
    inside = (distance > 6.01) & (distance < 15.99)
    outside = ~((distance > 5.99) & (distance < 16.01))
    assert rays.valid[inside].all()
    assert not rays.valid[outside].any()
    np.testing.assert_allclose(rays.origins[inside], met[inside], atol=1e-9)
    back = d[inside] * [1, 1, -1]
    np.testing.assert_allclose(rays.directions[inside], back, atol=1e-12)


def test_ring_is_dark_and_hub_shows_plate(rig):
    image = render_plate(rig, RING, T, np.random.default_rng(0)).astype(float)
    # A radiance of 1 fills nine tenths of the sensor's range.
    image = image.ravel() / (0.9 * 255)
    distance = positions(rig)[3]
    assert image[distance < 4].mean() == pytest.approx(PLATE, rel=0.05)
    assert image[(distance > 8) & (distance < 14)].mean() < 0.01
    # The plate is square, and lies 3 mm behind the ring's face.
    corner = transform(T, np.array([[75 - 18.0, 10 - 18.0, 0.0]]))
    u, v = np.rint(rig.camera.project(corner).pixels[0]).astype(int)
    position = image.reshape(rig.camera.height, -1)[v - 1 : v + 2, u - 1 : u + 2]
    assert position.mean() == pytest.approx(PLATE, rel=0.1)
