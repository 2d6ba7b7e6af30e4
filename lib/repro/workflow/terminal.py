"""What a build says to people, on standard error."""

from __future__ import annotations

import sys


def say(text: str) -> None:
    """Print text without control characters, which a name in it may hold."""
    shown = "".join(c if c.isprintable() or c in "\n\t" else " " for c in text)
    print(shown, file=sys.stderr, flush=True)
