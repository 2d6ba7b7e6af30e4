"""What the positions of a camera's image see in a scene."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from raxel.cameras import Camera
from raxel.cameras.base import Rays
from raxel.errors import InputError
from raxel.geometry import rotate, transform
from raxel.lab.scene import NO_RAY, TexturedScene

# Rays handled at once: a few MB, so that the steps between stay in cache.
RAYS_AT_ONCE = 1 << 16
# Corners of pixels whose rays are kept from one picture to the next: 100 MB.
CORNERS_REMEMBERED = 1 << 22


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

    camera: Camera
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

    def along(self, rays):
        """The `Sight` of `Rays` of the camera; their origins may be one, (1, 3)."""
        origins, directions, valid = rays
        part, uv, cosine = self.scene.hit(
            transform(self.T_world_camera, origins),
            rotate(self.T_world_camera, directions),
        )
        part[~valid] = NO_RAY
        return Sight(part, uv, cosine)

    def _look(self, pixels):
        return self.along(rays_of(self.camera, pixels))


def rays_of(camera, pixels):
    """The camera's `Rays` of positions (N, 2), with one origin (1, 3) if it is one."""
    origins, directions, valid = camera.rays(pixels)
    # A central camera may still start its rays on a mirror, each where it leaves.
    first = origins[np.argmax(valid)]
    if camera.central and np.all((origins == first) | ~valid[:, None]):
        origins = first[None]
    return Rays(origins, directions, valid)


class CornerRays:
    """Rays of the corners that pixels share, for many pictures by one camera.

    They are remembered, at 25 bytes a corner, unless there are too many.
    """

    def __init__(self, camera):
        self.camera = camera
        corners = (camera.width + 1) * (camera.height + 1)
        self._known = {} if corners <= CORNERS_REMEMBERED else None

    def of_rows(self, rows):
        """`Rays` of the corners of a range of rows, (h + 1) * (width + 1), by rows."""
        if self._known is None or rows not in self._known:
            u = np.arange(self.camera.width + 1) - 0.5
            v = np.arange(rows.start, rows.stop + 1) - 0.5
            rays = rays_of(self.camera, positions(u, v))
            if self._known is None:
                return rays
            self._known[rows] = rays
        return self._known[rows]


def positions(u, v):
    """All (u, v) (len(v) * len(u), 2), by rows."""
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


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


def need_visible(camera, T_world_camera, surface, least_share=0.0, name="target"):
    """Raise InputError, in one line, if a surface fills too little of the image."""
    share = visible_share(camera, T_world_camera, surface)
    if not share > least_share:
        raise InputError(
            f"scene: the {name} fills {100 * share:.2g} % of the image, more than "
            f"{100 * least_share:.2g} % is needed; move or turn the camera towards it"
        )
