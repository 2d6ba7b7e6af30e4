"""TIFF, where its decoder says nothing: whole files, size, orientation, negatives.

libtiff fills in what a cut-off file lacks and multiplies by what is transparent, and
OpenCV turns and mirrors by the tag of orientation though it is told not to, and takes
planes of 16 bit for pixels. Tags are those of TIFF 6.0 and of its form with 64-bit
places.
"""

import struct
import zlib

import numpy as np

SIGNATURES = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
# Bytes of a value of each type that is read.
SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 16: 8}
OFFSETS, LENGTHS = (273, 324), (279, 325)
WIDTH, HEIGHT, BITS, PACKING, FILL_ORDER = 256, 257, 258, 259, 266
PHOTOMETRIC, ORIENTATION, PLANES, EXTRA = 262, 274, 284, 338
READ = {
    *OFFSETS,
    *LENGTHS,
    *(WIDTH, HEIGHT, BITS, PACKING, FILL_ORDER, PHOTOMETRIC),
    *(ORIENTATION, PLANES, EXTRA),
}
WHITE_IS_ZERO, A_PLANE_EACH = 0, 2
# Pixels stay where they are stored; what is opaque is multiplied in already.
AS_STORED = {ORIENTATION: 1, EXTRA: 1}
DEFLATE = (8, 32946)
# No more comes out of the strips of a usable picture: four samples of 32 bit, twice.
MOST_BYTES_A_PIXEL = 32
BLOCK = 1 << 20


def is_tiff(data):
    """Whether bytes begin as a TIFF does."""
    return data[:4] in SIGNATURES


def stated_size(data):
    """(width, height) in px of the first picture, by its tags."""
    values = directory(data)
    return int(values[WIDTH][0]), int(values[HEIGHT][0])


def white_is_zero(data):
    """Whether samples of the first picture grow as it gets darker."""
    return WHITE_IS_ZERO in directory(data).get(PHOTOMETRIC, ())


def bits(data):
    """Of a sample of the first picture."""
    return int(directory(data).get(BITS, (1,))[0])


def planes_are_mistaken(data):
    """Whether the first picture has a plane of more than 8 bit for each colour."""
    values = directory(data)
    bits = values.get(BITS, np.ones(1))
    planes = values.get(PLANES, np.ones(1))[0]
    return planes == A_PLANE_EACH and len(bits) > 1 and bits[0] > 8


def as_stored(data):
    """The bytes with tags that leave pixels where, and as light as, they are stored."""
    order, entries = _entries(data)
    for tag in AS_STORED.keys() & entries.keys():
        kind, _, place = entries[tag]
        size = SIZES[kind]
        value = AS_STORED[tag].to_bytes(size, "little" if order == "<" else "big")
        data = data[:place] + value + data[place + size :]
    return data


def is_whole(data):
    """All strips or tiles of the first picture lie inside the file.

    Deflated ones end in a check sum, which libtiff does not always come to.
    """
    values = directory(data)
    offsets = next((values[tag] for tag in OFFSETS if tag in values), None)
    lengths = next((values[tag] for tag in LENGTHS if tag in values), None)
    if offsets is None or lengths is None or len(offsets) != len(lengths):
        return False
    if not np.all(offsets + lengths <= len(data)):
        return False
    known = {tag: int(values[tag][0]) for tag in values}
    if known.get(PACKING) in DEFLATE and known.get(FILL_ORDER, 1) == 1:
        most = MOST_BYTES_A_PIXEL * known[WIDTH] * known[HEIGHT]
        places = zip(offsets.astype(int), lengths.astype(int), strict=True)
        strips = (data[at : at + length] for at, length in places)
        return _streams_are_whole(strips, most + BLOCK)
    return True


def directory(data):
    """The tags of READ of the first picture, tag -> array of values."""
    order, entries = _entries(data)
    return {
        tag: np.frombuffer(data, f"{order}u{SIZES[kind]}", count, place).astype(float)
        for tag, (kind, count, place) in entries.items()
    }


def _entries(data):
    """(byte order, {tag of READ: (type, count, where its values begin)})"""
    order = "<" if data[:1] == b"I" else ">"
    if data[2:4] in (b"*\0", b"\0*"):
        count_format, entry, value_format, first = "H", 12, "I", 4
    else:
        count_format, entry, value_format, first = "Q", 20, "Q", 8
    (at,) = struct.unpack_from(order + value_format, data, first)
    (count,) = struct.unpack_from(order + count_format, data, at)
    at += struct.calcsize(count_format)
    found = {}
    for start in range(at, at + min(count, 4096) * entry, entry):
        tag, kind = struct.unpack_from(order + "HH", data, start)
        if tag in READ:
            found[tag] = (kind, *_values_at(data, order, value_format, start, kind))
    return order, found


def _values_at(data, order, value_format, start, kind):
    """(count, where they begin) of an entry's values: in it where they fit."""
    size = struct.calcsize(value_format)
    (count,) = struct.unpack_from(order + value_format, data, start + 4)
    at = start + 4 + size
    if count * SIZES[kind] > size:
        (at,) = struct.unpack_from(order + value_format, data, at)
    if at + count * SIZES[kind] > len(data):
        raise IndexError("values beyond the end of the file")
    return count, at


def _streams_are_whole(streams, most):
    """The check sum of each zlib stream holds; `most` bytes come out of them in all."""
    try:
        for rest in streams:
            stream = zlib.decompressobj()
            while rest and not stream.eof and most > 0:
                most -= len(stream.decompress(rest, BLOCK))
                rest = stream.unconsumed_tail
            if not stream.eof:
                return False
    except zlib.error:
        return False
    return True
