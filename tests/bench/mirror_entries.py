"""The record of this library's entries of the benchmark of mirrors that bend.

Renders every set of the benchmark, calibrates it in every way of the guide's page,
scores and forgets it: a quarter of a minute of one core for each set. Writes
data/records/mirrors.json.

    python -m tests.bench.mirror_entries
"""

import tempfile
from datetime import UTC, datetime
from pathlib import Path

from chapters.guides.mirror_benchmark.trials import LEVELS, RIGS, SEEDS, entries
from raxel.io.files import write_json
from raxel.lab.mirror_set_rig import load_mirror_set_rig
from raxel.lab.render_mirror_set import render_mirror_set
from tests.bench.provenance import commit, versions

RECORD = Path("data/records/mirrors.json")
SETS = Path("data/rigs/mirror-sets")
DIGITS = 4
# What is kept of the scores of all stages together, and of each.
OF_RAYS = "share_with_ray", "share_right", "rms_deg", "median_deg"
OF_HEIGHT = "share_covered", "mean_mm", "rms_mm"
OF_STAGE = "rays.rms_deg", "height.rms_mm"


def recorded():
    """The record: every rig at every level of noise, with every seed."""
    sets = []
    with tempfile.TemporaryDirectory() as room:
        for rig in RIGS:
            for level in LEVELS:
                sets += [_recorded_set(Path(room), rig, level, k) for k in SEEDS]
    return {
        "what": "Entries of this library in the benchmark of mirrors that bend: scores "
        "of several ways to calibrate each set, with the processor time of one core.",
        "command": "python -m tests.bench.mirror_entries",
        "note": "A record: scores are the same wherever it is made again, times "
        "belong to one machine. No build makes it again, since each set takes a "
        "quarter of a minute.",
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "versions": {"raxel": commit(), **versions()},
        "sets": sets,
    }


def _recorded_set(room, rig, level, seed):
    drawn = load_mirror_set_rig(SETS / f"{rig}.yaml")
    mirror_set = render_mirror_set(drawn, room / f"{rig}-{level}-{seed}", seed, level)
    print(mirror_set.name, flush=True)
    scores = [
        {"method": name} | kept(entry) for name, entry in entries(mirror_set).items()
    ]
    about = {"name": mirror_set.name, "rig": rig, "level": level, "seed": seed}
    return about | {"scores": scores}


def kept(entry):
    """What the record keeps of an entry of `entries`."""
    told = {name: entry[name] for name in ("answered", "refused")}
    if "all" not in entry:
        return told
    told["seconds"] = _rounded(entry["seconds"])
    for stage in entry["stages"]:
        if stage["stage"] < entry["answered"]:
            numbers = _numbers(stage)
            told[f"stage{stage['stage']}"] = {name: numbers[name] for name in OF_STAGE}
    told["all"] = _numbers(entry["all"]) | {
        "deflection_rms_mm": _rounded(entry["all"]["deflection_rms_mm"])
    }
    return told


def _numbers(scores):
    rays, height = scores["rays"], scores["height"]
    return {f"rays.{name}": _rounded(rays[name]) for name in OF_RAYS} | {
        f"height.{name}": _rounded(height[name]) for name in OF_HEIGHT
    }


def _rounded(value):
    return None if value is None else float(f"{value:.{DIGITS}g}")


if __name__ == "__main__":
    write_json(RECORD, recorded())
