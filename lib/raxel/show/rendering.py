"""Renderings of a scene: an image, and an interactive page.

The page is pyvista's own export, with legend and labels. It loads nothing and works
from the disk. The export numbers its objects by memory address and adds time stamps.
Here they are numbered in order, so that equal scenes give equal pages.
"""

from __future__ import annotations

import contextlib
import json
import re
import sys
from html import escape
from io import BytesIO, StringIO
from pathlib import Path
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np

from raxel.errors import InputError
from raxel.io.rendering import need, packages_missing, rendering_missing
from raxel.show.meshes import drawn_parts
from raxel.show.scene import Labels, Points, Scene, SceneError, Surface
from raxel.show.view import INK, NOMINAL_PX, VIEW_ANGLE_DEG, projected, view_angle_deg

# Image of a scene: shaded by pyvista off screen, with labels and legend.


# Width and height on a page, px; the file has PIXELS_PER_PX times as many each way.
SIZE = (720, 480)
PIXELS_PER_PX = 2
# Light enough for paper, solid enough for shape: matt, with a soft highlight.
SHADING = {"ambient": 0.35, "diffuse": 0.65, "specular": 0.0}
PRINTED = {"ambient": 0.85, "diffuse": 0.15, "specular": 0.0}
N_PEELS = 8
FONT_PX, LINE_PX, GAP_PX = 13, 21, 18


class Theme(NamedTuple):
    """background, words and their halo."""

    background: str
    ink: str


THEMES = {"light": Theme("#ffffff", INK), "dark": Theme("#14181e", "#e6e9ed")}


def png(scene: Scene, size: tuple[int, int] = SIZE, theme: str = "light") -> bytes:
    """Render a scene as a PNG image, the same for the same scene and machine.

    Parameters
    ----------
    scene : Scene
        Scene to render.
    size : tuple of int
        Width and height at which the image is shown, px. It has twice as many each way.
    theme : str
        'light' or 'dark'.

    Returns
    -------
    bytes
        PNG file.

    Raises
    ------
    SceneError
        For a scene with nothing to draw.
    RenderingError
        If the machine cannot render it.
    """
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(image_array(scene, size, theme)).save(buffer, "PNG")
    return buffer.getvalue()


def image_array(
    scene: Scene, size: tuple[int, int] = SIZE, theme: str = "light"
) -> np.ndarray:
    """Render a scene as an array.

    Parameters and errors are those of `png`.

    Returns
    -------
    ndarray of shape (height, width, 3)
        Image, uint8, of twice `size`.
    """
    if theme not in THEMES:
        raise InputError(f"theme: {theme!r}; give one of {', '.join(THEMES)}")
    look = THEMES[theme]
    width, height = (PIXELS_PER_PX * int(side) for side in size)
    entries = legend_entries(scene)
    rows = _legend_rows(entries, width)
    strip = PIXELS_PER_PX * (LINE_PX * len(rows) + 8 * bool(rows))
    if height - strip < 16:
        raise InputError(f"size: {size} px is too small (legend: {strip} px high)")
    shaded = render(scene, (width, height - strip), look)
    return _written(scene, shaded, rows, strip, look)


def render(scene, window, look=THEMES["light"]):
    """The scene without words, shaded: (height, width, 3) uint8 of `window` (w, h)."""
    need(rendering_missing())
    import pyvista as pv

    drawn = drawn_parts(scene)
    plotter = pv.Plotter(off_screen=True, window_size=list(window))
    try:
        plotter.set_background(look.background)
        add_drawn(plotter, drawn, look.ink)
        aim(plotter, scene)
        plotter.camera.view_angle = view_angle_deg(scene, *window)
        plotter.enable_anti_aliasing("ssaa")
        if any(part.opacity < 1 for part in drawn):
            # pyvista's own test would open a window.
            plotter.renderer.SetUseDepthPeeling(True)
            plotter.renderer.SetMaximumNumberOfPeels(N_PEELS)
            plotter.renderer.SetOcclusionRatio(0.0)
        return np.array(plotter.screenshot(return_img=True))[..., :3]
    finally:
        plotter.close()


def add_drawn(plotter, drawn, ink=INK):
    """Add meshes (`Drawn`) to a plotter; colour INK is replaced by `ink`."""
    from pyvista.plotting.opts import InterpolationType

    textures = {}
    for part in drawn:
        texture = None
        if part.texture is not None:
            # One image for all sheets that show it.
            key = id(part.texture)
            if key not in textures:
                textures[key] = _texture(part.texture)
            texture = textures[key]
        colour = ink if part.colour == INK else part.colour
        actor = plotter.add_mesh(
            part.mesh,
            color=None if texture else colour,
            opacity=part.opacity,
            texture=texture,
            culling=part.culled,
            smooth_shading=False,
            show_scalar_bar=False,
            reset_camera=False,
            render=False,
            **(PRINTED if texture else SHADING),
        )
        if part.mesh.point_data.active_normals is not None:
            actor.prop.interpolation = InterpolationType.PHONG


def aim(plotter, scene):
    """Point a plotter's camera at `look_at`."""
    sight = np.subtract(scene.view_from, scene.look_at).astype(float)
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.position = tuple(sight)
    plotter.camera.up = tuple(np.asarray(scene.up, float))
    plotter.camera.view_angle = VIEW_ANGLE_DEG
    plotter.camera.is_set = True
    plotter.renderer.ResetCameraClippingRange()


def _texture(array):
    import pyvista as pv

    array = np.asarray(array)
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    texture = pv.Texture(np.ascontiguousarray(array))
    texture.interpolate, texture.mipmap = True, True
    return texture


def legend_entries(scene):
    """(label, colour, is_sheet_or_ball) of each label of the parts, in their order."""
    entries = {}
    for part in scene.parts:
        if part.label and part.label not in entries and not isinstance(part, Labels):
            mark = "●" if isinstance(part, Points) else "━"
            mark = "■" if isinstance(part, Surface) else mark
            entries[part.label] = (part.label, part.colour, mark)
    return list(entries.values())


def _legend_rows(entries, width):
    """Return entries with positions along rows that fit into the image's width."""
    font = _font(FONT_PX)
    rows, x = [], 0
    for label, colour, mark in entries:
        wide = PIXELS_PER_PX * GAP_PX + font.getlength(mark + "  " + label)
        if not rows or x + wide > width - PIXELS_PER_PX * GAP_PX:
            rows.append([])
            x = PIXELS_PER_PX * GAP_PX
        rows[-1].append((x, label, colour, mark))
        x += wide
    return rows


def _written(scene, shaded, rows, strip, look):
    """Words of the labels on the image, and the legend below it."""
    from PIL import Image, ImageDraw

    height, width, _ = shaded.shape
    image = Image.new("RGB", (width, height + strip), look.background)
    image.paste(Image.fromarray(shaded), (0, 0))
    draw = ImageDraw.Draw(image)
    nominal = height / PIXELS_PER_PX / NOMINAL_PX
    for part in scene.parts:
        if isinstance(part, Labels):
            places = projected(scene, part.points, width, height)
            font = _font(part.size * max(nominal, 0.8))
            ink = look.ink if part.colour == INK else part.colour
            for place, text in zip(places, part.texts, strict=True):
                if np.isfinite(place).all():
                    draw.text(
                        tuple(place), text, ink, font, "mm",
                        stroke_width=2 * PIXELS_PER_PX, stroke_fill=look.background,
                    )  # fmt: skip
    font = _font(FONT_PX)
    for number, row in enumerate(rows):
        y = height + PIXELS_PER_PX * (LINE_PX * number + LINE_PX / 2)
        for x, label, colour, mark in row:
            draw.text((x, y), mark, colour, font, "lm")
            after = x + font.getlength(mark + " ")
            draw.text((after, y), label, look.ink, font, "lm")
    return np.asarray(image)


def _font(size_px):
    """The report's letters, from matplotlib's own files: the same on every machine."""
    import matplotlib
    from PIL import ImageFont

    path = f"{matplotlib.get_data_path()}/fonts/ttf/DejaVuSans.ttf"
    return ImageFont.truetype(path, PIXELS_PER_PX * size_px)


MAX_PAGE_BYTES = 3_000_000
OTHER_RENDERER = "trame.widgets.vtklocal"
HERE = Path(__file__).parent
REFERENCE = re.compile(r"^instance:\$\{(.*)\}$")
PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")
EPOCH = (1980, 1, 1, 0, 0, 0)


def html(scene: Scene, title: str) -> str:
    """Return the page of a scene, on which it can be rotated.

    The same scene gives the same page. OpenGL is not needed.

    Parameters
    ----------
    scene : Scene
        Scene to show.
    title : str
        Title that describes the scene.

    Returns
    -------
    str
        HTML text.

    Raises
    ------
    SceneError
        For a scene with nothing to draw, or a page larger than MAX_PAGE_BYTES.
    RenderingError
        If a package is missing.
    """
    need(packages_missing())
    drawn = drawn_parts(scene)
    viewer = StringIO()
    from trame_vtk.tools.vtksz2html import write_html

    write_html(_zipped(_numbered(_exported(scene, drawn))), viewer)
    text = _with_words(viewer.getvalue(), scene, title, drawn)
    size = len(text.encode())
    if size > MAX_PAGE_BYTES:
        raise SceneError(
            f"scene of {size} bytes exceeds {MAX_PAGE_BYTES}; use fewer points or "
            "a smaller texture"
        )
    return text


def _exported(scene, drawn):
    """Return pyvista's export as {hashes, scene}, in the format of its viewer."""
    import pyvista as pv

    plotter = pv.Plotter(off_screen=True)
    try:
        plotter.set_background(THEMES["light"].background)
        add_drawn(plotter, drawn)
        aim(plotter, scene)
        with _nothing_fetched():
            return json.loads(plotter.trame.export_vtksz(filename=None, format="json"))
    finally:
        plotter.close()


@contextlib.contextmanager
def _nothing_fetched():
    """Let trame not find its other renderer, for which it would ask the network."""
    before = sys.modules.get(OTHER_RENDERER)
    sys.modules[OTHER_RENDERER] = None
    try:
        yield
    finally:
        del sys.modules[OTHER_RENDERER]
        if before is not None:
            sys.modules[OTHER_RENDERER] = before


def _numbered(exported):
    """The export with its objects numbered in the order of their appearance."""
    numbers = {}

    def number(name):
        return numbers.setdefault(str(name), str(len(numbers) + 1))

    def walk(value, key=""):
        if isinstance(value, dict):
            return {k: walk(v, k) for k, v in value.items()}
        if isinstance(value, list):
            return [walk(part, key) for part in value]
        if key == "mtime":
            return 0
        if key == "type" and str(value).endswith("RenderWindow"):
            # The kind of the machine's windows is irrelevant in a browser.
            return "vtkRenderWindow"
        if key in ("id", "parent", "vtkRefId", "camera") and value is not None:
            return number(value)
        if isinstance(value, str) and (found := REFERENCE.match(value)):
            return f"instance:${{{number(found[1])}}}"
        return value

    return {"hashes": exported["hashes"], "scene": walk(exported["scene"])}


def _zipped(exported):
    buffer = BytesIO()
    with ZipFile(buffer, "w") as archive:
        entry = ZipInfo("index.json", EPOCH)
        entry.compress_type = ZIP_DEFLATED
        text = json.dumps(exported, separators=(",", ":"))
        archive.writestr(entry, text, compresslevel=9)
    return buffer.getvalue()


def _with_words(viewer, scene, title, drawn):
    """Return pyvista's page with title, legend, labels and note in its empty body."""
    contents = {
        "title": escape(title),
        "note": escape(scene.note),
        "legend": "\n".join(map(_legend_entry, legend_entries(scene))),
        "words": _words(scene, drawn),
        "script": (HERE / "page.js").read_text("utf-8"),
    }
    # All placeholders at once: inserted text may look like a placeholder.
    page = (HERE / "page.html").read_text("utf-8")
    body = PLACEHOLDER.sub(lambda place: contents[place[1]], page)
    head, rest = viewer.split("<body>", 1)
    head = re.sub(
        "<title>.*?</title>", lambda _: f"<title>{escape(title)}</title>", head
    )
    return f"{head}<body>\n{body}{rest}"


def _legend_entry(entry):
    label, colour, mark = entry
    said = escape(label)
    return (
        f'<label><input type="checkbox" checked value="{said}"> '
        f'<i style="color:{escape(_themed(colour))}">{mark}</i> {said}</label>'
    )


def _themed(colour):
    """Return a colour of the page's style: INK follows the theme."""
    return "var(--ink)" if colour == INK else colour


def _words(scene, drawn):
    """Return the input of the page's script as JSON: actors, texts, theme colours.

    Positions of texts are relative to `look_at`.
    """
    texts = [
        {
            "at": np.subtract(point, scene.look_at).astype(float).round(6).tolist(),
            "text": text,
            "colour": _themed(part.colour),
            "size": part.size,
            "label": part.label,
        }
        for part in scene.parts
        if isinstance(part, Labels)
        for point, text in zip(part.points, part.texts, strict=True)
        if np.isfinite(point).all()
    ]
    data = {
        "actors": [part.label for part in drawn],
        "inked": [part.texture is None and part.colour == INK for part in drawn],
        "texts": texts,
        "themes": {name: theme._asdict() for name, theme in THEMES.items()},
    }
    return json.dumps(data).replace("<", "\\u003c")
