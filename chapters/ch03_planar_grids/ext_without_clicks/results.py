"""Results of the page on extraction without clicks, over all images."""

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import NAMES

ROWS = (
    ("raxel", "known"),
    ("raxel", "counted"),
    ("opencv", "known"),
    ("opencv-sb", "known"),
    ("opencv-sb", "counted"),
)


def known(result, name):
    """Return the finite values of all trials of all conditions, (N,)."""
    found = result.select().column(name)
    return found[np.isfinite(found)]


def found_row(result, detector, size):
    """Return one row of the table of detectors."""
    off, right, wrong = (
        known(result, f"{detector}.{size}.{name}")
        for name in ("worst_px", "right", "wrong")
    )
    return {
        "Detector": detector,
        "Size": NAMES[size].removeprefix("size "),
        "Boards": len(right),
        "Right": int(right.sum()),
        "Wrong": int(wrong.sum()),
        "Median of worst (px)": float(np.median(off)) if len(off) else None,
        "Worst (px)": float(off.max()) if len(off) else None,
    }


def facts(zoo):
    """Return the numbers that the prose quotes, by name."""
    rows = {(d, s): found_row(zoo, d, s) for d, s in ROWS}
    mine = rows["raxel", "known"]
    return {
        "boards": mine["Boards"],
        "right": mine["Right"],
        "counted": rows["raxel", "counted"]["Right"],
        "opencv.right": rows["opencv", "known"]["Right"],
        "opencv-sb.counted": rows["opencv-sb", "counted"]["Right"],
        "wrong": mine["Wrong"] + rows["raxel", "counted"]["Wrong"],
    }
