"""What a cheap sheet of mirror has besides its bending: waves, and strained edges.

Both are heights over the bent sheet, so small that the length which they add (the
square of their slope) is neglected. They are multiplied by 1 - exp(-(x / CLAMPED)^2):
the clamp presses the sheet flat, so they vanish there with their slope.
"""

import numpy as np

from raxel.cameras.core.base import checked_array, checked_positive
from raxel.errors import InputError

# How far from the clamp the sheet is free again, mm.
CLAMPED = 15.0
WAVES = 4
# Nodes on which the RMS of the waves over the sheet is taken.
NODES = (97, 65)


class Unevenness:
    """size: (length from the clamp, width), mm. Heights are mm along z.

    aberration: RMS of the waves over the sheet, mm, after the clamp's flattening;
    wavelengths: (least, greatest), mm: WAVES plane waves of equal height with lengths
    drawn evenly between them, in directions and phases drawn evenly, from `seed`. The
    waves lie over x and y in the mirror's frame.
    strain: height of the three free edges, mm, falling off as exp(-distance / reach);
    beyond an edge, where no sheet is, as the first terms of that function's series.
    Raises InputError naming the field.
    """

    def __init__(self, size, aberration, wavelengths, seed, strain, reach):
        self.size = size
        self.aberration = float(checked_array("aberration", aberration, ()))
        self.wavelengths = checked_positive("wavelengths", wavelengths, (2,))
        self.strain = float(checked_array("strain", strain, ()))
        self.reach = float(checked_positive("strain_reach", reach))
        self.seed = _checked_seed(seed)
        if self.aberration < 0:
            raise InputError(
                f"field 'aberration': found {aberration}; give an RMS, mm, not negative"
            )
        if self.wavelengths[0] > self.wavelengths[1]:
            raise InputError(
                f"field 'wavelengths': found {self.wavelengths.tolist()}; give the "
                "least first, then the greatest"
            )
        rng = np.random.default_rng(self.seed)
        length = rng.uniform(*self.wavelengths, WAVES)
        angle = rng.uniform(0, 2 * np.pi, WAVES)
        self._phase = rng.uniform(0, 2 * np.pi, WAVES)
        self._wave = 2 * np.pi / length * np.stack([np.cos(angle), np.sin(angle)])
        self._height = 1.0
        self._height = self.aberration / self._rms()

    def _rms(self):
        share_x, share_y = (np.linspace(0, 1, n) for n in NODES)
        x, y = np.meshgrid(share_x * self.size[0], (share_y - 0.5) * self.size[1])
        waves = flattened(x.ravel(), self._waves(x.ravel(), y.ravel()))
        return np.sqrt(np.mean(waves[0] ** 2))

    @property
    def flat(self):
        """Whether there is no unevenness at all."""
        return not (self.aberration or self.strain)

    def at(self, x, y):
        """Height (N,) at x, y (N,), then its derivatives by x, y, xx, xy and yy."""
        height = np.zeros((6, len(x)))
        if self.aberration:
            height += self._waves(x, y)
        if self.strain:
            height += self._edges(x, y)
        return flattened(x, height)

    def _waves(self, x, y):
        k_x, k_y = self._wave
        angle = x[:, None] * k_x + y[:, None] * k_y + self._phase
        sine, cosine = self._height * np.sin(angle), self._height * np.cos(angle)
        return np.stack(
            [
                sine.sum(axis=1),
                *(cosine @ k_x, cosine @ k_y),
                *(-sine @ k_x**2, -sine @ (k_x * k_y), -sine @ k_y**2),
            ]
        )

    def _edges(self, x, y):
        length, half = self.size[0], self.size[1] / 2
        end = self._edge(length - x)
        low, high = self._edge(half + y), self._edge(half - y)
        zero = np.zeros(len(x))
        return np.stack(
            [
                end[0] + low[0] + high[0],
                *(-end[1], low[1] - high[1]),
                *(end[2], zero, low[2] + high[2]),
            ]
        )

    def _edge(self, distance):
        """Height of one edge at a distance (N,) mm from it, and its derivatives."""
        way = -distance / self.reach
        inner = np.exp(np.minimum(way, 0))
        over = np.maximum(way, 0)
        terms = inner + over + over**2 / 2, inner + over, inner
        return [
            self.strain * term / (-self.reach) ** order
            for order, term in enumerate(terms)
        ]


def flattened(x, heights):
    """Heights (6, N), as `Unevenness.at` has them, pressed flat next to the clamp."""
    place = x / CLAMPED
    bell = np.exp(-(place**2))
    free, rise = 1 - bell, 2 * place * bell / CLAMPED
    turn = (2 - 4 * place**2) * bell / CLAMPED**2
    z, by_x, by_y, xx, xy, yy = heights
    return np.stack(
        [
            free * z,
            *(free * by_x + rise * z, free * by_y),
            *(free * xx + 2 * rise * by_x + turn * z, free * xy + rise * by_y),
            free * yy,
        ]
    )


def _checked_seed(seed):
    whole = np.ndim(seed) == 0 and isinstance(seed, (int, float, np.number))
    if not (whole and 0 <= seed < 2**53 and float(seed).is_integer()):
        raise InputError(f"field 'seed': found {seed}; give a whole number from 0 on")
    return int(seed)
