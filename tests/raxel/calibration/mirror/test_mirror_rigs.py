"""The three rigs of chapter 5: what is in view, and that nothing is in the way."""

import numpy as np
import pytest

from chapters.shared.mirror.rigs import (
    BACK_PROJECTION_MM,
    DYNAMIC_MM,
    FILES,
    SMALL_FILES,
    STAGES_MM,
    mirror_rig,
)
from chapters.shared.rigs import RIGS
from raxel.geometry import intersect_rays_plane, inverse_pose, on_plane, transform

ALL = pytest.mark.parametrize("name", FILES)
SMALL = pytest.mark.parametrize("name", SMALL_FILES)
# Of the rays of a mirror: how many meet the monitor in its farther position at least.
FILLED = {"A": 1.0, "B": 1.0, "C": 0.92}
# The camera's body hides nothing that is so far off the line back to it.
BODY = np.radians(25)


def spread(camera):
    u, v = (np.linspace(0, n - 1, 41) for n in (camera.width, camera.height))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = camera.rays(pixels)
    return pixels[rays.valid], rays.origins[rays.valid], rays.directions[rays.valid]


@pytest.mark.parametrize(
    ("name", "small"), [(n, False) for n in FILES] + [(n, True) for n in SMALL_FILES]
)
def test_mirror_rig_files_exist(name, small):
    rig = mirror_rig(name, small)
    found = [part.path.relative_to(RIGS.parents[1]) for part in (rig.rig, rig.monitor)]
    assert tuple(map(str, found)) == (SMALL_FILES if small else FILES)[name]
    ours, theirs = rig.rig.camera.arguments(), rig.monitor.camera.arguments()
    del ours["viewer"], theirs["viewer"]
    np.testing.assert_equal(ours, theirs)


@SMALL
def test_small_camera_has_same_view(name):
    large, small = (mirror_rig(name, one).camera(10.0) for one in (False, True))
    assert (4 * small.width, 4 * small.height) == (large.width, large.height)
    pixels, origins, directions = spread(small)
    rays = large.rays(4 * (pixels + 0.5) - 0.5)
    np.testing.assert_allclose(rays.origins, origins, atol=1e-9)
    np.testing.assert_allclose(rays.directions, directions, atol=1e-12)


@ALL
def test_stage_mirror_shows_monitor_not_camera(name):
    rig, widths = mirror_rig(name), []
    size = np.array(rig.monitor.target.monitor_mm)
    for camera in rig.stages(aberration_um=10, seed=1):
        pixels, origins, directions = spread(camera)
        assert 0.5 < len(pixels) / 41**2 < 0.8
        back = -origins / np.linalg.norm(origins, axis=1, keepdims=True)
        assert np.arccos(np.sum(back * directions, axis=1)).min() > BODY
        for T in rig.monitor_poses():
            met = intersect_rays_plane(origins, directions, T)
            shown = np.all((met.points >= 0) & (met.points <= size), axis=1)
            assert np.mean(shown) >= FILLED[name]
        widths.append(np.arccos((directions @ directions.T).min()))
    assert np.all(np.diff(widths) > 0.05)


@ALL
@pytest.mark.parametrize("distance", [DYNAMIC_MM, BACK_PROJECTION_MM])
def test_stage_boards_are_visible_before_and_after(name, distance):
    rig = mirror_rig(name)
    for deflections in ((0.0, 5.0), (0.0, 15.0)):
        T = rig.board_pose(np.random.default_rng(2), distance, deflections)
        seen = [rig.corners(rig.camera(d), T)[1] for d in deflections]
        assert np.all(seen, axis=0).sum() >= 90
        middle = transform(T, on_plane(rig.board.points().mean(axis=0)[None]))
        _, origins, _ = spread(rig.camera(0.0))
        gap = np.linalg.norm(middle - origins.mean(axis=0))
        assert gap == pytest.approx(distance, rel=0.1)


@ALL
def test_stage_load_is_at_given_position(name):
    rig = mirror_rig(name)
    flat = rig.camera(0.0)
    for deflection in STAGES_MM:
        camera = rig.camera(deflection, aberration_um=0)
        moved = rig.load_point(camera) - rig.load_point(flat)
        along = moved @ rig.deflection_direction()
        assert along == pytest.approx(deflection, abs=1e-9)
        np.testing.assert_allclose(
            rig.clamp_pixels(camera), rig.clamp_pixels(flat), atol=1e-9
        )
    hidden = rig.camera(15.0, holder_mm=5.0)
    line = rig.clamp_pixels(hidden)
    assert np.all(line[:, 0] < rig.clamp_pixels(flat)[:, 0] - 50)
    # The free edge is at the left.
    assert hidden.rays(line - [1, 0]).valid.all()
    assert not hidden.rays(line + [1, 0]).valid.any()


@ALL
def test_flat_mirror_shows_both_positions(name):
    rig = mirror_rig(name)
    platter = rig.platter(np.random.default_rng(1))
    board = transform(platter.T_camera_board, on_plane(platter.board.points()))
    assert rig.viewer.in_image(rig.viewer.project(board).pixels).all()
    on_mirror = inverse_pose(rig.camera(0.0).T_viewer_mirror)
    assert transform(on_mirror, board)[:, 2].max() < -20
    T = platter.T_camera_mirror
    assert T[:3, 3] @ T[:3, 2] > 0
    middle = T[:3, 3]
    normal = T[:3, 2]
    into = middle / np.linalg.norm(middle)
    out = into - 2 * (into @ normal) * normal
    for monitor in rig.monitor_poses(np.random.default_rng(2)):
        met = intersect_rays_plane(middle[None], out[None], monitor)
        size = np.array(rig.monitor.target.monitor_mm)
        assert np.all((met.points > 40) & (met.points < size - 40))
