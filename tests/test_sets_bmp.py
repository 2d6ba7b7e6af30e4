"""Colours of a BMP of 32 bit lie where its masks say, or it is refused."""

import struct

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.sets.image_files import decode, file_fault, whole_file

HEIGHT, WIDTH = 4, 6
PLAIN, MASKED = 40, (56, 108, 124)  # headers without and with masks
AS_USUAL, BY_MASKS = 0, 3
BGRA = 0xFF0000, 0xFF00, 0xFF
IN_BYTES = {"RGBA": (0xFF, 0xFF00, 0xFF0000), "ABGR": (0xFF000000, 0xFF0000, 0xFF00)}
ODD = {
    "10 bit": (0x3FF00000, 0xFFC00, 0x3FF),
    "one byte twice": (0xFF, 0xFF, 0xFF),
    "across bytes": (0xFF00000, 0xFF000, 0xFF0),
    "no red": (0, 0xFF00, 0xFF),
}


def colours():
    """(HEIGHT, WIDTH, 3), R, G, B."""
    values = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH, 3))
    return values.astype(np.uint32)


def masked(header, masks, packing=BY_MASKS):
    """A BMP of 32 bit whose colours lie where the masks say, from the last row on."""
    shifts = [(mask & -mask).bit_length() - 1 if mask else 0 for mask in masks]
    pixels = sum(colours()[::-1, :, k] << shifts[k] for k in range(3) if masks[k])
    body = pixels.astype("<u4").tobytes()
    told = struct.pack("<III", *masks) if packing == BY_MASKS else b""
    about = struct.pack(
        "<IiiHHIIiiII", header, WIDTH, HEIGHT, 1, 32, packing, len(body), 0, 0, 0, 0
    )
    about = (about + told).ljust(header, b"\0")
    start = 14 + len(about)
    return b"BM" + struct.pack("<IHHI", start + len(body), 0, 0, start) + about + body


def read(data):
    assert file_fault(data) is None
    return decode("a.bmp", data, cv2.IMREAD_ANYCOLOR)[..., ::-1]


@pytest.mark.parametrize("header", [PLAIN, *MASKED])
@pytest.mark.parametrize("packing", [AS_USUAL, BY_MASKS])
def test_usual_colours_are_read_whatever_the_header(header, packing):
    np.testing.assert_array_equal(read(masked(header, BGRA, packing)), colours())


@pytest.mark.parametrize("header", MASKED)
@pytest.mark.parametrize("order", IN_BYTES)
def test_bytes_in_another_order_are_read_where_the_decoder_sees_masks(header, order):
    np.testing.assert_array_equal(read(masked(header, IN_BYTES[order])), colours())


@pytest.mark.parametrize("order", IN_BYTES)
def test_bytes_in_another_order_are_refused_where_it_does_not(order, tmp_path):
    refused(masked(PLAIN, IN_BYTES[order]), tmp_path)


@pytest.mark.parametrize("header", [PLAIN, *MASKED])
@pytest.mark.parametrize("kind", ODD)
def test_colours_that_are_no_bytes_of_their_own_are_refused(header, kind, tmp_path):
    refused(masked(header, ODD[kind]), tmp_path)


def refused(data, folder):
    path = folder / "a.bmp"
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"a\.bmp: a BMP whose colours lie .* as PNG"):
        whole_file(path)
