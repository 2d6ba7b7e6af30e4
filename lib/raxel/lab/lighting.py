"""Light on a board: its level, evenness and shadows.

A rig's `light` gives ranges; each image draws its own light from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from raxel.errors import InputError
from raxel.lab.textures import LUMINANCE

# Blemishes between scene and lens: spots on mirror or glass, glare, haze.


# SD px of a spot's edge: the mirror's surface is slightly out of focus.
SPOT_EDGE_PX = 0.7
# Radius of a spot or glare, in radii or SDs of its edge, beyond which it is zero.
MAX_RADII = 4


@dataclass(frozen=True)
class Blemishes:
    """Describe spots of a specimen, equal in all its images, and glare of each image.

    spots: number on the whole image; spot_radius: px; spot_cover: share of the scene's
    light that a spot occludes; spot_radiance: radiance that replaces it (dirt is dark,
    a pit that reflects a lamp is bright). glare: number of patches of light over an
    image, as of a lamp in a clear tube or a dull mirror; glare_radius: their SD, px;
    glare_radiance: at their centres; glare_within: px from the centre of the image.
    haze: share of the image's mean light that is spread evenly over the mirror or
    glass. All but `spots` and `haze` are (minimum, maximum).
    """

    spots: int = 0
    spot_radius: tuple[float, float] = (1.0, 1.0)
    spot_cover: tuple[float, float] = (0.0, 0.0)
    spot_radiance: tuple[float, float] = (0.0, 0.0)
    glare: tuple[int, int] = (0, 0)
    glare_radius: tuple[float, float] = (1.0, 1.0)
    glare_radiance: tuple[float, float] = (0.0, 0.0)
    glare_within: tuple[float, float] = (0.0, 0.0)
    haze: float = 0.0

    def __post_init__(self):
        for name, value in vars(self).items():
            if isinstance(value, tuple) and value[0] > value[1]:
                raise InputError(
                    f"field '{name}': found {list(value)}; give the least first, then "
                    "the greatest"
                )

    def apply(self, irradiance, mirror, specimen, rng):
        """Return a copy of the image (H, W) or (H, W, 3) with the blemishes.

        mirror: (H, W), above 0 where mirror or glass can have spots; specimen, rng:
        numpy Generators, for the specimen and for the image.
        """
        out = np.array(irradiance, np.float32)
        mean = float(out.mean())
        draws = specimen.random((self.spots, 5))
        for spot in _spots(self, out.shape[:2], draws.tobytes()):
            if mirror[spot.middle]:
                patch = out[spot.part]
                share = spot.share.reshape(spot.share.shape + (1,) * (out.ndim - 2))
                patch += share * (spot.radiance - patch)
        for _ in range(rng.integers(self.glare[0], self.glare[1] + 1)):
            self._add_glare(out, rng)
        haze = np.float32(self.haze * mean) * mirror
        return out + haze.reshape(haze.shape + (1,) * (out.ndim - 2))

    def _add_glare(self, out, rng):
        height, width = out.shape[:2]
        turn, away = rng.uniform(0, 2 * np.pi), rng.uniform(*self.glare_within)
        middle = np.array([(width - 1) / 2, (height - 1) / 2])
        middle = middle + away * np.array([np.cos(turn), np.sin(turn)])
        radius = rng.uniform(*self.glare_radius)
        radiance = rng.uniform(*self.glare_radiance)
        part, away = _around((height, width), middle, MAX_RADII * radius)
        glare = (radiance * np.exp(-((away / radius) ** 2) / 2)).astype(np.float32)
        out[part] += glare.reshape(glare.shape + (1,) * (out.ndim - 2))


class _Spot(NamedTuple):
    """Hold a spot: its part of an image, (row, column) of its centre, and share (h, w).

    share: of the light that it occludes.
    """

    part: tuple[slice, slice]
    middle: tuple[int, int]
    share: np.ndarray
    radiance: np.float32


@lru_cache(maxsize=4)
def _spots(blemishes, size, draws):
    """Return the `_Spot`s of a specimen on images of a size (height, width).

    draws: bytes of (n, 5) uniform numbers. All images of a specimen have the same
    spots, so they are cached.
    """
    height, width = size
    spots = []
    for *at, radius, cover, radiance in np.frombuffer(draws).reshape(-1, 5):
        middle = np.array(at) * (width, height) - 0.5
        radius = np.exp(_between(np.log(blemishes.spot_radius), radius))
        cover = _between(blemishes.spot_cover, cover)
        radiance = _between(blemishes.spot_radiance, radiance)
        u, v = np.clip(np.rint(middle).astype(int), 0, (width - 1, height - 1))
        part, away = _around(size, middle, radius + MAX_RADII * SPOT_EDGE_PX)
        share = cover / (1 + np.exp(2 * (away - radius) / SPOT_EDGE_PX))
        share = share.astype(np.float32)
        spots.append(_Spot(part, (v, u), share, np.float32(radiance)))
    return spots


def _between(limits, share):
    """The value at a share of the way from the first limit to the second."""
    return limits[0] + (limits[1] - limits[0]) * share


def _around(size, middle, reach):
    """Return the part of an image within `reach` px of a point, and distances (h, w).

    The part is an index of arrays of this size (height, width).
    """
    height, width = size
    low = np.clip(np.floor(middle - reach), 0, (width, height)).astype(int)
    high = np.clip(np.ceil(middle + reach) + 1, 0, (width, height)).astype(int)
    v, u = np.ogrid[low[1] : high[1], low[0] : high[0]]
    part = slice(low[1], high[1]), slice(low[0], high[0])
    return part, np.hypot(u - middle[0], v - middle[1])


WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Lighting:
    """Describe ranges (minimum, maximum) of the light of one image.

    tint: red, green and blue of lamps and mirror together; only ratios count. level:
    share of the scene's light at the centre of the board. slope: relative increase of
    the light from one end of the board to the other, in any direction. shadow_chance:
    share of images with a soft shadow on the board; shadow_depth: share of the light
    that it removes; shadow_radius: mm; shadow_edge: SD of its edge, mm. Its centre is
    anywhere on the board. surround: radiance around the mirror in the image.
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
        """Whether images in this light are not grey."""
        return len(set(self.tint)) > 1

    def tinted(self, irradiance):
        """Irradiance (H, W) or (H, W, 3) as (H, W, 3) in the lamps' tint.

        A grey image keeps its luminance.
        """
        tint = np.array(self.tint) / (LUMINANCE @ self.tint)
        grey = irradiance.ndim == 2
        return (irradiance[..., None] if grey else irradiance) * tint.astype(np.float32)

    def draw(self, rng, extent):
        """The `BoardLight` of one image; extent: (corner (2,), size (2,)), mm."""
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
    """Round soft shadow on a board.

    Attributes
    ----------
    middle : (2,) array
        Middle in the plane of the board, mm.
    depth : float
        Share of the light that the shadow takes.
    radius, edge : float
        Radius, and SD of its edge, mm.
    """

    middle: np.ndarray
    depth: float
    radius: float
    edge: float

    def passes(self, uv: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share (N,) of the light that passes at positions uv (N, 2), mm."""
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
        """Return the light (N,) at points uv (N, 2), mm."""
        light = self.level * np.maximum(1 + (uv - self.middle) @ self.slope, 0)
        return light if self.shadow is None else light * self.shadow.passes(uv)
