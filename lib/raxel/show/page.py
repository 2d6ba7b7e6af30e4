"""A scene as one page on which it turns: pyvista's own export, with legend and words.

The page loads nothing and works from the disk. The export numbers its objects by their
places in memory and stamps times; here they are numbered in order, so that the same
scene is the same page.
"""

import contextlib
import json
import re
import sys
from html import escape
from io import BytesIO, StringIO
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np

from raxel.io.rendering import need, packages_missing
from raxel.show.meshes import drawn_parts
from raxel.show.picture import THEMES, add_drawn, aim, legend_entries
from raxel.show.scene import Labels, SceneError
from raxel.show.view import INK

LARGEST_BYTES = 3_000_000
OTHER_RENDERER = "trame.widgets.vtklocal"
HERE = Path(__file__).parent
REFERENCE = re.compile(r"^instance:\$\{(.*)\}$")
PLACE = re.compile(r"\{\{(\w+)\}\}")
EPOCH = (1980, 1, 1, 0, 0, 0)


def html(scene, title):
    """The page of a scene as text; `title` says in words what it shows.

    The same scene gives the same page. Raises SceneError for a scene with nothing to
    draw or whose page would be larger than LARGEST_BYTES, and RenderingError where a
    package is missing; OpenGL is not needed.
    """
    need(packages_missing())
    drawn = drawn_parts(scene)
    viewer = StringIO()
    from trame_vtk.tools.vtksz2html import write_html

    write_html(_zipped(_numbered(_exported(scene, drawn))), viewer)
    text = _with_words(viewer.getvalue(), scene, title, drawn)
    size = len(text.encode())
    if size > LARGEST_BYTES:
        raise SceneError(
            f"scene of {size} bytes, {LARGEST_BYTES} at most; give it fewer points or "
            "a smaller texture"
        )
    return text


def _exported(scene, drawn):
    """What pyvista exports: {hashes, scene}, as its viewer reads it."""
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
            # Of what kind a machine's windows are does not matter to a browser.
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
    """pyvista's page with title, legend, labels and note in place of its empty body."""
    contents = {
        "title": escape(title),
        "note": escape(scene.note),
        "legend": "\n".join(map(_legend_entry, legend_entries(scene))),
        "words": _words(scene, drawn),
        "script": (HERE / "page.js").read_text("utf-8"),
    }
    # All places at once: what is filled in may look like a place itself.
    page = (HERE / "page.html").read_text("utf-8")
    body = PLACE.sub(lambda place: contents[place[1]], page)
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
    """A colour of the page's style: what has the colour INK follows the theme."""
    return "var(--ink)" if colour == INK else colour


def _words(scene, drawn):
    """What the page's script reads, as JSON: actors, texts, and the colours of themes.

    Texts have their places about `look_at`.
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
