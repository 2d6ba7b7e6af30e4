"""A run of CELECT, step by step, as a drawing that plays when it is clicked."""

import base64

import cv2
import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import Run, line_ends
from repro.page.reader import Shown
from repro.page.style import series

STEP_S = 0.14
BLUE, RED, GREEN = (series(i)["color"] for i in range(3))
YELLOW = series(5)["color"]
MARGIN_PX = 15
QUALITY = 70


def animation(result):
    """The recorded run as an SVG: a click plays it, another plays it again.

    Without a click it shows the end of the run, so nothing moves by itself.
    """
    run = Run(result)
    low, high = window_of(run)
    pieces = [
        f'<image href="{embedded(run.image, low, high)}" x="{low[0]}" '
        f'y="{low[1]}" width="{high[0] - low[0]}" '
        f'height="{high[1] - low[1]}"/>'
    ]
    for index in range(len(run.steps)):
        pieces += step_marks(run, index)
    end = len(run.steps) * STEP_S
    pieces += [
        f'<circle cx="{u:.1f}" cy="{v:.1f}" r="3.2" fill="none" '
        f'stroke="{GREEN}" stroke-width="1.4">{from_time(end)}</circle>'
        for _, u, v in run.merged
    ]
    size = high - low
    svg = (
        f'<svg id="celect_run" role="img" tabindex="0" '
        f'viewBox="{low[0]} {low[1]} {size[0]} {size[1]}" '
        'style="width:100%;max-width:36rem;cursor:pointer" '
        'xmlns="http://www.w3.org/2000/svg">'
        "<title>A run of CELECT, step by step: click to play</title>"
        + "".join(pieces)
        + button(low, end)
        + "</svg>"
    )
    caption = (
        f"The run of Fig. 3.1, {len(run.steps)} windows. Click the picture to "
        "play it. Circle: window; red: the line followed; crosses: candidate "
        "corners; green: corners after merging."
    )
    page = f"<figure>{svg}<figcaption>{caption}</figcaption></figure>"
    return Shown(page, page)


def window_of(run):
    """First and last pixel (2,) of the part of the image that is shown."""
    grid = run.grid.reshape(-1, 2)
    reach = run.steps[:, 3].max() + MARGIN_PX
    height, width = run.image.shape
    low = np.maximum(np.floor(grid.min(axis=0) - reach), 0).astype(int)
    high = np.minimum(np.ceil(grid.max(axis=0) + reach), (width, height))
    return low, high.astype(int)


def embedded(image, low, high):
    """A part of the image as a data address."""
    part = image[low[1] : high[1], low[0] : high[0]]
    _, jpeg = cv2.imencode(".jpg", part, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()


def step_marks(run, index):
    """Window and line of a step, shown while it lasts; candidates and path stay."""
    centre, radius, line, anchor = run.step(index)
    start = index * STEP_S
    (a, b), (c, d) = line_ends(centre, radius, line)
    for_now = (
        f'<set attributeName="visibility" to="visible" dur="{STEP_S:.2f}s" '
        f'begin="celect_run.click+{start:.2f}s"/>'
    )
    marks = [
        f'<g visibility="hidden">{for_now}<circle cx="{centre[0]:.1f}" '
        f'cy="{centre[1]:.1f}" r="{radius:.1f}" fill="none" '
        f'stroke="{YELLOW}" stroke-width="2"/><path d="M{a:.1f} {b:.1f}L'
        f'{c:.1f} {d:.1f}" stroke="{RED}" stroke-width="2"/></g>'
    ]
    crosses = "".join(
        f"M{u - 2:.0f} {v - 2:.0f}l4 4m0-4l-4 4"
        for u, v in run.of_step("corners", index)
    )
    marks.append(
        f'<path d="M{centre[0]:.1f} {centre[1]:.1f}L{anchor[0]:.1f} '
        f'{anchor[1]:.1f}" stroke="{YELLOW}" stroke-width="1.2" fill="none">'
        f"{from_time(start)}</path>"
    )
    if crosses:
        marks.append(
            f'<path d="{crosses}" stroke="{RED}" stroke-width="1" '
            f'fill="none">{from_time(start)}</path>'
        )
    return marks


def from_time(start):
    """Hidden from the click on until `start` seconds after it."""
    if start == 0:
        return ""
    return (
        '<set attributeName="visibility" to="hidden" begin="celect_run.click" '
        f'dur="{start:.2f}s"/>'
    )


def button(low, end):
    """A sign that the picture can be played, away while it plays."""
    x, y = low + [10, 10]
    return (
        f'<g><set attributeName="visibility" to="hidden" '
        f'begin="celect_run.click" dur="{end:.2f}s"/>'
        f'<circle cx="{x + 14}" cy="{y + 14}" r="14" fill="white" '
        f'fill-opacity="0.85" stroke="{BLUE}"/>'
        f'<path d="M{x + 10} {y + 7}v14l12-7z" fill="{BLUE}"/></g>'
    )
