"""Fig. 2.2, drawn from calibrated rays, and their error for a wrong T_1."""

import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.trials.known_motion import (
    LEVELS,
)
from chapters.shared.general_cameras import KINDS
from raxel.geometry import inverse_pose, transform
from raxel.show import Arrows, Labels, Points, Segments, Surface, framed, moved
from repro.judge.statistics import median_interval
from repro.page.space import draw_scene
from repro.page.style import INK, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

TOLERANCE_MM = 1e-9
FOUND_MM = 1e-6
GRIDS = tuple(series(k)["color"] for k in range(3))
NAMES = ("base grid", "grid 2", "grid 3")
SHEET = "#9aa5b1"
SIGHT = (0.55, 0.4, 0.7)
PANEL_ASPECT = 1.0


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
        offset = self.meetings - self.origins
        across = np.cross(offset, self.directions)
        off_ray = np.linalg.norm(across, axis=2).max()
        height = transform(inverse_pose(self.poses), self.meetings)[..., 2]
        off_outline = transform(inverse_pose(self.poses), self.outlines)
        return float(
            max(off_ray, np.abs(height).max(), np.abs(off_outline[..., 2]).max())
        )


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
        # The caption says what a legend in each panel would.
        parts = moved(_grids(grids), np.eye(4), unlabelled=True)
        draw_scene(panel, framed(parts, SIGHT, aspect=PANEL_ASPECT))
        panel.set_title(title)
    gap = max(grids.gap() for grids in found.values())
    off = results["fig_2_2_grids"].column("pose_error_mm", method="generic")
    off = float(off.max())
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
            gap < TOLERANCE_MM and off < FOUND_MM,
            "every drawn point lies on its ray and on its grid, to "
            f"{gap:.1g} mm; the poses of (b) are the true ones, to "
            f"{off:.1g} mm",
        ),
        _scene_2_2(found),
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


def _scene_2_2(found):
    """Return both configurations next to each other."""
    general, generic = (_grids(grids) for grids in found.values())
    sideways = np.eye(4)
    sideways[0, 3] = 1800.0
    return framed(
        general + moved(generic, sideways, unlabelled=True),
        SIGHT,
        note="Left: the general method, two grids in known poses. Right: the "
        "generic method, three grids with estimated poses.",
    )


@figure("ext_fig_2_2_error", needs=("fig_2_2_error",), evidence="synthetic")
def ext_fig_2_2_error(results):
    """Draw the ray error of the two-pose method for an error of T_1."""
    ran = results["fig_2_2_error"]
    drawn, axes = new_figure(1, 2, height_in=3.2)
    rows = []
    for panel, (kind, unit) in zip(axes, KINDS.items(), strict=True):
        levels = (0.0, *LEVELS)
        found = [
            median_interval(ran.column(f"ray_deg.{level:g}", kind=kind))
            for level in levels
        ]
        drawn_rows = plot_estimates(
            panel, levels, found, look=series(0), label="median"
        )
        rows += [(kind, *row) for row in drawn_rows]
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
