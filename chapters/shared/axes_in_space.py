"""Axes in space: camera coordinates drawn with y downwards."""

from __future__ import annotations

import numpy as np


def in_axes(points):
    """Camera coordinates (..., 3) in the order of drawing: x, z, y."""
    return np.moveaxis(np.asarray(points, float), -1, 0)[[0, 2, 1]]


def name_axes(axes, view):
    """Labels, y downwards, equal scales, and the view (elev, azim)."""
    axes.set(xlabel="x (mm)", ylabel="z (mm)", zlabel="y (mm)")
    axes.invert_zaxis()
    spans = [np.ptp(span) for span in _limits(axes)]
    axes.set_box_aspect(spans, zoom=0.98)
    axes.patch.set_alpha(0.0)
    axes.view_init(*view)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(_few())
        axis.label.set_size(8)
        axis.labelpad = -2
    axes.tick_params(labelsize=7, pad=-1)


def _limits(axes):
    return axes.get_xlim(), axes.get_ylim(), axes.get_zlim()


def line(axes, points, colour, width, style="-"):
    """A plain line through points (n, 3)."""
    axes.plot(*in_axes(points), color=colour, lw=width, ls=style, marker="")


def dots(axes, points, colour, size, marker="o"):
    """Dots at points (n, 3)."""
    axes.plot(*in_axes(points), color=colour, ls="", marker=marker, ms=size)


def _few():
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)
