"""Printed and written results: values, units and names."""

import json
import re
from functools import partial
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.calibration.parametric.lens_formula import BoardTest
from raxel.calibration.views.correspondence import BoardShape, BoardView
from raxel.cameras import KannalaBrandtCamera, MovingPupilCamera, PerspectiveCamera
from raxel.cli import active_grids, main, models
from raxel.cli.findings import misfit_warnings
from raxel.cli.image_sets import _check_images
from raxel.cli.images import _contents
from raxel.evaluation.benchmark import _spread
from raxel.evaluation.comparison import ModelComparison, spread_fields
from raxel.evaluation.coverage import field_of_view
from raxel.evaluation.cross_validation import Evaluation, ImageScore, evaluate_camera
from raxel.evaluation.diagnoses import score_text, shape_lines, stage_lines
from raxel.evaluation.json_fields import shape_fields
from raxel.evaluation.misfit import Misfit
from raxel.features.boards import Board, SizeVote, write_boards
from raxel.features.detector import Detection, Partial, rejected
from raxel.multiview.views import resample
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


def test_field_of_view_is_in_degrees_along_each_side():
    """Of a pinhole without distortion, between the outer edges of the pixels."""
    camera = PerspectiveCamera(
        [[400.0, 0, 319.5], [0, 300, 119.5], [0, 0, 1]], [], 640, 240
    )
    found = field_of_view(camera)
    across, down = 320 / 400, 120 / 300
    assert found["horizontal"] == pytest.approx(2 * np.degrees(np.arctan(across)))
    assert found["vertical"] == pytest.approx(2 * np.degrees(np.arctan(down)))
    corner = np.degrees(np.arctan(np.hypot(319.5 / 400, 119.5 / 300)))
    assert found["from_axis"] == pytest.approx(corner)


def test_board_shape_has_full_size_and_stretch_in_per_cent():
    shape = BoardShape(
        np.array([80.0, 60.0]),
        np.array([80.0, 60.0]),
        np.array([0.3, -0.2, 0.1, 0.004]),
    )
    sd = np.array([0.03, 0.02, 0.01, 0.001])
    test = BoardTest(shape, sd, (), 0.25, 0.5, 0.125, 0.0625)
    view = BoardView(np.zeros((63, 2)), np.zeros((63, 2)), 9, 7)
    fields = shape_fields(test, [view])
    assert fields | {
        "size": [160.0, 120.0], "middle": [80.0, 60.0], "corners": [9, 7],
        "p_bends": 0.25, "p_stretch": 0.5, "flat_px": 0.125, "shaped_px": 0.0625,
    } == fields  # fmt: skip
    assert list(shape_lines(fields, BOARDS, {"unit": "mm"})) == [
        (
            "board shape",
            "over 160 x 120 mm, ends of x 0.300 +- 0.030 mm behind the centre, ends of "
            "y -0.200 +- 0.020 mm, twist 0.100 +- 0.010 mm (not significant, not used)",
        ),
        ("board stretch", "x against y 0.40 +- 0.10 % (not significant, not used)"),
    ]


def test_comparison_has_own_and_common_errors():
    own = Evaluation([image_score(50, 5)], 0.5, 0.4, 0.3, 0.9, {1: "too few"})
    common = own._replace(rms_px=0.25)
    models_of = {"zhang": own}, {"zhang": common}, {"cgsp": "no overlap"}
    found = ModelComparison(*models_of, {"zhang": 0.75}).fields()
    zhang = found["zhang"]
    assert (zhang["own"]["rms_px"], zhang["common"]["rms_px"]) == (0.5, 0.25)
    assert (zhang["counted_rms_px"], zhang["parts_left_out"]) == (0.75, ["too few"])
    assert found["cgsp"] == {"refused": "no overlap"}


def test_misfit_warning_has_rms_scatter_and_predicted_sd():
    found = Misfit(3.25, 0.5, 0.125, True)
    assert found.fields() == {
        "fits": False, "rms_px": 3.25, "scatter_px": 0.5, "stated_sd_px": 0.125,
        "odd_board": None, "odd_boards": [],
    }  # fmt: skip
    (warning,) = misfit_warnings(found, "central-misfit", BOARDS)
    assert warning.startswith(
        "no central camera fits: RMS 3.25 px (corner scatter 0.5 px, predicted 0.12 px)"
    )
    (warning,) = misfit_warnings(
        found._replace(scatter_px=11.0), "camera-misfit", BOARDS
    )
    assert warning.startswith("this camera does not fit: RMS 3.25 px ")
    assert warning.code == "point-order"


def test_corners_file_has_counts_and_positions(tmp_path):
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
    assert found["size"] | {
        "votes": [{"columns": 4, "rows": 3, "files": ["a.png"]}],
        "photographs": 2, "looked_at_again": ["b.png"], "found_then": [],
    } == found["size"]  # fmt: skip


def test_decode_keeps_warnings_of_all_views(tmp_path, monkeypatch, capsys):
    target = SimpleNamespace(kind="active_grid")
    views = [SimpleNamespace(label=name) for name in ("near", "far")]
    taken = SimpleNamespace(name="set", views=views, target=target)
    for name in ("_check_names", "_check_margin", "_write"):
        monkeypatch.setattr(active_grids, name, lambda *_: None)
    monkeypatch.setattr(active_grids, "load_set", lambda _: taken)
    monkeypatch.setattr(active_grids, "of_swapped_sides", lambda _: [])
    monkeypatch.setattr(active_grids, "of_handedness", lambda _: [])
    monkeypatch.setattr(active_grids, "_line", lambda view: view["view"])
    fields = {"view": "", "as_in_a_mirror": False}
    monkeypatch.setattr(
        active_grids, "_summary", lambda label, _: fields | {"view": label}
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


def test_mirror_residuals_have_mean_and_sd():
    assert spread_fields(np.array([1.0, NAN, 3.0])) == {"mean": 2.0, "sd": 1.0}


def test_undistort_prints_the_share_of_visible_pixels(tmp_path, capsys):
    """White images: pixels that the camera does not see are black."""
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
    printed = capsys.readouterr().out
    assert printed.startswith(f"drawn: 2 images in {out}; the camera sees ")
    share = float(printed.split("sees ")[1].split(" %")[0])
    assert share == pytest.approx(100 * seen, abs=1.0)


def direction(stated, u, v):
    """Direction in the view of pixels, by the table of data/recorded/README.md."""
    if stated["projection"] == "perspective":
        return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(stated["K"]).T
    a = (u - (stated["width"] - 1) / 2) / stated["radius"]
    down = (v - stated["horizon"]) / stated["radius"]
    if stated["projection"] == "equirectangular":
        down = np.tan(down)
    return np.stack([np.sin(a), down, np.cos(a)], axis=-1)


@pytest.mark.parametrize("projection", ["perspective", "cylinder", "equirectangular"])
def test_undistort_states_range_and_geometry(tmp_path, capsys, projection):
    write_drawn_set(tmp_path / "set", ((0, 0), (25, 0)))
    lens = KannalaBrandtCamera([1, 0], (200.0, 200.0), (159.5, 119.5), WIDTH, HEIGHT)
    camera, out = MovingPupilCamera(lens, [6.0]), tmp_path / "out"
    order = f"undistort {tmp_path / 'camera.npz'} {tmp_path / 'set'} --out {out} --maps"
    order = f"{order} --size 90 60 --fov 70 --projection {projection}".split()
    camera.save(tmp_path / "camera.npz")
    assert main(order) == 0
    line = capsys.readouterr().out
    assert "rays do not meet in one point: images are exact far away; nearer" in line
    near = float(re.search(r"than (\S+) mm off by more than 1 px", line)[1])
    camera.board_distance = near
    camera.save(tmp_path / "camera.npz")
    assert main([*order, "--range", "300"]) == 0
    line = capsys.readouterr().out
    assert f"exact at 300 mm; at {near:g} mm (boards) off by up to 0." in line
    # The files alone give the point that each pixel shows.
    stated = json.loads((out / "undistorted.json").read_text())
    v, u = np.mgrid[:60, :90].astype(float)
    ahead = direction(stated, u, v) @ np.transpose(stated["R_camera_view"])
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    edges = direction(stated, np.array([-0.5, 89.5]), np.array([29.5, 29.5]))
    azimuths = np.degrees(np.arctan2(edges[:, 0], edges[:, 2]))
    np.testing.assert_allclose(azimuths, [-35, 35])
    far, exact, close = (
        camera.project((length * ahead + stated["centre"]).reshape(-1, 3)).pixels
        for length in (1e6, 300.0, near)
    )
    with np.load(out / "maps.npz") as maps:
        pixels = np.dstack([maps["u"], maps["v"]])
    seen = camera.in_image(exact)
    assert seen.mean() > 0.8
    np.testing.assert_allclose(pixels.reshape(-1, 2)[seen], exact[seen], atol=1e-4)
    assert np.linalg.norm(far - close, axis=1)[seen].max() == pytest.approx(1, abs=0.06)
    given, new = (cv2.imread(f"{one}/view1.png", 0) for one in (tmp_path / "set", out))
    np.testing.assert_array_equal(new, resample(given, pixels))


def test_models_name_excluded_boards_with_the_reason(monkeypatch):
    found = SimpleNamespace(
        camera=None, board=None, used=(0, 2), left_out={1: "too far"}, trend="unified",
        pupil=None, share_covered=0.5, share_with_ray=0.5, rms_deg=0.1, chosen=(0, 2),
        interpolation={0: "smooth", 2: "smooth"}, centre=None,
    )  # fmt: skip
    monkeypatch.setattr(models, "calibrate_spline", lambda *_, **__: found)
    views = [SimpleNamespace(name=name) for name in ("a.png", "b.png", "c.png")]
    for fit in (models.spline, partial(models.table, models.calibrate_spline)):
        details = fit(views, (640, 480), "mm").details
        assert details["left_out"] == [{"file": "b.png", "reason": "too far"}]


def test_score_text_has_units():
    found = Evaluation([image_score(50, 5)], 0.5, 0.25, 0.125, 0.9, {})
    assert found.n_scored == 45
    assert score_text(found.totals()) == (
        "mean angle 0.1250 deg, RMS 0.500 px, median 0.250 px, 90.0 % of corners "
        "with a ray"
    )


def test_size_vote_line_has_counts():
    votes = {(9, 6): ["a", "b", "c"], (8, 5): ["d"]}
    assert SizeVote(votes, 6, ["d", "e"], ["e"]).line() == (
        "size not given: 9 x 6 corners in 3 of 6 images, 8 x 5 in 1 (d); 2 searched "
        "again, 1 of them found"
    )


def test_decode_shares_are_of_all_pixels():
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


def test_spread_is_rms_median_and_max():
    errors = np.array([1.0, 2.0, 2.0, 4.0, 10.0])
    assert _spread(errors, "deg") == {
        "rms_deg": pytest.approx(5.0), "median_deg": 2.0, "max_deg": 10.0,
    }  # fmt: skip


def test_stage_lines_have_median_and_largest_predicted_error():
    stages = [
        {
            "residual_mm": {"mean": 0.5, "sd": 0.25},
            "predicted_ray_error_deg": {"median": 0.125, "largest": 0.75},
            "deflection_mm": mm,
        }
        for mm in (None, 2.5)
    ]
    result = {"stages": stages, "viewer_error_counted": True}
    text = (
        "residual 0.500 mm (SD 0.250 mm), predicted ray error 0.125 deg (median), "
        "0.750 deg (largest)"
    )
    assert list(stage_lines(result)) == [
        ("stage 0", text),
        ("stage 1", f"specified deflection 2.5 mm, {text}"),
    ]
    uncounted = stage_lines(result | {"viewer_error_counted": False})
    assert next(uncounted)[1] == f"{text}, without the error of the camera (unknown)"


def test_check_prints_counts_of_the_set(tmp_path, capsys):
    views = [{"image": f"view{i}.png"} for i in range(3)]
    views[2]["use"] = "evaluate"
    write_drawn_set(tmp_path, ((0, 0), (25, 0), (-25, 5)), views=views)
    _check_images(load_set(tmp_path), lambda text: None)
    printed = capsys.readouterr().out.splitlines()
    rows = dict(line.split(maxsplit=1) for line in printed)
    assert rows["images"] == "3 of 8 bit, 320 x 240 px"
    assert rows["target"] == "chessboard, 7 x 5 interior corners, pitch 20.0 mm"
    assert rows["views"] == "2 to calibrate, 1 to evaluate"


def test_patterns_prints_count_and_cell_size(tmp_path, capsys):
    out = tmp_path / "shown"
    sides = "--width", "320", "--height", "160", "--cells", "4", "--steps", "4"
    assert main(["patterns", *sides, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    written = [p for p in out.glob("*.png") if p.name[:4] in ("gray", "phas")]
    assert printed.startswith(
        f"{len(written)} patterns with cells of 80 x 40 px, white"
    )


def test_render_prints_counts_and_size():
    views = [SimpleNamespace(files=["a", "b", "c"]), SimpleNamespace(files=["d"])]
    line = _contents(SimpleNamespace(views=views, width=320, height=240))
    assert line == "2 views, 4 images of 320 x 240 px"


def test_scene_note_has_board_count_and_median_distance():
    points = MADE.points()
    views = [
        BoardView(pixels, points, COLUMNS, ROWS, f"{k}.png")
        for k, pixels in enumerate(boards_of(PINHOLE, count=2, noise=0.5))
    ]
    of_set = SimpleNamespace(
        name="made", target=MADE, views=[View(image=f"{k}.png") for k in range(3)]
    )
    images = evaluate_camera(PINHOLE, views).images
    distances = np.linalg.norm(np.concatenate([i.residuals_px for i in images]), axis=1)
    assert _posed_scene(of_set, PINHOLE, views, "how").note == (
        "made: 2 of 3 boards; how. Median distance of corners from where this puts "
        f"them: {np.median(distances):.2g} px."
    )
