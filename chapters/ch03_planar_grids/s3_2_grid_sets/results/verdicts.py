"""What a predicate that is tested seed by seed decides."""

import numpy as np

from repro.run.outcomes import Reading


def seed_by_seed(holds, found, reason, unit=""):
    """Reading from whether a predicate is true of each seed that it speaks of.

    found: what was measured, as `Reading.of` takes it.
    """
    seeds = f"true of {int(np.sum(holds))} of {len(holds)} seeds"
    seeds = seeds if holds else "no seed has any"
    return Reading.of_seeds(holds, found, unit, f"{reason}; {seeds}")
