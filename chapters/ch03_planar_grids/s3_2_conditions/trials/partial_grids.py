"""Extraction of parts of a large grid without a border (Fig. 3.14).

Parts of the grid are tried from the whole grid downwards, excluding the smallest
squares, until a method returns one. Then rows or columns are added as long as the
larger part is returned, too. CELECT gets the image as it is and clicks on the part's
corners; OpenCV gets white paint around the part's squares.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import cv2
import numpy as np

from chapters.ch03_planar_grids.s3_2_conditions.trials.detector_runs import (
    DONE,
    detected,
    draw_clicks,
    run,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import (
    outline_px,
    photograph,
    sheet_of,
)
from chapters.shared.grid_detectors import CELECT, OPENCV, OPENCV_SB

MIN_LINES = 3
WHITE = 255
BORDER_PX = 24
# Each part tried has at most this share of the corners of the one before.
NEXT_SHARE = {"quick": 0.8, "full": 0.95}


class Part(NamedTuple):
    """Corners of rows top to bottom and columns left to right, ends included."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def count(self):
        """Number of corners."""
        return (self.bottom - self.top + 1) * (self.right - self.left + 1)

    def of(self, lattice):
        """The part (rows, columns, 2) of a lattice."""
        return lattice[self.top : self.bottom + 1, self.left : self.right + 1]

    def moved(self, side, step):
        """The part with one side moved outwards by `step` lines (-1: inwards)."""
        outwards = (-step, step, -step, step)[side]
        return self._replace(**{self._fields[side]: self[side] + outwards})


def large_grids(effort):
    """Return the conditions of both cameras with a large grid."""
    return [
        {"camera": camera, "next_share": NEXT_SHARE[effort]}
        for camera in ("hyperboloidal", "fisheye")
    ]


def candidate_parts(lattice, next_share):
    """Return parts from the whole lattice down, each the largest of its smallest step.

    Excluding exactly the squares below a size gives one of them. Each has at most
    `next_share` of the corners of the one before.
    """
    parts, kept, longest = _all_parts(lattice), [], -1.0
    for part, step in sorted(parts, key=lambda p: (-p[0].count, -p[1])):
        if step <= longest:
            continue
        longest = step
        if not kept or part.count <= next_share * kept[-1].count:
            kept.append(part)
    return kept


def _all_parts(lattice):
    """Return every part of at least MIN_LINES lines each way, and its smallest step."""
    rows, columns = lattice.shape[:2]
    across = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    down = np.linalg.norm(np.diff(lattice, axis=0), axis=2)
    found = []
    for top in range(rows - MIN_LINES + 1):
        for bottom in range(top + MIN_LINES - 1, rows):
            h = across[top : bottom + 1].min(axis=0)
            v = down[top:bottom].min(axis=0)
            for left in range(columns - MIN_LINES + 1):
                steps = np.minimum.accumulate(
                    np.minimum(v[left:], np.append(np.inf, h[left:]))
                )
                steps = np.minimum(steps, v[left])
                found += [
                    (Part(top, bottom, left, right), float(steps[right - left]))
                    for right in range(left + MIN_LINES - 1, columns)
                ]
    return found


def largest_part(returns, lattice, next_share):
    """Return the part at which the search ends, or None, and the number of parts tried.

    returns: part -> whether the method returned all of it, in order.
    """
    rows, columns = lattice.shape[:2]
    whole = Part(0, rows - 1, 0, columns - 1)
    known = {}

    def tried(part):
        if part not in known:
            known[part] = returns(part)
        return known[part]

    part = next(filter(tried, candidate_parts(lattice, next_share)), None)
    while part:
        larger = next(filter(tried, _extended(part, whole)), None)
        if larger is None:
            break
        part = larger
    return part, len(known)


def _extended(part, whole):
    """Return the part with one line more at any side; the longest line first."""
    more = [part.moved(side, 1) for side in range(4) if part[side] != whole[side]]
    return sorted(more, key=lambda p: -p.count)


def painted(sheet, image, part):
    """Return the image with white around the squares of a part, by their true outline.

    Returns the image cropped to the squares and 24 px around them, and the part's
    true corners (rows, columns, 2) in it.
    """
    points = part.of(sheet.points).reshape(-1, 2)
    pitch = sheet.rig.target.pitch_mm
    low, high = points.min(axis=0) - pitch, points.max(axis=0) + pitch
    mask = np.zeros(image.shape, np.uint8)
    around = np.rint(outline_px(sheet, low, high)).astype(np.int32)
    cv2.fillPoly(mask, [around], 1)
    bordered = np.where(mask == 1, image, np.uint8(WHITE))
    first = np.maximum(around.min(axis=0) - BORDER_PX, 0)
    end = around.max(axis=0) + BORDER_PX + 1
    cut = bordered[first[1] : end[1], first[0] : end[0]]
    return cut, part.of(sheet.lattice) - first


def border_distance(corners, image):
    """Return the distance (px) of corners (..., 2) to the image border."""
    height, width = image.shape
    far = np.array([width - 0.5, height - 0.5])
    return float(min((corners + 0.5).min(), (far - corners).min()))


def partial_trial(condition, rng):
    """Return the largest part of CELECT and of OpenCV in one image of a large grid."""
    sheet, image = _large_picture(condition, rng)
    offsets = draw_clicks(rng)
    stages = Counter()

    def returns(part):
        clicked = run(image, part.of(sheet.lattice), offsets)
        stages[clicked.stage] += 1
        return clicked.right

    share = condition["next_share"]
    clicked = _extracted(returns, sheet, image, share)
    return {
        "picture": image,
        "lattice": sheet.lattice,
        CELECT: clicked | {"lost": {s: n for s, n in stages.items() if s != DONE}},
        OPENCV: _by_detector(OPENCV, sheet, image, share),
    }


def partial_sb_trial(condition, rng):
    """Return the largest part of OpenCV's sector-based detector in the same image."""
    picture = _large_picture(condition, rng)
    return {OPENCV_SB: _by_detector(OPENCV_SB, *picture, condition["next_share"])}


def _large_picture(condition, rng):
    sheet = sheet_of(f"large-{condition['camera']}", rng)
    return sheet, photograph(sheet, sheet.rig.light.draw(rng, sheet.rig.extent))


def _by_detector(name, sheet, image, next_share):
    """Return values of the search with white paint around every part."""

    def returns(part):
        return detected(name, *painted(sheet, image, part))

    return _extracted(returns, sheet, image, next_share)


def _extracted(returns, sheet, image, next_share):
    """Return values of a search: final part, size and distance to the border."""
    part, tries = largest_part(returns, sheet.lattice, next_share)
    if part is None:
        return {"tries": tries, "count": 0}
    corners = part.of(sheet.lattice)
    bordered, cut_corners = painted(sheet, image, part)
    long, short = sorted(corners.shape[:2], reverse=True)
    return {
        "tries": tries,
        "count": part.count,
        "columns": long,
        "rows": short,
        "border_px": border_distance(corners, image),
        "corners": corners,
        "painted": bordered,
        "first": corners[0, 0] - cut_corners[0, 0],
    }
