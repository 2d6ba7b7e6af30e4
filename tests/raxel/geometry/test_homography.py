"""Homographies: exactness, invariance, streaming equal to batch, robustness."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from raxel.errors import InputError
from raxel.geometry import apply_homography, homography_dlt, refine_homography
from raxel.geometry.homography import (
    OUTLIER_SIGMAS,
    homography_ransac,
    random_samples,
    robust_start,
    transfer_jacobian,
)
from raxel.geometry.homography_stream import fit_homography

H_TRUE = np.array([[1.2, 0.1, 5], [-0.2, 0.9, 3], [1e-4, -2e-4, 1]])
seeds = st.integers(0, 2**32 - 1)


def noisy_pairs(rng, n, sigma=0.0):
    source = rng.uniform(0, 1000, (n, 2))
    return source, apply_homography(H_TRUE, source) + rng.normal(0, sigma, (n, 2))


def same(H, G, tolerance):
    np.testing.assert_allclose(H / H[2, 2], G / G[2, 2], rtol=tolerance)


@pytest.mark.parametrize("n", [4, 5, 200])
def test_homography_is_exact_on_exact_points(n):
    source, target = noisy_pairs(np.random.default_rng(n), n)
    # Four random points may lie close to a line: hence the room above rounding.
    for H in (
        homography_dlt(source, target),
        refine_homography(H_TRUE, source, target),
    ):
        same(H, H_TRUE, 1e-8)
        assert np.linalg.norm(H) == pytest.approx(1)
        assert H[2] @ [*source.mean(axis=0), 1] > 0


@given(seeds)
def test_dlt_is_invariant_to_similarities(seed):
    rng = np.random.default_rng(seed)
    source, target = noisy_pairs(rng, 30, sigma=1.0)
    frames = []
    for _ in range(2):
        a, b = rng.normal(size=2)
        frames.append(np.array([[a, -b, 900 * b], [b, a, -700 * a], [0, 0, 1]]))
    T_s, T_t = frames
    H = homography_dlt(source, target)
    moved = homography_dlt(apply_homography(T_s, source), apply_homography(T_t, target))
    expected = T_t @ H @ np.linalg.inv(T_s)
    expected *= np.sign(np.vdot(expected, moved)) / np.linalg.norm(expected)
    np.testing.assert_allclose(moved, expected, atol=1e-9)


def test_homography_weights_scale_equations():
    rng = np.random.default_rng(5)
    source, target = noisy_pairs(rng, 20, sigma=1.0)
    weights = rng.integers(0, 3, 20)
    repeat = np.repeat(np.arange(20), weights**2)
    for estimate in (homography_dlt, lambda *a: refine_homography(H_TRUE, *a)):
        weighted = estimate(source, target, weights)
        same(weighted, estimate(source[repeat], target[repeat]), 1e-6)
    streamed = fit_homography(source, target, H_TRUE, weights=weights)
    same(streamed.H, homography_dlt(source, target, weights), 1e-9)


@pytest.mark.parametrize("field", ["use", "weights"])
@pytest.mark.parametrize("array", [np.ones(1), np.ones(19), np.ones((20, 1))])
def test_homography_rejects_wrong_number_of_weights(field, array):
    source, target = noisy_pairs(np.random.default_rng(5), 20)
    with pytest.raises(InputError, match=f"'{field}'"):
        fit_homography(source, target, H_TRUE, **{field: array})


def test_streamed_homography_equals_batch():
    source, target = noisy_pairs(np.random.default_rng(6), 1_000_000, sigma=0.5)
    # Image order: the first block is a narrow strip, as when rows come in one by one.
    order = np.argsort(source[:, 1])
    source, target = source[order], target[order]
    batch = homography_dlt(source, target)
    for start in (H_TRUE, homography_dlt(source[:9], target[:9])):
        fit = fit_homography(source, target, start)
        assert fit.count == 1_000_000
        same(fit.H, batch, 1e-9)


def test_streamed_homography_keeps_digits():
    source, target = noisy_pairs(np.random.default_rng(14), 5000)
    start = homography_dlt(source[::100], target[::100])
    same(fit_homography(source, target, start).H, H_TRUE, 1e-12)


def test_streamed_homography_skips_outliers_and_missing():
    source, target = noisy_pairs(np.random.default_rng(15), 500, sigma=0.5)
    target[:50] += 40.0
    source[50:60] = np.nan
    fit = fit_homography(source, target, H_TRUE, use=np.arange(500) < 480, limit=5.0)
    np.testing.assert_array_equal(np.flatnonzero(fit.inliers), np.arange(60, 480))
    same(fit.H, homography_dlt(source[60:480], target[60:480]), 1e-9)


def test_homography_covariance_predicts_scatter():
    rng = np.random.default_rng(16)
    source, target = noisy_pairs(rng, 100)
    draws, message = [], 0.0
    for _ in range(300):
        fit = fit_homography(source, target + rng.normal(0, 0.5, (100, 2)), H_TRUE)
        draws.append(fit.H.ravel())
        message = message + fit.covariance / 300
    found = np.cov(np.transpose(draws))
    # 300 draws give a standard deviation to 4 %; the DLT's equations have it unequal.
    ratio = np.sqrt(np.diag(message) / np.diag(found))
    assert np.all((ratio > 0.85) & (ratio < 1.15))


def test_jacobian_equals_differences():
    points = np.random.default_rng(7).uniform(0, 1000, (5, 2))
    J = transfer_jacobian(H_TRUE, points)
    for k in range(9):
        step = 1e-6 * max(abs(H_TRUE.flat[k]), 1e-3)
        moved = []
        for sign in (1, -1):
            H = H_TRUE.copy()
            H.flat[k] += sign * step
            moved.append(apply_homography(H, points))
        numeric = (moved[0] - moved[1]) / (2 * step)
        np.testing.assert_allclose(J[:, :, k], numeric, rtol=1e-5, atol=1e-4)


def test_refinement_reduces_transfer_error():
    source, target = noisy_pairs(np.random.default_rng(8), 40, sigma=20.0)
    cost = [
        np.sum((apply_homography(H, source) - target) ** 2)
        for H in (
            homography_dlt(source, target),
            refine_homography(homography_dlt(source, target), source, target),
            refine_homography(H_TRUE, source, target),
        )
    ]
    assert cost[1] < cost[0]
    assert cost[2] == pytest.approx(cost[1], rel=1e-9)


@pytest.mark.parametrize("share_wrong", [0.0, 0.3, 0.6])
def test_homography_ransac_finds_outliers(share_wrong):
    rng = np.random.default_rng(9)
    source, target = noisy_pairs(rng, 300, sigma=0.5)
    wrong = np.arange(300) < share_wrong * 300
    target[wrong] += rng.uniform(20, 500, (wrong.sum(), 2))
    H, inliers = homography_ransac(source, target, 3.0, rng)
    np.testing.assert_array_equal(inliers, ~wrong)
    same(H, homography_dlt(source[~wrong], target[~wrong]), 1e-12)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_ransac_threshold_is_in_target_frame(unit):
    """Few right pairs among wrong ones that lie a little beyond the threshold."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        source, target = noisy_pairs(rng, 60)
        wrong = np.arange(60) >= 18
        turn = rng.uniform(0, 2 * np.pi, wrong.sum())
        far = rng.uniform(6, 30, wrong.sum())
        target[wrong] += (far * [np.cos(turn), np.sin(turn)]).T
        _, inliers = homography_ransac(source, unit * target, unit * 3.0, rng)
        # One or two of the wrong ones may agree with the right ones by chance.
        assert inliers[~wrong].all()
        assert inliers[wrong].sum() <= 2


def test_ransac_is_reproducible():
    source, target = noisy_pairs(np.random.default_rng(10), 60, sigma=5.0)
    runs = [
        homography_ransac(source, target, 4.0, np.random.default_rng(3))
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0][0], runs[1][0])


def test_ransac_with_exactly_four_points():
    source, target = noisy_pairs(np.random.default_rng(11), 4)
    H, inliers = homography_ransac(source, target, 0.1, np.random.default_rng(0))
    assert inliers.all()
    same(H, H_TRUE, 1e-8)


def test_line_at_infinity_has_no_image():
    H = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 0]])
    assert np.isnan(apply_homography(H, [[0.0, 1]])).all()
    np.testing.assert_array_equal(apply_homography(H, [[2.0, 4]]), [[1, 2]])


@pytest.mark.parametrize("sigma", [0.02, 3.0])
def test_robust_start_cuts_at_sigmas(sigma):
    """A standard deviation per axis, estimated from the pairs' distances."""
    rng = np.random.default_rng(7)
    source, target = noisy_pairs(rng, 8000, sigma)
    _, limit = robust_start(source, target, rng)
    assert limit == pytest.approx(OUTLIER_SIGMAS * sigma, rel=0.05)
    _, given = robust_start(source, target, rng, sigma)
    assert given == pytest.approx(OUTLIER_SIGMAS * sigma)


square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
line = np.outer(np.arange(9.0), [1, 2]) + [5, 6]
scattered = np.random.default_rng(12).normal(size=(9, 2))
REJECTED = {
    "three points": (square[:3], square[:3], "at least 4|at least four"),
    "not a number": (square * [1, np.nan], square, "not finite|0 usable pairs"),
    "shapes differ": (square, square[:3], "two equal arrays"),
    "all on one line": (line, scattered, "collinear"),
    "target on one line": (scattered, line, "collinear"),
    "three of four on one line": (
        np.array([[0, 0], [1, 0], [2, 0], [0, 1.0]]),
        np.array([[0, 0], [1, 0], [2, 0], [0, 1.0]]),
        "collinear",
    ),
    "one point repeated": (np.ones((6, 2)), scattered[:6], "all points are equal"),
}


@pytest.mark.parametrize("case", REJECTED)
def test_homography_rejects_degenerate_points(case):
    source, target, text = REJECTED[case]

    with pytest.raises(InputError, match=text):
        homography_dlt(source, target)
    with pytest.raises(InputError, match=text):
        fit_homography(source, target, np.eye(3))
    with pytest.raises(InputError):
        homography_ransac(source, target, 0.1, np.random.default_rng(0))


def test_weights_must_be_usable():
    with pytest.raises(InputError, match="weights"):
        homography_dlt(square, square, [1, 1, -1, 1])
    with pytest.raises(InputError, match="at least 4"):
        homography_dlt(square, square, [1, 1, 0, 1])


def test_homography_covariance_of_few_pairs_is_unbiased():
    """Seven pairs: eight of fourteen numbers are the homography's."""
    rng, source = (
        np.random.default_rng(9),
        np.random.default_rng(8).uniform(0, 9, (7, 2)),
    )
    exact, reported = apply_homography(H_TRUE, source), []
    for _ in range(200):
        target = exact + 1e-4 * rng.standard_normal((7, 2))
        reported.append(np.trace(fit_homography(source, target, H_TRUE).covariance))
    many = np.tile(source, (3000, 1))
    target = apply_homography(H_TRUE, many) + 1e-4 * rng.standard_normal(many.shape)
    right = 3000 * np.trace(fit_homography(many, target, H_TRUE).covariance)
    # Of 200 draws of a chi square with six, the mean is known to 4 %.
    assert np.mean(reported) == pytest.approx(right, rel=0.15)


@given(seeds)
def test_random_samples_have_distinct_pairs(seed):
    picks = random_samples(np.random.default_rng(seed), 6, 50)
    assert np.all(np.diff(np.sort(picks, axis=1), axis=1) > 0)
    assert picks.min() >= 0
    assert picks.max() < 6
