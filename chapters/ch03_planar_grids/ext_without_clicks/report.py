"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.experiment import NAMES, RIGHT_PX
from repro.run import Check, Table, in_columns, table

# Results of the page on extraction without clicks, over all images.


ROWS = (
    ("raxel", "known"),
    ("raxel", "counted"),
    ("opencv", "known"),
    ("opencv-sb", "known"),
    ("opencv-sb", "counted"),
)


def found_row(result, detector, size):
    """Return one row of the table of detectors."""
    off, right, wrong = result.select().column(
        detector, size, ("worst_px", "right", "wrong")
    )
    off = off[right == 1]
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


# Tables of the page on extraction without clicks: boards, and rejections.


REQUESTS = (
    "one column too many",
    "one column too few",
    "cropped, size given",
    "cropped, size not given",
    "two boards, size given",
    "two boards, size not given",
)


@table("ext_without_clicks", needs=("ext_without_clicks_zoo",), evidence="rendered")
def ext_without_clicks(results):
    """Return results of the detectors on boards in front of the zoo's cameras."""
    result = results["ext_without_clicks_zoo"]
    rows = [found_row(result, *row) for row in ROWS]
    wrong = rows[0]["Wrong"] + rows[1]["Wrong"]
    return Table(
        in_columns(rows),
        f"Extraction results by detector, one board for each of "
        f"{len(result.conditions)} cameras of the zoo. Right: every corner within "
        f"{RIGHT_PX:g} px. Wrong: returned, but not right. Worst: largest corner "
        "error of a board, over the right boards.",
        Check(wrong == 0, f"raxel returned {wrong} wrong boards; the aim is 0"),
    )


@table(
    "ext_click_free_refusals", needs=("ext_without_clicks_zoo",), evidence="rendered"
)
def ext_click_free_refusals(results):
    """Return what must be rejected, and the ordered part that is reported."""
    result = results["ext_without_clicks_zoo"]
    rows = [_rejection_row(result, name) for name in REQUESTS]
    returned = sum(row["Images"] - row["Rejected"] for row in rows)
    return Table(
        in_columns(rows),
        "Rejections by raxel of images that do not show the requested board. In "
        "order: share of the visible corners that the rejection reports, in order.",
        Check(returned == 0, f"{returned} boards were returned; the aim is 0"),
    )


def _rejection_row(result, name):
    trials = result.select()
    rejected = trials.column("refusals", name, "refused")
    share = 100 * trials.column("refusals", name, "share")
    share = share[np.isfinite(share)]
    return {
        "Request": name,
        "Images": len(rejected),
        "Rejected": int(rejected.sum()),
        "In order, median (%)": float(np.median(share)) if len(share) else None,
        "In order, minimum (%)": float(share.min()) if len(share) else None,
    }
