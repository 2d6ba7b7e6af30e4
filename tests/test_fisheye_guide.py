"""A fisheye in ten minutes: where boards are held, remap tables, and counts."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from chapters.guides.fisheye_in_ten_minutes import page, results, tables
from chapters.guides.fisheye_in_ten_minutes.trials import boards, commands, models
from chapters.shared.records import record
from raxel.cameras import FisheyeCamera, PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.multiview.perspective_view import perspective_view
from repro.run.outcomes import Plan
from tests.made_results import plan_of, written

SIZE = boards.SIZES["quick"]


@pytest.fixture(scope="module")
def rig():
    return boards.rig_of(SIZE)


def middle_of(rig, T):
    corner, extent = rig.extent
    return (T @ [*(corner + extent / 2), 0, 1])[:3]


def test_a_placed_board_is_where_the_plan_says(rig):
    middle = middle_of(rig, T := boards.placed(rig, 35.0, 90.0, 150.0, 15.0))
    assert np.linalg.norm(middle) == pytest.approx(150)
    assert np.degrees(np.arccos(middle[2] / 150)) == pytest.approx(35)
    # Azimuth 90 degrees is down in the image; rows run along the rim.
    assert middle[:2] == pytest.approx([0, 150 * np.sin(np.radians(35))])
    assert np.abs(T[:3, 0]) == pytest.approx([1, 0, 0])
    tilt = np.arccos(T[:3, 2] @ middle / 150)
    assert np.degrees(tilt) == pytest.approx(15)


def test_a_hand_stays_near_its_place_and_the_board_in_view(rig):
    rng = np.random.default_rng(0)
    for place in boards.places_of(SIZE.plan):
        T = boards.held_at(rig, place, rng)
        assert rig.shows(T)
        assert np.linalg.norm(middle_of(rig, T)) == pytest.approx(place[2], rel=0.05)
    assert boards.inner_boards(boards.SIZES["full"].plan) == 6
    assert len(boards.places_of(boards.SIZES["full"].plan)) == 16


def test_the_plan_at_full_size_covers_nine_tenths_of_the_circle():
    size = boards.SIZES["full"]
    rig, seen = boards.rig_of(size), 0
    for place in boards.places_of(size.plan):
        T = boards.placed(rig, *place)
        view = models.board_at(rig, T, np.random.default_rng(0))
        seen = seen + models.board_counts([view], rig.camera.width, rig.camera.height)
    lit = models.lit(size)
    assert np.mean(seen[lit] > 0) > 0.9


def script_with(words):
    """The one Python listing of the page's text that holds these words."""
    lines = Path(page.__file__).read_text("utf-8").split("\n")
    text = "\n".join(line[2:] for line in lines if line.startswith("#"))
    listings = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (found,) = [listing for listing in listings if words in listing]
    return found


def test_the_board_script_runs_as_it_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(script_with("board.svg"), {})
    svg = Path("board.svg").read_text("utf-8")
    assert 'width="285mm" height="210mm"' in svg
    squares = re.findall(r"M([\d.]+) ([\d.]+)h15v15h-15z", svg)
    assert len(squares) == 18 * 13 // 2
    assert squares[0] == ("7.5", "7.5")
    full = boards.SIZES["full"]
    assert f"= {full.columns}, {full.rows}  #" in script_with("board.svg")
    # The smaller board fits a sheet with margins of 10 mm.
    exec(
        script_with("board.svg").replace(
            "pitch_mm, border_mm = 15", "pitch_mm, border_mm = 13"
        ),
        {},
    )
    width, height = map(
        float, re.findall(r'="([\d.]+)mm"', Path("board.svg").read_text())
    )
    assert width <= 277
    assert height <= 190


def test_the_correcting_script_does_what_the_page_did(tmp_path, monkeypatch, rig):
    camera = rig.camera
    monkeypatch.chdir(tmp_path)
    camera.save("camera.npz")
    Path("fisheye").mkdir()
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (camera.height, camera.width, 3), np.uint8)
    cv2.imwrite("fisheye/01.png", picture)
    exec(script_with("cv2.remap"), {})
    focal = commands.SIDE_FOCAL * camera.width
    views = {
        "ahead": perspective_view(camera),
        "aside": commands.turned_view(camera, commands.ASIDE_DEG, focal),
    }
    for name, view in views.items():
        maps = commands.remap_tables(camera, view)
        expected = cv2.remap(picture, *maps, cv2.INTER_LINEAR)
        assert (cv2.imread(f"{name}.png") == expected).all()


def test_long_lines_of_a_transcript_go_on_in_the_next():
    line = "word " * 30 + "95.3 % of corners"
    folded = tables.folded(line)
    assert max(map(len, folded.split("\n"))) <= tables.WIDTH + 4
    assert folded.split() == line.split()


def test_coverage_grows_and_a_refusal_is_counted(monkeypatch):
    def refuses(*_):
        raise CalibrationError("OpenCV's fisheye model: it refuses")

    monkeypatch.setattr(models, "calibrate_opencv_fisheye", refuses)
    rng = np.random.default_rng(0)
    found = models.coverage_trial(SIZE, models.PLANNED, 3, rng)
    shares = found["shares"]
    assert len(shares) == len(boards.places_of(SIZE.plan))
    assert (np.diff(shares) >= 0).all()
    assert 0.1 < shares[0] < shares[-1] < 1
    assert found["all"]["outcome"] == found["inner"]["outcome"] == "refused"
    assert found["all"]["reach_deg"] > found["inner"]["reach_deg"] > 50
    anywhere = models.coverage_trial(SIZE, models.ANYWHERE, 3, rng)
    assert len(anywhere["shares"]) == 3


def test_the_true_camera_has_no_error_against_the_truth(rig):
    assert models.against_truth(rig.camera, rig.camera) == {
        "image_with_ray": 1.0,
        "ray_deg": pytest.approx(0, abs=1e-5),
    }


def test_remap_tables_of_a_pinhole_leave_the_picture_as_it_is():
    K = np.array([[80.0, 0, 39.5], [0, 80.0, 29.5], [0, 0, 1]])
    camera = PerspectiveCamera(K, [], 80, 60)
    map_x, map_y = commands.remap_tables(camera, perspective_view(camera))
    assert map_x.dtype == map_y.dtype == np.float32
    v, u = np.mgrid[:60, :80]
    assert map_x == pytest.approx(u, abs=1e-3)
    assert map_y == pytest.approx(v, abs=1e-3)


def test_a_view_turned_aside_looks_there():
    camera = FisheyeCamera(
        "equidistance", 60.0, (99.5, 79.5), 200, 160, max_angle=np.radians(85)
    )
    view = commands.turned_view(camera, 40.0, 100.0)
    map_x, map_y = commands.remap_tables(camera, view)
    # An equidistant lens shows what is 40 degrees aside 60 px times that angle aside.
    cx, cy = np.round(view.K[:2, 2]).astype(int)
    expected = 99.5 + 60 * np.radians(40)
    assert map_x[cy, cx] == pytest.approx(expected, abs=1)
    assert map_y[cy, cx] == pytest.approx(79.5, abs=1)


def test_boards_until_a_goal_are_counted_and_draws_that_never_reach_it():
    shares = np.array([[0.5, 0.9, 0.95], [0.3, 0.5, 0.7]])
    draws = iter(shares)
    plan = Plan(
        lambda condition, rng: {"shares": next(draws)}, [{"held": "anywhere"}], 2
    )
    drawn = written(plan)
    needed = results.boards_for(drawn, "anywhere", 0.9)
    assert needed[0] == 2
    assert np.isnan(needed[1])
    assert results.told_boards(needed) == "2 pictures (not reached in 1 draws)"
    assert results.told_reached(needed) == "1 of 2 draws"


def test_the_record_of_calibrations_fills_its_table():
    sets = record("calibrations")["sets"]
    kept = written(plan_of("ext_calibration_record"))
    columns = tables.ext_fisheye_photographs(
        {"ext_calibration_record": kept, "photograph_study": {}}
    ).columns
    others = [one["name"] for one in record("detectors")["sets"]]
    assert sorted(columns["Set"]) == sorted(others)
    for one, cell in zip(sets, columns["Generic (px)"], strict=True):
        assert cell.low <= cell.value == one["models"]["generic"]["px"] <= cell.high
    assert all(0 < x <= 100 for x in columns["Picture with a ray (%)"])
