"""The target of a rig and its poses, from the values in the rig's file."""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector
from raxel.lab.monitor import Monitor
from raxel.lab.target_poses import AroundPoses, DrawnPoses, ListedPoses
from raxel.sets.model import ActiveGrid, Chessboard, MonitorChessboard
from raxel.sets.patterns import PatternPlan, plan_of_cells

RADIANCES = {
    "chessboard": {"black": 0.05, "white": 0.9, "background": 0.4},
    "active_grid": {"background": 0.05},
}
PLAN = ("gray_bits", "gray_inverse", "phase_steps", "phase_periods", "cell_px")


def read_chessboard(values):
    """The Chessboard of a section `target`."""
    return Chessboard(values["columns"], values["rows"], float(values["pitch"]))


def read_active_grid(values):
    """The ActiveGrid of a section `target`, with the chessboard that it shows."""
    board = values.get("chessboard")
    if board:
        origin = tuple(map(float, board["origin"]))
        counts = board["columns"], board["rows"]
        board = MonitorChessboard(*counts, float(board["pitch"]), origin)
    size_mm = tuple(map(float, values["monitor_mm"]))
    return ActiveGrid(values["monitor_px"], size_mm, board)


def read_monitor(values):
    """The Monitor of a section `target`. Raises InputError as Monitor does."""
    names = ("gamma", "black_level", "falloff_exponent", "white")
    return Monitor(**{name: values[name] for name in names if name in values})


def read_radiances(values):
    """Keyword arguments of the ready-made scene."""
    usual = RADIANCES[values["kind"]]
    return {name: values.get(name, value) for name, value in usual.items()}


def pattern_plan(values):
    """The PatternPlan of `cells`, or of bits and periods each on their own.

    Raises InputError where both are given, or no pattern.
    """
    given = {name: values[name] for name in PLAN if name in values}
    if "cells" not in values:
        plan = PatternPlan(**given)
        if not any(plan.gray_bits) and not any(plan.phase_periods):
            raise InputError(
                "field 'gray_bits': no pattern asked for; give gray_bits or "
                "phase_periods, or cells"
            )
        return plan
    steps = given.pop("phase_steps", PatternPlan.phase_steps)
    if given:
        raise InputError(
            f"field '{next(iter(given))}': found beside cells, which say it already; "
            "give one of the two"
        )
    return plan_of_cells(values["monitor_px"], values["cells"], steps)


def read_poses(values):
    """(DrawnPoses, AroundPoses or ListedPoses; how many views to calibrate with).

    Raises InputError for ranges that end before they begin, names given twice, and a
    list that is all kept for evaluation.
    """
    if values["kind"] == "listed":
        return _listed(values)
    around = values["kind"] == "around"
    names = ("polar", "subtense") if around else ("distance", "off_axis")
    ranges = {}
    for name in (*names, "tilt", "turn"):
        low, high = values[name]
        if low > high:
            raise InputError(
                f"field '{name}.value': found [{low}, {high}]; give the least first, "
                "then the greatest"
            )
        ranges[name] = (low, high) if name == "distance" else np.radians((low, high))
    if around:
        place = AroundPoses(values["centre"], values["axis"], **ranges)
        return place, values["count"]
    distance = ranges.pop("distance")
    return DrawnPoses(distance, **ranges), values["count"]


def _listed(values):
    entries = values["list"]
    vectors = np.radians([entry["rotation"] for entry in entries])
    shifts = np.array([entry["translation"] for entry in entries], float)
    evaluate = values.get("evaluate", 0)
    if evaluate >= len(shifts):
        raise InputError(
            f"field 'evaluate.value': found {evaluate} of {len(shifts)} poses; leave "
            "some to calibrate with"
        )
    names = tuple(entry.get("name") for entry in entries)
    for index, name in enumerate(names):
        if name and name in names[:index]:
            raise InputError(
                f"field 'list[{index}].name': found {name!r}, which "
                f"list[{names.index(name)}] has already; give each its own"
            )
    by_hand = values.get("set_up", {"shift": 0, "turn": 0})
    listed = ListedPoses(
        pose(rotation_from_vector(vectors), shifts),
        names,
        tuple(entry.get("patterns_only", False) for entry in entries),
        tuple(entry.get("lens_shift", (0, 0)) for entry in entries),
        float(by_hand["shift"]),
        float(np.radians(by_hand["turn"])),
    )
    return listed, len(shifts) - evaluate
