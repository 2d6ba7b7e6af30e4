"""What the decoders below OpenCV say, caught: they write it to standard error."""

import contextlib
import os
import tempfile

# libjpeg goes on after these and fills in grey; other warnings lose no pixels.
LOST_IN_JPEG = (b"remature end of", b"bad Huffman code", b"instead of RST")
# libtiff goes on after any error and fills in black; of run lengths and fax lines that
# do not fit it only warns.
LOST_IN_TIFF = (b"TIFF_Error", b"PackBitsDecode", b"Fax3Decode", b"Fax4Decode")
LOST_PIXELS = LOST_IN_JPEG + LOST_IN_TIFF


@contextlib.contextmanager
def words_of_decoders():
    """Yield a list; after the block it has the bytes written to standard error.

    The whole process's standard error is turned aside for the block, since the
    decoders are no part of Python.
    """
    words = []
    with tempfile.TemporaryFile() as aside:
        try:
            usual = os.dup(2)
        except OSError:  # it was closed; what is lost must be seen all the same
            usual = None
        os.dup2(aside.fileno(), 2)
        try:
            yield words
        finally:
            if usual is None:
                os.close(2)
            else:
                os.dup2(usual, 2)
                os.close(usual)
            aside.seek(0)
            words.append(aside.read())


def pixels_were_lost(words):
    """Whether these words of decoders tell of pixels that could not be read."""
    return any(sign in said for said in words for sign in LOST_PIXELS)
