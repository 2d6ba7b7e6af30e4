"""Points from rays, and poses with points: derivatives, recovery, coverage."""

import numpy as np
import pytest

from raxel.cameras import Rays
from raxel.errors import CalibrationError
from raxel.geometry.poses import (
    inverse_pose,
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from raxel.multiview import bundle_rays, refine_generalised_pose
from raxel.multiview.points import (
    PlacedPoints,
    PointSystem,
    RayTracks,
    RayView,
    moved_points,
    moved_poses,
    triangulate,
)
from raxel.multiview.ray_noise import (
    angular_rays,
    depths_of_pairs,
    matched_rays,
    rays_of_pixels,
)
from tests.raised import raises_code
from tests.ray_scenes import ACROSS, BENT, SD_PX, by_rig, in_mirror, jittered, unit

TURN = np.array([0.3, 1.0, 0.2])
STAGE = np.array(
    [pose(rotation_from_vector(0.01 * k * TURN), 25 * k * ACROSS) for k in range(4)]
)
ROUGH = rotation_from_vector([3e-3, -2e-3, 2e-3])


def on_stage(seed, count=60, noise=True):
    """Points (count, 3), and RayViews of the bent mirror at the stage's four places;
    the last view sees two thirds of them, out of order."""
    rng = np.random.default_rng(seed)
    X, pixels = in_mirror(rng, count, STAGE[1:])
    if noise:
        pixels = [jittered(rng, x) for x in pixels]
    views = [RayView(rays_of_pixels(BENT, x, SD_PX)) for x in pixels]
    some = rng.permutation(count)[: 2 * count // 3]
    views[-1] = RayView(views[-1].rays.of(some), some)
    return X, views


def rough(Ts):
    """Starts: turned, and some mm off."""
    moved = [pose(ROUGH @ T[:3, :3], T[:3, 3] + [2.0, -1, 1]) for T in Ts[1:]]
    return np.array([Ts[0], *moved])


def steps_of(found, true):
    """(w, v) (6 V,) of poses (V, 4, 4) about a bundle's centre."""
    off = []
    for T, T_0 in zip(found.T_view_world, true, strict=True):
        turn = T[:3, :3] @ T_0[:3, :3].T
        shift = T[:3, 3] - found.centre - turn @ (T_0[:3, 3] - found.centre)
        off += [vector_from_rotation(turn), shift]
    return np.concatenate(off)


def mahalanobis(error, covariance):
    return np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariance), error)


def test_derivatives_equal_differences():
    X, views = on_stage(0)
    seen = RayTracks(views, metre=500.0, centre=(200.0, 0, 480))
    state = PlacedPoints(*seen.poses(rough(STAGE)), seen.homogeneous(X))
    system, h = PointSystem(seen, state), 1e-6

    def differences(move, k, count):
        step = np.zeros((count, 3 if count == len(X) else 6))
        step[:, k] = h
        sides = (PointSystem(seen, move(s)).residuals for s in (step, -step))
        return np.subtract(*sides) / (2 * h)

    def of_points(step):
        return state._replace(h=moved_points(state.h, step))

    by_points, by_poses = system.by_points(), system.by_poses()
    for k in range(3):
        numeric = differences(of_points, k, len(X))
        assert (
            np.abs(numeric - by_points[..., k]).max() < 1e-7 * np.abs(by_points).max()
        )
    for k in range(6):
        numeric = differences(lambda step: moved_poses(state, step), k, len(views))
        assert np.abs(numeric - by_poses[..., k]).max() < 1e-7 * np.abs(by_poses).max()


@pytest.mark.parametrize("linear", [True, False])
def test_triangulation_is_exact(linear):
    X, views = on_stage(1, noise=False)
    found = triangulate(views, STAGE, linear=linear)
    assert found.valid.all()
    assert np.abs(found.points - X).max() < 1e-8
    assert str(found) == "60 of 60 points"
    assert np.all((found.angle > 0.02) & (found.angle < 0.5))


def test_triangulation_covariance_predicts_errors():
    for linear, least in ((True, 0.93), (False, 0.935)):
        inside, variances = [], []
        for seed in range(12):
            X, views = on_stage(seed)
            found = triangulate(views, STAGE, linear=linear)
            inside.append(mahalanobis(found.points - X, found.covariance))
            variances.append(found.variance)
        assert np.mean(inside) == pytest.approx(3, abs=0.3)
        assert least < np.mean(np.concatenate(inside) < 7.815) < 0.97
        assert np.mean(variances) == pytest.approx(1, abs=0.15)


def test_point_distance_is_from_nearest_pivot():
    """Of two cameras, one much nearer than the other, in either order."""
    X = np.random.default_rng(8).uniform([-100, -100, 900], [100, 100, 1000], (30, 3))
    centres = np.array([[0.0, 0, 0], [150.0, 0, 600]])
    sight = [angular_rays(Rays(c + 0 * X, unit(X - c), None), 1e-3) for c in centres]
    for order in ([0, 1], [1, 0]):
        found = triangulate([RayView(sight[k]) for k in order], [np.eye(4)] * 2)
        assert found.valid.all()
        along = found.points - centres[1]
        away = np.linalg.norm(along, axis=1)
        variance = np.einsum("ni,nij,nj->n", along, found.covariance, along)
        np.testing.assert_allclose(found.distance_sd, np.sqrt(variance) / away**2)


def test_unknown_noise_follows_from_point_scatter():
    _, views = on_stage(2, 200)
    stated = triangulate(views, STAGE)
    wrong = [v._replace(rays=v.rays._replace(covariance=9 * v.rays.covariance))
             for v in views]  # fmt: skip
    reported = triangulate(wrong, STAGE, stated=False)
    np.testing.assert_allclose(reported.points, stated.points, atol=1e-5)
    ratio = reported.covariance / stated.covariance
    np.testing.assert_allclose(ratio, stated.variance, rtol=1e-4)
    assert stated.variance == pytest.approx(1, abs=0.15)
    assert np.median(stated.rms) < 1


def test_undetermined_points_are_flagged():
    rng = np.random.default_rng(3)
    _, pixels = in_mirror(rng, 50, STAGE[1:2])
    one, two = (rays_of_pixels(BENT, x, SD_PX) for x in pixels)
    half = RayView(two.of(slice(25)), np.arange(25))
    found = triangulate([RayView(one), half], STAGE[:2])
    assert (found.reason == "fewer than two rays").sum() == 25
    assert np.isnan(found.points[25:]).all()
    assert np.isfinite(found.points[:25]).all()
    assert str(found) == "25 of 50 points; left out: 25 fewer than two rays"

    still = triangulate([RayView(one), RayView(one)], STAGE[[0, 0]])
    assert set(still.reason) == {"parallel rays"}
    assert not still.valid.any()
    assert np.isinf(still.distance_sd).all()
    # Two hundredths of a millimetre of baseline do not carry these distances.
    near = pose(np.eye(3), 0.02 * ACROSS)
    _, pixels = in_mirror(rng, 50, [near])
    views = [RayView(rays_of_pixels(BENT, jittered(rng, x), SD_PX)) for x in pixels]
    for linear in (True, False):
        found = triangulate(views, [np.eye(4), near], linear=linear)
        assert set(found.reason) <= {"open distance", "behind a ray"}
        assert (found.reason == "open distance").mean() > 0.3

    far = pose(np.eye(3), 25 * ACROSS)
    _, pixels = in_mirror(rng, 50, [far])
    views = [RayView(rays_of_pixels(BENT, x, SD_PX)) for x in pixels]
    for linear in (True, False):
        found = triangulate(views, [np.eye(4), inverse_pose(far)], linear=linear)
        assert set(found.reason) == {"behind a ray"}


def test_point_at_infinity_is_excluded():
    rng = np.random.default_rng(4)
    X, pixels = in_mirror(rng, 40, STAGE[1:2], near=3e5, far=9e5)
    views = [RayView(rays_of_pixels(BENT, jittered(rng, x), SD_PX)) for x in pixels]
    assert (triangulate(views, STAGE[:2]).reason != "").all()
    both = bundle_rays(views, STAGE[:2], held=1)
    # Their directions still hold the rotation, and they stay in the fit.
    assert both.open_points.mean() > 0.9
    assert both.rotation_sd(1) < 1e-3
    assert len(X) == both.used.sum()


@pytest.mark.parametrize("held", [None, 3])
def test_ray_bundle_converges_from_rough_start(held):
    X, views = on_stage(5, noise=False)
    start = rough(STAGE)
    if held:
        # What is held is right at the start.
        start[held] = STAGE[held]
    found = bundle_rays(views, start, held=held)
    assert found.converged
    assert np.abs(found.T_view_world - STAGE).max() < 1e-7
    assert np.abs(found.points - X).max() < 1e-5
    assert found.used.all()
    assert not found.open_points.any()
    assert found.rays == 220
    assert len(found.costs) < 10


@pytest.mark.parametrize("held", [None, 3])
def test_ray_bundle_covariance_predicts_errors(held):
    poses, points = [], []
    for seed in range(25):
        X, views = on_stage(seed, 40)
        found = bundle_rays(views, STAGE, held=held)
        error = steps_of(found, STAGE)[6:]
        covariance = found.covariance[6:, 6:]
        size = np.sqrt(np.diag(covariance))
        inverse = np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-12)
        poses.append((error / size) @ inverse @ (error / size))
        points.append(mahalanobis(found.points - X, found.point_covariance))
        if held:
            assert found.scale_sd(held) < 1e-6
    assert np.mean(poses) == pytest.approx(17 if held else 18, abs=4)
    assert np.mean(points) == pytest.approx(3, abs=0.6)


def test_two_view_bundle_equals_pair_motion():
    _, views = on_stage(6)
    bundle = bundle_rays(views[:2], STAGE[:2])
    pairs = refine_generalised_pose(views[0].rays, views[1].rays, STAGE[1])
    sd = np.sqrt(np.diag(bundle.covariance)[6:])
    assert np.all(np.abs(steps_of(bundle, [STAGE[0], pairs.T_2_1])[6:]) < 0.02 * sd)
    assert bundle.scale_sd(1) == pytest.approx(pairs.scale_sd / pairs.rms, rel=0.1)
    turn_sd = pairs.rotation_sd / pairs.rms
    assert bundle.rotation_sd(1) == pytest.approx(turn_sd, rel=0.1)
    # Each pair has one equation more than its point has numbers.
    assert bundle.variance * 54 == pytest.approx(60 * pairs.rms**2, rel=1e-3)


@pytest.mark.parametrize(("held", "unknowns"), [(None, 18), (3, 17)])
def test_ray_bundle_variance_counts_unknowns(held, unknowns):
    """Two equations a ray; three numbers a point, six a pose but the first, less one
    where a distance is held."""
    _, views = on_stage(10, 12)
    found = bundle_rays(views, STAGE, held=held)
    freedom = 2 * found.rays - 3 * found.used.sum() - unknowns
    assert found.variance * freedom == pytest.approx(found.costs[-1])
    assert found.rms**2 * 2 * found.rays == pytest.approx(found.costs[-1])


def test_ray_bundle_estimates_unknown_noise():
    _, views = on_stage(11, 20)
    stated = bundle_rays(views, STAGE)
    wrong = [v._replace(rays=v.rays._replace(covariance=9 * v.rays.covariance))
             for v in views]  # fmt: skip
    reported = bundle_rays(wrong, STAGE, stated=False)
    for name in ("covariance", "point_covariance"):
        found, known = (
            np.trace(getattr(b, name), 0, -2, -1) for b in (reported, stated)
        )
        np.testing.assert_allclose(found / known, stated.variance, rtol=1e-3)


def test_more_views_improve_length():
    _, views = on_stage(7)
    two, all_four = bundle_rays(views[:2], STAGE[:2]), bundle_rays(views, STAGE)
    assert all_four.scale_sd(1) < 0.5 * two.scale_sd(1)
    assert all_four.rotation_sd(1) < two.rotation_sd(1)
    assert np.linalg.norm(all_four.shift(1)) == pytest.approx(25, rel=0.2)


def test_central_rig_keeps_given_length():
    T = pose(rotation_from_vector([0.2, -0.1, 0.3]), [120.0, 40, -90])
    X, A, B = by_rig(np.random.default_rng(8), 60, T, sd=1e-4, spread=False)
    views = [RayView(A), RayView(B)]
    with raises_code("no-scale"):
        bundle_rays(views, [np.eye(4), T])
    found = bundle_rays(views, rough([np.eye(4), T]), held=1)
    length = np.linalg.norm(rough([np.eye(4), T])[1][:3, 3])
    assert np.linalg.norm(found.T_view_world[1][:3, 3]) == pytest.approx(length)
    scaled = np.linalg.norm(T[:3, 3]) / length * found.points
    close = np.linalg.norm(X, axis=1) < 1500
    assert np.abs(scaled - X)[close].max() < 20


def test_ray_bundle_rejects_invalid_input():
    X, views = on_stage(9, 20)
    few = [RayView(v.rays.of(slice(4)), np.arange(4)) for v in views]
    alone = [*views[:3], RayView(views[3].rays, np.arange(20, 20 + 13))]
    twice = RayView(views[0].rays, np.zeros(20, int))
    rejected = [
        ("4 views and poses", lambda: triangulate(views, STAGE[:3])),
        ("along two rays", lambda: triangulate([twice, *views[1:]], STAGE)),
        ("numbers .* for 20 rays", lambda: triangulate(
            [RayView(views[0].rays, [1, 2])], STAGE[:1])),
        ("1 views", lambda: bundle_rays(views[:1], STAGE[:1])),
        ("shares 4 points", lambda: bundle_rays(few, STAGE)),
        ("view 3 shares 0 points", lambda: bundle_rays(alone, STAGE)),
        ("found view 7", lambda: bundle_rays(views, STAGE, held=7)),
        ("found points", lambda: bundle_rays(views, STAGE, points=X[:5])),
        ("must be finite", lambda: bundle_rays(views, np.nan * STAGE)),
        ("views: found NoisyRays", lambda: triangulate([v.rays for v in views], STAGE)),
    ]  # fmt: skip
    for words, call in rejected:
        with pytest.raises(CalibrationError, match=words) as refusal:
            call()
        assert "\n" not in str(refusal.value)


def test_minimal_bundle_gives_no_scatter():
    views = [RayView(view.rays.of(np.arange(5))) for view in on_stage(7)[1][:2]]
    found = bundle_rays(views, STAGE[:2], stated=False)
    assert np.isnan(found.variance)
    assert not found.scale_sd(1) < 1
    assert found.open_points.all()


def test_depth_is_along_own_ray():
    rng, T = np.random.default_rng(8), STAGE[3]
    origins = rng.normal(0, 20, (2, 12, 3))
    points = rng.uniform([-200, -200, 300], [200, 200, 900], (12, 3))
    ways = np.array([points, transform(T, points)]) - origins
    # Half of the first camera's rays look the other way: their points lie behind it.
    true = np.linalg.norm(ways, axis=2) * [np.repeat([1, -1], 6), np.ones(12)]
    pairs = matched_rays(*map(Rays, origins, ways / true[..., None], 2 * [None]))
    depths = depths_of_pairs(*pairs.about_centre(T), pairs)
    np.testing.assert_allclose(depths, true.T, rtol=1e-9)
