"""What is kept of a run for the pictures: a trace, and one window of it."""

import cv2
import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import NO_EDGE
from raxel.features.celect.algorithm import snapped
from raxel.features.celect.hough import peaks_of, vote
from raxel.features.celect.trace import Step
from raxel.features.celect.window import canny_edges, open_window

COARSE = 3
"""Pixels of the picture per pixel of the overview."""

GREYS = 16
"""Grey levels per step of the overview: it is for the eye, and files stay small."""

WINDOW = (
    "cut",
    "cut_at",
    "centre",
    "radius",
    "edges",
    "lines",
    "chosen",
    "next",
    "trace",
    "candidates",
    "merged",
)
OVERVIEW = ("overview", "outer", "anchors", "contour_of", "lost_contour")

REACH = 1.6
"""Half side of the cut-out around a window, in radii of the window."""


def overview(image, run, lost):
    """Arrays of one run: small picture, anchors of all contours, lost contour."""
    small = cv2.resize(
        image, None, fx=1 / COARSE, fy=1 / COARSE, interpolation=cv2.INTER_AREA
    )
    anchors = [c.anchors for c in run.contours]
    names = [c.name for c in run.contours]
    lost_one = names.index(lost.contour) if lost.contour in names else -1
    return {
        "overview": small // GREYS * GREYS + GREYS // 2,
        "outer": run.outer_corners,
        "anchors": np.vstack([np.empty((0, 2)), *anchors]),
        "contour_of": np.repeat(np.arange(len(anchors)), [len(a) for a in anchors]),
        "lost_contour": np.array(lost_one),
    }


def no_window():
    """The arrays of a window where there is none to be shown."""
    return {part: np.empty((0, 2)) for part in WINDOW}


def window_at(image, run, where, lost, settings):
    """Arrays of the window that decided what became of a place `where` (2,), if any.

    Of the lost contour, if there is one: the step that led there, or the window in
    which there was no edge. Otherwise the step with its centre nearest to the place.
    """
    if where is None:
        return no_window()
    own = [c for c in run.contours if c.name == lost.contour]
    if own and lost.stage == NO_EDGE:
        return _shown(image, own[0], _stuck(image, run, own[0], settings))
    steps = [
        (contour, step) for contour in own or run.contours for step in contour.steps
    ]
    if not steps:
        return no_window()
    led_to = [np.linalg.norm(step.anchor - where) for _, step in steps]
    around = [np.linalg.norm(step.centre - where) for _, step in steps]
    arrived = own and min(led_to) == 0
    contour, step = steps[int(np.argmin(led_to if arrived else around))]
    return _shown(image, contour, step)


def _stuck(image, run, contour, settings):
    """The Step of the last window of a trace, which led nowhere."""
    scale, _ = snapped(image, run.outer_corners, run.columns, run.rows, settings)
    centre, radius = contour.anchors[-1], float(contour.radii[-1])
    window = open_window(image, centre, radius, scale.smoothing)
    edges = canny_edges(window, scale, settings.canny_high, settings.canny_low)
    space = vote(edges, centre, radius)
    lines = peaks_of(space, settings, contour.s).lines
    corners = settings.detect_corners(window, scale, settings)
    nowhere = np.full(2, np.nan)
    return Step(centre, radius, edges, space, lines, -1, corners, nowhere)


def _shown(image, contour, step):
    """Arrays of a window and of the contour that it belongs to."""
    reach = int(np.ceil(REACH * step.radius))
    u, v = np.rint(step.centre).astype(int)
    left, top = max(u - reach, 0), max(v - reach, 0)
    cut = image[top : v + reach + 1, left : u + reach + 1]
    return {
        "cut": cut,
        "cut_at": np.array([left, top]),
        "centre": step.centre,
        "radius": np.array(step.radius),
        "edges": step.edges,
        "lines": step.lines,
        "chosen": np.array(step.chosen),
        "next": step.anchor,
        "trace": contour.anchors,
        "candidates": contour.candidates,
        "merged": contour.merged,
    }
