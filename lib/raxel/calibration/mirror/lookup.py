"""A bent mirror's shape looked up by its boundary in the picture: the other method.

Before use, the mirror is bent to some shapes; of each, its boundary in the picture and
its calibrated shape go into a table. Later a picture of the boundary alone gives the
shape. It needs no target then, and knows no shape but those that lie between two
neighbours of the table. The idea is Kuthirummal's and Nayar's (2007), as section 1.2.3
of the thesis describes it; how boundaries are described and interpolated is chosen
here, as plainly as can be.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import InputError

# Points along each edge; a boundary that is farther off the table's, in standard
# deviations of a traced point, is none of its shapes.
ALONG, FAR = 17, 3.0
# Viewers whose directions differ by less, at places so many along either side, are one:
# a file rounds them by less, and no calibration repeats so well.
SAME_DEG, ACROSS = 1e-6, 9


class Looked(NamedTuple):
    """camera: SplineMirrorCamera; place: 1.25 is a quarter of the way from entry 1 to
    entry 2; off_px: root mean square distance of the boundary from the one that the
    table has there; flags: texts."""

    camera: SplineMirrorCamera
    place: float
    off_px: float
    flags: tuple


class BoundaryTable:
    """Boundaries of a mirror in the picture, and its shapes.

    boundaries: for each shape four edges, (M, 2) px each, traced from corner to corner
    and in the same order for all shapes; cameras: SplineMirrorCameras of the shapes,
    all on the same knots and with the same viewer. Neighbours stand next to each other,
    such as by deflection. Raises InputError for fewer than two, and for other knots or
    another viewer.
    """

    def __init__(self, boundaries, cameras):
        if len(cameras) < 2 or len(boundaries) != len(cameras):
            raise InputError(
                f"boundary table: found {len(boundaries)} boundaries and "
                f"{len(cameras)} cameras; give two or more shapes, both of each"
            )
        grid, quantity = cameras[0].grid, cameras[0].quantity
        for number, camera in enumerate(cameras[1:], 1):
            if not _alike(camera, cameras[0]):
                raise InputError(
                    f"boundary table: camera {number} has other knots or another "
                    "quantity than the first; calibrate all on the same knots"
                )
            if not _sees_alike(camera.viewer, cameras[0].viewer):
                raise InputError(
                    f"boundary table: camera {number} has another viewer than the "
                    "first; calibrate all shapes with the same viewer"
                )
        self._viewer, self._grid, self._quantity = cameras[0].viewer, grid, quantity
        self._boundaries = np.stack([described(edges) for edges in boundaries])
        self._coefficients = np.stack([c.coefficients.ravel("F") for c in cameras])

    def look_up(self, edges, noise_px=0.5):
        """Looked of the mirror whose boundary is traced: four edges (M, 2) px.

        The boundary is taken to lie between two neighbours of the table, where that is
        nearest to it. noise_px: standard deviation of a traced point along each axis.
        """
        seen = described(edges)
        places, off = self._on_segments(seen)
        best = int(np.argmin(off))
        place, first = places[best], min(best, len(places) - 1)
        share = place - first
        c = (1 - share) * self._coefficients[first]
        c = c + share * self._coefficients[first + 1]
        camera = SplineMirrorCamera.on_grid(self._viewer, self._grid, c, self._quantity)
        flags = []
        if off[best] > FAR * noise_px:
            flags.append(
                f"boundary: {off[best]:.2g} px (rms) from the nearest one between "
                "entries; the mirror has a shape that the table lacks"
            )
        return Looked(camera, float(place), float(off[best]), tuple(flags))

    def _on_segments(self, seen):
        """Nearest place (n - 1,) on the way from each entry to the next, and how far
        off (n - 1,) px the boundary is there."""
        start, way = self._boundaries[:-1], np.diff(self._boundaries, axis=0)
        length = np.sum(way**2, axis=(1, 2))
        share = np.sum((seen - start) * way, axis=(1, 2)) / np.maximum(length, 1e-30)
        share = np.clip(share, 0, 1)
        left = seen - start - share[:, None, None] * way
        off = np.sqrt(np.mean(np.sum(left**2, axis=2), axis=1))
        return np.arange(len(share)) + share, off


def described(edges):
    """Descriptor (4 ALONG, 2), px: points that divide each edge (M, 2) evenly."""
    edges = [np.asarray(edge, float) for edge in edges]
    if len(edges) != 4 or any(
        e.ndim != 2 or e.shape[1:] != (2,) or len(e) < 2 or not np.isfinite(e).all()
        for e in edges
    ):
        raise InputError(
            "boundary: give four edges, each (M, 2) finite pixels from corner to corner"
        )
    return np.concatenate([_evenly(edge) for edge in edges])


def _evenly(edge):
    run = np.append(0, np.cumsum(np.linalg.norm(np.diff(edge, axis=0), axis=1)))
    places = np.linspace(0, run[-1], ALONG)
    return np.column_stack([np.interp(places, run, axis) for axis in edge.T])


def _alike(camera, other):
    mine, its = camera.grid, other.grid
    return (
        camera.quantity == other.quantity
        and mine.angle == its.angle
        and mine.shape == its.shape
        and all(
            np.array_equal(a, b) for a, b in zip(mine.breaks, its.breaks, strict=True)
        )
    )


def _sees_alike(viewer, other):
    """Whether two viewers see every pixel in the same direction, to SAME_DEG."""
    if (viewer.width, viewer.height) != (other.width, other.height):
        return False
    u, v = (np.linspace(0, side - 1, ACROSS) for side in (viewer.width, viewer.height))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    mine, its = viewer.rays(pixels), other.rays(pixels)
    both = mine.valid & its.valid
    if not both.any() or np.any(mine.valid != its.valid):
        return False
    apart = mine.directions[both] - its.directions[both]
    return bool(np.linalg.norm(apart, axis=1).max() < np.radians(SAME_DEG))
