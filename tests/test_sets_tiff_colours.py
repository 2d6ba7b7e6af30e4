"""Colours of a TIFF: planes of their own, and what is said to be transparent."""

import struct

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.sets.image_files import decode, file_fault, whole_file

HEIGHT, WIDTH = 12, 20
TOGETHER, A_PLANE_EACH = 1, 2
TRANSPARENT = 2


def colours(depth):
    """(HEIGHT, WIDTH, 3), R, G, B."""
    values = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH, 3))
    return (values * (np.iinfo(depth).max // 255)).astype(depth)


def coloured(image, planes, extra=None):
    """A TIFF of grey, or of R, G, B, and further samples, the first of kind `extra`."""
    samples = image.shape[2]
    parts = np.moveaxis(image, 2, 0) if planes == A_PLANE_EACH else image[np.newaxis]
    parts = [np.ascontiguousarray(part).tobytes() for part in parts]
    tags = {
        256: (WIDTH,), 257: (HEIGHT,), 258: (8 * image.itemsize,) * samples, 259: (1,),
        262: (2 if samples > 2 else 1,), 273: (0,) * len(parts), 277: (samples,),
        278: (HEIGHT,), 279: tuple(map(len, parts)), 284: (planes,),
    }  # fmt: skip
    if extra is not None:
        tags[338] = (extra,)
    after = 8 + 2 + 12 * len(tags) + 4
    lists = 4 * sum(len(values) for values in tags.values() if len(values) > 1)
    sums = np.cumsum([0, *tags[279][:-1]]) + after + lists
    tags[273] = tuple(map(int, sums))
    entries, beside = b"", b""
    for tag, values in tags.items():
        written = struct.pack(f"<{len(values)}I", *values)
        if len(values) > 1:
            place = struct.pack("<I", after + len(beside))
            beside += written
        else:
            place = written
        entries += struct.pack("<HHI", tag, 4, len(values)) + place
    head = b"II*\0" + struct.pack("<IH", 8, len(tags))
    return head + entries + bytes(4) + beside + b"".join(parts)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_colours_of_a_pixel_that_lie_together_are_read(depth):
    image = colours(depth)
    data = coloured(image, TOGETHER)
    assert file_fault(data) is None
    found = decode("a.tif", data, cv2.IMREAD_ANYCOLOR)
    np.testing.assert_array_equal(found, image[..., ::-1])


def test_planes_of_8_bit_are_read_as_the_colours_that_they_are():
    image = colours(np.uint8)
    data = coloured(image, A_PLANE_EACH)
    assert file_fault(data) is None
    found = decode("a.tif", data, cv2.IMREAD_ANYCOLOR)
    np.testing.assert_array_equal(found, image[..., ::-1])


def test_planes_of_16_bit_are_refused(tmp_path):
    """The decoder takes three neighbours of the red plane for a pixel's colours."""
    path = tmp_path / "a.tif"
    path.write_bytes(coloured(colours(np.uint16), A_PLANE_EACH))
    with pytest.raises(InputError, match=r"a\.tif: .* plane for each colour.*as PNG"):
        whole_file(path)


@pytest.mark.parametrize("opacity", [0, 100, 255])
def test_what_is_said_to_be_transparent_stays_as_light_as_it_is(opacity):
    image = colours(np.uint8)
    opacities = np.full((HEIGHT, WIDTH, 1), opacity, np.uint8)
    data = coloured(np.dstack([image, opacities]), TOGETHER, extra=TRANSPARENT)
    found = decode("a.tif", data, cv2.IMREAD_ANYCOLOR)
    np.testing.assert_array_equal(found, image[..., ::-1])


@pytest.mark.parametrize("extra", [0, 1, TRANSPARENT, None])
def test_grey_of_8_bit_beside_opacity_is_read_as_it_is(extra):
    image = colours(np.uint8)[..., :2]
    found = decode("a.tif", coloured(image, TOGETHER, extra), cv2.IMREAD_ANYCOLOR)
    np.testing.assert_array_equal(found, image[..., 0])


@pytest.mark.parametrize("extra", [0, 1, TRANSPARENT, None])
def test_grey_of_16_bit_beside_opacity_is_refused(extra):
    """The decoder makes 8 bit of it, and says nothing."""
    data = coloured(colours(np.uint16)[..., :2], TOGETHER, extra)
    with pytest.raises(
        InputError, match=r"a\.tif: a TIFF of 16 bit .*; save it as PNG"
    ):
        decode("a.tif", data, cv2.IMREAD_GRAYSCALE)


@pytest.mark.parametrize("extra", [0, TRANSPARENT])
def test_colours_of_16_bit_beside_opacity_are_read_as_they_are(extra):
    image = np.dstack([colours(np.uint16), colours(np.uint16)[..., :1]])
    found = decode("a.tif", coloured(image, TOGETHER, extra), cv2.IMREAD_ANYCOLOR)
    assert found.dtype == np.uint16
    np.testing.assert_array_equal(found, image[..., 2::-1])
