"""Images without lens or sensor: the mean radiance over each pixel's square.

A pixel is the square of side 1 around its centre. Its value is the mean, over that
square, of the radiance that the camera's rays meet. Positions without a ray are black.
Rays go through the corners that pixels share. Where all four corners view one region of
one texture the pixel has that colour. An edge of a texture across a pixel covers an
exact share of it. Where edges meet, and on borders between surfaces, the pixel is
sampled.

A detail inside one pixel that touches none of its corners can be missed: the tip of a
sheet's corner, or a free-standing surface thinner than a pixel. Squares and stripes of
a texture are separate regions (`Texture.label`), so none is missed, however thin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera
from raxel.errors import InputError
from raxel.io.files import physical_memory
from raxel.lab.optics import RAYS_PER_BLOCK, Crop, Raster, Sight, Viewer
from raxel.lab.scene import NO_RAY, NOTHING, TexturedScene
from raxel.lab.textures import LUMINANCE, Texture

# Means over pixels that an edge crosses.


# Nodes of a pixel: its corners, the middles of its sides, its centre, row by row.
NODES = np.array([(u, v) for v in (-0.5, 0.0, 0.5) for u in (-0.5, 0.0, 0.5)])
CORNERS, OTHERS = [0, 2, 6, 8], [1, 3, 4, 5, 7]
# Where second differences are below this share of the first, third ones are below
# some 1e-4 of them, and so is the error of a surface of second degree through the
# nodes, in pixels. Jumps and kinks of a camera's map exceed it.
MAX_CURVATURE_SHARE = 0.02
SAMPLES_PER_BLOCK = 1 << 18
# Mean of a parabola from its values at both ends and in the middle.
SIMPSON = np.array([1, 4, 1]) / 6


def lattice(samples):
    """Return a rank-1 lattice of positions (samples, 2) in the square [-0.5, 0.5]^2.

    Each coordinate alone is the centred, regular grid (i + 1/2)/n - 1/2, and the set is
    point-symmetric about the centre. So an edge through the centre of a pixel, and one
    parallel to its side, are halved without bias.
    """
    uneven = np.arange(1, samples + 1, 2)
    uneven = uneven[np.gcd(uneven, samples) == 1]
    # The golden section spreads the points evenly also along slanting edges.
    generator = uneven[np.argmin(np.abs(uneven - samples * (np.sqrt(5) - 1) / 2))]
    i = np.arange(samples) + 0.5
    return np.column_stack([i / samples, (i * generator / samples) % 1.0]) - 0.5


def tinted(radiance, colour):
    """Radiance (..., [3]) with N leading as RGB (N, 3), or as its luminance (N,)."""
    radiance = np.asarray(radiance)
    if colour:
        return radiance if radiance.ndim == 2 else radiance[:, None]
    return radiance @ LUMINANCE if radiance.ndim == 2 else radiance


def numbers_in(part):
    """The parts that occur in `part`, an int16 array of any shape, in rising order."""
    return np.flatnonzero(_occurring(part.ravel(), part.max(initial=NO_RAY))) + NO_RAY


@numba.njit(cache=True)
def _occurring(part, last):
    found = np.zeros(last - NO_RAY + 1, np.bool_)
    for number in part:
        found[number - NO_RAY] = True
    return found


def seen_radiance(sight, textures, background, colour):
    """Radiance of a flat `Sight` (N,): (N,) or (N, 3), black without a ray."""
    part = sight.part
    shape = (len(part), 3) if colour else len(part)
    radiance = np.zeros(shape, np.float32)
    for number in numbers_in(part):
        if number == NO_RAY:
            continue
        here = np.flatnonzero(part == number)
        if number == NOTHING:
            values = np.asarray(background, np.float32)[None]
        else:
            values = textures[number].radiance(sight.uv[here], sight.cosine[here])
        radiance[here] = tinted(values, colour)
    return radiance


class PixelMeans:
    """Average over whole pixels with a set of positions in the pixel.

    viewer: origin of the rays; positions: (S, 2) in [-0.5, 0.5]^2, of equal weight.
    """

    def __init__(self, viewer, positions):
        self.viewer, self.positions = viewer, np.asarray(positions, float)
        self._spread = _quadratic(self.positions[:, 1])[:, :, None]
        self._spread = self._spread * _quadratic(self.positions[:, 0])[:, None, :]
        self._spread = self._spread.reshape(-1, 9)

    @property
    def pixels_at_once(self):
        """Return the number of pixels per block that bounds the memory."""
        return max(1, SAMPLES_PER_BLOCK // len(self.positions))

    def look(self, pixels):
        """`Sight` (n, S) of all positions of pixels (n, 2), each by its own ray."""
        spots = pixels[:, None] + self.positions
        return self.viewer.look(spots.reshape(-1, 2)).reshaped(*spots.shape[:2])

    def mean(self, sight, textures, colour):
        """Mean radiance (n, [3]) of a `Sight` (n, S)."""
        n, samples = sight.part.shape
        background = self.viewer.scene.background
        radiance = seen_radiance(sight.reshaped(-1), textures, background, colour)
        return radiance.reshape(n, samples, *radiance.shape[1:]).mean(axis=1)

    def mean_inside(self, pixels, corners, textures, colour):
        """Return the mean radiance of pixels (n, 2) whose corners view one part.

        corners: `Sight` (n, 4). Within such a pixel uv comes from a surface of second
        degree through nine rays. A texture with closed-form means over a parallelogram
        needs no positions. Where the camera's map is not smooth, or another surface is
        visible, every position has its own ray.
        """
        others = pixels[:, None] + NODES[OTHERS]
        others = self.viewer.look(others.reshape(-1, 2)).reshaped(len(pixels), 5)
        uv = np.empty((len(pixels), 9, 2))
        uv[:, CORNERS], uv[:, OTHERS] = corners.uv, others.uv
        whole = (others.part == corners.part[:, :1]).all(axis=1)
        whole &= _smooth(uv.reshape(-1, 3, 3, 2))
        means = np.zeros((len(pixels), 3) if colour else len(pixels), np.float32)
        rest = np.flatnonzero(~whole)
        means[rest] = self.mean(self.look(pixels[rest]), textures, colour)
        for number in numbers_in(corners.part[whole]):
            here = np.flatnonzero(whole & (corners.part[:, 0] == number))
            found = self._on_texture(uv[here], others.cosine[here, 2], textures[number])
            means[here] = tinted(found, colour)
        return means

    def _on_texture(self, uv, cosine, texture):
        """Mean radiance (n, [3]) of pixels by their nodes uv (n, 9, 2)."""
        if not texture.averages:
            return self._sampled(uv, cosine, texture)
        nodes = uv.reshape(-1, 3, 3, 2)
        across = np.einsum("j,njc->nc", SIMPSON, nodes[:, :, 2] - nodes[:, :, 0])
        down = np.einsum("i,nic->nc", SIMPSON, nodes[:, 2] - nodes[:, 0])
        middle = np.einsum("j,i,njic->nc", SIMPSON, SIMPSON, nodes)
        means = texture.average(middle, across, down, cosine)
        open_ones = np.flatnonzero(np.isnan(means.reshape(len(means), -1)[:, 0]))
        means[open_ones] = self._sampled(uv[open_ones], cosine[open_ones], texture)
        return means

    def _sampled(self, uv, cosine, texture):
        spots = np.empty((len(uv), len(self.positions), 2))
        for axis in range(2):
            spots[..., axis] = uv[..., axis] @ self._spread.T
        cosine = np.repeat(cosine, len(self.positions))
        radiance = texture.radiance(spots.reshape(-1, 2), cosine)
        return radiance.reshape(*spots.shape[:2], *radiance.shape[1:]).mean(axis=1)


def _quadratic(t):
    """Weights (S, 3) of values at -0.5, 0, 0.5 in the parabola through them."""
    return np.stack([t * (2 * t - 1), 1 - 4 * t * t, t * (2 * t + 1)], axis=1)


def _smooth(uv):
    """Whether second differences of uv (n, 3, 3, 2) are small relative to the first."""
    good = np.ones(len(uv), bool)
    for a, b, c in (
        (uv[:, 0], uv[:, 1], uv[:, 2]),
        (uv[:, :, 0], uv[:, :, 1], uv[:, :, 2]),
    ):
        first = np.linalg.norm(c - a, axis=-1).max(axis=-1)
        second = np.linalg.norm(a - 2 * b + c, axis=-1).max(axis=-1)
        good &= second <= MAX_CURVATURE_SHARE * first
    return good


# Peak memory for one pixel: the image and its work arrays.
BYTES_RENDERED, BYTES_TRACED = 16, 96
# A centre farther from the middle of its pixel's corners than this share of the
# footprint betrays a jump of the camera's map inside the pixel.
MAX_CENTRE_OFFSET = 0.05
# Bits of a key that number the regions of a part.
REGION_BITS = 44


def render(
    camera: Camera,
    T_world_camera: ArrayLike,
    scene: TexturedScene,
    *,
    colour: bool = False,
    samples: int = 64,
    offsets: ArrayLike | None = None,
    fineness: int = 1,
    window: Crop | None = None,
) -> NDArray[np.float32]:
    """Return the radiance image of a scene, without lens or sensor.

    Each value is the mean radiance over the pixel's square. Pixels without a ray are 0.

    Parameters
    ----------
    camera : Camera
        Any camera with rays.
    T_world_camera : (4, 4) array_like
        Pose of the camera in the world, mm.
    scene : TexturedScene
        Surfaces and background.
    colour : bool
        Whether to return red, green and blue, else their luminance.
    samples : int
        Positions in a pixel that an edge crosses, in a rank-1 lattice.
    offsets : (S, 2) array_like or None
        Positions in [-0.5, 0.5]^2 to use instead.
    fineness : int
        Pixels each way that stand for one of the camera's.
    window : Crop or None
        Part of the camera's image to render; None: all of it.

    Returns
    -------
    (height, width) or (height, width, 3) float32 array
        Linear radiance, times `fineness` pixels each way.

    Raises
    ------
    InputError
        For an image too large for the memory.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.lab import Plain, Rectangle, TexturedScene, render
    >>> camera = PerspectiveCamera([[10, 0, 1], [0, 10, 1], [0, 0, 1]], [], 3, 3)
    >>> T = np.eye(4)
    >>> T[2, 3] = 10.0  # a sheet from the middle of the image to the right
    >>> sheet = Rectangle(T, 5.0, 10.0, corner=(0.0, -5.0))
    >>> image = render(camera, np.eye(4), TexturedScene(((sheet, Plain(1.0)),)))
    >>> print([f"{value:.2f}" for value in image[1]])
    ['0.00', '0.50', '1.00']
    """
    raster = Raster(camera, fineness, window)
    _check_memory(raster, BYTES_RENDERED * (3 if colour else 1))
    view = Viewer(raster, np.asarray(T_world_camera, float), scene)
    means = PixelMeans(view, lattice(samples) if offsets is None else offsets)
    textures = scene.textures
    centres = not all(texture.regional for texture in textures)
    image = _canvas(raster, colour)
    for rows in _row_blocks(raster):
        block = _trace_rows(view, rows, centres)
        image[rows.start : rows.stop] = _shade(block, means, textures, colour)
    return image


def trace(
    camera: Camera,
    T_world_camera: ArrayLike,
    scene: TexturedScene,
    *,
    samples: int = 64,
    offsets: ArrayLike | None = None,
) -> Traced:
    """Return the rays and intersections of a view, kept to shade many textures.

    Needs about 100 bytes a pixel.

    Parameters
    ----------
    camera : Camera
        Any camera with rays.
    T_world_camera : (4, 4) array_like
        Pose of the camera in the world, mm.
    scene : TexturedScene
        Surfaces and background.
    samples, offsets
        As in `render`.

    Returns
    -------
    Traced
        Its `shade` gives the image of `render` for any textures.

    Raises
    ------
    InputError
        For an image too large for the memory.
    """
    raster = Raster(camera)
    _check_memory(raster, BYTES_TRACED)
    view = Viewer(raster, np.asarray(T_world_camera, float), scene)
    means = PixelMeans(view, lattice(samples) if offsets is None else offsets)
    blocks = [_trace_rows(view, rows, True) for rows in _row_blocks(raster)]
    return Traced(view, means, tuple(blocks))


@dataclass(frozen=True)
class Traced:
    """A view of a scene whose rays have met their surfaces.

    Attributes
    ----------
    viewer : Viewer
        Raster, pose and scene.
    means : PixelMeans
        Means over pixels that an edge crosses.
    blocks : tuple
        What corners and centres of the pixels see, some rows each.
    """

    viewer: Viewer
    means: PixelMeans
    blocks: tuple

    def shade(
        self, textures: Mapping[int, Texture] | None = None, *, colour: bool = False
    ) -> NDArray[np.float32]:
        """Return the radiance image with textures exchanged.

        Parameters
        ----------
        textures : mapping of int to Texture, or None
            Textures by index of the part; other parts keep their own.
        colour : bool
            Whether to return red, green and blue, else their luminance.

        Returns
        -------
        (height, width) or (height, width, 3) float32 array
            As from `render`.
        """
        used = list(self.viewer.scene.textures)
        for number, texture in (textures or {}).items():
            used[number] = texture
        image = _canvas(self.viewer.raster, colour)
        for block in self.blocks:
            rows = block.rows
            image[rows.start : rows.stop] = _shade(block, self.means, used, colour)
        return image

    def mixed_pixels(
        self, number: int, lit: NDArray[np.intp]
    ) -> list[tuple[NDArray[np.intp], Callable[[Texture], np.ndarray]]]:
        """Return the pixels that see a part and something else, or see it unevenly.

        Parameters
        ----------
        number : int
            Index of the part.
        lit : (N,) int array
            Flat indices of the pixels that see the part alone.

        Returns
        -------
        list of (flat indices, function)
            A block of rows each; the function turns a texture of the part into the
            mean radiance of the pixels.
        """
        seen = np.zeros(self.viewer.raster.height * self.viewer.raster.width, bool)
        seen[lit] = True
        return [
            pair
            for block in self.blocks
            for pair in _mixed_pixels(block, self, number, seen)
        ]


@dataclass
class _Block:
    """Hold some rows of a view: sights of corners (h + 1, width + 1) and centres."""

    rows: range
    corners: Sight
    centres: Sight | None
    # Sights of positions in pixels on a border between surfaces; made when needed.
    borders: list = field(default_factory=list)


def _row_blocks(raster):
    height = max(1, RAYS_PER_BLOCK // (raster.width + 1) - 1)
    for first in range(0, raster.height, height):
        yield range(first, min(first + height, raster.height))


def _trace_rows(view, rows, centres):
    u, v = np.arange(view.raster.width + 1.0), np.arange(rows.start, rows.stop + 1.0)
    corners = view.look_at_grid(u - 0.5, v - 0.5)
    return _Block(rows, corners, view.look_at_grid(u[:-1], v[:-1]) if centres else None)


def _shade(block, means, textures, colour):
    """Rows of the image."""
    part = block.corners.part
    keys = _keys(block.corners, textures)
    edge, border = _edges(keys, part)
    if block.centres is not None:
        edge |= _keys(block.centres, textures) != keys[:-1, :-1]
    height, width = edge.shape
    image = np.zeros((height, width) + (3,) * colour, np.float32)
    for number in numbers_in(part):
        if number == NO_RAY:
            continue
        texture = None if number == NOTHING else textures[number]
        if texture is None or (texture.regional and texture.light is None):
            background = np.asarray(means.viewer.scene.background, np.float32)
            colours = background[None] if texture is None else texture.colours
            colours = np.asarray(tinted(colours, colour), np.float32)
            channels = (len(colours), 3 if colour else 1)
            colours = np.broadcast_to(colours.reshape(len(colours), -1), channels)
            _paint(image.reshape(height, width, -1), edge, part, keys, number, colours)
            continue
        inside = ~edge & (part[:-1, :-1] == number)
        if texture.averages and not (texture.regional or texture.even_inside):
            uneven = inside & ~_even(block)
            edge |= uneven
            inside &= ~uneven
        values = _inside_radiance(block, inside, texture, keys)
        image[inside] = tinted(values, colour)
    _shade_borders(block, border, means, textures, colour, image)
    _shade_edges(block, edge & ~border, means, textures, colour, image)
    return image


def lit_pixels(traced, number):
    """Return pixels that view one region of part `number` only, and their footprints.

    For textures of one region with closed-form means (`Texture.averages`). Returns flat
    indices (N,) in the image; uv, across, down (N, 2) mm, centre and sides of the
    footprints; cosine (N,).
    """
    width = traced.viewer.raster.width
    found = []
    for block in traced.blocks:
        v, u = np.nonzero(_alone(block, number) & _even(block))
        uv, cosine = block.centres.uv[v, u], block.centres.cosine[v, u]
        place = (v + block.rows.start) * width + u
        found.append((place, uv, *_sides(block, v, u), cosine))
    return tuple(np.concatenate(part) for part in zip(*found, strict=True))


def _alone(block, number):
    """Return pixels (h, w) that view part `number` at their corners and centre."""
    here = block.corners.part == number
    alone = here[:-1, :-1] & here[:-1, 1:] & here[1:, :-1] & here[1:, 1:]
    return alone & (block.centres.part == number)


def _mixed_pixels(block, traced, number, lit):
    here = block.corners.part == number
    some = here[:-1, :-1] | here[:-1, 1:] | here[1:, :-1] | here[1:, 1:]
    some |= block.centres.part == number
    width, means = traced.viewer.raster.width, traced.means
    first = block.rows.start * width
    some &= ~lit[first : first + some.size].reshape(some.shape)
    v, u = np.nonzero(some)
    step = means.pixels_at_once
    for i in range(0, len(v), step):
        row, column = v[i : i + step] + block.rows.start, u[i : i + step]
        sight = means.look(np.column_stack([column, row]).astype(float))
        yield row * width + column, _Mixed(sight, traced, number)


@dataclass(frozen=True)
class _Mixed:
    """Pixels by all their positions, `Sight` (n, S)."""

    sight: Sight
    traced: Traced
    number: int

    def __call__(self, texture):
        textures = list(self.traced.viewer.scene.textures)
        textures[self.number] = texture
        return self.traced.means.mean(self.sight, textures, False)


def _shade_borders(block, border, means, textures, colour, image):
    """Shade pixels between surfaces, which no texture changes."""
    v, u = np.nonzero(border)
    step = means.pixels_at_once
    for number, i in enumerate(range(0, len(v), step)):
        row, column = v[i : i + step], u[i : i + step]
        if number == len(block.borders):
            pixels = np.column_stack([column, row + block.rows.start]).astype(float)
            block.borders.append(means.look(pixels))
        image[row, column] = means.mean(block.borders[number], textures, colour)


def _shade_edges(block, edge, means, textures, colour, image):
    """Pixels on one surface with an edge of its texture inside."""
    v, u = np.nonzero(edge)
    step = means.pixels_at_once
    for i in range(0, len(v), step):
        row, column = v[i : i + step], u[i : i + step]
        pixels = np.column_stack([column, row + block.rows.start]).astype(float)
        ring = row[:, None] + [0, 0, 1, 1], column[:, None] + [0, 1, 0, 1]
        corners = block.corners.at(ring)
        image[row, column] = means.mean_inside(pixels, corners, textures, colour)


def _keys(sight, textures):
    """One number for each part and region of it; the region's makes the last bits."""
    part = sight.part.ravel()
    keys = _part_keys(part)
    uv = sight.uv.reshape(-1, 2)
    for number in numbers_in(part):
        if number < 0:
            continue
        here = np.flatnonzero(part == number)
        if len(here) == len(part):
            keys += textures[number].label(uv)
        else:
            keys[here] += textures[number].label(uv[here])
    return keys.reshape(sight.part.shape)


@numba.njit(cache=True)
def _part_keys(part):
    keys = np.empty(len(part), np.int64)
    for n in range(len(part)):
        keys[n] = (np.int64(part[n]) + 2) << REGION_BITS
    return keys


@numba.njit(cache=True)
def _edges(keys, part):
    """Pixels (h, w) with an edge between their corners; those between surfaces."""
    height, width = keys.shape[0] - 1, keys.shape[1] - 1
    edge, border = np.empty((2, height, width), np.bool_)
    for i in range(height):
        for j in range(width):
            first, one = keys[i, j], part[i, j]
            same = keys[i, j + 1] == first
            same &= (keys[i + 1, j] == first) & (keys[i + 1, j + 1] == first)
            whole = (one >= 0) & (part[i, j + 1] == one)
            whole &= (part[i + 1, j] == one) & (part[i + 1, j + 1] == one)
            edge[i, j], border[i, j] = not same, not (same or whole)
    return edge, border


@numba.njit(cache=True)
def _paint(image, edge, part, keys, number, colours):
    """Give pixels (h, w, c) on a part, without an edge, their region's colour."""
    height, width, channels = image.shape
    for i in range(height):
        for j in range(width):
            if part[i, j] == number and not edge[i, j]:
                region = keys[i, j] & ((1 << REGION_BITS) - 1)
                for c in range(channels):
                    image[i, j, c] = colours[region, c]


def _inside_radiance(block, inside, texture, keys):
    """Return the radiance of pixels (h, w) that view one region of one texture."""
    if texture.regional:
        row, column = np.nonzero(inside)
        # Of the upper left corner; the lower right one is a row and a step further.
        corner, uv = row * keys.shape[1] + column, block.corners.uv.reshape(-1, 2)
        colours = texture.colours[keys.ravel()[corner] & ((1 << REGION_BITS) - 1)]
        return texture.lit(colours, (uv[corner] + uv[corner + keys.shape[1] + 1]) / 2)
    uv, cosine = block.centres.uv[inside], block.centres.cosine[inside]
    if not texture.averages or texture.even_inside:
        return texture.radiance(uv, cosine)
    return texture.average(uv, *_sides(block, *np.nonzero(inside)), cosine)


def _sides(block, v, u):
    """Return sides (N, 2), (N, 2) in mm of the footprints of pixels (v, u)."""
    uv = block.corners.uv
    a, b, c, d = uv[v, u], uv[v, u + 1], uv[v + 1, u], uv[v + 1, u + 1]
    return (b + d - a - c) / 2, (c + d - a - b) / 2


def _even(block):
    """Return whether the centre of each pixel is the centre of its footprint."""
    return _centred(block.corners.uv, block.centres.uv)


@numba.njit(cache=True, error_model="numpy")
def _centred(corners, centres):
    """Return pixels (h, w) whose `centres` (h, w, 2) are centred between corners."""
    height, width, _ = centres.shape
    even = np.empty((height, width), np.bool_)
    for i in range(height):
        for j in range(width):
            offset = size = 0.0
            for k in range(2):
                a, b = corners[i, j, k], corners[i, j + 1, k]
                c, d = corners[i + 1, j, k], corners[i + 1, j + 1, k]
                offset += abs(centres[i, j, k] - (a + b + c + d) / 4)
                size += abs((b + d - a - c) / 2) + abs((c + d - a - b) / 2)
            even[i, j] = offset <= MAX_CENTRE_OFFSET * size
    return even


def _canvas(raster, colour):
    return np.zeros((raster.height, raster.width) + (3,) * colour, np.float32)


def _check_memory(raster, bytes_per_pixel):
    need = raster.width * raster.height * bytes_per_pixel
    have = physical_memory()
    if need > have / 2:
        raise InputError(
            f"camera: an image of {raster.width} x {raster.height} px needs "
            f"{need / 1e9:.3g} GB, this machine has {have / 1e9:.3g} GB and half is "
            "left to other work; give a smaller width and height"
        )
