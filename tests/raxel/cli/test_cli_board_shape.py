"""`raxel evaluate --board` rejects the shape of another board."""

import json

import pytest

from raxel.cli import main
from tests.made_sets import COLUMNS, PINHOLE, ROWS, boards_of, write_made_set


@pytest.mark.parametrize(
    ("field", "value", "fault"),
    [
        ("size", [160, 0], "board_shape.size[1]: found 0; give a length larger than 0"),
        ("size", [80, 120], "board_shape: found one from (40, 0) to (120, 120), and"),
        (
            "middle",
            [900, 0],
            "board_shape: found one from (820, -60) to (980, 60), and",
        ),
        ("corners", [8, 5], "board_shape.corners: found 8 x 5 corners, and the set"),
        (
            "corners",
            None,
            "board_shape.corners: found a monitor, and the set has 9 x 7",
        ),
        (
            "stretch",
            {"value": -1, "used": True},
            "board_shape: found bends or a stretch",
        ),
        (
            "bend_y",
            {"value": 40, "used": True},
            "board_shape: found bends or a stretch",
        ),
        ("twist", {"value": "2", "used": True}, "board_shape.twist.value: found '2'"),
        ("unit", "pitch", "unit: found 'pitch', and the set is in mm"),
        ("board_shape", [], "board_shape: found a list"),
        ("board_shape", "left out", "board_shape: missing"),
        ("pitch", 25.0, "board_corners.pitch: found 25 mm, and the set has 20 mm"),
        ("columns", 7, "board_corners: found 7 x 9 corners, and the set has 9 x 7"),
        ("offsets", [[0, 0, "1"]], "board_corners.offsets[0][2]: found '1'; give a"),
    ],
)
def test_shape_of_another_board_is_rejected(tmp_path, capsys, field, value, fault):
    folder, corners = write_made_set(tmp_path / "set", boards_of(PINHOLE))
    PINHOLE.save(tmp_path / "camera.npz")
    term = {"value": 0.1, "used": True}
    shape = dict.fromkeys(("bend_x", "bend_y", "twist", "stretch"), term)
    shape |= {"middle": [80, 60], "size": [160, 120], "corners": [COLUMNS, ROWS]}
    displaced = {"used": True, "columns": COLUMNS, "pitch": 20.0}
    displaced["offsets"] = [[0.0, 0.0, 0.1]] * COLUMNS * ROWS
    data = {"unit": "mm", "board_shape": shape, "board_corners": displaced}
    parts = data, displaced, shape
    next(part for part in parts if field in part or part is shape)[field] = value
    if value == "left out":
        del data[field]
    path = tmp_path / "result.json"
    path.write_text(json.dumps(data))
    command = ["evaluate", tmp_path / "camera.npz", folder, "--corners", corners]
    assert main([*map(str, command), "--board", str(path)]) == 2
    printed = capsys.readouterr().err
    assert printed.startswith(f"raxel: {path}: {fault}"), printed
    assert printed.count("\n") == 1
