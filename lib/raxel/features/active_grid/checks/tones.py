"""Does the camera answer alike all over a picture, and in every one of them?

A camera that lifts what lies in dark parts and holds back what lies in bright ones, as
telephones do (HDR, local tone mapping), gives one and the same light other values from
picture to picture, by what each of them shows around it. So do a monitor that dims its
light in parts, and a lens that scatters a tenth of all light. Places are off where that
is not even along x or y, which is most so near the monitor's rim. The bright parts of a
Gray code tell it: one pixel is bright in many pictures, amid much else that is bright,
or little.
"""

import cv2
import numpy as np

from raxel.features.active_grid.checks.sample import Doubt

BRIGHT = 0.5  # of the contrast, picture less inverse: well on one side
EVERY = 2  # bands of which one is asked
BLOCK = 16  # columns of a band whose light is averaged
MIN_IN_BLOCK, MIN_BLOCKS = 30, 40
MARGIN = 6  # rows, of a band's 16
BLURRED = 3  # standard deviations of the blur, from edges
MIN_PICTURES = 3  # that are bright at a pixel
# Of the light. A twentieth of it that is scattered, and edges beyond the rows of bands,
# reach 0.009; from 0.02 on as few as 97 % of places by fine sines were within three
# standard deviations.
UNEVEN, MOST = 0.015, 0.9  # and of so many blocks


def tone_doubts(sample, blur_px):
    """A Doubt about light of a Sample that differs by what is around it, or none.

    blur_px: standard deviation of the blur, None where it is not known. Told by Gray
    codes, of which a pixel is bright in MIN_PICTURES at least. A picture that is
    brighter as a whole is no matter of this.
    """
    bright = _bright(sample, 1 + int(np.ceil(BLURRED * (blur_px or 1))))
    pictures = {k: sample.pictures[k, ::EVERY] for k in bright}
    shares = _shares(pictures, bright)
    # A picture that is darker as a whole moves the usual light where it has a say.
    usual = {k: np.median(share) for k, share in shares.items()}
    pictures = {k: pictures[k] / usual[k] for k in usual}
    off = _shares(pictures, {k: bright[k] for k in usual}).values()
    off = [np.abs(share - np.median(share)) for share in off]
    if sum(map(len, off)) < MIN_BLOCKS:
        return
    most = float(np.quantile(np.concatenate(off), MOST))
    if most > UNEVEN:
        yield Doubt(
            False,
            f"what is bright has other values by up to {100 * most:.1f} % from picture "
            "to picture, in some parts more than in others, as of a camera that sets "
            "its tones by what lies around (HDR, local tone mapping), a monitor that "
            "dims parts of its light or a lens that scatters much: places near the "
            "monitor's rim may be off by more than standard deviations say; switch "
            "both off, save raw pictures, clean the lens",
        )


def _shares(pictures, bright):
    """{picture: (B,) its light, where it is bright, as a share of what is usual there},
    in blocks; of pictures that have any."""
    shape = next(iter(bright.values())).shape if bright else (0, 0, 0)
    count = sum(bright.values(), np.zeros(shape, np.float32))
    level = sum(pictures[k] * on for k, on in bright.items()) / np.maximum(count, 1)
    known = (count >= MIN_PICTURES) & (level > 0)
    found = {}
    for k, on in bright.items():
        on = on & known
        share = _of_blocks(pictures[k] * on, level * on, on)
        if len(share):
            found[k] = share
    return found


def _bright(sample, reach):
    """{picture: (bands, BAND, W) bool, where it is bright}, `reach` px from its edges,
    of each EVERY-th band."""
    found, square = {}, np.ones((2 * reach + 1,) * 2, np.uint8)
    # What lies before and behind a band may be an edge.
    inner = np.s_[min(reach, MARGIN) : -min(reach, MARGIN)]
    for axis, code in enumerate(sample.codes):
        for bit, pair in enumerate(code.bits):
            apart = sample.apart(axis, bit)[::EVERY]
            for picture, sign in zip(pair, (1, -1), strict=True):
                if picture is not None:
                    on = sample.lit[::EVERY] & (sign * apart > BRIGHT)
                    bands = [cv2.erode(band.astype(np.uint8), square) for band in on]
                    found[picture] = np.zeros(on.shape, bool)
                    found[picture][:, inner] = np.array(bands)[:, inner] > 0
    return found


def _of_blocks(light, level, on):
    """(B,) light as a share of what is usual, in blocks with enough of both."""
    width = on.shape[2] // BLOCK * BLOCK
    sums = [
        one[..., :width].sum(axis=1).reshape(len(one), -1, BLOCK).sum(axis=2)
        for one in (light, level, on)
    ]
    enough = sums[2] >= MIN_IN_BLOCK
    return sums[0][enough] / sums[1][enough]
