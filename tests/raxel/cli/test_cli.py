"""The command line from end to end on drawn boards."""

import io
import json
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest

import raxel
from raxel import cli
from raxel.cameras import GeneralCamera, PerspectiveCamera, load_camera
from raxel.cli import main
from raxel.cli.commands import PROGRAM
from raxel.cli.models import STAGES
from raxel.cli.terminal import Progress, Terminal
from raxel.multiview.views import perspective_view, resample, source_pixels
from tests.image_sets import (
    COLUMNS,
    FOCAL,
    HEIGHT,
    ROWS,
    TILTS_DEG,
    WIDTH,
    boards,
    description,
    write_description,
    write_drawn_set,
)

CORNERS = COLUMNS * ROWS


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A set of six boards, the last for evaluation."""
    folder = tmp_path_factory.mktemp("drawn") / "set"
    write_drawn_set(folder)
    views = [{"image": f"view{i}.png"} for i in range(6)]
    views[5]["use"] = "evaluate"
    write_description(folder, description(6, views=views))
    return folder


@pytest.fixture(scope="module")
def corners_file(drawn, tmp_path_factory):
    path = tmp_path_factory.mktemp("corners") / "corners.json"
    assert main(["corners", str(drawn), "--json", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def calibrated(drawn, corners_file, tmp_path_factory):
    """model -> (path of the camera, its JSON result)"""
    folder = tmp_path_factory.mktemp("calibrated")
    results = {}
    for model in ("zhang", "generic"):
        camera, result = folder / f"{model}.npz", folder / f"{model}.json"
        status = main(
            ["calibrate", str(drawn), "--model", model, "--out", str(camera)]
            + ["--json", str(result), "--corners", str(corners_file)]
        )
        assert status == 0
        results[model] = camera, json.loads(result.read_text())
    return results


def test_corners_file_lists_images_and_corners(corners_file):
    content = json.loads(corners_file.read_text())
    assert [entry["file"] for entry in content["images"]] == [
        f"view{i}.png" for i in range(6)
    ]
    for entry, board in zip(content["images"], boards(), strict=True):
        assert entry["found"] is True
        assert (entry["columns"], entry["rows"]) == (COLUMNS, ROWS)
        assert entry["milliseconds"] > 0
        corners = np.array(entry["corners"])
        # A board of odd by odd corners is point-symmetric.
        error = min(
            np.abs(order - board.corners()).max() for order in (corners, corners[::-1])
        )
        assert error < 0.1


def test_corners_lists_rejected_image_with_reason(tmp_path):
    write_drawn_set(tmp_path / "set")
    blank = np.full((HEIGHT, WIDTH), 128, np.uint8)
    cv2.imwrite(str(tmp_path / "set" / "view2.png"), blank)
    path = tmp_path / "corners.json"
    assert main(["corners", str(tmp_path / "set"), "--json", str(path)]) == 0
    images = json.loads(path.read_text())["images"]
    assert [entry["found"] for entry in images] == [True, True, False, True, True, True]
    assert images[2]["corners"] == []
    assert "7 x 5" in images[2]["reason"]
    camera = tmp_path / "camera.npz"
    result = tmp_path / "result.json"
    arguments = ["calibrate", str(tmp_path / "set"), "--corners", str(path)]
    arguments += ["--model", "zhang", "--out", str(camera), "--json", str(result)]
    assert main(arguments) == 0
    left_out = json.loads(result.read_text())["left_out"]
    assert [entry["file"] for entry in left_out] == ["view2.png"]


def test_corners_start_at_first_clicked_corner(tmp_path):
    (board,) = write_drawn_set(tmp_path / "set", tilts=((0, 0),))
    last, first = CORNERS - 1, 0
    outer = [last, last - COLUMNS + 1, first, COLUMNS - 1]
    clicks = np.rint(board.corners()[outer]).tolist()
    views = [{"image": "view0.png", "outer_corners": clicks}]
    write_description(tmp_path / "set", description(1, views=views))
    path = tmp_path / "corners.json"
    assert main(["corners", str(tmp_path / "set"), "--json", str(path)]) == 0
    (entry,) = json.loads(path.read_text())["images"]
    assert np.abs(np.array(entry["corners"]) - board.corners()[::-1]).max() < 0.1


def test_calibrate_zhang_recovers_rendered_lens(calibrated):
    path, result = calibrated["zhang"]
    camera = load_camera(path)
    assert isinstance(camera, PerspectiveCamera)
    # 0.04 px of corner error on five boards of 320 x 240 px.
    assert camera.K[0, 0] == pytest.approx(FOCAL, rel=0.01)
    assert camera.K[0, 2] == pytest.approx((WIDTH - 1) / 2, abs=2)
    assert result["model"] == "zhang"
    assert result["unit"] == "mm"
    assert result["rms_px"] < 0.1
    assert len(result["images"]) == 5, "the view for evaluation is left alone"
    assert np.allclose(result["camera"]["K"], camera.K)


def test_calibrate_generic_gives_rays_to_covered_pixels(calibrated):
    path, result = calibrated["generic"]
    camera = load_camera(path)
    assert isinstance(camera, GeneralCamera)
    assert camera.units == "mm"
    assert camera.share_with_ray == pytest.approx(result["share_of_pixels_with_ray"])
    assert result["rms_px"] < 0.1
    assert {"view0.png", "view4.png"} <= set(result["used"])


def test_evaluate_scores_marked_views_only(calibrated, drawn, corners_file, tmp_path):
    for model in ("zhang", "generic"):
        path = tmp_path / f"{model}.json"
        arguments = ["evaluate", str(calibrated[model][0]), str(drawn)]
        arguments += ["--json", str(path), "--corners", str(corners_file)]
        assert main(arguments) == 0
        result = json.loads(path.read_text())
        assert result["views_scored"] == "marked evaluate"
        (image,) = result["images"]
        assert image["file"] == "view5.png"
        assert image["n_corners"] == CORNERS
        assert image["rms_px"] < 0.15
        assert result["rms_px"] == pytest.approx(image["rms_px"])
        assert result["mean_deg"] < 0.03
        share = 1 - image["n_without_ray"] / CORNERS
        assert result["share_with_ray"] == pytest.approx(share)


def test_evaluate_without_marked_views_scores_all(
    calibrated, corners_file, tmp_path, capsys
):
    write_drawn_set(tmp_path / "set")
    path = tmp_path / "result.json"
    arguments = ["evaluate", str(calibrated["zhang"][0]), str(tmp_path / "set")]
    arguments += ["--corners", str(corners_file), "--json", str(path)]
    assert main(arguments) == 0
    result = json.loads(path.read_text())
    assert len(result["images"]) == 6
    assert result["views_scored"] == "all: no view is marked evaluate"
    assert "no view is marked evaluate: all 6 are scored" in capsys.readouterr().out


def test_calibrate_auto_selects_model_by_held_out_error(
    drawn, corners_file, tmp_path, capsys
):
    camera, path = tmp_path / "camera.npz", tmp_path / "result.json"
    arguments = ["calibrate", str(drawn), "--corners", str(corners_file), "-v"]
    assert main([*arguments, "--out", str(camera), "--json", str(path)]) == 0
    result = json.loads(path.read_text())
    printed = capsys.readouterr().out
    validation = result["cross_validation"]
    assert set(validation) >= set(STAGES[0][0])
    for model in validation:
        assert f"{model}, held-out boards: mean angle" in printed
    errors = {m: v["counted_rms_px"] for m, v in validation.items()}
    assert errors[result["model"]] <= 1.02 * min(errors.values())
    assert "held-out points" in result["chosen_because"]
    assert f"model: {result['model']}: {result['chosen_because']}\n" in printed
    # All are scored on corners that all have rays for.
    assert {v["common"]["share_with_ray"] for v in validation.values()} == {1.0}


@pytest.mark.parametrize("model", ["zhang", "generic"])
def test_undistort_straightens_board_rows(calibrated, drawn, tmp_path, capsys, model):
    arguments = ["undistort", str(calibrated[model][0]), str(drawn)]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["undistorted.json", *(f"view{i}.png" for i in range(6))]
    straight = cv2.imread(str(tmp_path / "out" / "view0.png"), cv2.IMREAD_UNCHANGED)
    assert straight.shape == (HEIGHT, WIDTH)
    printed = capsys.readouterr().out
    black = 1 - int(re.search(r"camera sees (\d+) % of their pixels", printed)[1]) / 100
    # The board has black squares, the paper around it none.
    assert black <= np.mean(straight == 0) + 0.01
    assert ("the rest is black" in printed) == (black > 0.5)
    camera = load_camera(calibrated[model][0])
    bent = next(boards()).corners()
    moved = corners_in_view(camera, bent)
    seen = np.isfinite(moved[:, 0])
    assert seen.mean() > 0.8
    assert unstraightness(moved) < 0.1 * unstraightness(bent)
    refined = cv2.cornerSubPix(
        straight,
        np.array(moved[seen, None], np.float32, order="C"),
        (4, 4),
        (-1, -1),
        (cv2.TERM_CRITERIA_COUNT, 50, 0),
    )
    # The image has its corners where the rays predict, except at the black border.
    distances = np.linalg.norm(refined[:, 0] - moved[seen], axis=1)
    assert np.median(distances) < 0.1


def corners_in_view(camera, corners):
    """Where the perspective view should show what the camera saw at `corners`."""
    view = perspective_view(camera)
    ahead = camera.rays(corners).directions @ view.R_camera_view @ view.K.T
    return ahead[:, :2] / ahead[:, 2:]


def unstraightness(corners):
    """The largest distance of a corner from the best line through its row."""
    worst = 0.0
    for row in corners.reshape(ROWS, COLUMNS, 2):
        row = row[np.isfinite(row[:, 0])]
        if len(row) > 2:
            off = np.linalg.svd(row - row.mean(axis=0))[2][1]
            worst = max(worst, np.abs((row - row.mean(axis=0)) @ off).max())
    return worst


def test_perspective_view_of_general_camera_is_upright():
    K = np.array([[FOCAL, 0, 159.5], [0, FOCAL, 119.5], [0, 0, 1]])
    table = GeneralCamera.from_camera(PerspectiveCamera(K, [-0.3], WIDTH, HEIGHT))
    view = perspective_view(table)
    assert np.allclose(view.R_camera_view, np.eye(3), atol=0.02)
    assert np.linalg.det(view.R_camera_view) == pytest.approx(1)
    assert view.K[0, 0] <= FOCAL
    image = np.zeros((HEIGHT, WIDTH, 3), np.uint16)
    image[:, WIDTH // 2 :, 2] = 60000
    seen = resample(image, source_pixels(table, view))
    assert seen.dtype == np.uint16
    assert seen[HEIGHT // 2, WIDTH // 2 - 20].tolist() == [0, 0, 0]
    assert seen[HEIGHT // 2, WIDTH // 2 + 20].tolist() == [0, 0, 60000]


def test_check_summarises_image_set(drawn, capsys):
    assert main(["check", str(drawn)]) == 0
    printed = capsys.readouterr().out
    for text in (
        "chessboard, 7 x 5 interior corners, pitch 20.0 mm",
        "6 of 8 bit, 320 x 240 px",
        "5 to calibrate, 1 to evaluate",
    ):
        assert text in printed


def test_cut_boards_and_metres_give_a_warning(tmp_path, capsys):
    write_drawn_set(tmp_path, TILTS_DEG[:3])
    for index in range(3):
        path = str(tmp_path / f"view{index}.png")
        cv2.imwrite(path, cv2.imread(path)[:, 140:])
    target = {"kind": "chessboard", "columns": 7, "rows": 5, "pitch_mm": 0.02}
    size = [WIDTH - 140, HEIGHT]
    write_description(tmp_path, description(3, resolution=size, target=target))
    assert main(["corners", str(tmp_path)]) == 2
    printed = capsys.readouterr().out.splitlines()
    assert printed[-2:] == [
        "warning: target.pitch_mm: 0.02 mm is below 1 mm (metres?); give the side of a "
        "square in mm",
        "warning: 3 of 3 images show a board that the image's edge cuts (such as "
        "view0.png); use a ChArUco board, of which a part is enough",
    ]
    assert main(["check", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == printed[-2:]


def test_help_does_not_import_numpy():
    program = (
        "import sys; from raxel.cli import main; status = main(['--help']);"
        "sys.exit(status or any(m in sys.modules for m in ('numpy', 'cv2', 'yaml')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for command in ("corners", "calibrate", "evaluate", "undistort", "check"):
        assert command in done.stdout


def test_module_docstring_names_all_commands():
    first = cli.__doc__.partition("explains")[0]
    assert set(re.findall(r"`([a-z]+)`", first)) == {"raxel", *PROGRAM.commands}


@pytest.mark.parametrize("command", PROGRAM.commands)
def test_help_explains_every_parameter_within_80_columns(command, capsys):
    assert main([command, "--help"]) == 0
    text = capsys.readouterr().out
    assert max(map(len, text.splitlines())) <= 80
    flat = " ".join(text.split())
    for param in PROGRAM.commands[command].params:
        assert param.help.endswith((".", "]"))
        assert " ".join(param.help.split()) in flat.replace("- ", "-")
    example, *words = text.partition("Example: raxel ")[2].split()
    assert PROGRAM.commands[example].make_context(example, words).params


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ([], "raxel: missing command; see raxel --help"),
        (
            ["chek", "x"],
            "raxel: no such command 'chek' (did you mean check?); see raxel --help",
        ),
        (
            ["corners"],
            "raxel corners: missing argument 'SET'; see raxel corners --help",
        ),
        (
            ["corners", "x", "--jsn", "y"],
            "raxel corners: no such option '--jsn' (did you mean --json?); see raxel "
            "corners --help",
        ),
        (
            ["corners", "x", "--json"],
            "raxel corners: option '--json' requires an argument; see raxel corners "
            "--help",
        ),
    ],
)
def test_usage_error_is_one_line_with_a_suggestion(words, line, capsys):
    assert main(words) == 2
    assert capsys.readouterr().err == f"{line}\n"


def test_version_is_printed(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"raxel {raxel.__version__}\n"


class Stream(io.StringIO):
    """A stream that may be a terminal."""

    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal


@pytest.mark.parametrize(("terminal", "shown"), [(True, "one\n"), (False, "")])
def test_progress_lines_are_held_back_unless_on_a_terminal(terminal, shown):
    stream = Stream(terminal)
    progress = Progress(Terminal(stream), clock=lambda: 0.0)
    progress.say("one")
    assert stream.getvalue() == shown
    progress.release()
    assert stream.getvalue() == "one\n"


@pytest.mark.parametrize("no_colour", ["", "1"])
def test_progress_bar_shows_count_and_name_and_vanishes(monkeypatch, no_colour):
    for name, value in (("TERM", "xterm"), ("COLUMNS", "80"), ("NO_COLOR", no_colour)):
        monkeypatch.setenv(name, value)
    stream = Stream(terminal=True)
    progress = Progress(Terminal(stream))
    progress.say("1/3 a[red].png\x1b[2J")
    shown = stream.getvalue()
    assert all(part in shown for part in ("1/3", "left", "a[red].png\\x1b[2J"))
    assert ("\x1b[3" in shown) == (not no_colour)
    progress.say("fitting")
    assert stream.getvalue().endswith("\x1b[2Kfitting\n")


def test_help_is_coloured_on_a_terminal_only(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    texts = []
    for terminal in (True, False):
        monkeypatch.setattr(sys, "stdout", Stream(terminal))
        assert main(["--help"]) == 0
        texts.append(sys.stdout.getvalue())
    coloured, plain = texts
    assert "\x1b[36mcheck\x1b[0m" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain
