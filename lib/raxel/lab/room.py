"""A furnished room with many straight edges, seen from its middle."""

from itertools import chain

import numpy as np

from raxel.geometry import pose
from raxel.lab.interior import AHEAD, DOWN, RIGHT, patch_edges, shaded, wall, window
from raxel.lab.scene import TexturedScene
from raxel.lab.surfaces import Cylinder, Rectangle, box
from raxel.lab.textures import Panels, Plain, Tiles

PLASTER, SKIRTING, WHITE = (0.86, 0.78, 0.62), (0.30, 0.17, 0.09), (0.90, 0.90, 0.88)
SKY = [(0.62, 0.82, 1.10), (0.66, 0.85, 1.12), (0.70, 0.88, 1.12)]
WOOD, DARK_WOOD, BRASS = (0.42, 0.22, 0.10), (0.20, 0.10, 0.05), (0.75, 0.55, 0.15)
BOOKS = [
    (0.50, 0.07, 0.06),
    (0.07, 0.20, 0.42),
    (0.10, 0.33, 0.14),
    (0.72, 0.52, 0.12),
    (0.36, 0.12, 0.32),
    (0.78, 0.74, 0.64),
    (0.08, 0.36, 0.38),
]
GOLDEN = (np.sqrt(5) - 1) / 2


def room(width=5000.0, depth=6000.0, height=2700.0, eye=1300.0):
    """A room, mm; the same at every call.

    World frame: origin in the middle of the room at `eye` above the floor, x right, y
    down, z ahead. Ahead: two windows; right: a bookcase; behind: pictures and a
    cupboard; left: a door and a picture; tiles on the floor, a table, a column.
    Straight edges: joints of the walls, window, door, picture and shelf frames.
    """
    left, back, top = -width / 2, -depth / 2, eye - height
    walls = [
        _ahead(np.array([left, top, -back]), width, height),
        _right(np.array([-left, top, -back]), depth, height),
        _behind(np.array([-left, top, back]), width, height),
        _left(np.array([left, top, back]), depth, height),
    ]
    parts = [part for part, _ in walls]
    edges = [patch_edges(part[0], framed) for part, framed in walls]
    edges += [part[0].outline for part in parts]
    parts += [_floor(left, eye, back), _ceiling(left, top, back)]
    parts += _table(eye) + _column(np.array([1700.0, eye, -1500.0]), height)
    return TexturedScene(tuple(parts), 0.0, np.concatenate(edges))


def _ahead(corner, width, height):
    frames = [
        window(x, 600, 1300, 1300, (2, 3), 60, SKY, WHITE)
        for x in (0.14 * width, 0.86 * width - 1300)
    ]
    sills = [(f[0][0] - 80, 1900, f[0][2] + 80, 1960, SKIRTING) for f in frames]
    patches = [(0, height - 120, width, height, SKIRTING), *chain(*frames), *sills]
    part = wall(corner, RIGHT, DOWN, width, height, PLASTER, patches)
    return part, list(chain(*frames))


def _right(corner, depth, height):
    x, y, shelf = 900.0, 400.0, 380.0
    patches = [(0, height - 120, depth, height, SKIRTING)]
    patches.append((x, y, x + 4200, height, WOOD))
    niches = [
        (x + 40 + 1380 * i, y + 40 + shelf * j, x + 1380 * (i + 1), y + shelf * (j + 1))
        for i in range(3)
        for j in range(6)
    ]
    for number, niche in enumerate(niches):
        patches.append((*niche, DARK_WOOD))
        patches += _books(niche, number)
    patches = shaded(patches, 0.9)
    ground = tuple(0.9 * np.array(PLASTER))
    part = wall(corner, -AHEAD, DOWN, depth, height, ground, patches)
    return part, [patches[1], *niches]


def _books(niche, number):
    """Backs of books side by side, of widths and heights that vary without chance."""
    x0, y0, x1, y1 = niche
    x, books, k = x0 + 5, [], 31 * number
    # Every fifth niche is half empty.
    end = x1 if number % 5 else (x0 + x1) / 2
    while True:
        one, two = (k * GOLDEN) % 1.0, (k * GOLDEN * GOLDEN * 7) % 1.0
        wide = 40 + 60 * one
        if x + wide > end - 5:
            return books
        colour = BOOKS[int(len(BOOKS) * ((k * 0.7548777) % 1.0))]
        books.append((x, y1 - (y1 - y0) * (0.62 + 0.3 * two), x + wide, y1, colour))
        x, k = x + wide + 3, k + 1


def _behind(corner, width, height):
    pictures = [
        _picture(500, 600, 1100, 800, BOOKS[0], BOOKS[3]),
        _picture(width - 1500, 500, 900, 1100, BOOKS[1], BOOKS[6]),
    ]
    patches = [(0, height - 120, width, height, SKIRTING), *chain(*pictures)]
    base = height - 900
    doors = [(1900 + 600 * k, base, 2480 + 600 * k, height - 60) for k in range(2)]
    patches.append((1880, base - 40, 3100, height, WOOD))
    patches += [(*door, (0.52, 0.30, 0.15)) for door in doors]
    patches = shaded(patches, 0.72)
    ground = tuple(0.72 * np.array(PLASTER))
    part = wall(corner, -RIGHT, DOWN, width, height, ground, patches)
    return part, [picture[0] for picture in pictures] + doors


def _left(corner, depth, height):
    door = (900.0, height - 2050, 1800.0, height, (0.16, 0.34, 0.36))
    frame = (820.0, height - 2130, 1880.0, height, WHITE)
    fields = [
        (
            1000 + 370 * i,
            door[1] + 120 + 950 * j,
            1300 + 370 * i,
            door[1] + 900 + 950 * j,
        )
        for i in range(2)
        for j in range(2)
    ]
    fields = [(*f, (0.22, 0.46, 0.48)) for f in fields]
    handle = (1680.0, height - 1080, 1760.0, height - 1040, BRASS)
    picture = _picture(2700, 600, 1500, 1000, BOOKS[2], SKY[0])
    patches = [(0, height - 120, depth, height, SKIRTING), frame, door, *fields]
    patches = shaded([*patches, handle, *picture], 0.82)
    ground = tuple(0.82 * np.array(PLASTER))
    part = wall(corner, AHEAD, DOWN, depth, height, ground, patches)
    return part, [frame, door, *fields, picture[0]]


def _picture(x, y, width, height, colour, other):
    """A gilt frame, a mount, and a picture of horizontal bands."""
    inner = (x + 130, y + 130, x + width - 130, y + height - 130)
    third = (inner[3] - inner[1]) / 3
    return [
        (x, y, x + width, y + height, BRASS),
        (x + 50, y + 50, x + width - 50, y + height - 50, WHITE),
        (*inner, colour),
        (inner[0], inner[1] + third, inner[2], inner[1] + 2 * third, other),
    ]


def _floor(left, eye, back):
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, -AHEAD, DOWN])
    T[:3, 3] = [left, eye, -back]
    tiles = Tiles(
        (500, 500), [(0.55, 0.27, 0.17), (0.80, 0.72, 0.58)], 12, (0.3, 0.28, 0.25)
    )
    return Rectangle(T, -2 * left, -2 * back), tiles


def _ceiling(left, top, back):
    T = np.eye(4)
    T[:3, :3] = np.column_stack([RIGHT, AHEAD, -DOWN])
    T[:3, 3] = [left, top, back]
    width, depth = -2 * left, -2 * back
    lamps = [
        (width / 2 - 150, y - 700, width / 2 + 150, y + 700, (1.25, 1.22, 1.1))
        for y in (depth / 4, 3 * depth / 4)
    ]
    beams = [
        (0, y - 60, width, y + 60, (0.50, 0.33, 0.20))
        for y in (depth / 2, 0.02 * depth, 0.98 * depth)
    ]
    return Rectangle(T, width, depth), Panels((0.80, 0.80, 0.78), beams + lamps)


def _table(eye):
    """A table ahead on the left: top of one box, four round legs."""
    corner, size, legs = (
        np.array([-1900.0, eye - 740, 900.0]),
        (1500.0, 40.0, 850.0),
        35,
    )
    tones = {0: 0.75, 1: 1.25, 2: 0.9}
    parts = []
    for number, face in enumerate(box(pose(np.eye(3), corner), size)):
        tone = tones[number % 3]
        parts.append((face, Plain(tuple(tone * np.array(WOOD)))))
    upright = np.column_stack([RIGHT, AHEAD, -DOWN])
    for x in (60, size[0] - 60):
        for z in (60, size[2] - 60):
            foot = corner + [x, 740, z]
            parts.append((Cylinder(pose(upright, foot), legs, 700), Plain(DARK_WOOD)))
    return parts


def _column(foot, height):
    """A round column with stripes, to the right behind the camera."""
    upright = np.column_stack([RIGHT, AHEAD, -DOWN])
    radius = 170.0
    turn = np.pi * radius
    ribs = 12
    step = 2 * turn / ribs
    flutes = [
        (-turn + step * (k + 0.2), 150, -turn + step * (k + 0.8), height - 150)
        for k in range(ribs)
    ]
    flutes = [(*flute, (0.62, 0.60, 0.56)) for flute in flutes]
    return [
        (
            Cylinder(pose(upright, foot), radius, height),
            Panels((0.80, 0.78, 0.74), flutes),
        )
    ]
