"""Corners tracked through a video, and the mirror shapes from them."""

from functools import lru_cache

import cv2
import numpy as np
import pytest

from chapters.shared.mirror.scores import load_height
from raxel.calibration import MirrorSettings, MirrorTracker, VideoTracker
from raxel.errors import InputError
from raxel.features.lattice import spacing
from raxel.features.video import _smooth, track_corners
from tests.film_scenes import film_scene
from tests.raised import raises_code

BENT_MM = 1.2  # corners move by 0.4 of a square


@lru_cache
def film():
    scene = film_scene(384)
    return scene, scene.frame(0.0), scene.frame(BENT_MM)


def off_px(found, true):
    """Distances (n,) of the tracked corners from the true ones; none may be missing."""
    there = np.isfinite(found.corners[:, 0])
    off = np.linalg.norm(found.corners - true, axis=1)[there]
    assert np.isfinite(off).all()
    return off


def square(frame, size):
    apart = spacing(frame.true, *size)
    return np.median(apart[np.isfinite(frame.true[:, 0])])


def shifted(frame, shift):
    image = cv2.warpAffine(
        frame.picture,
        np.column_stack([np.eye(2), shift]),
        frame.picture.shape[::-1],
        flags=cv2.INTER_CUBIC,
        borderValue=20,
    )
    return image, frame.true + shift


def test_tracked_corners_match_predicted_sd():
    scene, flat, bent = film()
    seen = np.isfinite(flat.true[:, 0]) & np.isfinite(bent.true[:, 0])
    moved = np.linalg.norm(bent.true - flat.true, axis=1)[seen]
    assert moved.max() > 0.35 * square(flat, scene.size)
    found = track_corners(flat.picture, bent.picture, flat.true, *scene.size)
    off = off_px(found, bent.true)
    sd = found.sd[np.isfinite(found.sd)]
    assert len(off) == len(sd) > 0.85 * seen.sum()
    assert off.max() < 0.05
    assert np.mean(off**2 / (2 * sd**2)) < 1
    assert np.max(off / sd) < 4
    assert np.median(sd) < 0.05
    assert not (found.lost & found.regained).any()


def test_smooth_flow_is_robust_to_outliers():
    rng = np.random.default_rng(4)
    lattice = np.indices((9, 11)).reshape(2, -1).T
    i, j = lattice.T / 10
    true = np.stack([3 + 2 * i - j + i * j, 1 - 4 * j + 2 * i * i], axis=1)
    motion = true + rng.normal(0, 0.01, true.shape)
    astray = rng.random(len(true)) < 0.2
    motion[astray] += rng.uniform(-20, 20, (astray.sum(), 2))
    motion[::17] = np.nan
    assert np.abs(_smooth(lattice, motion) - true).max() < 0.05


def test_tracking_keeps_identity_at_half_square_steps():
    scene, flat, _ = film()
    first = track_corners(flat.picture, flat.picture, flat.true, *scene.size)
    step = square(flat, scene.size)
    for angle in np.arange(8) * np.pi / 4 + 0.1:
        shift = 0.5 * step * np.array([np.cos(angle), np.sin(angle)])
        image, true = shifted(flat, shift)
        found = track_corners(flat.picture, image, flat.true, *scene.size)
        assert off_px(found, true).max() < 0.2
        both = np.isfinite(first.corners[:, 0]) & np.isfinite(found.corners[:, 0])
        assert both.sum() > 0.8 * np.isfinite(first.corners[:, 0]).sum()
    # By a whole square, each would lie on the place of its neighbour.
    image, true = shifted(flat, [step, 0.0])
    found = track_corners(flat.picture, image, flat.true, *scene.size)
    assert not np.isfinite(found.corners).any()
    assert found.lost.sum() == np.isfinite(flat.true[:, 0]).sum()


def test_occluded_side_is_lost_and_regained():
    scene, flat, bent = film()
    start = track_corners(bent.picture, flat.picture, bent.true, *scene.size).corners
    column = np.arange(len(start)) % scene.size[0]
    known = np.isfinite(start[:, 0])
    rim = known & (column >= column[known].max() - 1)
    low, high = start[rim].min(axis=0) - 10, start[rim].max(axis=0) + 10
    covered = bent.picture.copy()
    (u, v), (right, bottom) = np.maximum(low, 0).astype(int), high.astype(int)
    covered[v:bottom, u:right] = 90
    without = track_corners(flat.picture, covered, start, *scene.size)
    assert without.lost[rim].all()
    off = off_px(without, bent.true)
    assert off.max() < 0.05
    assert len(off) > 0.6 * known.sum()
    back = track_corners(covered, flat.picture, without.corners, *scene.size)
    assert back.regained[rim].sum() > 0.8 * rim.sum()
    assert off_px(back, flat.true).max() < 0.05


def test_mirror_tracking_has_no_drift():
    scene, flat, bent = film()
    camera = scene.spline()
    settings = MirrorSettings(prior_sd=0.1)
    tracker = MirrorTracker(camera, scene.scene_points, scene.clamp(camera), settings)
    following = VideoTracker(tracker, flat.picture, flat.true, *scene.size)
    for frame, deflection in ((bent, BENT_MM), (flat, 0.0)) * 2:
        found = following.follow(frame.picture)
        assert found.shape.settled
        assert np.nanmean(found.shape.residuals) < 0.05
        true = scene.rig.camera(deflection)
        height = load_height(scene.rig, tracker.camera_now(), true)
        assert abs(height - deflection) < 0.01
    with raises_code("too-few-features"):
        following.follow(np.full_like(flat.picture, 128))
    # The film stays where it was.
    assert np.isfinite(following.follow(bent.picture).corners.corners).any()


def far_apart():
    """Six corners of 14 by 13, no two of them neighbours."""
    corners = np.full((13, 14, 2), np.nan)
    corners[1:12:6, 2:13:5] = 100.0
    return corners.reshape(-1, 2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"after": np.zeros((10, 10), np.uint8)}, r"\(10, 10\)"),
        ({"after": np.zeros((288, 384))}, "uint8"),
        ({"corners": np.zeros((5, 2))}, r"\(5, 2\)"),
        ({"corners": np.full((182, 2), np.nan)}, " 0 corners"),
        ({"corners": far_apart()}, "video: "),
    ],
)
def test_tracking_rejects_invalid_input(change, message):
    image = np.zeros((288, 384), np.uint8)
    given = {"before": image, "after": image, "corners": np.zeros((182, 2))}
    with pytest.raises(InputError, match=message):
        track_corners(**given | change, columns=14, rows=13)


def test_tracking_is_independent_of_polarity():
    scene, flat, bent = film()
    found = track_corners(flat.picture, bent.picture, flat.true, *scene.size)
    negative = track_corners(
        255 - flat.picture, 255 - bent.picture, flat.true, *scene.size
    )
    np.testing.assert_allclose(negative.corners, found.corners, atol=0.01)


def test_flow_to_neighbours_is_rejected(monkeypatch):
    """After half a square to the left, half a square to the right fits equally well."""
    scene, flat, _ = film()
    step = square(flat, scene.size)
    image, true = shifted(flat, [-0.5 * step, 0.0])
    wrong = np.roll(true.reshape(13, 14, 2), 1, axis=1).reshape(-1, 2)
    wrong[::14] = np.nan
    known = np.isfinite(wrong[:, 0]) & np.isfinite(flat.true[:, 0])
    assert np.all(np.linalg.norm(wrong - flat.true, axis=1)[known] < 0.6 * step)
    monkeypatch.setattr("raxel.features.video._flow_positions", lambda *given: wrong)
    found = track_corners(flat.picture, image, flat.true, *scene.size)
    assert not np.isfinite(found.corners).any()
