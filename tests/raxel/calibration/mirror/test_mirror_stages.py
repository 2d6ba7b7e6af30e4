"""A bending mirror from its views: accuracy, and bad views are rejected or flagged."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.mirror.images import ordered_like
from raxel.calibration.mirror.observations import normalised
from raxel.calibration.mirror.stages import (
    DEFAULT_SETTINGS,
    _outline,
    calibrate_mirror,
    check_distinct_images,
)
from raxel.errors import CalibrationError, InputError
from tests.made_mirror_views import board_view, edge, made_views, sheet, step_views
from tests.mirror_scenes import board_pose
from tests.raised import raises_code

DEFLECTIONS = 0.0, 5.0, 10.0


@lru_cache
def good():
    return made_views(DEFLECTIONS)


@lru_cache
def calibrated():
    return calibrate_mirror(good())


def with_step(**changes):
    """The views of the first step alone, changed."""
    return good()._replace(steps=(good().steps[0]._replace(**changes),))


def ray_angles(found, deflection):
    """Angles (N,) between found and true rays all over the knots, degrees."""
    u, v = (np.linspace(b[0], b[-1], 15) for b in found.grid.breaks)
    p = found.grid.unturned(np.stack(np.meshgrid(u, v), -1).reshape(-1, 2))
    pixels = found.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels
    ours, true = found.rays(pixels), sheet(deflection).rays(pixels)
    gap = np.linalg.norm(ours.directions - true.directions, axis=1)
    return np.degrees(gap[ours.valid & true.valid])


def test_stage_errors_match_predictions():
    found = calibrated()
    assert len(found.cameras) == 3
    for k, (camera, deflection) in enumerate(
        zip(found.cameras, DEFLECTIONS, strict=True)
    ):
        assert np.mean(ray_angles(camera, deflection)) < 0.04
        assert camera.grid.shape == (7, 3)
        assert np.mean(found.residuals_mm(k)) < 0.08
        pixels = found.views[0].view.pixels
        assert 0.001 < np.degrees(np.nanmedian(found.bundle.ray_sd(k, pixels))) < 0.03
    assert abs(found.primary.motions[0].distance - 100) < 0.5
    np.testing.assert_allclose(
        found.residuals_deg(2), np.degrees(found.residuals_mm(2) / 260), rtol=0.4
    )


def test_static_board_over_two_steps_has_one_pose():
    rng = np.random.default_rng(2)
    T = board_pose([2.0, 3, 4])
    one, two, three = (board_view(d, T, f"at {d:g}", rng) for d in (0.0, 5.0, 10.0))
    first, second = good().steps
    steps = (
        first._replace(before=one, after=two),
        second._replace(before=two, after=three),
    )
    found = calibrate_mirror(good()._replace(steps=steps))
    assert [(view.stage, view.grid) for view in found.views] == [(0, 0), (1, 0), (2, 0)]
    assert np.mean(ray_angles(found.cameras[2], 10.0)) < 0.05


def test_corner_order_follows_first_image():
    rng = np.random.default_rng(3)
    T = board_pose([2.0, 3, 4])
    before, after = (board_view(d, T, "", rng) for d in (0.0, 5.0))
    turned = np.arange(14 * 13).reshape(13, 14)[::-1, ::-1].ravel()
    other = after._replace(pixels=after.pixels[turned], sd=np.arange(182.0)[turned])
    again, clear = ordered_like(before, other)
    np.testing.assert_array_equal(again.pixels, after.pixels)
    np.testing.assert_array_equal(again.sd, np.arange(182.0))
    assert clear
    far = after._replace(pixels=after.pixels + np.ptp(after.pixels[:14], axis=0) / 2)
    assert not ordered_like(before, far)[1]


def test_wrong_matches_are_rejected_and_reported():
    rng = np.random.default_rng(1)
    after = good().steps[0].after
    pixels = after.pixels.copy()
    common = np.flatnonzero(np.isfinite(pixels[:, 0]))
    wrong = rng.permutation(common)[: len(common) // 5]
    pixels[wrong] = pixels[np.roll(wrong, 1)]
    found = calibrate_mirror(with_step(after=after._replace(pixels=pixels)))
    assert "stage 1: 23 wrong matches rejected" in found.flags
    assert np.mean(ray_angles(found.cameras[1], 5.0)) < 0.04


def test_wrong_monitor_points_are_rejected_and_reported():
    near, far = good().grids
    location = near.location.copy()
    rows, columns = np.nonzero(np.isfinite(location[..., 0]))
    location[rows[::40], columns[::40]] += 60.0
    # Where decoding fails it does so at pixels of their own.
    found = calibrate_mirror(
        good()._replace(grids=(near._replace(location=location), far))
    )
    assert any("grid points rejected" in flag for flag in found.flags)
    assert np.mean(ray_angles(found.cameras[0], 0.0)) < 0.04


def test_moved_board_is_flagged():
    for moved_mm, message in ((0.0, False), (20.0, True)):
        step = step_views(1, (0.0, 5.0), np.random.default_rng(5), moved_mm)
        found = calibrate_mirror(good()._replace(steps=(step,)))
        assert any("static board" in flag for flag in found.flags) == message


def test_large_step_reports_missing_rays():
    step = step_views(1, (0.0, 25.0), np.random.default_rng(5))
    found = calibrate_mirror(good()._replace(steps=(step,)))
    assert any("no rays near the free edge" in flag for flag in found.flags)
    assert np.mean(ray_angles(found.cameras[1], 25.0)) < 0.05


@pytest.mark.parametrize(
    ("x", "message"),
    [
        (-40.0, "of the mirror's length from the image"),
        (40.0, "of the pixels that see the monitor are beyond its line"),
        (160.0, "knot interval along u: rays rotate .* board, camera or clamp"),
    ],
)
def test_misplaced_clamp_is_rejected(x, message):
    clamp = good().clamp._replace(points=edge(x))
    with pytest.raises((InputError, CalibrationError), match=message):
        calibrate_mirror(good()._replace(clamp=clamp))


def test_line_replaces_hidden_clamp():
    clamp = good().clamp._replace(points=edge(4.0), hidden_mm=4.0)
    found = calibrate_mirror(good()._replace(clamp=clamp, steps=good().steps[:1]))
    assert np.mean(ray_angles(found.cameras[1], 5.0)) < 0.05


def test_clamp_points_off_line_are_rejected():
    points = edge(0.1) + 40 * np.random.default_rng(1).standard_normal((9, 2))
    clamp = good().clamp._replace(points=points)
    with raises_code("bent-clamp-line"):
        calibrate_mirror(good()._replace(clamp=clamp))


def test_exchanged_images_are_rejected_by_name():
    step = good().steps[0]
    views = with_step(before=step.after, after=step.before)
    with pytest.raises(CalibrationError, match=r"step 1 \(s1-after, s1-before\)"):
        calibrate_mirror(views)


def test_corners_only_near_clamp_are_rejected():
    after = good().steps[0].after
    near = after.pixels[:, 0] > np.nanquantile(after.pixels[:, 0], 0.85)
    pixels = np.where(near[:, None], after.pixels, np.nan)
    views = with_step(after=after._replace(pixels=pixels))
    with pytest.raises(CalibrationError, match="step 1 "):
        calibrate_mirror(views)


def test_equal_monitor_positions_are_rejected():
    views = good()
    first, second = views.platter
    twice = first, second._replace(grid=first.grid)
    for rejected, wrong in (
        (raises_code("same-points"), made_views(far_mm=0.3)),
        (
            pytest.raises(CalibrationError, match="near and far"),
            views._replace(platter=twice),
        ),
        (raises_code("rays-do-not-meet"), views._replace(grids=views.grids[::-1])),
    ):
        with rejected:
            calibrate_mirror(wrong)


def test_knots_span_supported_part_of_next_step():
    """Boards of the next step lie far beyond; knots follow a part of the way."""
    step, camera = good().steps[0], calibrated().cameras[0]
    pixels = step.after.pixels
    middle = np.nanmean(pixels, axis=0)
    wide = step.before._replace(pixels=middle + 3 * (pixels - middle))
    spans = []
    for following in (None, step._replace(before=wide).before):
        outline = _outline(camera, step, following, DEFAULT_SETTINGS)
        spans.append(np.ptp(camera.grid.turned(normalised(camera.viewer, outline)), 0))
    intervals = np.subtract(DEFAULT_SETTINGS.shape, DEFAULT_SETTINGS.degree)
    common = pixels[camera.rays(step.before.pixels).valid & np.isfinite(pixels[:, 0])]
    common = np.ptp(camera.grid.turned(normalised(camera.viewer, common)), axis=0)
    # Four tenths of an interval to each side are as far as knots are supported.
    np.testing.assert_allclose(spans[1], common * (1 + 0.8 / intervals), rtol=1e-3)
    assert np.all(spans[0] < spans[1])


def test_repeated_monitor_position_is_detected_despite_outliers():
    """What single pixels decode wrongly is no other place."""
    grids = [SimpleNamespace(name=name) for name in ("near", "far")]
    once = np.random.default_rng(0).uniform(0, 300, (200, 2))
    again = once + 0.1
    again[:30] += 80
    again[-5:] = np.nan
    with pytest.raises(CalibrationError, match="near and far show the same points"):
        check_distinct_images(np.stack([once, again]), grids)
    check_distinct_images(np.stack([once, once + [5.0, 0.0]]), grids)
