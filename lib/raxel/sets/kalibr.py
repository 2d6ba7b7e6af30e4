"""Targets as Kalibr describes them."""

from raxel.errors import InputError
from raxel.io.documents import read_yaml, shown
from raxel.sets.model import AprilGrid, Chessboard, CircleGrid

MM = 1000.0  # per metre


def read_kalibr_target(path):
    """Return the target (aprilgrid, checkerboard, circlegrid) of a YAML file of Kalibr.

    Raises InputError for other files. The message names the file and the field.
    """
    data = read_yaml(path)
    kind = data.get("target_type") if isinstance(data, dict) else None
    if kind not in ("aprilgrid", "checkerboard", "circlegrid"):
        raise InputError(
            f"{path}: target_type: found {shown(kind)}; give aprilgrid, checkerboard "
            "or circlegrid"
        )
    try:
        if kind == "aprilgrid":
            tag = MM * float(data["tagSize"])
            pitch = tag * (1 + float(data["tagSpacing"]))
            counts = 2 * int(data["tagCols"]), 2 * int(data["tagRows"])
            first = int(data.get("codeOffset", 0))
            return AprilGrid(*counts, pitch, tag, first_id=first)
        counts = int(data["targetCols"]), int(data["targetRows"])
        if kind == "checkerboard":
            return Chessboard(*counts, MM * _pitch(data))
        staggered = bool(data.get("asymmetricGrid", False))
        return CircleGrid(*counts, MM * float(data["spacingMeters"]), staggered)
    except KeyError as fault:
        raise InputError(f"{path}: {fault.args[0]}: missing; add it") from fault
    except (TypeError, ValueError) as fault:
        raise InputError(f"{path}: not a target of Kalibr ({fault})") from fault


def _pitch(data):
    """Side of a square, m; ValueError where squares are not square."""
    rows = float(data["rowSpacingMeters"])
    if float(data.get("colSpacingMeters", rows)) != rows:
        raise ValueError("rowSpacingMeters and colSpacingMeters differ")
    return rows
