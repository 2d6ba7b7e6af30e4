"""The pictures of a view: whether they fit each other, and in the form of the loops."""

from collections import Counter
from dataclasses import replace

import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.layout import AHEAD, REACH


def checked_pictures(images, patterns):
    """The pictures, if they fit each other and the patterns."""
    if not len(images) or len(images) != len(patterns):
        raise InputError(
            f"images: found {len(images)} for {len(patterns)} patterns; give one for "
            "each, in the same order"
        )
    kinds = Counter((np.shape(image), image.dtype) for image in images)
    usual = kinds.most_common(1)[0][0]
    if len(kinds) > 1:
        k = next(k for k, i in enumerate(images) if (i.shape, i.dtype) != usual)
        found, dtype = images[k].shape, images[k].dtype
        raise InputError(
            f"{patterns[k].image}: found a picture {found} {dtype} among those "
            f"{usual[0]} {usual[1]}; give all of a view in one size and depth"
        )
    if len(usual[0]) != 2 or usual[1] not in (np.uint8, np.uint16):
        raise InputError(
            f"images: found pictures {usual[0]} {usual[1]}; give grey ones, uint8 or "
            "uint16"
        )
    return images


class PictureStack:
    """The pictures as one stack in which every bit has an inverse, block by block."""

    def __init__(self, images, patterns, monitor_px, white, black):
        """As `decode.decode`; seen, codes: AxisCodes without and with what is made."""
        self.images, self.made = checked_pictures(images, patterns), []
        self.shape, self.dtype = np.shape(images[0]), images[0].dtype
        self.white, self.black = white, black
        self.names = [pattern.image for pattern in patterns]
        self.seen = read_coding(patterns, monitor_px)
        self.codes = tuple(map(self._completed, self.seen))
        whole = isinstance(images, np.ndarray) and images.flags.c_contiguous
        self.as_it_lies = whole and not self.made

    def _completed(self, code):
        bits = []
        for picture, inverse in code.bits:
            if inverse is None:
                if not code.steps and (self.white is None or self.black is None):
                    alone = [k for k, other in code.bits if other is None]
                    files = ", ".join(self.names[k] for k in alone)
                    raise InputError(
                        f"patterns: axis {'xy'[code.axis]}: Gray code without inverse "
                        f"({files}); give the inverse pictures, or those of white and "
                        "black"
                    )
                inverse = len(self.images) + len(self.made)
                self.made.append((picture, code.steps))
            bits.append((picture, inverse))
        return replace(code, bits=tuple(bits))

    def rows(self, first, stop):
        """(stack, the picture's row where it begins) with what is needed around."""
        if self.as_it_lies:
            return self.images, 0
        start, end = max(0, first - REACH), min(self.shape[0], stop + AHEAD)
        block = np.empty(
            (len(self.images) + len(self.made), end - start, self.shape[1]), self.dtype
        )
        for k, image in enumerate(self.images):
            block[k] = image[start:end]
        for k, (picture, steps) in enumerate(self.made, len(self.images)):
            block[k] = self._inverse(block, picture, steps, slice(start, end))
        return block, start

    def _inverse(self, block, picture, steps, part):
        """What an inverse would have shown, as far from the middle."""
        if self.white is not None and self.black is not None:
            twice = self.white[part].astype(np.int32) + self.black[part]
        else:
            twice = np.rint(2 * np.mean(block[list(steps)], axis=0)).astype(np.int32)
        most = np.iinfo(self.dtype).max
        return np.clip(twice - block[picture], 0, most)

    def apart(self, pair, where):
        """A picture of `codes` less its inverse, float32, at an index into pictures."""
        light, inverse = pair
        value = self.images[light][where].astype(np.float32)
        if inverse < len(self.images):
            return value - self.images[inverse][where]
        if self.white is not None and self.black is not None:
            return 2 * value - self.white[where] - self.black[where]
        steps = self.made[inverse - len(self.images)][1]
        return 2 * value - 2 * np.mean([self.images[k][where] for k in steps], axis=0)

    def together(self, pair, where):
        """As `apart`, a picture and its inverse, or None where none was taken."""
        if pair[1] >= len(self.images):
            return None
        light, dark = (self.images[k][where].astype(np.float32) for k in pair)
        return light + dark

    def for_noise(self):
        """Pictures without many edges: the sines, else the coarsest bits."""
        sines = [k for code in self.codes for k in code.steps]
        coarse = [code.bits[0][0] for code in self.codes if code.bits]
        return [self.images[k] for k in sines[:8] or coarse]
