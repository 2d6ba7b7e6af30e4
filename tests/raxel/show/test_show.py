"""Scenes in space: content of meshes, images and pages; rejected input."""

import hashlib
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from raxel.cameras import camera_from
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.io import rendering
from raxel.sets import Chessboard
from raxel.show import (
    Arrows,
    Labels,
    Points,
    Polyline,
    Scene,
    SceneError,
    Segments,
    Surface,
    board,
    framed,
    html,
    image_array,
    png,
)
from raxel.show import rendering as page
from raxel.show.meshes import drawn_parts
from raxel.show.rendering import THEMES
from raxel.show.scene import CLEAR
from raxel.show.view import mm_per_px, projected

VIEW = {"view_from": (0, 0, -5), "look_at": (0, 0, 1)}
MISSING = rendering.rendering_missing()
draws = pytest.mark.skipif(bool(MISSING), reason=MISSING)
has_pyvista = pytest.mark.skipif("pyvista" in MISSING, reason=MISSING)


def lattice(rows, columns, depth=0.0):
    """A sheet (rows, columns, 3) of unit cells about the z axis: x right, y down."""
    v, u = np.mgrid[:rows, :columns].astype(float)
    u, v = u - (columns - 1) / 2, v - (rows - 1) / 2
    return np.stack([u, v, np.full_like(u, depth)], axis=-1)


def quadrants():
    """Red, green, blue and grey: upper left, upper right, lower left, lower right."""
    colours = [[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (128, 128, 128)]]
    return np.kron(np.array(colours, np.uint8), np.ones((8, 8, 1), np.uint8))


def meshes(*parts):
    return drawn_parts(Scene(parts, **VIEW))


@has_pyvista
def test_tube_follows_line_with_gaps():
    points = np.array([[0, 0, 1], [1, 0, 1], [np.nan] * 3, [2, 0, 1], [3, 0, 1]])
    (drawn,) = meshes(Polyline(points, "k", width=2))
    around = drawn.mesh.points
    assert np.unique(around[:, 0].round(6)).tolist() == [0, 1, 2, 3]
    radius = mm_per_px(Scene([Points([[0, 0, 0]], "k")], **VIEW))
    assert np.hypot(*around[:, 1:].T) == pytest.approx(radius)
    faces = drawn.mesh.triangulate().regular_faces
    spans = np.sort(around[faces][..., 0].round(6), axis=1)[:, [0, -1]]
    assert {tuple(span) for span in spans[spans[:, 0] < spans[:, 1]]} == {
        (0, 1),
        (2, 3),
    }


@has_pyvista
def test_nonfinite_parts_are_skipped():
    starts, ends = np.zeros((3, 3)), np.ones((3, 3))
    ends[1, 2] = np.inf
    drawn = meshes(
        Segments(starts, ends, "red"),
        Points([[np.nan, 0, 0], [1, 2, 3]], "blue", size=6),
        Points(np.full((2, 3), np.nan), "green", "nowhere"),
        Arrows(starts, ends, "black"),
    )
    assert len(drawn) == 3
    lines = Segments(starts[[0, 2]], ends[[0, 2]], "red")
    assert np.array_equal(drawn[0].mesh.points, meshes(lines)[0].mesh.points)
    assert drawn[1].mesh.center == pytest.approx((1, 2, 2))
    assert np.max(drawn[2].mesh.points @ [1, 1, 1]) <= 2 + 1e-6


@has_pyvista
def test_sheet_has_hole_at_missing_corner():
    points = lattice(4, 3)
    (drawn,) = meshes(Surface(points))
    assert np.allclose(drawn.mesh.points, points.reshape(-1, 3) - VIEW["look_at"])
    assert drawn.mesh.n_cells == 6
    points[0, 0] = np.nan
    (drawn,) = meshes(Surface(points, texture=quadrants()))
    assert drawn.mesh.n_cells == 5
    assert 0 not in drawn.mesh.regular_faces


@pytest.mark.parametrize("seed", range(5))
def test_framed_view_is_tight(seed):
    rng = np.random.default_rng(seed)
    points = (
        rng.normal(size=(30, 3)) * rng.uniform(1, 100, 3) + rng.normal(size=3) * 1e3
    )
    scene = framed([Points(points, "k")], rng.normal(size=3), scale="")
    reach = np.abs(projected(scene, points, 720, 480) - [359.5, 239.5]) / [360, 240]
    assert reach.max() == pytest.approx(0.9, abs=0.01)


@draws
def test_image_matches_camera_projection():
    """The renderer's pinhole, and the library's with its K, put corners alike."""
    chess = Chessboard(4, 3, 20.0)
    T = pose(rotation_from_vector([0.3, -0.4, 0.2]), [-30, -20, 300])
    parts = board(chess, T)
    marks = Points(transform(T, [[-20, -20, 0]]), "#ff0000", size=10)
    image = image_array(Scene([*parts, marks], (0, 0, 0), (0, 0, 300))).astype(int)
    height, width, _ = image.shape
    focal = height / 2 / np.tan(np.radians(15))
    K = [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]
    camera = camera_from(
        "perspective", {"K": K, "radial": [], "width": width, "height": height}
    )
    cells = np.array([[10, 10], [30, 10], [-10, 10], [-10, -10], [30, 30], [50, 10]])
    u, v = np.round(camera.project(transform(T, on_plane(cells))).pixels).astype(int).T
    assert (image[v, u].mean(axis=1) > 128).tolist() == [
        True, False, False, True, True, True,
    ]  # fmt: skip
    red = (image[..., 0] > 150) & (image[..., 1:].max(axis=2) < 90)
    middle = np.argwhere(red).mean(axis=0)[::-1]
    assert middle == pytest.approx(camera.project(marks.points).pixels[0], abs=2)


@draws
def test_texture_is_mirrored_from_behind():
    sheet = Surface(lattice(2, 2), texture=quadrants())
    for back in (False, True):
        scene = Scene([sheet], (0, 0, 5 if back else -5), (0, 0, 0))
        image = image_array(scene).astype(int)
        places = projected(
            scene, [[-0.3, -0.3, 0], [0.3, -0.3, 0]], *image.shape[1::-1]
        )
        u, v = np.round(places).astype(int).T
        assert image[v, u].argmax(axis=1).tolist() == [0, 1]
        assert (u[0] < u[1]) != back


@draws
def test_nearer_sheet_occludes_farther():
    near = Surface(lattice(2, 2, -1), "#ff0000", back=CLEAR)
    far = Surface(lattice(2, 2, 1), "#0000ff", back="#00ff00")

    def shown(parts, z):
        image = image_array(Scene(parts, (0, 0, z), (0, 0, 0))).astype(int)
        return int(image[image.shape[0] // 2, image.shape[1] // 2].argmax())

    assert shown([near, far], -6) == shown([far, near], -6) == 0
    assert shown([near, far], 6) == 1
    assert (image_array(Scene([near], (0, 0, 6), (0, 0, 0))) == 255).all()


def small_scene():
    """One of every part."""
    return framed(
        [
            Segments([[0, 0, 0]], [[0, 1, 3]], "#0072b2", "a </script><b>"),
            Points([[1, 2, 3]], "#d55e00", "dots"),
            Surface(lattice(3, 4), texture=quadrants(), back=CLEAR, label="sheet"),
            Surface(lattice(3, 4, 2), opacity=0.4, label="glass"),
            Labels([[0, 0, 0], [np.nan] * 3], ["<i>", "nowhere"], "#000000"),
        ],
        note="a < b",
    )


SAME_IN_A_NEW_PROCESS = """
import hashlib, sys
sys.path.insert(0, "tests")
from raxel.show import html, png
from tests.raxel.show.test_show import small_scene
for made in (png(small_scene()), html(small_scene(), "T").encode()):
    print(hashlib.sha256(made).hexdigest())
# What would ask the network for another renderer stays out.
assert "trame_vtklocal" not in sys.modules
"""


@draws
def test_rendering_is_reproducible():
    def made():
        pair = png(small_scene()), html(small_scene(), "T").encode()
        return [hashlib.sha256(content).hexdigest() for content in pair]

    first = made()
    html(framed([Points([[0, 0, 0], [1, 1, 1]], "k")]), "another, in between")
    assert made() == first
    other = subprocess.run(
        [sys.executable, "-c", SAME_IN_A_NEW_PROCESS], capture_output=True, text=True
    )
    assert other.stdout.split() == first, other.stderr


@draws
def test_page_is_self_contained():
    made = html(small_scene(), "An <i> title")
    assert "<title>An &lt;i&gt; title</title>" in made
    assert "<p>a &lt; b</p>" in made
    assert "a </script><b>" not in made
    assert not re.search(r"<(script|link|img)[^>]+(src|href)=", made)
    assert re.findall(r'<input type="checkbox" checked value="([^"]*)"', made) == [
        "a &lt;/script&gt;&lt;b&gt;", "dots", "sheet", "glass",
    ]  # fmt: skip
    assert '"text": "\\u003ci>"' in made
    words = json.loads(re.search(r'id="words">(.*?)</script>', made)[1])
    assert len(words["inked"]) == len(words["actors"])
    # The scale alone has the colour of the ink, which follows the theme.
    assert {words["actors"][k] for k, ink in enumerate(words["inked"]) if ink} == {""}
    assert [text["colour"] for text in words["texts"]] == ["#000000", "var(--ink)"]
    assert words["themes"]["dark"] == THEMES["dark"]._asdict()
    assert "nowhere" not in made
    assert len(made.encode()) < 1_300_000


@draws
def test_oversized_page_is_rejected(monkeypatch):
    monkeypatch.setattr(sys.modules[page.__name__], "MAX_PAGE_BYTES", 1000)
    with pytest.raises(SceneError, match=r"scene of \d+ bytes exceeds 1000"):
        html(small_scene(), "T")


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Points([1, 2, 3], "k", "dots"), r"Points 'dots': points has shape"),
        (lambda: Segments(np.zeros((2, 3)), np.zeros((3, 3)), "k"), "2 starts, 3 ends"),
        (lambda: Labels([[0, 0, 0]], ["a", "b"], "k"), "1 points, 2 texts"),
        (lambda: Surface(np.zeros((4, 3))), r"\(rows, columns, 3\) is needed"),
        (lambda: Surface(np.zeros((2, 2, 3)), opacity=0), "opacity 0"),
        (
            lambda: Surface(np.zeros((2, 2, 3)), texture=np.zeros((2, 2))),
            "texture is float64",
        ),
        (lambda: Scene([], **VIEW), "no parts"),
        (lambda: framed([]), "no part has a finite point"),
        (
            lambda: Scene([Points([[0, 0, 0]], "k")], (0, -5, 1), (0, 0, 1)),
            "are collinear",
        ),
        (
            lambda: Scene([Points([[0, 0, 0]], "k")], (0, np.nan, 1), (0, 0, 1)),
            "view_from is",
        ),
        (lambda: meshes(Points([[np.nan] * 3], "k")), "no part has a finite point"),
    ],
)
def test_invalid_scene_is_rejected(make, text):
    with pytest.raises(SceneError, match=text):
        make()


def test_look_at_is_image_centre():
    """Half a pixel beyond the outermost centre, as pixel centres are whole numbers."""
    edge = 10 * np.tan(np.radians(15.0))
    scene = Scene([Points([[0, 0, 0]], "k")], (0, 0, 0), (0, 0, 10), (0, -1, 0))
    points = [[0, 0, 10], [0, edge, 10], [0, -edge, 10], [edge, 0, 10]]
    pixels = projected(scene, points, 720, 480)
    expected = [[359.5, 239.5], [359.5, 479.5], [359.5, -0.5], [599.5, 239.5]]
    np.testing.assert_allclose(pixels, expected, atol=1e-9)
