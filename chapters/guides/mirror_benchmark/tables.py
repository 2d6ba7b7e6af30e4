"""The entries of this library in the benchmark of mirrors that bend."""

import numpy as np

from chapters.guides.mirror_benchmark.results import (
    ENTRIES,
    STAGES,
    TITLES,
    entries_of,
    rigs_and_levels,
)
from repro.run.columns import in_columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

# Column -> what of the scores of all stages, told with the range of the seeds.
ERRORS = {
    "Ray angle (deg)": "rays.rms_deg",
    "Height (mm)": "height.rms_mm",
    "Deflection (mm)": "deflection_rms_mm",
}
SHARES = {"Ray (%)": "rays.share_with_ray", "Right (%)": "rays.share_right"}
OF_STAGE = {"Ray, {} (deg)": "rays.rms_deg", "Height, {} (mm)": "height.rms_mm"}
LEVEL = "middle"


@table("ext_mirror_entries", needs=("ext_mirror_entries_record",), evidence="rendered")
def entries_table(results):
    """Every set and way, all stages together."""
    record = results[ENTRIES]
    rows = [
        _row(entries_of(record, rig, level), rig, level, method)
        for rig, level in rigs_and_levels(record)
        for method in TITLES
    ]
    return Table(
        in_columns(rows),
        "Entries of this library: medians of the seeds, and for errors their range. "
        "Stages: that have an answer, the first shape counted, the fewest of any seed. "
        "Ray: pixels with a ray, of all stages; right: within 0.1 degrees. Angles, "
        "heights and deflections are root mean squares over what was answered; a way "
        "that answers the first stage alone is asked nothing harder. Deflection: over "
        "all readings after the first stage, none where one is missing. Time of one "
        "core, from photographs to rays.",
    )


def _row(trials, rig, level, method):
    row = {
        "Rig": rig,
        "Noise": level,
        "Way": TITLES[method],
        "Stages": int(np.min(trials.column(f"{method}.answered"))),
    }
    for title, name in SHARES.items():
        row[title] = _median(100 * trials.column(f"{method}.all.{name}"))
    for title, name in ERRORS.items():
        found = trials.column(f"{method}.all.{name}")
        row[title] = Measured.of_seeds(found) if np.isfinite(found).any() else None
    return row | {"Time (s)": _median(trials.column(f"{method}.seconds"))}


@table("ext_mirror_stages", needs=("ext_mirror_entries_record",), evidence="rendered")
def stages_table(results):
    """Rays and heights of each stage, at the middle level of noise."""
    record, rows = results[ENTRIES], []
    for rig, level in rigs_and_levels(record):
        if level != LEVEL:
            continue
        trials = entries_of(record, rig, level)
        for method, title in TITLES.items():
            row = {"Rig": rig, "Way": title}
            for kind, name in OF_STAGE.items():
                for k in STAGES:
                    found = trials.column(f"{method}.stage{k}.{name}")
                    row[kind.format(k)] = _median(found)
            rows.append(row)
    return Table(
        in_columns(rows),
        f"The same stage by stage, at the {LEVEL} level of noise: root mean squares of "
        "ray angles and of heights, medians of the seeds that have an answer. Empty: "
        "no seed has one.",
    )


def _median(found):
    """Of what is known, to three digits; None where nothing is."""
    known = found[np.isfinite(found)]
    return float(f"{np.median(known):.3g}") if len(known) else None
