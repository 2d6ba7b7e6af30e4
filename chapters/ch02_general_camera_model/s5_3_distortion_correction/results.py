"""Distances from straight lines, read from the seeds of section 2.5.2."""

import numpy as np

from chapters.shared.facade import FEWEST, HALF_VIEW_DEG, OUTER, PITCH_DEG
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.judge.statistics import with_worst
from repro.page.reader import value

HALF_PX = 110  # of the side of the enlarged parts


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    edges = edges_of(open_results("table_2_2_rendered"))
    off = distances(edges)["parametric"]
    found = {
        **{
            f"{name}{word}": line_median(ZoomCase(results, options), name)
            for word, options in (("", {}), ("_smooth", {"interpolation": "smooth"}))
            for name in ("generic", "parametric")
        },
        "bend": np.nanmax(off),
        "worst": np.nanmax(off[shared(edges)]),
        "pitch": PITCH_DEG,
        "half_view": HALF_VIEW_DEG,
        "outer": 100 * (1 - OUTER),
    }
    for name, number in found.items():
        value(name, number)


def line_median(case, name):
    """Median over seeds of a method's distance (px) from straight lines."""
    place = f"lines.{case.method('generic')}.{name}.{case.scale}"
    return float(np.median(with_worst(case.column(place, FACADE_ZOOM))))


def edges_of(rendered):
    """The front's edges (edges, points, 2) as taken and as corrected, px."""
    names = ("as_taken", "parametric", "generic_as_printed")
    return {
        name: rendered.arrays(f"edges.{name}", zoom=FACADE_ZOOM)[0] for name in names
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


def distances(edges):
    """By method, px (edges, points) from the line of what both methods show."""
    both, out = shared(edges), {}
    for method in ("parametric", "generic_as_printed"):
        out[method] = np.full(both.shape, np.nan)
        for number in np.flatnonzero(np.sum(both, axis=1) >= FEWEST):
            edge = edges[method][number]
            out[method][number] = np.abs(from_line(edge, both[number]))
    return out


def most_bent(edges):
    """Number of the edge that the parametric picture bends most, and a point.

    The point, in that picture, lies from where the edge leaves the boards halfway
    to where it is farthest from its line, or half a window on.
    """
    off = distances(edges)["parametric"]
    number, worst = np.unravel_index(np.nanargmax(off), off.shape)
    known = np.flatnonzero(shared(edges)[number])
    leaves = known[np.argmin(np.abs(known - worst))]
    start, end = edges["parametric"][number, [leaves, worst]]
    far = np.linalg.norm(end - start)
    return number, start + (end - start) / max(2.0, 2 * far / HALF_PX)
