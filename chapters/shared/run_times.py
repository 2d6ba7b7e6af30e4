"""How long something takes, and in words."""

import time


def rounded_seconds(seconds):
    """A run time in words, coarse enough to be the same again."""
    return "under 1 s" if seconds < 1 else f"{seconds:.0f} s"


def timed(call):
    """Seconds that a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start
