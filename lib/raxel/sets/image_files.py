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
JPEG_START, JPEG_END, JPEG_SCAN = 0xD8, 0xD9, 0xDA
TIFF_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 16: 8}
TIFF_PLACES = {"offsets": (273, 324), "lengths": (279, 325)}


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
    image = decode(path, colour)
    height, width = image.shape[:2]
    if (width, height) != (image_set.width, image_set.height):
        raise InputError(
            f"{path}: found {width} x {height} px, but resolution in "
            f"{image_set.description} is {image_set.width} x {image_set.height}; "
            "take the image out or mend resolution"
        )
    return image


def decode(path, colour):
    """The pixels of a whole image file; `colour` is OpenCV's reading mode.

    Raises InputError naming the file.
    """
    import cv2

    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError as fault:
        raise InputError(f"{path}: no such file; add it or mend set.yaml") from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    fault = file_fault(data)
    if fault:
        raise InputError(f"{path}: {fault}")
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
    """OpenCV's decoder without its own log lines; None where it fails.

    None also where pixels were lost, which libjpeg fills in with grey.
    """
    import cv2

    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
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
    try:
        complete = whole(data)
    except (struct.error, IndexError):
        complete = False
    if complete:
        return None
    return f"cut off or damaged (its {len(data)} bytes do not hold it whole); {CUT_OFF}"


def _check_of(data):
    if data.startswith(PNG_SIGNATURE):
        return _png_is_whole
    if data.startswith(b"\xff\xd8\xff"):
        return _jpeg_is_whole
    if data[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        return _tiff_is_whole
    if data.startswith(b"BM"):
        return _bmp_is_whole
    return None


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
    """All strips or tiles of the first picture lie inside the file."""
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
        if tag in TIFF_PLACES["offsets"] + TIFF_PLACES["lengths"]:
            values[tag] = _tiff_values(data, order, value_format, start, kind)
    offsets = next((values[t] for t in TIFF_PLACES["offsets"] if t in values), None)
    lengths = next((values[t] for t in TIFF_PLACES["lengths"] if t in values), None)
    if offsets is None or lengths is None or len(offsets) != len(lengths):
        return False
    return bool(np.all(offsets + lengths <= len(data)))


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
    """The rows of pixels (or the stated size, if packed) lie inside the file."""
    stated, _, start, _, width, height, _, bits, packing = struct.unpack_from(
        "<IIIIiiHHI", data, 2
    )
    if packing in (1, 2):
        return stated <= len(data)
    row = (abs(width) * bits + 31) // 32 * 4
    return start + row * abs(height) <= len(data)
