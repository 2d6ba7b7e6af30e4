"""Cells of tables and words about runs, some of which were rejected."""

import numpy as np

from repro.run import Measured

MEDIANS = "Medians over the seeds that came so far, with 95 % intervals."


def beside(ids, rows):
    """Ids of printed numbers for the rows of a table that begins with theirs."""
    return [*ids, *[None] * (rows - len(ids))]


def reached(values):
    """Median of the seeds (n,) that have a value, None without any."""
    known = values[np.isfinite(values)]
    return Measured.median(known) if len(known) else None


def ranged(values):
    """Median and range of the runs (n,) that have a value, None without any."""
    return Measured.of_seeds(values) if np.isfinite(values).any() else None


def middle(values):
    """Median of the runs (n,) that have a value, as words; "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"
