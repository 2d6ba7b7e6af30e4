"""BMP, where its decoder says nothing: whole files, size, and where colours lie."""

import struct

SIGNATURE = b"BM"
BY_RUN_LENGTHS, BY_MASKS = (1, 2), 3
RUN_LENGTHS = (
    "a BMP packed by run lengths, which may leave pixels out; save it as PNG, or "
    "unpacked"
)
ODD_COLOURS = (
    "a BMP whose colours lie elsewhere than in bytes of B, G, R, which is not read; "
    "save it as PNG, or with 24 bit"
)
# What masks of red, green and blue of a pixel of 32 bit say where there are none.
USUAL = (0xFF0000, 0xFF00, 0xFF)
BYTES = {0xFF << shift for shift in (0, 8, 16, 24)}
# OpenCV obeys masks that are part of a header so long; beside a shorter one it takes
# the usual ones.
HEADER_WITH_MASKS = 56


def is_bmp(data):
    """Whether bytes begin as a BMP does."""
    return data.startswith(SIGNATURE)


def stated_size(data):
    """(width, height) in px by the header."""
    width, height = struct.unpack_from("<ii", data, 18)
    return abs(width), abs(height)


def is_whole(data):
    """The rows of pixels lie inside the file."""
    start, _, width, height, _, bits = struct.unpack_from("<IIiiHH", data, 10)
    row = (abs(width) * bits + 31) // 32 * 4
    return start + row * abs(height) <= len(data)


def not_read(data):
    """Why a BMP is not read though it is whole (with advice), or None."""
    header, *_, bits, packing = struct.unpack_from("<IiiHHI", data, 14)
    if packing in BY_RUN_LENGTHS:
        return RUN_LENGTHS
    if packing == BY_MASKS and bits == 32:
        masks = struct.unpack_from("<III", data, 54)
        in_bytes = set(masks) <= BYTES and len(set(masks)) == len(masks)
        if masks != USUAL and not (in_bytes and header >= HEADER_WITH_MASKS):
            return ODD_COLOURS
    return None
