"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.experiment import (
    LEVELS,
    PIXEL_I,
    TABLE_PX,
)
from chapters.shared.general import KINDS
from raxel.geometry import inverse_pose, pluecker_matrix, transform
from raxel.show import Arrows, Labels, Points, Segments, Surface, framed, moved
from repro.page import FAINT, INK, new_figure, plot_estimates, series, value
from repro.page.space import draw_scene
from repro.run import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Check,
    Drawing,
    Reading,
    claim,
    columns,
    figure,
    median_interval,
    weighted_line,
)

# Effect of an error of T_1 on the rays, from the results of section 2.3.

LEVEL_NAMES = tuple(f"{level:g}" for level in LEVELS)


def line_fits(result, kind):
    """Return R2 of a straight line through the errors of each trial, (trials,)."""
    errors = result.column("ray_deg", LEVEL_NAMES, kind=kind).T
    weights = np.ones(len(LEVELS))
    return np.array([weighted_line(LEVELS, error, weights).r2 for error in errors])


def slope(result, kind):
    """Return the median ray error per unit of error of T_1 (deg per mm or deg)."""
    found = result.column("ray_deg", LEVEL_NAMES[0], kind=kind)
    return float(np.median(found)) / LEVELS[0]


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    wrong = open_results("fig_2_2_error")
    any_camera = open_results("exp_c2_nonparam_any")
    value("per_mm", np.median(wrong.column("ray_deg", 1, kind="translation")))
    value("per_deg", np.median(wrong.column("ray_deg", 1, kind="rotation")))
    value("jump_deg", any_camera.column("jump_deg", camera="faceted").max())


# Fig. 2.2, drawn from calibrated rays, and their error for a wrong T_1.


TOLERANCE_MM = 1e-9
FOUND_MM = 1e-6
GRIDS = tuple(series(k)["color"] for k in range(3))
NAMES = ("base grid", "grid 2", "grid 3")
SHEET = "#9aa5b1"
SIGHT = (0.55, 0.4, 0.7)


class Grids:
    """Rays and the grids they meet, from one calibration."""

    def __init__(self, result, method):
        for name in (
            "poses", "centre", "origins", "directions", "meetings",
            "outlines",
        ):  # fmt: skip
            setattr(self, name, result.arrays(name, method=method)[0])

    def gap(self):
        """Return the largest distance (mm) of a drawn point from its ray or grid."""
        across = np.cross(self.meetings - self.origins, self.directions)
        off_ray = np.linalg.norm(across, axis=2).max()
        heights = (
            np.abs(transform(inverse_pose(self.poses), points)[..., 2]).max()
            for points in (self.meetings, self.outlines)
        )
        return float(max(off_ray, *heights))


@figure("fig_2_2", needs=("fig_2_2_grids",), evidence="analytic", scene=True)
def fig_2_2(results):
    """Draw (a) two grids with known T_1, (b) three grids in unknown poses."""
    found = {
        method: Grids(results["fig_2_2_grids"], method)
        for method in ("general", "generic")
    }
    drawn, axes = new_figure(1, 2, height_in=4.0)
    drawn.set_layout_engine("none")
    for panel, left in zip(axes, (0.0, 0.5), strict=True):
        panel.set_position([left, 0.0, 0.5, 0.93])
    titles = ("(a) general: $T_1$ known", "(b) generic: $T_1$, $T_2$ unknown")
    for panel, title, grids in zip(axes, titles, found.values(), strict=True):
        # The caption replaces a legend in each panel.
        parts = moved(_grids(grids), np.eye(4), unlabelled=True)
        draw_scene(panel, framed(parts, SIGHT, aspect=1.0))
        panel.set_title(title)
    gap = max(grids.gap() for grids in found.values())
    off = results["fig_2_2_grids"].column("pose_error_mm", method="generic").max()
    rows = [
        (method, number, *point)
        for method, grids in found.items()
        for number, points in enumerate(grids.meetings, 1)
        for point in points
    ]
    return Drawing(
        drawn,
        columns(("method", "grid", "x_mm", "y_mm", "z_mm"), rows),
        "Calibration configurations in the frame of the first grid, drawn "
        "from rays that the library calibrated: (a) the general method, "
        "two grids with known relative pose $T_1$; (b) the generic method, "
        "three grids with estimated poses $T_1$ and $T_2$. Coloured dots: "
        "intersections of calibrated rays with the grids. Black dot: the "
        "camera's centre. Arrows: from the origin of the base grid to that "
        "of each other grid.",
        Check(
            bool(gap < TOLERANCE_MM and off < FOUND_MM),
            "every drawn point lies on its ray and on its grid, to "
            f"{gap:.1g} mm; the poses of (b) are the true ones, to "
            f"{off:.1g} mm",
        ),
        side_by_side(
            *map(_grids, found.values()),
            1800.0,
            SIGHT,
            "Left: the general method, two grids in known poses. Right: the generic "
            "method, three grids with estimated poses.",
        ),
    )


def _grids(grids):
    """Return the grids in their estimated poses, and rays from the centre."""
    last = grids.meetings[-1]
    centre = np.broadcast_to(grids.centre, last.shape)
    base, others = grids.poses[0, :3, 3], grids.poses[1:, :3, 3]
    parts = [
        Segments(centre, last, SHEET, "ray", 1.2),
        Points(grids.centre[None], INK, "camera centre", 10.0),
        Labels(grids.centre[None], ["centre"], INK),
        Arrows(np.broadcast_to(base, others.shape), others, INK, "T", 2.5),
    ]
    for number, (outline, points) in enumerate(
        zip(grids.outlines, grids.meetings, strict=True)
    ):
        colour = GRIDS[number]
        sheet = np.stack([outline[[0, 1]], outline[[3, 2]]])
        parts += [
            Surface(sheet, colour, 0.35, NAMES[number]),
            Points(points, colour, size=5.0),
            Labels(outline[1:2], [NAMES[number]], colour),
        ]
    return parts


def side_by_side(first, second, shift_mm, sight, note):
    """Return the scene of two groups of parts, the second one moved along x."""
    sideways = np.eye(4)
    sideways[0, 3] = shift_mm
    return framed(first + moved(second, sideways, unlabelled=True), sight, note=note)


@figure("ext_fig_2_2_error", needs=("fig_2_2_error",), evidence="synthetic")
def ext_fig_2_2_error(results):
    """Draw the ray error of the two-pose method for an error of T_1."""
    ran = results["fig_2_2_error"]
    drawn, axes = new_figure(1, 2, height_in=3.2)
    rows = []
    for panel, (kind, unit) in zip(axes, KINDS.items(), strict=True):
        found = ran.column("ray_deg", ("0", *LEVEL_NAMES), kind=kind)
        estimates = plot_estimates(
            panel, (0.0, *LEVELS), [*map(median_interval, found)],
            look=series(0), label="median",
        )  # fmt: skip
        rows += [(kind, *row) for row in estimates]
        panel.set(
            xlabel=f"Error of the {kind} in T₁ ({unit})",
            ylabel="Median ray error (deg)",
        )
    return Drawing(
        drawn,
        columns(("kind", "level", "median", "low", "high"), rows),
        "Ray error of the two-pose method as a function of an error of the "
        "known motion, with all else exact. Left: translation, right: "
        "rotation of the second grid. Medians over trials with 95 % intervals.",
    )


# Fig. 2.1, drawn from look-up tables of the library.


DRAWN_MM = 380.0
SIDES = {"fisheye": "central: fisheye", "faceted": "not central: four mirrors"}
BLUE, ORANGE = (series(k)["color"] for k in range(2))
TABLES_SIGHT = (0.5, 0.45, 0.75)


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
        # The caption replaces a legend in each panel.
        parts = moved(_rays(table), np.eye(4), unlabelled=True)
        draw_scene(space, framed(parts, TABLES_SIGHT, aspect=0.9))
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
        side_by_side(
            *map(_rays, tables.values()),
            900.0,
            TABLES_SIGHT,
            "Left: a fisheye, whose rays all start in one point. Right: a camera in "
            "front of four mirrors, with one anchor point for each ray.",
        ),
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


# The claims of section 2.3, tested as the registry words them.


ROUNDING = 1e-12
RAY_ERROR = 1e-9
MIN_R2 = 0.98


@claim(
    "c2_pluecker_invariant", needs=("exp_c2_pluecker_invariant",), evidence="analytic"
)
def judge_pluecker_invariant(results):
    """Relative difference below 1e-12 over pairs of points of a line."""
    ran = results["exp_c2_pluecker_invariant"]
    difference, asymmetry = ran.column(("difference", "asymmetry")).max(axis=1)
    return Reading.of(
        difference < ROUNDING and asymmetry < ROUNDING,
        float(difference),
        reason="largest difference of an entry, matrices at unit norm; "
        "a matrix plus its transpose, which is 0 if it is "
        f"antisymmetric, is at most {asymmetry:.1g}",
    )


@claim("c2_pluecker_origin", needs=("exp_c2_pluecker_origin",), evidence="analytic")
def judge_pluecker_origin(results):
    """Norm ratio below 1e-12 through the origin, above 0 otherwise."""
    ran = results["exp_c2_pluecker_origin"]
    through = ran.column("through_origin").max()
    others = ran.column("beside_origin").min()
    nearest = ran.column("least_distance_m").min()
    return Reading.of(
        through < ROUNDING < others,
        float(through),
        reason="norm of the last three entries over that of the "
        f"vector, lengths in m; at least {others:.2g} for lines that pass "
        f"the origin at {1e3 * nearest:.2g} mm or more",
    )


@claim("c2_nonparam_any", needs=("exp_c2_nonparam_any",), evidence="analytic")
def judge_nonparametric(results):
    """Faceted mirror, two known grid poses: ray error below 1e-9."""
    faceted = results["exp_c2_nonparam_any"].one(camera="faceted")
    angle, gap, jump = faceted.column(("angle_rad", "gap_mm", "jump_deg")).max(axis=1)
    share = faceted.column("share").min()
    return Reading.of(
        angle < RAY_ERROR and gap < RAY_ERROR and share == 1,
        float(angle),
        unit="rad",
        reason=f"largest angle; the lines pass the mirror points at "
        f"{gap:.1g} mm; {100 * share:.0f} % of the rays, neighbours up "
        f"to {jump:.0f} deg apart",
    )


@claim("c2_two_pose_needs_T", needs=("fig_2_2_error",), evidence="synthetic")
def judge_two_pose_needs_motion(results):
    """The ray error grows linearly with the error of T_1, R2 >= 0.98.

    The line is fitted in each trial, in which the error of T_1 keeps its
    direction.
    """
    ran = results["fig_2_2_error"]
    fits = {kind: line_fits(ran, kind) for kind in KINDS}
    rising = all(slope(ran, kind) > 0 for kind in KINDS)
    worst = {kind: float(r2.min()) for kind, r2 in fits.items()}
    middle = median_interval(np.minimum(*fits.values()))
    decision = UNDECIDED
    if rising and min(worst.values()) >= MIN_R2:
        decision = HOLDS
    elif not rising or middle.high < MIN_R2:
        decision = FAILS
    return Reading.of(
        decision,
        middle,
        reason="R² of the straight line of a trial; lowest of all "
        "trials: " + ", ".join(f"{r2:.6f} ({kind})" for kind, r2 in worst.items()),
    )
