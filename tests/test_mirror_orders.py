"""Knots and degree are raised until residuals are noise, and no further."""

import numpy as np
import pytest

from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import CLAMP_PICKS, lattice, outline, true_points
from raxel.calibration import (
    MirrorSettings,
    SplineOrder,
    clamp_line,
    fixed_line,
    primary_by_order,
    primary_from_points,
    raised_until_white,
    stage_by_order,
)
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.whiteness import _across, neighbours, whiteness
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.spline_grid import spline_grid

DECODED_MM = 0.05
STEP_PX = 192


@pytest.fixture(scope="module")
def scene():
    """Geometry A bent by 15 mm; viewer, monitor, clamp and pixels are true."""
    rig = mirror_rig("A")
    bent = rig.camera(STAGES_MM[-1])
    line = clamp_line(rig.viewer, rig.clamp_pixels(bent, CLAMP_PICKS))
    T = rig.monitor_poses()
    pixels = lattice(bent, STEP_PX)
    points = np.stack([true_points(rig, bent, pixels, pose) for pose in T])
    both = np.isfinite(points).all(axis=(0, 2))
    spline = {"angle": line.angle, "span": line.points(CLAMP_PICKS)}
    return rig, pixels[both], points[:, both], T, spline


def own_space(scene, order):
    """The spline of a SplineOrder that is nearest to the bent mirror."""
    rig, pixels, points, T, spline = scene
    return primary_from_points(
        rig.viewer, pixels, points, T, shape=order.shape, degree=order.degree, **spline
    ).camera


def decoded_in(scene, camera, noise=DECODED_MM):
    """Points of both monitors that the pixels see in a camera, with noise."""
    rig, pixels, _, T, _ = scene
    points = np.stack([true_points(rig, camera, pixels, pose) for pose in T])
    return points + np.random.default_rng(0).normal(0, noise, points.shape)


def primary(scene, points):
    rig, pixels, _, T, spline = scene
    return primary_by_order(rig.viewer, pixels, points, T, **spline)


@pytest.mark.parametrize(
    "order", [SplineOrder((4, 3)), SplineOrder((5, 3)), SplineOrder((5, 4), (3, 3))]
)
def test_a_mirror_of_the_splines_own_space_is_left_at_its_order(scene, order):
    found = raised_until_white(
        primary(scene, decoded_in(scene, own_space(scene, order)))
    )
    assert found.white
    assert found.order == order
    assert not any(step.whiteness.white for step in found.steps[:-1])


def test_finer_relief_is_followed_further(scene):
    rig = scene[0]
    ends = []
    for height_um in (0.0, 21.0):
        points = decoded_in(scene, rig.camera(STAGES_MM[-1], height_um, 1), 0.2)
        found = raised_until_white(primary(scene, points))
        assert found.white
        ends.append(found.order.size)
    assert ends[1] > 1.5 * ends[0]


def test_without_noise_nothing_is_white_and_the_reason_is_said(scene):
    rig = scene[0]
    points = decoded_in(scene, rig.camera(STAGES_MM[-1], 21.0, 2), noise=0.0)
    found = raised_until_white(primary(scene, points), most=30)
    assert not found.white
    assert found.reason == "30 coefficients are the most"
    assert found.order.size <= 30
    assert np.all(np.diff([step.variance for step in found.steps]) < 0)


@pytest.fixture(scope="module")
def fitted(scene):
    own = own_space(scene, SplineOrder((5, 3)))
    return primary(scene, decoded_in(scene, own))(SplineOrder((5, 3)))[1]


def test_white_noise_has_the_mean_and_the_deviation_that_are_told(fitted):
    exact, rng = fitted.points - fitted.residuals, np.random.default_rng(3)
    noisy = [
        fitted._replace(points=exact + rng.normal(0, 0.02, exact.shape))
        for _ in range(60)
    ]
    drawn = [whiteness(one).excess for one in noisy]
    assert abs(np.mean(drawn)) < 3 / np.sqrt(len(drawn))
    assert np.std(drawn) == pytest.approx(1, abs=0.3)
    # Coefficients that were not fitted to this noise take none of it away.
    spent = 1 - len(fitted.coefficients) / (2 * len(exact))
    variance = spent * np.mean([one.variance for one in noisy])
    assert variance == pytest.approx(0.02**2, rel=0.03)


def test_mean_and_deviation_are_those_of_the_fits_whole_projection(fitted):
    """Of r^T W r / r^T r for r = P e, P = I - J J^+: moments of quadratic forms."""
    rays, some = fitted.rays, slice(None, None, 8)
    fitted = fitted._replace(
        rays=RayPoints(rays.p[some], rays.grid, rays.quantity),
        points=fitted.points[some],
        motion=fitted.motion[some],
        grids=fitted.grids[some],
    )
    rays, c = fitted.rays, fitted.coefficients
    changes = [rays.jacobian(c, fitted.points), rays.across(c) @ fitted.motion]
    J = _across(rays.surface(c)[1]) @ np.concatenate(changes, axis=2)
    J = J.reshape(-1, J.shape[2])
    J = J / np.linalg.norm(J, axis=0)
    P = np.eye(len(J)) - J @ np.linalg.pinv(J, rcond=1e-9)
    joined = neighbours(rays.p, fitted.grids)
    A = P @ np.kron(joined.toarray(), np.eye(2)) @ P
    freedom, trace = np.trace(P), np.trace(A)
    square = (2 * np.sum(A * A.T) + trace**2) / (freedom * (freedom + 2))
    unit = len(rays.p) / joined.nnz
    told = whiteness(fitted)
    mean, sd = trace / freedom, np.sqrt(square - (trace / freedom) ** 2)
    np.testing.assert_allclose([told.expected, told.sd], [unit * mean, unit * sd], 1e-6)


def test_poses_that_are_off_do_not_make_residuals_coloured(scene):
    rig, pixels, _, T, spline = scene
    off = T.copy()
    off[0, :3, 3] += [0.5, -0.5, 1.0]
    points = decoded_in(scene, own_space(scene, SplineOrder((5, 3))))
    calibrate = primary_by_order(rig.viewer, pixels, points, off, **spline)
    assert raised_until_white(calibrate, most=20).order == SplineOrder((5, 3))


def test_places_on_a_line_have_no_neighbours_and_are_refused_in_words():
    p = np.linspace(0, 1, 12)[:, None] * [1.0, 0.5]
    with pytest.raises(CalibrationError, match="12 features of a grid lie on a line"):
        neighbours(p, np.zeros(12, int))


def test_neighbours_are_of_one_grid_and_near():
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0))
    p = np.column_stack([x.ravel(), y.ravel()])
    joined = neighbours(np.vstack([p, p]), np.repeat([0, 1], len(p)))
    assert (joined != joined.T).nnz == 0
    assert joined[: len(p), len(p) :].nnz == 0
    i, j = joined[: len(p), : len(p)].nonzero()
    length = np.linalg.norm(p[i] - p[j], axis=1)
    assert length.max() < 1.5
    # All sides of the lattice and one diagonal in each cell.
    assert len(i) // 2 == 5 * 5 + 6 * 4 + 5 * 4


def test_across_a_bay_of_a_grid_are_no_neighbours():
    """Two arms of a lattice: the triangulation fills the bay between them."""
    x, y = np.meshgrid(np.arange(9.0), np.arange(9.0))
    p = np.column_stack([x.ravel(), y.ravel()])
    p = p[(p < 2).any(axis=1)]
    i, j = neighbours(p, np.zeros(len(p), int)).nonzero()
    length = np.linalg.norm(p[i] - p[j], axis=1)
    assert length.max() < 1.5
    assert np.count_nonzero(length < 1.1) // 2 == 2 * (2 * 8 + 9) - 4


def test_a_dynamic_stage_is_raised_until_white():
    rig = mirror_rig("A")
    flat, bent = (rig.camera(mm) for mm in STAGES_MM[:2])
    line = clamp_line(rig.viewer, rig.clamp_pixels(flat, CLAMP_PICKS))
    grid = spline_grid(
        np.vstack([normalised(rig.viewer, outline(flat)), line.points(CLAMP_PICKS)]),
        (7, 3), angle=line.angle,
    )  # fmt: skip
    # A flat mirror is a spline of inverse depth: what was before is known exactly.
    seen = flat.rays(lattice(flat, STEP_PX)).origins
    first = SplineMirrorCamera.fitted(rig.viewer, grid, seen)
    rng = np.random.default_rng(5)
    T = rig.board_pose(rng, deflections=STAGES_MM[:2])
    pictures = []
    for camera in (flat, bent):
        pixels, there = rig.corners(camera, T)
        pixels = pixels + rng.normal(0, 0.1, pixels.shape)
        pictures.append(np.where(there[:, None], pixels, np.nan))
    calibrate = stage_by_order(
        first, *pictures, rig.board.points(), fixed_line(first, line),
        outline=outline(bent),
    )  # fmt: skip
    found = raised_until_white(calibrate)
    assert found.white
    assert len(found.steps) > 1
    # Fewer functions than as published leave twice as much, and are seen to.
    assert found.steps[0].variance > 4 * found.steps[-1].variance


def test_where_no_higher_order_is_supported_the_residuals_are_told_not_white(scene):
    rough = decoded_in(scene, scene[0].camera(STAGES_MM[-1], 21.0, 2))

    def up_to_twenty(order):
        if order.size > 20:
            raise CalibrationError("no feature there")
        return primary(scene, rough)(order)

    found = raised_until_white(up_to_twenty)
    assert not found.white
    assert found.order.size <= 20
    assert found.reason == "no higher order is supported by the features"


def test_what_cannot_be_told_is_refused(scene):
    rig, pixels, points, T, spline = scene
    with pytest.raises(InputError, match="prior_sd"):
        stage_by_order(None, pixels, pixels, points, None, MirrorSettings(prior_sd=0.1))
    few = np.linspace(0, len(pixels) - 1, 7).astype(int)
    calibrate = primary_by_order(rig.viewer, pixels[few], points[:, few], T, **spline)
    with pytest.raises(CalibrationError):
        raised_until_white(calibrate)


def test_each_order_has_steps_up_that_are_larger():
    for order in (SplineOrder(), SplineOrder((9, 5), (4, 4))):
        for higher in order.raised():
            assert higher.size > order.size
    shapes = [higher.shape for higher in SplineOrder().raised()]
    assert shapes == [(5, 3), (6, 3), (4, 4), (4, 5), (5, 4)]
    assert len(SplineOrder((9, 5), (4, 4)).raised()) == 4
