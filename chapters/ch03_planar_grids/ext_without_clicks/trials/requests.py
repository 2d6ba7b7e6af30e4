"""Trials of the page on extraction without clicks."""

from __future__ import annotations

from math import ceil

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.trials.zoo_boards import (
    DRAWN,
    LARGER,
    zoo_board,
)
from chapters.shared.synthetic_board import Board
from raxel.features import DETECTORS, find_board, symmetries

RIGHT_PX = 1.0
COUNTING = ("raxel", "opencv-sb")
NAMES = {"known": "size given", "counted": "size not given"}
SETTINGS = {
    "right_px": RIGHT_PX,
    "larger": LARGER,
    "drawn": {name: list(limits) for name, limits in DRAWN.items()},
}
SWEPT = {
    "noise": ("noise_sd", "SD of the noise", "grey levels"),
    "blur": ("blur_px", "SD of the blur", "px"),
    "squares": ("square_px", "side of a square", "px"),
    "field": ("fov_deg", "field of view", "°"),
    "yaw": ("yaw_deg", "yaw", "°"),
}
LEVELS = {
    "noise": (0, 10, 20, 30, 40, 60),
    "blur": (1, 2, 3, 4, 5, 7),
    "squares": (100, 66, 50, 40, 33),
    "field": (100, 120, 134, 145, 152),
    "yaw": (0, 15, 30, 40, 44),
}
QUICK_LEVELS = {
    "noise": (20,),
    "blur": (2,),
    "squares": (),
    "field": (),
    "yaw": (),
}


def worst(found, corners, columns, rows):
    """Largest distance in px to the true corners, infinite for another size."""
    return min(
        (
            float(np.linalg.norm(order - corners, axis=1).max())
            for order, size in symmetries(
                found.corners, found.columns, found.rows
            )
            if size == (columns, rows)
        ),
        default=np.inf,
    )


def scored(found, corners, columns, rows):
    """{found, right, wrong, worst_px} of a Detection."""
    off = worst(found, corners, columns, rows) if found.found else np.inf
    right = off <= RIGHT_PX
    return {
        "found": bool(found.found),
        "right": bool(right),
        "wrong": bool(found.found and not right),
        "worst_px": off if right else None,
    }


def zoo_trial(condition, rng):
    """One board before one camera; every detector, and what must be refused."""
    board = zoo_board(condition["camera"], rng)
    image, corners = board.image, board.corners
    size = board.columns, board.rows
    out = {}
    for name, detector in DETECTORS.items():
        out[name] = {
            "known": scored(detector(image, *size), corners, *size)
        }
        if name in COUNTING:
            counted = detector(image, None, None)
            out[name]["counted"] = scored(counted, corners, *size)
    return out | {"refusals": refusals(board)}


def refusals(board):
    """What `find_board` makes of pictures in which the wanted board is not."""
    image, columns, rows = board.image, board.columns, board.rows
    cut = int(np.median(board.corners[:, 0]))
    cropped = np.ascontiguousarray(image[:, cut:])
    two = np.hstack([image, image])
    asked = {
        "one column too many": (image, columns + 1, rows),
        "one column too few": (image, columns - 1, rows),
        "cropped, size given": (cropped, columns, rows),
        "cropped, size not given": (cropped, None, None),
        "two boards, size given": (two, columns, rows),
        "two boards, size not given": (two, None, None),
    }
    out = {}
    for name, (picture, *size) in asked.items():
        found = find_board(picture, *size)
        out[name] = {"refused": not found.found}
        true = (
            board.corners - [cut, 0] if "cropped" in name else board.corners
        )
        if "two" not in name:
            out[name]["share"] = share_in_order(
                found.partial, true, (columns, rows), picture.shape
            )
    return out


def share_in_order(partial, true, size, shape):
    """Share of the true corners inside the image that the ordered part has in order.

    A corner is in order if it lies within a pixel of the true corner to which one of
    the eight symmetries of a lattice, and one shift, take its row and column.
    """
    columns, _ = size
    inside = np.all((true > 4) & (true < np.array(shape[::-1]) - 5), axis=1)
    if partial is None or not inside.any():
        return 0.0
    apart = np.linalg.norm(partial.corners[:, None] - true[None], axis=2)
    nearest = apart.argmin(axis=1)
    good = (apart.min(axis=1) < RIGHT_PX) & inside[nearest]
    place = np.stack(np.divmod(nearest[good], columns), axis=1)
    best = 0
    for turned in (partial.indices[good], partial.indices[good][:, ::-1]):
        for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            _, counts = np.unique(
                place - turned * sign, axis=0, return_counts=True
            )
            best = max(best, counts.max(initial=0))
    return float(best / inside.sum())


def sweep_conditions(effort):
    """Every level of every sweep."""
    levels = LEVELS if effort == "full" else QUICK_LEVELS
    return [
        {"sweep": sweep, "level": level}
        for sweep, values in levels.items()
        for level in values
    ]


def sweep_trial(condition, rng):
    """The synthetic board of 3.3.1 with one thing changed, its size given."""
    name = SWEPT[condition["sweep"]][0]
    changed = {name: condition["level"]}
    geometry = {
        k: v for k, v in changed.items() if k not in ("noise_sd", "blur_px")
    }
    optics = {
        k: v for k, v in changed.items() if k in ("noise_sd", "blur_px")
    }
    board = Board(**geometry)
    image = board.image(rng=rng, **optics)
    size = board.columns, board.rows
    found = find_board(image, *size)
    out = scored(found, board.corners, *size)
    if not found.found:
        out["share"] = share_in_order(
            found.partial, board.corners, size, image.shape
        )
    return out


def part_task():
    """What `check` needs for the exercise."""
    return {
        "expected": least_in_order,
        "hint": "round up: part of a corner is none",
        "slips": {
            "That counts the lost column too.": lambda: ceil(0.95 * 54),
        },
    }


def least_in_order():
    """Corners that make 95 % of eight columns of six."""
    return ceil(0.95 * 48)
