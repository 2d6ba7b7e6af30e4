"""Reading photographs: whole files only, in the sensor's own orientation and depth.

OpenCV pads what a cut-off JPEG lacks and says nothing, so each format's own end is
looked for in the bytes before anything is decoded.
"""

import struct
import zlib
from pathlib import Path

import numpy as np

from raxel.errors import InputError
from raxel.sets.decoder_words import pixels_were_lost, words_of_decoders
from raxel.sets.model import View

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
NOT_AN_IMAGE = "not a PNG, JPEG, TIFF or BMP image; convert it or take it out"
CUT_OFF = "copy it anew from its source"
RUN_LENGTHS = (b"\1\0\0\0", b"\2\0\0\0")
BY_RUN_LENGTHS = (
    "a BMP packed by run lengths, which may leave pixels out; save it as PNG, or "
    "unpacked"
)
JPEG_SIGNATURE = b"\xff\xd8\xff"
JPEG_START, JPEG_END, JPEG_SCAN = 0xD8, 0xD9, 0xDA
JPEG_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
TIFF_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 16: 8}
TIFF_OFFSETS, TIFF_LENGTHS = (273, 324), (279, 325)
TIFF_WIDTH, TIFF_HEIGHT, TIFF_PACKING, TIFF_FILL_ORDER = 256, 257, 259, 266
TIFF_READ = {
    *TIFF_OFFSETS,
    *TIFF_LENGTHS,
    *(TIFF_WIDTH, TIFF_HEIGHT, TIFF_PACKING, TIFF_FILL_ORDER),
}
DEFLATE = (8, 32946)
# No more comes out of the strips of a usable picture: four samples of 32 bit, twice.
MOST_BYTES_A_PIXEL = 32
BLOCK = 1 << 20


def read_image(image_set, view):
    """A photograph of the set in grey, (height, width), uint8 or uint16.

    `view` is a View of one image, or the name of any image of the set. EXIF rotation
    is ignored: pixels stay where the sensor had them. Raises InputError for a file
    that is missing, empty, cut off, damaged, no image, or not of the set's resolution.
    """
    import cv2

    return _read(image_set, view, cv2.IMREAD_GRAYSCALE)


def read_colour(image_set, view):
    """As `read_image`, but colour stays colour: (height, width[, 3]), BGR order."""
    import cv2

    return _read(image_set, view, cv2.IMREAD_ANYCOLOR)


def _read(image_set, view, colour):
    name = view.image if isinstance(view, View) else view
    path = image_set.folder / name
    data = whole_file(path)
    width, height = stated_size(data)
    if (width, height) != (image_set.width, image_set.height):
        raise InputError(
            f"{path}: found {width} x {height} px, but resolution in "
            f"{image_set.description} is {image_set.width} x {image_set.height}; "
            "take the image out or mend resolution"
        )
    return decode(path, data, colour)


def whole_file(path):
    """The bytes of an image file. Raises InputError where they are not a whole one."""
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError as fault:
        raise InputError(f"{path}: no such file; add it or mend set.yaml") from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    fault = file_fault(data)
    if fault:
        raise InputError(f"{path}: {fault}")
    return data


def decode(path, data, colour):
    """The pixels of a whole file's bytes; `colour` is OpenCV's reading mode.

    Raises InputError naming `path`.
    """
    import cv2

    mode = colour | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    image = _decode_quietly(np.frombuffer(data, np.uint8), mode)
    if image is None:
        raise InputError(f"{path}: damaged, it cannot be decoded; {CUT_OFF}")
    if image.dtype not in (np.uint8, np.uint16):
        raise InputError(
            f"{path}: found samples of type {image.dtype}; save it with 8 or 16 bit"
        )
    return image


def _decode_quietly(data, mode):
    """OpenCV's decoder with its words caught; None where it fails.

    None also where pixels were lost and filled in, of which only these words tell.
    """
    import cv2

    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_WARNING)
    try:
        with words_of_decoders() as words:
            image = cv2.imdecode(data, mode)
        return None if pixels_were_lost(words) else image
    except cv2.error:
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)


def file_fault(data):
    """Why these bytes are not one whole image (with advice), or None if they are."""
    if not data:
        return f"the file is empty (0 bytes); {CUT_OFF}"
    whole = _check_of(data)
    if whole is None:
        return NOT_AN_IMAGE
    if data.startswith(b"BM") and data[30:34] in RUN_LENGTHS:
        return BY_RUN_LENGTHS
    try:
        complete = whole(data) and min(stated_size(data)) > 0
    except (struct.error, LookupError, OverflowError):
        complete = False
    if complete:
        return None
    return f"cut off or damaged (its {len(data)} bytes do not hold it whole); {CUT_OFF}"


def _check_of(data):
    if data.startswith(PNG_SIGNATURE):
        return _png_is_whole
    if data.startswith(JPEG_SIGNATURE):
        return _jpeg_is_whole
    if data[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        return _tiff_is_whole
    if data.startswith(b"BM"):
        return _bmp_is_whole
    return None


def stated_size(data):
    """(width, height) in px by the header of a whole file, before any is decoded.

    A few bytes can state a picture that no memory holds.
    """
    if data.startswith(PNG_SIGNATURE):
        return struct.unpack_from(">II", data, 16)
    if data.startswith(b"BM"):
        width, height = struct.unpack_from("<ii", data, 18)
        return abs(width), abs(height)
    if data.startswith(JPEG_SIGNATURE):
        height, width = struct.unpack_from(">HH", data, _jpeg_frame(data) + 5)
        return width, height
    values = _tiff_directory(data)
    return int(values[TIFF_WIDTH][0]), int(values[TIFF_HEIGHT][0])


def _jpeg_frame(data):
    """Where the marker of the frame header lies: the first of SOF0 to SOF15."""
    at = 2
    while data[at + 1] not in JPEG_FRAMES:
        if data[at + 1] == 0xFF:
            at += 1
        elif data[at] != 0xFF or data[at + 1] == JPEG_SCAN:
            raise IndexError("no frame header before the scan")
        else:
            (length,) = struct.unpack_from(">H", data, at + 2)
            at += 2 + length
    return at


def _png_is_whole(data):
    """Every chunk's check sum holds, up to IEND."""
    at = len(PNG_SIGNATURE)
    while True:
        (length,) = struct.unpack_from(">I", data, at)
        (checksum,) = struct.unpack_from(">I", data, at + 8 + length)
        if zlib.crc32(data[at + 4 : at + 8 + length]) != checksum:
            return False
        if data[at + 4 : at + 8] == b"IEND":
            return True
        at += 12 + length


def _jpeg_is_whole(data):
    """There is an end marker outside the segments: a thumbnail's does not count."""
    at, scanned = 2, False
    while True:
        at = data.find(b"\xff", at)
        if at < 0:
            return False
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
        elif marker == 0 or marker == 1 or 0xD0 <= marker <= JPEG_START:
            at += 2
        elif marker == JPEG_END:
            return scanned
        else:
            scanned = scanned or marker == JPEG_SCAN
            (length,) = struct.unpack_from(">H", data, at + 2)
            at += 2 + length


def _tiff_is_whole(data):
    """All strips or tiles of the first picture lie inside the file.

    Deflated ones end in a check sum, which libtiff does not always come to.
    """
    values = _tiff_directory(data)
    offsets = next((values[tag] for tag in TIFF_OFFSETS if tag in values), None)
    lengths = next((values[tag] for tag in TIFF_LENGTHS if tag in values), None)
    if offsets is None or lengths is None or len(offsets) != len(lengths):
        return False
    if not np.all(offsets + lengths <= len(data)):
        return False
    known = {tag: int(values[tag][0]) for tag in values}
    if known.get(TIFF_PACKING) in DEFLATE and known.get(TIFF_FILL_ORDER, 1) == 1:
        most = MOST_BYTES_A_PIXEL * known[TIFF_WIDTH] * known[TIFF_HEIGHT]
        places = zip(offsets.astype(int), lengths.astype(int), strict=True)
        strips = (data[at : at + length] for at, length in places)
        return _streams_are_whole(strips, most + BLOCK)
    return True


def _tiff_directory(data):
    """The tags of TIFF_READ of the first picture, tag -> array of values."""
    order = "<" if data[:1] == b"I" else ">"
    if data[2:4] in (b"*\0", b"\0*"):
        count_format, entry, value_format, first = "H", 12, "I", 4
    else:
        count_format, entry, value_format, first = "Q", 20, "Q", 8
    (at,) = struct.unpack_from(order + value_format, data, first)
    (count,) = struct.unpack_from(order + count_format, data, at)
    at += struct.calcsize(count_format)
    values = {}
    for start in range(at, at + min(count, 4096) * entry, entry):
        tag, kind = struct.unpack_from(order + "HH", data, start)
        if tag in TIFF_READ:
            values[tag] = _tiff_values(data, order, value_format, start, kind)
    return values


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


def _tiff_values(data, order, value_format, start, kind):
    size = struct.calcsize(value_format)
    (count,) = struct.unpack_from(order + value_format, data, start + 4)
    at = start + 4 + size
    if count * TIFF_SIZES[kind] > size:
        (at,) = struct.unpack_from(order + value_format, data, at)
    if at + count * TIFF_SIZES[kind] > len(data):
        raise IndexError("values beyond the end of the file")
    number = np.dtype(f"{order}u{TIFF_SIZES[kind]}")
    return np.frombuffer(data, number, count, at).astype(np.float64)


def _bmp_is_whole(data):
    """The rows of pixels lie inside the file."""
    start, _, width, height, _, bits = struct.unpack_from("<IIiiHH", data, 10)
    row = (abs(width) * bits + 31) // 32 * 4
    return start + row * abs(height) <= len(data)
