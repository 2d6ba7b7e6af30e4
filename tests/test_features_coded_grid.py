"""The coded grid: its code, its picture, and that a wrong place is never returned."""

from functools import lru_cache

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera
from raxel.errors import InputError
from raxel.features.coded_grid import (
    CodedGrid,
    Squares,
    chance_of,
    coded_grid,
    least_distance,
    locate,
    read_squares,
)
from raxel.geometry.poses import pose
from raxel.lab import Rectangle, TexturedScene, render
from raxel.lab.coded_texture import CodedTexture

SIZE = 12


@lru_cache
def grid():
    return coded_grid(SIZE, SIZE, np.random.default_rng(5))


def squares_of(bits, turns=0):
    """What a faultless reading gives of a block of bits whose first square is white."""
    white = np.indices(bits.shape).sum(axis=0) % 2 == 0
    white, bits = np.rot90(white, turns), np.rot90(bits, turns)
    return Squares(white.astype(float), white, bits.astype(float))


def block(row, column, high=5, wide=5, turns=0):
    """Reading and true corner numbers of a block that starts on a white square."""
    squares = squares_of(grid().bits[row : row + high, column : column + wide], turns)
    indices = np.stack(np.indices((high + 1, wide + 1)), axis=-1) + (row, column)
    return squares, np.rot90(indices, turns)


def test_windows_differ_in_as_many_bits_as_promised_in_all_turns():
    bits = grid().bits
    words = []
    for row in range(SIZE - 4):
        for column in range(SIZE - 4):
            for turns in range(4):
                white = np.rot90(np.indices((5, 5)).sum(axis=0) + row + column, turns)
                view = np.rot90(bits[row : row + 5, column : column + 5], turns)
                words.append((white[0, 0] % 2, view.ravel()))
    least = min(
        (a[1] != b[1]).sum()
        for i, a in enumerate(words)
        for b in words[:i]
        if a[0] == b[0]
    )
    assert least == least_distance(bits, 5) >= 5


def test_code_comes_from_the_generator_alone():
    one, two = (coded_grid(8, 9, np.random.default_rng(3)) for _ in range(2))
    assert (one.bits == two.bits).all()
    assert one.bits.shape == (8, 9)


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("size", [(5, 5), (5, 6), (5, 7), (8, 6)])
def test_every_block_is_found_where_it_is(turns, size):
    for row, column in ((0, 0), (1, 3), (4, 2), (3, 5)):
        squares, indices = block(row, column, *size, turns=turns)
        found = locate(squares, grid())
        assert found.found, found.reason
        assert (found.indices == indices).all()
        assert found.errors == 0


def test_one_wrong_mark_is_put_up_with_and_three_are_refused():
    squares, indices = block(2, 4)
    for place in np.ndindex(5, 5):
        squares.mark[place] = 1 - squares.mark[place]
        found = locate(squares, grid())
        assert found.found
        assert found.errors == 1
        assert (found.indices == indices).all()
        squares.mark[place] = 1 - squares.mark[place]
    squares.mark[0, :3] = 1 - squares.mark[0, :3]
    assert not locate(squares, grid()).found


def test_unclear_marks_are_not_guessed():
    squares, indices = block(2, 4)
    squares.mark[0, :2] = (0.45, 0.6)
    found = locate(squares, grid())
    assert found.found
    assert found.unclear == 2
    assert (found.indices == indices).all()
    squares.mark[:] = 0.5
    assert locate(squares, grid()).reason.startswith("0 marks wrong and 25 unclear")


def test_random_marks_are_refused_as_often_as_promised():
    rng, accepted = np.random.default_rng(0), 0
    for _ in range(400):
        accepted += locate(squares_of(rng.random((5, 5)) < 0.5), grid()).found
    # At most one in a thousand is promised: 400 draws give 3 once in 150.
    assert accepted < 3


def test_blank_board_mirrored_block_and_broken_colours_are_refused():
    assert not locate(squares_of(np.zeros((5, 5), bool)), grid()).found
    squares, _ = block(2, 4)
    assert not locate(squares_of(squares.mark[:, ::-1] > 0.5), grid()).found
    squares.white[2, 2] ^= True
    assert "1 squares" in locate(squares, grid()).reason
    large = squares_of(np.zeros((SIZE + 1, 2), bool))
    assert "larger" in locate(large, grid()).reason


def test_chance_is_the_binomial_tail_times_the_places():
    assert chance_of(10, 1, 3) == pytest.approx(3 * 11 / 1024)
    assert chance_of(3, 3, 50) == 1.0


def test_two_equal_windows_are_no_place():
    bits = np.random.default_rng(2).random((5, 15)) < 0.5
    bits[:, 10:] = bits[:, :5]
    squares = squares_of(bits[:, :5])
    assert "two places" in locate(squares, CodedGrid(bits, 5, 1)).reason


@pytest.mark.parametrize("contrast", [1.0, 0.25])
def test_marks_are_read_in_a_picture_of_the_texture(contrast):
    code, pitch = grid(), 40.0
    texture = CodedTexture(code.bits, pitch, contrast=contrast)
    sheet = Rectangle(pose(np.eye(3), [-240, -240, 500]), 480, 480)
    K = np.array([[500.0, 0, 239.5], [0, 500.0, 239.5], [0, 0, 1]])
    camera = PerspectiveCamera(K, (), 480, 480)
    picture = render(camera, np.eye(4), TexturedScene(((sheet, texture),)))
    image = np.rint(255 * picture).astype(np.uint8)
    numbers = np.stack(np.indices((SIZE - 1, SIZE - 1)), axis=-1) + 1
    corners = numbers[..., ::-1] * pitch - 0.5
    squares = read_squares(image, corners, contrast)
    marks = code.bits[1:-1, 1:-1]
    assert np.abs(squares.mark - marks).max() < 0.02
    assert squares.white[0, 0]
    assert (locate(squares, code).indices == numbers).all()
    # The share of white in the picture is that of the texture's squares and marks.
    even = np.indices(code.bits.shape).sum(axis=0) % 2 == 0
    share = 0.09 * contrast * code.bits
    white = np.where(even, 1 - share, share).mean()
    assert picture.mean() == pytest.approx(0.05 + 0.85 * white, abs=1e-5)


@pytest.mark.parametrize(
    "wrong", [{"rows": 4}, {"window": 0}, {"distance": 0}, {"distance": 13}]
)
def test_impossible_codes_are_refused(wrong):
    asked = {"rows": 6, "columns": 8, "window": 3, "distance": 2} | wrong
    if "rows" in wrong:
        asked["window"] = 5
    with pytest.raises(InputError, match="coded grid"):
        coded_grid(rng=np.random.default_rng(1), **asked)


def test_a_texture_without_bits_is_refused():
    with pytest.raises(InputError, match="mark"):
        CodedTexture(np.zeros((2, 2), bool), 1.0, mark=1.5)
