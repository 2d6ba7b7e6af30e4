"""What the page on the look-up table reads of its experiment, and quotes."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_lookup.trials.compared import CASES
from chapters.ch05_flexible_mirror.ext_lookup.trials.table import ENTRIES_MM, TRACED_PX
from repro.judge.statistics import median_interval, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

RUNS = "ext_mirror_lookup_runs"
# The ways, and how they are said.
WAYS = {
    "exact": "table, boundary exact",
    "traced": "table, boundary traced",
    "few": "table of two entries, traced",
    "update": "update from a board",
}
# The cases in the order of the page, and how they are said.
SAID = {
    "between1": "2.5 mm, between entries",
    "entry": "5 mm, on an entry",
    "between2": "7.5 mm, between entries",
    "between3": "12.5 mm, between entries",
    "twisted": "7.5 mm, rulings 3° oblique",
    "twisted_more": "7.5 mm, rulings 8° oblique",
    "beyond": "18 mm, beyond the last entry",
}


def measured(result, geometry, way, case, name):
    """Values (seeds,), infinite where a seed was refused; of a deflection its size."""
    found = result.select(geometry=geometry).column(f"{way}.{case}.{name}")
    return with_worst(np.abs(found))


def flagged(result, geometry, way, case):
    """Seeds in which a way said that its result is doubtful, or gave none."""
    trials = result.select(geometry=geometry)
    refused = [text is not None for text in trials.texts(f"{way}.{case}.refused")]
    told = trials.column(f"{way}.{case}.flagged") == 1
    return int(np.count_nonzero(np.logical_or(refused, told)))


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, number in quoted(open_results(RUNS)).items():
        value(name, number)


def quoted(result):
    """Name -> what prose quotes."""
    found = {
        "seeds": result.trials_per_condition,
        "entries": len(ENTRIES_MM),
        "last_mm": f"{ENTRIES_MM[-1]:g}",
        "traced_px": f"{TRACED_PX['traced']:g}",
    }
    for geometry in "AB":
        for way in WAYS:
            for case in CASES:
                name = f"{geometry}.{way}.{case}"
                for what in ("angle_deg", "deflection_um"):
                    estimate = median_interval(
                        measured(result, geometry, way, case, what)
                    )
                    found[f"{name}.{what}"] = in_words(estimate)
                found[f"{name}.flagged"] = flagged(result, geometry, way, case)
        for case in CASES:
            off = result.select(geometry=geometry).column(f"traced.{case}.off_px")
            found[f"{geometry}.{case}.off_px"] = in_words(median_interval(off))
    return found


def in_words(estimate):
    """An Estimate with its interval, for a sentence; a single seed has none."""
    if not np.isfinite(estimate.value):
        return "(no number)"
    ends = estimate.low, estimate.high
    return rounded(estimate.value, ends if np.isfinite(ends).all() else None)
