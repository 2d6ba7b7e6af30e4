"""Scenes in figures and on pages, with OpenGL and without it."""

import json

import numpy as np
import pytest

from raxel.io.rendering import rendering_missing
from raxel.show import Points, Scene, Surface
from repro.page import draw, space, style
from repro.run import discover, jobs
from tests.sample_files import write

MISSING = "3-D images require OpenGL (not working); run: install <it>"
PAGE = "chapters/ch09_try/s9_scene/page.py"
VIEW = {"view_from": (0, 0, -5), "look_at": (0, 0, 1)}
SHEET = np.array([[[-9, -9, 2], [9, -9, 2]], [[-9, 9, 2], [9, 9, 2.0]]])


@pytest.fixture
def without_opengl(monkeypatch):
    monkeypatch.setattr(space, "rendering_missing", lambda: MISSING)


@pytest.mark.skipif(bool(rendering_missing()), reason=rendering_missing())
def test_scene_fills_axes():
    drawn, axes = style.new_figure(1, 2, height_in=2.0)
    drawn.set_layout_engine("none")
    axes[0].set_position([0, 0, 0.25, 1])
    axes[1].set(xlabel="Place (mm)", ylabel="Place (mm)")
    space.draw_scene(axes[0], Scene([Surface(SHEET, "#ff0000")], **VIEW))
    height, width = axes[0].images[0].get_array().shape[:2]
    assert width / height == pytest.approx((style.WIDTH_IN * 0.25 / 2.0), rel=0.02)
    middle = axes[0].images[0].get_array()[height // 2, width // 2]
    assert middle[0] > 100
    assert middle[1:3].max() < 60
    assert middle[3] == 255
    style.check_axes(drawn, "fig")


def test_figure_without_opengl_states_remedy(without_opengl):
    drawn, axes = style.new_figure()
    space.draw_scene(axes, Scene([Points([[0, 0, 0]], "k")], **VIEW))
    assert " ".join(axes.texts[0].get_text().split()) == MISSING
    style.check_axes(drawn, "fig")


def test_page_without_opengl_states_remedy(without_opengl):
    page = space.scene_page(Scene([Points([[0, 0, 0]], "k")], **VIEW), "A <b> title")
    assert "<title>A &lt;b&gt; title</title>" in page
    assert "run: install &lt;it&gt;" in page


CHAPTER = """
import numpy as np
from repro.run.marks import figure
from repro.run.outcomes import Drawing, Film, Panel
from raxel.show import Points, Scene
from repro.page.style import new_figure


@figure("fig_9_9", evidence="analytic"MARK)
def fig_9_9(results):
    drawn, axes = new_figure()
    axes.set(xlabel="Place (mm)", ylabel="Place (mm)")
    scene = Scene([Points([[0, 0, 0]], "k")], (0, 0, -5), (0, 0, 1))
    film = Film([Panel("", "", [np.zeros((4, 4, 3), np.uint8)])], ["black"])
    return Drawing(drawn, {"x": [0]}, "One $x$.", scene=SCENE)
"""


@pytest.mark.parametrize(
    ("mark", "scene", "good"),
    [
        (", scene=True", "scene", True),
        (", scene=True", "film", True),
        ("", "None", True),
        (", scene=True", "None", False),
        ("", "scene", False),
    ],
)
def test_figure_decorator_stores_scene(tmp_path, monkeypatch, mark, scene, good):
    text = CHAPTER.replace("MARK", mark).replace("SCENE", scene)
    path = write(tmp_path / PAGE, text)
    names = {}
    exec(compile(text, str(path), "exec"), names)
    monkeypatch.setattr(jobs, "function_of", lambda found: names[found.function])
    out = tmp_path / "figures" / "fig_9_9.json"
    if not good:
        with pytest.raises(ValueError, match="fig_9_9: marked with scene="):
            draw.draw(tmp_path, "figure", "fig_9_9", tmp_path, out)
        return
    draw.draw(tmp_path, "figure", "fig_9_9", tmp_path, out)
    about = json.loads(out.read_text())
    assert about["scene"] == {"scene": "3-D", "film": "film"}.get(scene, "")
    assert about["lines"] is True
    assert about["source"] == ["ch09_try/s9_scene/page.py", "fig_9_9"]
    assert out.with_suffix(".html").is_file() is bool(mark)
    if mark:
        assert "<title>Fig. 9.9 One x.</title>" in out.with_suffix(".html").read_text()


def test_scene_flag_must_be_literal(tmp_path):
    write(tmp_path / PAGE, CHAPTER.replace("MARK", ", scene=True"))
    assert [p.details["scene"] for p in discover.producers(tmp_path)] == [True]
