"""What the scores of rendered sets say, and the numbers of the prose."""

from math import isfinite

from chapters.guides.benchmarks.trials import DETECTORS
from chapters.shared import detector_counts

FAILED = "failed"


def scored_rigs(result):
    """Names of the rigs that have scores."""
    return [condition["rig"] for condition in result.conditions]


def worst_corner(result):
    """The largest error of a corner in px, over all cameras."""
    return float(result.select(check="corners").column("largest").max())


def worst_of(result, check):
    """The largest error of one check of photometry."""
    return float(result.column("largest", check=check)[0])


def facts(scores):
    """What the prose says of the scored rigs, as {name: number or text}."""
    rigs = scored_rigs(scores)
    last = scores.one(rig=rigs[-1])
    found = {
        "views": scores.settings["views"] * len(rigs),
        "rigs": ", ".join(rigs),
        "last": rigs[-1],
    }
    for one in DETECTORS:
        found[f"right_{one}"] = int(scores.select().column(f"{one}.right").sum())
    for model in ("zhang", "opencv_fisheye", "general"):
        angle = last.column(f"{model}.rms_deg")[0]
        found[f"{model}_deg"] = f"{angle:.2g}" if isfinite(angle) else FAILED
    share = last.column("general.share_with_ray")[0]
    found["share"] = f"{100 * share:.0f} %" if isfinite(share) else FAILED
    return found


def counted(results):
    """Boards right on rendered sets and on photographs, for the prose."""
    found = {"record.date": results[detector_counts.RECORD].settings["date"]}
    for one in detector_counts.summed(detector_counts.every_count(results)):
        found[f"{one.evidence}.pictures"] = one.count
        for name, count in (("right", one.right), ("wrong", one.wrong)):
            for detector in detector_counts.DETECTORS:
                found[f"{one.evidence}.{detector}.{name}"] = count[detector]
    return found
