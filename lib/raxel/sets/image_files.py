"""Reading photographs: whole files only, in the sensor's own orientation and depth.

OpenCV pads what a cut-off JPEG lacks and says nothing, so each format's own end is
looked for in the bytes before anything is decoded.
"""

import struct
import zlib
from pathlib import Path

import numpy as np

from raxel.errors import InputError
from raxel.io.files import check_size
from raxel.sets import bmp, tiff
from raxel.sets.decoder_words import pixels_were_lost, words_of_decoders
from raxel.sets.model import View

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
NOT_AN_IMAGE = "not a PNG, JPEG, TIFF or BMP image; convert it or take it out"
CUT_OFF = "copy it anew from its source"
# 160 megapixels of three samples of 16 bit, not packed.
MOST_BYTES = 1_000_000_000
IN_PLANES = (
    "a TIFF of more than 8 bit with a plane for each colour, which is not read; save "
    "it as PNG, or with the colours of a pixel together"
)
JPEG_SIGNATURE = b"\xff\xd8\xff"
JPEG_START, JPEG_END, JPEG_SCAN = 0xD8, 0xD9, 0xDA
JPEG_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}


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
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file; add it or mend set.yaml")
    check_size(path, MOST_BYTES, "photograph")
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    fault = file_fault(data)
    if fault:
        raise InputError(f"{path}: {fault}")
    return data


def decode(path, data, colour):
    """The pixels of a whole file's bytes; `colour` is OpenCV's reading mode.

    Raises InputError naming `path`, where the bytes hold no picture of the size that
    they state.
    """
    import cv2

    mode = colour | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    stored = tiff.as_stored(data) if tiff.is_tiff(data) else data
    image = _decode_quietly(np.frombuffer(stored, np.uint8), mode)
    if image is None:
        raise InputError(
            f"{path}: cannot be decoded: damaged, or of a kind that is not read; "
            f"{CUT_OFF}, or save it as PNG"
        )
    height, width = image.shape[:2]
    if (width, height) != stated_size(data):
        stated = " x ".join(map(str, stated_size(data)))
        raise InputError(
            f"{path}: found {width} x {height} px, but its header states {stated}; "
            "save it anew, as PNG"
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise InputError(
            f"{path}: found samples of type {image.dtype}; save it with 8 or 16 bit"
        )
    if image.dtype == np.uint8 and tiff.is_tiff(data) and tiff.bits(data) > 8:
        raise InputError(
            f"{path}: a TIFF of {tiff.bits(data)} bit that the decoder makes 8 bit of, "
            "as it does with opacity beside grey; save it as PNG, or without opacity"
        )
    # With 8 bit the decoder has turned them already.
    if image.dtype == np.uint16 and tiff.is_tiff(data) and tiff.white_is_zero(data):
        return np.iinfo(np.uint16).max - image
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
    try:
        if bmp.is_bmp(data) and (fault := bmp.not_read(data)):
            return fault
        complete = whole(data) and min(stated_size(data)) > 0
        if complete:
            mistaken = tiff.is_tiff(data) and tiff.planes_are_mistaken(data)
            return IN_PLANES if mistaken else None
    except (struct.error, LookupError, OverflowError):
        pass
    return f"cut off or damaged (its {len(data)} bytes do not hold it whole); {CUT_OFF}"


def _check_of(data):
    if data.startswith(PNG_SIGNATURE):
        return _png_is_whole
    if data.startswith(JPEG_SIGNATURE):
        return _jpeg_is_whole
    if tiff.is_tiff(data):
        return tiff.is_whole
    if bmp.is_bmp(data):
        return bmp.is_whole
    return None


def is_jpeg(path):
    """Whether a file begins as a JPEG does, whatever its name says."""
    with open(path, "rb") as stream:
        return stream.read(len(JPEG_SIGNATURE)) == JPEG_SIGNATURE


def stated_size(data):
    """(width, height) in px by the header of a whole file, before any is decoded.

    A few bytes can state a picture that no memory holds.
    """
    if data.startswith(PNG_SIGNATURE):
        return struct.unpack_from(">II", data, 16)
    if bmp.is_bmp(data):
        return bmp.stated_size(data)
    if data.startswith(JPEG_SIGNATURE):
        height, width = struct.unpack_from(">HH", data, _jpeg_frame(data) + 5)
        return width, height
    return tiff.stated_size(data)


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
