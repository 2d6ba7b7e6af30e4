"""Mirror sets: mirror.yaml is read, and inconsistent sets are rejected."""

import pytest
import yaml

from raxel.cli import main
from raxel.errors import InputError
from raxel.sets import is_mirror_set, load_mirror_set
from tests.image_sets import COLUMNS, ROWS
from tests.mirror_sets import MONITOR, code, mirror_description, write_mirror_set

PLATTER = ("near", "far", "near.2")
STEPS = mirror_description()["stages"]["steps"]
PRIMARY = mirror_description()["primary"]
WITHOUT_PITCH = {
    "kind": "chessboard",
    "columns": COLUMNS,
    "rows": ROWS,
    "pitch_mm": None,
}


def test_mirror_set_is_read(tmp_path):
    write_mirror_set(tmp_path)
    found = load_mirror_set(tmp_path)
    assert is_mirror_set(tmp_path)
    assert found.thickness_mm == 1.27
    assert found.clamp.points == ((10.0, 20.0), (12.0, 200.0))
    assert (found.clamp.sd_px, found.clamp.hidden_mm) == (0.5, 0.0)
    assert [step.deflection_mm for step in found.steps] == [5.0, None]
    assert found.steps[1].evaluate == ("view3.png",)
    assert [view.label for view in found.grids.views] == ["near", "far"]
    assert found.stages.target.columns == COLUMNS


@pytest.mark.parametrize(
    ("data", "of_sets", "named"),
    [
        ({"clamp": {"point": [[1, 2], [3, 4]]}}, {}, "clamp.point: unknown key"),
        ({"viewer": "../viewer"}, {}, "viewer: ../viewer is outside the set's folder"),
        ({"viewer": "camera.npz"}, {}, "viewer: no file camera.npz"),
        (
            {"clamp": {"points": [[5, 5], [5, 5]]}},
            {},
            "clamp.points: all points are equal",
        ),
        ({"clamp": {"points": [[5, 5], [5, 900]]}}, {}, "clamp.points[1]: [5, 900]"),
        (
            {"clamp": {"points": [[5, 5], [5, 250]]}},
            {},
            "[5, 250] is outside the image of 320 x 240 px",
        ),
        (
            {},
            {"grids": {"views": [{"name": "near", "patterns": code(0)}]}},
            "primary.grids: 1 position of the active grid; give 2 or more",
        ),
        ({}, {"stages": {"resolution": [330, 240]}}, "stages.set: images have"),
        ({}, {"stages": {"target": WITHOUT_PITCH}}, "target.pitch_mm is null"),
        (
            {},
            {"platter": {"target": MONITOR | {"monitor_mm": [40, 30]}}},
            "differs from that of",
        ),
        ({"primary": PRIMARY | {"grids": "plate"}}, {}, "target is a board; give"),
        ({"primary": PRIMARY | {"plate": "stages"}}, {}, "4 images for 2 views"),
    ],
)
def test_mirror_set_error_names_field(tmp_path, data, of_sets, named):
    write_mirror_set(tmp_path, mirror_description(**data), **of_sets)
    with pytest.raises(InputError) as rejected:
        load_mirror_set(tmp_path)
    assert named in str(rejected.value)
    assert "\n" not in str(rejected.value)


@pytest.mark.parametrize(
    ("step", "named"),
    [
        ({"before": "view9.png", "after": "view2.png"}, "steps[1].before: view9"),
        ({"before": "view0.png", "after": "view2.png"}, "taken after 0 deflections"),
        ({"before": "view1.png", "after": "view1.png"}, "taken after 1 deflections"),
    ],
)
def test_image_shows_one_mirror_state(tmp_path, step, named):
    stages = {"set": "stages", "steps": [STEPS[0], step]}
    write_mirror_set(tmp_path, mirror_description(stages=stages))
    with pytest.raises(InputError) as rejected:
        load_mirror_set(tmp_path)
    assert named in str(rejected.value)


def test_evaluation_image_may_begin_next_step(tmp_path):
    """It shows the mirror after its step, as the one before the next one does."""
    first = STEPS[0] | {"evaluate": ["view2.png"]}
    stages = {"set": "stages", "steps": [first, STEPS[1] | {"before": "view2.png"}]}
    stages["steps"][1] |= {"after": "view3.png", "evaluate": []}
    write_mirror_set(tmp_path, mirror_description(stages=stages))
    assert load_mirror_set(tmp_path).steps[0].evaluate == ("view2.png",)
    stages["steps"][1]["after"] = "view2.png"
    (tmp_path / "mirror.yaml").write_text(
        yaml.safe_dump(mirror_description(stages=stages)), "utf-8"
    )
    with pytest.raises(InputError, match="after 1 deflections"):
        load_mirror_set(tmp_path)


def test_position_without_flat_mirror_image_is_named(tmp_path):
    write_mirror_set(tmp_path)
    path = tmp_path / "platter" / "set.yaml"
    path.write_text(path.read_text("utf-8").replace("name: far", "name: else"), "utf-8")
    with pytest.raises(InputError, match="view far"):
        load_mirror_set(tmp_path)


def test_check_lists_mirror_set_contents(tmp_path, capsys):
    write_mirror_set(tmp_path)
    assert main(["check", str(tmp_path)]) == 0
    reported = capsys.readouterr().out
    assert "platter    1.27 mm in front of its board" in reported
    assert "2 deflections (5 mm, not stated), 1 board to evaluate" in reported
    assert reported.count("images     ") == 5


def test_position_may_occur_twice_in_flat_mirror(tmp_path):
    views = [{"name": name, "patterns": code(k)} for k, name in enumerate(PLATTER)]
    image_views = [{"image": f"view{k}.png"} for k in range(3)]
    of_sets = {"platter": {"views": views}, "plate": {"views": image_views}}
    write_mirror_set(tmp_path, **of_sets)
    found = load_mirror_set(tmp_path)
    assert (found.platter_views("near"), found.platter_views("far")) == ([0, 2], [1])


def test_view_without_position_is_named(tmp_path):
    names = [*PLATTER, "nearer"]
    views = [{"name": name, "patterns": code(k)} for k, name in enumerate(names)]
    write_mirror_set(tmp_path, platter={"views": views})
    with pytest.raises(InputError, match="view nearer"):
        load_mirror_set(tmp_path)
