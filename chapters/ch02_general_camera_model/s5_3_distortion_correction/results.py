"""Distances from straight lines, read from the seeds of section 2.5.2."""

from __future__ import annotations

import numpy as np

from chapters.shared.facade import FEWEST
from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.judge.statistics import with_worst


def line_median(made, name, scale="corrected"):
    """Median over seeds of a method's distance from straight lines."""
    place = f"lines.generic_as_printed.{name}.{scale}"
    trials = made.column(place, zoom=FACADE_ZOOM)
    return float(np.median(with_worst(trials)))


def edges_of(rendered):
    """The front's edges (edges, points, 2) as taken and as corrected, px."""
    names = ("as_taken", "parametric", "generic_as_printed")
    return {
        name: rendered.arrays(f"edges.{name}", zoom=FACADE_ZOOM)[0]
        for name in names
    }


def shared(edges):
    """Which points (edges, points) both corrected pictures show."""
    return np.isfinite(
        edges["parametric"][..., 0] + edges["generic_as_printed"][..., 0]
    )


def from_line(edge, known):
    """Signed distances (points,) of an edge from the line of its known points."""
    centre, along = best_line(edge[known])
    return (edge - centre) @ [-along[1], along[0]]


def best_line(points):
    """A point and the direction of the best line (total least squares)."""
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre)[2][0]


def line_through(points, reach_px=2000.0):
    """Two points (2, 2) far apart on the best line of points."""
    centre, along = best_line(points)
    return centre + np.outer([-reach_px, reach_px], along)


def most_bent(edges):
    """Number of the edge that the parametric picture bends most, and a point.

    The point, in that picture, is halfway from where the edge leaves the boards
    to where it is farthest from its line.
    """
    both, parametric = shared(edges), edges["parametric"]
    off = np.full(both.shape, np.nan)
    for number in np.flatnonzero(np.sum(both, axis=1) >= FEWEST):
        off[number] = np.abs(from_line(parametric[number], both[number]))
    number, worst = np.unravel_index(np.nanargmax(off), off.shape)
    known = np.flatnonzero(both[number])
    leaves = known[np.argmin(np.abs(known - worst))]
    return number, parametric[number, [leaves, worst]].mean(axis=0)
