"""Smooth rays directly from corners: exact, consistent, honest, and without a guess."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration import BoardView, adjust_spline, calibrate_spline
from raxel.calibration.smooth import boards as smooth_boards
from raxel.calibration.smooth import equations as linear_part
from raxel.calibration.smooth.boards import RayTrend, _completed, _generic_start
from raxel.calibration.smooth.equations import CornersOfBoards, grid_of
from raxel.cameras import KannalaBrandtCamera
from raxel.geometry import on_plane, pose, rotation_from_vector
from tests.raised import raises_code
from tests.smooth_fields import (
    LENS,
    H,
    W,
    bent,
    boards,
    disturbed,
    misfit_px,
    positions,
    rms,
)

N_BOARDS = 12


def scene(seed, sd_px, count=N_BOARDS):
    rng = np.random.default_rng(seed)
    camera = bent(seed=seed)
    seen, poses = boards(camera, rng, count, sd_px)
    return camera, seen, disturbed(poses, rng), rng


def test_spline_equations_equal_derivatives():
    """Of corners' errors with control values and poses, by differences."""
    camera, seen, poses, rng = scene(1, 0.3, count=3)
    pixels, points = (np.concatenate(part) for part in zip(*seen, strict=True))
    corners = CornersOfBoards(pixels, on_plane(points), np.repeat(np.arange(3), 48))
    grid = grid_of(8, W, H, pixels)
    start = np.ascontiguousarray(camera.control)
    first = linear_part.linearised(LENS, poses, corners, start, grid)
    step = 1e-5

    def changed(control, moved):
        found = linear_part.linearised(LENS, moved, corners, control, grid)
        return (found.off - first.off) / step

    direction = rng.normal(size=start.shape)
    found = changed(start + step * direction, poses)
    index, share = linear_part.shares(first.place, grid.shape, grid.spacing)
    lifted = np.sum(share[..., None] * direction.reshape(-1, 2)[index], axis=1)
    expected = (first.white @ lifted[..., None])[..., 0]
    np.testing.assert_allclose(found, expected, atol=1e-3)
    move = rng.normal(size=6) * [0.01, 0.01, 0.01, 1, 1, 1]
    R = poses[:, :3, :3]
    turned = R @ rotation_from_vector(step * move[:3])
    moved = pose(turned, poses[:, :3, 3] + step * (R @ move[3:]))
    expected = -(first.white @ (first.by_pose @ move)[..., None])[..., 0]
    np.testing.assert_allclose(changed(start, moved), expected, atol=1e-3)
    turn = rotation_from_vector(step * np.array([0.3, -0.2, 0.1]))
    about = pose(turn, np.zeros(3)) @ poses
    expected = -(first.white @ (first.by_turn @ [0.3, -0.2, 0.1])[..., None])[..., 0]
    np.testing.assert_allclose(changed(start, about), expected, atol=1e-3)


def test_spline_fits_exact_corners():
    camera, seen, start, _ = scene(2, 0, count=20)
    found = adjust_spline(LENS, start, seen, W, H)
    assert rms(np.concatenate(found.residuals_px)) < 2e-3
    pixels = np.concatenate([pixels for pixels, _ in seen])
    assert rms(misfit_px(found.camera, camera, pixels)) < 0.02


@pytest.mark.parametrize("seed", [2, 3])
def test_field_extends_to_image_edge(seed):
    """Few boards leave gaps: one held firmly at their rim is twice as far off."""
    camera, seen, start, rng = scene(seed, 0, count=10)
    found = adjust_spline(LENS, start, seen, W, H).camera
    fresh = positions(rng, 500)
    off = misfit_px(found, camera, fresh)
    assert rms(off[found.covers(fresh)]) < 0.02
    assert rms(off) < 0.06


def test_trend_corners_give_zero_field():
    rng = np.random.default_rng(3)
    seen, poses = boards(LENS, rng, N_BOARDS, 0)
    found = adjust_spline(LENS, disturbed(poses, rng), seen, W, H)
    assert np.abs(found.camera.displacement(positions(rng, 500))).max() < 1e-4
    np.testing.assert_allclose(found.T_camera_grid, poses, atol=1e-3)


def test_spline_noise_decreases_with_boards():
    """The field is consistent: four times the boards, about half of the error."""
    errors, normalised, sds = {8: [], 32: []}, [], []
    for count, of_count in errors.items():
        for seed in range(3):
            camera, seen, start, rng = scene(seed, 0.2, count)
            found = adjust_spline(LENS, start, seen, W, H)
            fresh = positions(rng, 400)
            fresh = fresh[found.camera.covers(fresh)]
            off = misfit_px(found.camera, camera, fresh)
            of_count.append(rms(off))
            stated = np.linalg.inv(found.camera.pixel_covariance(fresh))
            normalised.append(np.mean(np.einsum("ni,nij,nj->n", off, stated, off)) / 2)
            sds.append(found.sd_px)
    assert np.median(errors[32]) < 0.7 * np.median(errors[8])
    assert 0.1 < np.median(normalised) < 1.5
    np.testing.assert_allclose(np.mean(sds), 0.2, rtol=0.05)


def test_spline_noise_of_few_corners_is_unbiased():
    """Of a dozen coordinates of a board six are spent on where it is; and the field,
    of which corners determine about eighteen parameters, takes a seventh
    of what is left."""
    found = []
    for seed in range(4):
        _, seen, start, rng = scene(40 + seed, 0.3, count=20)
        picks = [rng.permutation(len(pixels))[:6] for pixels, _ in seen]
        few = [(a[own], b[own]) for (a, b), own in zip(seen, picks, strict=True)]
        found.append(adjust_spline(LENS, start, few, W, H).sd_px)
    assert rms(found) == pytest.approx(0.3, rel=0.08)


def test_field_contains_no_rotation():
    _, seen, start, _ = scene(4, 0.2)
    found = adjust_spline(LENS, start, seen, W, H)
    pixels, points = (np.concatenate(part) for part in zip(*seen, strict=True))
    board = np.repeat(np.arange(N_BOARDS), 48)
    corners = CornersOfBoards(pixels, on_plane(points), board)
    grid = grid_of(found.cells, W, H, pixels)
    control = np.ascontiguousarray(found.camera.control)
    parts = linear_part.linearised(LENS, found.T_camera_grid, corners, control, grid)
    field = found.camera.displacement(parts.place)
    for axis in range(3):
        turn = parts.by_turn[:, :, axis]
        alike = np.vdot(turn, field) / np.linalg.norm(turn) / np.linalg.norm(field)
        assert abs(alike) < 0.02


def test_spline_rejects_and_lists_wrong_corners():
    _, seen, start, _ = scene(5, 0.2)
    seen[3][0][[4, 9]] += [[12.0, -7.0], [5.0, 9.0]]
    found = adjust_spline(LENS, start, seen, W, H)
    assert np.flatnonzero(found.outliers[3]).tolist() == [4, 9]
    assert sum(np.count_nonzero(out) for out in found.outliers) == 2
    np.testing.assert_allclose(found.residuals_px[3][4], [12, -7], atol=1.0)


def test_spline_predicts_held_out_boards():
    camera, seen, _, rng = scene(6, 0.15)
    views = [BoardView(pixels, points, 8, 6, f"{k}") for k, (pixels, points) in
             enumerate(seen)]  # fmt: skip
    found = calibrate_spline(views, W, H, rng=rng)
    assert found.used == list(range(N_BOARDS))
    assert found.left_out == {}
    assert found.wrong_corners == {}
    assert found.share_with_ray > 0.99
    assert 0.5 < found.share_covered <= 1
    pixels = np.concatenate([pixels for pixels, _ in seen])
    assert rms(misfit_px(found.camera, camera, pixels)) < 0.4
    assert found.camera.covers(pixels).all()
    assert min(found.adjustment.held_out_px.values()) < 1.2 * np.sqrt(2) * 0.15
    assert found.adjustment.cells > 4


def test_single_or_unseen_boards_are_rejected():
    _, seen, start, _ = scene(7, 0.1, count=2)
    with raises_code("too-few-grids"):
        adjust_spline(LENS, start[:1], seen[:1], W, H)
    behind = start.copy()
    behind[1, :3, 3] = [0, 0, -300.0]
    narrow = KannalaBrandtCamera(
        [1, -0.03], (120, 120), (162, 118), W, H, max_angle=1.5
    )
    with raises_code("too-few-points"):
        adjust_spline(narrow, behind, seen, W, H)


def test_generic_start_poses_use_trend_frame(monkeypatch):
    """The generic method has a frame of its own, turned about the lens's centre."""
    R = rotation_from_vector([0.3, -0.2, 0.5])
    T_lens_grid = pose(rotation_from_vector([0.1, 0.2, 0.0]), [-30.0, -20.0, 400.0])
    T_rays_grid = pose(R, np.zeros(3)) @ T_lens_grid
    v, u = np.indices((H, W))
    rays = LENS.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    table = SimpleNamespace(
        mask=rays.valid.reshape(H, W),
        directions=(rays.directions @ R.T).reshape(H, W, 3),
    )
    found = SimpleNamespace(
        camera=table, used=[0], T_camera_grid=T_rays_grid[None], left_out={}
    )
    monkeypatch.setattr(smooth_boards, "calibrate_generic", lambda *a, **k: found)
    monkeypatch.setattr(
        smooth_boards, "trend_of_rays", lambda *a: RayTrend(LENS, R, 0.1)
    )
    start = _generic_start([], W, H, None, "mm", -1)
    np.testing.assert_allclose(start.T_camera_grid[0], T_lens_grid, atol=1e-12)


def test_best_predicting_trend_is_selected(monkeypatch):
    """A spacing of cells that is not taken says nothing against its trend."""
    held_out_px = {"one": {8: 0.9, 16: 0.2}, "other": {8: 0.3, 16: 0.4}}

    def laid(name, *_):
        return SimpleNamespace(
            name=name, adjustment=SimpleNamespace(held_out_px=held_out_px[name])
        )

    monkeypatch.setattr(smooth_boards, "_lenses", lambda *_: (["other", "one"], []))
    monkeypatch.setattr(smooth_boards, "_lens_start", lambda name: name)
    monkeypatch.setattr(smooth_boards, "_laid", laid)
    monkeypatch.setattr(smooth_boards, "_completed", lambda best, *_: best.name)
    assert calibrate_spline([], W, H, rng=None) == "one"


def test_image_shares_and_wrong_corners_are_counted():
    """Rays left of u = 60, corners only above v = 20 and left of u = 40."""
    camera = SimpleNamespace(
        rays=lambda pixels: SimpleNamespace(valid=pixels[:, 0] < 60),
        covers=lambda pixels: (pixels < [40, 20]).all(axis=1),
    )
    outliers = [np.array([False, True, True]), np.zeros(3, bool)]
    poses = np.tile(np.eye(4), (2, 1, 1))
    fitted = SimpleNamespace(camera=camera, T_camera_grid=poses, outliers=outliers)
    start = SimpleNamespace(name="rays", pupil=None, board=None)
    found = _completed((start, [1, 3], {0: "why"}, fitted), 80, 40)
    assert (found.share_with_ray, found.share_covered) == (0.8, 0.3)
    assert found.wrong_corners == {1: 2}
    assert (found.used, found.left_out) == ([1, 3], {0: "why"})
