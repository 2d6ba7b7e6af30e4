"""The general camera (2.3): a look-up table from pixels to rays."""

import numpy as np

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    near_rows,
    pixel_grid,
)
from raxel.cameras.core.centrality import closest_point
from raxel.cameras.tables.interpolation import rays_at
from raxel.cameras.tables.inverse import TableInverse
from raxel.cameras.tables.ray_table import RayTable
from raxel.errors import InputError
from raxel.geometry.lines import pluecker_matrix_of_rays

BLOCK = 1 << 16
# Of an origin, mm or pitch: fourth powers must not overflow.
FARTHEST = 1e15


class GeneralCamera(Camera):
    """A ray for each pixel that has one, whatever the optics.

    directions: (H, W, 3), any length but zero, away from the camera; mask: (H, W) bool,
    True where the pixel has a ray; origins: (3,), the centre of a central camera, or
    (H, W, 3), a point on each ray (the thesis's anchor point), camera frame; units: the
    unit of the origins, 'mm' or 'pitch'.

    Between pixel centres the directions are interpolated bilinearly and normalised, and
    so are the origins of a non-central camera: slide the anchor points along their rays
    so that neighbours are close together. A position has a ray when every pixel that
    takes part has one: at a pixel centre that pixel alone, on the line between two
    centres those two. Across a discontinuity of the optics the interpolation has no
    meaning; leave the pixels there out of the mask.

    `project` is the exact inverse of this interpolation. Where the table sees a point
    twice, one of the pixels is returned. Its search structure is built at first use.
    Memory: 24 bytes per pixel, 48 when non-central (144 and 288 MB at 3008 x 2000), and
    about a tenth of it for the search.

    Raises InputError naming the field for wrong shapes, and for rays of the mask that
    are zero or not finite. Source: Grossberg and Nayar 2001,
    doi:10.1109/ICCV.2001.937611.
    """

    kind = "general"

    def __init__(self, directions, mask, origins=(0.0, 0.0, 0.0), units="mm"):
        directions = np.array(directions, dtype=float)
        if directions.ndim != 3 or directions.shape[2] != 3:
            raise InputError(
                f"field 'directions': shape {directions.shape} found; (height, width, "
                "3) needed"
            )
        shape = directions.shape[:2]
        check_size(self, shape[1], shape[0])
        if min(shape) < 2:
            raise InputError(
                f"field 'directions': {shape[1]} x {shape[0]} pixels found; a table "
                "needs two or more each way"
            )
        mask = np.asarray(mask)
        if mask.shape != shape or mask.dtype != bool:
            raise InputError(
                f"field 'mask': {mask.dtype} {mask.shape} found; bool {shape} needed"
            )
        origins = np.array(origins, dtype=float)
        if origins.shape not in ((3,), (*shape, 3)):
            raise InputError(
                f"field 'origins': shape {origins.shape} found; (3,) or "
                f"{(*shape, 3)} needed"
            )
        if units not in ("mm", "pitch"):
            raise InputError(f"field 'units': found {units!r}; give 'mm' or 'pitch'")
        _normalise(directions, mask)
        _blank(origins, mask)
        # The search structure would not notice a change.
        directions.flags.writeable = origins.flags.writeable = False
        self.units = units
        self._table = RayTable(directions, origins)
        self._inverse = None

    @classmethod
    def from_camera(cls, camera, units="mm"):
        """The table of another camera's rays at the pixel centres of its image."""
        shape = (camera.height, camera.width)
        directions, mask = np.empty((*shape, 3)), np.empty(shape, bool)
        origins = None if camera.central else np.empty((*shape, 3))
        step = max(1, BLOCK // camera.width)
        for top in range(0, camera.height, step):
            block = slice(top, min(top + step, camera.height))
            pixels = pixel_grid(camera.width, block.stop - top) + [0, top]
            o, d, valid = camera.rays(pixels)
            directions[block] = d.reshape(-1, camera.width, 3)
            mask[block] = valid.reshape(-1, camera.width)
            if not camera.central:
                origins[block] = o.reshape(-1, camera.width, 3)
        if camera.central:
            origins = _meeting_point(camera, mask)
        return cls(directions, mask, origins, units)

    @property
    def central(self):
        return self._table.central

    @property
    def parameters(self):
        """Two per ray of a central camera, four per ray (a line) otherwise."""
        return (2 if self.central else 4) * int(np.count_nonzero(self.mask))

    @property
    def directions(self):
        """(H, W, 3) unit directions, NaN without a ray; read-only."""
        return self._table.directions

    @property
    def origins(self):
        """(3,) or (H, W, 3), NaN without a ray; read-only."""
        return self._table.origins

    @property
    def mask(self):
        """(H, W) bool: which pixels have a ray."""
        return self._table.mask

    @property
    def share_with_ray(self):
        """Share of the pixels that have a ray."""
        return float(np.mean(self.mask))

    def rays(self, pixels):
        """Rays of pixels (N, 2) by interpolation in the table."""
        pixels = as_rows(pixels, 2)
        # One layout, as compiled loops are compiled for each.
        pixels = np.array(pixels, order="C")
        size = self.width, self.height
        origins, directions = rays_at(pixels, *self._table.rows, *size)
        return Rays(origins, directions, np.isfinite(directions[:, 0]))

    def project(self, points):
        """Pixels of points (N, 3): where the interpolated ray passes through each."""
        points = np.ascontiguousarray(near_rows(points, 3))
        if self._inverse is None:
            self._inverse = TableInverse(self._table)
        pixels = np.empty((len(points), 2))
        for start in range(0, len(points), BLOCK):
            rows = slice(start, start + BLOCK)
            pixels[rows] = self._inverse.project(points[rows])
        return Projection(pixels, np.isfinite(pixels[:, 0]))

    def pluecker(self, rows=slice(None)):
        """Plücker matrices (2.11) of a slice of image rows: (h, W, 4, 4).

        NaN without a ray. Built on demand: 128 bytes per pixel.
        """
        directions = self.directions[rows]
        origins = self.origins if self.central else self.origins[rows]
        return pluecker_matrix_of_rays(origins, directions)

    def _fields(self):
        return {
            "directions": self.directions,
            "mask": self.mask,
            "origins": self.origins,
            "units": np.array(self.units),
        }

    @classmethod
    def _from_file(cls, file):
        width, height = file.size()
        shape = file.shape("directions")
        found = dict(zip(("height", "width"), shape, strict=False))
        for name, value in (("width", width), ("height", height)):
            if found.get(name, value) != value:
                raise InputError(
                    f"field '{name}': found {value}, but the table has {found[name]}; "
                    "save it anew"
                )
        return cls(
            file.table("directions", (height, width, 3)),
            file.table("mask", (height, width)),
            file.table("origins", (3,), (height, width, 3)),
            file.text("units"),
        )


def _meeting_point(camera, mask):
    """The centre (3,) of a central camera that has rays at the pixels of a mask."""
    v, u = np.nonzero(mask)
    if not len(u):
        return np.zeros(3)
    rays = camera.rays(np.column_stack([u, v])[:: 1 + len(u) // BLOCK].astype(float))
    # Where a mirror is in the way rays start there, and only their lines meet.
    at_centre = np.all(rays.origins == rays.origins[0])
    return rays.origins[0] if at_centre else closest_point(rays)


def _normalise(directions, mask):
    """Make the rays of the mask unit in place, the others NaN; block by block."""
    step = max(1, BLOCK // mask.shape[1])
    for top in range(0, len(mask), step):
        d, seen = directions[top : top + step], mask[top : top + step]
        length = np.linalg.norm(d, axis=-1)
        bad = seen & ~(np.isfinite(length) & (length > 0))
        if bad.any():
            v, u = np.argwhere(bad)[0]
            raise InputError(
                f"field 'directions': {np.count_nonzero(bad)} rays near row {top + v} "
                f"are zero or not finite, first at pixel ({u}, {top + v}); take them "
                "out of the mask"
            )
        # Unit vectors stay as they are to the bit, so that save and load agree.
        length[np.abs(length - 1) < 1e-15] = 1.0
        length[~seen] = np.nan
        d /= length[..., None]


def _blank(origins, mask):
    """Check origins of the mask and put NaN outside it, in place."""
    if origins.ndim == 1:
        if not (np.abs(origins) < FARTHEST).all():
            raise InputError(
                f"field 'origins': found {origins}; it must be finite, below "
                f"{FARTHEST:g}"
            )
        return
    bad = mask & ~(np.abs(origins) < FARTHEST).all(axis=-1)
    if bad.any():
        v, u = np.argwhere(bad)[0]
        raise InputError(
            f"field 'origins': {np.count_nonzero(bad)} of the mask are not finite, "
            f"or beyond {FARTHEST:g}, first at pixel ({u}, {v}); take them out of the "
            "mask"
        )
    origins[~mask] = np.nan
