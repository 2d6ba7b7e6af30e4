"""Active grids from the command line: rendered, decoded, calibrated, scored."""

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from raxel.cameras import load_camera
from raxel.cli import main
from raxel.cli.commands import PROGRAM
from raxel.evaluation.benchmark import score_camera
from raxel.multiview.views import plane_scale
from raxel.report import check_report
from raxel.sets import load_set, pattern_image
from tests.active_grids import drawn
from tests.image_sets import write_drawn_set
from tests.raxel.cli.test_cli_active_grid import error_line, recorded

ROOT = Path(__file__).parents[3]
RIG = ROOT / "data/rigs/active-grid-demo.yaml"
README = ROOT / "README.md"
FITTED = 3


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """The demonstration rig with half the pixels and more poses; and the folder of its
    points."""
    folder = tmp_path_factory.mktemp("grids")
    rig = yaml.safe_load(RIG.read_text("utf-8"))
    camera, target, poses = rig["camera"], rig["target"], rig["poses"]
    camera["K"]["value"] = [[310, 0, 160.5], [0, 310, 118.25], [0, 0, 1]]
    camera["width"]["value"], camera["height"]["value"] = 320, 240
    rig["optics"]["exit_pupil"]["value"] = 310
    target["gray_bits"]["value"] = [4, 4]
    target["phase_periods"]["value"] = [16, 16]
    poses["count"]["value"], poses["evaluate"]["value"] = FITTED, 1
    poses["tilt"]["value"] = [20, 25]  # few poses tell a focal length only if tilted
    (folder / "rig.yaml").write_text(yaml.safe_dump(rig), "utf-8")
    done = folder / "set", folder / "points"
    order = ["render", folder / "rig.yaml", "--out", done[0], "--seed", 1]
    assert main([*map(str, order)]) == 0
    assert main(["decode", str(done[0]), "--out", str(done[1])]) == 0
    return done


def calibrated(image_set, out, *options):
    """The JSON of a calibration whose camera goes to out / camera.npz."""
    files = ["-v", "--out", out / "camera.npz", "--json", out / "result.json"]
    assert main([*map(str, ["calibrate", image_set, *files, *options])]) == 0
    return json.loads((out / "result.json").read_text())


# rms over all pixels of the formula, and over those that the table has.
@pytest.mark.parametrize(("model", "most_deg"), [("zhang", 6e-3), ("generic", 1e-2)])
def test_calibrate_recovers_rendered_camera(
    rendered, tmp_path, capsys, model, most_deg
):
    image_set, points = rendered
    options = "--points", points, "--model", model
    result = calibrated(image_set, tmp_path, *options)
    printed = capsys.readouterr().out
    assert f"\n{model}, fitted grids: mean angle" in printed
    assert result["warnings"] == []
    assert [grid["file"] for grid in result["grids"]] == [f"pose-00{k}" for k in "012"]
    for image, grid in zip(result["images"], result["grids"], strict=True):
        assert image["n_corners"] == grid["points"]
        assert 900 < grid["points"] < 1600
        # Of the monitor, what is 8 px or more from its rim: the blur reaches so far.
        assert grid["pixels"] > 0.38 * 320 * 240
    # Points are sure to about 0.03 px.
    assert result["rms_px"] < 0.05
    scores = tmp_path / "scores.json"
    camera = load_camera(tmp_path / "camera.npz")
    assert score_camera(load_set(image_set), camera)["rms_deg"] < most_deg
    order = ["evaluate", tmp_path / "camera.npz", image_set, "--points", points]
    assert main([*map(str, order), "--json", str(scores)]) == 0
    evaluated = json.loads(scores.read_text())
    assert [image["file"] for image in evaluated["images"]] == ["pose-003"]
    assert evaluated["rms_px"] < 0.06
    assert evaluated["misfit"]["fits"]


def test_calibration_without_points_decodes_images(rendered, tmp_path):
    image_set, points = rendered
    options = "--model", "zhang"
    then = calibrated(image_set, tmp_path, *options, "--points", points)
    now = calibrated(image_set, tmp_path, *options, "--report", tmp_path / "report")
    # What the response may do is small beside sigma, so nothing is problem of it.
    assert now.pop("warnings") == then.pop("warnings") == []
    # Sums of the last digits may depend on the memory layout; where the fit ends
    # depends on them by up to 4e-8 of a number.
    assert numbers(now) == pytest.approx(numbers(then), rel=1e-6, abs=1e-9)
    assert worded(now) == worded(then)
    page = (tmp_path / "report" / "index.html").read_text("utf-8")
    assert "fitted grids" in page
    assert "<th>Points</th>" in page
    assert len(list((tmp_path / "report").glob("view-*.jpg"))) == FITTED
    check_report(tmp_path / "report", load_set(image_set))  # the next one may follow


def leaves(result, path=()):
    """Yields (path, value) of all that a JSON result holds."""
    parts = result.items() if isinstance(result, dict) else enumerate(result)
    for name, part in parts:
        if isinstance(part, dict | list):
            yield from leaves(part, (*path, name))
        else:
            yield (*path, name), part


def numbers(result):
    return {path: x for path, x in leaves(result) if isinstance(x, float)}


def worded(result):
    return {path: x for path, x in leaves(result) if not isinstance(x, float)}


@pytest.fixture
def copied(rendered, tmp_path):
    """The rendered set and its points, to be changed."""
    return [
        shutil.copytree(folder, tmp_path / folder.name, dirs_exist_ok=True)
        for folder in rendered
    ]


def test_undecoded_views_are_excluded_and_reported(copied, tmp_path, capsys):
    image_set, points = copied
    (points / "pose-001.npz").unlink()
    result = calibrated(image_set, tmp_path, "--points", points, "--model", "zhang")
    assert [entry["file"] for entry in result["left_out"]] == ["pose-001"]
    printed = capsys.readouterr().out
    assert f"warning: pose-001: excluded: {points} has no file for it" in printed
    with np.load(points / "pose-002.npz") as found:
        arrays = {**found, "mask": np.zeros((240, 320), bool)}
    np.savez(points / "pose-002.npz", **arrays)
    out = tmp_path / "other.npz"
    order = ["calibrate", image_set, "--points", points, "--out", out]
    message = error_line(capsys, *order)
    assert (
        "grid decoded in 1 of 3 views, --model auto requires 3 (pose-001: " in message
    )
    assert "check exposure and order of the images" in message
    assert not out.exists()


def test_lengths_are_in_pitches_without_monitor_mm(copied, tmp_path, capsys):
    image_set, points = copied
    file = image_set / "set.yaml"
    data = yaml.safe_load(file.read_text("utf-8"))
    data["target"]["monitor_mm"] = None
    file.write_text(yaml.safe_dump(data), "utf-8")
    order = ["calibrate", image_set, "--points", points, "--out", tmp_path / "a.npz"]
    assert "field 'points_px': missing" in error_line(capsys, *order)
    for file in points.glob("*.npz"):
        with np.load(file) as found:
            pitch = 304 / 1024
            in_px = {f"{k}_px": found[f"{k}_mm"] / pitch for k in ("points", "sigma")}
        np.savez(file, **in_px)
    result = calibrated(image_set, tmp_path, "--model", "zhang", "--points", points)
    assert result["unit"] == "pitch"
    assert any("lengths are in pitches of the mon" in w for w in result["warnings"])
    assert main(["check", str(image_set)]) == 0
    assert "size in mm unknown (unit of length: its " in capsys.readouterr().out


def test_check_warns_of_oblong_pixels(copied, capsys):
    image_set, _ = copied
    file = image_set / "set.yaml"
    data = yaml.safe_load(file.read_text("utf-8"))
    data["target"]["monitor_mm"] = [228, 304]
    data["views"] = data["views"][:1]
    file.write_text(yaml.safe_dump(data), "utf-8")
    assert main(["check", str(image_set)]) == 0
    message = (
        "the monitor's pixels would be 0.223 x 0.396 mm, not square; check monitor_px"
    )
    assert f"228 x 304 mm; {message}" in capsys.readouterr().out
    out = image_set.parent / "doubted"
    assert main(["decode", str(image_set), "--out", str(out)]) == 0
    assert f"warning: {message}" in capsys.readouterr().out


def test_points_of_another_set_are_rejected(copied, tmp_path, capsys):
    image_set, points = copied
    order = "calibrate", image_set, "--out", tmp_path / "camera.npz", "--points"
    assert "no such folder; give one written" in error_line(
        capsys, *order, tmp_path / "no"
    )
    message = error_line(
        capsys, *order[:2], "--out", points / "pose-000.npz", *order[4:], points
    )
    assert "is an input of this command" in message
    order = *order, points
    (points / "decoded.json").write_text('{"set": "another"}')
    assert "set: found 'another'" in error_line(capsys, *order)
    (points / "decoded.json").unlink()
    with np.load(points / "pose-000.npz") as found:
        arrays = dict(found)
    for name, wrong, problem in (
        ("mask", np.ones((240, 320)), "mask: found float64; give truth values"),
        (
            "sigma_mm",
            np.ones((240, 320)),
            "sigma_mm: found shape (240, 320); give (240, 320",
        ),
    ):
        np.savez(points / "pose-000.npz", **{**arrays, name: wrong})
        assert f"pose-000.npz: {problem}" in error_line(capsys, *order)
    assert not (tmp_path / "camera.npz").exists()


def test_options_for_other_target_are_rejected(rendered, tmp_path, capsys):
    order = "calibrate", rendered[0], "--out", tmp_path / "camera.npz"
    for option in (("--corners", "corners.json"), ("--detector", "opencv")):
        message = error_line(capsys, *order, *option)
        assert f"{option[0]}: not for an active grid (" in message
        assert message.endswith("; leave it out, or use --points")
    write_drawn_set(tmp_path / "boards")
    order = "calibrate", tmp_path / "boards", "--out", tmp_path / "camera.npz"
    message = error_line(capsys, *order, "--points", rendered[1])
    assert "--points: not for a chessboard (" in message
    assert message.endswith("; leave it out, or use --corners")
    message = error_line(capsys, "corners", rendered[0])
    assert "use raxel decode for active grids" in message


def test_readme_commands_are_valid_and_consistent():
    section = README.read_text("utf-8").split("## A monitor as target\n")[1]
    orders = re.findall(r"(?m)^\$ raxel (.+)$", section.split("\n## ")[0])
    assert [order.split()[0] for order in orders] == [
        "patterns", "check", "decode", "calibrate", "evaluate", "undistort",
    ]  # fmt: skip
    read = [options(*order.split()) for order in orders]
    _, _, decoded, calibrated, evaluated, undistorted = read
    assert calibrated["points"] == evaluated["points"] == decoded["out"]
    assert evaluated["camera"] == undistorted["camera"] == calibrated["out"]
    assert {one["set"] for one in read[1:]} == {"my-monitor"}


def options(command, *words):
    """The options of a command line."""
    return PROGRAM.commands[command].make_context(command, list(words)).params


def test_undistort_maps_images_onto_grid_plane(tmp_path, capsys):
    scene = drawn(vignetting=0.0)
    folder = recorded(tmp_path / "set", scene)
    points, out = tmp_path / "points", tmp_path / "plane"
    assert main(["decode", str(folder), "--out", str(points)]) == 0
    order = ["undistort", points / "pose.npz", folder, "--out", out]
    assert main([*map(str, order)]) == 0
    assert "the grid's points cover" in capsys.readouterr().out
    with np.load(points / "pose.npz") as found:
        _, mm_per_px = plane_scale(found["points_mm"], found["mask"])
    finest = "x", 2, False
    (code,) = (p for p in scene.patterns if (p.axis, p.bit, p.inverse) == finest)
    shown = cv2.imread(str(out / code.image), -1)
    places = (np.arange(shown.shape[1]) + 0.5) * mm_per_px / 1.5
    sent = pattern_image(code, scene.grid.monitor_px)[0, places.astype(int)]
    # Two pixels from the edges of stripes and the rim; every row is the same.
    apart = np.abs(places / 25 - np.rint(places / 25)) * 25 * 1.5 > 2 * mm_per_px
    rows, columns = slice(10, -10), apart & (places > 15) & (places < 180)
    assert columns.sum() > 50
    for value, grey in ((255, 200), (0, 30)):
        stripes = shown[rows, columns & (sent == value)].astype(int)
        assert np.abs(stripes - grey).max() <= 2


def test_undistort_rejects_unsuitable_points(tmp_path, capsys):
    folder = recorded(tmp_path / "set", drawn())
    path = tmp_path / "points.npz"
    order = "undistort", path, folder, "--out", tmp_path / "out"
    for points, message in (
        (np.zeros((9, 9, 2)), "points_mm: found shape (9, 9, 2); give (120, 160, 2)"),
        (np.full((120, 160, 2), 2e9), "points_mm: found 2e+09, more than any monitor"),
        (np.zeros((120, 160, 2)), "no two neighbouring pixels see different positions"),
        (-np.indices((120, 160)).T.swapaxes(0, 1), "all points are left of"),
    ):
        np.savez(path, points_mm=points)
        line = error_line(capsys, *order)
        assert f"points.npz: {message}" in line.replace("location: ", "")
    assert not (tmp_path / "out").exists()
