"""Boards detected correctly and wrongly: rendered sets and real images."""

from __future__ import annotations

from typing import NamedTuple

from chapters.shared.grid_detectors import CLICKLESS, OPENCV, OPENCV_SB

RENDERED = ("table_3_4_grids", "table_3_5_grids", "table_3_6_grids", "table_3_7_grids")
RECORD = "ext_detector_record"
DETECTORS = {"raxel": "raxel", "opencv": "OpenCV", "opencv-sb": "OpenCV sector-based"}
# The same detectors as 3.3.2 names them.
NAMES_OF_3_3_2 = {"raxel": CLICKLESS, "opencv": OPENCV, "opencv-sb": OPENCV_SB}


class Counted(NamedTuple):
    """Images of one kind, and the number of correct and wrong boards per detector."""

    evidence: str
    pictures: str
    count: int
    right: dict[str, int]
    wrong: dict[str, int]
    poses: str = ""


def rendered_counts(results):
    """Return a Counted for each set of 3.3.2 and each range of its poses."""
    found = []
    for name in RENDERED:
        for poses, some in results[name].by("poses").items():
            right, returned = (
                {
                    detector: int(some.column(f"{own}.{what}").sum())
                    for detector, own in NAMES_OF_3_3_2.items()
                }
                for what in ("success", "returned")
            )
            wrong = {d: returned[d] - right[d] for d in right}
            title = f"{some.conditions[0]['set']}, {poses} range"
            count = len(some.conditions)
            found.append(Counted("rendered", title, count, right, wrong, poses))
    return found


def recorded_counts(record):
    """Return a Counted for each set of real images in the record."""
    found = []
    for name, kept in record.by("set").items():
        right, wrong = (
            {d: int(kept.column(f"{d}.{what}")[0]) for d in DETECTORS}
            for what in ("right", "wrong")
        )
        count = int(kept.column("images")[0])
        found.append(Counted("photographs", name, count, right, wrong))
    return found


def every_count(results):
    """Return a Counted for each set: rendered ones, then those of the record."""
    return [*rendered_counts(results), *recorded_counts(results[RECORD])]


def summed(counted, by=("evidence",)):
    """Return one Counted per kind, summed over its sets; ``by`` defines the kinds."""

    def kind(one):
        return tuple(getattr(one, name) for name in by)

    found = []
    for wanted in dict.fromkeys(map(kind, counted)):
        some = [c for c in counted if kind(c) == wanted]
        right, wrong = (
            {d: sum(getattr(c, what)[d] for c in some) for d in DETECTORS}
            for what in ("right", "wrong")
        )
        poses = dict(zip(by, wanted, strict=True)).get("poses", "")
        title = f"{len(some)} sets" + (f", {poses} range" if poses else "")
        count = sum(c.count for c in some)
        found.append(Counted(some[0].evidence, title, count, right, wrong, poses))
    return found


def count_columns(counted):
    """Return the columns of a table of Counted rows, numbers as numbers."""
    columns = {
        "Evidence": [c.evidence for c in counted],
        "Set": [c.pictures for c in counted],
        "Images": [c.count for c in counted],
    }
    for detector, name in DETECTORS.items():
        for what in ("right", "wrong"):
            columns[f"{name}: {what}"] = [getattr(c, what)[detector] for c in counted]
    return columns
