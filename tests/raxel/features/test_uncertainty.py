"""The standard deviation of a corner, from the detector to the calibration."""

import json

import cv2
import numpy as np
import pytest

from raxel.calibration import BoardView, board_views, calibrate_generic, calibrate_zhang
from raxel.calibration.views.correspondence import check_view
from raxel.cameras import pixel_grid
from raxel.errors import InputError
from raxel.features.boards import detect_boards, read_boards, write_boards
from raxel.features.localise import saddle_point
from raxel.sets import load_reference, load_set, read_image
from raxel.sets.model import check_sd, plain_sd, sd_from_plain
from tests.board_scenes import HEIGHT, WIDTH, board_poses, views_of
from tests.image_sets import COLUMNS, ROWS, write_drawn_set

CORNERS = COLUMNS * ROWS


@pytest.fixture(scope="module")
def image_set(tmp_path_factory):
    """A rendered set with noise of 3 grey levels."""
    folder = tmp_path_factory.mktemp("sd") / "set"
    write_drawn_set(folder, ((0, 0), (25, 0)))
    rng = np.random.default_rng(11)
    for path in sorted(folder.glob("*.png")):
        clean = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        noisy = np.rint(clean + rng.normal(0, 3, clean.shape))
        cv2.imwrite(str(path), np.clip(noisy, 0, 255).astype(np.uint8))
    return load_set(folder)


def test_detector_sd_reaches_views(image_set):
    boards = detect_boards(image_set)
    for board, view in zip(boards, board_views(image_set, boards), strict=True):
        assert view.sd.shape == (CORNERS,)
        assert (view.sd > 0).all()
        np.testing.assert_array_equal(view.sd, board.detection.sd)
        np.testing.assert_array_equal(check_view(view).sd, view.sd)


def test_sd_round_trips_through_file(image_set, tmp_path):
    boards = detect_boards(image_set)
    boards[0].detection.sd[4] = np.nan
    write_boards(tmp_path / "corners.json", image_set, "raxel", boards)
    again = read_boards(tmp_path / "corners.json", image_set)
    for one, other in zip(boards, again, strict=True):
        np.testing.assert_allclose(other.detection.sd, one.detection.sd, atol=6e-7)


@pytest.mark.parametrize(("u", "inside"), [(-0.4, True), (-0.6, False)])
def test_corners_in_outer_half_pixel_are_accepted(image_set, tmp_path, u, inside):
    boards = detect_boards(image_set)
    boards[0].detection.corners[0] = [u, 20.0]
    write_boards(tmp_path / "corners.json", image_set, "raxel", boards)
    if inside:
        again = read_boards(tmp_path / "corners.json", image_set)
        assert again[0].detection.corners[0, 0] == u
        return
    with pytest.raises(InputError, match=r"found \(-0\.6, 20\)"):
        read_boards(tmp_path / "corners.json", image_set)


def test_detector_without_sd_gives_none(image_set, tmp_path):
    boards = detect_boards(image_set, "opencv")
    write_boards(tmp_path / "corners.json", image_set, "opencv", boards)
    content = json.loads((tmp_path / "corners.json").read_text())
    assert content["images"][0]["sd"] is None
    again = read_boards(tmp_path / "corners.json", image_set)
    assert [view.sd for view in board_views(image_set, again)] == [None, None]
    assert np.isnan(check_view(board_views(image_set, again)[0]).sd).all()


def test_reference_corners_have_stated_sd(tmp_path):
    drawn = write_drawn_set(tmp_path, tilts=((0, 0), (25, 0)), reference="ref.json")
    stated = [0.1 + 0.01 * k for k in range(CORNERS)]
    stated[3] = None
    entries = [{"corners": board.corners().tolist()} for board in drawn]
    entries[1]["sd"] = stated
    images = {f"view{k}.png": entry for k, entry in enumerate(entries)}
    content = {"columns": COLUMNS, "rows": ROWS, "images": images}
    (tmp_path / "ref.json").write_text(json.dumps(content))
    reference = load_reference(load_set(tmp_path))
    assert reference["view0.png"].sd is None
    np.testing.assert_array_equal(
        reference["view1.png"].sd, np.array(stated, dtype=float)
    )


def test_localised_corners_make_view(image_set):
    image = read_image(image_set, image_set.views[0])
    start = detect_boards(image_set)[0].detection.corners + 0.3
    found = saddle_point(image, start, window=9)
    points = image_set.target.points()
    view = check_view(BoardView(found.corners, points, COLUMNS, ROWS, sd=found.sd))
    assert ((view.sd > 0.005) & (view.sd < 0.2)).all()


@pytest.mark.parametrize(
    "calibrate",
    [
        calibrate_zhang,
        lambda *given: calibrate_generic(*given, rng=np.random.default_rng(1)),
    ],
    ids=["zhang", "generic"],
)
def test_calibrations_do_not_weight_by_sd(calibrate):
    views = views_of(board_poses(3, 6), noise=0.05)
    rng = np.random.default_rng(5)
    stated = [v._replace(sd=rng.uniform(0.01, 5, len(v.pixels))) for v in views]
    pixels = pixel_grid(WIDTH, HEIGHT)
    without, with_sd = (
        calibrate(v, WIDTH, HEIGHT).camera.rays(pixels) for v in (views, stated)
    )
    assert without.valid.any()
    # Sums run in another order where memory begins elsewhere.
    np.testing.assert_allclose(with_sd.directions, without.directions, atol=1e-12)


def test_invalid_sd_is_rejected():
    assert np.isnan(check_sd("board", None, 4)).all()
    np.testing.assert_array_equal(check_sd("b", [0, np.nan, np.inf], 3)[0], 0.0)
    for wrong in ([0.1, 0.2], [0.1, -0.2, 0.1]):
        with pytest.raises(InputError, match="view: sd: "):
            check_sd("view", wrong, 3)


def test_sd_plain_form():
    assert plain_sd(None) is None
    assert sd_from_plain("x", None, 2) is None
    assert plain_sd(np.array([0.1234567, np.nan, np.inf])) == [0.123457, None, None]
    np.testing.assert_array_equal(sd_from_plain("x", 0, 3), np.zeros(3))
    np.testing.assert_array_equal(sd_from_plain("x", [0.5, None], 2), [0.5, np.nan])


@pytest.mark.parametrize(
    "wrong", [[0.1], [0.1, "a"], [0.1, -1], [0.1, True], "0.1", -0.1, {}, [[1], [2]]]
)
def test_invalid_plain_sd_is_rejected(wrong):
    with pytest.raises(InputError, match=r"corners\.json: sd: "):
        sd_from_plain("corners.json: sd", wrong, 2)
