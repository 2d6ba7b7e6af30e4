"""A fisheye in ten minutes: where boards are held, remap tables, and counts."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from chapters.guides.fisheye_in_ten_minutes import experiment, page, report
from raxel.multiview.views import perspective_view, source_pixels

SIZE = experiment.SIZES["quick"]


@pytest.fixture(scope="module")
def rig():
    return experiment.rig_of(SIZE)


def middle_of(rig, T):
    corner, extent = rig.extent
    return (T @ [*(corner + extent / 2), 0, 1])[:3]


def test_placed_board_matches_the_plan(rig):
    middle = middle_of(rig, T := experiment.placed(rig, 35.0, 90.0, 150.0, 15.0))
    assert np.linalg.norm(middle) == pytest.approx(150)
    assert np.degrees(np.arccos(middle[2] / 150)) == pytest.approx(35)
    # Azimuth 90 degrees is down in the image; rows run along the edge.
    assert middle[:2] == pytest.approx([0, 150 * np.sin(np.radians(35))])
    assert np.abs(T[:3, 0]) == pytest.approx([1, 0, 0])
    tilt = np.arccos(T[:3, 2] @ middle / 150)
    assert np.degrees(tilt) == pytest.approx(15)


def test_hand_held_board_stays_near_its_pose_and_visible(rig):
    rng = np.random.default_rng(0)
    for place in experiment.places_of(SIZE.plan):
        T = experiment.held_at(rig, place, rng)
        assert rig.shows(T)
        assert np.linalg.norm(middle_of(rig, T)) == pytest.approx(place[2], rel=0.05)
    assert experiment.inner_boards(experiment.SIZES["full"].plan) == 6
    assert len(experiment.places_of(experiment.SIZES["full"].plan)) == 16


def test_page_describes_the_full_plan():
    text = " ".join(Path(page.__file__).read_text("utf-8").replace("\n#", " ").split())
    full = experiment.SIZES["full"]
    _, half, *edge = full.plan
    assert f"{half.boards} boards at about {half.polar_deg:g}°" in text
    count = sum(ring.boards for ring in edge)
    assert f"{count} boards at about {edge[0].polar_deg:g}°" in text
    corners = f"{full.columns} × {full.rows} inner corners"
    assert f"{corners} at a pitch of {full.pitch_mm:g} mm" in text


def script_with(words):
    """The one Python listing of the page's text that holds these words."""
    lines = Path(page.__file__).read_text("utf-8").split("\n")
    text = "\n".join(line[2:] for line in lines if line.startswith("#"))
    listings = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (found,) = [listing for listing in listings if words in listing]
    return found


def test_board_script_writes_the_stated_board(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(script_with("board.svg"), {})
    svg = Path("board.svg").read_text("utf-8")
    assert 'width="285mm" height="210mm"' in svg
    squares = re.findall(r"M([\d.]+) ([\d.]+)h15v15h-15z", svg)
    assert (len(squares), squares[0]) == (18 * 13 // 2, ("7.5", "7.5"))
    full = experiment.SIZES["full"]
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


def test_undistortion_script_gives_the_image_of_the_page(tmp_path, monkeypatch, rig):
    camera = rig.camera
    monkeypatch.chdir(tmp_path)
    camera.save("camera.npz")
    Path("fisheye").mkdir()
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (camera.height, camera.width, 3), np.uint8)
    cv2.imwrite("fisheye/01.png", image)
    exec(script_with("cv2.remap"), {})
    map_x, map_y = cv2.split(source_pixels(camera, perspective_view(camera)))
    expected = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR)
    assert (cv2.imread("ahead.png") == expected).all()


def test_transcript_lines_are_folded():
    line = "word " * 30 + "95.3 % of corners"
    folded = report.folded(line)
    assert max(map(len, folded.split("\n"))) <= report.WIDTH + 4
    assert folded.split() == line.split()


def test_true_camera_has_no_error(rig):
    assert experiment.against_truth(rig.camera, rig.camera) == {
        "image_with_ray": 1.0,
        "ray_deg": pytest.approx(0, abs=1e-5),
    }
