"""What the positions of a camera's image see in a scene."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from raxel.cameras import Camera
from raxel.cameras.core.smooth_rays import smooth_rays
from raxel.geometry import rotate, transform
from raxel.lab.scene import NO_RAY, TexturedScene

# Rays handled at once: a few MB, so that the steps between stay in cache.
RAYS_AT_ONCE = 1 << 16


class Crop(NamedTuple):
    """Part of a picture of `full_width` x `full_height` px: first pixel and size."""

    u: int
    v: int
    width: int
    height: int
    full_width: int
    full_height: int

    @property
    def place(self):
        """Its rows and columns of the whole picture, as an index of an array."""
        rows = slice(self.v, self.v + self.height)
        return rows, slice(self.u, self.u + self.width)


@dataclass(frozen=True)
class Raster:
    """Pixels of a camera's picture, or of a `Crop` of it.

    fineness: how many of them, each way, make one pixel of the camera.
    """

    camera: Camera
    fineness: int = 1
    window: Crop | None = None

    @property
    def width(self):
        """Pixels of a row."""
        return self.fineness * (self.window or self.camera).width

    @property
    def height(self):
        """Pixels of a column."""
        return self.fineness * (self.window or self.camera).height

    def rays(self, pixels):
        """`Rays` of positions (N, 2) of the raster; origins may be one, (1, 3)."""
        u, v = (self._in_camera(pixels[:, axis], axis) for axis in range(2))
        return smooth_rays(self.camera).rays(np.column_stack([u, v]))

    def grid(self, u, v):
        """`Rays` of all (u, v) of the raster, by rows, as `rays`; u and v rise."""
        u, v = self._in_camera(u, 0), self._in_camera(v, 1)
        return smooth_rays(self.camera).grid(u, v)

    def _in_camera(self, values, axis):
        first = self.window[axis] if self.window else 0
        return (values + 0.5) / self.fineness - 0.5 + first


class Sight(NamedTuple):
    """What N positions see; the arrays may have more leading dimensions.

    part: index of the scene's part, NOTHING or NO_RAY, int16; uv: (N, 2) mm on that
    surface; cosine: (N,) of the angle between ray and normal.
    """

    part: np.ndarray
    uv: np.ndarray
    cosine: np.ndarray

    def reshaped(self, *shape):
        """The same with leading dimensions `shape`."""
        part, uv, cosine = self
        return Sight(part.reshape(shape), uv.reshape(*shape, 2), cosine.reshape(shape))

    def at(self, where):
        """The entries that an index of the leading dimensions takes."""
        return Sight(*(field[where] for field in self))


@dataclass(frozen=True)
class Viewer:
    """A camera at its place in front of a scene. T_world_camera: (4, 4), mm."""

    raster: Raster
    T_world_camera: np.ndarray
    scene: TexturedScene

    def look(self, pixels):
        """The `Sight` of positions (N, 2) in the image."""
        pixels = np.asarray(pixels, float)
        steps = range(0, len(pixels), RAYS_AT_ONCE)
        parts = [self._look(pixels[i : i + RAYS_AT_ONCE]) for i in steps]
        if len(parts) == 1:
            return parts[0]
        if not parts:
            return Sight(np.empty(0, np.int16), np.empty((0, 2)), np.empty(0))
        return Sight(*(np.concatenate(field) for field in zip(*parts, strict=True)))

    def look_at_grid(self, u, v):
        """The `Sight` (len(v), len(u)) of all (u, v), which rise."""
        return self._along(self.raster.grid(u, v)).reshaped(len(v), len(u))

    def _look(self, pixels):
        return self._along(self.raster.rays(pixels))

    def _along(self, rays):
        origins, directions, valid = rays
        # Most scenes are set up in the camera's own frame.
        if not np.array_equal(self.T_world_camera, np.eye(4)):
            origins = transform(self.T_world_camera, origins)
            directions = rotate(self.T_world_camera, directions)
        part, uv, cosine = self.scene.hit(origins, directions)
        part[~valid] = NO_RAY
        return Sight(part, uv, cosine)


def visible_share(camera, T_world_camera, surface, most=200_000):
    """Share of the image's pixels whose rays meet a surface, 0 to 1.

    Looks at the centres of all pixels, or of every n-th each way where there are more
    than `most`. A surface that the camera does not see has share 0.
    """
    step = max(1, int(np.ceil(np.sqrt(camera.width * camera.height / most))))
    v, u = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    hit = surface.hit(
        transform(T_world_camera, rays.origins), rotate(T_world_camera, rays.directions)
    )
    return float(np.mean(rays.valid & np.isfinite(hit.distance)))
