"""Effects of a lens on the image before the sensor: shading, blur and colour fringes.

All are linear in radiance. Radii are pixels from the optical centre, or shares of the
half diagonal, as documented.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import raxel.lab
from raxel.cameras.core.base import Camera, Projection, Rays, as_rows
from raxel.cameras.core.smooth_rays import smooth_rays
from raxel.cameras.mirrors.flexible import FlexibleMirrorCamera
from raxel.errors import InputError
from raxel.geometry import rotate, transform
from raxel.lab.scene import NO_RAY, TexturedScene
from raxel.lab.textures import LUMINANCE

# Visible points of the scene for positions in a camera's image.


# Rays processed at once: a few MB, which fit into the cache.
RAYS_PER_BLOCK = 1 << 16


class Crop(NamedTuple):
    """Part of an image: its first pixel and its size.

    Attributes
    ----------
    u, v : int
        Column and row of the first pixel in the whole image.
    width, height : int
        Size of the part, px.
    full_width, full_height : int
        Size of the whole image, px.
    """

    u: int
    v: int
    width: int
    height: int
    full_width: int
    full_height: int

    @property
    def place(self) -> tuple[slice, slice]:
        """Rows and columns of the whole image, as an index of an array."""
        rows = slice(self.v, self.v + self.height)
        return rows, slice(self.u, self.u + self.width)


@dataclass(frozen=True)
class Raster:
    """Pixels of a camera's image, or of a `Crop` of it.

    Attributes
    ----------
    camera : Camera
        Any camera with rays.
    fineness : int
        How many pixels of the raster, each way, make one pixel of the camera.
    window : Crop or None
        Part of the camera's image; None: all of it.
    """

    camera: Camera
    fineness: int = 1
    window: Crop | None = None

    @property
    def width(self) -> int:
        """Pixels of a row."""
        return self.fineness * (self.window or self.camera).width

    @property
    def height(self) -> int:
        """Pixels of a column."""
        return self.fineness * (self.window or self.camera).height

    def rays(self, pixels: NDArray[np.float64]) -> Rays:
        """Return the rays of positions of the raster.

        Parameters
        ----------
        pixels : (N, 2) array
            Positions (u, v) in pixels of the raster.

        Returns
        -------
        Rays
            In the camera frame; origins may be one, (1, 3).
        """
        u, v = (self._in_camera(pixels[:, axis], axis) for axis in range(2))
        return smooth_rays(self.camera).rays(np.column_stack([u, v]))

    def grid(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> Rays:
        """Return the rays of all (u, v) of the raster, by rows.

        Parameters
        ----------
        u, v : (W,) and (H,) arrays
            Rising columns and rows, in pixels of the raster.

        Returns
        -------
        Rays
            H W rays as `rays` returns them.
        """
        u, v = self._in_camera(u, 0), self._in_camera(v, 1)
        return smooth_rays(self.camera).grid(u, v)

    def _in_camera(self, values, axis):
        first = self.window[axis] if self.window else 0
        return (values + 0.5) / self.fineness - 0.5 + first


class Sight(NamedTuple):
    """Hold what N positions view; arrays may have more leading dimensions.

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
        """Return the entries at an index of the leading dimensions."""
        return Sight(*(field[where] for field in self))


@dataclass(frozen=True)
class Viewer:
    """Hold a camera and its pose in a scene. T_world_camera: (4, 4), mm."""

    raster: Raster
    T_world_camera: np.ndarray
    scene: TexturedScene

    def look(self, pixels):
        """The `Sight` of positions (N, 2) in the image."""
        pixels = np.asarray(pixels, float)
        steps = range(0, len(pixels), RAYS_PER_BLOCK)
        blocks = (self.raster.rays(pixels[i : i + RAYS_PER_BLOCK]) for i in steps)
        parts = list(map(self._along, blocks))
        if len(parts) == 1:
            return parts[0]
        if not parts:
            return Sight(np.empty(0, np.int16), np.empty((0, 2)), np.empty(0))
        return Sight(*(np.concatenate(field) for field in zip(*parts, strict=True)))

    def look_at_grid(self, u, v):
        """The `Sight` (len(v), len(u)) of all (u, v), which rise."""
        return self._along(self.raster.grid(u, v)).reshaped(len(v), len(u))

    def _along(self, rays):
        origins, directions, valid = rays
        # Most scenes are set up in the camera's own frame.
        if not np.array_equal(self.T_world_camera, np.eye(4)):
            origins = transform(self.T_world_camera, origins)
            directions = rotate(self.T_world_camera, directions)
        part, uv, cosine = self.scene.hit(origins, directions)
        part[~valid] = NO_RAY
        return Sight(part, uv, cosine)


# A part of a rig's image as an image of its own. Where a mirror fills only some of
# a large image, the rest costs time and memory and shows nothing. A windowed rig
# renders the rectangle alone: pixel (0, 0) of its images is pixel (window.u,
# window.v) of the whole one, and lens and sensor treat it as they would there.


# Pixels around the window: the point spread function is narrower.
MARGIN_PX = 16


class WindowedCamera(Camera):
    """The part `window` (a `Crop`) of a camera's image. It is never written to disk.

    Pixels count from the window's own first pixel.
    """

    def __init__(self, camera, window):
        self.camera, self.window = camera, window
        self.width, self.height = window.width, window.height
        self.kind, self.continuous = camera.kind, camera.continuous
        self.projects = camera.projects
        self._first = np.array([window.u, window.v], float)

    @property
    def central(self):
        """As that of the camera."""
        return self.camera.central

    @property
    def parameters(self):
        """Those of the camera."""
        return self.camera.parameters

    def _rays(self, pixels):
        """Rays of pixels (N, 2)."""
        return self.camera.rays(as_rows(pixels, 2) + self._first)

    def project(self, points):
        """Pixels of points (N, 3)."""
        pixels, valid = self.camera.project(points)
        return Projection(pixels - self._first, valid)

    def _fields(self):
        raise InputError(f"{self.kind}: a window of an image; save the camera itself")

    @classmethod
    def _from_file(cls, file):
        raise InputError(f"{cls.kind}: cannot be stored; save the camera of the image")


def windowed(rig: raxel.lab.Rig, window: Crop) -> raxel.lab.Rig:
    """Return the rig that takes only a part of its image.

    Blur and vignetting are those of the same pixels of the whole image. The optical
    centre may lie outside the window. Blooming and blur ignore what lies beyond it.

    Parameters
    ----------
    rig : Rig
        The rig of the whole image.
    window : Crop
        The part to take.

    Returns
    -------
    Rig
        With a camera and optics of the part; its pixels count from the window's first.
    """
    camera, optics = rig.camera, rig.optics
    low, high = (sd**2 for sd in optics.blur_sd_px)
    share = (window.width**2 + window.height**2) / (camera.width**2 + camera.height**2)
    centre = optics.centre(camera.width, camera.height) - [window.u, window.v]
    optics = replace(
        optics,
        blur_sd_px=(low**0.5, max(low + (high - low) * share, 0) ** 0.5),
        centre_px=tuple(map(float, centre)),  # type: ignore[arg-type]
    )
    return replace(rig, camera=_windowed_camera(camera, window), optics=optics)


@lru_cache(maxsize=8)
def _windowed_camera(camera, window):
    """Return one object per window, so that its cached B-spline rays are shared."""
    return WindowedCamera(camera, window)


def window_around(
    camera: Camera, pixels: NDArray[np.float64], margin_px: int = MARGIN_PX
) -> Crop:
    """Return the `Crop` of a camera's image that holds given pixels and a margin.

    Parameters
    ----------
    camera : Camera
        Gives the size of the whole image.
    pixels : (N, 2) array
        Pixels (u, v); those that are NaN do not count.
    margin_px : int
        Margin on each side, px, clipped at the image's border.

    Returns
    -------
    Crop
        The smallest such part with whole pixels.

    Raises
    ------
    InputError
        `outside-image` where no pixel is in the image.
    """
    full = np.array([camera.width, camera.height])
    inside = pixels[camera.in_image(pixels)]
    if not len(inside):
        raise InputError(
            "window: entirely outside the image; rotate the camera",
            code="outside-image",
        )
    low = np.floor(np.nanmin(pixels, axis=0)) - margin_px
    high = np.ceil(np.nanmax(pixels, axis=0)) + margin_px + 1
    low = np.clip(low, 0, full).astype(int)
    high = np.clip(high, 0, full).astype(int)
    return Crop(*map(int, (*low, *(high - low), *full)))


def mirror_window(camera: FlexibleMirrorCamera) -> Crop:
    """Return the `Crop` that holds all that the sheet of a flexible mirror shows.

    Parameters
    ----------
    camera : FlexibleMirrorCamera
        A camera that views a flexible mirror.

    Returns
    -------
    Crop
        Part of the viewing camera's image, with a margin of 16 px.

    Raises
    ------
    InputError
        `outside-image` where nothing of the sheet is in the image.
    """
    points = camera.mirror.point(camera.mirror.nodes().reshape(-1, 2))[0]
    T = camera.T_viewer_mirror
    pixels = camera.viewer.project(points @ T[:3, :3].T + T[:3, 3]).pixels
    return window_around(camera, pixels)


def bands(window: Crop, count: int, height_px: int) -> list[Crop]:
    """Return evenly spaced bands of a window's whole width.

    Where some thousand pixels all over an image suffice, these cost less than all.

    Parameters
    ----------
    window : Crop
        The part of an image to divide.
    count : int
        Number of bands.
    height_px : int
        Rows of each band.

    Returns
    -------
    list of Crop
        `count` parts of the same image, from top to bottom.

    Raises
    ------
    InputError
        Where the window has fewer than `count` times `height_px` rows.

    Examples
    --------
    >>> from raxel.lab import Crop, bands
    >>> window = Crop(10, 20, 300, 200, full_width=640, full_height=480)
    >>> [(band.v, band.height) for band in bands(window, count=2, height_px=10)]
    [(65, 10), (165, 10)]
    """
    if not 0 < count * height_px <= window.height:
        raise InputError(
            f"bands: {count} of {height_px} rows exceed {window.height}; give fewer"
        )
    middle = window.v + window.height * (np.arange(count) + 0.5) / count
    return [
        window._replace(v=int(v), height=int(height_px)) for v in middle - height_px / 2
    ]


# Between neighbouring levels of blur the SD differs by at most this many px, or by this
# share of the smallest.
BLUR_STEP_PX, BLUR_STEP = 0.1, 0.15
# More levels than these are spaced by their ratio.
MAX_EVEN_STEPS = 64
# Taps of a discrete Gaussian reach this many SD, and at least this many px.
REACH_SD, REACH_PX = 6, 3
# Pixels from which one is resampled, along each axis.
RESAMPLING_TAPS = 6
# Parts of an image that are blurred on their own, with the few levels that each needs.
BLUR_TILE_PX = 256
# Steeper curves overflow.
MIN_RADIUS_STEP = 1e-6
NO_ABERRATION = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Optics:
    """Vignetting, blur and lateral chromatic aberration of a lens.

    Attributes
    ----------
    blur_sd_px : (float, float)
        SD of the Gaussian point spread at the optical centre, and at one half diagonal
        from it, px. The variance grows with the square of the radius.
    exit_pupil_px : float or None
        Distance of the exit pupil from the sensor in px; illumination then falls as
        cos^4 of the angle at which light arrives there. For a pinhole the focal length:
        then that is the field angle. None: no such falloff.
    falloff : ((float, ...), (float, ...)) or None
        Radii in px and shares of light: a measured curve in addition. It is linear in
        between and constant beyond its ends.
    chromatic_scale : (float, float, float)
        Magnification of red, green and blue about the centre. The camera model is that
        of the grey image, so only their ratios count. They are divided by their mean,
        weighted as in luminance.
    centre_px : (float, float) or None
        The optical centre (u, v); None: the middle of the image.

    Raises
    ------
    InputError
        Naming the field that no lens can have.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.lab import Optics
    >>> optics = Optics(exit_pupil_px=100.0)
    >>> image = optics.apply(np.ones((201, 201)))
    >>> print(f"{image[100, 100]:.2f} {image[100, 200]:.2f}")  # centre, 45 degrees
    1.00 0.25
    """

    blur_sd_px: tuple[float, float] = (0.0, 0.0)
    exit_pupil_px: float | None = None
    falloff: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    chromatic_scale: tuple[float, float, float] = NO_ABERRATION
    centre_px: tuple[float, float] | None = None

    def __post_init__(self):
        if min(self.blur_sd_px) < 0:
            raise InputError(
                f"field 'blur_sd': found {list(self.blur_sd_px)}; give the SD of the "
                "point spread, 0 or more"
            )
        if self.exit_pupil_px is not None and not self.exit_pupil_px > 0:
            raise InputError(
                f"field 'exit_pupil': found {self.exit_pupil_px}; it must be positive"
            )
        if self.falloff is not None:
            _check_falloff(*self.falloff)
        if not min(self.chromatic_scale) > 0:
            raise InputError(
                f"field 'chromatic_scale': found {list(self.chromatic_scale)}; give "
                "three magnifications near 1"
            )

    def apply(
        self, image: np.ndarray, fineness: int = 1, window: Crop | None = None
    ) -> NDArray[np.float32]:
        """Return the irradiance on the sensor from scene radiance.

        Within a pixel an edge has a share but no position. So blur at the sensor's own
        resolution shows edges in their right position, but with a wrong variance.
        Edges are up to 1/6 px^2 too narrow or 1/12 px^2 too wide, according to where
        in a pixel they are. With two pixels each way the error is about a quarter of
        that.

        Blur comes first, since it alone needs the finer pixels. A blurred image can be
        resampled without loss. Vignetting and magnifications change too slowly over a
        point spread for the order to matter.

        A grey image stays grey: its red, green and blue copies add up by luminance.
        Beyond the border the outermost pixels are repeated.

        Parameters
        ----------
        image : (H, W) or (H, W, 3) array
            Linear radiance.
        fineness : int
            How many pixels of `image` make one of the sensor, each way.
        window : Crop or None
            The part of which `image` is the radiance, where it is not the whole image.

        Returns
        -------
        (H / fineness, W / fineness[, 3]) float32 array
            Irradiance, in the unit of the radiance.
        """
        image = np.asarray(image, np.float32)
        if window is None:
            height, width = (size // fineness for size in image.shape[:2])
            window = Crop(0, 0, width, height, width, height)
        if max(self.blur_sd_px) > 0:
            image = self._blurred(image, fineness, window)
        if fineness > 1:
            image = _binned(image, fineness)
        light = _light(self, window.full_width, window.full_height)
        if light is not None:
            image = image * _over_colours(light[window.place], image)
        if len(set(self.chromatic_scale)) > 1:
            image = self._coloured(image, self._centre_in(window))
        return image

    def vignetting(self, width: int, height: int) -> NDArray[np.float32]:
        """Return the share of the light that each pixel keeps.

        Parameters
        ----------
        width, height : int
            Size of the image, px.

        Returns
        -------
        (height, width) float32 array
            Shares; read-only where the lens has a falloff.
        """
        light = _light(self, width, height)
        return np.ones((height, width), np.float32) if light is None else light

    def _centre_in(self, window):
        whole = self.centre(window.full_width, window.full_height)
        return whole - [window.u, window.v]

    def centre(self, width: int, height: int) -> NDArray[np.float64]:
        """Return the optical centre (u, v), px, in an image of this size."""
        middle = ((width - 1) / 2, (height - 1) / 2)
        return np.array(middle if self.centre_px is None else self.centre_px, float)

    def strongest_blur_px(self, width: int, height: int) -> float:
        """Return the largest SD of the point spread in an image of this size, px."""
        u, v = self.centre(width, height)
        farthest = max(u, width - 1 - u) ** 2 + max(v, height - 1 - v) ** 2
        share = farthest / ((width**2 + height**2) / 4)
        low, high = (sd**2 for sd in self.blur_sd_px)
        return float(np.sqrt(max(low, high, low + (high - low) * share)))

    def _blurred(self, image, fineness, window):
        """Each pixel between the two nearest of a few uniform blurs.

        A mixture of two Gaussians with shares linear in the variance has exactly the
        variance in between.
        """
        low, high = ((fineness * sd) ** 2 for sd in self.blur_sd_px)
        if low == high:
            return gaussian_blur(image, float(np.float32(low)))
        height, width = image.shape[:2]
        fine_centre = (self._centre_in(window) + 0.5) * fineness - 0.5
        diagonal = fineness**2 * (window.full_width**2 + window.full_height**2)
        bend = 4 * (high - low) / diagonal
        v2, u2 = _squares(width, height, fine_centre)
        # A pixel's variance is the sum of these, or 0 where a centre is out of the
        # middle and the sum negative.
        rows, columns = np.float32(low + bend * v2), np.float32(bend * u2)
        levels = _levels(
            *(max(0.0, float(end(rows) + end(columns))) for end in (np.min, np.max))
        )
        size = max(BLUR_TILE_PX, 4 * _reach(levels[-1]))
        blurred = np.empty_like(image)
        for v, u in itertools.product(range(0, height, size), range(0, width, size)):
            tile = slice(v, v + size), slice(u, u + size)
            variance = np.add.outer(rows[tile[0]], columns[tile[1]])
            blurred[tile] = _tile_blurred(image, tile, levels, np.maximum(variance, 0))
        return blurred

    def _coloured(self, image, centre):
        scales = np.array(self.chromatic_scale) / (LUMINANCE @ self.chromatic_scale)
        if image.ndim == 3:
            parts = [magnified(image[..., c], s, centre) for c, s in enumerate(scales)]
            return np.stack(parts, axis=-1)
        grey = np.zeros_like(image)
        for weight, scale in zip(LUMINANCE, scales, strict=True):
            grey += np.float32(weight) * magnified(image, scale, centre)
        return grey


@lru_cache(maxsize=4)
def _light(optics, width, height):
    """Return the share of light (height, width) of each pixel; None: all of it."""
    light = None
    squares = _squares(width, height, optics.centre(width, height))
    squared = np.add.outer(*squares).astype(np.float32)
    if optics.exit_pupil_px is not None:
        light = (1 + squared / np.float32(optics.exit_pupil_px**2)) ** -2
    if optics.falloff is not None:
        curve = np.interp(np.sqrt(squared), *optics.falloff).astype(np.float32)
        light = curve if light is None else light * curve
    if light is not None:
        light.flags.writeable = False
    return light


def _tile_blurred(image, tile, levels, variance):
    """A part of the image, two slices, blurred by the variance of each pixel.

    Of the levels only those next to these variances are needed.
    """
    first, last = np.searchsorted(levels, [variance.min(), variance.max()])
    levels = levels[max(0, first - 1) : last + 1]
    reach = _reach(levels[-1])
    parts = [(max(0, part.start - reach), part) for part in tile]
    around = image[tuple(slice(start, part.stop + reach) for start, part in parts)]
    inside = tuple(
        slice(part.start - start, part.stop - start) for start, part in parts
    )
    blurred = below = gaussian_blur(around, levels[0])[inside]
    for low, high in itertools.pairwise(levels):
        above = gaussian_blur(around, high)[inside]
        share = np.clip((variance - np.float32(low)) / np.float32(high - low), 0, 1)
        blurred = blurred + _over_colours(share, image) * (above - below)
        below = above
    return blurred


def _reach(variance):
    """Taps to either side of the discrete Gaussian, px."""
    return max(REACH_PX, int(np.ceil(REACH_SD * np.sqrt(variance))))


def gaussian_blur(image, variance):
    """Blur with the discrete Gaussian of this variance, px^2, which it has exactly.

    The kernel is exp(-v) I_n(v) (Lindeberg 1990, doi:10.1109/34.49051). Samples of the
    continuous Gaussian would have a different variance where it is small.
    """
    import cv2
    from scipy.special import ive

    if variance == 0:
        return image
    reach = _reach(variance)
    kernel = ive(np.abs(np.arange(-reach, reach + 1)), variance)
    kernel /= kernel.sum()
    return cv2.sepFilter2D(
        image, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REPLICATE
    )


def magnified(image, scale, centre):
    """Return the image (H, W) magnified by `scale` about `centre` (2,).

    Rows and columns are resampled in turn at the exact positions, by the polynomial
    through the six nearest pixels. Straight ramps stay straight, and so edges stay in
    place. Beyond the border the outermost pixels are repeated.
    """
    if scale == 1:
        return image
    for axis in range(2):
        image = _stretched(image, scale, centre[1 - axis], axis)
    return image


def _stretched(image, scale, centre, axis):
    """Return the rows (axis 0) or columns of an image stretched about `centre`."""
    count = image.shape[axis]
    source = centre + (np.arange(count) - centre) / scale
    first = np.floor(source).astype(int) - RESAMPLING_TAPS // 2 + 1
    taps = first[:, None] + np.arange(RESAMPLING_TAPS)
    weights = _lagrange(source - first).astype(np.float32)
    if axis == 0:
        weights = weights[:, :, None]
    out = np.zeros(image.shape, np.float32)
    part = np.empty_like(out)
    for k, tap in enumerate(np.clip(taps, 0, count - 1).T):
        # Taps are in range; any other mode copies once more.
        np.take(image, tap, axis, part, mode="clip")
        part *= weights[:, k]
        out += part
    return out


def _lagrange(at):
    """Weights (N, RESAMPLING_TAPS) of samples at 0, 1, ... for values at `at` (N,)."""
    nodes = np.arange(RESAMPLING_TAPS)
    weights = np.ones((len(at), RESAMPLING_TAPS))
    for k in nodes:
        for other in nodes[nodes != k]:
            weights[:, k] *= (at - other) / (k - other)
    return weights


def _levels(low, high):
    """Variances from `low` to `high`, their roots evenly and closely spaced."""
    first, last = np.sqrt([low, high])
    if last - first < 1e-6:
        return [high]
    step = max(BLUR_STEP_PX, BLUR_STEP * first)
    steps = int(np.ceil((last - first) / step))
    if steps <= MAX_EVEN_STEPS:
        return np.linspace(first, last, steps + 1) ** 2
    # From sharp to soft: each level softer than the one before by the same factor.
    even = max(first, BLUR_STEP_PX / BLUR_STEP)
    below = np.arange(first, even, BLUR_STEP_PX)
    steps = int(np.ceil(np.log(last / even) / np.log1p(BLUR_STEP)))
    return np.concatenate([below, np.geomspace(even, last, steps + 1)]) ** 2


def _binned(image, fineness):
    """Means over fineness x fineness pixels."""
    height, width = (size // fineness for size in image.shape[:2])
    if image.ndim == 3:
        cells = image.reshape(height, fineness, width, fineness, -1)
        return cells.mean(axis=(1, 3))
    # Sums over whole rows and columns: numpy is slow along short axes.
    across = (
        sum(image[:, k::fineness] for k in range(1, fineness)) + image[:, ::fineness]
    )
    down = sum(across[k::fineness] for k in range(1, fineness)) + across[::fineness]
    return down / np.float32(fineness**2)


def _over_colours(factor, image):
    """Return a factor (H, W) in a shape that multiplies every colour of an image."""
    return factor.reshape(factor.shape + (1,) * (image.ndim - 2))


def _squares(width, height, centre):
    """Squared distances, px^2, of rows (height,) and columns (width,) from a centre."""
    return (np.arange(height) - centre[1]) ** 2, (np.arange(width) - centre[0]) ** 2


def _check_falloff(radii, shares):
    """A curve over radii that rise, of shares between 0 and 1."""
    rising = len(radii) == len(shares) >= 2 and np.all(np.diff(radii) > MIN_RADIUS_STEP)
    if not (rising and radii[0] >= 0):
        raise InputError(
            f"field 'falloff': {len(radii)} radii and {len(shares)} shares; give as "
            "many of each, two or more, the radii rising from 0"
        )
    if not (min(shares) >= 0 and max(shares) <= 1):
        raise InputError(
            f"field 'falloff': found shares from {min(shares)} to {max(shares)}; a "
            "lens passes between 0 and 1 of the light"
        )
