"""Deflection, rays and warnings of the look-up table beside the update."""

from chapters.ch05_flexible_mirror.ext_lookup.results import (
    RUNS,
    SAID,
    WAYS,
    flagged,
    measured,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table(
    "ext_mirror_lookup_table", needs=("ext_mirror_lookup_runs",), evidence="synthetic"
)
def lookup_table(results):
    """A row for each case and way, with the rays and the deflection of both rigs."""
    result, rows = results[RUNS], []
    seeds = result.trials_per_condition
    for case, said in SAID.items():
        for way in ("traced", "update"):
            of_rigs = [
                Measured.median_or_none(measured(result, geometry, way, case, name))
                for geometry in "AB"
                for name in ("angle_deg", "deflection_um")
            ]
            warned = sum(flagged(result, geometry, way, case) for geometry in "AB")
            rows.append((said, WAYS[way], *of_rigs, f"{warned} of {2 * seeds}"))
    head = (
        "Case", "Way", "A: rays (degrees)", "A: deflection (µm)", "B: rays (degrees)",
        "B: deflection (µm)", "Flagged",
    )  # fmt: skip
    return Table(
        columns(head, rows),
        "The table of boundaries beside the update, case by case: mean ray angle over "
        "the mirror, size of the error of the deflection at the load, and seeds on "
        "both rigs in which the method itself said that its result is doubtful, or "
        f"gave none. Medians over {seeds} seeds with 95 % intervals.",
    )
