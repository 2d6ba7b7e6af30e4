"""Messages of a build, on standard error."""

from __future__ import annotations

import sys


def say(text: str) -> None:
    """Print text without control characters, which names in it may contain."""
    shown = "".join(c if c.isprintable() or c in "\n\t" else " " for c in text)
    print(shown, file=sys.stderr, flush=True)
