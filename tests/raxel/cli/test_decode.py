"""raxel decode on sets that are not as they should be: one line, and nothing kept."""

import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.cli import main
from raxel.cli.decode import _of_response, _summary
from raxel.sets import PatternPlan, load_set
from tests.active_grids import drawn
from tests.raxel.cli.test_cli_active_grid import recorded, refused


@pytest.fixture
def folder(tmp_path):
    return recorded(tmp_path / "set", drawn(noise=2.0, blur=0.8))


def again(folder, name, change):
    """Another picture in place of one of the set."""
    path = str(folder / name)
    cv2.imwrite(path, change(cv2.imread(path, cv2.IMREAD_UNCHANGED)))


def test_pictures_exchanged(tmp_path, capsys, folder):
    first, second = folder / "phase-x-1.png", folder / "phase-x-2.png"
    aside = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(aside)
    line = refused(capsys, "decode", folder, "--out", tmp_path / "points")
    assert "set.yaml: views: pose: the phase steps along x" in line
    assert "not in order" in line
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda i: i[:-1], "gray-y-01.png: 160 x 119 px differs from resolution"),
        (
            lambda i: i.astype(np.uint16) * 257,
            "gray-y-01.png: 16 bit differs from 8 bit of gray-x-00.png; save all",
        ),
    ],
)
def test_a_picture_of_another_size_or_depth(tmp_path, capsys, folder, change, message):
    again(folder, "gray-y-01.png", change)
    assert message in refused(capsys, "decode", folder, "--out", tmp_path / "points")
    assert not (tmp_path / "points").exists()


def test_a_change_of_light_is_a_warning(tmp_path, capsys, folder):
    again(folder, "gray-x-00.png", lambda i: np.rint(0.88 * i).astype(np.uint8))
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1].startswith("warning: pose: gray-x-00.png is 1")
    (warning,) = json.loads((out / "decoded.json").read_text())["warnings"]
    assert lines[-1] == f"warning: {warning}"


def test_a_colour_clipped_is_no_sine(tmp_path, capsys, folder):
    """Blue at its end where grey is far from it."""
    for pattern in load_set(folder).views[0].patterns:

        def coloured(i):
            grey = i.astype(float)
            parts = [1.35 * grey, 0.9 * grey, grey]
            return np.clip(np.stack(parts, axis=-1), 0, 255).astype(np.uint8)

        again(folder, pattern.image, coloured)
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 0
    assert "are excluded (overexposed); reduce the exposure" in capsys.readouterr().out
    with np.load(out / "pose.npz") as found:
        crest = cv2.imread(str(folder / "phase-x-0.png"))[..., 0] == 255
        assert not found["mask"][crest].any()
        assert found["mask"].mean() > 0.1


def test_only_some_views_as_in_a_mirror(tmp_path, capsys):
    scene, text = drawn(noise=2.0), ""
    folder = recorded(tmp_path / "set", scene)
    text = (folder / "set.yaml").read_text()
    _, views = text.split("views:\n")
    for pattern, image in zip(scene.patterns, scene.images, strict=True):
        cv2.imwrite(str(folder / f"2-{pattern.image}"), image[:, ::-1])
    views = views.replace("pose", "pose-2").replace("image: ", "image: 2-")
    (folder / "set.yaml").write_text(text + views)
    out = str(tmp_path / "points")
    assert main(["decode", str(folder), "--out", out]) == 0
    told = capsys.readouterr().out
    assert "warning: pose-2 shows the grid as in a mirror, and pose does not" in told


def test_a_full_disk_leaves_nothing(tmp_path, capsys, folder, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_twelve_bits_in_files_of_sixteen(tmp_path, capsys):
    """What the camera clipped is left out, though the file could hold more."""
    scene = drawn(noise=2.0, dtype=np.uint16)
    scene.images = np.minimum(scene.images // 12, 4095).astype(np.uint16)
    folder = recorded(tmp_path / "set", scene)
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 0
    sines = [k for k, p in enumerate(scene.patterns) if p.kind == "phase"]
    crest = scene.images[sines].max(axis=0)
    with np.load(out / "pose.npz") as found:
        assert (crest == 4095).mean() > 0.02
        assert not found["mask"][crest == 4095].any()
        assert found["mask"].mean() > 0.1


def test_what_the_summary_says_of_a_view(tmp_path, capsys):
    """Along y the sines have periods of another length, and five steps."""
    plan = PatternPlan((3, 4), True, 5, (8.0, 5.5))
    folder = recorded(tmp_path / "set", drawn(noise=2.0, blur=0.8, plan=plan))
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 0
    summary = json.loads((out / "decoded.json").read_text())
    assert set(summary) == {"set", "views", "warnings"}
    assert (summary["set"], summary["warnings"]) == ("drawn", [])
    (view,) = summary["views"]
    with np.load(out / "pose.npz") as found:
        sigma, mask = found["sigma_mm"], found["mask"]
    assert view["median_sigma"] == pytest.approx(np.nanmedian(sigma, axis=(0, 1)))
    assert view["pixels"]["decoded"] == mask.sum()
    assert sum(view["pixels"].values()) == mask.size
    assert view["noise_floor"] + 110 * view["noise_slope"] == pytest.approx(4, rel=0.15)
    assert view["blur_px"] == pytest.approx(0.8, abs=0.15)
    known = {key: view[key] for key in ("view", "unit", "margin_px", "as_in_a_mirror")}
    due = {"view": "pose", "unit": "mm", "margin_px": 7, "as_in_a_mirror": False}
    assert known == due
    assert view["step_errors"] == [0.0, 0.0]


@pytest.mark.parametrize("margin", [3_000_000_000, 20_000])
def test_a_margin_that_leaves_nothing(tmp_path, capsys, folder, margin):
    image_set = load_set(folder)
    most = (min(image_set.width, image_set.height) - 1) // 2
    words = "decode", folder, "--out", tmp_path / "points", "--margin"
    line = refused(capsys, *words, margin)
    assert f"--margin: found {margin} px, and nothing is left" in line
    assert f"give {most} at most" in line
    assert "nothing is left" in refused(capsys, *words, most + 1)
    assert not (tmp_path / "points").exists()


def test_the_summary_tells_what_the_response_did_and_what_is_left_of_each_axis():
    response = [
        SimpleNamespace(ripple=SimpleNamespace(steps=steps), size=size, left=left)
        for steps, size, left in ((0, 0.0, 0.1), (5, 0.7, 0.2))
    ]
    decoded = SimpleNamespace(
        counts=dict, unit="mm", sigma=np.ones((2, 2, 2)), blur_px=None, margin_px=3,
        noise=SimpleNamespace(floor=1.0, slope=0.5), response=response,
    )  # fmt: skip
    found = SimpleNamespace(
        decoded=decoded, step_errors=[0.0, 0.4], noise_factors=[1.0, 1.2],
        as_in_a_mirror=False,
    )  # fmt: skip
    told = _summary("pose", found)
    assert told["response"] == {
        "corrected": [False, True], "shift": [0.0, 0.7], "left": [0.1, 0.2],
    }  # fmt: skip
    assert (told["step_errors"], told["noise_factors"]) == ([0.0, 0.4], [1.0, 1.2])
    assert _of_response(told) == "; response corrected: y by 0.7 mm, 0.2 left"
