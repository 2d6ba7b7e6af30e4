"""Pieces that rooms and fronts are built of."""

import numpy as np

from raxel.geometry import transform
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import Panels

RIGHT, DOWN, AHEAD = np.eye(3)


def wall(corner, right, down, width, height, ground, patches=()):
    """(Rectangle, Panels): a wall seen from the front, uv from its upper left corner.

    corner: (3,) of the upper left; right, down: (3,) unit along u and v; patches as in
    `Panels`.
    """
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2] = right, down, np.cross(right, down)
    T[:3, 3] = corner
    return Rectangle(T, width, height), Panels(ground, patches)


def patch_edges(rectangle, patches):
    """The four sides of each patch on a wall as segments (n, 2, 3) in the world."""
    sides = []
    for x0, y0, x1, y1, *_ in patches:
        ring = [(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)]
        sides += [(ring[k], ring[(k + 1) % 4]) for k in range(4)]
    sides = np.array(sides, float).reshape(-1, 2, 3)
    return transform(rectangle.T_world_surface, sides)


def window(x, y, width, height, panes, frame, pane_colours, frame_colour):
    """Patches of a window: its frame, and panes (columns, rows) with bars between.

    x, y: upper left corner; frame: width of frame and bars, mm. The first patch is the
    whole window.
    """
    columns, rows = panes
    across = (width - (columns + 1) * frame) / columns
    down = (height - (rows + 1) * frame) / rows
    patches = [(x, y, x + width, y + height, frame_colour)]
    for row in range(rows):
        for column in range(columns):
            left = x + frame + column * (across + frame)
            top = y + frame + row * (down + frame)
            colour = pane_colours[(row + column) % len(pane_colours)]
            patches.append((left, top, left + across, top + down, colour))
    return patches


def shaded(patches, tone):
    """Patches with their colours darkened by one factor."""
    return [(*patch[:4], tuple(tone * np.asarray(patch[4]))) for patch in patches]
