"""How much of a large grid without a border is extracted (Fig. 3.14).

A part of the grid is looked for, first all of it; the line of corners with the
shortest step goes until a method returns what is left. Then lines come back as long
as the larger part is returned, too. CELECT gets the picture as it is and clicks on the
part's corners; OpenCV gets white painted round the part's squares.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from chapters.ch03_planar_grids.click_orders import (
    detected_right,
    draw_clicks,
    run,
)
from chapters.ch03_planar_grids.sheet_views import (
    outline_px,
    photograph,
    sheet_of,
)
from raxel.features import DETECTORS
from raxel.lab.lighting import Lighting

FEWEST = 3
WHITE = 255


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
        return lattice[
            self.top : self.bottom + 1, self.left : self.right + 1
        ]

    def moved(self, side, step):
        """The part with one side moved outwards by `step` lines (-1: inwards)."""
        outwards = (-step, step, -step, step)[side]
        return self._replace(**{self._fields[side]: self[side] + outwards})


def without_shortest(part, lattice):
    """The part without the outermost line that holds the shortest step."""
    own = part.of(lattice)
    turned = own, own[::-1], own.swapaxes(0, 1), own.swapaxes(0, 1)[::-1]
    shortest = []
    for lines in turned:
        along = np.linalg.norm(np.diff(lines[0], axis=0), axis=1).min()
        across = np.linalg.norm(lines[1] - lines[0], axis=1).min()
        shortest.append(min(along, across))
    return part.moved(int(np.argmin(shortest)), -1)


def largest_part(returns, lattice):
    """The part that the search ends at, or None, and how many parts were tried.

    returns: part -> whether the method returned all of it, in order.
    """
    rows, columns = lattice.shape[:2]
    whole = Part(0, rows - 1, 0, columns - 1)
    known = {}

    def tried(part):
        if part not in known:
            known[part] = returns(part)
        return known[part]

    part = whole
    while not tried(part):
        part = without_shortest(part, lattice)
        if min(part.of(lattice).shape[:2]) < FEWEST:
            return None, len(known)
    while larger := [p for p in _extended(part, whole) if tried(p)][:1]:
        (part,) = larger
    return part, len(known)


def _extended(part, whole):
    """The part with one line more, the longest first; lazily."""
    more = [
        part.moved(side, 1)
        for side in range(4)
        if part[side] != whole[side]
    ]
    return sorted(more, key=lambda p: -p.count)


def painted(sheet, image, part):
    """The image with white around the squares of a part, by their true outline."""
    points = part.of(sheet.points).reshape(-1, 2)
    pitch = sheet.rig.target.pitch_mm
    low, high = points.min(axis=0) - pitch, points.max(axis=0) + pitch
    mask = np.zeros(image.shape, np.uint8)
    around = np.rint(outline_px(sheet, low, high)).astype(np.int32)
    cv2.fillPoly(mask, [around], 1)
    return np.where(mask == 1, image, np.uint8(WHITE))


def border_distance(corners, image):
    """Distance px from the nearest of corners (..., 2) to the frame of an image."""
    height, width = image.shape
    far = np.array([width - 0.5, height - 0.5])
    return float(min((corners + 0.5).min(), (far - corners).min()))


def partial_trial(condition, rng):
    """One picture of a large grid; the largest part that each method returns."""
    sheet = sheet_of(f"large-{condition['camera']}", rng)
    image = photograph(sheet, Lighting().draw(rng, sheet.rig.extent))
    offsets = draw_clicks(rng)

    def by_clicks(part):
        return run(image, part.of(sheet.lattice), offsets).right

    def by_detector(name):
        def returns(part):
            lattice = part.of(sheet.lattice)
            rows, columns = lattice.shape[:2]
            picture = painted(sheet, image, part)
            detection = DETECTORS[name](picture, columns, rows)
            return detected_right(detection, lattice)

        return returns

    values = {"picture": image, "lattice": sheet.lattice}
    for method in condition["methods"]:
        how = by_clicks if method == "celect" else by_detector(method)
        part, tries = largest_part(how, sheet.lattice)
        values[method] = {"tries": tries, "count": 0}
        if part is not None:
            values[method] |= _extracted(part, sheet, image)
            if method != "celect":
                values[method]["painted"] = painted(sheet, image, part)
    return values


def _extracted(part, sheet, image):
    corners = part.of(sheet.lattice)
    long, short = sorted(corners.shape[:2], reverse=True)
    return {
        "count": part.count,
        "columns": long,
        "rows": short,
        "border_px": border_distance(corners, image),
        "corners": corners,
    }
