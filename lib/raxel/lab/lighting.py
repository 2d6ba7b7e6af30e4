"""Light on a board: how much of it arrives, how evenly, and what shades it.

A rig's `light` gives ranges; each picture draws its own light from them.
"""

from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError
from raxel.lab.textures import LUMINANCE

WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Lighting:
    """Ranges (least, greatest) from which the light of one picture is drawn.

    tint: red, green and blue of lamps and mirror together; only ratios count. level:
    share of the scene's light that reaches the board's middle. slope: by how much,
    as a share, the light rises from one end of the board to the other, in any
    direction. shadow_chance: share of pictures with a soft shadow on the board;
    shadow_depth: share of the light it takes; shadow_radius: mm; shadow_edge: SD of
    its edge, mm. Its middle lies anywhere on the board. surround: radiance of what the
    camera sees beside its mirror.
    """

    tint: tuple[float, float, float] = WHITE
    level: tuple[float, float] = (1.0, 1.0)
    slope: tuple[float, float] = (0.0, 0.0)
    shadow_chance: float = 0.0
    shadow_depth: tuple[float, float] = (0.0, 0.0)
    shadow_radius: tuple[float, float] = (1.0, 1.0)
    shadow_edge: tuple[float, float] = (1.0, 1.0)
    surround: float = 0.0

    def __post_init__(self):
        for name in (
            *("level", "slope", "shadow_depth"),
            *("shadow_radius", "shadow_edge"),
        ):
            low, high = getattr(self, name)
            if low > high:
                raise InputError(
                    f"field '{name}': found [{low}, {high}]; give the least first, "
                    "then the greatest"
                )
        if not min(self.tint) > 0:
            raise InputError(
                f"field 'tint': found {list(self.tint)}; give three shares above 0"
            )

    @property
    def coloured(self):
        """Whether pictures in this light are not grey."""
        return len(set(self.tint)) > 1

    def tinted(self, irradiance):
        """Irradiance (H, W) or (H, W, 3) as (H, W, 3) in the lamps' tint.

        A grey picture keeps its luminance.
        """
        tint = np.array(self.tint) / (LUMINANCE @ self.tint)
        grey = irradiance.ndim == 2
        return (irradiance[..., None] if grey else irradiance) * tint.astype(np.float32)

    def draw(self, rng, extent):
        """The `BoardLight` of one picture; extent: (corner (2,), size (2,)), mm."""
        corner, size = extent
        level, slope = rng.uniform(*self.level), rng.uniform(*self.slope)
        turn = rng.uniform(0, 2 * np.pi)
        across = np.array([np.cos(turn), np.sin(turn)])
        has_shadow = rng.random() < self.shadow_chance
        middle = corner + rng.random(2) * size
        depth, radius, edge = (
            rng.uniform(*limits)
            for limits in (self.shadow_depth, self.shadow_radius, self.shadow_edge)
        )
        return BoardLight(
            level,
            slope * across / np.linalg.norm(size),
            corner + size / 2,
            Shadow(middle, depth, radius, edge) if has_shadow else None,
        )


@dataclass(frozen=True)
class Shadow:
    """A round soft shadow: middle (2,), radius and SD of its edge in mm."""

    middle: np.ndarray
    depth: float
    radius: float
    edge: float

    def passes(self, uv):
        """Share of the light that passes, at places uv (N, 2) in mm."""
        from scipy.special import erfc

        away = np.linalg.norm(uv - self.middle, axis=1) - self.radius
        return 1 - self.depth * erfc(away / (np.sqrt(2) * self.edge)) / 2


@dataclass(frozen=True)
class BoardLight:
    """Light over a board: a level, a slope (2,) per mm about `middle`, a shadow."""

    level: float
    slope: np.ndarray
    middle: np.ndarray
    shadow: Shadow | None = None

    def __call__(self, uv):
        """Light (N,) at places uv (N, 2), mm."""
        light = self.level * np.maximum(1 + (uv - self.middle) @ self.slope, 0)
        return light if self.shadow is None else light * self.shadow.passes(uv)
