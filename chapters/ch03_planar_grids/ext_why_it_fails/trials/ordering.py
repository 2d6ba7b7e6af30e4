"""The two orderings of section 1.2.1 on corners that are given to them."""

import math

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.sector_board import SectorBoard
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import spacing
from chapters.shared.lattices import outer
from chapters.shared.synthetic_board import SyntheticBoard
from raxel.features.celect.baselines import (
    order_by_homography,
    order_by_joining_line,
    row_margin,
)
from raxel.geometry import apply_homography, homography_dlt
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

TRIALS = {"quick": 1, "full": 20}
CORNER_SD_PX = 0.5
ARCS_DEG = (1, 5, 10, 15, 20, 25, 30, 40, 50, 60, 80, 100, 130, 160)
FOVS_DEG = (20, 40, 60, 70, 80, 90, 100, 110, 120, 134, 146, 158)
HALF_WIDTH_PX, DEPTH_PX = 300.0, 200.0
BENDS = {"arc": ARCS_DEG, "fov": FOVS_DEG}
FEW = {"arc": (5, 60), "fov": (60, 134)}


def bends(effort):
    """Conditions of the two families of boards."""
    taken = FEW if effort == "quick" else BENDS
    return [{"family": f, "bend_deg": b} for f in taken for b in taken[f]]


def lattice_at(condition, rng):
    """True corners (rows, columns, 2) of a bent board, turned at random."""
    bend = condition["bend_deg"]
    if condition["family"] == "fov":
        return SyntheticBoard(fov_deg=bend).lattice
    radius = HALF_WIDTH_PX / math.sin(math.radians(bend) / 2)
    return SectorBoard(
        arc_deg=bend, radius_px=radius, depth_px=DEPTH_PX, turn_deg=rng.uniform(0, 360)
    ).lattice


def ordering_trial(condition, rng):
    """Corners with a small error, shuffled, then ordered in two ways.

    margin: `row_margin` over the smallest spacing; stray: the largest distance of a
    corner from its place under the homography of the four outer ones, over its own
    spacing.
    """
    true = lattice_at(condition, rng)
    rows, columns = true.shape[:2]
    corners = true + rng.normal(0.0, CORNER_SD_PX, true.shape)
    ends = outer(corners)
    points = rng.permutation(corners.reshape(-1, 2))
    by_line = order_by_joining_line(points, ends, columns, rows)
    by_plane = order_by_homography(points, ends, columns, rows)
    side = spacing(corners)
    stray = np.linalg.norm(_flat(ends, rows, columns) - corners, axis=2)
    return {
        "line": bool(np.array_equal(by_line, corners)),
        "homography": bool(np.array_equal(by_plane, corners)),
        "margin": row_margin(corners) / float(side.min()),
        "stray": float((stray / side).max()),
    }


@experiment("ext_why_orderings", artefact="ext_why_orderings")
def orderings(effort):
    """The two orderings of 1.2.1 on corners of boards that bend more and more."""
    settings = {"corner_sd_px": CORNER_SD_PX}
    return Plan(ordering_trial, bends(effort), TRIALS[effort], settings)


def _flat(outer, rows, columns):
    """Where the homography of the outer corners (4, 2) puts all: (rows, columns, 2)."""
    last = columns - 1, rows - 1
    ends = np.array([[0, 0], [last[0], 0], last, [0, last[1]]], float)
    y, x = np.mgrid[:rows, :columns].astype(float)
    points = np.column_stack((x.ravel(), y.ravel()))
    places = apply_homography(homography_dlt(ends, outer), points)
    return places.reshape(rows, columns, 2)
