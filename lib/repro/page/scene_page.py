"""A scene as one page: data and viewer in a single file that loads nothing else.

The viewer (`repro/page/viewer`) is a few kilobytes of WebGL, so that every scene
carries its own and works from a disk, on its own, for ever. Writing one draws nothing
and needs neither a display nor OpenGL; the same scene gives the same bytes.
"""

from __future__ import annotations

import base64
import html
import json
from io import BytesIO
from pathlib import Path

import numpy as np

from repro.page.scene import Part, Points, Polyline, Scene, SceneError, Surface

VIEWER = Path(__file__).with_name("viewer")
FILES = ("page.html", "viewer.js")
LARGEST_BYTES = 1_500_000


def scene_html(scene: Scene, title: str) -> str:
    """The page of a scene; ``title`` says in words what it shows.

    Raises `SceneError` where nothing of it is finite, or the page would be too large
    for a site that is handed on.
    """
    data = json.dumps(_described(scene), separators=(",", ":")).replace("<", "\\u003c")
    page, viewer = ((VIEWER / name).read_text("utf-8") for name in FILES)
    for name, content in (
        ("{{title}}", html.escape(title)),
        ("{{note}}", html.escape(scene.note)),
        ("{{viewer}}", viewer),
        ("{{scene}}", data),
    ):
        page = page.replace(name, content)
    size = len(page.encode())
    if size > LARGEST_BYTES:
        raise SceneError(
            f"scene of {size} bytes, {LARGEST_BYTES} at most; give it fewer points or "
            "a smaller texture"
        )
    return page


def _described(scene: Scene) -> dict:
    """Scene for the viewer, about ``look_at`` so that single precision is enough."""
    centre = np.asarray(scene.look_at, dtype=float)
    parts = [_part(part, centre) for part in scene.parts]
    parts = [part for part in parts if part["count"]]
    if not parts:
        raise SceneError("Scene: no part has a finite point")
    return {
        "parts": parts,
        "eye": (np.asarray(scene.view_from, dtype=float) - centre).tolist(),
        "up": np.asarray(scene.up, dtype=float).tolist(),
        "radius": max(part.pop("radius") for part in parts),
    }


def _part(part: Part, centre: np.ndarray) -> dict:
    from matplotlib.colors import to_rgb

    common = {"label": part.label, "colour": [round(c, 4) for c in to_rgb(part.colour)]}
    if isinstance(part, Surface):
        return common | _surface(part, centre)
    if isinstance(part, Points):
        points = np.asarray(part.points, dtype=float) - centre
        points = points[np.isfinite(points).all(axis=1)]
        return common | {"kind": "points", "size": part.size} | _points(points)
    if isinstance(part, Polyline):
        points = np.asarray(part.points, dtype=float)
        starts, ends = points[:-1], points[1:]
    else:
        starts, ends = (np.asarray(p, dtype=float) for p in (part.starts, part.ends))
    pairs = np.stack([starts, ends], axis=1) - centre
    pairs = pairs[np.isfinite(pairs).all(axis=(1, 2))]
    found = _points(pairs.reshape(-1, 3))
    return common | {"kind": "lines", "size": part.width} | found


def _points(points: np.ndarray) -> dict:
    return {
        "count": len(points),
        "points": _base64(points.astype("<f4").tobytes()),
        "radius": float(np.linalg.norm(points, axis=1).max(initial=0)),
    }


def _surface(part: Surface, centre: np.ndarray) -> dict:
    """Two triangles a cell; those with a corner that is not finite are left out."""
    lattice = np.asarray(part.points, dtype=float) - centre
    rows, columns, _ = lattice.shape
    finite = np.isfinite(lattice).all(axis=2).ravel()
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2)
    triangles = triangles.reshape(-1, 3)
    triangles = triangles[finite[triangles].all(axis=1)]
    points = np.where(finite[:, None], lattice.reshape(-1, 3), 0.0)
    found = _points(points) | {
        "kind": "surface",
        "count": 3 * len(triangles),
        "triangles": _base64(triangles.astype("<u4").tobytes()),
        "opacity": part.opacity,
    }
    if part.texture is not None:
        found |= {"shape": [rows, columns], "texture": _png(part.texture)}
    return found


def _png(texture: np.ndarray) -> str:
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(texture).save(buffer, "PNG", optimize=True)
    return "data:image/png;base64," + _base64(buffer.getvalue())


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()
