"""CELECT on rendered boards: accuracy, order of the clicks, named failures."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.celect import OUTER_CORNER, TOO_FEW, TRACING, CelectSettings, celect
from raxel.features.celect.algorithm import TOO_MANY
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import soft_and_noisy

COLUMNS, ROWS = 8, 6
BENT = Board(COLUMNS, ROWS, facing(COLUMNS, ROWS, 46, turn=0.3), bend=0.9)
# Anchors and corners are whole pixels, so a turned image is traced a little elsewhere.
SAME_PX = 2.5


def lattice(board):
    return board.corners().reshape(board.rows, board.columns, 2)


def outer(grid):
    return np.array([grid[0, 0], grid[0, -1], grid[-1, -1], grid[-1, 0]])


def seen(board, noise=2.0, blur=0.8):
    return soft_and_noisy(board.image(), blur, noise)


IMAGE, TRUTH = seen(BENT), lattice(BENT)
CLICKS = outer(TRUTH) + [[1.5, -1], [-2, 1], [0.5, 2], [-1, -1]]


def largest_error(result, truth):
    assert result.found, result.failures
    return np.linalg.norm(result.corners - truth, axis=2).max()


@pytest.mark.parametrize("bend", [0.0, 0.4, 0.9, 1.6])
@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 2, 2.6])
def test_celect_finds_all_corners_of_bent_board(bend, turn):
    board = Board(7, 7, facing(7, 7, 40, tilt=(0.03, -0.02), turn=turn), bend=bend)
    truth = lattice(board)
    result = celect(seen(board), outer(truth) + 1.2, 7, 7)
    assert largest_error(result, truth) < 4


@pytest.mark.parametrize("noise", [0, 10, 25])
@pytest.mark.parametrize("blur", [0.5, 2.0])
def test_celect_tolerates_noise_and_blur(noise, blur):
    result = celect(seen(BENT, noise, blur), CLICKS, COLUMNS, ROWS)
    assert largest_error(result, TRUTH) < 6


@pytest.mark.parametrize("start", range(4))
def test_celect_order_follows_clicks(start):
    straight = celect(IMAGE, CLICKS, COLUMNS, ROWS).corners
    size = (COLUMNS, ROWS)[:: -1 if start % 2 else 1]
    result = celect(IMAGE, np.roll(CLICKS, -start, axis=0), *size)
    expected = np.rot90(straight, start)
    assert largest_error(result, expected) < 2 * SAME_PX


def test_celect_mirrored_image_gives_mirrored_corners():
    width = IMAGE.shape[1]
    mirrored = np.ascontiguousarray(IMAGE[:, ::-1])

    def mirror(points):
        return np.stack((width - 1 - points[..., 0], points[..., 1]), axis=-1)

    result = celect(mirrored, mirror(CLICKS), COLUMNS, ROWS)
    straight = celect(IMAGE, CLICKS, COLUMNS, ROWS).corners
    assert largest_error(result, mirror(straight)) < SAME_PX


def test_celect_is_independent_of_polarity_and_depth():
    whole = celect(IMAGE, CLICKS, COLUMNS, ROWS)
    inverted = celect(255 - IMAGE, CLICKS, COLUMNS, ROWS)
    deep = celect(IMAGE.astype(np.uint16) * 257, CLICKS, COLUMNS, ROWS)
    np.testing.assert_allclose(inverted.corners, whole.corners, atol=1.0)
    np.testing.assert_allclose(deep.corners, whole.corners, atol=1.0)


def test_celect_inner_clicks_give_partial_board():
    part = TRUTH[1:5, 2:7]
    assert largest_error(celect(IMAGE, outer(part), 5, 4), part) < 4


def test_celect_records_trace():
    result = celect(IMAGE, CLICKS, COLUMNS, ROWS, record=True)
    names = [contour.name for contour in result.contours]
    assert names[:4] == ["side 1", "side 2", "side 3", "side 4"]
    assert names[4:] == [f"column {k}" for k in range(2, COLUMNS)]
    for contour in result.contours:
        assert len(contour.steps) == len(contour.radii) == len(contour.anchors) - 1
        for step, anchor in zip(contour.steps, contour.anchors, strict=False):
            np.testing.assert_array_equal(step.centre, anchor)
            off = np.linalg.norm(step.edges - step.centre, axis=1)
            assert off.max() <= step.radius
    unrecorded = celect(IMAGE, CLICKS, COLUMNS, ROWS)
    np.testing.assert_array_equal(unrecorded.corners, result.corners)
    assert unrecorded.contours[0].steps == ()


def test_celect_failed_contour_is_named_and_replaceable():
    image = np.where(
        np.hypot(*(np.indices(IMAGE.shape)[::-1] - TRUTH[2, 3][:, None, None])) < 22,
        128,
        IMAGE,
    ).astype(np.uint8)
    result = celect(image, CLICKS, COLUMNS, ROWS)
    assert not result.found
    assert [failure.contour for failure in result.failures] == ["column 4"]
    failure = result.failures[0]
    assert failure.stage in (TRACING, TOO_FEW, TOO_MANY)
    assert failure.wanted == ROWS
    assert "\n" not in failure.reason
    missing = np.isnan(result.corners[..., 0])
    np.testing.assert_array_equal(np.argwhere(missing)[:, 1], [3] * (ROWS - 2))

    for by_hand in (TRUTH[:, 3], TRUTH[::-1, 3]):
        repaired = celect(
            image, CLICKS, COLUMNS, ROWS, given_contours={"column 4": by_hand}
        )
        assert largest_error(repaired, TRUTH) < 4


def test_celect_accepts_side_by_hand():
    settings = CelectSettings(first_angle_deg=90.0)
    result = celect(IMAGE, CLICKS, COLUMNS, ROWS, settings=settings)
    assert (result.failures[0].contour, result.failures[0].stage) == ("side 1", TRACING)
    repaired = celect(
        IMAGE,
        CLICKS,
        COLUMNS,
        ROWS,
        settings=settings,
        given_contours={"side 1": TRUTH[0]},
    )
    assert largest_error(repaired, TRUTH) < 4


def test_celect_exchanged_counts_fail():
    result = celect(IMAGE, CLICKS, ROWS, COLUMNS)
    assert not result.found
    assert {f.stage for f in result.failures[:4]} <= {TOO_FEW, TOO_MANY}
    assert result.corners.shape == (COLUMNS, ROWS, 2)


def test_celect_flat_image_has_no_corner():
    flat = np.full_like(IMAGE, 90)
    result = celect(flat, CLICKS, COLUMNS, ROWS)
    assert not result.found
    assert [f.stage for f in result.failures] == [OUTER_CORNER] * 4
    assert np.isnan(result.corners).all()


BAD_INPUT = {
    "colour": (np.dstack([IMAGE] * 3), CLICKS, COLUMNS, ROWS, "image: found an array"),
    "float": (IMAGE / 255, CLICKS, COLUMNS, ROWS, "image: found an array"),
    "empty": (IMAGE[:0], CLICKS, COLUMNS, ROWS, "image: found an array"),
    "one pixel": (IMAGE[:1, :1], CLICKS * 0, COLUMNS, ROWS, "squares of 0 px"),
    "outside": (IMAGE, CLICKS + 600, COLUMNS, ROWS, "outer_corners[0]: found (817"),
    "crossing": (IMAGE, CLICKS[[1, 0, 2, 3]], COLUMNS, ROWS, "two sides cross"),
    "three": (IMAGE, CLICKS[:3], COLUMNS, ROWS, "give 4 finite points"),
    "nan": (IMAGE, CLICKS * np.nan, COLUMNS, ROWS, "give 4 finite points"),
    "words": (IMAGE, ["a", "b", "c", "d"], COLUMNS, ROWS, "give 4 finite points"),
    "none": (IMAGE, None, COLUMNS, ROWS, "give 4 finite points"),
    "no count": (IMAGE, CLICKS, None, ROWS, "columns: found None"),
    "fraction": (IMAGE, CLICKS, COLUMNS, 5.5, "rows: found 5.5"),
    "one row": (IMAGE, CLICKS, COLUMNS, 1, "rows: found 1"),
    "too many": (IMAGE, CLICKS, 2000, ROWS, "squares of"),
}


@pytest.mark.parametrize("name", BAD_INPUT)
def test_celect_rejects_invalid_input(name):
    *arguments, message = BAD_INPUT[name]
    with pytest.raises(InputError) as caught:
        celect(*arguments)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"side 5": TRUTH[0]}, "found 'side 5'"),
        ({"column 1": TRUTH[:, 0]}, "found 'column 1'"),
        ({"side 1": TRUTH[0, :3]}, "side 1.* 8 "),
        ({"side 1": TRUTH[0] + 900}, r"side 1.* 640 x 480 px"),
    ],
)
def test_celect_rejects_invalid_contours(given, message):
    with pytest.raises(InputError, match=message):
        celect(IMAGE, CLICKS, COLUMNS, ROWS, given_contours=given)


def test_celect_records_radius_of_grown_window():
    settings = CelectSettings(radius_scale=0.5)
    result = celect(IMAGE, CLICKS, COLUMNS, ROWS, settings=settings, record=True)
    grown = 0
    for contour in result.contours:
        np.testing.assert_array_equal([s.radius for s in contour.steps], contour.radii)
        grown += len(set(contour.radii)) > 1
    assert grown > 0
