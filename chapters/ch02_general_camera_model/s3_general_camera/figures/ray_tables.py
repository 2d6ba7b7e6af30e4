"""Fig. 2.1, drawn from look-up tables of the library."""

import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.trials.drawn_rays import (
    PIXEL_I,
    TABLE_PX,
)
from raxel.geometry import pluecker_matrix
from raxel.show import Labels, Points, Segments, Surface, framed, moved
from repro.page.space import draw_scene
from repro.page.style import FAINT, INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

DRAWN_MM = 380.0
TOLERANCE_MM = 1e-9
SIDES = {"fisheye": "central: fisheye", "faceted": "not central: four mirrors"}
BLUE, ORANGE = (series(k)["color"] for k in range(2))
SHEET = "#9aa5b1"
SIGHT = (0.5, 0.45, 0.75)
PANEL_ASPECT = 0.9


class RayTableOfCamera:
    """The look-up table of one camera, from an experiment."""

    def __init__(self, result, camera):
        for name in ("pixels", "origins", "directions", "matrices"):
            setattr(self, name, result.arrays(name, camera=camera)[0])
        facets = result.arrays("facets", camera=camera)
        self.facets = facets[0] if facets else np.empty((0, 4, 3))
        self.ends = self.origins + DRAWN_MM * self.directions
        width, _ = TABLE_PX
        self.i = PIXEL_I[1] * width + PIXEL_I[0]
        # Every second pixel is drawn, and pixel i.
        self.drawn = np.all(self.pixels % 2 == 0, axis=1)
        self.drawn &= np.isfinite(self.directions[:, 0])
        self.drawn[self.i] = False

    def gap(self):
        """Return the largest distance (mm) of a drawn point from the stored line.

        The line is that of its Plücker matrix: the matrix of two points
        drawn on it must be the same, up to scale.
        """
        rows = np.flatnonzero(self.drawn).tolist() + [self.i]
        one = np.ones((len(rows), 1))
        drawn = pluecker_matrix(
            np.column_stack([self.origins[rows], one]),
            np.column_stack([self.ends[rows], one]),
        )
        return float(np.abs(drawn / DRAWN_MM - self.matrices[rows]).max())


@figure("fig_2_1", needs=("fig_2_1_tables",), evidence="analytic", scene=True)
def fig_2_1(results):
    """Draw image, look-up table and rays of two cameras, side by side."""
    tables = {
        camera: RayTableOfCamera(results["fig_2_1_tables"], camera) for camera in SIDES
    }
    drawn, images = new_figure(1, 2, height_in=6.4)
    # Axes in space need more room than a layout engine gives them.
    drawn.set_layout_engine("none")
    for column, (camera, table) in enumerate(tables.items()):
        left = 0.5 * column
        images[column].set_position([left + 0.1, 0.81, 0.3, 0.15])
        _draw_image(images[column], table)
        images[column].set_title(SIDES[camera])
        drawn.text(
            left + 0.1,
            0.735,
            "$M_i$ =\n" + matrix_text(table.matrices[table.i]),
            family="DejaVu Sans Mono",
            fontsize=9,
            va="top",
        )
        space = drawn.add_axes([left, 0.0, 0.49, 0.59])
        # The caption says what a legend in each panel would.
        parts = moved(_rays(table), np.eye(4), unlabelled=True)
        draw_scene(space, framed(parts, SIGHT, aspect=PANEL_ASPECT))
    gap = max(table.gap() for table in tables.values())
    names = ["camera", "u_px", "v_px"]
    names += [f"{part}_{x}_mm" for part in ("anchor", "end") for x in "xyz"]
    rows = [
        (camera, *table.pixels[k], *table.origins[k], *table.ends[k])
        for camera, table in tables.items()
        for k in [*np.flatnonzero(table.drawn), table.i]
    ]
    return Drawing(
        drawn,
        columns(names, rows),
        "The general camera model. Top: an image with every second pixel "
        "marked, and the Plücker matrix in the look-up table for pixel $i$ "
        "(orange; lengths in mm). Bottom: the rays of the marked pixels from the "
        "table, with their anchor points (black). Left: the rays of a fisheye "
        "have one anchor point, the centre. Right: each ray of a camera that "
        "looks into four plane mirrors (grey) has its own.",
        Check(
            gap < TOLERANCE_MM,
            f"every drawn ray lies on the line of its Plücker matrix, to {gap:.1g} mm",
        ),
        _scene_2_1(tables),
    )


def _draw_image(axes, table):
    width, height = TABLE_PX
    axes.vlines(np.arange(width + 1) - 0.5, -0.5, height - 0.5, FAINT, lw=0.6)
    axes.hlines(np.arange(height + 1) - 0.5, -0.5, width - 0.5, FAINT, lw=0.6)
    axes.plot(*table.pixels[table.drawn].T, "o", color=BLUE, ms=2.5)
    axes.plot(*table.pixels[table.i], "s", color=ORANGE, ms=5)
    axes.annotate(
        "$i$", table.pixels[table.i], (6, -4), textcoords="offset points", color=ORANGE
    )
    axes.set(xlabel="u (px)", ylabel="v (px)", aspect="equal")
    axes.invert_yaxis()
    axes.grid(False)


def matrix_text(matrix):
    """Return a Plücker matrix as rows of text with two decimals."""
    # Adding zero turns the -0 of a rounded entry into 0.
    cells = [[f"{x:.2f}" for x in row] for row in np.round(matrix, 2) + 0.0]
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join(
        " ".join(cell.rjust(n) for cell, n in zip(row, wide, strict=True))
        for row in cells
    )


def _rays(table):
    """Return the rays of the marked pixels, their anchor points and the mirrors."""
    rows, i = table.drawn, [table.i]
    sheets = [
        Surface(np.stack([facet[[0, 1]], facet[[3, 2]]]), SHEET, 0.5, "mirror")
        for facet in table.facets
    ]
    return [
        *sheets,
        Segments(table.origins[rows], table.ends[rows], BLUE, "ray", 1.5),
        Points(table.origins[rows], INK, "anchor point", 6.0),
        Segments(table.origins[i], table.ends[i], ORANGE, "ray of pixel i", 4.0),
        Points(table.origins[i], ORANGE, size=9.0),
        Labels(table.ends[i], ["i"], ORANGE),
    ]


def _scene_2_1(tables):
    """Return both cameras next to each other; the mirror camera is moved along x."""
    fisheye, mirrors = (_rays(table) for table in tables.values())
    sideways = np.eye(4)
    sideways[0, 3] = 900.0
    return framed(
        fisheye + moved(mirrors, sideways, unlabelled=True),
        SIGHT,
        note="Left: a fisheye, whose rays all start in one point. Right: a camera "
        "in front of four mirrors, with one anchor point for each ray.",
    )
