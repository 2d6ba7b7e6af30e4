"""All stages of a bending mirror and the grids seen in it, adjusted together."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import Delaunay

from raxel.calibration.mirror.bundle import (
    BundleProblem,
    State,
    _misfit,
    _sightings,
    _spaces,
    _variance,
    _whitening,
    _widening,
    bundle_stages,
    moved,
    normalised,
)
from raxel.calibration.mirror.clamp import Clamp, ClampLine, clamped, fixed_line
from raxel.calibration.pose.three_point import moved_pose
from raxel.cameras import SplineMirrorCamera
from raxel.errors import InputError
from raxel.geometry.poses import pose
from tests.mirror_scenes import (
    VIEWER,
    H,
    W,
    board_pose,
    flexible_camera,
    spline_camera,
    stage_pictures,
)
from tests.raised import raises_code

DEFLECTIONS = 0.0, 5.0, 10.0, 15.0
PAIRS = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (3, 2)]
SD = 0.2


def seen_by(stages, coefficients):
    """A problem whose views show these stages, each of a dozen coefficients."""
    space = SimpleNamespace(directions=np.eye(coefficients))
    return SimpleNamespace(
        layout=lambda state: (0, coefficients * 2),
        residuals=lambda state: (state, None),
        spaces=[space, space],
        seen=[SimpleNamespace(stage=stage, unknown_sd=False) for stage in stages],
    )


def poses():
    rng = np.random.default_rng(3)
    return np.stack(
        [
            board_pose([5, 8, 5] * rng.standard_normal(3), 6 * rng.standard_normal(3))
            for _ in range(3)
        ]
    )


def clamp_rows(camera):
    """The firm clamp of a camera, at the right border of its knots."""
    u, v = camera.grid.breaks
    line = np.column_stack([np.full(7, u[-1]), np.linspace(v[0], v[-1], 7)])
    b, b_x, b_y = camera.grid.rows(line)
    c = camera.coefficients.ravel("F")
    return Clamp(line, b @ c, np.column_stack([b_x @ c, b_y @ c]))


@lru_cache
def own_space():
    """Spline mirrors with one clamp, and noise-free images."""
    first = spline_camera(deflection=0.0)
    clamp, cameras = clamp_rows(first), [first]
    for deflection in DEFLECTIONS[1:]:
        near = spline_camera(deflection=deflection)
        space = clamped(near.grid, clamp)
        c = space.coefficients(space.free(near.coefficients.ravel("F")))
        cameras.append(SplineMirrorCamera.on_grid(VIEWER, near.grid, c))
    return cameras, clamp, stage_pictures(cameras, PAIRS, poses())


def shaken(cameras, seed=0):
    """Starts: every stage but the first a little off, and poses."""
    rng = np.random.default_rng(seed)
    starts = [
        SplineMirrorCamera.on_grid(
            VIEWER,
            camera.grid,
            camera.coefficients.ravel("F")
            * (1 + 2e-4 * rng.standard_normal(camera.grid.size)),
        )
        for camera in cameras[1:]
    ]
    steps = np.column_stack([0.01 * rng.standard_normal((3, 3)), np.ones((3, 3))])
    T = [moved_pose(T, step) for T, step in zip(poses(), steps, strict=True)]
    return [cameras[0], *starts], np.stack(T)


def noisy(views, seed):
    rng = np.random.default_rng(seed)
    found = []
    for stage in views:
        pixels = stage.view.pixels
        sd = np.full(len(pixels), SD)
        pixels = pixels + SD * rng.standard_normal(pixels.shape)
        found.append(stage._replace(view=stage.view._replace(pixels=pixels, sd=sd)))
    return found


def image_lattice():
    v, u = np.mgrid[0:H:90, 0:W:90]
    return np.column_stack([u.ravel(), v.ravel()]).astype(float)


def ray_errors(found, true, pixels):
    """Angles (N,), radians, between the rays of two cameras, NaN where one has none."""
    a, b = found.rays(pixels), true.rays(pixels)
    return np.linalg.norm(np.cross(a.directions, b.directions), axis=1)


def normalised_square(error, covariance):
    """Squared error over the covariance, for each dimension that it has."""
    values, vectors = np.linalg.eigh(covariance)
    free = values > 1e-9 * values[-1]
    return np.mean((vectors[:, free].T @ error) ** 2 / values[free])


def test_bundle_recovers_shapes_and_poses_exactly():
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    found = bundle_stages(starts, views, T, clamp=clamp)
    for one, true in zip(found.cameras, cameras, strict=True):
        np.testing.assert_allclose(one.coefficients, true.coefficients, rtol=1e-9)
    np.testing.assert_allclose(found.T_camera_grid, poses(), atol=1e-6)
    assert max(np.abs(r).max() for r in found.residuals) < 1e-6
    assert found.converged
    assert not found.misfit.any()


def test_jacobian_equals_differences():
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    spaces = _spaces(starts, clamp, None)
    pairs = zip(spaces, starts, strict=True)
    state = State([s.free(c.coefficients.ravel("F")) for s, c in pairs], T)
    seen = _sightings(tuple(starts), views, T)
    empty = [(np.zeros((0, c.grid.size)), np.zeros(0)) for c in starts]
    problem = BundleProblem(
        seen, spaces, empty, _whitening(seen, spaces, state, np.ones(len(cameras)))
    )
    begins, size = problem.layout(state)
    view, whiten = problem.seen[3], problem.whiten[3]
    by_shape, by_pose = problem.jacobians(view, whiten, state)
    pose = begins[-1] + 6 * view.grid
    for columns, J in ((begins[view.stage], by_shape), (pose, by_pose)):
        for k in range(J.shape[1]):
            step = np.zeros(size)
            step[columns + k] = 1e-4 / np.abs(J[:, k]).max()
            up, down = (
                problem.residuals(moved(state, s))[0][3].ravel() for s in (step, -step)
            )
            np.testing.assert_allclose(
                J[:, k], (up - down) / (2 * step[columns + k]),
                atol=1e-6 * np.abs(J[:, k]).max(),
            )  # fmt: skip


def test_bundle_covariance_predicts_errors():
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    pixels, shapes, rays, variances = image_lattice(), [], [], []
    for seed in range(10):
        found = bundle_stages(starts, noisy(views, seed), T, clamp=clamp)
        variances.append(found.variance)
        for stage in range(1, 4):
            one, true = found.cameras[stage], cameras[stage]
            off = (one.coefficients - true.coefficients).ravel("F")
            shapes.append(normalised_square(off, found.coefficient_covariance(stage)))
            angles = ray_errors(one, true, pixels)
            rays.append(np.nanmean(angles**2 / 2 / found.ray_sd(stage, pixels) ** 2))
    assert 0.9 < np.mean(variances) < 1.1
    assert 0.7 < np.mean(shapes) < 1.4
    assert 0.7 < np.mean(rays) < 1.4


def test_uncertain_first_shape_is_re_estimated():
    cameras, clamp, views = own_space()
    first = cameras[0]
    c = first.coefficients.ravel("F")
    covariance = (1e-6 * np.mean(c)) ** 2 * np.eye(len(c))
    squares = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        wrong = c + rng.multivariate_normal(np.zeros(len(c)), covariance)
        starts, T = shaken(cameras)
        starts[0] = SplineMirrorCamera.on_grid(VIEWER, first.grid, wrong)
        found = bundle_stages(
            starts, noisy(views, seed), T, clamp=clamp, first_covariance=covariance
        )
        for stage in (0, 3):
            off = found.cameras[stage].coefficients - cameras[stage].coefficients
            spread = found.coefficient_covariance(stage)
            squares.append(normalised_square(off.ravel("F"), spread))
    assert 0.6 < np.mean(squares) < 1.6


def test_bundle_fits_physical_sheet_and_reports_misfit():
    """Elastica, 3 mm hidden by the holder: a line that stands in for the clamp."""
    true = [flexible_camera(d) for d in DEFLECTIONS]
    starts = [spline_camera(deflection=d) for d in DEFLECTIONS]
    u, v = starts[0].grid.breaks
    ends = np.array([[u[-1], v[0]], [u[-1], v[-1]]])
    line = ClampLine(ends, 0.0, 1e-6, 1e-6, np.ones(8, bool), 0.0)
    held = fixed_line(starts[0], line, hidden=3.0, length=150.0, deflection=15.0)
    views, pixels = stage_pictures(true, PAIRS, poses()), image_lattice()
    angles, ratios = [], []
    for seed in range(4):
        found = bundle_stages(starts, noisy(views, seed), poses(), clamp=held)
        for stage in range(1, 4):
            off = ray_errors(found.cameras[stage], true[stage], pixels)
            angles.append(np.degrees(np.nanmean(off)))
            hull = Delaunay(found.corners[stage])
            among = hull.find_simplex(normalised(true[stage].viewer, pixels)) >= 0
            among &= np.isfinite(off)
            message = found.ray_sd(stage, pixels)[among]
            ratios.append(np.mean(off[among] ** 2 / 2) / np.mean(message**2))
    assert np.all(np.reshape(angles, (4, 3)).mean(axis=0) < [0.03, 0.05, 0.08])
    assert 0.5 < np.mean(ratios) < 2
    assert np.all(np.reshape(ratios, (4, 3)).mean(axis=0) < 3)
    # A clamp that is held where it is not: the residuals show it.
    firm = bundle_stages(starts, noisy(views, 0), poses(), clamp=clamp_rows(starts[0]))
    assert firm.variance > 5 * found.variance


def test_stage_without_previous_grid_is_less_certain():
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    pixels = image_lattice()
    whole = bundle_stages(starts, noisy(views, 1), T, clamp=clamp)
    parted = noisy([views[0], views[1], *views[3:]], 1)
    parted = bundle_stages(starts, parted, T, clamp=clamp)
    known, lost = (found.ray_sd(2, pixels) for found in (whole, parted))
    assert np.nanmean(lost) > 1.5 * np.nanmean(known)


def test_bundle_rejects_undetermined_shape():
    cameras, clamp, views = own_space()
    starts, T = shaken(cameras)
    # Without the corners at the free edge, what they support is named.
    pixels = views[5].view.pixels
    near = np.where(pixels[:, :1] > 1300, pixels, np.nan)
    near = views[5]._replace(view=views[5].view._replace(pixels=near))
    aside = views[1].view._replace(pixels=views[1].view.pixels + [2900, 0])
    for rejected, arguments in (
        (raises_code("no-feature-at-end"), (starts, views[:5], T)),
        (raises_code("open-coefficients"), (starts, views, [*T, T[0]])),
        (raises_code("no-feature-at-end"), (starts, [*views[:5], near], T)),
        (
            pytest.raises(InputError, match="stage 4 and grid 0"),
            (starts, [views[0]._replace(stage=4)], T),
        ),
        (raises_code("too-few-corners"), (starts, [views[1]._replace(view=aside)], T)),
    ):
        with rejected:
            bundle_stages(*arguments, clamp=clamp)


@pytest.mark.parametrize("misfit", [0.0, 4e-4])
def test_bundle_misfit_is_ray_error_beyond_noise(misfit):
    """Noise of 3e-4 and misfit, radians; points 300 mm from the mirror along z."""
    rng, count, noise = np.random.default_rng(41), 4000, 3e-4
    off = np.hypot(noise, misfit) * rng.standard_normal((count, 2))
    rays = SimpleNamespace(
        surface=lambda c: (np.zeros((count, 3)), np.tile([0.0, 0, 1], (count, 1))),
        residuals=lambda c, placed: 300 * np.pad(off, ((0, 0), (0, 1))),
    )
    view = SimpleNamespace(
        unknown_sd=False, points=np.zeros((count, 2)), grid=0, stage=1, rays=rays
    )
    problem = SimpleNamespace(coefficients=lambda state: [None, None], seen=[view])
    state = SimpleNamespace(T=pose(np.eye(3), [[0.0, 0, 300]]))
    found = _misfit(problem, state, [off / noise])
    np.testing.assert_allclose(found, [0, misfit], rtol=0.05)


def test_misfit_does_not_bias_first_shape():
    """60 um of unevenness: corners at 0.2 px claim more than a spline can follow.

    With the variance of all stages at the first one too it is 0.72 deviations.
    """
    true = [flexible_camera(d, aberration=0.06, seed=5) for d in DEFLECTIONS]
    starts = [spline_camera(deflection=d) for d in DEFLECTIONS]
    c = starts[0].coefficients
    covariance = (1e-5 * np.mean(c)) ** 2 * np.eye(c.size)
    views = noisy(stage_pictures(true, PAIRS, poses()), 0)
    found = bundle_stages(starts, views, poses(), first_covariance=covariance)
    carried = (found.cameras[0].coefficients - c) / (1e-5 * np.mean(c))
    assert found.variance > 100
    assert np.abs(carried).max() < 0.4


def test_bundle_noise_of_few_corners_is_unbiased():
    """Of three views with 24 numbers, sixteen are taken by what is fitted."""
    rng, problem = np.random.default_rng(40), SimpleNamespace(layout=lambda s: (0, 16))
    basis = np.linalg.qr(rng.normal(size=(24, 16)))[0]
    found = []
    for _ in range(600):
        off = rng.standard_normal(24)
        off -= basis @ (basis.T @ off)
        variance, freedom = _variance(problem, off.reshape(3, 4, 2), None)
        found.append(variance)
    assert freedom == 8
    # Of 600 draws of a chi square with 8, the mean is known to 2 %.
    assert np.mean(found) == pytest.approx(1, abs=0.08)


def test_misfit_threshold_separates_noise():
    rng, problem = np.random.default_rng(42), seen_by([0, 1], 12)
    reported = {1.0: [], 1.25: []}
    for _ in range(1000):
        # Of 424 numbers, 24 are taken by what is fitted: a deviation is 0.07.
        off = rng.standard_normal(424)
        off *= np.sqrt(400 / 424)
        for variance, found in reported.items():
            views = np.sqrt(variance) * off.reshape(2, 106, 2)
            found.append(np.any(_widening(problem, views) != 1))
    assert np.mean(reported[1.0]) < 0.01
    assert np.mean(reported[1.25]) > 0.6


def test_misfit_weight_is_independent_of_corner_count():
    """The mean of all numbers of the first shape, of which the misfit has twelve."""
    problem, rng, count = seen_by([0, 1], 12), np.random.default_rng(43), 600
    widening, means = [], []
    for _ in range(400):
        misfit = np.repeat(3 * rng.standard_normal(12), count // 12)
        off = (rng.standard_normal(count) + misfit).reshape(-1, 2)
        widening.append(_widening(problem, [off, off])[0])
        means.append(off.mean())
    assert np.mean(widening) / count == pytest.approx(np.var(means), rel=0.2)
