"""Means over pixels that an edge crosses."""

import numba
import numpy as np

from raxel.lab.scene import NO_RAY, NOTHING
from raxel.lab.textures import LUMINANCE

# Nodes of a pixel: its corners, the middles of its sides, its centre, row by row.
NODES = np.array([(u, v) for v in (-0.5, 0.0, 0.5) for u in (-0.5, 0.0, 0.5)])
CORNERS, OTHERS = [0, 2, 6, 8], [1, 3, 4, 5, 7]
# Where second differences are below this share of the first, third ones are below
# some 1e-4 of them, and so is the error of a surface of second degree through the
# nodes, in pixels. Jumps and kinks of a camera's map exceed it.
SMOOTH = 0.02
SAMPLES_AT_ONCE = 1 << 18
# Mean of a parabola from its values at both ends and in the middle.
SIMPSON = np.array([1, 4, 1]) / 6


def lattice(samples):
    """Rank-1 lattice of positions (samples, 2) in the square [-0.5, 0.5]^2.

    Both coordinates alone are the centred, even grid (i + 1/2)/n - 1/2, and the set is
    its own reflection in the centre: so an edge through the middle of a pixel, and one
    parallel to its side, are halved without bias.
    """
    odd = np.arange(1, samples + 1, 2)
    odd = odd[np.gcd(odd, samples) == 1]
    # The golden section spreads the points evenly also along slanting edges.
    generator = odd[np.argmin(np.abs(odd - samples * (np.sqrt(5) - 1) / 2))]
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
    """Means over whole pixels by a set of positions in the pixel.

    viewer: where rays come from; positions: (S, 2) in [-0.5, 0.5]^2, of equal weight.
    """

    def __init__(self, viewer, positions):
        self.viewer, self.positions = viewer, np.asarray(positions, float)
        self._spread = _quadratic(self.positions[:, 1])[:, :, None]
        self._spread = self._spread * _quadratic(self.positions[:, 0])[:, None, :]
        self._spread = self._spread.reshape(-1, 9)

    @property
    def pixels_at_once(self):
        """How many pixels to handle at once to bound memory."""
        return max(1, SAMPLES_AT_ONCE // len(self.positions))

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
        """Mean radiance of pixels (n, 2) whose corners, `Sight` (n, 4), see one part.

        Within such a pixel uv comes from a surface of second degree through nine rays.
        A texture that knows the mean over a parallelogram then needs no positions.
        Where the camera's map is not smooth, or something else shows through, every
        position has its own ray.
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
    """Whether second differences of uv (n, 3, 3, 2) are small beside the first."""
    good = np.ones(len(uv), bool)
    for a, b, c in (
        (uv[:, 0], uv[:, 1], uv[:, 2]),
        (uv[:, :, 0], uv[:, :, 1], uv[:, :, 2]),
    ):
        first = np.linalg.norm(c - a, axis=-1).max(axis=-1)
        second = np.linalg.norm(a - 2 * b + c, axis=-1).max(axis=-1)
        good &= second <= SMOOTH * first
    return good
