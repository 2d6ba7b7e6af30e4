"""What stands in the scenes of cameras, rigs, sets and rooms; the command `show`."""

import json
import webbrowser
from pathlib import Path

import numpy as np
import pytest

from raxel.cameras import camera_from, closest_point
from raxel.cli import main
from raxel.errors import InputError
from raxel.features.boards import detect_boards
from raxel.geometry import pose, transform
from raxel.io import rendering
from raxel.lab import Rig, load_rig
from raxel.lab.set_rendering import POSES
from raxel.sets import load_set
from raxel.show import Points, Segments, Surface, camera_scene
from raxel.show.cameras import MEASURED, field_edge, rig_scene, set_scene, spread_pixels
from raxel.show.scene import finite_points
from raxel.show.view import surface_texture
from tests.image_sets import write_drawn_set
from tests.raxel.lab.test_rig import RIGS
from tests.raxel.show.test_show import draws

LENS = {
    "K": [[130, 0, 99.5], [0, 130, 79.5], [0, 0, 1]],
    "radial": [],
    "width": 200,
    "height": 160,
}
PINHOLE = camera_from("perspective", LENS)
SPHERE = {"shape": "sphere", "axes": [30], "rim_radius": 25}


def sphere_camera():
    """A pinhole 100 mm before a ball."""
    viewer = {"kind": "perspective"} | LENS
    T = pose(np.eye(3), [0, 0, 100])
    return camera_from(
        "quadric mirror", SPHERE | {"viewer": viewer, "T_viewer_mirror": T}
    )


def of_kind(scene, kind, label):
    return [p for p in scene.parts if isinstance(p, kind) and p.label == label]


def test_field_edge_is_border_or_angle():
    u, v = field_edge(PINHOLE).T
    border = np.maximum(np.abs(u - 99.5) / 99.5, np.abs(v - 79.5) / 79.5)
    assert border == pytest.approx(1)
    lens = camera_from(
        "fisheye",
        {
            "projection": "equidistance", "focal_px": 40, "max_angle": 1.5,
            "principal_point": [99.5, 79.5], "width": 200, "height": 160,
        },
    )  # fmt: skip
    radius = np.linalg.norm(field_edge(lens) - [99.5, 79.5], axis=1)
    assert radius == pytest.approx(60, abs=1e-6)


def test_central_camera_scene():
    scene = camera_scene(PINHOLE, "mine")
    (rays,) = of_kind(scene, Segments, "ray")
    assert np.linalg.norm(rays.ends, axis=1) == pytest.approx(100)
    (centre,) = of_kind(scene, Points, "centre")
    assert np.allclose(centre.points, 0)
    assert scene.note.startswith("mine: perspective, 200 x 160 px; central")


def test_mirror_camera_scene_has_caustic():
    camera = sphere_camera()
    scene = camera_scene(camera)
    (sheet,) = of_kind(scene, Surface, "mirror")
    starts = finite_points(of_kind(scene, Points, "start of a ray")[0])
    assert np.linalg.norm(sheet.points - [0, 0, 130], axis=2) == pytest.approx(30)
    assert np.linalg.norm(starts - [0, 0, 130], axis=1) == pytest.approx(30)
    (caustic,) = of_kind(scene, Points, "caustic, sheet 1")
    assert (np.linalg.norm(caustic.points - [0, 0, 130], axis=1) < 30).all()
    assert "non-central" in scene.note
    (nearest,) = of_kind(scene, Points, "nearest to all rays")
    rays = camera.rays(spread_pixels(camera, MEASURED))
    assert nearest.points[0] == pytest.approx(closest_point(rays))


@pytest.mark.parametrize("path", RIGS, ids=lambda path: path.stem)
def test_rig_scene_uses_rendered_poses(path, monkeypatch):
    rig: Rig = load_rig(path)
    requested = []

    def noted(rig, rng, count, draw=Rig.draw_poses):
        requested.append((rng.bit_generator.state, count, draw(rig, rng, count)))
        return requested[-1][2]

    monkeypatch.setattr(Rig, "draw_poses", noted)
    scene = rig_scene(rig, seed=3)
    sheets = [
        p for p in scene.parts if isinstance(p, Surface) and p.texture is not None
    ]
    # What `raxel render` draws them from, once: to draw them again takes long.
    ((begins, count, poses),) = requested
    assert begins == np.random.default_rng([3, POSES]).bit_generator.state
    assert count == rig.count + rig.evaluate
    assert len(sheets) == count
    corner, size = rig.extent
    for sheet, T in zip(sheets, poses, strict=True):
        ends = transform(T, [[*corner, 0], [*(corner + size), 0]])
        assert np.allclose(sheet.points[[0, 1], [0, 1]], ends)


def test_set_scene_uses_truth_or_calibrates(tmp_path):
    drawn = write_drawn_set(tmp_path / "set")
    scene = set_scene(load_set(tmp_path / "set"))
    sheets = [
        p for p in scene.parts if isinstance(p, Surface) and p.texture is not None
    ]
    assert len(sheets) == len(drawn)
    # The first board stands upright at 9.5 pitches of 20 mm.
    assert sheets[0].points[..., 2] == pytest.approx(190, rel=0.02)
    assert "6 of 6 boards; camera by Zhang's method" in scene.note
    truth = tmp_path / "set" / "truth"
    truth.mkdir()
    PINHOLE.save(truth / "camera.npz")
    T = pose(np.eye(3), [0, 0, 500])
    named = {f"view{k}.png": T.tolist() for k in range(len(drawn))}
    (truth / "poses.json").write_text(json.dumps({"T_camera_target": named}))
    text = (tmp_path / "set" / "set.yaml").read_text()
    (tmp_path / "set" / "set.yaml").write_text(text + "truth: truth/\n")
    scene = set_scene(load_set(tmp_path / "set"))
    assert "true poses" in scene.note
    named.popitem()
    (truth / "poses.json").write_text(json.dumps({"T_camera_target": named}))
    with pytest.raises(InputError, match=r"poses\.json: T_camera_target: "):
        set_scene(load_set(tmp_path / "set"))


def test_known_boards_skip_detection(tmp_path, monkeypatch):
    drawn = write_drawn_set(tmp_path / "set")
    image_set = load_set(tmp_path / "set")
    boards = detect_boards(image_set)
    for board in boards:
        board.detection.corners[[0, 20]] = np.nan
    monkeypatch.setattr("raxel.show.cameras.detect_boards", None)
    scene = set_scene(image_set, boards=boards)
    assert (
        f"{len(drawn)} of {len(drawn)} boards; camera by Zhang's method" in scene.note
    )
    scene = set_scene(image_set, PINHOLE, boards=boards[:2])
    assert f"2 of {len(drawn)} boards; poses fitted to the camera given" in scene.note


@draws
@pytest.mark.parametrize("name", ["a.png", "b.html"])
def test_show_writes_format_of_suffix(tmp_path, capsys, name):
    PINHOLE.save(tmp_path / "camera.npz")
    out = tmp_path / name
    assert main(["show", str(tmp_path / "camera.npz"), "--out", str(out)]) == 0
    head = out.read_bytes()[:15]
    assert head.startswith(b"\x89PNG" if name == "a.png" else b"<!doctype html>")
    assert "camera: perspective" in capsys.readouterr().out


@draws
@pytest.mark.parametrize("display", ["", ":0"])
def test_show_without_file_opens_page(tmp_path, capsys, monkeypatch, display):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    PINHOLE.save(tmp_path / "camera.npz")
    assert main(["show", str(tmp_path / "camera.npz")]) == 0
    page = Path(capsys.readouterr().out.splitlines()[-1])
    assert page.is_file()
    assert opened == ([page.as_uri()] if display else [])


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["nowhere.npz"], "nowhere.npz"),
        (["nothing.txt"], "nothing.txt: no such file; give a rig"),
        (
            ["x.yaml", "--out", "a.svg"],
            "a.svg: found ending '.svg'; give .html or .png",
        ),
        (["x.yaml", "--camera", "c.npz"], "--camera: found with x.yaml"),
        (["x.npz", "--corners", "c.json"], "--corners: found with x.npz"),
        (["x.yaml", "--out", "no/folder/a.png"], "no folder"),
    ],
)
def test_show_errors_have_one_line(monkeypatch, capsys, arguments, lines):
    monkeypatch.setattr("raxel.cli.images.packages_missing", str)
    assert main(["show", *arguments]) == 2
    complaint = capsys.readouterr().err
    assert lines in complaint
    assert complaint.count("\n") == 1


def test_missing_packages_are_reported_with_command(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(rendering.sys, "prefix", str(tmp_path))
    monkeypatch.setattr(rendering, "PROBE", "import os; os.kill(os.getpid(), 11)")
    assert "apt-get install libegl1 libgl1 libxrender1" in fresh()
    monkeypatch.setattr(rendering, "PROBE", "import time; time.sleep(60)")
    monkeypatch.setattr(rendering, "PROBE_S", 0.2)
    assert "apt-get install libegl1 libgl1 libxrender1" in fresh()
    monkeypatch.setattr(rendering, "PACKAGES", ("pyvista", "no_such_package"))
    missing = fresh()
    assert missing == (
        "3-D scenes require no_such_package (not installed); run: "
        "pip install raxel[show]"
    )
    PINHOLE.save(tmp_path / "camera.npz")
    assert main(["show", str(tmp_path / "camera.npz")]) == 2
    assert capsys.readouterr().err == f"raxel: {missing}\n"


def fresh():
    """What is missing, found out anew."""
    return rendering.rendering_missing.__wrapped__()


def test_spread_pixels_are_centred():
    camera = load_rig(RIGS[0]).camera
    pixels = spread_pixels(camera, (8, 6)).reshape(6, 8, 2)
    size = np.array([camera.width, camera.height])
    np.testing.assert_allclose(pixels.mean(axis=(0, 1)), (size - 1) / 2)
    # The image reaches from -1/2 on; the first cell's middle is half a cell from there.
    np.testing.assert_allclose(pixels[0, 0], size / [8, 6] / 2 - 0.5)


def test_texel_samples_its_centre():
    class Ramp:
        """As bright as its place is far right and, in another channel, far down."""

        def radiance(self, uv, cosine):
            share = (uv - [10.0, 20.0]) / [8.0, 4.0]
            return np.column_stack([share, 0 * cosine]) ** 2.2

    shown = surface_texture(Ramp(), np.array([10.0, 20.0]), np.array([8.0, 4.0]), 1.0)
    assert shown.shape == (4, 8, 3)
    np.testing.assert_array_equal(
        shown[0, :, 0], np.round(255 * (np.arange(8) + 0.5) / 8)
    )
    np.testing.assert_array_equal(
        shown[:, 0, 1], np.round(255 * (np.arange(4) + 0.5) / 4)
    )
