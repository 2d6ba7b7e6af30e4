"""The numbers that the page of the mirror benchmark quotes: rules and entries."""

import numpy as np

from raxel.evaluation import mirror_benchmark
from repro.page.wording import rounded

# px, pixels, degrees, mm, mm, and percent of the way to a load.
STEP = mirror_benchmark.STEP_PX
FEWEST = mirror_benchmark.FEWEST_RAYS
RIGHT = mirror_benchmark.RIGHT_DEG
CELL = mirror_benchmark.CELL_MM
NEAR = mirror_benchmark.NEAR_MM
READ_AT = 100 * mirror_benchmark.READ_AT

ENTRIES = "ext_mirror_entries_record"
TITLES = {
    "published": "published",
    "stages": "stage by stage",
    "all_after": "all corners",
    "at_once": "at once",
    "prior": "prior",
    "two_places": "two places",
}
STAGES = range(4)


def entries_of(record, rig, level):
    """The trials of all seeds of a rig at a level of noise."""
    return record.select(rig=rig, level=level)


def rigs_and_levels(record):
    """(rig, level) of the record, in its order."""
    return list(dict.fromkeys((c["rig"], c["level"]) for c in record.conditions))


def entry_facts(record):
    """Name -> what the prose says of the entries."""
    found = {
        "date": record.settings["date"],
        "commit": record.settings["raxel"],
        "command": record.settings["command"],
        "sets": len(record.conditions),
        "seeds": len({c["seed"] for c in record.conditions}),
    }
    every = record.select()
    for method in TITLES:
        answered = every.column(f"{method}.answered")
        found[f"{method}.all_stages"] = int(np.sum(answered == len(STAGES)))
        for rig in ("clean", "aberrated"):
            own = entries_of(record, rig, "middle")
            name = f"{method}.{rig}"
            angle = own.column(f"{method}.all.rays.rms_deg")
            right = 100 * own.column(f"{method}.all.rays.share_right")
            found |= {f"{name}.deg": in_words(angle), f"{name}.right": in_words(right)}
            first = own.column(f"{method}.stage0.rays.rms_deg")
            found[f"{name}.first_deg"] = in_words(first)
            moved = own.column(f"{method}.all.deflection_rms_mm")
            found[f"{name}.moved_mm"] = in_words(moved)
    seconds = np.concatenate([every.column(f"{name}.seconds") for name in TITLES])
    found["seconds"] = in_words(seconds)
    for level in ("low", "high"):
        height = entries_of(record, "clean", level).column("at_once.all.height.rms_mm")
        found[f"height.{level}"] = in_words(height)
    shift = entries_of(record, "clean", "high").column("at_once.all.height.mean_mm")
    found["height.shift"] = in_words(np.abs(shift))
    return found


def in_words(values):
    """The median of some seeds and their range, for a sentence."""
    known = values[np.isfinite(values)]
    if not len(known):
        return "(no number)"
    return rounded(float(np.median(known)), (float(known.min()), float(known.max())))
