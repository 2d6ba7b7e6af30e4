"""From light on the sensor to the numbers in a file.

Light is counted in electrons of one pixel of the image. The order is physical: photons
arrive at random, wells fill and overflow, the readout adds noise, and then the camera's
tone curve and rounding follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import cv2
import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.lab.textures import LUMINANCE

# Tone curve and rounding in one: the shares from which on a file has the next number.
# The integers of a nondecreasing curve are determined by the shares at which they
# change. Those are found once, to the last digit; then an image is counted off,
# pixel by pixel.


# Cells of the table that says near which step a share lies; a power of two is exact.
N_CELLS = 1 << 12
# Shares beyond these limits have the first number, or the last.
MAX_SHARE = 1e6


class ToneSteps(NamedTuple):
    """Hold the steps of a tone curve.

    steps: (n,) float32, the smallest share with the number 1, 2, ... n; below: number
    of steps below zero, then below the start of each cell.
    """

    steps: np.ndarray
    below: np.ndarray


def tone_steps(number_of, top):
    """Return the ToneSteps of a nondecreasing function (N,) -> (N,), up to `top`.

    number_of: integers of float32 shares. A number that is never reached has an
    infinite step.
    """
    wanted = np.arange(1, top + 1)
    low, high = (
        np.full(top, _rank(np.float32(far))) for far in (-MAX_SHARE, MAX_SHARE)
    )
    always = number_of(_share(low)) >= wanted
    never = number_of(_share(high)) < wanted
    while np.any(high - low > 1):
        middle = (low + high) // 2
        reached = number_of(_share(middle)) >= wanted
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    steps = np.where(always, -np.inf, np.where(never, np.inf, _share(high)))
    starts = np.arange(N_CELLS + 1) / N_CELLS
    below = np.searchsorted(steps, starts, side="right")
    return ToneSteps(steps.astype(np.float32), np.append(0, below))


def counted(share, steps, kind):
    """Numbers of an integer `kind`, shaped as the float32 shares, by ToneSteps."""
    image = np.empty(share.shape, kind)
    _count_into(image.reshape(-1), share.reshape(-1), *steps)
    return image


def _rank(share):
    """Return integers that increase with float32 numbers, one for each."""
    bits = np.asarray(share, np.float32).view(np.int32).astype(np.int64)
    return np.where(bits < 0, -(bits & 0x7FFFFFFF), bits)


def _share(rank):
    """The float32 number of a rank."""
    bits = np.where(rank < 0, -rank | 0x80000000, rank)
    return bits.astype(np.uint32).view(np.float32)


@numba.njit(cache=True, error_model="numpy")
def _count_into(image, share, steps, below):
    for n in range(len(share)):
        x = share[n]
        # NaN has the first number.
        number = below[int(min(x, np.float32(1)) * N_CELLS) + 1] if x >= 0 else 0
        while number < len(steps) and steps[number] <= x:
            number += 1
        image[n] = number


# Values processed at once, which fit into the cache.
BLOCK_VALUES = 1 << 15
# Electrons, below the limit of the generator.
MAX_ELECTRONS = 1e15
# Where white has so many, shot and read noise are one Gaussian, in a quarter of the
# time: the skewness of shot noise is below 0.05 from 400 electrons on, and where there
# are fewer read noise hides it.
MIN_GAUSSIAN_ELECTRONS = 5e4
# Between charges of a curve: steeper ones overflow.
MIN_CHARGE_STEP = 1e-9
BITS = {8: np.uint8, 16: np.uint16}
# Colour (red 0, green 1, blue 2) at (row, column) of the 2 x 2 mosaic.
BAYER = {
    "RGGB": ((0, 1), (1, 2)),
    "BGGR": ((2, 1), (1, 0)),
    "GRBG": ((1, 0), (2, 1)),
    "GBRG": ((1, 2), (0, 1)),
}
# OpenCV names a mosaic after its second row and column.
DEMOSAIC = {"RGGB": "BG", "BGGR": "RG", "GRBG": "GB", "GBRG": "GR"}


@dataclass(frozen=True)
class Sensor:
    """A sensor and what its camera does with the charge.

    Attributes
    ----------
    white_e : float
        Electrons that radiance 1.0 makes during the exposure.
    full_well_e : float
        Electrons at which a pixel is full; they give the largest number of the file.
    read_noise_e : float
        SD of the read noise, electrons.
    blooming : float
        Share of the charge above a full well that runs along the column into the next
        pixels; the rest is drained.
    gamma : float
        The file holds (charge / full well)^(1 / gamma).
    response : ((float, ...), (float, ...)) or None
        Instead of gamma: charges as shares of the full well, and shares of the range,
        linear in between.
    black_level : float
        Share of the file's range that stands for no charge.
    bits : int
        8 or 16.
    bayer : str or None
        Colours of the mosaic, row by row: 'RGGB', ...; None: no mosaic.
    jpeg : int or None
        Quality, 1 to 100, of the compression with which the camera saves the image, of
        8 bits; None: saved as it is.

    Raises
    ------
    InputError
        Naming the field that no sensor can have.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.lab import Sensor
    >>> sensor = Sensor(white_e=10_000, full_well_e=20_000)
    >>> image = sensor.expose(np.full((100, 100), 0.6), np.random.default_rng(0))
    >>> print(image.dtype, f"{image.mean():.0f}")  # 30 % of the range
    uint8 76
    """

    white_e: float
    full_well_e: float
    read_noise_e: float = 0.0
    blooming: float = 0.0
    gamma: float = 1.0
    response: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    black_level: float = 0.0
    bits: int = 8
    bayer: str | None = None
    jpeg: int | None = None

    def __post_init__(self):
        limits = {
            "white_e": (self.white_e > 0, "the exposure must be above 0"),
            "full_well_e": (self.full_well_e > 0, "it must be above 0"),
            "read_noise_e": (self.read_noise_e >= 0, "it must be 0 or more"),
            "blooming": (0 <= self.blooming <= 1, "give a share, 0 to 1"),
            "gamma": (self.gamma > 0, "it must be above 0"),
            "black_level": (0 <= self.black_level < 1, "give a share below 1"),
            "bits": (self.bits in BITS, "give 8 or 16"),
            "jpeg": (
                self.jpeg is None or (1 <= self.jpeg <= 100 and self.bits == 8),
                "give a quality from 1 to 100, with 8 bits, or leave it out",
            ),
            "bayer": (
                self.bayer is None or self.bayer in BAYER,
                f"give one of {', '.join(BAYER)}, or leave it out",
            ),
        }
        for name, (good, advice) in limits.items():
            if not good:
                found = getattr(self, name)
                raise InputError(f"field '{name}': value is {found}; {advice}")
        if self.response is not None:
            _check_response(*self.response)

    def expose(
        self,
        irradiance: NDArray[np.floating],
        rng: np.random.Generator,
        *,
        colour: bool = False,
    ) -> np.ndarray:
        """Return the numbers in the file that irradiance on the sensor leaves.

        With a mosaic each pixel sees one colour; the others come from its neighbours.

        Parameters
        ----------
        irradiance : (H, W) or (H, W, 3) array
            Light on the sensor; 1.0 makes `white_e` electrons.
        rng : numpy.random.Generator
            Draws the noise.
        colour : bool
            Whether to return red, green and blue, else the luminance of a
            coloured image.

        Returns
        -------
        (H, W) or (H, W, 3) uint8 or uint16 array
            The image as the camera saves it.
        """
        if self.bayer is None:
            share = self.read_out(irradiance, rng)
        else:
            share = demosaiced(
                self.read_out(mosaic(irradiance, self.bayer), rng), self.bayer
            )
        if colour and share.ndim == 2:
            share = np.repeat(share[..., None], 3, axis=-1)
        elif not colour and share.ndim == 3:
            share = share @ LUMINANCE.astype(np.float32)
        image = self.develop(share)
        return image if self.jpeg is None else compressed(image, self.jpeg)

    def read_out(
        self, irradiance: NDArray[np.floating], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """Return the charge after reading, as a share of the full well.

        Noise may make it negative.

        Parameters
        ----------
        irradiance : (H, W) or (H, W, 3) array
            Light on the sensor; 1.0 makes `white_e` electrons.
        rng : numpy.random.Generator
            Draws shot and read noise.

        Returns
        -------
        float32 array
            Shares of the full well, shaped as the irradiance.
        """
        irradiance = np.asarray(irradiance)
        at_once = self.white_e >= MIN_GAUSSIAN_ELECTRONS
        charge = np.empty(irradiance.shape, np.float32 if at_once else float)
        for rows in _row_blocks(charge):
            light = irradiance[rows].astype(charge.dtype)
            if at_once:
                noise = rng.standard_normal(light.shape, np.float32)
                _charge_into(
                    charge[rows].reshape(-1),
                    light.reshape(-1),
                    noise.reshape(-1),
                    np.float32(self.white_e),
                    np.float32(self.read_noise_e**2),
                )
            else:
                expected = np.maximum(light * self.white_e, 0)
                charge[rows] = rng.poisson(np.minimum(expected, MAX_ELECTRONS))
        charge = bloom(charge, self.full_well_e, self.blooming)
        share = np.empty(charge.shape, np.float32)
        for rows in _row_blocks(charge):
            block = charge[rows]
            if self.read_noise_e > 0 and not at_once:
                block = block + self.read_noise_e * rng.standard_normal(block.shape)
            share[rows] = block / self.full_well_e
        return share

    def develop(self, share: ArrayLike) -> np.ndarray:
        """Return the file's numbers after tone curve and rounding.

        Parameters
        ----------
        share : (H, W) or (H, W, 3) array_like
            Shares of the full well.

        Returns
        -------
        uint8 or uint16 array
            Shaped as the shares.
        """
        share = np.ascontiguousarray(share, np.float32)
        return counted(share, _steps_of(self), BITS[self.bits])

    def number(self, share: NDArray[np.floating]) -> NDArray[np.floating]:
        """Return the file's number, as a float, of shares (N,) of the full well."""
        top = 2**self.bits - 1
        toned = self.black_level + (1 - self.black_level) * self._toned(share)
        return np.clip(np.rint(top * toned), 0, top)

    def _toned(self, share):
        if self.response is not None:
            return np.interp(share, *self.response)
        if self.gamma != 1:
            return np.maximum(share, 0) ** np.float32(1 / self.gamma)
        return share


@numba.njit(cache=True, error_model="numpy")
def _charge_into(charge, light, noise, white_e, read_variance):
    """Electrons (N,) of light (N,), shot and read noise being `noise` (N,) of SD 1."""
    for n in range(len(charge)):
        expected = min(
            max(light[n] * white_e, np.float32(0)), np.float32(MAX_ELECTRONS)
        )
        charge[n] = expected + noise[n] * np.sqrt(expected + read_variance)


@lru_cache(maxsize=8)
def _steps_of(sensor):
    """The ToneSteps of a sensor."""
    return tone_steps(sensor.number, 2**sensor.bits - 1)


def _row_blocks(image):
    """Return slices of rows that cover the image (H, ...), BLOCK_VALUES values each."""
    height = max(1, BLOCK_VALUES * len(image) // max(image.size, 1))
    return (slice(i, i + height) for i in range(0, len(image), height))


def bloom(
    charge: NDArray[np.floating], full_well: float, share: float
) -> NDArray[np.floating]:
    """Return the charge with no well above full; a share of the rest runs on.

    The excess of a pixel is halved and runs up and down its column, each half until it
    has found room. Charge that runs off the sensor is lost.

    Parameters
    ----------
    charge : (H, W) or (H, W, C) array
        Electrons.
    full_well : float
        Electrons at which a pixel is full.
    share : float
        Share of the excess that runs on, 0 to 1; the rest is drained.

    Returns
    -------
    array
        Electrons, shaped as `charge`; `charge` itself where no well is above full.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.lab import bloom
    >>> column = np.array([[0.0], [3.0], [0.0]])
    >>> bloom(column, full_well=1.0, share=1.0).ravel().tolist()
    [1.0, 1.0, 1.0]
    """
    if charge.max(initial=0) <= full_well:
        return charge
    excess = np.maximum(charge - full_well, 0)
    charge = np.minimum(charge, full_well)
    if share == 0:
        return charge
    half = share / 2 * excess
    for rows in (range(len(charge)), range(len(charge) - 1, -1, -1)):
        carried = np.zeros_like(charge[0])
        for row in rows:
            taken = np.minimum(carried, full_well - charge[row])
            charge[row] += taken
            carried += half[row] - taken
    return charge


def compressed(image, quality):
    """An image (H, W) or (H, W, 3), uint8, after JPEG and back."""
    # OpenCV uses the order blue, green, red; the luminance weights depend on it.
    image = image[..., ::-1] if image.ndim == 3 else image
    as_file = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    back = cv2.imdecode(as_file, cv2.IMREAD_UNCHANGED)
    return np.ascontiguousarray(back[..., ::-1]) if back.ndim == 3 else back


def mosaic(image, pattern):
    """Return one colour per pixel (H, W) of (H, W, 3); a grey image is unchanged."""
    if image.ndim == 2:
        return image
    out = np.empty(image.shape[:2], image.dtype)
    for row, colours in enumerate(BAYER[pattern]):
        for column, c in enumerate(colours):
            out[row::2, column::2] = image[row::2, column::2, c]
    return out


def demosaiced(raw, pattern):
    """(H, W, 3) from one colour per pixel (H, W), shares of the full well.

    Bilinear, as OpenCV does it, on numbers of 16 bit; the range leaves room for noise
    on both sides.
    """
    low, high = -0.25, 1.25
    number = np.clip((raw - low) / (high - low), 0, 1) * 65535
    code = getattr(cv2, f"COLOR_Bayer{DEMOSAIC[pattern]}2RGB")
    image = cv2.cvtColor(np.rint(number).astype(np.uint16), code)
    return image.astype(np.float32) / 65535 * (high - low) + low


def _check_response(charge, value):
    """Raise unless a curve starts at no charge, ends at a full well, never falls."""
    ordered = len(charge) == len(value) >= 2 and np.all(
        np.diff(charge) > MIN_CHARGE_STEP
    )
    if not (ordered and charge[0] == 0 and charge[-1] == 1):
        raise InputError(
            f"field 'response': {len(charge)} charges and {len(value)} values; give as "
            "many of each, the charges rising from 0 to 1"
        )
    if np.any(np.diff(value) < 0) or min(value) < 0 or max(value) > 1:
        raise InputError(
            "field 'response': values fall or are outside 0 to 1; give rising values"
        )
