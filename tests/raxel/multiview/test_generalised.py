"""Motion of a general camera from matched rays: linear, robust, refined, observable."""

from math import comb

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera, Rays
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector, vector_from_rotation
from raxel.multiview import generalised_motion as generalised_robust
from raxel.multiview.generalised_motion import (
    MotionInformation,
    generalised_pose_ransac,
    motion_information,
    refine_generalised_pose,
)
from raxel.multiview.motion_samples import (
    epipolar_angles,
    sampled_motions,
    squared_gaps,
    turning_pairs,
)
from raxel.multiview.ray_noise import (
    NoisyRays,
    angular_rays,
    gap_system,
    gaps,
    matched_rays,
    moved_motion,
    rays_of_pixels,
)
from tests.raised import raises_code
from tests.ray_scenes import (
    ACROSS,
    BENT,
    SD_PX,
    T_MIRROR,
    VIEWER,
    by_rig,
    in_mirror,
    jittered,
    off,
    unit,
    wrong_pairs,
)

T_RIG = pose(rotation_from_vector([0.4, -0.2, 0.6]), [150.0, -80.0, 220.0])


def mirror_rays(seed, count=60, sd=SD_PX, noise=True, T=T_MIRROR):
    """NoisyRays of the bent mirror before and after a motion, and a generator."""
    rng = np.random.default_rng(seed)
    _, pixels = in_mirror(rng, count, [T])
    if noise:
        pixels = [jittered(rng, x, sd) for x in pixels]
    return *(rays_of_pixels(BENT, x, sd) for x in pixels), rng


def length_of(A, B, T):
    return np.linalg.norm(matched_rays(A, B).about_centre(T)[1])


def test_bent_mirror_motion_and_length_are_exact():
    A, B, rng = mirror_rays(0, noise=False)
    start = generalised_pose_ransac(A, B, rng, 1e-3)
    assert np.abs(start.T_2_1 - T_MIRROR).max() < 1e-6
    assert start.ahead == 1.0
    found = refine_generalised_pose(A, B, start)
    assert np.abs(found.T_2_1 - T_MIRROR).max() < 1e-9
    assert found.scale_determined
    assert found.baseline == pytest.approx(length_of(A, B, T_MIRROR), rel=1e-10)


@pytest.mark.parametrize(
    "scene",
    [
        {"crossing": False},
        {"crossing": True},
        {"cameras": 2},
        {"cameras": 2, "crossing": False},
    ],
    ids=["locally central", "crossing", "two cameras", "both"],
)
def test_rig_motion_is_exact(scene):
    rng = np.random.default_rng(1)
    _, A, B = by_rig(rng, 80, T_RIG, sd=0.0, **scene)
    found = generalised_pose_ransac(A, B, rng, 1e-3)
    assert np.abs(found.T_2_1 - T_RIG).max() < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_motion_ransac_rejects_30_percent_outliers(seed):
    A, B, rng = mirror_rays(seed, 150)
    B, wrong = wrong_pairs(rng, B, 0.3)
    found = generalised_pose_ransac(A, B, rng, 3.5)
    assert found.inliers[~wrong].mean() > 0.97
    assert found.inliers[wrong].mean() < 0.05
    reported = motion_information(T_MIRROR, A.of(~wrong), B.of(~wrong))
    turn, aside, length = off(found.T_2_1, T_MIRROR, found.centre)
    assert turn < 4 * reported.rotation_sd
    assert aside < 4 * reported.direction_sd
    assert abs(length - 1) < 4 * reported.scale_sd
    assert found.rms == pytest.approx(1, abs=0.25)


@pytest.mark.parametrize("scene", [{}, {"flat": True}, {"depth": (5000, 20000)}])
def test_rig_ransac_handles_flat_and_distant_scenes(scene):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        _, A, B = by_rig(rng, 150, T_RIG, **scene)
        B, wrong = wrong_pairs(rng, B, 0.3)
        found = generalised_pose_ransac(A, B, rng, 3.5)
        assert found.inliers[~wrong].mean() > 0.97
        best = refine_generalised_pose(A.of(found.inliers), B.of(found.inliers), T_RIG)
        assert found.rms <= 1.001 * best.rms


def test_known_length_finds_short_motion():
    """25 mm and 25 points at 0.2 px of an image four times as large (5.3.5)."""
    T = pose(np.eye(3), 25 * ACROSS)
    turns, sides, reported = [], [], []
    for seed in range(12):
        A, B, rng = mirror_rays(seed, 25, T=T)
        found = generalised_pose_ransac(A, B, rng, 3.5, length=25.0)
        turn, aside, length = off(found.T_2_1, T, found.centre)
        assert length == pytest.approx(length_of(A, B, T) ** -1 * 25, rel=1e-9)
        assert found.scale_sd < 1e-6
        turns.append(turn)
        sides.append(aside)
        known = np.linalg.inv(motion_information(T, A, B).information[:5, :5])
        reported.append([np.sqrt(known.diagonal()[s].sum()) for s in np.s_[:3, 3:]])
    expected = np.mean(reported, axis=0)
    assert 0.5 < np.sqrt(np.mean(np.square(turns))) / expected[0] < 1.6
    assert 0.5 < np.sqrt(np.mean(np.square(sides))) / expected[1] < 1.6


@pytest.mark.parametrize("sd", [0.32, 0.34])
def test_length_is_determined_to_a_third(sd):
    """Three standard deviations are then as long as the motion."""
    found = MotionInformation(np.diag([1e4] * 5 + [sd**-2]), 10.0, np.zeros(3), 1.0)
    assert (found.scale_sd, found.scale_determined) == (pytest.approx(sd), 3 * sd < 1)


def test_angular_rays_rotate_about_closest_points():
    rng = np.random.default_rng(14)
    about = np.array([5.0, -30.0, 12.0])
    directions = unit(rng.normal(size=(20, 3)))
    rays = Rays(rng.uniform(-50, 50, (20, 3)), directions, np.ones(20, bool))
    pivots, sd = angular_rays(rays, 2e-3, about=about).pivots()
    np.testing.assert_allclose(sd, 2e-3)
    np.testing.assert_allclose(np.sum((pivots - about) * directions, 1), 0, atol=1e-9)
    off = np.cross(pivots - rays.origins, directions)
    np.testing.assert_allclose(off, 0, atol=1e-9)


def test_minimal_pairs_give_no_uncertainty():
    A, B, _ = mirror_rays(2)
    six = np.arange(6)
    found = refine_generalised_pose(A.of(six), B.of(six), T_MIRROR)
    assert np.isnan(found.covariance).all()
    assert not found.scale_determined


def test_jacobian_equals_differences():
    A, B, _ = mirror_rays(2)
    pairs = matched_rays(A, B)
    R, u = pairs.about_centre(T_MIRROR)
    state = moved_motion((R, u), np.array([2e-3, -1e-3, 3e-3, 1.0, 2, -1]))
    _, J = gap_system(*state, pairs)
    for k, h in enumerate([1e-6] * 3 + [1e-4] * 3):
        step = np.zeros(6)
        step[k] = h
        above, below = (gaps(*moved_motion(state, s), pairs) for s in (step, -step))
        numeric = (above - below) / (2 * h)
        assert np.abs(numeric - J[:, k]).max() < 1e-7 * np.abs(J[:, k]).max()


def test_central_gaps_equal_epipolar_angles():
    _, A, B = by_rig(np.random.default_rng(4), 30, T_RIG, sd=0.01, spread=False)
    plain = (Rays(x.origins, x.directions, None) for x in (A, B))
    pairs = matched_rays(*plain, about=np.zeros(3))
    step = pose(T_RIG[:3, :3], unit(T_RIG[:3, 3]))
    ours = gaps(T_RIG[:3, :3], T_RIG[:3, 3], pairs)
    theirs = epipolar_angles(step, A.directions, B.directions)
    np.testing.assert_allclose(np.abs(ours), np.abs(theirs), rtol=1e-9, atol=1e-14)


def test_pixel_noise_gives_unit_gaps():
    A, B, _ = mirror_rays(3, 400)
    pairs = matched_rays(A, B)
    r = gaps(*pairs.about_centre(T_MIRROR), pairs)
    assert np.sqrt(np.mean(r**2)) == pytest.approx(1, abs=0.12)
    # The pivots of a bent mirror's rays lie behind it, on its caustic.
    pivots, sd = A.pivots()
    assert np.einsum("ni,ni->n", pivots - A.origins, A.directions).max() < -50
    assert np.all((sd > 0.5 * SD_PX / 1900) & (sd < 4 * SD_PX / 1900))


def test_gaps_ignore_origin_along_ray():
    A, B, _ = mirror_rays(4, 30)
    slide = np.eye(6)
    slide[:3, 3:] = 70 * np.eye(3)
    slid = NoisyRays(
        A.origins + 70 * A.directions, A.directions, slide @ A.covariance @ slide.T
    )
    about = {"about": np.array([200.0, 0, 480])}
    one, other = matched_rays(A, B, **about), matched_rays(slid, B, **about)
    state = one.about_centre(T_MIRROR)
    # The pivot's noise is first order; so is the slide.
    np.testing.assert_allclose(gaps(*state, one), gaps(*state, other), rtol=1e-5)


def test_motion_covariance_and_information_predict_errors():
    inside, found, reported, stated = [], [], [], []
    for seed in range(40):
        A, B, _ = mirror_rays(seed, 40)
        best = refine_generalised_pose(A, B, T_MIRROR)
        true = best._replace(T_2_1=T_MIRROR).shift
        w = vector_from_rotation(best.T_2_1[:3, :3] @ T_MIRROR[:3, :3].T)
        error = np.concatenate([w, best.shift - true])
        inside.append(error @ np.linalg.solve(best.covariance, error))
        turn, aside, length = off(best.T_2_1, T_MIRROR, best.centre)
        found.append([turn, aside, np.log(length)])
        known = motion_information(T_MIRROR, A, B)
        reported.append([known.rotation_sd, known.direction_sd, known.scale_sd])
        stated.append([best.rotation_sd, best.scale_sd])
    # Chi square with six degrees, divided by a variance of 34.
    assert np.mean(inside) == pytest.approx(6.4, abs=1.9)
    assert np.mean(np.array(inside) < 14.1) > 0.85
    ratio = np.sqrt(
        np.mean(np.square(found), axis=0) / np.mean(np.square(reported), axis=0)
    )
    assert np.all((ratio > 0.75) & (ratio < 1.3))
    # What a motion states of itself is that bound, but for the scatter of 34 degrees.
    both = np.median(np.array(stated) / np.array(reported)[:, [0, 2]], axis=0)
    np.testing.assert_allclose(both, 1, atol=0.08)


def test_sampled_motions_are_independent_of_unit():
    A, B, _ = mirror_rays(5, 60)
    pairs = matched_rays(A, B)
    picks = np.random.default_rng(5).integers(60, size=(8, 7))
    samples = turning_pairs(pairs).of(picks)
    metres = samples._replace(p_1=samples.p_1 / 1000, p_2=samples.p_2 / 1000)
    R, u = sampled_motions(samples, pairs.spread, 3.5)
    again, shorter = sampled_motions(metres, pairs.spread / 1000, 3.5)
    assert len(R) > 8
    np.testing.assert_allclose(again, R, atol=1e-5)
    np.testing.assert_allclose(1000 * shorter, u, atol=1e-3 * np.abs(u).max())


def test_sample_gaps_equal_pair_gaps():
    """Where rays turn about points, as those of a rig do."""
    _, A, B = by_rig(np.random.default_rng(6), 40, T_RIG)
    pairs = matched_rays(A, B)
    R, u = pairs.about_centre(T_RIG)
    ours = squared_gaps(R[None], u[None], turning_pairs(pairs), 3.5)[0]
    np.testing.assert_allclose(np.sqrt(ours), np.abs(gaps(R, u, pairs)), rtol=1e-6)


def test_nearly_central_rays_determine_length_less():
    information = []
    for radius in (100.0, 10.0, 1.0, 0.0):
        _, A, B = by_rig(np.random.default_rng(6), 100, T_RIG, radius=radius)
        information.append(motion_information(T_RIG, A, B))
    scale = [x.scale_sd for x in information]
    assert scale[1] == pytest.approx(10 * scale[0], rel=0.3)
    assert scale[2] == pytest.approx(10 * scale[1], rel=0.3)
    assert scale[3] > 1e4
    assert [x.scale_determined for x in information] == [True, True, True, False]
    values, vectors = np.linalg.eigh(information[3].information)
    assert values[0] < 1e-9 * values[1]
    assert abs(vectors[5, 0]) > 0.999
    assert "undetermined" in str(information[3])
    assert "length determined: to" in str(information[0])


def test_central_camera_needs_given_length():
    rng = np.random.default_rng(7)
    _, A, B = by_rig(rng, 60, T_RIG, sd=0.0, spread=False)
    length = length_of(A, B, T_RIG)
    found = generalised_pose_ransac(A, B, rng, 10.0, length=length)
    assert np.abs(found.T_2_1 - T_RIG).max() < 1e-6


def test_twin_motion_puts_points_behind():
    _, A, B = by_rig(np.random.default_rng(12), 40, T_RIG, sd=0.0, spread=False)
    pairs = matched_rays(A, B, about=np.zeros(3))
    R, u = pairs.about_centre(T_RIG)
    twin = (2 * np.outer(unit(u), unit(u)) - np.eye(3)) @ R
    motions = np.stack([R, twin, R]), np.stack([u, u, -u])
    for motion in zip(*motions, strict=True):
        assert np.abs(gaps(*motion, pairs)).max() < 1e-3
    squared = squared_gaps(*motions, turning_pairs(pairs), 1.0)
    assert np.isfinite(squared[0]).all()
    assert np.isinf(squared[1:]).all()


def test_undetermined_motion_is_rejected():
    rng = np.random.default_rng(8)
    _, A, B = by_rig(rng, 60, T_RIG)
    _, one, two = by_rig(rng, 60, T_RIG, spread=False)
    _, still, turned = by_rig(rng, 60, pose(T_RIG[:3, :3], np.zeros(3)), spread=False)
    same, _, _ = mirror_rays(9, 40)
    few = A.of(slice(5)), B.of(slice(5))
    nan = A._replace(origins=np.where(np.arange(60)[:, None] == 3, np.nan, A.origins))
    long = A._replace(directions=1.1 * A.directions)
    rejected = [
        ("one point.*give the len", lambda: generalised_pose_ransac(one, two, rng, 3)),
        ("one point.*give the", lambda: refine_generalised_pose(one, two, T_RIG)),
        (
            "length: found -1",
            lambda: refine_generalised_pose(A, B, T_RIG, length=-1.0),
        ),
        (
            "pure rotation",
            lambda: generalised_pose_ransac(still, turned, rng, 3.5, length=1.0),
        ),
        ("pure rotation", lambda: generalised_pose_ransac(same, same, rng, 3.5)),
        ("5 pairs of rays; give 6", lambda: refine_generalised_pose(*few, T_RIG)),
        ("60 and 59 rays", lambda: refine_generalised_pose(A, B.of(slice(59)), T_RIG)),
        ("1 of 60 are not finite", lambda: refine_generalised_pose(nan, B, T_RIG)),
        ("not of length 1", lambda: refine_generalised_pose(long, B, T_RIG)),
        ("centre does not move", lambda: motion_information(np.eye(4), A, B)),
        ("above 0", lambda: angular_rays(A, 0.0)),
        ("2 of 2 pixels", lambda: rays_of_pixels(BENT, [[0, 0], [-5, 3]])),
    ]  # fmt: skip
    for words, call in rejected:
        with pytest.raises(CalibrationError, match=words) as refusal:
            call()
        assert "\n" not in str(refusal.value)
    mixed, _ = wrong_pairs(rng, B, 1.0)
    with raises_code("too-many-outliers"):
        generalised_pose_ransac(A, mixed, rng, 1e-3, most_trials=64)


def test_perspective_rays_rotate_about_centre():
    rays = rays_of_pixels(VIEWER, np.random.default_rng(10).uniform(50, 500, (40, 2)))
    pivots, sd = rays.pivots()
    assert np.abs(pivots).max() < 1e-9
    assert np.abs(sd * 1900 - 1).max() < 0.1
    pinhole = PerspectiveCamera([[500, 0, 320], [0, 500, 240], [0, 0, 1]], [], 640, 480)
    middle = rays_of_pixels(pinhole, [[320.0, 240.0]], 2.0)
    expected = np.zeros((6, 6))
    expected[3, 3] = expected[4, 4] = (2 / 500) ** 2
    np.testing.assert_allclose(middle.covariance[0], expected, atol=1e-9)


@pytest.mark.parametrize(("agreeing", "rejected"), [(1, False), (2, True)])
def test_chance_inliers_are_rejected(monkeypatch, agreeing, rejected):
    """Six pairs are fitted whatever they are. Of the others five or more agree, where
    `agreeing` of 14 do when they are matched at random, as often as is summed here."""
    count, some, samples = 14, 11, 2000
    gaps_of_all = np.where(np.arange(count) < agreeing, 0.0, np.inf)[None]
    monkeypatch.setattr(generalised_robust, "squared_gaps", lambda *_: gaps_of_all)
    p = (8 * agreeing + 1) / (8 * count + 1)
    tail = sum(comb(8, k) * p**k * (1 - p) ** (8 - k) for k in range(some - 6, 9))
    assert (samples * tail > 1) == rejected
    A, B, _ = mirror_rays(1, count=count)
    reported = None
    try:
        generalised_robust._check_chance(
            np.eye(3, 4), turning_pairs(matched_rays(A, B)), np.arange(count) < some,
            1.0, samples,
        )  # fmt: skip
    except CalibrationError as fault:
        reported = str(fault)
    assert (reported is not None) == rejected
    assert not rejected or "11 of 14 pairs agree with one motion, as many as by" in (
        reported
    )
