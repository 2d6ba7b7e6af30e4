"""Detection without clicks: correct or rejected, under any image processing."""

import cv2
import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.lattice import symmetries
from tests.chessboards import Board, facing

POSES = {
    "straight": (9, 6, facing(9, 6, 40), 0.0),
    "turned": (7, 5, facing(7, 5, 38, turn=0.7), 0.0),
    "tilted": (9, 6, facing(9, 6, 42, tilt=(0.05, -0.03), turn=-0.3), 0.0),
    "bent": (8, 8, facing(8, 8, 44, turn=0.2), 0.8),
    "strongly bent": (11, 8, facing(11, 8, 60, tilt=(-0.02, 0.02), turn=3.0), 2.5),
}


def drawn(name):
    columns, rows, homography, bend = POSES[name]
    return Board(columns, rows, homography, bend=bend)


def seen(board, blur=0.8, noise=2.0, seed=1):
    """The board through a soft lens, with noise."""
    return soft_and_noisy(board.image(), blur, noise, seed)


def soft_and_noisy(image, blur=0.8, noise=2.0, seed=1):
    soft = cv2.GaussianBlur(image.astype(float), (0, 0), blur)
    noisy = soft + np.random.default_rng(seed).normal(0, noise, soft.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def distance(found, corners, columns, rows):
    """The largest distance to the true corners under the best symmetry."""
    return min(
        np.nanmax(np.linalg.norm(order - corners, axis=1))
        for order, size in symmetries(found.corners, found.columns, found.rows)
        if size == (columns, rows)
    )


@pytest.mark.parametrize("known", [True, False], ids=["size given", "size not given"])
@pytest.mark.parametrize("name", POSES)
def test_find_board_finds_all_corners(name, known):
    board = drawn(name)
    size = (board.columns, board.rows) if known else (None, None)
    found = find_board(seen(board), *size)
    assert distance(found, board.corners(), board.columns, board.rows) < 0.2
    assert found.sd.shape == (board.columns * board.rows,)
    assert found.sd.max() < 0.1


TURNS = {
    "half turn": lambda a: a[::-1, ::-1],
    "quarter turn": lambda a: a.transpose(1, 0)[:, ::-1],
    "mirrored": lambda a: a[:, ::-1],
    "upside down": lambda a: a[::-1],
    "transposed": lambda a: a.T,
}


@pytest.mark.parametrize("name", TURNS)
def test_find_board_is_independent_of_orientation(name):
    board = drawn("bent")
    image = seen(board)
    numbers = TURNS[name](np.arange(image.size).reshape(image.shape))
    found = find_board(np.ascontiguousarray(TURNS[name](image)))
    assert found.found, found.reason
    v, u = np.indices(numbers.shape)
    new = np.empty((image.size, 2))
    new[numbers.ravel()] = np.column_stack([u.ravel(), v.ravel()])
    ends = new.reshape(*image.shape, 2)
    origin, right, down = ends[0, 0], ends[0, 1] - ends[0, 0], ends[1, 0] - ends[0, 0]
    true = origin + board.corners() @ np.stack([right, down])
    assert distance(found, true, 8, 8) < 0.2


@pytest.mark.parametrize("factor", [0.5, 1.7, 3.0])
def test_find_board_is_independent_of_scale(factor):
    board = drawn("turned")
    size = round(640 * factor), round(480 * factor)
    image = cv2.resize(seen(board), size, interpolation=cv2.INTER_AREA)
    found = find_board(image, 7, 5)
    true = (board.corners() + 0.5) * factor - 0.5
    assert distance(found, true, 7, 5) < 0.2 * max(factor, 1)


@pytest.mark.parametrize("size", [(8, 6), (None, None)], ids=["given", "not given"])
@pytest.mark.parametrize("strip", [3, 5])
def test_narrow_last_row_is_detected(size, strip):
    board = drawn("straight")
    image = board.image().copy()
    last = int(board.corners()[:, 0].max())
    image[:, last + strip :] = 0
    found = find_board(soft_and_noisy(image), *size)
    assert "squares continue beyond its right side" in found.reason


@pytest.mark.parametrize("size", [(8, 6), (9, 5), (10, 6), (9, 7), (3, 3)])
def test_wrong_size_is_rejected_with_actual_size(size):
    found = find_board(seen(drawn("straight")), *size)
    assert "9 x 6" in found.reason
    assert len(found.partial.corners) == 54


@pytest.mark.parametrize(
    ("cut", "known"),
    [(120, False), (150, False), (180, False), (205, False), (180, True), (205, True)],
)
def test_cropped_board_is_rejected_with_ordered_part(cut, known):
    board = drawn("straight")
    image = np.ascontiguousarray(seen(board)[:, cut:])
    found = find_board(image, *((9, 6) if known else (None, None)))
    true = board.corners() - [cut, 0]
    assert not found.found
    assert ordered_share(found.partial, true, 9, 6, image.shape) >= 0.95


def test_cropped_margin_requires_known_size():
    board = drawn("straight")
    image = np.ascontiguousarray(seen(board)[:, 150:])
    found = find_board(image, 9, 6)
    assert distance(found, board.corners() - [150, 0], 9, 6) < 0.2
    for turn, side in enumerate(("left side", "bottom", "right side", "top")):
        turned = np.ascontiguousarray(np.rot90(image, turn))
        reason = find_board(turned).reason
        assert f"may continue beyond its {side}, outside the image" in reason


def ordered_share(partial, true, columns, rows, shape):
    """Share of the visible corners that are on one lattice with the true ones."""
    lattice = true.reshape(rows, columns, 2)
    inside = np.all((true > 2) & (true < np.array(shape[::-1]) - 3), axis=1)
    best = 0
    for down, right in np.ndindex(2 * rows, 2 * columns):
        for turned in (partial.indices, partial.indices[:, ::-1]):
            for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                at = turned * sign + (down - rows // 2, right - columns // 2)
                good = np.all((at >= 0) & (at < (rows, columns)), axis=1)
                here = lattice[at[good, 0], at[good, 1]]
                apart = np.linalg.norm(here - partial.corners[good], axis=1)
                best = max(best, (apart < 1).sum())
    return best / inside.sum()


def test_occluded_column_is_rejected():
    board = drawn("straight")
    image = seen(board)
    u = int(board.corners().reshape(6, 9, 2)[0, 4, 0])
    image[:, u - 12 : u + 12] = 120
    for size in ((9, 6), (None, None), (4, 6)):
        assert not find_board(image, *size).found


def test_two_boards_are_rejected_with_both_sizes():
    one = seen(drawn("straight"))
    found = find_board(np.hstack([one, one]), 9, 6)
    assert "2 boards" in found.reason
    found = find_board(np.hstack([one, one]))
    assert not found.found
    assert found.complete == ((9, 6), (9, 6))


def test_small_board_in_the_background_is_ignored():
    one = seen(drawn("straight"))
    small = cv2.resize(one, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    assert find_board(small, 9, 6).found
    below = one.shape[0] - small.shape[0]
    small = np.pad(small, ((0, below), (0, 0)), constant_values=200)
    found = find_board(np.hstack([one, small]), 9, 6)
    np.testing.assert_allclose(found.corners, find_board(one, 9, 6).corners, atol=0.02)


def images_without_a_board():
    v, u = np.mgrid[0:480, 0:640].astype(float)
    rng = np.random.default_rng(5)
    spots = np.hypot(u % 40 - 20, v % 40 - 20) < 12
    return {
        "stripes": 127 + 100 * np.sign(np.sin(u / 9)),
        "waves both ways": 127 + 50 * np.sin(u / 9) + 50 * np.sin(v / 9),
        "tiles": np.where((u % 40 < 3) | (v % 40 < 3), 60.0, 180.0),
        "spots": np.where(spots, 30.0, 220.0),
        "rings": 127 + 100 * np.sign(np.sin(np.hypot(u - 320, v - 240) / 7)),
        "noise": rng.uniform(0, 255, u.shape),
        "black": np.zeros_like(u),
        "ramp": u / 3,
    }


@pytest.mark.parametrize("name", images_without_a_board())
def test_non_board_images_are_rejected(name):
    image = images_without_a_board()[name].astype(np.uint8)
    for size in ((9, 6), (None, None)):
        assert find_board(image, *size).reason
