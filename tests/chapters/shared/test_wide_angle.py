"""The simulated scene of section 4.1.5: what is drawn is what its text says."""

import numpy as np
import pytest

from chapters.shared.central import camera as scene_of
from raxel.geometry import on_plane, transform


def in_base(T_base_grid, points):
    return transform(T_base_grid, on_plane(points))


@pytest.mark.parametrize("camera", [scene_of.radial_lens(), scene_of.equidistance(150)])
def test_clean_points_lie_on_forward_rays(camera):
    rng = np.random.default_rng(1)
    scene = scene_of.draw_scene(camera, 0.0, rng, grids=4)
    reach = in_base(scene.T_base_grid, scene.points) - scene_of.CENTRE_MM
    along = np.sum(reach * scene.directions, axis=2)
    assert along.min() > 0
    off = reach - along[..., None] * scene.directions
    assert np.abs(off).max() < 1e-9 * np.abs(reach).max()
    normals = scene.T_base_grid[:, :3, 2]
    incidence = np.abs(scene.directions @ normals.T)
    assert incidence.min() >= scene_of.MIN_INCIDENCE


def test_pixels_cover_the_field_of_view():
    rng = np.random.default_rng(2)
    scene = scene_of.draw_scene(scene_of.radial_lens(), 0.0, rng)
    radius = np.linalg.norm(scene.pixels - scene_of.PRINCIPAL, axis=1)
    assert radius.max() <= scene_of.RADIUS_PX
    angle = np.degrees(np.arccos(-scene.directions[:, 2]))
    assert angle.max() < scene_of.FOV_DEG / 2 < 1.02 * angle.max()


@pytest.mark.parametrize("domain", ["px", "mm"])
def test_grid_noise_is_independent(domain):
    rng = np.random.default_rng(3)
    scene = scene_of.draw_scene(
        scene_of.radial_lens(), 0.5, rng, domain=domain, rays=4000
    )
    error = (scene.noisy - scene.points)[..., 0]
    assert error.std() > 0.3
    bound = 4 / np.sqrt(error.shape[1])
    correlation = np.corrcoef(error) - np.eye(3)
    assert np.abs(correlation).max() < bound


def test_grids_are_limited_in_size():
    rng = np.random.default_rng(4)
    camera, poses = scene_of.radial_lens(), scene_of.draw_poses(rng, euler_deg=10)
    pixels = scene_of.draw_pixels(camera, poses, rng, 200, half_mm=250)
    points, seen = scene_of.back_project(camera, pixels, poses)
    assert seen.all()
    assert np.abs(points).max() <= 250


def test_grid_tilts_and_shifts_are_symmetric():
    rng = np.random.default_rng(8)
    poses = np.concatenate([scene_of.draw_poses(rng)[1:] for _ in range(200)])
    small = np.concatenate([scene_of.draw_poses(rng, 3, 1.0)[1:] for _ in range(200)])
    # Turns of a degree add up as vectors.
    turns = np.degrees([small[:, 2, 1], small[:, 0, 2], small[:, 1, 0]])
    shifts = poses[:, :3, 3].T
    for drawn, most in ((turns, 1.0), (shifts, scene_of.SHIFT_MM)):
        # 400 even draws: their mean has an SD of a thirty-fifth of the largest.
        assert np.abs(drawn.mean(axis=1)).max() < 0.12 * most
        assert drawn.min(axis=1).max() < -0.9 * most
        assert drawn.max(axis=1).min() > 0.9 * most
        assert np.abs(drawn).max() < 1.05 * most
