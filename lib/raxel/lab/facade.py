"""A building front with rows of windows and long vertical lines."""

from itertools import chain

import numpy as np

from raxel.lab.interior import AHEAD, DOWN, RIGHT, patch_edges, wall, window
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Rectangle
from raxel.lab.textures import Tiles

STONE, BRICK, TRIM = (0.72, 0.64, 0.50), (0.46, 0.20, 0.13), (0.85, 0.82, 0.74)
GLASS = [(0.10, 0.16, 0.24), (0.16, 0.24, 0.34)]
SLATE, DOOR, PAVING = (0.16, 0.18, 0.22), (0.10, 0.28, 0.16), (0.42, 0.42, 0.42)
SKY = (0.55, 0.74, 1.0)


def facade(bays=7, storeys=4, bay=3400.0, storey=3600.0):
    """A front of bays x storeys windows, mm; the same at every call.

    World frame: origin at the foot of the front's middle, x right, y down (the house
    stands at negative y), z ahead, into the house: a camera stands at negative z.
    Straight edges: sides of pilasters, cornices, windows, and of the front; those
    along (0, 1, 0) are vertical.
    """
    width, height = bays * bay, storeys * storey + 900
    corner = np.array([-width / 2, -height, 0.0])
    pilasters = _pilasters(bays, bay, height)
    cornices = [(0, 0, width, 350, TRIM)]
    for level in range(1, storeys):
        y = height - level * storey
        cornices.append((0, y - 130, width, y + 130, TRIM))
    plinth = (0, height - 700, width, height, STONE)
    openings = _openings(bays, storeys, bay, storey, height)
    patches = [plinth, *cornices, *pilasters, *chain(*openings)]
    front = wall(corner, RIGHT, DOWN, width, height, BRICK, patches)
    outer = [opening[0] for opening in openings]
    edges = [patch_edges(front[0], pilasters + cornices + outer), front[0].outline]
    parts = [front, *_neighbours(width, height), _street()]
    return TexturedScene(tuple(parts), SKY, np.concatenate(edges))


def _pilasters(bays, bay, height):
    """Light strips from plinth to cornice between the bays and at both ends."""
    half = 190.0
    middles = [min(max(k * bay, half), bays * bay - half) for k in range(bays + 1)]
    return [(x - half, 350, x + half, height - 700, TRIM) for x in middles]


def _openings(bays, storeys, bay, storey, height):
    openings = []
    for level in range(storeys):
        for k in range(bays):
            middle = (k + 0.5) * bay
            if level == 0 and k == bays // 2:
                openings.append(_door(middle, height))
                continue
            tall = 2000.0 - 150 * level
            sill = height - level * storey - 950
            frame = window(
                middle - 650, sill - tall, 1300, tall, (2, 3), 70, GLASS, TRIM
            )
            ledge = (middle - 800, sill, middle + 800, sill + 120, STONE)
            openings.append([*frame, ledge])
    return openings


def _door(middle, height):
    top = height - 2900
    leaves = [
        (middle - 640 + 660 * k, top + 500, middle - 20 + 660 * k, height, DOOR)
        for k in range(2)
    ]
    light = (middle - 640, top + 100, middle + 640, top + 440, GLASS[1])
    return [(middle - 760, top, middle + 760, height, TRIM), light, *leaves]


def _neighbours(width, height):
    """Lower houses to both sides, a little behind the front's line."""
    houses = []
    for side, colour, lower in ((-1, STONE, 2600.0), (1, (0.60, 0.46, 0.42), 4200.0)):
        tall, wide = height - lower, 14000.0
        x = -width / 2 - wide if side < 0 else width / 2
        frames = [
            window(1500 + 2800 * i, y, 1200, 1700, (1, 2), 80, GLASS, TRIM)
            for i in range(4)
            for y in np.arange(900.0, tall - 2600, 3300)
        ]
        patches = [(0, 0, wide, 260, SLATE), *chain(*frames)]
        corner = np.array([x, -tall, 400.0])
        houses.append(wall(corner, RIGHT, DOWN, wide, tall, colour, patches))
    return houses


def _street():
    """Paving in front of the houses, 30 m deep."""
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, -AHEAD, DOWN])
    T[:3, 3] = [-30000, 0, 600]
    slabs = Tiles(
        (1500, 1000), [PAVING, (0.50, 0.49, 0.47)], 30, (0.26, 0.26, 0.26), 0.5
    )
    return Rectangle(T, 60000, 30000), slabs
