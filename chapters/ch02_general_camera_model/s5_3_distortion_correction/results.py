"""Distances from straight lines, from the simulated runs of section 2.5.2."""

import numpy as np

from chapters.shared.facade import FEWEST, HALF_VIEW_DEG, PITCH_DEG
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.judge.statistics import with_worst
from repro.page.reader import value

HALF_PX = 110  # half the side of the enlarged parts


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    edges = edges_of(open_results("table_2_2_rendered"))
    found = {
        **{
            name: line_median(ZoomCase(results), name)
            for name in ("generic", "parametric")
        },
        "generic_smooth": line_median(
            ZoomCase(results, {"interpolation": "smooth"}), "generic"
        ),
        "bend": np.nanmax(distances(edges)["parametric"]),
        "pitch": PITCH_DEG,
        "half_view": HALF_VIEW_DEG,
    }
    for name, number in found.items():
        value(name, number)


def line_median(case, name):
    """Return a method's median distance (px) from straight lines, over runs."""
    place = f"lines.{case.method('generic')}.{name}.{case.scale}"
    return float(np.median(with_worst(case.column(place, FACADE_ZOOM))))


def edges_of(rendered):
    """Return the front's edges (edges, points, 2), as taken and as corrected, px."""
    names = ("as_taken", "parametric", "generic_as_printed")
    return {
        name: rendered.arrays(f"edges.{name}", zoom=FACADE_ZOOM)[0] for name in names
    }


def shared(edges):
    """Return which points (edges, points) both corrected images show."""
    return np.isfinite(
        edges["parametric"][..., 0] + edges["generic_as_printed"][..., 0]
    )


def from_line(edge, known):
    """Return signed distances (points,) of an edge from the line of known points."""
    centre, along = best_line(edge[known])
    return (edge - centre) @ [-along[1], along[0]]


def best_line(points):
    """Return a point and the direction of the best line (total least squares)."""
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre)[2][0]


def line_through(points, reach_px=2000.0):
    """Return two distant points (2, 2) on the best line of points."""
    centre, along = best_line(points)
    return centre + np.outer([-reach_px, reach_px], along)


def distances(edges):
    """Return distances (edges, points) in px from lines of shared points, by method."""
    both, out = shared(edges), {}
    for method in ("parametric", "generic_as_printed"):
        out[method] = np.full(both.shape, np.nan)
        for number in np.flatnonzero(np.sum(both, axis=1) >= FEWEST):
            edge = edges[method][number]
            out[method][number] = np.abs(from_line(edge, both[number]))
    return out


def most_bent(edges):
    """Return the edge that the parametric correction bends most, and a point.

    The point is halfway between where the edge leaves the boards and where it is
    farthest from its line, but at most HALF_PX / 2 from the former.
    """
    off = distances(edges)["parametric"]
    number, worst = np.unravel_index(np.nanargmax(off), off.shape)
    known = np.flatnonzero(shared(edges)[number])
    leaves = known[np.argmin(np.abs(known - worst))]
    start, end = edges["parametric"][number, [leaves, worst]]
    far = np.linalg.norm(end - start)
    return number, start + (end - start) / max(2.0, 2 * far / HALF_PX)
