"""What the scores of rendered sets say, and the numbers of the prose."""

from __future__ import annotations

from math import isfinite

from chapters.guides.benchmarks.trials import DETECTORS

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
    views = scores.settings["views"]
    last = rigs[-1]
    right = {
        one: sum(
            int(scores.column(f"{one}.right", rig=name)[0]) for name in rigs
        )
        for one in DETECTORS
    }
    found = {
        "views": views * len(rigs),
        "rigs": ", ".join(rigs),
        "right_raxel": right["raxel"],
        "right_cv": right["opencv"],
        "right_sb": right["opencv-sb"],
        "last": last,
    }
    for model in ("zhang", "general"):
        angle = float(scores.column(f"{model}.rms_deg", rig=last)[0])
        found[f"{model}_deg"] = _told(angle)
    share = float(scores.column("general.share_with_ray", rig=last)[0])
    found["share"] = f"{100 * share:.0f} %" if isfinite(share) else FAILED
    return found
