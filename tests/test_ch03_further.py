"""The pictures and comparisons behind the page on 6.3.1."""

import cv2
import numpy as np
import pytest

from chapters.ch03_planar_grids.ext_corner_detection.exercises import (
    false_places,
    largest_window,
    symmetry_of_a_bend,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.bent_boards import (
    BentBoard,
    bent_at_random,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import (
    BLOCK,
    DEFAULT,
    Block,
    CodedView,
    code_of,
    conditions,
    decoded,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    METHODS,
    OTHERS,
)
from raxel.features.celect import CelectSettings
from raxel.features.celect.curvature import curved_side
from raxel.features.celect.result import CelectResult
from raxel.features.celect.symmetric import symmetry_at
from raxel.features.celect.window import Smoothing, open_window
from raxel.features.coded_grid import least_distance


def test_true_corners_of_a_bent_board_are_those_of_its_picture():
    for seed in range(2):
        rng = np.random.default_rng(seed)
        board = bent_at_random(rng)
        image = board.image(1.0, 0.0, rng)
        start = board.corners.astype(np.float32)[:, None]
        found = cv2.cornerSubPix(image, start.copy(), (4, 4), (-1, -1), (3, 99, 1e-4))
        off = np.linalg.norm(found[:, 0] - board.corners, axis=1)
        # The edges are bent within the localiser's window of 9 x 9 px.
        assert off.max() < 0.4
        assert np.median(off) < 0.1


def test_a_board_that_is_not_bent_is_straight():
    board = BentBoard((0.0, 0.0), (5.0, 5.0), (0.0, 0.0))
    assert np.diff(board.lattice, axis=1) - (60, 0) == pytest.approx(0, abs=1e-9)
    assert np.diff(board.lattice, axis=0) - (0, 60) == pytest.approx(0, abs=1e-9)
    assert board.corners.mean(axis=0) == pytest.approx((359.5, 359.5))


def test_each_method_changes_one_stage_and_the_last_all():
    published = CelectSettings()
    changed = {
        name: {k for k, v in vars(s).items() if v != getattr(published, k)}
        for name, s in METHODS.items()
    }
    assert [len(changed[name]) for name in OTHERS] == [1, 1, 1, 3]
    assert set.union(*(changed[name] for name in OTHERS[:3])) == changed["all three"]


def test_codes_keep_their_distance():
    for name in ("coded", "another code"):
        assert least_distance(code_of(name).bits, 5) >= 5


def test_blocks_of_a_view_are_whole_and_large_enough():
    view = CodedView("coded", "full", 134, 1)
    blocks = view.blocks()
    assert len(blocks) > 10
    assert blocks.min() >= 1
    assert blocks.max() + BLOCK <= 20
    row, column = blocks[0]
    block = view.corners[row : row + BLOCK, column : column + BLOCK]
    assert np.isfinite(block).all()
    turned = CodedView("coded", "full", 134, 2).corners
    assert not np.allclose(turned[10, 10], view.corners[10, 10])


def test_truth_judges_the_decoder():
    view = CodedView("coded", "full", 134, 1)
    row, column = view.blocks()[0]
    numbers = np.indices((BLOCK, BLOCK)).transpose(1, 2, 0) + (row, column)
    true = view.corners[numbers[..., 0], numbers[..., 1]]
    image = view.image(0.0, np.random.default_rng(0))

    def outcome(corners, numbers, found=True, **other):
        result = CelectResult(found, corners, BLOCK, BLOCK, None, (), ())
        block = Block(image, None, true, numbers)
        return decoded(block, result, DEFAULT | other)[0]["outcome"]

    assert outcome(true, numbers) == "right"
    assert outcome(true, numbers + 1) == "wrong place"
    assert outcome(true, numbers, grid="another code") == "wrong place"
    assert outcome(true, numbers, found=False) == "refused by CELECT"
    assert outcome(true[::-1], numbers) == "refused by the decoder"
    bent = true.copy()
    bent[2, 2] += (-7.0, 5.0)
    assert outcome(bent, numbers) == "a corner off"


def test_conditions_are_all_different():
    for effort in ("quick", "full"):
        asked = conditions(effort)
        assert len({tuple(c.values()) for c in asked}) == len(asked)


def test_exercises_agree_with_the_library():
    angle = 20 / 144 * np.arange(9)
    arc = 144 * np.column_stack((np.cos(angle), np.sin(angle)))
    wide = CelectSettings(column_radius=1.5)
    assert curved_side(arc, wide) == pytest.approx(largest_window(144))
    bend = np.where((np.indices((121, 121)) < 60).all(axis=0), 0, 255).astype(np.uint8)
    window = open_window(bend, np.array([60.0, 60.0]), 45.0, Smoothing(0.7, 1.0))
    near = symmetry_at(window, np.array([[60, 60]]) - window.first, 12.0)
    assert near == pytest.approx(symmetry_of_a_bend(), abs=0.1)
    assert false_places(10, 1024) == 1
