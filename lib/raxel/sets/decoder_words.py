"""What the decoders below OpenCV say, caught: they write it to standard error."""

import contextlib
import os
import tempfile

# libjpeg goes on after these and fills in grey; other warnings lose no pixels.
LOST_PIXELS = (b"remature end of", b"bad Huffman code", b"instead of RST")


@contextlib.contextmanager
def words_of_decoders():
    """Yield a list; after the block it has the bytes written to standard error.

    The whole process's standard error is turned aside for the block, since the
    decoders are no part of Python.
    """
    words = []
    try:
        usual = os.dup(2)
    except OSError:  # there is no standard error to write to
        yield words
        return
    with tempfile.TemporaryFile() as aside:
        os.dup2(aside.fileno(), 2)
        try:
            yield words
        finally:
            os.dup2(usual, 2)
            os.close(usual)
            aside.seek(0)
            words.append(aside.read())


def pixels_were_lost(words):
    """Whether these words of decoders tell of pixels that could not be read."""
    return any(sign in said for said in words for sign in LOST_PIXELS)
