"""Verdicts of predicates that are tested run by run."""

import numpy as np

from repro.run.outcomes import Reading


def seed_by_seed(holds, found, reason, unit=""):
    """Return the Reading of a predicate from the runs that it applies to.

    found: what was measured, as `Reading.of` takes it.
    """
    seeds = f"true of {int(np.sum(holds))} of {len(holds)} seeds"
    seeds = seeds if holds else "no seed has any"
    return Reading.of_seeds(holds, found, unit, f"{reason}; {seeds}")
