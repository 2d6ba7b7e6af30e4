"""Results of the page on extraction without clicks, over all that was pictured."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import NAMES

ROWS = (
    ("raxel", "known"),
    ("raxel", "counted"),
    ("opencv", "known"),
    ("opencv-sb", "known"),
    ("opencv-sb", "counted"),
)


def over(result, name):
    """Values of all trials of all conditions that have them, (N,)."""
    parts = [result.column(name, **one) for one in result.conditions]
    return np.concatenate(parts)


def found_row(result, detector, size):
    """One row of the table of detectors."""
    name = f"{detector}.{size}"
    off = over(result, f"{name}.worst_px")
    off = off[np.isfinite(off)]
    right = int(over(result, f"{name}.right").sum())
    return {
        "Detector": detector,
        "Size": NAMES[size].removeprefix("size "),
        "Boards": len(over(result, f"{name}.right")),
        "Right": right,
        "Wrong": int(over(result, f"{name}.wrong").sum()),
        "Median of worst (px)": float(np.median(off)) if len(off) else None,
        "Worst (px)": float(off.max()) if len(off) else None,
    }


def facts(zoo, sweeps):
    """What the prose says, as {name: number or text}."""
    rows = {(d, s): found_row(zoo, d, s) for d, s in ROWS}
    share = over(sweeps, "share")
    share = share[np.isfinite(share)]
    mine = rows["raxel", "known"]
    return {
        "boards": mine["Boards"],
        "right": mine["Right"],
        "counted": rows["raxel", "counted"]["Right"],
        "wrong": mine["Wrong"] + rows["raxel", "counted"]["Wrong"],
        "swept": len(over(sweeps, "found")),
        "swept_found": int(over(sweeps, "found").sum()),
        "swept_wrong": int(over(sweeps, "wrong").sum()),
        "swept_share": f"{100 * np.median(share):.0f} %"
        if len(share)
        else "none is refused",
    }
