"""A board that is bent or longer one way: its shape is found with the camera."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from raxel.calibration import calibrate_lens
from raxel.calibration.parametric import lens_bundle, lens_fit
from raxel.calibration.parametric import lens_formula as lens_board
from raxel.calibration.parametric.lens_bundle import LensFormula
from raxel.calibration.parametric.lens_fit import (
    FormulaFit,
    _criterion,
    clustered_covariance,
    covariance_of,
)
from raxel.calibration.parametric.lens_formula import _wald, board_test
from raxel.calibration.views.correspondence import TERMS, BoardShape, shaped
from raxel.geometry.planes import on_plane
from tests.board_scenes import BOARD, HEIGHT, WIDTH, board_poses, views_of
from tests.calibration_scenes import central_difference

HALF = np.ptp(BOARD, axis=0) / 2
COUNT, NOISE_PX, FOCAL_PX = 12, 0.05, 100.0


def asked_for(gain, monkeypatch, count=20):
    """(used, px of the given shape, px of the tested one), where held-out boards gain
    so many px^2, each."""
    formula = LensFormula("kannala-brandt", 2, 0, 0)
    none, fit = np.zeros((count, 4, 2)), FormulaFit(formula, None)
    seen = np.ones((count, 4), bool)
    boards = lens_bundle.StackedBoards(none, none, seen, None, np.arange(count))
    found = shape_of(9.0, 9.0, 9.0, 0.0), np.eye(4), np.eye(4)
    squares = {"flat": 4 + gain, "shaped": np.full(count, 4.0)}
    monkeypatch.setattr(lens_board, "_found_shape", lambda *_: found)
    monkeypatch.setattr(lens_board, "_shaped_board", lambda *_: "shaped")
    monkeypatch.setattr(
        lens_board,
        "held_out_squares",
        lambda one, _: squares["shaped" if one == "shaped" else "flat"],
    )
    return board_test(fit, boards)


def shape_of(*values):
    return BoardShape(BOARD.mean(axis=0), HALF, np.array(values, float))


def seen_with(shape, seed, count=COUNT):
    poses = board_poses(seed, count)
    return views_of(poses, noise=NOISE_PX, seed=seed, solid=shape.points(BOARD))


def test_bent_sheet_keeps_lengths():
    # Its bend about a slanted axis: along the arc as long as on the stated board.
    along = np.linspace(-1, 1, 2001)[:, None] * [60.0, 54.0]
    curvature = 2e-3
    one = np.array([60.0, 54.0]) / np.hypot(60.0, 54.0)
    a, b = HALF
    values = curvature / 2 * np.array([(a * one[0]) ** 2, (b * one[1]) ** 2, 0.0, 0.0])
    values[2] = curvature * a * b * one[0] * one[1]
    placed = shape_of(*values).points(along + BOARD.mean(axis=0))
    length = np.sum(np.linalg.norm(np.diff(placed, axis=0), axis=1))
    flat = 2 * np.hypot(60.0, 54.0)
    assert length == pytest.approx(flat, rel=3e-5)
    chord = np.linalg.norm(placed[-1] - placed[0])
    assert chord == pytest.approx(flat * (1 - (curvature * flat) ** 2 / 24), rel=3e-5)
    assert placed[-1, 2] - placed[1000, 2] == pytest.approx(curvature * flat**2 / 8)


def test_board_shape_slopes_equal_differences():
    values = np.array([4.0, -3.0, 2.5, 0.03])
    _, slopes = shaped(BOARD, shape_of(*values))
    differences = central_difference(
        lambda step: shape_of(*(values + step)).points(BOARD), 4
    )
    np.testing.assert_allclose(slopes, differences, atol=1e-7)


def test_lens_equations_equal_residual_differences():
    views = views_of(board_poses(1, 4), noise=1.0, seed=0)
    boards = lens_bundle.stacked([(view.pixels, view.points) for view in views])
    formula = LensFormula("kannala-brandt", 2, 2, 1, TERMS)
    values = np.array(
        [100, 101, 122, 88, -0.01, 2e-3, 1e-3, -1e-3, 1, 3, -2, 1.5, 0.02]
    )
    T = board_poses(1, 4)
    # Of so wide a loss all weights are 1.
    system = lens_bundle._system(formula, values, T, boards, "cauchy", np.full(4, 1e4))

    def off(step):
        return lens_bundle._residuals(formula, values + step, T, boards).ravel()

    J = -np.nan_to_num(central_difference(off, len(values)))
    np.testing.assert_allclose(system[0], J.T @ J, rtol=1e-4, atol=1e-3)
    right = J.T @ np.nan_to_num(off(np.zeros(len(values))))
    np.testing.assert_allclose(system[3], right, rtol=1e-3, atol=1e-2)


@pytest.mark.parametrize(
    ("values", "used"), [((0.8, 0, 0, 0), TERMS[:3]), ((-0.4, 0.5, 0.3, 0.006), TERMS)]
)
def test_board_shape_is_estimated_with_camera(values, used):
    views = seen_with(shape_of(*values), 7)
    found = calibrate_lens(views, WIDTH, HEIGHT, "kannala-brandt", pupil="fixed")
    test = found.board
    assert test.used == used
    assert np.all(np.abs(test.shape.values - values) < 4 * test.sd)
    assert np.all(test.sd < [0.05, 0.05, 0.05, 1e-3])
    assert test.shaped_px < test.flat_px
    focal, sd = found.values[0], np.sqrt(found.covariance[0, 0])
    assert abs(focal - FOCAL_PX) < 3 * sd < 0.3


@pytest.mark.parametrize("n_images", [6, 30])
def test_wald_test_follows_f_distribution(n_images):
    """Of two numbers the law has a closed form: (1 + q / n)^(-n / 2)."""
    covariance = np.array([[4.0, 1.0], [1.0, 2.0]])
    values = np.array([6.0, -3.0])
    square, free = values @ np.linalg.inv(covariance) @ values, n_images - 1
    assert _wald(values, covariance, n_images) == pytest.approx(
        (1 + square / free) ** (-free / 2)
    )


def test_flat_board_stays_flat_and_few_images_give_no_test():
    views = seen_with(shape_of(0, 0, 0, 0), 8)
    found = calibrate_lens(views, WIDTH, HEIGHT, "kannala-brandt", pupil="fixed")
    assert found.board.used == ()
    assert np.all(found.board.taken.values == 0)
    assert np.all(np.abs(found.board.shape.values) < 4 * found.board.sd)
    assert np.all(found.board.taken.points(BOARD) == on_plane(BOARD))
    bent = seen_with(shape_of(0.8, 0, 0, 0), 9)[:5]
    found = calibrate_lens(bent, WIDTH, HEIGHT, "kannala-brandt", pupil="fixed")
    assert found.board is None


def test_covariance_is_of_corners_not_weights():
    """Gaussian corners: 2 % more variance than least squares have, as Tukey's loss
    costs; wrong corners cost no more than that there are fewer right ones."""
    rng, wrong = np.random.default_rng(6), 0.06
    poses = board_poses(6, 16)
    views = views_of(poses, noise=NOISE_PX, seed=6)
    boards = lens_bundle.stacked([(view.pixels, view.points) for view in views])
    formula = LensFormula("kannala-brandt", 2, 0, 0)
    start = np.array([FOCAL_PX, FOCAL_PX, 122.0, 88.0, 0.0, 0.0])

    def alone(boards):
        found = lens_bundle.adjusted(formula, start, poses, boards, "tukey")
        reported = covariance_of(FormulaFit(formula, found), boards)
        far = np.full(len(poses), 1e6)
        exact = formula, found.values, found.T_camera_grid
        normal = lens_bundle.board_information(*exact, boards, far)[0].sum(axis=0)
        squares = NOISE_PX**2 * np.linalg.inv(normal)
        return np.mean(np.diag(reported.alone) / np.diag(squares))

    assert alone(boards) == pytest.approx(1.02, abs=0.06)
    off = rng.random(boards.seen.shape) < wrong
    boards.pixels[off] += rng.choice([-8.0, 8.0], (np.count_nonzero(off), 2))
    assert alone(boards) == pytest.approx(1.02 / (1 - wrong), abs=0.08)


def fitted_line(rng, together):
    """(estimate, its ClusteredCovariance) of three parameters from 12 groups of 40; in
    each group errors share what moves the first parameter, so strongly."""
    rows = rng.normal(size=(12, 40, 3))
    errors = rng.normal(size=(12, 40))
    errors += together * rows[..., 0] * rng.normal(size=(12, 1))
    normal = np.einsum("nmi,nmj->nij", rows, rows)
    found = np.linalg.solve(normal.sum(axis=0), np.einsum("nmi,nm->i", rows, errors))
    left = errors - rows @ found
    gradient = np.einsum("nmi,nm->ni", rows, left)
    variance = np.sum(left**2) / (left.size - 3)
    return found, clustered_covariance(normal, gradient, variance)


@pytest.mark.parametrize("together", [0.0, 0.3])
def test_covariance_includes_errors_common_to_image(together):
    rng = np.random.default_rng(3)
    trials = [fitted_line(rng, together) for _ in range(300)]
    found = np.array([values for values, _ in trials])
    spread = np.sqrt(np.mean(found**2, axis=0))
    stated, alone = (
        np.sqrt(np.mean([np.diag(c[k]) for _, c in trials], axis=0)) for k in (0, 1)
    )
    own = found / np.sqrt([np.diag(c.covariance) for _, c in trials])
    factor = np.mean([c.factor for _, c in trials])
    for _, one in trials:
        for wider, less in (
            (one.estimated, one.alone),
            (one.covariance, one.estimated),
        ):
            assert np.linalg.eigvals(np.linalg.solve(less, wider)).min() > 1 - 1e-9
    if not together:
        # What is less than alone by chance is raised, and what is more is not lowered.
        assert np.all((stated / spread > 0.95) & (stated / spread < 1.2))
        assert np.all(np.abs(np.sqrt(np.mean(own**2, axis=0)) - 0.95) < 0.1)
        assert 1.0 <= factor < 1.15
    else:
        assert alone[0] < 0.6 * spread[0]
        # The widening for a dozen numbers makes the mean variance larger, by up to 11/9
        # (1.2 was the bound without it); errors over what is stated would be 1.26.
        assert 0.85 < stated[0] / spread[0] < 1.25
        assert np.sqrt(np.mean(own[:, 0] ** 2)) < 1.2
        assert factor > 1.2


def test_held_out_squares_count_corners(monkeypatch):
    """A constant that each fit takes as the mean of its boards' pixels, with gaps."""
    rng = np.random.default_rng(54)
    seen = rng.random((7, 30)) < 0.7
    pixels = rng.normal(size=(7, 1, 2)) + 0.3 * rng.normal(size=(7, 30, 2))
    pixels[2, 3] += 90.0
    seen[2, 3] = True
    scales = np.linspace(1.0, 2.0, 7)
    boards = lens_bundle.StackedBoards(
        pixels, np.zeros((7, 30, 3)), seen, None, np.array([0, 1, 2, 3, 4, 5, 0])
    )

    def adjusted(formula, values, poses, inside, loss, of_loss):
        assert len(poses) == len(inside.seen) == len(of_loss)
        return SimpleNamespace(values=inside.pixels[inside.seen].mean(axis=0))

    monkeypatch.setattr(lens_fit, "adjusted", adjusted)
    monkeypatch.setattr(
        lens_fit,
        "posed_residuals",
        lambda _, values, poses, kept: np.where(
            kept.seen[..., None], kept.pixels - values, np.nan
        ),
    )
    result = SimpleNamespace(
        scales=scales, T_camera_grid=np.zeros((7, 4, 4)), values=None
    )
    found = lens_fit.held_out_squares(FormulaFit(None, result), boards)
    parts = np.array([0, 1, 2, 3, 4, 0, 0])  # a near copy of the first stays with it
    for k in range(7):
        others = parts != parts[k]
        mean = pixels[others][seen[others]].mean(axis=0)
        squares = np.sum((pixels[k][seen[k]] - mean) ** 2, axis=1)
        expected = np.minimum(
            squares, (lens_bundle.OUTLIER_SCALES * scales[k]) ** 2
        ).mean()
        assert found[k] == pytest.approx(expected)


def test_board_shape_needs_significant_held_out_gain(monkeypatch):
    rng, paid = np.random.default_rng(52), {0.0: [], 0.75: []}
    for _ in range(200):
        scatter = rng.standard_normal(20)
        for mean, found in paid.items():
            found.append(bool(asked_for(mean + scatter, monkeypatch).used))
    # Student's t of 19 is beyond 2 by chance once in 33.
    assert 0.01 < np.mean(paid[0.0]) < 0.06
    assert np.mean(paid[0.75]) > 0.85
    for gain, used in ((0.0005**2, ()), (0.0015**2, TERMS[:3])):
        assert asked_for(np.full(20, gain), monkeypatch).used == used
    test = asked_for(np.full(20, 5.0), monkeypatch)
    assert (test.flat_px, test.shaped_px) == (3.0, 2.0)


def test_repeated_boards_add_no_information():
    """With the errors they share a board seems no more bent, and a fit no surer."""
    start = np.array([FOCAL_PX, FOCAL_PX, 122.0, 88.0, 0.0, 0.0])
    formula, once = LensFormula("kannala-brandt", 2, 0, 0), np.arange(COUNT)

    def reported(of, copies=None):
        poses = board_poses(4, COUNT)
        views = views_of(poses, noise=NOISE_PX, seed=4)
        corners = [(views[k].pixels[::3], views[k].points[::3]) for k in of]
        boards = lens_bundle.stacked(corners, copies)
        found = lens_bundle.adjusted(formula, start, poses[of], boards, "tukey")
        fit = FormulaFit(formula, found)
        sd = np.sqrt(covariance_of(fit, boards).covariance[0, 0])
        return sd, np.log10(board_test(fit, boards).p_bends)

    thrice = np.repeat(once, 3)
    (sd, bends), single = reported(thrice, thrice), reported(once)
    assert sd / single[0] == pytest.approx(1, abs=0.1)
    assert bends == pytest.approx(single[1], abs=0.3)
    alone = reported(thrice)
    assert alone[0] < 0.7 * single[0]
    assert alone[1] < 2 * single[1]


def test_spurious_term_rate_follows_schwarz():
    """Of 240 coordinates it lowers squares by a chi square with one; log 240 is 5.5."""
    rng, boards = np.random.default_rng(53), SimpleNamespace(seen=np.ones((3, 40)))
    kept = []
    for _ in range(3000):
        left, taken = rng.chisquare([239, 1]) / 240
        fits = [
            SimpleNamespace(
                formula=SimpleNamespace(names=tuple(names)),
                result=SimpleNamespace(cost=cost),
            )
            for names, cost in (("abcd", left + taken), ("abcde", left))
        ]
        less, more = (_criterion(fit, boards) for fit in fits)
        kept.append(more < less)
    # 0.019 of 3000, known to 0.003.
    assert np.mean(kept) == pytest.approx(chi2.sf(np.log(240), 1), abs=0.008)
