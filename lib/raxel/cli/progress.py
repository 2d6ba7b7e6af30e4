"""Lines that say how far a command is."""

import time

from raxel.cli.terminal import on_one_line

PATIENCE_S = 5.0


class Progress:
    """Writes lines at once to a terminal; elsewhere when the command takes long.

    In a pipe or a log, lines of the first PATIENCE_S seconds are held back: a command
    that soon fails leaves exactly its one line there.
    """

    def __init__(self, stream, clock=time.monotonic):
        self._stream = stream
        self._clock = clock
        self._live_from = clock() + (0.0 if stream.isatty() else PATIENCE_S)
        self._held = []

    def say(self, line):
        """One line of progress."""
        self._held.append(on_one_line(line))
        if self._clock() >= self._live_from:
            self.release()

    def release(self):
        """Write what was held back: the command takes long, or has succeeded."""
        for line in self._held:
            print(line, file=self._stream)
        self._held.clear()
        self._stream.flush()
