"""The scene of the linear stage, drawn: what is known, and what is sought."""

import numpy as np

from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

NAMES = ("base grid", "grid 2", "grid 3")
TOLERANCE_MM = 1e-6


@figure("ext_linear_scene", needs=("ext_worked_row_scene",), evidence="synthetic")
def linear_scene(results):
    """Three grids, one centre and one ray, seen from the side."""
    result = results["ext_worked_row_scene"]
    centre, met, traces = (
        result.arrays(name)[0] for name in ("centre", "met", "traces")
    )
    drawn, axes = new_figure(height_in=3.8)
    for number, ends in enumerate(_in_plane(traces, met, centre)):
        colour = series(number)["color"]
        axes.plot(*ends.T, color=colour, lw=2.4, ls="-", marker="")
        axes.annotate(
            NAMES[number], ends[np.argmin(ends[:, 0])], (-6, 0), color=colour,
            textcoords="offset points", ha="right", va="center",
        )  # fmt: skip
    farthest = met[np.argmax(np.linalg.norm(met - centre, axis=1))]
    end = centre + 1.15 * (farthest - centre)
    ray = _in_plane(np.array([centre, end]), met, centre)
    axes.plot(*ray.T, color=INK, lw=1.2, ls="-", marker="")
    for number, place in enumerate(_in_plane(met, met, centre)):
        axes.plot(*place, "o", color=series(number)["color"])
        axes.annotate(
            f"$\\mathbf{{Q}}^{number + 1}$", place, (8, 5),
            textcoords="offset points", va="bottom",
        )  # fmt: skip
    axes.plot(*ray[0], "o", color=INK)
    axes.annotate(
        "centre $\\mathbf{C}$", ray[0], (9, 0),
        textcoords="offset points", va="center",
    )  # fmt: skip
    axes.set(xlabel="along the x axis of the base grid (mm)", ylabel="across (mm)")
    axes.set_aspect("equal", adjustable="datalim")
    rows = [("C", *centre)]
    rows += [(f"Q{n}", *point) for n, point in enumerate(met, 1)]
    gap = _off_line(centre, met)
    return Drawing(
        drawn,
        columns(("point", "x_mm", "y_mm", "z_mm"), rows),
        "One pixel's ray and the three grids of a scene, cut by a plane "
        "through the ray, so that each grid is a line. The ray runs from "
        "the centre $\\mathbf{C}$ and meets the grids in $\\mathbf{Q}^1$, "
        "$\\mathbf{Q}^2$, $\\mathbf{Q}^3$. Known are only the coordinates "
        "of each point on its own grid, for many pixels. Sought are the "
        "centre and the poses of grids 2 and 3.",
        Check(
            gap < TOLERANCE_MM,
            f"the three points and the centre lie on one line, to {gap:.1g} mm",
        ),
    )


def _in_plane(points, met, centre):
    """Coordinates (..., 2) in the plane through the ray and the base x axis."""
    upright = met[0] - centre
    upright = upright * [0.0, 1.0, 1.0] / np.linalg.norm(upright[1:])
    return np.stack([points[..., 0], (points - met[0]) @ upright], axis=-1)


def _off_line(centre, met):
    """Largest distance (mm) of the points from the line to the first one."""
    way = met[0] - centre
    way = way / np.linalg.norm(way)
    return float(np.linalg.norm(np.cross(met - centre, way), axis=1).max())
