"""Corners of mrcal and OpenCV, targets of Kalibr."""

import json

import cv2
import numpy as np
import pytest

from raxel.cli import main
from raxel.errors import InputError
from raxel.features.boards import read_boards
from raxel.sets import AprilGrid, Chessboard, CircleGrid, load_set, read_kalibr_target
from tests.image_sets import COLUMNS, FOCAL, HEIGHT, ROWS, WIDTH, write_drawn_set


@pytest.fixture
def drawn(tmp_path):
    """(ImageSet, corners (n, N, 2) px) of rendered boards."""
    boards = write_drawn_set(tmp_path / "set")
    return load_set(tmp_path / "set"), np.array([board.corners() for board in boards])


def vnl(corners):
    """The text of a .vnl file, with a missing board and a missing corner."""
    lines = ["## detected", "# filename x y level", "", "a/view0.png - - -"]
    for k, board in enumerate(corners[1:], 1):
        lines += [f"a/view{k}.png {u} {v} 0" for u, v in board]
    lines[4 + 3] = "a/view1.png - - -"
    return "\n".join(lines)


def storage(path, corners, order, **more):
    """A cv2.FileStorage of corners in some order."""
    points = Chessboard(COLUMNS, ROWS, 20.0).points()
    solid = np.column_stack([points, np.zeros(len(points))])[order]
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, values in (
        ("object_points", [solid] * len(corners)),
        ("image_points", corners[:, order]),
    ):
        file.startWriteStruct(name, cv2.FILE_NODE_SEQ)
        for one in values:
            file.write("", one[None])
        file.endWriteStruct()
    for name, values in more.items():
        file.startWriteStruct(name, cv2.FILE_NODE_SEQ)
        for value in values:
            file.write("", value)
        file.endWriteStruct()
    file.release()


def test_vnl_corners_are_read(drawn, tmp_path):
    image_set, corners = drawn
    (tmp_path / "c.vnl").write_text(vnl(corners), "utf-8")
    first, second, *rest = read_boards(tmp_path / "c.vnl", image_set)
    assert not first.detection.found
    assert np.flatnonzero(np.isnan(second.detection.corners[:, 0])).tolist() == [3]
    for board, truth in zip(rest, corners[2:], strict=True):
        np.testing.assert_array_equal(board.detection.corners, truth)


@pytest.mark.parametrize("line", ["view1.png 3 x 0", "view1.png 3"])
def test_vnl_line_is_named(drawn, tmp_path, line):
    (tmp_path / "c.vnl").write_text(f"# filename x y level\n{line}\n", "utf-8")
    with pytest.raises(InputError, match="line 2: not 'filename x y level'"):
        read_boards(tmp_path / "c.vnl", drawn[0])


@pytest.mark.parametrize("ending", ["xml", "yml"])
def test_storage_is_ordered_by_object_points(drawn, tmp_path, ending):
    image_set, corners = drawn
    order = np.random.default_rng(0).permutation(COLUMNS * ROWS)
    storage(tmp_path / f"c.{ending}", corners, order)
    boards = read_boards(tmp_path / f"c.{ending}", image_set)
    for board, truth in zip(boards, corners, strict=True):
        np.testing.assert_allclose(board.detection.corners, truth, atol=1e-5)


def test_storage_calibrates_without_images(drawn, tmp_path, capsys):
    path, result = tmp_path / "c.xml", tmp_path / "result.json"
    order = np.arange(COLUMNS * ROWS)
    storage(path, drawn[1], order, image_size=(WIDTH, HEIGHT))
    options = (
        "--model",
        "zhang",
        "--json",
        str(result),
        "--out",
        str(tmp_path / "k.npz"),
    )
    assert main(["calibrate", str(path), *options]) == 0
    found = json.loads(result.read_text("utf-8"))
    assert found["set"] == "c"
    assert abs(found["camera"]["K"][0][0] - FOCAL) < 1
    storage(path, drawn[1], order)
    assert main(["calibrate", str(path), *options]) == 2
    assert "image_size is missing" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "target"),
    [
        (
            "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.02 # m\n"
            "tagSpacing: 0.3\ncodeOffset: 4\n",
            AprilGrid(12, 10, 26.0, 20.0, first_id=4),
        ),
        (
            "target_type: checkerboard\ntargetCols: 7\ntargetRows: 6\n"
            "rowSpacingMeters: 0.03\ncolSpacingMeters: 0.03\n",
            Chessboard(7, 6, 30.0),
        ),
        (
            "target_type: circlegrid\ntargetCols: 4\ntargetRows: 11\n"
            "spacingMeters: 0.02\nasymmetricGrid: True\n",
            CircleGrid(4, 11, 20.0, staggered=True),
        ),
    ],
)
def test_kalibr_target_is_read(tmp_path, text, target):
    path = tmp_path / "target.yaml"
    path.write_text(text, "utf-8")
    assert read_kalibr_target(path) == target
    path.write_text(text.replace("Rows:", "Cells:"), "utf-8")
    with pytest.raises(InputError, match="Rows: missing; add it"):
        read_kalibr_target(path)
