"""What the scores of rendered sets say, and the numbers of the prose."""

from __future__ import annotations

from math import isfinite

from chapters.guides.benchmarks.trials import DETECTORS
from chapters.shared import detector_counts

FAILED = "failed"


def scored_rigs(result):
    """Names of the rigs that have scores."""
    return [condition["rig"] for condition in result.conditions]


def _told(x):
    return f"{x:.2g}" if isfinite(x) else FAILED


def worst_corner(result):
    """The largest error of a corner in px, over all cameras."""
    return max(
        float(result.column("largest", **condition)[0])
        for condition in result.conditions
        if condition["check"] == "corners"
    )


def worst_of(result, check):
    """The largest error of one check of photometry."""
    return float(result.column("largest", check=check)[0])


def facts(scores):
    """What the prose says of the scored rigs, as {name: number or text}."""
    rigs = scored_rigs(scores)
    last = rigs[-1]
    found = {
        "views": scores.settings["views"] * len(rigs),
        "rigs": ", ".join(rigs),
        "last": last,
    }
    for one in DETECTORS:
        rights = [scores.column(f"{one}.right", rig=r)[0] for r in rigs]
        found[f"right_{one}"] = int(sum(rights))
    for model in ("zhang", "opencv_fisheye", "general"):
        angle = float(scores.column(f"{model}.rms_deg", rig=last)[0])
        found[f"{model}_deg"] = _told(angle)
    share = float(scores.column("general.share_with_ray", rig=last)[0])
    found["share"] = f"{100 * share:.0f} %" if isfinite(share) else FAILED
    return found


def counted(results):
    """Boards right on rendered sets and on photographs, for the prose."""
    record = results[detector_counts.RECORD]
    sums = detector_counts.summed(
        [
            *detector_counts.rendered_counts(results),
            *detector_counts.recorded_counts(record),
        ]
    )
    found = {}
    for one in sums:
        found[f"{one.evidence}.pictures"] = one.count
        for detector in detector_counts.DETECTORS:
            stem = f"{one.evidence}.{detector}"
            found[f"{stem}.right"] = one.right[detector]
            found[f"{stem}.wrong"] = one.wrong[detector]
    return found | {"record.date": record.settings["date"]}
