"""Reading of images: complete files only, in the sensor's orientation and bit depth.

Pillow reads the header and verifies the file. OpenCV decodes the pixels, since it keeps
16 bit of every colour.
"""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
import warnings
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, UnidentifiedImageError

from raxel.errors import InputError
from raxel.io.files import check_file
from raxel.sets.model import ImageSet, View

# Messages of the decoders that OpenCV uses, captured from standard error.


# libjpeg continues after these and fills in grey; other warnings lose no pixels.
LOST_IN_JPEG = (b"remature end of", b"bad Huffman code", b"instead of RST")
# libtiff continues after any error and fills in black. It only warns of invalid run
# lengths and fax lines.
LOST_IN_TIFF = (b"TIFF_Error", b"PackBitsDecode", b"Fax3Decode", b"Fax4Decode")
LOST_PIXELS = LOST_IN_JPEG + LOST_IN_TIFF


@contextlib.contextmanager
def words_of_decoders() -> Iterator[list[bytes]]:
    """Yield a list; after the block it has the bytes written to standard error.

    The standard error of the whole process is redirected for the block, since the
    decoders are no part of Python.

    Yields
    ------
    list of bytes
        Empty during the block.
    """
    words = []  # type: ignore[var-annotated]
    with tempfile.TemporaryFile() as captured:
        try:
            usual = os.dup(2)
        except OSError:  # it was closed; lost pixels must be detected all the same
            usual = None
        os.dup2(captured.fileno(), 2)
        try:
            yield words
        finally:
            if usual is None:
                os.close(2)
            else:
                os.dup2(usual, 2)
                os.close(usual)
            captured.seek(0)
            words.append(captured.read())


def pixels_were_lost(words: Iterable[bytes]) -> bool:
    """Return whether these messages of decoders report lost pixels."""
    return any(sign in message for message in words for sign in LOST_PIXELS)


FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP")
# 160 megapixels of three samples of 16 bit, not packed. Pillow bounds the decoded size.
MAX_BYTES = 1_000_000_000
# Tags of TIFF, and values of theirs.
WIDTH, HEIGHT, BITS, PACKING, PHOTOMETRIC, FILL_ORDER = 256, 257, 258, 259, 262, 266
ORIENTATION, SAMPLES, PLANES = 274, 277, 284
STRIPS, TILES = (273, 279), (324, 325)  # where they begin, their bytes
WHITE_IS_ZERO, A_PLANE_EACH, DEFLATE = 0, 2, (8, 32946)
MAX_BYTES_PER_PIXEL = 32  # out of a strip: four samples of 32 bit, twice
# Inverse of each orientation: OpenCV rotates a TIFF despite the flag against it.
UNDO = {
    1: lambda image: image,
    2: lambda image: image[:, ::-1],
    3: lambda image: image[::-1, ::-1],
    4: lambda image: image[::-1],
    5: lambda image: image.swapaxes(0, 1),
    6: lambda image: np.rot90(image, 1),
    7: lambda image: image[::-1, ::-1].swapaxes(0, 1),
    8: lambda image: np.rot90(image, -1),
}


def read_image(image_set: ImageSet, view: View | str) -> np.ndarray:
    """Return an image of the set in grey levels.

    EXIF rotation is ignored: pixels stay where the sensor had them.

    Parameters
    ----------
    image_set : ImageSet
        The set.
    view : View or str
        A view of one image, or the name of any image of the set.

    Returns
    -------
    ndarray of uint8 or uint16, shape (height, width)
        The image.

    Raises
    ------
    InputError
        If the file is missing, empty, truncated, damaged, no image, or not of the
        resolution of the set.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from PIL import Image
    >>> from raxel.sets import Chessboard, ImageSet, View, read_image
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     grey = np.full((48, 64), 7, np.uint8)
    ...     Image.fromarray(grey).save(Path(folder) / "a.png")
    ...     view = View("a.png")
    ...     board = Chessboard(3, 2)
    ...     image_set = ImageSet("demo", 64, 48, board, (view,), Path(folder))
    ...     image = read_image(image_set, view)
    >>> image.shape, image.dtype.name, int(image[0, 0])
    ((48, 64), 'uint8', 7)
    """
    return _read(image_set, view, cv2.IMREAD_GRAYSCALE)


def read_colour(image_set: ImageSet, view: View | str) -> np.ndarray:
    """Return an image of the set with its colours.

    Parameters
    ----------
    image_set : ImageSet
        The set.
    view : View or str
        A view of one image, or the name of any image of the set.

    Returns
    -------
    ndarray of uint8 or uint16, shape (height, width) or (height, width, 3)
        The image, in BGR order if it has colours.

    Raises
    ------
    InputError
        As `read_image`.
    """
    return _read(image_set, view, cv2.IMREAD_ANYCOLOR)


def has_orientation(path: str | Path) -> bool:
    """Return whether a file has an orientation, which raxel ignores."""
    with _opened(path, Path(path).read_bytes()) as header:
        return header.getexif().get(ORIENTATION, 1) != 1


def stored_size(path: Path) -> tuple[int, int] | None:
    """Return (width, height) in px of a file before any orientation, without pixels.

    None for a file that is no image; `read_image` reports it.
    """
    with contextlib.suppress(Exception), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with Image.open(path, formats=FORMATS) as header:
            return _stored_size(header)
    return None


def is_whole(path: Path) -> bool:
    """Return whether all pixels of an image file are decoded without loss."""
    data, mode = path.read_bytes(), cv2.IMREAD_REDUCED_GRAYSCALE_8
    # Of the kinds of BMP, OpenCV supports only some.
    return data[:2] == b"BM" or _by_opencv(data, mode) is not None


def _read(image_set, view, colour):
    name = view.image if isinstance(view, View) else view
    path = image_set.folder / name
    check_file(path, MAX_BYTES, "image")
    data = path.read_bytes()
    with _opened(path, data) as header:
        size = _stored_size(header)
        if size != (image_set.width, image_set.height):
            raise InputError(
                f"{path}: {size[0]} x {size[1]} px differs from resolution "
                f"{image_set.width} x {image_set.height} of {image_set.description}; "
                "remove the image or correct resolution"
            )
        return _decoded(path, data, header, colour)


@contextlib.contextmanager
def _opened(path, data):
    """Yield the header of an image by Pillow; all its errors become InputError."""
    if not data:
        raise InputError(f"{path}: file is empty (0 bytes); copy it again")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=FORMATS) as header:
                yield header
    except InputError:
        raise
    except UnidentifiedImageError as fault:
        raise InputError(
            f"{path}: not an image, or truncated; convert it to {', '.join(FORMATS)} "
            "or remove it"
        ) from fault
    except Image.DecompressionBombError as fault:
        raise InputError(f"{path}: too many pixels; crop the image") from fault
    except Exception as fault:  # a damaged file can raise any exception
        raise _damaged(path) from fault


def _damaged(path):
    return InputError(f"{path}: file is truncated or damaged; copy it again")


def _stored_size(header):
    """Return (width, height) in px before any orientation."""
    if header.format == "TIFF":
        return header.tag_v2[WIDTH], header.tag_v2[HEIGHT]
    return header.size


def _decoded(path, data, header, colour):
    """Return the pixels of a file; `colour` is OpenCV's reading mode."""
    is_tiff = header.format == "TIFF"
    tags = dict(header.tag_v2) if is_tiff else {}
    size = _stored_size(header)
    if is_tiff:
        _check_samples(path, tags)
        if not _streams_are_whole(data, tags):
            raise _damaged(path)
    with words_of_decoders():
        if header.format == "PNG":
            header.verify()  # check sums of all parts
        else:
            header.load()
    if header.format == "BMP":
        return _by_pillow(header, colour)
    image = _by_opencv(data, colour)
    if image is None:
        raise _damaged(path)
    if is_tiff:
        image = np.ascontiguousarray(UNDO.get(tags.get(ORIENTATION, 1), UNDO[1])(image))
    if image.shape[1::-1] != size:
        raise InputError(
            f"{path}: {image.shape[1]} x {image.shape[0]} px differs from {size[0]} x "
            f"{size[1]} px in its header; save it again, as PNG"
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise InputError(
            f"{path}: samples have type {image.dtype}; save it with 8 or 16 bit"
        )
    if image.dtype == np.uint16 and tags.get(PHOTOMETRIC) == WHITE_IS_ZERO:
        return np.iinfo(np.uint16).max - image  # of 8 bit OpenCV does so itself
    return image


def _check_samples(path, tags):
    """Reject a TIFF whose samples OpenCV misinterprets."""
    samples, bits = tags.get(SAMPLES, 1), tags.get(BITS, (1,))[0]
    if samples not in (1, 3):
        raise InputError(
            f"{path}: {samples} samples per pixel; save the TIFF without opacity"
        )
    if samples > 1 and bits > 8 and tags.get(PLANES) == A_PLANE_EACH:
        raise InputError(
            f"{path}: separate colour planes; save the TIFF with interleaved colours"
        )


def _streams_are_whole(data, tags):
    """Whether each zlib stream of a TIFF ends in its checksum, unlike libtiff."""
    if tags.get(PACKING) not in DEFLATE or tags.get(FILL_ORDER, 1) != 1:
        return True
    starts, lengths = STRIPS if STRIPS[0] in tags else TILES
    remaining = MAX_BYTES_PER_PIXEL * tags[WIDTH] * tags[HEIGHT]
    for start, length in zip(tags[starts], tags[lengths], strict=True):
        stream = zlib.decompressobj()
        remaining -= len(
            stream.decompress(data[start : start + length], max(remaining, 1))
        )
        if not stream.eof:
            return False
    return True


def _by_pillow(image, colour):
    """Return the pixels of a BMP; OpenCV supports only some masks and run lengths."""
    if image.mode in ("1", "L"):
        return np.array(image.convert("L"))
    pixels = np.array(image.convert("RGB"))
    grey = colour == cv2.IMREAD_GRAYSCALE
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY if grey else cv2.COLOR_RGB2BGR)


def _by_opencv(data, colour):
    """Return the pixels; None if decoding fails or loses some of them."""
    mode = colour | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_WARNING)
    try:
        with words_of_decoders() as words:
            image = cv2.imdecode(np.frombuffer(data, np.uint8), mode)
        return None if pixels_were_lost(words) else image
    except cv2.error:
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)


def write_png(path: Path, image: np.ndarray) -> None:
    """Write an image (H, W) or (H, W, 3), blue, green, red, of 8 or 16 bit as PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(cv2.imencode(".png", np.ascontiguousarray(image))[1].tobytes())
