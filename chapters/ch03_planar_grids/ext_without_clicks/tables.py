"""Tables and the figure of the page on extraction without clicks."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import (
    NAMES,
    RIGHT_PX,
    SWEPT,
)
from repro.page.style import figure as new_figure
from repro.run.experiment import figure, table
from repro.run.outcomes import Check, Drawing, Table

ROWS = (
    ("raxel", "known"),
    ("raxel", "counted"),
    ("opencv", "known"),
    ("opencv-sb", "known"),
    ("opencv-sb", "counted"),
)
ASKED = (
    "one column too many",
    "one column too few",
    "cropped, size given",
    "cropped, size not given",
    "two boards, size given",
    "two boards, size not given",
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
        "Median of worst (px)": float(np.median(off))
        if len(off)
        else np.nan,
        "Worst (px)": float(off.max()) if len(off) else np.nan,
    }


@table(
    "ext_without_clicks",
    needs=("ext_without_clicks_zoo",),
    evidence="rendered",
)
def ext_without_clicks(results):
    """Detectors side by side on boards before the cameras of the zoo."""
    result = results["ext_without_clicks_zoo"]
    rows = [found_row(result, *row) for row in ROWS]
    wrong = rows[0]["Wrong"] + rows[1]["Wrong"]
    return Table(
        {key: [row[key] for row in rows] for key in rows[0]},
        f"Boards before {len(result.conditions)} cameras of the zoo. Right: every "
        f"corner within {RIGHT_PX:g} px. Wrong: returned, and not right. Worst: of a "
        "board's corners, over the boards that are right.",
        Check(
            wrong == 0,
            f"raxel returned {wrong} wrong boards; the aim is none",
        ),
    )


@table(
    "ext_click_free_refusals",
    needs=("ext_without_clicks_zoo",),
    evidence="rendered",
)
def ext_click_free_refusals(results):
    """What must be refused, and what is handed over all the same."""
    result = results["ext_without_clicks_zoo"]
    rows = [_refusal_row(result, name) for name in ASKED]
    returned = sum(row["Pictures"] - row["Refused"] for row in rows)
    return Table(
        {key: [row[key] for row in rows] for key in rows[0]},
        "Pictures that do not show the board asked for, given to raxel. In order: "
        "share of the visible corners that the refusal holds, in order.",
        Check(
            returned == 0,
            f"{returned} boards were returned; the aim is none",
        ),
    )


NOT_TOLD = "–"


def _refusal_row(result, name):
    refused = over(result, f"refusals.{name}.refused")
    row = {
        "Asked for": name,
        "Pictures": len(refused),
        "Refused": int(refused.sum()),
    }
    share = np.array([])
    if "two" not in name:
        share = over(result, f"refusals.{name}.share")
        share = share[np.isfinite(share)]
    told = len(share) > 0
    row["In order, median (%)"] = (
        100 * float(np.median(share)) if told else NOT_TOLD
    )
    row["In order, least (%)"] = (
        100 * float(share.min()) if told else NOT_TOLD
    )
    return row


@figure(
    "ext_click_free_sweeps",
    needs=("ext_without_clicks_sweeps",),
    evidence="rendered",
)
def ext_click_free_sweeps(results):
    """The worst corner of each board over five sweeps, and the refusals."""
    result = results["ext_without_clicks_sweeps"]
    drawn, axes = new_figure(2, 3, height_in=4.4)
    data = {name: [] for name in ("sweep", "level", "worst_px", "found")}
    for axis, (sweep, (_, label, unit)) in zip(
        axes.flat, SWEPT.items(), strict=False
    ):
        for one in result.conditions:
            if one["sweep"] != sweep:
                continue
            off = result.column("worst_px", **one)
            found = result.column("found", **one)
            for x, y in zip(found, off, strict=True):
                data["sweep"].append(sweep)
                data["level"].append(one["level"])
                data["worst_px"].append(y)
                data["found"].append(x)
            right = np.isfinite(off)
            axis.plot(
                [one["level"]] * right.sum(),
                off[right],
                "o",
                color="C0",
                ms=4,
            )
            lost = np.count_nonzero(found == 0)
            axis.plot(
                [one["level"]] * lost, [1.0] * lost, "x", color="C1", ms=5
            )
        axis.axhline(RIGHT_PX, color="0.6", lw=0.8)
        axis.set_ylim(0, 1.15)
        axis.set_xlabel(f"{label} ({unit})")
        axis.set_ylabel("worst corner (px)")
    drawn.delaxes(axes.flat[-1])
    drawn.tight_layout()
    off = over(result, "wrong")
    return Drawing(
        drawn,
        data,
        "Boards of 3.3.1 with one thing changed. Dots: the corner farthest from the "
        "truth, of boards that were returned. Crosses: boards that were refused.",
        Check(
            off.sum() == 0,
            f"{int(off.sum())} of {len(off)} boards were returned with a corner more "
            f"than {RIGHT_PX:g} px off, or of a wrong size; the aim is none",
        ),
    )


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
        "right_cv": rows["opencv", "known"]["Right"],
        "right_sb": rows["opencv-sb", "known"]["Right"],
        "wrong": mine["Wrong"] + rows["raxel", "counted"]["Wrong"],
        "swept": len(over(sweeps, "found")),
        "swept_found": int(over(sweeps, "found").sum()),
        "swept_wrong": int(over(sweeps, "wrong").sum()),
        "swept_share": f"{100 * np.median(share):.0f} %"
        if len(share)
        else "none is refused",
    }
