"""What commands print and write is what was found, in its own unit, under its name."""

import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.calibration.parametric.lens_formula import BoardTest
from raxel.calibration.views.correspondence import BoardShape, BoardView
from raxel.cameras import PerspectiveCamera
from raxel.cli import active_grids, main, mirror, models, scores
from raxel.cli.board_shape import shape_fields, shape_line
from raxel.cli.calibrate import _cross_validation
from raxel.cli.described import misfit_fields, misfit_warnings
from raxel.cli.image_sets import _check_images
from raxel.cli.images import _contents
from raxel.evaluation.benchmark import _spread
from raxel.evaluation.coverage import field_of_view
from raxel.evaluation.cross_validation import Evaluation, ImageScore, evaluate_camera
from raxel.evaluation.misfit import Misfit
from raxel.features.boards import Board, SizeVote, write_boards
from raxel.features.detector import Detection, Partial, rejected
from raxel.sets import load_set
from raxel.sets.model import BOARDS, View
from raxel.show.cameras import _posed_scene
from tests.image_sets import write_drawn_set
from tests.made_sets import BOARD as MADE
from tests.made_sets import COLUMNS, HEIGHT, PINHOLE, ROWS, WIDTH, K, boards_of

NAN = float("nan")
POSE = np.eye(4)


def image_score(found, without_ray):
    residuals = np.full((found, 2), NAN)
    return ImageScore(
        "one", found, without_ray, 0.4, 0.3, 0.2, POSE, POSE, residuals, ""
    )


def test_angles_of_the_field_of_view_are_degrees_along_their_own_sides():
    """Of a pinhole without distortion, from rim to rim of the pixels."""
    camera = PerspectiveCamera(
        [[400.0, 0, 319.5], [0, 300, 119.5], [0, 0, 1]], [], 640, 240
    )
    found = field_of_view(camera)
    across, down = 320 / 400, 120 / 300
    assert found["horizontal"] == pytest.approx(2 * np.degrees(np.arctan(across)))
    assert found["vertical"] == pytest.approx(2 * np.degrees(np.arctan(down)))
    corner = np.degrees(np.arctan(np.hypot(319.5 / 400, 119.5 / 300)))
    assert found["from_axis"] == pytest.approx(corner)


def test_the_shape_of_a_board_has_its_whole_size_and_a_stretch_in_per_cent():
    shape = BoardShape(
        np.array([80.0, 60.0]),
        np.array([80.0, 60.0]),
        np.array([0.3, -0.2, 0.1, 0.004]),
    )
    sd = np.array([0.03, 0.02, 0.01, 0.001])
    test = BoardTest(shape, sd, (), 0.25, 0.5, 0.125, 0.0625)
    view = BoardView(np.zeros((63, 2)), np.zeros((63, 2)), 9, 7)
    fields = shape_fields(test, [view])
    assert fields["size"] == [160.0, 120.0]
    assert fields["middle"] == [80.0, 60.0]
    assert fields["corners"] == [9, 7]
    told = [fields[name] for name in ("p_bends", "p_stretch", "flat_px", "shaped_px")]
    assert told == [0.25, 0.5, 0.125, 0.0625]
    line = shape_line(test, "mm", "board")
    assert "0.300 +- 0.030 mm" in line
    assert "0.40 +- 0.10 %" in line


def test_errors_of_models_stand_apart_from_those_that_all_can_answer_for():
    own = Evaluation([image_score(50, 5)], 0.5, 0.4, 0.3, 0.9, {1: "too few"})
    common = own._replace(rms_px=0.25)
    comparison = SimpleNamespace(
        own={"zhang": own}, common={"zhang": common}, errors_px={"zhang": 0.75},
        refused={"cgsp": "no overlap"},
    )  # fmt: skip
    found = _cross_validation(comparison)
    assert found["zhang"]["own"]["rms_px"] == 0.5
    assert found["zhang"]["common"]["rms_px"] == 0.25
    assert found["zhang"]["counted_rms_px"] == 0.75
    assert found["zhang"]["parts_left_out"] == ["too few"]
    assert found["cgsp"] == {"refused": "no overlap"}


def test_a_misfit_says_how_far_corners_are_off_and_by_how_much_they_scatter():
    found = Misfit(3.25, 0.5, 0.125, True)
    assert misfit_fields(found) == {
        "fits": False, "rms_px": 3.25, "scatter_px": 0.5, "stated_sd_px": 0.125,
        "odd_board": None,
    }  # fmt: skip
    (warning,) = misfit_warnings(found, "no camera fits", "look", BOARDS)
    assert [warning.find(n) > 0 for n in ("3.25 px", " 0.5 px", "0.12 px")] == 3 * [
        True
    ]


def test_corners_are_counted_and_stand_as_they_were_found(tmp_path):
    corners = np.column_stack([np.arange(12.0), np.arange(12.0) + 100])
    corners[[2, 7]] = NAN
    sd = np.arange(12) / 100 + 0.01
    partial = Partial(np.array([[5.0, 6.0]]), np.array([[1, 2]]))
    no = rejected(4, 3, "why")._replace(partial=partial)
    boards = [
        Board(View(image="a.png"), Detection(True, corners, 4, 3, sd=sd), 12.5),
        Board(View(image="b.png"), no, 7.5),
    ]
    vote = SizeVote({(4, 3): ["a.png"]}, 2, ["b.png"], [])
    path = tmp_path / "corners.json"
    write_boards(path, SimpleNamespace(name="made"), "raxel", boards, vote)
    found = json.loads(path.read_text())
    (first, second) = found.pop("images")
    assert first["corners"][3] == [3.0, 103.0]
    assert [k for k, point in enumerate(first["corners"]) if point is None] == [2, 7]
    assert (first["columns"], first["rows"], first["missing"]) == (4, 3, 2)
    assert first["sd"][3] == pytest.approx(sd[3])
    assert (first["found"], first["milliseconds"]) == (True, 12.5)
    assert second["partial"] == {"corners": [[5.0, 6.0]], "indices": [[1, 2]]}
    assert (second["found"], second["reason"]) == (False, "why")
    assert found["size"]["votes"] == [{"columns": 4, "rows": 3, "files": ["a.png"]}]
    assert found["size"]["photographs"] == 2
    assert found["size"]["looked_at_again"] == ["b.png"]
    assert found["size"]["found_then"] == []


def test_warnings_of_every_view_are_kept(tmp_path, monkeypatch, capsys):
    target = SimpleNamespace(kind="active_grid")
    views = [SimpleNamespace(label=name) for name in ("near", "far")]
    taken = SimpleNamespace(name="set", views=views, target=target)
    for name in ("_check_names", "_check_margin", "_write"):
        monkeypatch.setattr(active_grids, name, lambda *_: None)
    monkeypatch.setattr(active_grids, "load_set", lambda _: taken)
    monkeypatch.setattr(active_grids, "of_swapped_sides", lambda _: [])
    monkeypatch.setattr(active_grids, "of_handedness", lambda _: [])
    monkeypatch.setattr(active_grids, "_line", lambda view: view["view"])
    told = {"view": "", "as_in_a_mirror": False}
    monkeypatch.setattr(
        active_grids, "_summary", lambda label, _: told | {"view": label}
    )
    monkeypatch.setattr(
        active_grids,
        "decode_view",
        lambda _, view, **__: SimpleNamespace(
            reason="", warnings=[f"{view.label}: a lamp"]
        ),
    )
    options = SimpleNamespace(
        set="set", out=tmp_path / "points", raw=False, neighbours=True, fill=False,
        margin=None, linear=False,
    )  # fmt: skip
    active_grids.decode(options, lambda line: None)
    summary = json.loads((options.out / active_grids.SUMMARY).read_text())
    assert summary["warnings"] == ["near: a lamp", "far: a lamp"]
    assert "near: a lamp" in "".join(capsys.readouterr())


def test_residuals_of_a_mirror_have_a_mean_and_a_scatter_about_it():
    assert mirror._spread(np.array([1.0, NAN, 3.0])) == {"mean": 2.0, "sd": 1.0}


def test_the_share_of_straightened_pixels_is_counted_in_what_was_written(
    tmp_path, capsys
):
    """White photographs: what is black in the pictures, the camera does not see."""
    write_drawn_set(tmp_path / "set", ((0, 0), (25, 0)))
    for k in range(2):
        white = np.full((HEIGHT, WIDTH), 255, np.uint8)
        cv2.imwrite(str(tmp_path / "set" / f"view{k}.png"), white)
    PerspectiveCamera(K, [0.3, 0.0], WIDTH, HEIGHT).save(tmp_path / "camera.npz")
    out = tmp_path / "straight"
    given = tmp_path / "camera.npz", tmp_path / "set"
    assert main(["undistort", *map(str, given), "--out", str(out)]) == 0
    seen = np.mean(cv2.imread(str(out / "view0.png"), 0) > 0)
    assert seen < 0.97
    told = capsys.readouterr().out
    assert told.startswith(f"drawn: 2 images in {out}; the camera sees ")
    share = float(told.split("sees ")[1].split(" %")[0])
    assert share == pytest.approx(100 * seen, abs=1.0)


@pytest.mark.parametrize("model", ["spline", "cgsp", "generic"])
def test_boards_that_a_model_leaves_out_are_named_with_the_reason(monkeypatch, model):
    found = SimpleNamespace(
        camera=None, board=None, used=(0, 2), left_out={1: "too far"}, trend="unified",
        pupil=None, share_covered=0.5, share_with_ray=0.5, rms_deg=0.1, chosen=(0, 2),
        interpolation={0: "smooth", 2: "smooth"}, centre=None,
    )  # fmt: skip
    monkeypatch.setattr(models, f"calibrate_{model}", lambda *_, **__: found)
    views = [SimpleNamespace(name=name) for name in ("a.png", "b.png", "c.png")]
    details = getattr(models, model)(views, (640, 480), "mm").details
    assert details["left_out"] == [{"file": "b.png", "reason": "too far"}]


def test_the_line_of_a_score_gives_each_number_its_unit():
    found = Evaluation([image_score(50, 5)], 0.5, 0.25, 0.125, 0.9, {})
    assert found.n_scored == 45
    assert scores.line("set", found) == (
        "set: mean angle 0.1250 deg, rms 0.500 px, median 0.250 px, 90.0 % of corners "
        "with a ray"
    )


def test_the_vote_for_a_size_is_told_with_its_counts():
    votes = {(9, 6): ["a", "b", "c"], (8, 5): ["d"]}
    assert SizeVote(votes, 6, ["d", "e"], ["e"]).line() == (
        "size not given: 9 x 6 corners in 3 of 6 images, 8 x 5 in 1 (d); 2 searched "
        "again, 1 of them found"
    )


def test_shares_of_a_decoded_view_are_of_all_its_pixels():
    view = {
        "view": "pose", "unit": "mm", "pixels": {"decoded": 60, "dark": 15, "edge": 5},
        "median_sigma": [0.01, 0.02], "blur_px": 1.5, "margin_px": 6,
        "response": {
            "corrected": [True, False], "shift": [0.5, 0.25], "left": [0.125, 0.0],
        },
        "as_in_a_mirror": False,
    }  # fmt: skip
    assert active_grids._line(view) == (
        "pose: 75.0 % decoded, 18.8 % dark, 6.2 % edge; median sigma x 0.01 mm and y "
        "0.02 mm; blur 1.5 px, margin 6 px; response corrected: x by 0.5 mm, 0.12 left"
    )


def test_errors_are_summed_up_by_root_mean_square_median_and_largest():
    errors = np.array([1.0, 2.0, 2.0, 4.0, 10.0])
    assert _spread(errors, "deg") == {
        "rms_deg": pytest.approx(5.0), "median_deg": 2.0, "max_deg": 10.0,
    }  # fmt: skip


def test_lines_of_a_mirror_give_what_is_predicted_for_most_rays_and_at_most():
    stages = [
        {
            "residual_mm": {"mean": 0.5, "sd": 0.25},
            "predicted_ray_error_deg": {"median": 0.125, "largest": 0.75},
            "deflection_mm": mm,
        }
        for mm in (None, 2.5)
    ]
    grids = [{"first": "a", "second": "b", "distance_mm": 30.0, "distance_sd_mm": 0.5}]
    result = {
        "primary": {"points_from_rays_mm": 0.375, "grids": grids},
        "stages": stages, "viewer_error_counted": True,
    }  # fmt: skip
    assert list(mirror._lines(SimpleNamespace(name="made"), result)) == [
        "made: first shape: rays meet within 0.375 mm (mean); a and b 30.00 mm apart "
        "(SD 0.50)",
        "made: stage 0: residual 0.500 mm (SD 0.250), rays predicted to 0.125 deg "
        "(median), 0.750 at most",
        "made: stage 1, bent by 2.5 mm as stated: residual 0.500 mm (SD 0.250), rays "
        "predicted to 0.125 deg (median), 0.750 at most",
    ]


def test_a_set_is_told_by_what_was_counted_in_it(tmp_path, capsys):
    views = [{"image": f"view{i}.png"} for i in range(3)]
    views[2]["use"] = "evaluate"
    write_drawn_set(tmp_path, ((0, 0), (25, 0), (-25, 5)), views=views)
    _check_images(load_set(tmp_path), lambda text: None)
    told = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert told["images"] == "3 of 8 bit, 320 x 240 px"
    assert told["target"] == "chessboard, 7 x 5 interior corners, pitch 20.0 mm"
    assert told["views"] == "2 to calibrate, 1 to evaluate"


def test_patterns_are_counted_and_their_cells_measured(tmp_path, capsys):
    out = tmp_path / "shown"
    sides = "--width", "320", "--height", "160", "--cells", "4", "--steps", "4"
    assert main(["patterns", *sides, "--out", str(out)]) == 0
    told = capsys.readouterr().out
    written = [p for p in out.glob("*.png") if p.name[:4] in ("gray", "phas")]
    assert told.startswith(f"{len(written)} patterns with cells of 80 x 40 px, white")


def test_a_rendered_set_is_told_by_its_views_files_and_size():
    views = [SimpleNamespace(files=["a", "b", "c"]), SimpleNamespace(files=["d"])]
    told = _contents(SimpleNamespace(views=views, width=320, height=240))
    assert told == "2 views, 4 images of 320 x 240 px"


def test_the_note_of_a_scene_counts_boards_and_gives_the_median_distance():
    points = MADE.points()
    views = [
        BoardView(pixels, points, COLUMNS, ROWS, f"{k}.png")
        for k, pixels in enumerate(boards_of(PINHOLE, count=2, noise=0.5))
    ]
    of_set = SimpleNamespace(
        name="made", target=MADE, views=[View(image=f"{k}.png") for k in range(3)]
    )
    images = evaluate_camera(PINHOLE, views).images
    apart = np.linalg.norm(np.concatenate([i.residuals_px for i in images]), axis=1)
    assert _posed_scene(of_set, PINHOLE, views, "how").note == (
        "made: 2 of 3 boards; how. Median distance of corners from where this puts "
        f"them: {np.median(apart):.2g} px."
    )
