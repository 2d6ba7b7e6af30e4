"""The general camera (2.3): a look-up table from pixels to rays."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    closest_point,
    near_rows,
    pixel_grid,
)
from raxel.cameras.tables.bounds import BoundPyramid
from raxel.cameras.tables.interpolation import rays_at, walked, within_cells
from raxel.cameras.tables.ray_spline import RayTable
from raxel.errors import InputError
from raxel.geometry.planes import pluecker_matrix_of_rays

# Points to pixels of a general camera: the inverse of its interpolation. A point P is
# seen at (s, t) of a cell when the interpolated ray passes through it: (P - o(s, t)) x
# d(s, t) = 0, two independent equations, solved by Newton's method. A walk finds most
# points: it starts in the cell with the nearest direction (a tree over a coarse grid of
# cells), and each Newton step may enter a neighbouring cell. Holes in the table can
# stop a walk. Remaining points are searched for completely, in a pyramid of bounds:
# each node has a cone of directions and a ball of origins that enclose all rays below
# it, so no cell that sees the point is missed.


# Initial values of Newton's method in a cell: the centre, others for noisy cells.
NEWTON_STARTS = ((0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
MAX_N_COARSE_CELLS = 1 << 16
SEARCH_BLOCK = 1 << 11


class TableInverse:
    """The search structure of one `RayTable`."""

    def __init__(self, table):
        self._table = table
        self._plant_tree()

    @cached_property
    def _pyramid(self):
        # Points in the middle of the field of view are found without it.
        return BoundPyramid(self._table)

    def project(self, points):
        """Pixels (N, 2) of points (N, 3), NaN where no position sees the point."""
        pixels = np.full((len(points), 2), np.nan)
        finite = np.flatnonzero(np.isfinite(points).all(axis=1))
        if self._tree is not None:
            pixels[finite] = self._walk(points[finite])
        left = finite[np.isnan(pixels[finite, 0])]
        for start in range(0, len(left), SEARCH_BLOCK):
            rows = left[start : start + SEARCH_BLOCK]
            pixels[rows] = self._search(points[rows])
        return pixels

    def _plant_tree(self):
        from scipy.spatial import cKDTree

        mask = self._table.mask
        whole = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:] & mask[1:, 1:]
        stride = max(1, int(np.ceil(np.sqrt(whole.size / MAX_N_COARSE_CELLS))))
        coarse = np.zeros_like(whole)
        coarse[stride // 2 :: stride, stride // 2 :: stride] = True
        v, u = np.nonzero(whole & coarse)
        self._start = np.column_stack([u, v])
        self._tree = cKDTree(self._table.directions[v, u]) if len(u) else None
        self._eye = self._table.origins
        if not self._table.central and len(u):
            self._eye = self._table.origins[v, u].mean(axis=0)

    def _walk(self, points):
        """Newton's method across cells; NaN without convergence."""
        table = self._table
        far = points - self._eye
        length = np.linalg.norm(far, axis=1, keepdims=True)
        _, nearest = self._tree.query(far / np.where(length > 0, length, 1.0))
        start = self._start[nearest] + 0.5
        return walked(points, start, *table.rows, table.width, table.height)

    def _search(self, points):
        """Complete search, for points where the walk failed."""
        index, u, v = self._pyramid.cells(points)
        index, cells = self._solvable(index, u, v)
        place = np.full((len(index), 2), np.nan)
        todo = np.ones(len(index), bool)
        rows, width = self._table.rows, self._table.width
        for start in NEWTON_STARTS:
            place[todo] = within_cells(
                points[index[todo]], cells[todo], start, *rows, width
            )
            todo = ~np.isin(index, index[np.isfinite(place[:, 0])])
        seen = np.isfinite(place[:, 0])
        index, place = index[seen], place[seen]
        order = np.lexsort([place[:, 0], place[:, 1], index])
        index, first = np.unique(index[order], return_index=True)
        pixels = np.full((len(points), 2), np.nan)
        pixels[index] = place[order][first]
        return pixels

    def _solvable(self, who, u, v):
        """Replace cells without a corner by their existing edges and pixels."""
        mask = self._table.mask
        have = np.stack(
            [mask[v, u], mask[v, u + 1], mask[v + 1, u], mask[v + 1, u + 1]]
        )
        whole = have.all(axis=0)
        parts = [(who[whole], u[whole], v[whole], 1, 1)]
        for du, dv, right, below in [
            (0, 0, 1, 0), (0, 1, 1, 0), (0, 0, 0, 1), (1, 0, 0, 1),
            (0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (1, 1, 0, 0),
        ]:  # fmt: skip
            first = have[du + 2 * dv]
            second = have[du + right + 2 * (dv + below)]
            use = ~whole & first & second
            parts.append((who[use], u[use] + du, v[use] + dv, right, below))
        sizes = [len(part[0]) for part in parts]
        joined = [np.concatenate([part[k] for part in parts]) for k in range(3)]
        extent = [np.repeat([part[k] for part in parts], sizes) for k in (3, 4)]
        who, *place = joined
        return who, np.column_stack([*place, *extent])


BLOCK = 1 << 16
# Of an origin, mm or pitch: fourth powers must not overflow.
MAX_ORIGIN = 1e15


class GeneralCamera(Camera):
    """A ray for each pixel that has one, whatever the optics.

    Between pixel centres the directions are interpolated bilinearly and normalised, and
    so are the origins of a non-central camera: slide the anchor points along their rays
    so that neighbours are close together. A position has a ray when every pixel that
    takes part has one: at a pixel centre that pixel alone, on the line between two
    centres those two. Across a discontinuity of the optics the interpolation has no
    meaning; exclude the pixels there from the mask.

    `project` is the exact inverse of this interpolation. Where the table sees a point
    twice, one of the pixels is returned. Its search structure is built at first use.
    Memory: 24 bytes per pixel, 48 when non-central (144 and 288 MB at 3008 x 2000), and
    about a tenth of it for the search.

    Parameters
    ----------
    directions : array_like, shape (H, W, 3)
        Directions of any length but zero, away from the camera.
    mask : ndarray of bool, shape (H, W)
        True where the pixel has a ray.
    origins : array_like, shape (3,) or (H, W, 3)
        Centre of a central camera, or a point on each ray (the thesis's anchor point),
        camera frame.
    units : str
        Unit of the origins, 'mm' or 'pitch'.

    Raises
    ------
    InputError
        Wrong shapes, or rays of the mask that are zero or not finite; the message names
        the field.

    References
    ----------
    Grossberg and Nayar 2001, doi:10.1109/ICCV.2001.937611.
    """

    kind = "general"

    def __init__(
        self,
        directions: NDArray[Any],
        mask: NDArray[Any],
        origins: Any = (0.0, 0.0, 0.0),
        units: str = "mm",
    ) -> None:
        directions = np.array(directions, dtype=float)
        if directions.ndim != 3 or directions.shape[2] != 3:
            raise InputError(
                f"field 'directions': found shape {directions.shape}; give (height, "
                "width, 3)"
            )
        shape = directions.shape[:2]
        check_size(self, shape[1], shape[0])
        if min(shape) < 2:
            raise InputError(
                f"field 'directions': found {shape[1]} x {shape[0]} pixels; give two "
                "or more along both axes"
            )
        mask = np.asarray(mask)
        if mask.shape != shape or mask.dtype != bool:
            raise InputError(
                f"field 'mask': found {mask.dtype} {mask.shape}; give bool {shape}"
            )
        origins = np.array(origins, dtype=float)
        if origins.shape not in ((3,), (*shape, 3)):
            raise InputError(
                f"field 'origins': found shape {origins.shape}; give (3,) or "
                f"{(*shape, 3)}"
            )
        if units not in ("mm", "pitch"):
            raise InputError(f"field 'units': found {units!r}; give 'mm' or 'pitch'")
        _normalise(directions, mask)
        _blank(origins, mask)
        # The search structure would not follow a change.
        directions.flags.writeable = origins.flags.writeable = False
        self.units = units
        self._table = RayTable(directions, origins)
        self._inverse = None

    @classmethod
    def from_camera(cls, camera: Camera, units: str = "mm") -> GeneralCamera:
        """Return the table of another camera's rays at the pixel centres of its image.

        Parameters
        ----------
        camera : Camera
            Camera to tabulate.
        units : str
            Unit of the origins, 'mm' or 'pitch'.

        Returns
        -------
        GeneralCamera
            Table of rays.
        """
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
                origins[block] = o.reshape(-1, camera.width, 3)  # type: ignore[index]
        if camera.central:
            origins = _meeting_point(camera, mask)
        return cls(directions, mask, origins, units)

    @property
    def central(self) -> bool:
        return self._table.central

    @property
    def parameters(self) -> int:
        """Two per ray of a central camera, four per ray (a line) otherwise."""
        return (2 if self.central else 4) * int(np.count_nonzero(self.mask))

    @property
    def directions(self) -> NDArray[np.float64]:
        """(H, W, 3) unit directions, NaN without a ray; read-only."""
        return self._table.directions

    @property
    def origins(self) -> NDArray[np.float64]:
        """(3,) or (H, W, 3), NaN without a ray; read-only."""
        return self._table.origins

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(H, W) bool: which pixels have a ray."""
        return self._table.mask

    @property
    def share_with_ray(self) -> float:
        """Share of the pixels that have a ray."""
        return float(np.mean(self.mask))

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays by interpolation in the table."""
        pixels = as_rows(pixels, 2)
        # One memory layout, since compiled loops depend on it.
        pixels = np.array(pixels, order="C")
        size = self.width, self.height
        origins, directions = rays_at(pixels, *self._table.rows, *size)  # type: ignore[call-arg]
        return Rays(origins, directions, np.isfinite(directions[:, 0]))

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points: where the interpolated ray passes through each.
        """
        points = np.ascontiguousarray(near_rows(points, 3))
        if self._inverse is None:
            self._inverse = TableInverse(self._table)  # type: ignore[assignment]
        pixels = np.empty((len(points), 2))
        for start in range(0, len(points), BLOCK):
            rows = slice(start, start + BLOCK)
            pixels[rows] = self._inverse.project(points[rows])  # type: ignore[attr-defined]
        return Projection(pixels, np.isfinite(pixels[:, 0]))

    def pluecker(self, rows: slice = slice(None)) -> NDArray[np.float64]:
        """Return Plücker matrices (2.11) of a slice of image rows.

        They are built on demand: 128 bytes per pixel.

        Parameters
        ----------
        rows : slice
            Rows of the image.

        Returns
        -------
        ndarray, shape (h, W, 4, 4)
            Matrices, NaN without a ray.
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
                    "save the file anew"
                )
        return cls(
            file.table("directions", (height, width, 3)),
            file.table("mask", (height, width)),
            file.table("origins", (3,), (height, width, 3)),
            file.text("units"),
        )


def _meeting_point(camera, mask):
    """Centre (3,) of a central camera with rays at the pixels of a mask."""
    v, u = np.nonzero(mask)
    if not len(u):
        return np.zeros(3)
    rays = camera.rays(np.column_stack([u, v])[:: 1 + len(u) // BLOCK].astype(float))
    # Rays may start on a mirror; then only their lines meet.
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
                f"are zero or not finite, first at pixel ({u}, {top + v}); exclude "
                "them in the mask"
            )
        # Unit vectors stay bit-identical, so that save and load agree.
        length[np.abs(length - 1) < 1e-15] = 1.0
        length[~seen] = np.nan
        d /= length[..., None]


def _blank(origins, mask):
    """Check origins of the mask and set NaN outside it, in place."""
    if origins.ndim == 1:
        if not (np.abs(origins) < MAX_ORIGIN).all():
            raise InputError(
                f"field 'origins': found {origins}; give finite values below "
                f"{MAX_ORIGIN:g}"
            )
        return
    bad = mask & ~(np.abs(origins) < MAX_ORIGIN).all(axis=-1)
    if bad.any():
        v, u = np.argwhere(bad)[0]
        raise InputError(
            f"field 'origins': {np.count_nonzero(bad)} of the mask are not finite or "
            f"above {MAX_ORIGIN:g}, first at pixel ({u}, {v}); exclude them in the mask"
        )
    origins[~mask] = np.nan
