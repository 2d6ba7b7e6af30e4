"""Scenes: surfaces with textures in front of a background, in one world frame, mm."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from raxel.geometry import transform
from raxel.lab.surfaces import Rectangle, TracedSurface
from raxel.lab.textures import Panels, Texture

# Parts for rays that meet no surface, and for positions without a ray.
NOTHING, NO_RAY = -1, -2


@dataclass(frozen=True)
class TexturedScene:
    """What a camera can view: surfaces with textures in front of a background.

    Attributes
    ----------
    parts : tuple of (TracedSurface, Texture)
        Surfaces in the world frame, mm, each with its texture.
    background : float or (float, float, float)
        Radiance, a number or RGB, of rays that meet nothing.
    straight_edges : (n, 2, 3) array
        Ends of straight edges in the world, mm, that stand out in the image. They serve
        to measure how straight the edges are in the image.
    """

    parts: tuple[tuple[TracedSurface, Texture], ...]
    background: float | tuple[float, float, float] = 0.0
    straight_edges: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 3)))

    @property
    def surfaces(self) -> tuple[TracedSurface, ...]:
        """The surfaces alone, in the order of `parts`."""
        return tuple(surface for surface, _ in self.parts)

    @property
    def textures(self) -> tuple[Texture, ...]:
        """The textures alone, in the order of `parts`."""
        return tuple(texture for _, texture in self.parts)

    def hit(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.int16], NDArray[np.float64], NDArray[np.float64]]:
        """Return the nearest surface of each ray.

        Parameters
        ----------
        origins : (N, 3) or (1, 3) array
            Origins in the world frame, mm.
        directions : (N, 3) array
            Unit directions in the world frame.

        Returns
        -------
        index : (N,) int16 array
            Index of the part, or NOTHING (-1).
        uv : (N, 2) array
            Position on that surface, mm.
        cosine : (N,) array
            Cosine of the angle between ray and normal.
        """
        index = np.full(len(directions), NOTHING, np.int16)
        if not self.parts:
            return index, np.zeros((len(index), 2)), np.zeros(len(index))
        nearest = None
        for number, surface in enumerate(self.surfaces):
            hit = surface.hit(origins, directions)
            if nearest is None:
                nearest, uv, cosine = hit
                index[np.isfinite(nearest)] = number
                continue
            closer = np.flatnonzero(hit.distance < nearest)
            nearest[closer] = hit.distance[closer]
            uv[closer], cosine[closer] = hit.uv[closer], hit.cosine[closer]
            index[closer] = number
        return index, uv, cosine


# Pieces that rooms and fronts are built of.


RIGHT, DOWN, AHEAD = np.eye(3)


def wall(corner, right, down, width, height, ground, patches=()):
    """Return (Rectangle, Panels): a wall in front view, uv from its upper left corner.

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
    """Return patches of a window: its frame, and panes (columns, rows) with bars.

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
