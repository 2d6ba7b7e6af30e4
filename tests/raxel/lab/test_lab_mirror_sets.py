"""Mirror rigs, and the mirror sets that are rendered of them."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml

from raxel.cameras import load_camera, pixel_grid
from raxel.cli import main
from raxel.errors import InputError
from raxel.geometry import on_plane, transform
from raxel.io.files import read_json
from raxel.lab import mirror_set_rig as rendering
from raxel.lab import target_poses
from raxel.lab.mirror_set_rig import (
    is_mirror_set_rig,
    load_mirror_set_rig,
    render_mirror_set,
)
from raxel.sets import load_mirror_set, read_image
from tests.raxel.lab.test_rig import ORIGINS, quantities
from tests.tiny_mirror_rig import RIGS, SETS, tiny_rig


@pytest.fixture(scope="module")
def rig():
    return tiny_rig()


@pytest.fixture(scope="module")
def rendered(rig, tmp_path_factory):
    return render_mirror_set(rig, tmp_path_factory.mktemp("tiny") / "set", 3)


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.mark.parametrize("name", SETS)
def test_mirror_rigs_are_valid(name):
    path = RIGS / f"{name}.yaml"
    assert is_mirror_set_rig(path)
    rig = load_mirror_set_rig(path)
    assert (rig.name, list(rig.light)) == (f"mirror-{name}", ["low", "middle", "high"])
    for shares in zip(*rig.light.values(), strict=True):
        assert list(shares) == sorted(shares, reverse=True)
    assert len(rig.cameras(0)) == len(rig.stages) == 4
    for file in (path, *(getattr(rig, key).path for key in ("viewer", "plate"))):
        leaves = list(quantities(yaml.safe_load(file.read_text("utf-8"))))
        assert len(leaves) >= 7
        for quantity in leaves:
            assert quantity["origin"] in ORIGINS
            assert len(quantity["reason"]) > 5


def test_rendered_mirror_set_has_truth(rig, rendered):
    assert (rendered.name, rendered.size) == ("mirror-clean-low-3", (128, 96))
    (step,) = rendered.steps
    assert step.deflection_mm == 5.0
    assert rendered.thickness_mm == 0.381
    labels = [view.label for view in rendered.grids.views]
    assert labels == [view.label for view in rendered.platter.views] == ["near", "far"]
    for k, deflections in enumerate(rig.stages):
        camera = load_camera(rendered.folder / "truth" / f"stage-{k}.npz")
        assert tuple(camera.deflections) == deflections
    poses = read_json(rendered.folder / "truth" / "poses.json")["T_camera_target"]
    assert sorted(poses) == ["s1-after.png", "s1-before.png"]
    board = on_plane(rendered.stages.target.points())
    pixels, valid = camera.project(transform(np.array(poses[step.after]), board))
    assert (valid & camera.in_image(pixels)).all()


def test_image_noise_is_independent(rendered):
    # Where the mirror is not, all is dark: what differs there is noise alone.
    off_mirror = ~load_camera(rendered.folder / "truth/stage-0.npz").rays(
        pixel_grid(*rendered.size)
    ).valid.reshape(rendered.size[::-1])
    dark = [
        read_image(visible, f"{where}/black.png")[off_mirror].astype(float)
        for visible in (rendered.grids, rendered.platter)
        for where in ("near", "far")
    ]
    assert np.abs(np.corrcoef(dark) - np.eye(len(dark))).max() < 0.5
    assert np.std(dark, axis=1).min() > 1


def test_random_streams_are_distinct(rig, tmp_path, monkeypatch):
    made, drawn = np.random.default_rng, {}

    def noted(seed):
        # What is drawn again by the same numbers is meant to be the same.
        drawn.setdefault(made(seed).bytes(16), set()).add(str(seed))
        return made(seed)

    monkeypatch.setattr(np.random, "default_rng", noted)
    render_mirror_set(rig, tmp_path / "set", 3)
    assert len(drawn) > 20
    assert [seeds for seeds in drawn.values() if len(seeds) > 1] == []


def test_step_images_have_independent_noise(rig, tmp_path, monkeypatch):
    noises, specimens = [], []

    def rendered_board(_, T, noise, specimen):
        noises.append(noise.random(4))
        specimens.append(specimen.random(4))
        return np.zeros((96, 128), np.uint8)

    monkeypatch.setattr(rendering, "render_board", rendered_board)
    rendering._write_steps(rig, rig.cameras(3), tmp_path / "stages", 3, str)
    before, after = noises
    assert np.all(before != after)
    # The mirror's spots are those of one specimen.
    np.testing.assert_array_equal(*specimens)


def test_boards_are_visible_before_and_after(rig):
    pair = rig.cameras(0)
    board = on_plane(rig.steps.target.points())
    for seed in range(4):
        T = rig.step_pose(np.random.default_rng(seed), *pair)
        for camera in pair:
            pixels, valid = camera.project(transform(T, board))
            assert (valid & camera.in_image(pixels)).all()


def test_seed_and_level_determine_bytes(rig, rendered, tmp_path):
    render_mirror_set(rig, tmp_path / "again", 3)
    first, again = contents(rendered.folder), contents(tmp_path / "again")
    assert first == again
    darker = render_mirror_set(rig, tmp_path / "high", 3, "high")
    assert darker.name == "mirror-clean-high-3"
    truth = {name for name in first if name.startswith("truth/")}
    high = contents(darker.folder)
    assert {name for name in first if first[name] != high[name]} >= {
        name for name in first if name.endswith(".png")
    }
    assert all(first[name] == high[name] for name in truth)
    black, white = (
        [read_image(of(one), name)[:5].mean() for one in (rendered, darker)]
        for of, name in (
            (lambda one: one.grids, "near/black.png"),
            (lambda one: one.plate, "near.png"),
        )
    )
    # Around the mirror all is dark; gamma lifts the noise there. Paper is as light.
    assert black[1] > 1.5 * black[0]
    assert white[1] == pytest.approx(white[0], abs=8)


def test_calibration_does_not_read_truth(rendered, tmp_path):
    bare = shutil.copytree(rendered.folder, tmp_path / "bare")
    for folder in bare.rglob("truth"):
        shutil.rmtree(folder)
    assert load_mirror_set(bare).name == rendered.name
    assert main(["check", str(bare)]) == 0


def changed(tmp_path, change):
    """Write a changed copy of the clean rig next to the files that it names."""
    folder = tmp_path / "rigs" / "mirror-sets"
    shutil.copytree(RIGS.parent, folder.parent)
    path = folder / "clean.yaml"
    data = yaml.safe_load(path.read_text("utf-8"))
    change(data)
    path.write_text(yaml.safe_dump(data), "utf-8")
    return path


def changed_rig(name, **fields):
    return lambda data: data[name].update(fields)


FAULTS = {
    "misspelt": (
        lambda d: d.update(stagse=1),
        "stagse: unknown key; did you mean stag",
    ),
    "one stage": (
        changed_rig("stages", value=[[0]]),
        "stages.value: found a list of 1",
    ),
    "two loads": (
        changed_rig("stages", value=[[0, 0], [1, 2]]),
        "stages: wrong number of deflections; give 1 for each stage",
    ),
    "too far": (
        changed_rig("stages", value=[[0], [140]]),
        "stages: field 'deflections'",
    ),
    "wrong unit": (
        changed_rig("stages", unit="cm"),
        "stages.unit: found 'cm'; give mm",
    ),
    "no rig": (lambda d: d.update(steps="nowhere.yaml"), "nowhere.yaml: no such file"),
    "no mirror": (lambda d: d.update(steps="viewer.yaml"), "steps: camera differs"),
    "another camera": (
        lambda d: d.update(viewer="../kodak-boards-small.yaml"),
        "viewer: camera differs from the viewer of grids",
    ),
    "a board for a grid": (
        lambda d: d.update(grids="steps.yaml"),
        "grids: target is not an active grid",
    ),
    "many poses": (lambda d: d.update(plate="viewer.yaml"), "plate: 12 poses"),
    "a level twice": (
        lambda d: d["noise"].append(d["noise"][0]),
        "noise: a name is repeated",
    ),
    "all hub": (
        lambda d: d["platter"]["hub"].update(value=30),
        "platter.hub: not below the radius",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_invalid_mirror_rig_is_rejected(name, tmp_path):
    change, fault = FAULTS[name]
    path = changed(tmp_path, change)
    with pytest.raises(InputError) as raised:
        load_mirror_set_rig(path)
    assert fault in str(raised.value)
    assert str(raised.value).isprintable()


def test_invalid_render_options_are_rejected(rig, tmp_path, capsys, monkeypatch):
    out = tmp_path / "set"
    with pytest.raises(InputError, match=r"'hihg'.* high"):
        render_mirror_set(rig, out, 0, "hihg")
    (tmp_path / "there").mkdir()
    with pytest.raises(InputError, match="there"):
        render_mirror_set(rig, tmp_path / "there", 0)
    monkeypatch.setattr(target_poses, "MAX_TRIES_FOR_FIRST", 20)
    small = replace(rig.steps, poses=replace(rig.steps.poses, subtense=(1.5, 1.6)))
    with pytest.raises(InputError, match="poses: 0 of 1 "):
        render_mirror_set(replace(rig, steps=small), out, 0)
    ordinary = str(RIGS / "viewer.yaml")
    assert main(["render", ordinary, "--out", str(out), "--noise", "low"]) == 2
    assert "--noise: found with" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
