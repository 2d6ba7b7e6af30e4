"""Figs 2.1 and 2.2, drawn from rays that the library computed."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.drawn_rays import PIXEL_I, TABLE_PX
from chapters.ch02_general_camera_model.general_cameras import KINDS, LEVELS
from raxel.geometry import inverse_pose, pluecker_matrix, transform
from repro.experiment import figure
from repro.outcomes import Check, Drawing
from repro.results import summary
from repro.scene import Points, Scene, Segments, Surface
from repro.style import FAINT, INK, plot_interval, series
from repro.style import figure as new_figure

PAGE = "s3_general_camera"

DRAWN_MM = 380.0
TOLERANCE_MM = 1e-9
SIDES = {
    "fisheye": "central: fisheye",
    "faceted": "not central: four mirrors",
}
BLUE, ORANGE, GREEN = (series(k)["color"] for k in range(3))
GRIDS = (BLUE, ORANGE, GREEN)
SHEET = "#9aa5b1"


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


class Table:
    """The look-up table of one camera, as an experiment left it."""

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
        """Largest distance (mm) of a drawn point from the stored line.

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


@figure(
    "fig_2_1", needs=("fig_2_1_tables",), evidence="analytic", scene=True
)
def fig_2_1(results):
    """Image, look-up table and rays of two cameras, side by side."""
    tables = {
        camera: Table(results["fig_2_1_tables"], camera) for camera in SIDES
    }
    drawn, images = new_figure(1, 2, height_in=6.0)
    # Axes in space need more room than a layout engine gives them.
    drawn.set_layout_engine("none")
    for column, (camera, table) in enumerate(tables.items()):
        left = 0.5 * column
        images[column].set_position([left + 0.05, 0.74, 0.2, 0.2])
        _draw_image(images[column], table)
        images[column].set_title(SIDES[camera])
        space = drawn.add_axes(
            [left - 0.03, -0.02, 0.52, 0.72],
            projection="3d",
            zorder=2 - column,
        )
        _draw_rays(space, table)
    gap = max(table.gap() for table in tables.values())
    data = {"camera": [], "u_px": [], "v_px": []}
    data |= {
        f"{part}_{x}_mm": [] for part in ("anchor", "end") for x in "xyz"
    }
    for camera, table in tables.items():
        for row in [*np.flatnonzero(table.drawn), table.i]:
            cells = (
                *table.pixels[row],
                *table.origins[row],
                *table.ends[row],
            )
            for name, cell in zip(data, (camera, *cells), strict=True):
                data[name].append(cell)
    return Drawing(
        drawn,
        data,
        "The general camera model. Top: an image, every second pixel "
        "marked, and the Plücker matrix that the look-up table holds for pixel "
        "$i$ (orange; lengths in mm). Bottom: the rays of the marked pixels, "
        "from the camera's table, with their anchor points. Left, the rays "
        "of a fisheye have one anchor point, the centre; right, each ray of a "
        "camera that looks into four plane mirrors has its own.",
        Check(
            gap < TOLERANCE_MM,
            "every drawn ray lies on the line of its Plücker matrix, to "
            f"{gap:.1g} mm",
        ),
        _scene_2_1(tables),
    )


def _draw_image(axes, table):
    width, height = TABLE_PX
    axes.vlines(
        np.arange(width + 1) - 0.5, -0.5, height - 0.5, FAINT, lw=0.6
    )
    axes.hlines(
        np.arange(height + 1) - 0.5, -0.5, width - 0.5, FAINT, lw=0.6
    )
    axes.plot(*table.pixels[table.drawn].T, "o", color=BLUE, ms=2.5)
    axes.plot(*table.pixels[table.i], "s", color=ORANGE, ms=5)
    axes.annotate(
        "$i$",
        table.pixels[table.i],
        (4, 3),
        textcoords="offset points",
        color=ORANGE,
    )
    axes.set(xlabel="u (px)", ylabel="v (px)", aspect="equal")
    axes.invert_yaxis()
    axes.grid(False)
    axes.text(
        1.03,
        0.5,
        "$M_i$ =\n" + matrix_text(table.matrices[table.i]),
        transform=axes.transAxes,
        family="DejaVu Sans Mono",
        fontsize=6.5,
        va="center",
    )


def matrix_text(matrix):
    """A Plücker matrix in rows, two digits after the point."""
    # Adding zero turns the -0 of a rounded entry into 0.
    rows = np.round(matrix, 2) + 0.0
    cells = [[f"{x:.2f}" for x in row] for row in rows]
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join(
        " ".join(cell.rjust(n) for cell, n in zip(row, wide, strict=True))
        for row in cells
    )


def _draw_rays(axes, table):
    for facet in table.facets:
        line(axes, np.vstack([facet, facet[:1]]), SHEET, 1.0)
    for row in np.flatnonzero(table.drawn):
        ray = np.stack([table.origins[row], table.ends[row]])
        line(axes, ray, BLUE, 0.7)
    dots(axes, table.origins[table.drawn], INK, 2.0)
    ray = np.stack([table.origins[table.i], table.ends[table.i]])
    line(axes, ray, ORANGE, 2.0)
    dots(axes, ray[:1], ORANGE, 4, "s")
    name_axes(axes, (20, -60))


def _scene_2_1(tables):
    """Both cameras beside each other: the mirrors' is moved along x."""
    parts = []
    for place, table in enumerate(tables.values()):
        shift = np.array([900.0 * place, 0.0, 0.0])
        own, rows = "" if place else "ray", table.drawn
        for facet in table.facets:
            sheet = np.stack([facet[[0, 1]], facet[[3, 2]]]) + shift
            parts.append(Surface(sheet, SHEET, 0.5))
        parts += [
            Segments(
                table.origins[rows] + shift,
                table.ends[rows] + shift,
                BLUE,
                own,
            ),
            Points(
                table.origins[rows] + shift,
                INK,
                "" if place else "anchor point",
            ),
            Segments(
                table.origins[[table.i]] + shift,
                table.ends[[table.i]] + shift,
                ORANGE,
                "" if place else "pixel i",
                4.0,
            ),
        ]
    return Scene(
        parts,
        (450.0, -700.0, -1600.0),
        (450.0, 0.0, 100.0),
        note="Left a fisheye: all rays leave one point. Right a camera "
        "before four mirrors: every ray has an anchor point of its own.",
    )


# Fig. 2.2


class Grids:
    """Rays that meet grids, as one calibration found them."""

    def __init__(self, result, method):
        for name in (
            "poses", "centre", "origins", "directions", "meetings",
            "outlines",
        ):  # fmt: skip
            setattr(self, name, result.arrays(name, method=method)[0])

    def gap(self):
        """Largest distance (mm) of a drawn point from its ray or grid."""
        offset = self.meetings - self.origins
        across = np.cross(offset, self.directions)
        off_ray = np.linalg.norm(across, axis=2).max()
        height = transform(inverse_pose(self.poses), self.meetings)[..., 2]
        off_outline = transform(inverse_pose(self.poses), self.outlines)
        return float(
            max(
                off_ray,
                np.abs(height).max(),
                np.abs(off_outline[..., 2]).max(),
            )
        )


@figure(
    "fig_2_2", needs=("fig_2_2_grids",), evidence="analytic", scene=True
)
def fig_2_2(results):
    """(a) two grids a known T_1 apart; (b) three in unknown poses."""
    found = {
        method: Grids(results["fig_2_2_grids"], method)
        for method in ("general", "generic")
    }
    drawn, axes = new_figure(
        1, 2, height_in=4.0, subplot_kw={"projection": "3d"}
    )
    drawn.set_layout_engine("none")
    for panel, left in zip(axes, (-0.04, 0.46), strict=True):
        panel.set_position([left, -0.02, 0.54, 0.95])
        # The label of the left z axis reaches into the right panel.
        panel.set_zorder(1 - left)
    titles = (
        "(a) general: $T_1$ known",
        "(b) generic: $T_1$, $T_2$ unknown",
    )
    for panel, title, grids in zip(
        axes, titles, found.values(), strict=True
    ):
        _draw_grids(panel, grids)
        panel.set_title(title)
    gap = max(grids.gap() for grids in found.values())
    data = {"method": [], "grid": [], "x_mm": [], "y_mm": [], "z_mm": []}
    for method, grids in found.items():
        for number, points in enumerate(grids.meetings, 1):
            for point in points:
                cells = (method, number, *point)
                for name, cell in zip(data, cells, strict=True):
                    data[name].append(cell)
    return Drawing(
        drawn,
        data,
        "Calibration configurations, drawn in the frame of the first grid "
        "from rays that the library calibrated: (a) the general method, "
        "two grids a known $T_1$ apart; (b) the generic method, three "
        "grids whose poses $T_1$ and $T_2$ were found in the calibration. "
        "Dots: where calibrated rays meet the grids.",
        Check(
            gap < TOLERANCE_MM,
            "every drawn point lies on its ray and on its grid, to "
            f"{gap:.1g} mm",
        ),
        _scene_2_2(found),
    )


def _draw_grids(axes, grids):
    for last in grids.meetings[-1]:
        line(axes, np.stack([grids.centre, last]), SHEET, 0.6)
    dots(axes, grids.centre[None], INK, 4)
    for number, (outline, points, T) in enumerate(
        zip(grids.outlines, grids.meetings, grids.poses, strict=True)
    ):
        colour = GRIDS[number]
        line(axes, np.vstack([outline, outline[:1]]), colour, 1.3)
        dots(axes, points, colour, 2.5)
        where = {"color": colour, "fontsize": 9}
        if number:
            axes.text(*in_axes(outline[1]), f"$T_{number}$", **where)
        else:
            where |= {"ha": "right", "va": "top"}
            axes.text(*in_axes(outline[3]), "base grid", **where)
        ends = np.stack([grids.poses[0, :3, 3], T[:3, 3]])
        line(axes, ends, INK, 1.0, ":")
    name_axes(axes, (18, -50))


def _scene_2_2(found):
    parts = []
    for place, grids in enumerate(found.values()):
        shift = np.array([1800.0 * place, 0.0, 0.0])
        for number, (outline, points) in enumerate(
            zip(grids.outlines, grids.meetings, strict=True)
        ):
            label = "base grid" if number == 0 else f"grid {number + 1}"
            known = place == 0 and number < 2
            named = known or (place == 1 and number == 2)
            sheet = np.stack([outline[[0, 1]], outline[[3, 2]]]) + shift
            parts.append(
                Surface(sheet, GRIDS[number], 0.35, label if named else "")
            )
            parts.append(Points(points + shift, GRIDS[number], size=6.0))
        last = grids.meetings[-1] + shift
        centre = np.broadcast_to(grids.centre + shift, last.shape)
        parts.append(
            Segments(centre, last, SHEET, "" if place else "ray", 1.0)
        )
        parts.append(
            Points(centre[:1], INK, "" if place else "camera centre", 12.0)
        )
        ends = grids.poses[1:, :3, 3] + shift
        starts = np.broadcast_to(shift, ends.shape)
        parts.append(Segments(starts, ends, INK, "" if place else "T", 3.0))
    return Scene(
        parts,
        (-800.0, -1500.0, -2200.0),
        (900.0, 0.0, 100.0),
        note="Left the general method, two grids in known poses. Right the "
        "generic method, three grids whose poses it found.",
    )


@figure("ext_fig_2_2_error", needs=("fig_2_2_error",), evidence="synthetic")
def ext_fig_2_2_error(results):
    """What an error of T_1 does to the rays of the two-pose method."""
    ran = results["fig_2_2_error"]
    drawn, axes = new_figure(1, 2, height_in=3.2)
    data = {n: [] for n in ("kind", "level", "median", "low", "high")}
    for panel, (kind, unit) in zip(axes, KINDS.items(), strict=True):
        levels = (0.0, *LEVELS)
        found = [
            summary(ran.column(f"ray_deg.{level:g}", kind=kind))
            for level in levels
        ]
        rows = np.array(
            [[f["median"], *f["median_interval"]] for f in found]
        )
        plot_interval(
            panel, np.array(levels), *rows.T, index=0, label="median"
        )
        panel.set_xlabel(f"Error of {kind} put on T₁ ({unit})")
        for level, row in zip(levels, rows, strict=True):
            for name, cell in zip(data, (kind, level, *row), strict=True):
                data[name].append(cell)
        panel.set_ylabel("Median ray error (deg)")
    return Drawing(
        drawn,
        data,
        "Error of the rays of the two-pose method against an error put on "
        "the known motion, with nothing else wrong: left a shift, right "
        "a turn of the second grid. Medians over trials with 95 % intervals.",
    )
