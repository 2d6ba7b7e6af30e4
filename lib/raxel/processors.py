"""How many processors this process may use."""

import os


def processors():
    """Number of processors; 1 where the system does not say."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
