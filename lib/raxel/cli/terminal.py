"""Text for a terminal: control characters are escaped, closed pipes are tolerated."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import time
import unicodedata
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich import progress

Say = Callable[[str], None]
PATIENCE_S = 5.0
COUNTED = re.compile(r"(\d+)/(\d+) (.*)")
# Fields of set.yaml, and the options that give them for a folder without one.
OPTIONS = {
    r"target\.kind: (\w+)": r"--board \1:...",
    r"target\.(columns|dictionary|family)(, columns)?,? (and )?(target\.)?rows"
    r"( and \w+)?|(?<=(?:give|heck) )columns and rows": "--board",
    r"target\.columns: found null": "--board: missing",
    r"target\.pitch_mm": "--pitch",
    r"target\.(?=\w)": "--board: ",
}
HELP_STYLES = {
    r"(?m)^\S.*:$|^Usage:": "bold yellow",
    r"(?<!\S)--?[a-z][a-z-]*": "cyan",
    r"(?m)(?<=^  )[a-z]+(?=  )": "cyan",
    r"\[(default|required)\b.*?\]": "dim",
}


def on_one_line(text: object, kept: str = "") -> str:
    """Return the text with every character that is not printable as an escape.

    Escaped are control characters (C0, C1, DEL), line breaks and separators, marks of
    the writing direction, and lone surrogates, but not the characters `kept`.
    """
    return "".join(
        one
        if one.isprintable() or one in kept or unicodedata.category(one) == "Zs"
        else one.encode("unicode_escape").decode()
        for one in str(text)
    )


class Terminal:
    """An output stream that escapes text as `on_one_line` does.

    After an error of the stream, `fault` holds the error and all further text is
    discarded. The command continues, because its results are files. Without a stream
    (None) all text is discarded. With `names_options`, fields of a target in set.yaml
    appear as OPTIONS.
    """

    def __init__(self, stream: TextIO | None, kept: str = "\n") -> None:
        self.fault: OSError | None = None
        self._stream = io.StringIO() if stream is None else stream
        self._kept = kept
        self.names_options = False

    def write(self, text: str) -> int:
        """Write the text; return its length."""
        for field, option in OPTIONS.items() if self.names_options else ():
            text = re.sub(field, option, text)
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        data = on_one_line(text, self._kept).encode(encoding, "backslashreplace")
        self._attempt(self._stream.write, data.decode(encoding))
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        self._attempt(self._stream.flush)

    def console(self) -> Any:
        """Return a rich.console.Console for text that is escaped already."""
        from rich.console import Console

        file: Any = Terminal(self._stream, kept="\n\r\x1b")
        return Console(file=file, highlight=False)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _attempt(self, do: Callable[..., object], *arguments: object) -> None:
        try:
            if self.fault is None:
                do(*arguments)
        except OSError as fault:
            self.fault = fault
            # What is still buffered must not fail again when Python ends.
            with contextlib.suppress(OSError), open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())


def print_help(text: str) -> None:
    """Print a help text, with colours if standard output is a terminal."""
    stdout: Any = sys.stdout
    if stdout.isatty():
        from rich.text import Text

        styled = Text(text)
        for pattern, style in HELP_STYLES.items():
            styled.highlight_regex(pattern, style)
        stdout.console().print(styled, soft_wrap=True)
    else:
        print(text)


class Progress:
    """Show progress: a bar on a terminal, lines elsewhere.

    A line `NUMBER/TOTAL TEXT` moves the bar. In a pipe or a log file, the lines of the
    first PATIENCE_S seconds are held back, so that a command that fails early leaves
    only its error message there.
    """

    def __init__(
        self, stream: Terminal, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._stream = stream
        self._clock = clock
        self._has_bar = stream.isatty() and os.environ.get("TERM") != "dumb"
        self._live_from = clock() + (0.0 if stream.isatty() else PATIENCE_S)
        self._held: list[str] = []
        self._bar: progress.Progress | None = None

    def say(self, line: str) -> None:
        """Show one line of progress."""
        line = on_one_line(line)
        counted = COUNTED.fullmatch(line)
        if counted and self._has_bar:
            self._advance(int(counted[1]), int(counted[2]), counted[3])
            return
        self.close()
        self._held.append(line)
        if self._clock() >= self._live_from:
            self.release()

    def release(self) -> None:
        """Print the lines that were held back."""
        for line in self._held:
            print(line, file=self._stream)
        self._held.clear()
        self._stream.flush()

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _advance(self, number: int, total: int, text: str) -> None:
        if self._bar is None:
            self._bar = _started_bar(self._stream)
        (task,) = self._bar.task_ids
        self._bar.update(
            task, completed=number, total=total, description=text, refresh=True
        )
        if number >= total:
            self.close()


def _started_bar(stream: Terminal) -> progress.Progress:
    from rich import progress
    from rich.table import Column

    text = Column(no_wrap=True, overflow="ellipsis", ratio=1)
    bar = progress.Progress(
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeRemainingColumn(),
        "left",
        progress.TextColumn("{task.description}", markup=False, table_column=text),
        console=stream.console(),
        auto_refresh=False,
        expand=True,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )
    bar.add_task("")
    bar.start()
    bar.console.show_cursor()  # a process that is killed leaves the cursor visible
    return bar
