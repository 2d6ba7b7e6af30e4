"""raxel decode on invalid sets: one line, and no output."""

import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.cli import main
from raxel.cli.active_grids import _of_response, _summary
from raxel.sets import PatternPlan, load_set
from tests.active_grids import drawn
from tests.raxel.cli.test_cli_active_grid import error_line, recorded


@pytest.fixture
def folder(tmp_path):
    return recorded(tmp_path / "set", drawn(noise=2.0, blur=0.8))


def again(folder, name, change):
    """Replace an image of the set."""
    path = str(folder / name)
    cv2.imwrite(path, change(cv2.imread(path, cv2.IMREAD_UNCHANGED)))


def test_decode_rejects_exchanged_images(tmp_path, capsys, folder):
    first, second = folder / "phase-x-1.png", folder / "phase-x-2.png"
    aside = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(aside)
    line = error_line(capsys, "decode", folder, "--out", tmp_path / "points")
    assert "set.yaml: views: pose: phase-x-0.png to phase-x-3.png: " in line
    assert "phase steps along x are not in order" in line
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda i: i[:-1], "19 of 20 images, 1 is 160 x 119 (gray-y-01.png); remove"),
        (
            lambda i: i.astype(np.uint16) * 257,
            "gray-y-01.png: 16 bit differs from 8 bit of gray-x-00.png; save all",
        ),
    ],
)
def test_decode_rejects_other_size_or_depth(tmp_path, capsys, folder, change, message):
    again(folder, "gray-y-01.png", change)
    assert message in error_line(capsys, "decode", folder, "--out", tmp_path / "points")
    assert not (tmp_path / "points").exists()


def test_decode_warns_of_brightness_change(tmp_path, capsys, folder):
    again(folder, "gray-x-00.png", lambda i: np.rint(0.88 * i).astype(np.uint8))
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1].startswith("warning: pose: gray-x-00.png: 1")
    (warning,) = json.loads((out / "decoded.json").read_text())["warnings"]
    assert lines[-1] == f"warning: {warning}"


def test_decode_excludes_pixels_with_one_clipped_channel(tmp_path, capsys, folder):
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


def test_decode_warns_of_inconsistent_handedness(tmp_path, capsys):
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
    result = capsys.readouterr().out
    assert "warning: pose-2 shows the grid mirrored, pose does not: " in result


def test_decode_on_full_disk_leaves_no_output(tmp_path, capsys, folder, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    out = tmp_path / "points"
    assert main(["decode", str(folder), "--out", str(out)]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_decode_excludes_clipped_12_bit_pixels(tmp_path, capsys):
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


def test_decode_summary_matches_arrays(tmp_path, capsys):
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
    due = {"view": "pose", "unit": "mm", "margin_px": 7, "as_in_a_mirror": False}
    due["step_errors"] = [0.0, 0.0]
    assert view | due == view


@pytest.mark.parametrize("margin", [3_000_000_000, 20_000])
def test_decode_rejects_too_large_margin(tmp_path, capsys, folder, margin):
    image_set = load_set(folder)
    most = (min(image_set.width, image_set.height) - 1) // 2
    words = "decode", folder, "--out", tmp_path / "points", "--margin"
    line = error_line(capsys, *words, margin)
    assert f"--margin: found {margin} px, but the images have" in line
    assert f"give at most {most}" in line
    assert "but the images have" in error_line(capsys, *words, most + 1)
    assert not (tmp_path / "points").exists()


def test_decode_summary_reports_response_per_axis():
    response = [
        SimpleNamespace(ripple=SimpleNamespace(steps=steps), size=size, remaining=left)
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
    result = _summary("pose", found)
    assert result["response"] == {
        "corrected": [False, True], "shift": [0.0, 0.7], "left": [0.1, 0.2],
    }  # fmt: skip
    assert (result["step_errors"], result["noise_factors"]) == ([0.0, 0.4], [1.0, 1.2])
    assert _of_response(result) == "; response corrected: y by 0.7 mm, 0.2 left"
