"""Predicted uncertainties match actual errors, under any image processing."""

from functools import cache

import cv2
import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard.corners import FULL_EFFORT, localise_corners
from raxel.features.chessboard.grids import (
    Patches,
    add_shift_variance,
    clip_at_median,
    noise_ratio,
    patches_of,
    side_patches_of,
)
from raxel.features.chessboard.outer_corners import BLURS, outer_corner_model
from raxel.features.chessboard.saddles import Level
from raxel.features.lattice import orders
from tests.chessboards import Board, facing
from tests.drawn_images import Board as BoardBefore
from tests.drawn_images import Lens, Photo, board_in_view, gaussian
from tests.drawn_images import drawn as drawn_image
from tests.raxel.features.chessboard.test_find_board import seen, soft_and_noisy

FINER = 4


def crossings(blur, angle, noise, sigma, rng, count=60):
    """A corner of edges at an angle, `count` times in noise: levels, and its patch."""
    along = [np.array([np.cos(turn), np.sin(turn)]) for turn in (0.3, 0.3 + angle)]
    v, u = (np.mgrid[: 61 * FINER, : 61 * FINER] + 0.5) / FINER - 30.5
    sides = [FINER * (x * v - y * u) for x, y in along]
    sharp = np.prod([np.clip(side, -1, 1) for side in sides], axis=0)
    soft = cv2.GaussianBlur(sharp, (0, 0), blur * FINER)
    soft = 128 + 80 * cv2.resize(soft, (61, 61), interpolation=cv2.INTER_AREA)

    def level():
        seen = soft + rng.normal(0, noise, soft.shape)
        smooth = cv2.GaussianBlur(seen.astype(np.float32), (0, 0), sigma)
        return Level(smooth, 1, noise, sigma)

    zero = np.zeros((1, 2))
    shape = (36 * along[0][None], 36 * along[1][None], zero, zero, zero)
    return [level() for _ in range(count)], Patches(zero + 30, *shape)


@cache
def fine():
    """A board, and its image with every pixel the mean of FINER x FINER."""
    board = Board(9, 6, facing(9, 6, 34, tilt=(0.05, -0.03), turn=0.2))
    scale = np.diag([FINER, FINER, 1.0])
    scale[:2, 2] = (FINER - 1) / 2
    large = Board(9, 6, scale @ board.homography, 640 * FINER, 480 * FINER)
    size = board.width, board.height
    image = cv2.resize(large.image().astype(float), size, interpolation=cv2.INTER_AREA)
    return board, image


def stored(image):
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def jpeg(image, quality):
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    coded = cv2.imencode(".jpg", stored(image), options)[1]
    return cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)


def moved(image, length, angle):
    """Blurred by a straight motion of this length (px)."""
    ends = np.array([np.cos(angle), np.sin(angle)]) * length / 2
    total = np.zeros_like(image)
    for share in np.linspace(-1, 1, 25):
        shift = np.float64([[1, 0, share * ends[0]], [0, 1, share * ends[1]]])
        size = image.shape[::-1]
        total += cv2.warpAffine(image, shift, size, borderMode=cv2.BORDER_REPLICATE)
    return stored(total / 25)


def errors(found, truth):
    """(distances (N,) px, predicted SD (N,) px) under the best symmetry."""
    distances = [
        (np.linalg.norm(found.corners[order] - truth, axis=1), found.sd[order])
        for order, size in orders(found.columns, found.rows)
        if size == (9, 6)
    ]
    return min(distances, key=lambda pair: np.nansum(pair[0]))


SOFT = {
    "jpeg 10": lambda image: jpeg(cv2.GaussianBlur(image, (0, 0), 1.0), 10),
    "jpeg 5, blurred": lambda image: jpeg(cv2.GaussianBlur(image, (0, 0), 2.0), 5),
    "motion": lambda image: moved(image, 12, 0.6),
    "clipped": lambda image: stored((cv2.GaussianBlur(image, (0, 0), 2.0) - 30) * 2.2),
    "blur": lambda image: stored(cv2.GaussianBlur(image, (0, 0), 4.0)),
    "dark": lambda image: stored(cv2.GaussianBlur(image, (0, 0), 0.8) / 12),
}


@pytest.mark.parametrize("name", SOFT)
def test_smoothing_does_not_lower_predicted_sd(name):
    """The SD matches the errors where pixel noise alone does not explain them."""
    board, image = fine()
    found = find_board(SOFT[name](image), 9, 6)
    if not found.found:
        return
    off, sd = errors(found, board.corners())
    assert np.nanmin(sd) > 0
    assert not np.any((off > 1) & (sd <= 0.2))
    # Each axis has a part of the distance, and the SD is of the larger axis. Blur of an
    # eighth of a square draws the outer corners, and all alike.
    assert np.sqrt(np.nanmean((off / np.sqrt(2) / sd) ** 2)) < 2.5
    assert np.nanmax(off) < 1.5


@pytest.mark.parametrize("noise", [2.0, 8.0])
def test_predicted_sd_matches_noise_errors(noise):
    board, image = fine()
    soft = cv2.GaussianBlur(image, (0, 0), 0.7)
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(4):
        found = find_board(stored(soft + rng.normal(0, noise, soft.shape)), 9, 6)
        off, sd = errors(found, board.corners())
        ratios.append(off / np.sqrt(2) / sd)
    assert 0.8 < np.sqrt(np.mean(np.square(ratios))) < 1.2


@pytest.mark.parametrize("side", [1, -1])
def test_half_occluded_corner_is_not_returned(side):
    board = Board(9, 6, facing(9, 6, 40))
    image = seen(board)
    u, v = board.corners()[30]
    # Its edge runs along the lattice, seven pixels from the corner.
    edge = round(u + 7 * side)
    cover = slice(edge, edge + 16) if side > 0 else slice(edge - 16, edge)
    image[round(v) - 5 : round(v) + 16, cover] = 225
    found = find_board(image, 9, 6)
    assert found.found, found.reason
    assert found.missing == 1
    assert np.nanmax(errors(found, board.corners())[0]) < 1.0


def scattered(times, seed, shape=(7, 10)):
    rng = np.random.default_rng(seed)
    return times * rng.standard_normal((*shape, 2))


@pytest.mark.parametrize("times", [0.7, 1.0, 6.0])
def test_noise_ratio_scales_with_disagreement(times):
    stated = np.stack([noise_ratio(scattered(times, seed)) for seed in range(20)])
    assert np.median(stated) == pytest.approx(times, rel=0.08)
    # Chance makes no corner much better than it is.
    assert np.quantile(stated, 0.02) > 0.75 * times


def test_predicted_extrapolates_curvature():
    """Evenly changing curvature is extrapolated exactly; a parabola would be biased."""
    i, j = np.mgrid[:6, :7].astype(float)
    points = np.stack([30 * j + 0.4 * j**3, 30 * i + 0.2 * i**3 + j**2], axis=2)
    patches, rows, columns = side_patches_of(points)
    assert set(zip(rows, columns, strict=True)) == {
        (a, b) for a in range(6) for b in range(7) if a in (0, 5) or b in (0, 6)
    }
    true = np.stack([1.2 * columns, np.ones(len(rows))], axis=1)
    np.testing.assert_allclose(patches.uu, true, atol=1e-9)
    plain, _, columns = patches_of(points)
    assert np.abs(plain.uu[:, 0] - 1.2 * columns).max() > 1


def test_corners_on_shadow_edge_are_missing():
    """All corners of such a row have similar errors, so that each looks normal."""
    board = Board(9, 6, facing(9, 6, 34, turn=0.2))
    row = board.corners().reshape(6, 9, 2)[2]
    v, u = np.mgrid[: board.height, : board.width]
    along = (row[-1] - row[0]) / np.linalg.norm(row[-1] - row[0])
    behind = (v - row[0, 1]) * along[0] - (u - row[0, 0]) * along[1] > 1
    image = soft_and_noisy(board.image() * np.where(behind, 0.5, 1), 2.0, noise=1.0)
    found = find_board(image, 9, 6)
    off, _ = errors(found, board.corners())
    assert found.missing == 9
    assert off[np.isfinite(off)].max() < 0.2


@pytest.mark.parametrize("quality", [75, 90])
def test_predicted_sd_covers_compression_and_clipping(quality):
    lens = Lens("perspective", 600.0)
    board = BoardBefore(9, 6, cv2.Rodrigues(np.array([0.4, -0.3, 0.2]))[0], np.zeros(3))
    board = board._replace(t=[0, 0, 19] - board.R @ [4.0, 2.5, 0])
    photo = Photo(blur=gaussian(0.8), grey=(20, 300), noise=2, quality=quality)
    image, truth = drawn_image(lens, board, photo, np.random.default_rng(2))
    off, sd = errors(find_board(image, 9, 6), truth)
    assert 0.7 < np.sqrt(np.mean((off / np.sqrt(2) / sd) ** 2)) < 1.4


@pytest.mark.parametrize(("square", "blur"), [(4.5, 0.6), (6.0, 1.0)])
def test_predicted_sd_matches_errors_of_small_squares(square, blur):
    """Blur of a fifth to a third of a square, with pixels and smoothing included."""
    lens, rng = Lens("equidistant", 160.0, 320, 240), np.random.default_rng(4)
    board = board_in_view(lens, 9, 6, square, rng, tilt=0.2)
    photo = Photo(blur=gaussian(blur), noise=1.5)
    image, truth = drawn_image(lens, board, photo, rng)
    off, sd = errors(find_board(image, 9, 6), truth)
    known = np.isfinite(off)
    assert known.sum() >= 50
    assert 0.7 < np.sqrt(np.mean((off / sd)[known] ** 2) / 2) < 1.25


def test_enlarged_image_is_searched_at_its_own_scale():
    lens, rng = Lens("perspective", 160.0, 190, 150), np.random.default_rng(4)
    board = board_in_view(lens, 9, 6, 11.0, rng, tilt=0.2)
    photo = Photo(blur=gaussian(1.5), noise=1.0, quality=90)
    image, truth = drawn_image(lens, board, photo, rng)
    large = cv2.resize(image, None, fx=5, fy=5, interpolation=cv2.INTER_CUBIC)
    found = find_board(jpeg(large, 85))
    assert (found.found, found.missing) == (True, 0)
    off, sd = errors(found, 5 * (truth + 0.5) - 0.5)
    assert 0.7 < np.sqrt(np.mean((off / sd) ** 2) / 2) < 1.4
    # The centre of a pixel stays where it was.
    order = [np.mean(a, axis=0) for a in (found.corners, 5 * (truth + 0.5) - 0.5)]
    assert np.abs(order[0] - order[1]).max() < 0.1


@pytest.mark.parametrize("blur", [0.3, 0.7])
def test_corners_along_pixel_grid_are_unbiased(blur):
    """Aliasing is the same along such an edge, so that no disagreement shows it."""
    lens = Lens("perspective", 600.0)
    board = BoardBefore(9, 6, cv2.Rodrigues(np.array([0.02, 0.01, 0.02]))[0], None)
    board = board._replace(t=[0, 0, 19.3] - board.R @ [4.2, 2.3, 0])
    photo = Photo(blur=gaussian(blur), noise=0.3)
    image, truth = drawn_image(lens, board, photo, np.random.default_rng(2))
    off, sd = errors(find_board(image, 9, 6), truth)
    assert np.sqrt(np.mean(off**2) / 2) < 0.005 / np.sqrt(blur / 0.7)
    assert np.sqrt(np.mean((off / sd) ** 2) / 2) < 1.3


@pytest.mark.parametrize(
    ("blur", "degrees", "window", "sigma"),
    [(0.7, 90, 7.0, 0.7), (3.0, 90, 14.0, 1.2), (1.0, 35, 7.0, 0.7)],
)
def test_pixel_noise_propagates_through_corner_fit(blur, degrees, window, sigma):
    """To the scatter of the corner, and to the disagreement of its two window parts."""
    rng = np.random.default_rng(5)
    levels, patch = crossings(blur, np.radians(degrees), 2.0, sigma, rng)
    put = [localise_corners(patch, level, window, FULL_EFFORT) for level in levels]
    points = np.concatenate([one.points for one in put])
    apart = np.concatenate([one.disagreement for one in put])
    # 120 numbers: their SD is known to 6.5 %.
    stated = np.median([one.sd[0] for one in put])
    assert np.sqrt(points.var(axis=0).mean()) == pytest.approx(stated, rel=0.2)
    assert np.sqrt(np.mean(apart**2)) == pytest.approx(1, rel=0.2)


def test_blur_moves_outer_corners_of_small_squares():
    """By what the model of the squares that end predicts, without noise."""
    blur, square = 1.3, 5.0
    lens = Lens("equidistant", 160.0, 320, 240)
    board = BoardBefore(9, 6, cv2.Rodrigues(np.array([0.0, 0.0, 0.3]))[0], None)
    board = board._replace(t=[0, 0, 160 / square] - board.R @ [4.0, 2.5, 0])
    photo = Photo(blur=gaussian(blur), noise=0.0)
    image, truth = drawn_image(lens, board, photo, np.random.default_rng(2))
    found = find_board(image, 9, 6)
    off = errors(found, truth)[0].reshape(6, 9) / square
    total = np.sqrt(blur**2 + 0.7**2 + 1 / 3 + 1 / 12) / square
    shift = np.interp(total, BLURS, outer_corner_model((True, False))[1])
    assert np.sqrt(2) * shift == pytest.approx(off[[0, -1], 2:-2].mean(), rel=0.3)
    assert off[1:-1, 1:-1].max() < shift / 2


def test_noise_ratio_of_shadow_row_is_local():
    apart = scattered(1.0, 7, (6, 9))
    apart[2] *= 50
    stated = np.median(noise_ratio(apart), axis=1)
    assert stated[2] > 10
    # The median of a row counts its own parts' chance, too.
    assert stated[[0, 1, 3, 4, 5]].max() < 3


def test_clip_at_median_limits_noise_ratio():
    times = np.array([[0.5, 0.8, 9.0], [1.0, np.nan, 2.0]])
    expected = [[0.5, 0.8, 1.0], [1.0, np.nan, 1.0]]
    np.testing.assert_array_equal(clip_at_median(times), expected)
    assert np.isnan(clip_at_median(np.full((2, 2), np.nan))).all()


def test_shift_within_fluctuation_keeps_sd():
    sd, shift = np.array([0.01, 0.01, 0.01]), np.array([0.0, 0.025, 0.2])
    stated = add_shift_variance(sd, shift)
    np.testing.assert_allclose(stated, [0.01, 0.01, 0.2], rtol=0.02)


def test_patch_twist_is_constant_at_lattice_end():
    """Corners at the end have fewer neighbours, which determine the twist as well."""
    i, j = np.mgrid[:5, :6].astype(float)
    points = np.stack([30 * j + 1.5 * i * j, 28 * i - 0.8 * i * j], axis=2)
    patches, rows, _ = patches_of(points)
    assert len(rows) == 30
    np.testing.assert_allclose(patches.w, np.tile([1.5, -0.8], (30, 1)), atol=1e-9)
