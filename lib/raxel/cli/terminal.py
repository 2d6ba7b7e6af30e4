"""Text for a terminal: it commands nothing there, and a lost reader stops nothing."""

import errno
import io
import os
import unicodedata


def on_one_line(text):
    """`text` with all that is not seen as itself shown as an escape, line breaks too.

    These are control characters (C0, C1, DEL), marks that turn the direction of
    writing, separators of lines, and halves of characters.
    """
    return _visible(str(text), kept="")


def _visible(text, kept):
    if text.isprintable():
        return text
    return "".join(
        one
        if one.isprintable() or one in kept or unicodedata.category(one) == "Zs"
        else one.encode("unicode_escape").decode()
        for one in text
    )


class Terminal:
    """A stream for people: all text as `on_one_line`, but line breaks stay.

    A stream that cannot be written is remembered in `fault` and left alone: the
    command goes on, since its results are files. `stream` None swallows everything.
    """

    def __init__(self, stream):
        self.fault = None
        self._stream = io.StringIO() if stream is None else stream

    @property
    def reader_has_gone(self):
        """Whether this is a pipe whose reader wants no more."""
        return self.fault is not None and self.fault.errno == errno.EPIPE

    def write(self, text):
        """Write `text`; returns its length."""
        shown = _visible(text, kept="\n")
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        shown = shown.encode(encoding, "backslashreplace").decode(encoding)
        self._attempt(self._stream.write, shown)
        return len(text)

    def flush(self):
        """Pass on what is held back."""
        self._attempt(self._stream.flush)

    def isatty(self):
        """Whether people look at it now."""
        return self._stream.isatty()

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def _attempt(self, do, *arguments):
        if self.fault is not None:
            return
        try:
            do(*arguments)
        except OSError as fault:
            self.fault = fault
            self._lead_away()

    def _lead_away(self):
        """What the stream still holds back must not fail again at the end of Python."""
        try:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
        except OSError:  # it is no file of the system
            pass
