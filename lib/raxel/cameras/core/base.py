"""Interface of all cameras: pixels to rays, points to pixels, save and load.

Pixels are (u right, v down) with pixel centres at integers, in arrays (N, 2). Rays and
points are in the camera frame: for the parametric models x right, y down, z along the
optical axis, with the centre at the origin; mm (or the unit the camera names).
"""

from __future__ import annotations

import abc
from os import PathLike
from typing import Any, ClassVar, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.storage import write_camera
from raxel.errors import InputError
from raxel.io.documents import one_line

# Deviation of a set of rays from a central camera (2.3.1).


def closest_point(rays: Rays) -> NDArray[np.float64]:
    """Return the point with the least sum of squared distances to the rays' lines.

    Where many points do equally well, as for parallel rays, it is the one nearest the
    mean origin.

    Parameters
    ----------
    rays : Rays
        Rays in the camera frame; those that are not valid do not count.

    Returns
    -------
    ndarray, shape (3,)
        Point in the camera frame, mm.

    Raises
    ------
    ValueError
        No ray is valid.
    """
    origins, directions = _lines(rays)
    middle = origins.mean(axis=0)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    target = np.einsum("nij,nj->i", across, origins - middle)
    step = np.linalg.lstsq(across.sum(axis=0), target, rcond=1e-12)[0]
    return middle + step


def centrality(rays: Rays) -> float:
    """Return the smallest RMS distance of the rays' lines from one point.

    Lines are infinite: no half-line meets the centre behind a convex mirror.

    Parameters
    ----------
    rays : Rays
        Rays in the camera frame; those that are not valid do not count.

    Returns
    -------
    float
        Distance in mm, zero for a central camera.

    Raises
    ------
    ValueError
        No ray is valid.

    References
    ----------
    Thesis 2.3.1.
    """
    origins, directions = _lines(rays)
    reach = closest_point(rays) - origins
    return float(np.sqrt(np.mean(np.sum(np.cross(reach, directions) ** 2, axis=1))))


def _lines(rays):
    keep = rays.valid
    if not keep.any():
        raise ValueError("no valid ray")
    return rays.origins[keep], rays.directions[keep]


# Pixels and millimetres beyond this have no ray and no pixel: their squares and the
# products of these must not overflow.
MAX_COORDINATE = 1e100
SLOPE_STEP_PX = 0.5  # in differences of directions
# Scales and lengths: fourth powers, and pixels divided by one, must not overflow.
MIN_SCALE, MAX_SCALE = 1e-30, 1e30
# Coefficients of a polynomial, or corners of an outline: the roots of longer
# polynomials are noise, and their computation takes cubic time.
MAX_N_COEFFICIENTS = 200


class Rays(NamedTuple):
    """One half-line per pixel, in the camera frame.

    Attributes
    ----------
    origins : ndarray, shape (N, 3)
        Origins, mm, NaN where not valid.
    directions : ndarray, shape (N, 3)
        Unit directions away from the camera, NaN where not valid.
    valid : ndarray of bool, shape (N,)
        Whether the pixel has a ray.
    """

    origins: np.ndarray
    directions: np.ndarray
    valid: np.ndarray


class RaysWithCovariance(NamedTuple):
    """Rays with their predicted errors.

    Attributes
    ----------
    origins, directions, valid : ndarray
        As of `Rays`.
    covariance : ndarray, shape (N, 3, 3)
        Covariances of the directions, rad^2, NaN where unknown.
    """

    origins: np.ndarray
    directions: np.ndarray
    valid: np.ndarray
    covariance: np.ndarray


class Projection(NamedTuple):
    """One pixel per point.

    Attributes
    ----------
    pixels : ndarray, shape (N, 2)
        Pixel coordinates (u, v), px, NaN where not valid.
    valid : ndarray of bool, shape (N,)
        Whether the point has a pixel.
    """

    pixels: np.ndarray
    valid: np.ndarray


class Camera(abc.ABC):
    """A map between pixels and rays.

    Parametric models answer wherever their formula holds, also a little outside the
    image (a fit needs that); `in_image` returns which pixels are inside. A look-up
    table answers inside its table only.

    Attributes
    ----------
    kind : str or None
        Name of the kind of camera, a key of `CAMERAS`.
    width, height : int
        Size of the image, px.
    projects : bool
        False where a point has no pixel or no single one; `project` then reports why.
    continuous : bool
        False where neighbouring pixels may see positions far from each other.
    """

    kind: ClassVar[str | None] = None
    # False where a point has no pixel or several; `project` then documents it.
    projects = True
    # False where neighbouring pixels may see distant positions.
    continuous = True
    # Names of the fields that shape r(theta) of a radially symmetric kind; K: its size.
    width: int
    height: int
    # The board of the calibration as JSON, where it is not as specified.
    board: dict[str, Any] | None = None
    # Median distance of the boards of the calibration, where it is known.
    board_distance: float | None = None
    # Predicted errors of its rays, uu, uv, vv in px^2, at nodes (rows, columns, 3) that
    # are spread evenly from edge to edge of the image, NaN where unknown.
    error_nodes: NDArray[np.float64] | None = None
    # Cells of the image that a board of the calibration covered, bool, rows by columns.
    board_cells: NDArray[np.bool_] | None = None

    @property
    @abc.abstractmethod
    def central(self) -> bool:
        """Whether all rays meet in one point."""

    @property
    @abc.abstractmethod
    def parameters(self) -> int:
        """Number of free intrinsic parameters; width and height are not counted."""

    @overload
    def rays(
        self, pixels: ArrayLike, *, covariance: Literal[False] = False
    ) -> Rays: ...

    @overload
    def rays(
        self, pixels: ArrayLike, *, covariance: Literal[True]
    ) -> RaysWithCovariance: ...

    def rays(
        self, pixels: ArrayLike, *, covariance: bool = False
    ) -> Rays | RaysWithCovariance:
        """Return the rays of pixels.

        Parameters
        ----------
        pixels : array_like, shape (N, 2)
            Pixel coordinates (u, v), px.
        covariance : bool
            Whether the predicted errors of the directions are included, after the
            best common rotation of all rays that boards of the calibration covered.

        Returns
        -------
        Rays or RaysWithCovariance
            Rays in the camera frame; values that are not finite have none.
        """
        rays = self._rays(pixels)
        if not covariance:
            return rays
        pixels = as_rows(pixels, 2)
        slopes = self.direction_slopes(pixels)
        errors = slopes @ self.pixel_covariance(pixels) @ slopes.transpose(0, 2, 1)
        return RaysWithCovariance(*rays, errors)

    def direction_slopes(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivatives (N, 3, 2) of directions by pixels (N, 2)."""
        steps = [
            self._rays(pixels + step).directions - self._rays(pixels - step).directions
            for step in SLOPE_STEP_PX * np.eye(2)
        ]
        return np.stack(steps, axis=2) / (2 * SLOPE_STEP_PX)

    @abc.abstractmethod
    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays of pixels (N, 2)."""

    def pixel_covariance(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return covariances of the positions in the image of the rays of pixels.

        They are the predicted errors of where in the image the rays belong.

        Parameters
        ----------
        pixels : array_like, shape (N, 2)
            Pixel coordinates (u, v), px.

        Returns
        -------
        ndarray, shape (N, 2, 2)
            Covariances, px^2, NaN outside the image, or if none are known.
        """
        pixels = as_rows(pixels, 2)
        found = np.full((len(pixels), 2, 2), np.nan)
        nodes, spacing = self._node_errors()
        if nodes is not None:
            inside = self.in_image(pixels)
            found[inside] = _covariance_between(nodes, (pixels[inside] + 0.5) / spacing)
        return found

    def _node_errors(self):
        """(error_nodes or None, their spacing in px)"""
        if self.error_nodes is None:
            return None, None
        cells = np.array(self.error_nodes.shape[1::-1]) - 1
        return self.error_nodes, np.array([self.width, self.height]) / cells

    @abc.abstractmethod
    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels: the exact inverse of `rays`.
        """

    @abc.abstractmethod
    def _fields(self):
        """Content of the file: dict name -> array."""

    @classmethod
    @abc.abstractmethod
    def _from_file(cls, file):
        """Camera of a `CameraFile`."""

    def in_image(self, pixels: ArrayLike) -> NDArray[np.bool_]:
        """Return which pixels are on the image's cells, [-0.5, size - 0.5].

        Parameters
        ----------
        pixels : array_like, shape (..., 2)
            Pixel coordinates (u, v), px.

        Returns
        -------
        ndarray of bool, shape (...)
            Whether each is inside.
        """
        pixels = np.asarray(pixels, float)
        size = np.array([self.width, self.height])
        return np.all((pixels >= -0.5) & (pixels <= size - 0.5), axis=-1)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the camera to an .npz file, completely or not at all.

        `load_camera` reads it.

        Parameters
        ----------
        path : str or path-like
            File to write.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        names = "width", "height", "board_distance", "error_nodes"
        own = {name: getattr(self, name) for name in names}
        known = {name: np.array(v) for name, v in own.items() if v is not None}
        fields = known | self._fields()
        write_camera(path, self.kind, fields, self.board, self.board_cells)


def check_size(camera, width, height):
    """Set width and height, or raise InputError naming the field."""
    for name, value in (("width", width), ("height", height)):
        number = np.ndim(value) == 0 and isinstance(value, (int, float, np.number))
        if not (number and 1 <= value < MAX_COORDINATE and float(value).is_integer()):
            raise InputError(
                f"field '{name}': found {value}; give a whole number of pixels"
            )
        setattr(camera, name, int(value))


def checked_array(name, values, shape):
    """Finite, read-only float64 copy of `values` of this shape.

    None in `shape` means up to MAX_N_COEFFICIENTS. Raises InputError naming the field,
    also for numbers of MAX_COORDINATE and above.
    """
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as fault:
        raise InputError(
            f"field '{name}': not numeric, or lists of unequal length; give numbers, "
            "or lists of numbers of equal length"
        ) from fault
    fits = array.ndim == len(shape) and all(
        want in (None, got) for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise InputError(f"field '{name}': found shape {array.shape}; give {shape}")
    if max(array.shape, default=0) > MAX_N_COEFFICIENTS:
        raise InputError(
            f"field '{name}': found shape {array.shape}; give at most "
            f"{MAX_N_COEFFICIENTS} in a row"
        )
    if not (np.abs(array) < MAX_COORDINATE).all():
        raise InputError(
            f"field '{name}': values not finite, or beyond {MAX_COORDINATE:g}; "
            "remove them"
        )
    array.flags.writeable = False
    return array


def checked_positive(name, values, shape=()):
    """As `checked_array`, of scales or lengths: each from MIN_SCALE to MAX_SCALE."""
    array = checked_array(name, values, shape)
    if not ((array >= MIN_SCALE) & (array <= MAX_SCALE)).all():
        raise InputError(
            f"field '{name}': found {array.tolist()}; give positive values, "
            f"{MIN_SCALE:g} to {MAX_SCALE:g}"
        )
    return array


def checked_word(name, value, known):
    """`value`, one of the known words, or InputError naming the field."""
    if not isinstance(value, str) or value not in known:
        raise InputError(
            f"field '{name}': found {one_line(repr(value))}; give one of "
            + ", ".join(known)
        )
    return value


def checked_calibration_matrix(K):
    """K (3, 3) of the form (2.1), read-only, or InputError naming the field."""
    K = checked_array("K", K, (3, 3))
    upper = K[1, 0] == 0 and np.array_equal(K[2], [0, 0, 1])
    if not (upper and min(K[0, 0], K[1, 1]) >= MIN_SCALE):
        raise InputError(
            "field 'K': found " + str(K.tolist()) + "; give positive focal lengths, "
            "zeros below the diagonal, and 1 in the corner (2.1)"
        )
    return K


def as_rows(values: ArrayLike, length: int) -> NDArray[np.float64]:
    """Float64 rows (N, length) of an array passed to `rays` or `project`."""
    array = np.asarray(values, float)
    if array.ndim != 2 or array.shape[1] != length:
        raise ValueError(f"found shape {array.shape}; give (N, {length})")
    return array


def near_rows(values: ArrayLike, length: int) -> NDArray[np.float64]:
    """Rows (N, length) as from `as_rows`, NaN throughout for unusable ones.

    These contain a value that is not finite, or so large that its square may overflow.
    """
    array = as_rows(values, length)
    near = (np.abs(array) < MAX_COORDINATE).all(axis=1)
    return np.where(near[:, None], array, np.nan)  # type: ignore[index]


def pixel_grid(width: int, height: int) -> NDArray[np.float64]:
    """Return all pixel centres of an image, row by row.

    Parameters
    ----------
    width, height : int
        Size of the image, px.

    Returns
    -------
    ndarray, shape (height * width, 2)
        Pixel coordinates (u, v), px.

    Examples
    --------
    >>> from raxel.cameras import pixel_grid
    >>> pixel_grid(2, 2).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
    """
    v, u = np.mgrid[:height, :width]
    return np.column_stack([u.ravel(), v.ravel()]).astype(float)


def under_boards(camera, pixels):
    """Whether a board of the calibration covered the cells of pixels (N, 2) of the
    image: (N,) bool, all True for a camera without this area."""
    cells = np.ones((1, 1), bool) if camera.board_cells is None else camera.board_cells
    count = np.array(cells.shape[::-1])
    places = (pixels + 0.5) * count / [camera.width, camera.height]
    u, v = np.minimum(places.astype(int), count - 1).T
    return cells[v, u]


def _covariance_between(nodes, places):
    """Covariances (N, 2, 2), bilinear between nodes (rows, columns, 3) uu, uv, vv, at
    places (N, 2) (column, row)."""
    cell = np.clip(places.astype(int), 0, np.array(nodes.shape[1::-1]) - 2)
    s, t = (places - cell).T[..., None]
    i, j = cell.T
    upper = (1 - s) * nodes[j, i] + s * nodes[j, i + 1]
    lower = (1 - s) * nodes[j + 1, i] + s * nodes[j + 1, i + 1]
    uu, uv, vv = ((1 - t) * upper + t * lower).T
    return np.stack([uu, uv, uv, vv], axis=1).reshape(-1, 2, 2)


# Cameras that contain another camera: the viewer of mirrors, the lens of a field.


def nested_fields(name, camera):
    """Fields of a nested camera, with the names that `CameraFile.nested` reads."""
    size = {"width": np.array(camera.width), "height": np.array(camera.height)}
    fields = {"kind": np.array(camera.kind)} | size | camera._fields()
    return {f"{name}.{key}": value for key, value in fields.items()}


def finite_rows(points: ArrayLike) -> NDArray[np.float64]:
    """Points (N, 3), NaN in rows that are not finite or far beyond any scene."""
    return near_rows(points, 3)


def checked_rigid(name, T):
    """A read-only pose (4, 4), or InputError naming the field."""
    T = checked_array(name, T, (4, 4))
    R = T[:3, :3]
    rigid = np.abs(R @ R.T - np.eye(3)).max() < 1e-9 and np.linalg.det(R) > 0
    if not (rigid and np.array_equal(T[3], [0, 0, 0, 1])):
        raise InputError(
            f"field '{name}': not a rigid pose; give a rotation, a translation in mm "
            "and the last row 0 0 0 1"
        )
    return T
