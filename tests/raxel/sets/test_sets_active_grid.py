"""What set.yaml may not say of an active grid: each fault in one line."""

import os

import pytest

from raxel.errors import InputError
from raxel.sets import load_set, patterns_of, plan_of_cells
from tests.image_sets import write_description

SIZE = 1024, 768


def described(folder, patterns, **view):
    """A set of empty files, as set.yaml has it."""
    listed = []
    for pattern in patterns:
        entry = {k: v for k, v in vars(pattern).items() if v is not None}
        del entry["inverse" if pattern.kind == "phase" else "offset"]
        listed.append(entry)
    for name in {*(p.image for p in patterns), *view.values()}:
        (folder / name).write_bytes(b"")
    return {
        "raxel_set": 1,
        "name": "grid",
        "resolution": [64, 48],
        "target": {"kind": "active_grid", "monitor_px": list(SIZE)},
        "views": [{"name": "pose", **view, "patterns": listed}],
    }


@pytest.fixture
def grid(tmp_path):
    patterns = patterns_of(plan_of_cells(SIZE, phase_steps=4))
    return described(tmp_path, patterns, white="w.png", black="b.png")


def message_of(folder, data):
    write_description(folder, data)
    with pytest.raises(InputError) as fault:
        load_set(folder)
    text = str(fault.value)
    assert "\n" not in text
    return text.removeprefix(f"{folder / 'set.yaml'}: views[0].")


def test_complete_and_partial_codes_are_valid(tmp_path, grid):
    listed = grid["views"][0]["patterns"]
    for kept in (
        listed,
        listed[::-1],
        [p for p in listed if p["axis"] == "y"],
        [p for p in listed if p["kind"] == "gray"],
        [p for p in listed if not p.get("inverse")],
        [p for p in listed if p.get("bit", 0) < 2],
    ):
        grid["views"][0]["patterns"] = kept
        write_description(tmp_path, grid)
        assert len(load_set(tmp_path).views[0].patterns) == len(kept)


def changed(number, **fields):
    def change(view):
        view["patterns"][number] |= fields

    return change


def excluded(number):
    return lambda view: view["patterns"].pop(number)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (excluded(0), "patterns[0]: bit 0 of axis x has only its inverse; add the ima"),
        (excluded(14), "patterns: phase code of axis x lacks step 2 of 4; add its ima"),
        (changed(2, bit=0), "patterns[2]: same pattern as patterns[0]; correct axis"),
        (
            changed(2, of=4),
            "patterns[2].of: 4 differs from 3 in patterns[0] of the same",
        ),
        (
            changed(13, offset=0.25),
            "patterns[13].offset: 0.25 differs from 0 in patter",
        ),
        (changed(13, offset=90), "patterns[13].offset: found 90; give the part of"),
        (changed(0, offset=0.0), "patterns[0].offset: unknown key; known are image"),
        (
            changed(3, cell_px=64.0),
            "patterns[3].cell_px: 64 differs from 128 in patterns[0] of the same code",
        ),
        (
            changed(13, image="phase-x-0.png"),
            "patterns[13].image: 'phase-x-0.png' is the same file as "
            "'phase-x-0.png' of views[0].patterns[12]; list it once",
        ),
        (
            changed(5, image="w.png"),
            "patterns[5].image: 'w.png' is the same file as 'w.png' of views[0]",
        ),
        (lambda v: v.update(black="w.png"), "black: 'w.png' is the same file as"),
        (lambda v: v.update(white="none.png"), "white: no file 'none.png' in"),
        (
            lambda v: [p.update(periods=600.0) for p in v["patterns"][12:16]],
            "patterns[12].periods: 600 periods on 1024 px of the monitor; give at",
        ),
        (
            lambda v: [p.update(cell_px=100.0) for p in v["patterns"][:6]],
            "patterns[0].cell_px: 8 cells of 100 px do not cover",
        ),
    ],
)
def test_invalid_patterns_are_reported(tmp_path, grid, change, message):
    change(grid["views"][0])
    assert message_of(tmp_path, grid).startswith(message)


@pytest.mark.parametrize(
    ("origin", "found"),
    [
        ((50.0, 50.0), ""),
        ((40.0, 50.0), "squares from [-10.0, 0.0] to [390.0, 300.0] px exceed"),
        ((50.0, 49.0), "squares from [0.0, -1.0] to [400.0, 299.0] px exceed"),
        ((674.0, 518.0), ""),
        ((675.0, 518.0), "squares from [625.0, 468.0] to [1025.0, 768.0] px exceed"),
        ((674.0, 519.0), "squares from [624.0, 469.0] to [1024.0, 769.0] px exceed"),
    ],
)
def test_monitor_chessboard_needs_surrounding_square(tmp_path, grid, origin, found):
    """7 x 5 corners of squares of 50 px: the first one lies a square further in."""
    board = {"columns": 7, "rows": 5, "pitch_px": 50.0, "origin_px": list(origin)}
    grid["target"]["chessboard"] = board
    if found:
        assert f"target.chessboard: {found}" in message_of(tmp_path, grid)
    else:
        write_description(tmp_path, grid)
        assert load_set(tmp_path).target.chessboard.origin_px == origin


def test_code_finer_than_pixels_needs_cell_px(tmp_path):
    """Ten bits along 768 px: not cells of 0.75 px, but of one, truncated at the end."""
    patterns = patterns_of(plan_of_cells(SIZE, 2, 4))
    data = described(tmp_path, ([p for p in patterns if p.kind == "gray"]))
    for entry in data["views"][0]["patterns"]:
        entry["of"] = 10
        del entry["cell_px"]
    assert message_of(tmp_path, data).startswith(
        "patterns[2].of: 1024 cells of 0.75 px on 768 px of the monitor; correct of, "
        "or give cell_px: 1 if the code counts pixels"
    )
    for entry in data["views"][0]["patterns"]:
        entry["cell_px"] = 1.0
    write_description(tmp_path, data)
    assert load_set(tmp_path).views[0].patterns[2].cell_px == 1


def test_image_belongs_to_one_pose(tmp_path, grid):
    """Known by the file, whatever it is called."""
    first = grid["views"][0]
    os.link(tmp_path / "w.png", tmp_path / "other.png")
    second = {"name": "pose-2", "patterns": [dict(p) for p in first["patterns"]]}
    for entry in second["patterns"]:
        entry["image"] = f"2-{entry['image']}"
        (tmp_path / entry["image"]).write_bytes(b"")
    grid["views"].append(second)
    write_description(tmp_path, grid)
    assert len(load_set(tmp_path).views) == 2
    second["white"] = "other.png"
    line = message_of(tmp_path, grid)
    assert line.endswith("same file as 'w.png' of views[0]; list it once")
