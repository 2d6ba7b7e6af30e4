"""The picture of a scene: shaded by pyvista off screen, with words and legend on it."""

from io import BytesIO
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.io.rendering import need, rendering_missing
from raxel.show.meshes import drawn_parts
from raxel.show.scene import Labels, Points, Surface
from raxel.show.view import INK, NOMINAL_PX, VIEW_ANGLE_DEG, projected, view_angle_deg

# Width and height on a page, px; the file has FINER times as many each way.
SIZE = (720, 480)
FINER = 2
# Light enough for paper, solid enough for shape: matt, with a soft highlight.
SHADING = {"ambient": 0.35, "diffuse": 0.65, "specular": 0.0}
PRINTED = {"ambient": 0.85, "diffuse": 0.15, "specular": 0.0}
PEELS = 8
FONT_PX, LINE_PX, GAP_PX = 13, 21, 18


class Theme(NamedTuple):
    """background, words and their halo."""

    background: str
    ink: str


THEMES = {"light": Theme("#ffffff", INK), "dark": Theme("#14181e", "#e6e9ed")}


def picture(scene, size=SIZE, theme="light"):
    """PNG bytes of a scene, the same for the same scene on the same machine.

    size: (width, height) at which it is shown, px; it has twice as many each way.
    theme: 'light' or 'dark'. Raises SceneError for a scene with nothing to draw, and
    RenderingError where the machine cannot draw it.
    """
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(picture_array(scene, size, theme)).save(buffer, "PNG")
    return buffer.getvalue()


def picture_array(scene, size=SIZE, theme="light"):
    """What `picture` shows, as an array (height, width, 3), uint8, of twice `size`."""
    if theme not in THEMES:
        raise InputError(f"theme: found {theme!r}; give one of {', '.join(THEMES)}")
    look = THEMES[theme]
    width, height = (FINER * int(side) for side in size)
    entries = legend_entries(scene)
    rows = _legend_rows(entries, width)
    strip = FINER * (LINE_PX * len(rows) + 8 * bool(rows))
    if height - strip < 16:
        raise InputError(f"size: found {size}; the legend alone is {strip} px high")
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
            # pyvista's own way draws a window first, to see whether that works.
            plotter.renderer.SetUseDepthPeeling(True)
            plotter.renderer.SetMaximumNumberOfPeels(PEELS)
            plotter.renderer.SetOcclusionRatio(0.0)
        return np.array(plotter.screenshot(return_img=True))[..., :3]
    finally:
        plotter.close()


def add_drawn(plotter, drawn, ink=INK):
    """Put meshes (`Drawn`) into a plotter; what has the colour INK gets `ink`."""
    from pyvista.plotting.opts import InterpolationType

    textures = {}
    for part in drawn:
        texture = None
        if part.texture is not None:
            # One picture for all sheets that show it.
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
    """Point a plotter's camera at what lies about `look_at`."""
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
    """Entries with their places along rows that fit into the picture's width."""
    font = _font(FONT_PX)
    rows, x = [], 0
    for label, colour, mark in entries:
        wide = FINER * GAP_PX + font.getlength(mark + "  " + label)
        if not rows or x + wide > width - FINER * GAP_PX:
            rows.append([])
            x = FINER * GAP_PX
        rows[-1].append((x, label, colour, mark))
        x += wide
    return rows


def _written(scene, shaded, rows, strip, look):
    """Words of the labels on the picture, and the legend below it."""
    from PIL import Image, ImageDraw

    height, width, _ = shaded.shape
    image = Image.new("RGB", (width, height + strip), look.background)
    image.paste(Image.fromarray(shaded), (0, 0))
    draw = ImageDraw.Draw(image)
    nominal = height / FINER / NOMINAL_PX
    for part in scene.parts:
        if isinstance(part, Labels):
            places = projected(scene, part.points, width, height)
            font = _font(part.size * max(nominal, 0.8))
            ink = look.ink if part.colour == INK else part.colour
            for place, text in zip(places, part.texts, strict=True):
                if np.isfinite(place).all():
                    draw.text(
                        tuple(place), text, ink, font, "mm",
                        stroke_width=2 * FINER, stroke_fill=look.background,
                    )  # fmt: skip
    font = _font(FONT_PX)
    for number, row in enumerate(rows):
        y = height + FINER * (LINE_PX * number + LINE_PX / 2)
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
    return ImageFont.truetype(path, FINER * size_px)
