"""Lines that say how far a command is."""


class Progress:
    """Writes lines at once to a terminal, else when the command has succeeded.

    So a command that fails leaves exactly its one line in a log.
    """

    def __init__(self, stream):
        self._stream = stream
        self._live = stream.isatty()
        self._held = []

    def say(self, line):
        """One line of progress."""
        if self._live:
            print(line, file=self._stream, flush=True)
        else:
            self._held.append(line)

    def release(self):
        """The command has succeeded: write what was held back."""
        for line in self._held:
            print(line, file=self._stream)
        self._held.clear()
