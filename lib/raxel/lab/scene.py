"""A scene: surfaces with textures before a background, in one world frame, mm."""

from dataclasses import dataclass, field

import numpy as np

from raxel.lab.surfaces import TracedSurface
from raxel.lab.textures import Texture

# What a ray meets when it meets no surface, and when a position has no ray.
NOTHING, NO_RAY = -1, -2


@dataclass(frozen=True)
class TexturedScene:
    """What a camera can look at.

    parts: pairs (surface, texture); background: radiance, a number or RGB, of rays
    that meet nothing; straight_edges: (n, 2, 3) ends of straight edges in the world
    that stand out in the picture, for measuring how straight they come out.
    """

    parts: tuple[tuple[TracedSurface, Texture], ...]
    background: float | tuple[float, float, float] = 0.0
    straight_edges: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 3)))

    @property
    def surfaces(self):
        """The surfaces alone, in the order of `parts`."""
        return tuple(surface for surface, _ in self.parts)

    @property
    def textures(self):
        """The textures alone, in the order of `parts`."""
        return tuple(texture for _, texture in self.parts)

    def hit(self, origins, directions):
        """The nearest surface of each ray.

        origins: (N, 3) or (1, 3), directions: (N, 3) unit, world frame. Returns
        (index (N,) int16 of the part or NOTHING, uv (N, 2) mm, cosine (N,)).
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
