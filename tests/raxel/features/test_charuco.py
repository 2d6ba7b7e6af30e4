"""ChArUco boards: identified by their markers, localised as plain corners."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from raxel.cli import main
from raxel.errors import InputError
from raxel.features import find_board
from raxel.features.charuco import (
    find_charuco,
    find_markers,
    with_marker_hint,
    without_markers,
)
from raxel.features.detector import rejected
from raxel.sets import Charuco, load_set, write_set
from tests.charuco_boards import (
    HEIGHT,
    SQUARE_PX,
    TARGET,
    TILTS_DEG,
    WIDTH,
    board_image,
    opencv_board,
    sheet,
)
from tests.image_sets import description, write_description

CHARUCO = {
    "kind": "charuco",
    "columns": 7,
    "rows": 5,
    "pitch_mm": 40.0,
    "dictionary": "4X4_50",
    "marker_mm": 29.0,
}
PLAIN = {"kind": "chessboard", "columns": 7, "rows": 5, "pitch_mm": 40.0}


def drawn_set(folder, **changes):
    """A set of four rendered ChArUco boards; returns their corners."""
    folder.mkdir()
    truths = []
    for index, tilt in enumerate(TILTS_DEG):
        image, corners = board_image(tilt, seed=index)
        cv2.imwrite(str(folder / f"view{index}.png"), image)
        truths.append(corners)
    data = description(len(truths), resolution=[WIDTH, HEIGHT], target=CHARUCO)
    write_description(folder, data | changes)
    return truths


@pytest.mark.parametrize("tilt", TILTS_DEG)
def test_charuco_corners_have_board_order(tilt):
    image, truth = board_image(tilt)
    found = find_charuco(image, TARGET)
    assert found.found
    assert (found.columns, found.rows) == (7, 5)
    known = np.isfinite(found.corners[:, 0])
    assert known.sum() >= 33
    errors = (found.corners - truth)[known]
    assert np.abs(errors).max() < 0.2
    assert np.array_equal(np.isfinite(found.sd), known)
    assert np.sqrt(np.mean((errors / found.sd[known, None]) ** 2)) < 2


def test_charuco_mirrored_board_is_viewed_from_behind():
    image, _ = board_image(TILTS_DEG[0])
    found = find_charuco(np.ascontiguousarray(image[:, ::-1]), TARGET)
    straight = find_charuco(image, TARGET)
    again = found.corners.reshape(5, 7, 2)[:, ::-1] * [-1, 1] + [WIDTH - 1, 0]
    np.testing.assert_allclose(again.reshape(-1, 2), straight.corners, atol=1e-9)
    sd = found.sd.reshape(5, 7)[:, ::-1].ravel()
    np.testing.assert_allclose(sd, straight.sd, rtol=1e-9)
    assert np.nanmax(sd) > 1.1 * np.nanmin(sd)
    lattice = found.corners.reshape(5, 7, 2)
    along, down = lattice[2, 4] - lattice[2, 3], lattice[3, 3] - lattice[2, 3]
    assert along[0] * down[1] - along[1] * down[0] > 0


@pytest.mark.parametrize("slope", [(0.6, 0.0), (0.0, 0.6), (0.4, -0.3)])
def test_marker_paint_continues_surrounding_light(slope):
    v, u = np.mgrid[:90, :120]
    light = np.rint(150 + slope[0] * (u - 60) + slope[1] * (v - 45)).astype(np.uint8)
    grey, marker = light.copy(), np.array([[45, 30], [75, 32], [73, 60], [44, 58]])
    cv2.fillConvexPoly(grey, marker, 20)
    painted = without_markers(grey, [marker.astype(float)], 40 / 29)
    assert np.abs(painted.astype(int) - light).max() <= 1


def test_charuco_occlusion_leaves_other_corners():
    image, truth = board_image(TILTS_DEG[0])
    covered = image.copy()
    covered[:, : WIDTH // 2] = 128
    found = find_charuco(covered, TARGET)
    known = np.isfinite(found.corners[:, 0])
    assert found.found
    assert 6 <= known.sum() < 30
    assert (truth[known, 0] > WIDTH // 2 - 1).all()
    assert np.linalg.norm((found.corners - truth)[known], axis=1).max() < 0.2


def test_charuco_rejects_single_row():
    """Two rows of squares do not determine the direction across them."""
    print_ = sheet()
    hidden, seen = np.full_like(print_, 255), slice(2 * SQUARE_PX, 4 * SQUARE_PX)
    hidden[seen] = print_[seen]
    found = find_charuco(hidden, TARGET)
    assert "in two rows and columns required" in found.reason


@pytest.mark.parametrize(
    ("printed", "mirrored", "reason"),
    [
        (
            {"legacy": True},
            False,
            "the layout before OpenCV 4.6; set target.legacy: true",
        ),
        (
            {"dictionary": "6X6_100"},
            True,
            "markers of 6X6_50; set target.dictionary: 6X6_50",
        ),
        (
            {"columns": 5, "rows": 7},
            False,
            "exchanged; set target.columns: 5, target.rows: 7",
        ),
        (
            {"dictionary": "5X5_50", "legacy": True},
            False,
            "target.dictionary: 5X5_50, target.legacy: true",
        ),
        (
            {"columns": 8, "rows": 7},
            False,
            "another board: 36 markers of 4X4_50, numbers 0 to 35",
        ),
    ],
)
def test_charuco_rejection_names_printed_board(printed, mirrored, reason):
    image, _ = board_image(TILTS_DEG[0], replace(TARGET, **printed))
    found = find_charuco(image[:, ::-1] if mirrored else image, TARGET)
    assert not found.found
    assert reason in found.reason


@pytest.mark.parametrize("marker_mm", [16.0, 32.0])
def test_rejection_mentions_markers(marker_mm):
    image, _ = board_image(TILTS_DEG[0], Charuco(7, 5, 40.0, "4X4_50", marker_mm))
    for size in ((7, 5), (None, None)):
        reason = find_board(image, *size).reason
        assert reason.startswith("this looks like a ChArUco board (")
        assert reason.count("this looks like") == 1


def test_corners_command_warns_of_markers(tmp_path, capsys):
    """Markers of a third of the squares: corners are correct, nothing is rejected."""
    image = cv2.GaussianBlur(sheet(Charuco(7, 5, 40.0, "4X4_50", 12.0)), (0, 0), 0.8)
    cv2.imwrite(str(tmp_path / "view0.png"), image)
    resolution = list(image.shape[::-1])
    data = description(1, resolution=resolution, target=PLAIN)
    write_description(tmp_path, data)
    assert main(["corners", str(tmp_path)]) == 0
    output = capsys.readouterr()
    assert "board found in 1 of 1 images" in output.out
    assert "view0.png: this looks like a ChArUco board" in output.err


def test_charuco_set_round_trips(tmp_path):
    drawn_set(tmp_path / "set", target=CHARUCO | {"legacy": True})
    image_set = load_set(tmp_path / "set")
    write_set(image_set)
    assert load_set(tmp_path / "set") == image_set
    assert image_set.target == Charuco(7, 5, 40.0, "4X4_50", 29.0, legacy=True)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"marker_mm": 40}, "target.marker_mm: 40 mm is not below pitch_mm"),
        ({"columns": 17, "rows": 9}, "target.dictionary: 4X4_50 has 50 markers"),
        ({"dictionary": "DICT_4X4_50"}, "target.dictionary: found 'DICT_4X4_50'"),
        ({"columns": None}, "target.columns: found null"),
    ],
)
def test_charuco_target_faults_are_named(tmp_path, change, found):
    drawn_set(tmp_path / "set", target=CHARUCO | change)
    with pytest.raises(InputError, match=found):
        load_set(tmp_path / "set")


@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize("counts", [(7, 5), (6, 5), (7, 4), (6, 4)])
def test_charuco_marker_count_matches_board(counts, legacy):
    board = opencv_board(Charuco(*counts, 40.0, "4X4_50", 29.0, legacy))
    assert len(board.getIds()) == Charuco(*counts, 40.0).marker_count


@pytest.mark.parametrize("name", ["4X4_50", "APRILTAG_16h5", "ARUCO_ORIGINAL"])
def test_charuco_dictionary_is_found_by_name(name):
    image, _ = board_image(TILTS_DEG[0], Charuco(7, 5, 40.0, name, 29.0))
    markers = find_markers(image)
    assert markers.dictionary == name
    assert len(markers.numbers) >= 22
    assert set(markers.numbers) <= set(range(24))


def test_marker_dictionary_contains_all_numbers():
    target = Charuco(12, 8, 40.0, "4X4_250", 29.0)
    image = cv2.resize(sheet(target), None, fx=0.5, fy=0.5)
    assert find_markers(image).dictionary == "4X4_100"


@pytest.mark.parametrize("border", [1, 2])
def test_april_tag_grid_is_named(border):
    """Tags in every cell, with the black squares and the border of Kalibr."""
    tags = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    print_, side, pitch = np.full((360, 440), 255, np.uint8), 60, 78
    for v, u in np.ndindex(5, 6):
        square = np.s_[pitch * v :, pitch * u :]
        print_[square][2:20, 2:20] = 0
        if v < 4 and u < 5:
            tag = tags.generateImageMarker(5 * v + u, side, borderBits=border)
            print_[square][20 : 20 + side, 20 : 20 + side] = tag
    image, _ = board_image(TILTS_DEG[1], print_=print_)
    reasons = (
        find_charuco(image, TARGET).reason,
        with_marker_hint(rejected(6, 4, "no"), image).reason,
    )
    for reason in reasons:
        assert reason.startswith("this is an AprilTag grid (")
        assert "markers of APRILTAG_36h11, 5 in a row); set target.kind" in reason
