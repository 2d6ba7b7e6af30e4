"""The clamped edge of a mirror: its line in the image, and the fixed quantities."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.mirror import images as from_pictures
from raxel.calibration.mirror.clamp import (
    Clamp,
    beam_motion,
    clamp_line,
    clamp_of_camera,
    clamped,
    fixed_line,
    soft_clamp,
)
from raxel.cameras import PerspectiveCamera, SplineMirrorCamera
from raxel.errors import InputError
from raxel.geometry import rotation_from_vector, spline_grid
from tests.mirror_scenes import VIEWER
from tests.raised import raises_code

ENDS = np.array([[0.17, -0.13], [0.15, 0.14]])
BOX = np.array([[-0.2, -0.16], [0.21, 0.16]])


def picks_on_line(count=12):
    share = np.linspace(0, 1, count)[:, None]
    p = (1 - share) * ENDS[0] + share * ENDS[1]
    return VIEWER.project(np.column_stack([p, np.ones(count)])).pixels


def plane_camera(quantity, shift=0.0, turn=0.0, ends=ENDS):
    """A flat mirror, moved along its normal and turned about the line between ends."""
    n = rotation_from_vector([0, np.radians(-30), 0])[:, 2]
    w = np.column_stack([ends, np.ones(2)])
    line = 370 * n[2] / (w @ n)[:, None] * w
    axis = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    k = line[0] @ n + shift
    at, n = line[0] + shift * n, rotation_from_vector(turn * axis) @ n
    k = at @ n
    grid = spline_grid(BOX, (9, 7), (3, 3), np.arctan2(0.02, 0.27))
    u, v = (np.linspace(b[0], b[-1], 40) for b in grid.breaks)
    p = grid.unturned(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    w = np.column_stack([p, np.ones(len(p))])
    return SplineMirrorCamera.fitted(VIEWER, grid, k / (w @ n)[:, None] * w, quantity)


def edge_at(y):
    """x of a mirror's left edge in an image without distortion, px."""
    return 120 + 0.07 * y


def picks_of(monkeypatch, given, sd_px, wave=0.0):
    """ClampPicks by given points in an image of the edge; wave: px, of its waves."""
    v, u = np.mgrid[:200, :300]
    inside = edge_at(v) + wave * np.sin(v / 8) - u
    monkeypatch.setattr(
        from_pictures, "_lit", lambda image_set: 60 + 120 / (1 + np.exp(inside / 0.8))
    )
    viewer = PerspectiveCamera([[700, 0, 150], [0, 700, 100], [0, 0, 1]], [], 300, 200)
    clamp = SimpleNamespace(points=given, sd_px=sd_px, hidden_mm=2.0)
    return from_pictures.clamp_picks(SimpleNamespace(clamp=clamp, grids=None), viewer)


@pytest.mark.parametrize("count", [2, 6])
@pytest.mark.parametrize(("aside", "taken"), [(2.4, True), (3.6, False), (-3.6, False)])
def test_edge_near_points_is_used_as_clamp(monkeypatch, aside, taken, count):
    """aside: standard deviations of a point, to the left or right of the edge."""
    y, sd_px = np.linspace(20, 180, count)[::-1], 0.8
    y[1:] = np.roll(y[1:], 2)
    given = np.column_stack([edge_at(y) + aside * sd_px * np.hypot(1, 0.07), y])
    picks = picks_of(monkeypatch, given, sd_px)
    assert picks.hidden_mm == 2.0
    off = picks.points[:, 0] - edge_at(picks.points[:, 1])
    # Along all of what was given, in whichever order.
    assert np.ptp(picks.points[:, 1]) == pytest.approx(160, abs=0.5)
    if taken:
        assert len(picks.points) == from_pictures.N_PICKS
        assert np.abs(off).max() < 0.1
        assert picks.sd_px < 0.1
    else:
        assert len(picks.points) == max(count, 3)
        np.testing.assert_allclose(off, given[0, 0] - edge_at(y[0]), atol=1e-9)
        assert picks.sd_px == sd_px


@pytest.mark.parametrize(("wave", "taken"), [(0.4, True), (1.8, False)])
def test_crooked_edge_is_not_used_as_clamp(monkeypatch, wave, taken):
    y = np.linspace(20, 180, 6)
    given = np.column_stack([edge_at(y), y])
    picks = picks_of(monkeypatch, given, 0.8, wave)
    assert (len(picks.points) > len(given)) == taken
    assert (picks.sd_px < 0.8) == taken


def test_clamp_line_rejects_wrong_picks():
    picks = picks_on_line()
    picks[3] += [14.0, 0]
    picks[7] = np.nan
    line = clamp_line(VIEWER, picks)
    np.testing.assert_array_equal(np.flatnonzero(~line.used), [3, 7])
    order = np.argsort(line.ends[:, 1])
    np.testing.assert_allclose(line.ends[order], ENDS, atol=1e-9)
    along = ENDS[1] - ENDS[0]
    assert line.angle == pytest.approx(np.arctan2(-along[0], along[1]), abs=1e-9)
    assert line.rms_px < 1e-6


@pytest.mark.parametrize("seed", [2325, 2442])
def test_clamp_line_keeps_valid_picks(seed):
    noise = 0.3 * np.random.default_rng(seed).standard_normal((9, 2))
    assert np.count_nonzero(clamp_line(VIEWER, picks_on_line(9) + noise).used) >= 6


def test_clamp_line_sd_predicts_scatter():
    off, clean = [], clamp_line(VIEWER, picks_on_line())
    for seed in range(30):
        noise = 0.3 * np.random.default_rng(seed).standard_normal((12, 2))
        line = clamp_line(VIEWER, picks_on_line() + noise)
        u = np.array([np.cos(line.angle), np.sin(line.angle)])
        miss = (line.ends.mean(axis=0) - ENDS.mean(axis=0)) @ u / line.offset_sd
        turn = (line.angle - clean.angle) / line.angle_sd
        off.append([miss, turn])
    assert np.all(np.abs(np.mean(np.square(off), axis=0) - 1.2) < 0.8)


@pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
def test_clamp_values_come_from_primary_stage(quantity):
    camera = plane_camera(quantity)
    clamp = fixed_line(camera, clamp_line(VIEWER, picks_on_line()))
    S = camera.mirror.points(clamp.points)
    expected = np.linalg.norm(S, axis=1) if quantity == "distance" else 1 / S[:, 2]
    np.testing.assert_allclose(clamp.values, expected, rtol=1e-10)
    c = camera.coefficients.ravel("F")
    step = 1e-6
    up, down = (
        camera.grid.rows(clamp.points + s * step * clamp.u)[0] @ c for s in (1, -1)
    )
    slopes = clamp.slopes @ clamp.u
    np.testing.assert_allclose(slopes, (up - down) / (2 * step), rtol=1e-6)


@pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
def test_replacement_line_sd_follows_its_motion(quantity):
    still = plane_camera(quantity)
    line = clamp_line(VIEWER, picks_on_line())
    moved, turned = beam_motion(6.0, 150.0, 15.0)
    assert moved == pytest.approx(15 * 36 * 444 / (2 * 150**3))
    further = beam_motion(6.0 + 1e-6, 150.0, 15.0)[0]
    assert turned == pytest.approx((further - moved) / 1e-6, rel=1e-5)
    clamp = fixed_line(still, line, hidden=6.0, length=150.0, deflection=15.0)
    shifted = fixed_line(plane_camera(quantity, shift=moved), line)
    leant = fixed_line(plane_camera(quantity, turn=turned), line)
    np.testing.assert_allclose(
        clamp.value_sd, abs(shifted.values - clamp.values), rtol=0.01
    )
    slopes = [(other.slopes - clamp.slopes) @ clamp.u for other in (shifted, leant)]
    np.testing.assert_allclose(clamp.slope_sd, np.hypot(*slopes), rtol=0.03)
    assert (fixed_line(still, line).slope_sd < 0.01 * clamp.slope_sd).all()


def test_missing_clamp_line_is_rejected():
    with pytest.raises(InputError, match="2 points"):
        clamp_line(VIEWER, picks_on_line(2))
    scattered = np.random.default_rng(2).uniform(500, 1500, (9, 2))
    with raises_code("bent-clamp-line"):
        clamp_line(VIEWER, scattered)
    camera, line = plane_camera("distance"), clamp_line(VIEWER, picks_on_line())
    with pytest.raises(InputError, match="length None"):
        fixed_line(camera, line, hidden=3.0, deflection=15.0)
    outside = clamp_line(VIEWER, picks_on_line() + [500, 0])
    with pytest.raises(InputError, match="0 of 8 points"):
        fixed_line(camera, outside)


def test_displaced_line_is_held_with_its_sd():
    """0.01 in the image are some mm on the mirror, different at each point."""
    camera, off = plane_camera("distance"), 0.01
    line = clamp_line(VIEWER, picks_on_line())
    pushed = {"length": 150.0, "deflection": 15.0}
    found = fixed_line(camera, line._replace(offset_sd=off), **pushed)
    at = [camera.mirror.points(found.points + way * found.u) for way in (0, 1e-5)]
    for k, mm in enumerate(np.linalg.norm(at[1] - at[0], axis=1) * off / 1e-5):
        hidden = fixed_line(camera, line._replace(offset_sd=0.0), hidden=mm, **pushed)
        assert found.value_sd[k] == pytest.approx(hidden.value_sd[k], rel=1e-3)
        assert found.slope_sd[k] == pytest.approx(hidden.slope_sd[k], rel=1e-3)


@pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
def test_source_mirror_fulfils_clamp(quantity):
    camera, line = plane_camera(quantity), clamp_line(VIEWER, picks_on_line())
    clamp = fixed_line(camera, line)
    # Another direction than across the line as well: slopes are vectors.
    for angle in (line.angle, line.angle + 0.9):
        kept = soft_clamp(camera.grid, clamp._replace(angle=angle))
        c = camera.coefficients.ravel("F")
        assert len(kept.rows) == 2 * len(clamp.points)
        np.testing.assert_allclose(kept.rows @ c, kept.values, rtol=1e-9)


def test_clamp_point_outside_knots_is_rejected():
    camera = plane_camera("distance")
    line = fixed_line(camera, clamp_line(VIEWER, picks_on_line()))
    points = np.vstack([line.points[:-1], [[0.9, 0.9]]])
    for kept in (Clamp(points, line.values), Clamp(points, line.values, line.slopes)):
        with raises_code("outside-knots"):
            clamped(camera.grid, kept)
    with raises_code("outside-knots"):
        soft_clamp(camera.grid, line._replace(points=points))
    pixels = VIEWER.project(np.column_stack([points, np.ones(len(points))])).pixels
    with raises_code("outside-knots"):
        clamp_of_camera(camera, pixels)
