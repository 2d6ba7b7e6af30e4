"""3-D scenes of `raxel.show` in a figure, and on a page.

Without pyvista or OpenGL, the build continues: the figure names what is missing and the
command that installs it.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from raxel.io.rendering import rendering_missing
from raxel.show import Scene, html, image_array
from raxel.show.rendering import PIXELS_PER_PX
from raxel.show.rendering import render as shaded_scene
from repro.page.style import new_figure
from repro.page.templates import render

CSS_PX_PER_INCH = 96


def draw_scene(axes: Axes, scene: Scene, *, words: bool = True) -> None:
    """Fill ``axes`` with the rendered image of a scene.

    The position of the axes is fixed first: call it last, or set the position manually.
    Without ``words``, no legend and no names are drawn: for small panels.
    """
    axes.set_axis_off()
    missing = rendering_missing()
    if missing:
        reason = textwrap.fill(missing, 34)
        axes.text(0.5, 0.5, reason, ha="center", va="center", transform=axes.transAxes)
        return
    drawn = axes.figure
    layout = drawn.get_layout_engine()
    if layout:
        layout.execute(drawn)
    place = axes.get_window_extent().transformed(drawn.dpi_scale_trans.inverted())
    size = [round(CSS_PX_PER_INCH * side) for side in (place.width, place.height)]
    if words:
        shaded = image_array(scene, size)
    else:
        shaded = shaded_scene(scene, [PIXELS_PER_PX * side for side in size])
    # With an alpha channel, which matplotlib would otherwise add at each drawing.
    shown = np.pad(shaded, ((0, 0), (0, 0), (0, 1)), constant_values=255)
    axes.imshow(shown, interpolation="none", aspect="equal")


def scene_figure(scene: Scene, height_in: float) -> Figure:
    """Return a figure of the report's width, filled with the image of a scene."""
    drawn, axes = new_figure(height_in=height_in)
    drawn.set_layout_engine("none")
    axes.set_position([0.0, 0.0, 1.0, 1.0])
    draw_scene(axes, scene)
    return drawn


def scene_frames(scenes: Sequence[Scene], size: tuple[int, int]) -> list[np.ndarray]:
    """Return images of scenes, for a video: (height, width, 3) uint8 of ``size``, px.

    Without OpenGL they are white; the page's figure states what is missing.
    """
    if rendering_missing():
        return [np.full((size[1], size[0], 3), 255, np.uint8) for _ in scenes]
    return [
        cv2.resize(image_array(scene, size), size, interpolation=cv2.INTER_AREA)
        for scene in scenes
    ]


def scene_page(scene: Scene, title: str) -> str:
    """Return the interactive page of a scene; without OpenGL, a page with the reason.

    ``title`` describes the scene in words.
    """
    missing = rendering_missing()
    if missing:
        return render("no_scene", title=title, reason=missing)
    return html(scene, title)
