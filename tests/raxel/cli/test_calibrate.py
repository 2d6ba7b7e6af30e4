"""`raxel calibrate`: the printed and written results and warnings."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from raxel.calibration.views.correspondence import BoardView
from raxel.cameras import (
    KannalaBrandtCamera,
    MovingPupilCamera,
    PerspectiveCamera,
    UnifiedSphereCamera,
    load_camera,
)
from raxel.cli import calibrate as calibrate_command
from raxel.cli import main
from raxel.evaluation.cross_validation import Evaluation
from raxel.evaluation.diagnoses import CORRECT_FIRST, STRICT, score_text
from raxel.evaluation.json_fields import camera_fields
from tests.image_sets import TILTS_DEG, write_drawn_set
from tests.made_sets import (
    BOARD,
    CENTRE,
    COLUMNS,
    FISHEYE,
    HEIGHT,
    PINHOLE,
    ROWS,
    WIDTH,
    K,
    WavyCamera,
    boards_of,
    of_more_than_the_rim,
    write_made_set,
)


@pytest.fixture
def calibrate(tmp_path, capsys):
    """(boards, *options) -> (what was printed, the JSON file)"""
    runs = []

    def run(boards, *options):
        folder, corners = write_made_set(tmp_path / f"set{len(runs)}", boards)
        runs.append(folder)
        out, result = tmp_path / "camera.npz", tmp_path / "result.json"
        arguments = ["calibrate", str(folder), "--corners", str(corners), "-v"]
        arguments += ["--out", str(out), "--json", str(result), *map(str, options)]
        assert main(arguments) == 0, capsys.readouterr().err
        return capsys.readouterr().out, json.loads(result.read_text())

    return run


def test_readme_commands_lead_to_files_of_other_programs(tmp_path, monkeypatch):
    write_drawn_set(tmp_path / "my-images", TILTS_DEG)
    (tmp_path / "my-images/set.yaml").unlink()
    monkeypatch.chdir(tmp_path)
    # Zhang's model is quick.
    monkeypatch.setattr(calibrate_command, "STAGES", [(["zhang"], np.inf)])
    readme = (Path(__file__).parents[3] / "README.md").read_text("utf-8")
    block = readme.split("$ pip install .\n")[1].split("```")[0].replace("9x6", "7x5")
    orders = [line.removeprefix("$ raxel ").split() for line in block.splitlines()]
    assert [order[0] for order in orders] == [
        "board", "calibrate", "undistort", "export", "export", "export",
    ]  # fmt: skip
    assert [main(order) for order in orders] == [0] * len(orders)
    camera = load_camera("my-images-calibration/camera.npz")
    assert max(camera.board_cells.shape) == 64
    assert 0.1 < camera.board_cells.mean() < 1
    stored = cv2.FileStorage("camera.yaml", cv2.FILE_STORAGE_READ)
    assert stored.getNode("camera_matrix").mat() == pytest.approx(camera.K)
    colmap = np.array(
        Path("cameras.txt").read_text().split("\n")[-2].split()[4:], float
    )
    assert colmap[2:4] == pytest.approx(camera.K[:2, 2] + 0.5)
    ros = yaml.safe_load(Path("camera_info.yaml").read_text())
    assert ros["camera_matrix"]["data"] == pytest.approx(camera.K.ravel())


def test_score_text_has_no_nan():
    blank = Evaluation([], np.nan, np.nan, np.nan, np.nan, {})
    assert score_text(blank.totals()) == "no corner could be scored"
    angles = blank._replace(mean_deg=0.25, share_with_ray=0.0)
    assert score_text(angles.totals()) == (
        "mean angle 0.2500 deg, RMS unknown, median unknown, 0.0 % of corners with a "
        "ray"
    )


def all_warnings_in(printed):
    marked = (line for line in printed.splitlines() if line.startswith("warning: "))
    return [line.removeprefix("warning: ") for line in marked]


def warnings_in(printed):
    return of_more_than_the_rim(all_warnings_in(printed))


def test_calibrate_prints_and_writes_intrinsics(calibrate):
    printed, result = calibrate(boards_of(PINHOLE), "--model", "zhang")
    camera = result["camera"]
    assert camera["focal_px"] == pytest.approx([300, 300], rel=0.01)
    assert camera["principal_point_px"] == pytest.approx(CENTRE, abs=3)
    found = re.search(
        r"focal lengths ([\d.]+) and ([\d.]+) px, principal point \(([\d.]+), "
        r"([\d.]+)\) px, radial terms (\S+), (\S+)\n",
        printed,
    )
    numbers = [*camera["focal_px"], *camera["principal_point_px"], *camera["radial"]]
    assert [float(x) for x in found.groups()] == pytest.approx(numbers, abs=0.006)
    sd = [result["terms"][name]["sd"] for name in ("fx", "fy", "cx", "cy")]
    fx, fy, cx, cy = (f"{one:.2g}" for one in sd)
    assert (
        f"standard deviations: focal lengths {fx} and {fy} px, principal point "
        f"({cx}, {cy}) px; {result['sd_over_independent']:.2g} times those of"
    ) in printed
    assert np.all(np.abs(np.array(numbers[:2]) - 300) < 4 * np.array(sd[:2]))
    # The bend pulls in what a straight pinhole of this focal length would not hold.
    straight = 2 * np.degrees(np.arctan(0.5 * WIDTH / 300))
    field = camera["field_of_view_deg"]
    assert straight < field["horizontal"] < 1.1 * straight
    assert f"field of view: {field['horizontal']:.1f} x " in printed
    assert 0.1 < camera["share_of_image_under_boards"] < 1
    (warning,) = all_warnings_in(printed)
    assert result["warnings"] == [warning]
    beyond = result["beyond_boards"]
    percent = 100 * beyond["share_of_image"]
    assert warning.startswith(f"{percent:.0f} % of the image is outside all boards")
    (diagnosis,) = result["diagnoses"]
    assert warning == f"{diagnosis['text']}; {diagnosis['what_to_do']}"
    assert diagnosis["code"] == "extrapolated-area"
    assert diagnosis["percent"] == pytest.approx(percent)
    # A little of the hull of all boards is under none of them.
    free = 1 - camera["share_of_image_under_boards"]
    assert free - 0.1 < beyond["share_of_image"] < free + 0.03
    assert result["misfit"]["fits"] is True
    # 0.05 px each way.
    assert result["misfit"]["scatter_px"] == pytest.approx(0.05 * 2**0.5, rel=0.15)


UNEQUAL = np.array([[300.0, 0, 151], [0, 310, 119], [0, 0, 1]])
THETA = KannalaBrandtCamera([1.1, 0.05], [280, 290], [151, 119], WIDTH, HEIGHT)


@pytest.mark.parametrize(
    "camera",
    [
        PerspectiveCamera(UNEQUAL, [0.1], WIDTH, HEIGHT),
        UnifiedSphereCamera(0.9, UNEQUAL, WIDTH, HEIGHT),
        THETA,
        MovingPupilCamera(THETA, [2.0]),
    ],
    ids=lambda camera: camera.kind,
)
def test_focal_px_is_px_per_radian_near_the_axis(camera):
    turn = 1e-3
    aside = 1e6 * np.tan(turn) * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    far = np.column_stack([aside, np.full(4, 1e6)])
    right, left, below, above = camera.project(far).pixels
    focal = (right - left)[0] / (2 * turn), (below - above)[1] / (2 * turn)
    assert camera_fields(camera, [])["focal_px"] == pytest.approx(focal, rel=1e-5)


def test_radial_terms_are_independent_of_the_scale_of_k():
    """k1 times the px per unit is the focal length: the same lens, written twice."""
    size = [151, 119], WIDTH, HEIGHT
    one = KannalaBrandtCamera([2, 0.06, -0.01], [140, 145], *size)
    other = KannalaBrandtCamera([1, 0.03, -0.005], [280, 290], *size)
    fields = [camera_fields(camera, []) for camera in (one, other)]
    for name in ("focal_px", "radial", "principal_point_px"):
        assert fields[0][name] == pytest.approx(fields[1][name])


def test_excluded_views_and_small_tables_give_warnings(calibrate):
    small = [(b - CENTRE) * 0.25 + CENTRE for b in boards_of(PINHOLE)]
    separate = small[0] - [100, 70]
    printed, result = calibrate([*small, separate, None], "--model", "generic")
    share = 100 * result["camera"]["share_of_image_with_ray"]
    assert share < 20
    warnings = warnings_in(printed)
    assert warnings[0].startswith(
        f"the table has rays for only {share:.0f} % of the image"
    )
    assert warnings[-2] == "7.png: excluded: too dark"
    assert warnings[-1].startswith("6.png: excluded: shares 0 samples with the known")
    assert warnings == of_more_than_the_rim(result["warnings"])
    assert f"rays: for {share:.1f} % of the image, through one centre" in printed
    assert "nan" not in printed
    assert result["one_centre"]["central"]
    assert result["stability"] is None
    assert f"; p = {result['one_centre']['p_value']:.2g} if central)\n" in printed


@pytest.mark.parametrize(
    ("camera", "model", "problem"),
    [
        (FISHEYE, "zhang", "zhang does not fit"),
        (WavyCamera(), "generic", "no central camera fits"),
    ],
)
def test_misfit_gives_a_warning(calibrate, camera, model, problem):
    printed, result = calibrate(boards_of(camera), "--model", model)
    misfit = result["misfit"]
    assert misfit["fits"] is False
    *_, warning = warnings_in(printed)[: 2 if model == "generic" else 1]
    assert warning.startswith(
        f"{problem}: RMS {misfit['rms_px']:.2f} px (corner scatter "
        f"{misfit['scatter_px']:.2g} px, predicted unknown); "
    )
    if model != "generic":
        assert "one_centre" not in result
        return
    found = result["one_centre"]
    # Lines move by 9 mm to and fro; poses and directions can follow a part of that.
    assert 3 < found["at_least"] < 9 < found["at_most"] < 18
    distance = f"{found['distance']:.2g} mm RMS (at least "
    assert warnings_in(printed)[0].startswith(f"rays miss a common point by {distance}")


def test_strict_misfit_has_its_own_status_and_all_results(tmp_path, capsys):
    for camera, status in ((PINHOLE, 0), (FISHEYE, 3)):
        folder, corners = write_made_set(tmp_path / str(status), boards_of(camera))
        names = [str(tmp_path / f"result-{status}.{end}") for end in ("npz", "json")]
        given = ["--corners", str(corners), "--strict", "--json", names[1]]
        calibrate = ["calibrate", str(folder), "--model", "zhang", "--out", names[0]]
        for command in (calibrate, ["evaluate", names[0], str(folder)]):
            assert main([*command, *given]) == status
            found = json.loads(Path(names[1]).read_text())["diagnoses"]
            codes = {one["code"] for one in found} & set(STRICT)
            printed = capsys.readouterr()
            assert ", ".join(codes) in printed.err
            assert "RMS " in printed.out
            assert len(codes) == (status == 3)
            Path(names[1]).unlink()
    # A folder of results is complete, too.
    out = tmp_path / "out"
    options = "--model", "zhang", "--strict", "--corners", str(corners)
    assert main(["calibrate", str(folder), "--out", str(out), *options]) == 3
    assert (out / "set.yaml").is_file()


@pytest.mark.parametrize("names", [("4.png",), ("7.png", "4.png")])
def test_misfit_names_outlier_boards(calibrate, names):
    boards = boards_of(PINHOLE, count=10)
    for k, name in enumerate(names):
        number = int(name[0])
        bent = (0.3 + 0.1 * (k == 0)) * (np.arange(COLUMNS * ROWS) % COLUMNS - 4) ** 2
        boards[number] = boards[number] + bent[:, None]
    printed, result = calibrate(boards, "--model", "zhang")
    assert result["misfit"]["odd_board"] == names[0]
    begin = f"{', '.join(names)}: worse than the other boards: total RMS "
    assert any(each.startswith(begin) for each in warnings_in(printed))


def test_cause_of_a_misfit_comes_first(calibrate):
    """The area outside the boards is reported, too."""
    printed, result = calibrate(of_two_cameras(1.4), "--model", "zhang")
    found = {each["code"]: each for each in result["diagnoses"]}
    first = found["focal-length-varies"]
    assert next(iter(found.values())) is first
    assert sorted(first["shorter"]) == [f"{k}.png" for k in range(6)]
    assert found["parametric-misfit"]["what_to_do"] == CORRECT_FIRST
    assert "extrapolated-area" in found
    assert warnings_in(printed) == of_more_than_the_rim(result["warnings"])


def of_two_cameras(ratio=1.03):
    longer = K * [[ratio, 1, 1], [1, ratio, 1], [1, 1, 1]]
    other = PerspectiveCamera(longer, [-0.2, 0.05], WIDTH, HEIGHT)
    return [*boards_of(PINHOLE, 1, 6), *boards_of(other, 2, 6)]


def of_a_lens_that_focuses():
    boards = []
    for seed, b in enumerate(0.008 * np.random.default_rng(8).normal(size=14)):
        focused = K * [[1 + b, 1, 1], [1, 1 + b, 1], [1, 1, 1]]
        camera = PerspectiveCamera(focused, [-0.2, 0.05], WIDTH, HEIGHT)
        boards += boards_of(camera, seed, 1)
    return boards


def of_a_board_half_off():
    boards = [*boards_of(PINHOLE, 1, 7), *boards_of(PINHOLE, 2, 7)]
    boards[4] = boards[4] + [2.0, 0.0] * (np.arange(COLUMNS * ROWS)[:, None] % 2)
    return boards


def of_frames_alike():
    boards, rng = boards_of(PINHOLE, 6, 9), np.random.default_rng(5)
    frames = [boards[4] + 0.02 * rng.normal(size=boards[4].shape) for _ in range(30)]
    return [*boards, *frames]


# Fault -> (boards, begin of its one warning, what the result holds of it).
FAULTS = {
    "two cameras": (
        of_two_cameras,
        "focal length varies between images: SD ",
        lambda result: not result["stability"]["same_camera"],
    ),
    "a lens that focuses anew": (
        of_a_lens_that_focuses,
        "focal length varies between images: SD ",
        lambda result: (
            result["stability"]["same_camera"] and not result["stability"]["stable"]
        ),
    ),
    "a misprinted row": (
        lambda: boards_of(PINHOLE, 3, 10, row=0.4),
        "the board's corners are off by up to ",
        lambda result: result["board_corners"]["worst"] // COLUMNS == 2,
    ),
    "half a board off": (
        of_a_board_half_off,
        "4.png: ",
        lambda result: result["misfit"]["odd_board"] == "4.png",
    ),
    "an image twice": (
        lambda: [*boards_of(PINHOLE), *boards_of(PINHOLE)[2:4]],
        "2 of 8 images show the board in the pose of another (such as 6.png and 2.",
        lambda result: result["misfit"]["fits"],
    ),
    "frames alike": (
        of_frames_alike,
        "30 of 39 images show the board in the pose of another (such as 9.png and 4.",
        lambda result: result["misfit"]["fits"],
    ),
    "few boards": (
        lambda: boards_of(PINHOLE)[:5],
        "only 5 boards: ",
        lambda result: result["stability"] is result["board_shape"] is None,
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_board_fault_gives_one_warning(calibrate, fault):
    boards, begin, holds = FAULTS[fault]
    printed, result = calibrate(boards(), "--model", "zhang")
    (warning,) = warnings_in(printed)
    assert warning.startswith(begin)
    assert holds(result)


def test_bent_board_gives_a_warning_and_is_used(calibrate):
    printed, result = calibrate(boards_of(PINHOLE, 3, 12, bend=2.0), "--model", "zhang")
    shape = result["board_shape"]
    used = [name for name in ("bend_x", "twist", "stretch") if shape[name]["used"]]
    assert used == ["bend_x", "twist"]
    assert abs(shape["bend_x"]["value"] - 2.0) < 4 * shape["bend_x"]["sd"] < 0.4
    assert shape["shaped_px"] < shape["flat_px"]
    assert "board shape: over 160 x 120 mm, ends of x " in printed
    (warning,) = warnings_in(printed)
    assert warning.startswith("the board is bent by up to ")
    assert result["rms_px"] < 1.5 * shape["shaped_px"]


def test_evaluate_uses_the_shape_of_the_board(calibrate, tmp_path, capsys):
    boards = boards_of(PINHOLE, 3, 12, bend=2.0, row=0.4)
    _, fitted = calibrate(boards, "--model", "zhang")
    assert fitted["board_corners"]["used"]
    again = boards_of(PINHOLE, 4, 6, bend=2.0, row=0.4)
    folder, corners = write_made_set(tmp_path / "again", again)
    camera, plain = tmp_path / "camera.npz", load_camera(tmp_path / "camera.npz")
    plain.board = None
    plain.save(tmp_path / "plain.npz")

    def scored(camera, *more):
        command = ["evaluate", tmp_path / camera, folder, "--corners", corners, *more]
        command += ["--json", tmp_path / "scores.json"]
        assert main([*map(str, command)]) == 0, capsys.readouterr().err
        return json.loads((tmp_path / "scores.json").read_text())

    flat = scored("plain.npz")
    assert "a bent board does not fit a flat one; " in capsys.readouterr().out
    shaped = scored("camera.npz")
    printed = capsys.readouterr().out
    assert f"made: boards with the shape of {camera}\n" in printed
    assert f"boards as specified: {score_text(flat)}\n" in printed
    assert scored("plain.npz", "--board", tmp_path / "result.json") == shaped | {
        "camera": str(tmp_path / "plain.npz"), "board": str(tmp_path / "result.json"),
    }  # fmt: skip
    assert (flat["board"], shaped["board"]) == ("as stated", str(camera))
    assert flat["rms_px"] == shaped["as_specified"]["rms_px"] > 3 * shaped["rms_px"]
    # Corners are drawn with 0.05 px along each axis; six poses take some of it.
    assert 0.04 < shaped["rms_px"] / np.sqrt(2) < 0.06
    fitted |= {"board_shape": None, "board_corners": None}
    (tmp_path / "flat.json").write_text(json.dumps(fitted))
    as_there = scored("camera.npz", "--board", tmp_path / "flat.json")
    assert (as_there["rms_px"], as_there["board"]) == (flat["rms_px"], "as stated")
    description = (folder / "set.yaml").read_text().replace("20.0", "25.0")
    (folder / "set.yaml").write_text(description)
    capsys.readouterr()
    assert scored("camera.npz")["board"] == "as stated"
    found = f"made: board of the camera not used: {camera}: board_shape: found one from"
    assert found in capsys.readouterr().out


def test_few_bent_boards_are_named_as_a_cause_of_misfit(calibrate):
    printed, _ = calibrate(boards_of(PINHOLE, 4, 5, bend=4.0), "--model", "zhang")
    (warning,) = [one for one in warnings_in(printed) if "not fit" in one]
    assert "check for bent board (untested), " in warning


def test_focal_length_variation_is_estimated(calibrate):
    printed, result = calibrate(of_a_lens_that_focuses(), "--model", "zhang")
    (warning,) = warnings_in(printed)
    sd = result["stability"]["focal_lengths"]["sd"]
    breaths = 0.008 * np.random.default_rng(8).normal(size=14)
    assert sd == pytest.approx(np.std(breaths), rel=0.35)
    assert f"SD {100 * sd:.2g} %, " in warning


def test_misprinted_row_is_located(calibrate, tmp_path):
    printed, result = calibrate(boards_of(PINHOLE, 3, 10, row=0.4), "--model", "zhang")
    found = result["board_corners"]
    assert found["as_stated"] is False
    (warning,) = warnings_in(printed)
    offset = np.linalg.norm(found["offsets"][found["worst"]])
    assert f"off by up to {offset:.2g} +- " in warning
    assert ", row 2)" in warning
    before, after = found["held_out_px"].values()
    assert f"(other half: RMS {after:.3g} px, {before:.3g} px without)" in warning
    assert result["rms_px"] < after < 0.7 * before
    boards = boards_of(PINHOLE, 3, 10)
    printed, result = calibrate(boards, "--model", "zhang")
    assert result["board_corners"]["as_stated"] is True
    views = [BoardView(pixels, BOARD.points(), COLUMNS, ROWS) for pixels in boards]
    plain = calibrate_command.FITS["zhang"](views, (WIDTH, HEIGHT), "mm").camera
    found = load_camera(tmp_path / "camera.npz")
    np.testing.assert_allclose(found.K, plain.K, rtol=1e-6)
    assert found.board is None
    assert warnings_in(printed) == []
    assert "corner positions: no significant deviation from the " in printed
