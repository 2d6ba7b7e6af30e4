"""Scenes to turn around: what is written, what is refused, and that it stays alone."""

import base64
import json
import re
import sys

import numpy as np
import pytest

from repro.page import draw
from repro.page.scene import Points, Polyline, Scene, SceneError, Segments, Surface
from repro.page.scene_page import LARGEST_BYTES, scene_html
from repro.run import discover, jobs
from repro.site.check import check_site

VIEW = {"view_from": (0, 0, -5), "look_at": (0, 0, 1)}


def described(*parts, **more) -> dict:
    """The data that the page of these parts carries."""
    page = scene_html(Scene(parts, **(VIEW | more)), "A title")
    return json.loads(re.search(r'id="scene">(.*?)</script>', page, re.S)[1])


def floats(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, 3)


def test_lines_are_told_about_the_centre_of_turning_and_broken_at_nan():
    points = np.array([[0, 0, 1], [1, 0, 1], [np.nan] * 3, [2, 0, 1], [3, 0, 1]])
    found = described(Polyline(points, "k", "path"))["parts"][0]
    assert found["kind"] == "lines"
    assert found["label"] == "path"
    assert found["colour"] == [0, 0, 0]
    drawn = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]
    assert floats(found["points"]).tolist() == drawn


def test_far_from_the_origin_single_precision_is_enough():
    centre = np.array([1e7, 0, 0])
    points = centre + [[0.25, 0, 0], [0, 0.125, 0]]
    content = described(Points(points, "#123456"), look_at=centre, view_from=centre + 1)
    assert floats(content["parts"][0]["points"]).tolist() == [
        [0.25, 0, 0],
        [0, 0.125, 0],
    ]
    assert content["radius"] == 0.25


def test_segments_and_dots_without_a_finite_place_are_left_out():
    starts, ends = np.zeros((3, 3)), np.ones((3, 3))
    ends[1, 2] = np.inf
    parts = described(
        Segments(starts, ends, "red"),
        Points([[np.nan, 0, 0], [1, 2, 3]], "blue"),
        Points(np.full((2, 3), np.nan), "green", "nowhere"),
    )["parts"]
    assert [part["count"] for part in parts] == [4, 1]


def test_a_surface_has_two_triangles_a_cell_and_a_hole_where_a_corner_is_missing():
    v, u = np.mgrid[:4, :3].astype(float)
    lattice = np.dstack([u, v, np.zeros_like(u)])
    assert described(Surface(lattice))["parts"][0]["count"] == 3 * 2 * 3 * 2
    lattice[0, 0] = np.nan
    texture = np.zeros((5, 7), np.uint8)
    found = described(Surface(lattice, texture=texture))["parts"][0]
    triangles = np.frombuffer(base64.b64decode(found["triangles"]), "<u4")
    assert len(triangles) == 3 * (2 * 3 * 2 - 2)
    assert 0 not in triangles
    assert found["shape"] == [4, 3]
    assert found["texture"].startswith("data:image/png;base64,")


def test_the_same_scene_is_the_same_page_and_loads_nothing(tmp_path):
    def page():
        part = Points([[1, 2, 3]], "k", "</script><b>")
        return scene_html(Scene([part], **VIEW, note="a < b"), "An <i> title")

    assert page() == page()
    assert "</script><b>" not in page()
    assert "a &lt; b" in page()
    assert not re.search(r"https?:|//\w+\.\w+/|\bimport\b.*from|fetch\(", page())
    (tmp_path / "scene.html").write_text(page())
    assert check_site(tmp_path) == []
    assert len(page()) < 40_000
    assert "pyvista" not in sys.modules


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Points([1, 2, 3], "k", "dots"), r"Points 'dots': points has shape"),
        (lambda: Segments(np.zeros((2, 3)), np.zeros((3, 3)), "k"), "2 starts, 3 ends"),
        (lambda: Surface(np.zeros((4, 3))), r"\(rows, columns, 3\) is needed"),
        (lambda: Surface(np.zeros((2, 2, 3)), opacity=0), "opacity 0"),
        (
            lambda: Surface(np.zeros((2, 2, 3)), texture=np.zeros((2, 2))),
            "texture is float64",
        ),
        (lambda: Scene([], **VIEW), "no parts"),
        (
            lambda: Scene([Points([[0, 0, 0]], "k")], (0, -5, 1), (0, 0, 1)),
            "lie on one line",
        ),
        (
            lambda: Scene([Points([[0, 0, 0]], "k")], (0, np.nan, 1), (0, 0, 1)),
            "view_from is",
        ),
        (lambda: described(Points([[np.nan] * 3], "k")), "no part has a finite point"),
        (
            lambda: described(Points(np.zeros((LARGEST_BYTES // 16, 3)), "k")),
            "give it fewer points",
        ),
    ],
)
def test_a_bad_scene_is_refused_with_its_reason(make, said):
    with pytest.raises(SceneError, match=said):
        make()


CHAPTER = """
from repro.run.experiment import figure
from repro.run.outcomes import Drawing
from repro.page.scene import Points, Scene
from repro.page.style import figure as new_figure


@figure("fig_9_9", evidence="analytic"MARK)
def fig_9_9(results):
    drawn, axes = new_figure()
    axes.set(xlabel="Place (mm)", ylabel="Place (mm)")
    scene = Scene([Points([[0, 0, 0]], "k")], (0, 0, -5), (0, 0, 1))
    return Drawing(drawn, {"x": [0]}, "One $x$.", scene=SCENE)
"""


@pytest.mark.parametrize(
    ("mark", "scene", "good"),
    [
        (", scene=True", "scene", True),
        ("", "None", True),
        (", scene=True", "None", False),
        ("", "scene", False),
    ],
)
def test_a_marked_figure_leaves_its_scene(tmp_path, monkeypatch, mark, scene, good):
    path = tmp_path / "chapters" / "ch09_try" / "s9_scene" / "page.py"
    path.parent.mkdir(parents=True)
    path.write_text(CHAPTER.replace("MARK", mark).replace("SCENE", scene))
    names = {}
    exec(compile(path.read_text(), str(path), "exec"), names)
    monkeypatch.setattr(jobs, "function_of", lambda found: names[found.function])
    out = tmp_path / "figures" / "fig_9_9.json"
    if not good:
        with pytest.raises(ValueError, match="fig_9_9 is marked with scene="):
            draw.draw(tmp_path, "figure", "fig_9_9", tmp_path, out)
        return
    draw.draw(tmp_path, "figure", "fig_9_9", tmp_path, out)
    about = json.loads(out.read_text())
    assert about["scene"] is bool(mark)
    assert about["source"] == ["ch09_try/s9_scene/page.py", "fig_9_9"]
    assert out.with_suffix(".html").is_file() is bool(mark)
    if mark:
        assert "<title>Fig. 9.9 One x.</title>" in out.with_suffix(".html").read_text()


def test_a_scene_is_a_literal_that_the_workflow_finds(tmp_path):
    path = tmp_path / "chapters" / "ch09_try" / "s9_scene" / "page.py"
    path.parent.mkdir(parents=True)
    path.write_text(CHAPTER.replace("MARK", ", scene=True"))
    assert [p.details["scene"] for p in discover.producers(tmp_path)] == [True]
