"""View of an active grid: the point that each pixel sees, instead of corners.

It has the interface of a board view. Poses, parametric models and scores use a few
hundred well-spread points: every k-th pixel along both axes. The generic method, which
assigns a ray to each pixel, uses all pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.views.correspondence import (
    BoardView,
    add_points,
    pixels_on_board,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry.pixel_cells import as_in_a_mirror, whole_cells

# Board points at a lattice of pixels, for the generic method. A million pixels hardly
# improve the few parameters of centre and poses, so every k-th pixel is used; the table
# of rays contains all pixels.


class BoardSamples(NamedTuple):
    """Hold board points at a lattice of pixels.

    Attributes
    ----------
    pixels : ndarray of int, shape (M, 2)
        Multiples of `step` that see any board.
    points : ndarray, shape (n, M, 2)
        Points on each of n boards; NaN where not seen.
    seen : ndarray of bool, shape (n, M)
        Whether a pixel sees a board.
    step : int
        Distance of the pixels, px.
    """

    pixels: np.ndarray
    points: np.ndarray
    seen: np.ndarray
    step: int

    def thinned(self, factor: int) -> BoardSamples:
        """Return the samples whose pixels are multiples of factor * step."""
        step = factor * self.step
        keep = np.all(self.pixels % step == 0, axis=1)
        return BoardSamples(
            self.pixels[keep], self.points[:, keep], self.seen[:, keep], step
        )


def sample_boards(
    views: Sequence[BoardView | DenseView], width: int, height: int, observations: float
) -> BoardSamples:
    """Return samples of about a given number of pixel-board pairs, at most every pixel.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        The views.
    width, height : int
        Size of the image, px.
    observations : float
        Number of pixel-board pairs.

    Returns
    -------
    BoardSamples
        The samples.
    """
    area = sum(view.area() for view in views)
    step = max(1, round(np.sqrt(area / observations)))
    columns, rows = (width - 1) // step + 1, (height - 1) // step + 1
    points = np.full((len(views), rows * columns, 2), np.nan)
    for k, view in enumerate(views):
        pixels, on_board = pixels_on_board(view, width, height, step)
        points[k, pixels[:, 1] // step * columns + pixels[:, 0] // step] = on_board
    seen = np.isfinite(points[..., 0])
    used = np.flatnonzero(seen.any(axis=0))
    pixels = step * np.column_stack([used % columns, used // columns])
    return BoardSamples(pixels, points[:, used], seen[:, used], step)


N_SAMPLES = 1000  # approximate number of pixels of a view for poses and models
MIN_N_PIXELS = 100
DERIVATIVE_REACH_PX = 3  # to either side, for derivatives of points by pixels
MIN_SIGMA_MM = 1e-6  # highest accuracy of a point
MAX_COORDINATE_MM = 1e6  # of points on a monitor and of their standard deviations


class DenseView(NamedTuple):
    """Hold one view of an active grid; `dense_view` makes it.

    The first six attributes are those of a BoardView, for a lattice of pixels: every
    step-th column and row of the image. The step is the largest for which about
    N_SAMPLES pixels or more remain.

    The ray table weights the points of a pixel with 1/sigma^2, and a misfit is compared
    with `sd`. Fits of formulas, poses and centre, and all scores, weight the samples
    alike, as they do corners. Memory: 17 bytes for each pixel of the image; location,
    sigma and whole may be StoredArrays instead.

    Attributes
    ----------
    pixels : ndarray, shape (N, 2)
        Pixels of the lattice; NaN where not decoded.
    points : ndarray, shape (N, 2)
        Their points on the grid; 0 where not decoded.
    columns, rows : int
        Size of the lattice.
    name : str
        Name for messages.
    sd : ndarray, shape (N,), or None
        Standard deviations, px, from `sigma`.
    location : ndarray of float32, shape (H, W, 2)
        Point of each pixel; NaN without one.
    sigma : ndarray of float32, shape (H, W, 2)
        Standard deviations of the points, in the same unit.
    whole : ndarray of bool, shape (H - 1, W - 1)
        Squares of four pixels that see one piece of surface. Within these, points may
        be interpolated.
    step : int
        Distance of the pixels of the lattice, px.
    mirrored : bool
        Whether y is counted upwards, since the grid is seen as in a mirror.
    """

    pixels: np.ndarray
    points: np.ndarray
    columns: int
    rows: int
    name: str
    sd: np.ndarray | None
    location: np.ndarray
    sigma: np.ndarray
    whole: np.ndarray
    step: int
    mirrored: bool

    every_pixel = True  # type: ignore[misc]

    def locate(self, pixels: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return the points of the target that pixels look at.

        The result is bilinear within whole squares. A whole pixel has its own decoded
        point.

        Parameters
        ----------
        pixels : array_like, shape (M, 2)
            Pixels (u, v) at any sub-pixel position.

        Returns
        -------
        points : ndarray, shape (M, 2)
            Points on the target; NaN where the view does not reach.
        inside : ndarray of bool, shape (M,)
            Whether the view reaches the pixel.
        """
        pixels = np.asarray(pixels, float)
        height, width, _ = self.location.shape
        points = np.full(pixels.shape, np.nan)
        there = np.all((pixels >= 0) & (pixels <= [width - 1, height - 1]), axis=1)
        waiting = np.flatnonzero(there)
        # A pixel between two squares belongs to either.
        for lower in product((np.floor, lambda x: np.ceil(x) - 1), repeat=2):
            u, v = (f(pixels[waiting, k]).astype(int) for k, f in enumerate(lower))  # type: ignore[operator]
            holds = (u >= 0) & (v >= 0) & (u < width - 1) & (v < height - 1)
            holds[holds] = self.whole[v[holds], u[holds]]
            found, u, v = waiting[holds], u[holds], v[holds]
            points[found] = self._bilinear(pixels[found], u, v)
            waiting = waiting[~holds]
        u, v = np.rint(pixels[waiting]).astype(int).T
        exact = np.all(pixels[waiting] == np.column_stack([u, v]), axis=1)
        points[waiting[exact]] = self.location[v[exact], u[exact]]
        return points, np.isfinite(points[:, 0])

    def _bilinear(self, pixels, u, v):
        along, down = (pixels - np.column_stack([u, v])).T[..., None]
        upper = (1 - along) * self.location[v, u] + along * self.location[v, u + 1]
        v = v + 1
        lower = (1 - along) * self.location[v, u] + along * self.location[v, u + 1]
        return (1 - down) * upper + down * lower

    def whole_pixels(
        self, width: int, height: int, step: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the whole pixels that look at the target, and their points.

        Parameters
        ----------
        width, height : int
            Size of the image, px.
        step : int
            Only multiples of it count, px.

        Returns
        -------
        pixels : ndarray of int, shape (M, 2)
            Pixels (u, v), row by row.
        points : ndarray, shape (M, 2)
            Points on the target.
        """
        seen = self.location[:height:step, :width:step]
        v, u = np.nonzero(np.isfinite(seen[..., 0]))
        return step * np.column_stack([u, v]), seen[v, u].astype(float)

    def area(self) -> int:
        """Return the number of pixels that have a point."""
        return int(np.count_nonzero(np.isfinite(self.location[..., 0])))

    def covered(self, width: int, height: int) -> NDArray[np.uint8]:
        """Return (height, width) uint8: 1 where a pixel has a point."""
        return np.isfinite(self.location[:height, :width, 0]).astype(np.uint8)

    def add_moments(
        self,
        sums: np.ndarray,
        T_base_grid: np.ndarray,
        centre: np.ndarray,
        weight: float = 1.0,
    ) -> None:
        """Add the moments of each pixel's point about the centre, times weight/sigma^2.

        Parameters
        ----------
        sums : ndarray, shape (height, width, 9)
            Sums to which the moments are added, as `correspondence` lays them out.
        T_base_grid : ndarray, shape (4, 4)
            Pose of the grid.
        centre : ndarray, shape (3,)
            Centre, base frame.
        weight : float
            Weight of the view.
        """
        plane = T_base_grid[:3, [0, 1, 3]] - np.outer(centre, [0.0, 0.0, 1.0])
        add_points(sums, self.location[:], self.sigma[:], plane, weight)


def dense_view(
    location: Any, sigma: Any = None, mask: ArrayLike | None = None, name: str = ""
) -> DenseView:
    """Return the DenseView of decoded points.

    The first three parameters are what `raxel.features.active_grid.decoding` gives. In
    the image, x should turn clockwise into y. Where it turns the other way for most
    pixels, as through a mirror, the image of the grid is taken as the grid. Then y is
    counted upwards, with a minus sign.

    Parameters
    ----------
    location : ndarray or StoredArray, shape (H, W, 2)
        Point of the grid that each pixel sees; NaN (or beyond MAX_COORDINATE_MM) where
        unknown.
    sigma : ndarray or StoredArray, shape (H, W, 2), or None
        Standard deviations in the same unit; None where unknown.
    mask : array_like of bool, shape (H, W), or None
        Where a location counts; None for all that are finite.
    name : str
        Name for messages.

    Returns
    -------
    DenseView
        The view.

    Raises
    ------
    InputError
        If the shapes do not fit.
    CalibrationError
        If fewer than MIN_N_PIXELS pixels have a point.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import dense_view
    >>> v, u = np.mgrid[0:40, 0:50]
    >>> view = dense_view(np.stack([0.5 * u, 0.5 * v], axis=2))
    >>> view.area(), view.mirrored
    (2000, False)
    >>> view.locate([[10.5, 4.0]])[0].round(4).tolist()
    [[5.25, 2.0]]
    """
    name = name or "grid"
    location = _single(location[:])
    if location.ndim != 3 or location.shape[2] != 2:
        raise InputError(
            f"{name}: location: found shape {location.shape}; give (height, width, 2)"
        )
    seen = np.isfinite(location).all(axis=2)
    if mask is not None:
        seen &= _fitting(name, "mask", np.asarray(mask, bool), seen.shape)
    if sigma is None:
        deviations = np.ones_like(location)
    else:
        deviations = _fitting(name, "sigma", _single(sigma[:]), location.shape)
        seen &= (deviations >= 0).all(axis=2)
        np.maximum(deviations, MIN_SIGMA_MM, out=deviations)
    count = np.count_nonzero(seen)
    if count < MIN_N_PIXELS:
        raise CalibrationError(
            f"{name}: found {count} pixels with a point on both axes; give at least "
            f"{MIN_N_PIXELS}",
            code="too-few-points",
        )
    for values in location, deviations:
        np.copyto(values, np.nan, where=~seen[..., None])
    whole = whole_cells(location, None if sigma is None else deviations)
    step = max(1, int(np.sqrt(count / N_SAMPLES)))
    pixels = _lattice(seen, step)
    rows, columns, _ = pixels.shape
    pixels = pixels.reshape(-1, 2)
    found = np.isfinite(pixels[:, 0])
    u, v = pixels[found].astype(int).T
    slopes = _slopes(location, u, v)
    mirrored = bool(as_in_a_mirror(location))
    if mirrored:
        location[..., 1] *= -1
    points = np.zeros(pixels.shape)
    points[found] = location[v, u]
    sd = None
    if sigma is not None:
        sd = np.full(len(pixels), np.nan)
        sd[found] = _in_pixels(deviations[v, u], slopes)
    return DenseView(  # type: ignore[call-arg]
        pixels, points, columns, rows, name, sd,
        location, deviations, whole, step, mirrored,
    )  # fmt: skip


def _single(values):
    """A copy in single precision, NaN for values beyond MAX_COORDINATE_MM."""
    with np.errstate(over="ignore"):
        values = np.array(values, np.float32)
    values[(values > MAX_COORDINATE_MM) | (values < -MAX_COORDINATE_MM)] = np.nan
    return values


def _fitting(name, field, array, shape):
    if array.shape != shape:
        raise InputError(f"{name}: {field}: found shape {array.shape}; give {shape}")
    return array


def _lattice(seen, step):
    """(rows, columns, 2) float: every step-th pixel per axis, NaN where not seen."""
    v, u = (np.arange(step // 2, size, step) for size in seen.shape)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).astype(float)
    pixels[~seen[np.ix_(v, u)]] = np.nan
    return pixels


def _slopes(location, u, v):
    """Derivatives of points by pixels: (N, 2, 2), columns by u and v; NaN at edges."""
    height, width, _ = location.shape
    slopes = np.full((len(u), 2, 2), np.nan)
    inside = (
        (u >= DERIVATIVE_REACH_PX)
        & (u < width - DERIVATIVE_REACH_PX)
        & (v >= DERIVATIVE_REACH_PX)
        & (v < height - DERIVATIVE_REACH_PX)
    )
    u, v = u[inside], v[inside]
    slopes[inside, :, 0] = (
        location[v, u + DERIVATIVE_REACH_PX] - location[v, u - DERIVATIVE_REACH_PX]
    )
    slopes[inside, :, 1] = (
        location[v + DERIVATIVE_REACH_PX, u] - location[v - DERIVATIVE_REACH_PX, u]
    )
    return slopes / (2 * DERIVATIVE_REACH_PX)


def _in_pixels(sigma, slopes):
    """Standard deviation (N,) px along an axis of points with sigma (N, 2)."""
    variance = sigma[:, ::-1].astype(float) ** 2
    across = np.sum(np.sum(slopes**2, axis=2) * variance, axis=1)
    (a, b), (c, d) = np.moveaxis(slopes, 0, 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(across / 2) / np.abs(a * d - b * c)
    return np.where(np.isfinite(sd), sd, np.nan)
