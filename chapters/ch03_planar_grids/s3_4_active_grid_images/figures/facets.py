"""Fig. 3.18: the chessboard in the mirror ball, put together, and the ball in space."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import FACETS
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import rig_of
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.facets import MM_PER_PX
from raxel.geometry import on_plane, transform
from raxel.geometry.planes import intersect_rays_plane
from raxel.show.boards import board, polygon
from raxel.show.cameras import axes as axes_parts
from raxel.show.cameras import frustum, mirrors
from raxel.show.rigs import drawn_poses
from raxel.show.scene import Labels, Segments
from raxel.show.view import INK, framed
from repro.page.space import draw_scene
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

GREYS = (0.45, 0.75)  # of the true grid
ORANGE = "#d55e00"
HEIGHT_IN = 4.4
HEAD = ("facet", "x_mm", "y_mm")


@figure("fig_3_18", needs=("fig_3_18_facets",), evidence="rendered")
def fig_3_18(results):
    """The picture, and what the active grid makes of it over the true grid."""
    ran = results[FACETS].select()
    picture, laid, seen, metric, off = (
        ran.arrays(name)[0]
        for name in ("picture", "laid", "seen", "metric", "corner_squares")
    )
    drawn, axes = new_figure(1, 2, height_in=3.9, width_ratios=(0.9, 1.3))
    axes[0].imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    shown = np.where(seen, laid / 255.0, true_grid(laid.shape, metric))
    axes[1].imshow(shown, cmap="gray", vmin=0, vmax=1, interpolation="antialiased")
    known = np.isfinite(off)
    axes[1].plot(
        *(metric[known] / MM_PER_PX - 0.5).T,
        "o",
        ms=4,
        mfc="none",
        color=ORANGE,
        mew=0.8,
    )
    for panel, title in zip(axes, ("(a) in the ball", "(b) remapped"), strict=True):
        panel.set_axis_off()
        panel.set_title(title)
    rows = [(*place, error) for place, error in zip(metric, off, strict=True)]
    places = np.rint(metric / MM_PER_PX - 0.5).astype(int)
    return Drawing(
        drawn,
        columns(("x_mm", "y_mm", "off_squares"), rows),
        "A chessboard in a ball of flat mirrors; and the same picture laid out by an "
        "active grid, black and white, over the true grid, grey. Circles: the corners "
        "that could be localised.",
        Check(
            bool(known.any() and seen[tuple(places[known].T[::-1])].all()),
            "every circle is where the remapped picture was decoded",
        ),
    )


def true_grid(shape, metric):
    """The chessboard in greys, (h, w), white beyond its squares."""
    square = np.linalg.norm(metric[1] - metric[0])
    side = int(np.sqrt(len(metric)))
    v, u = np.mgrid[: shape[0], : shape[1]]
    x, y = (
        (MM_PER_PX * (p + 0.5) - c) / square
        for p, c in zip((u, v), metric[0], strict=True)
    )
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    black = (column + row) % 2 != 0
    inside = (np.minimum(column, row) >= -1) & (np.maximum(column, row) <= side - 1)
    return np.where(black & inside, *GREYS)


@figure(
    "ext_fig_3_18_facets", needs=("fig_3_18_facets",), evidence="analytic", scene=True
)
def ext_fig_3_18_facets(results):
    """The ball, its monitor, and the piece of it that each facet shows."""
    rig = rig_of("mirror-ball")
    T = drawn_poses(rig, results[FACETS].levels("seed")[0])[0]
    camera = rig.camera
    pieces = pieces_shown(camera, T, rig.target.monitor_mm)
    parts = [
        *board(rig.target, T, None, "monitor"),
        *mirrors(camera),
        frustum(camera.viewer, 60.0),
        *axes_parts(120.0),
    ]
    look = {"colour": ORANGE, "opacity": 0.8, "label": "piece of a facet"}
    parts += [
        polygon(transform(T, on_plane(piece) - [0, 0, 1.0]), **look)
        for piece in pieces.values()
    ]
    rows = [(k, *corner) for k, piece in pieces.items() for corner in piece]
    middles = np.array([camera.T_viewer_facets[k, :3, 3] for k in pieces])
    ends = {k: transform(T, np.append(p.mean(axis=0), 0)) for k, p in pieces.items()}
    reflected = np.array([*ends.values()])
    parts += [
        Segments(middles, reflected, "#0072b2", "ray off a facet", 1.0),
        Segments(np.zeros_like(middles), middles, "#8a919a", "sight of the ball", 1.0),
        Labels([[0, 60.0, 0]], ["camera"], INK),
    ]
    scene = framed(parts, (-0.7, 0.5, 0.25), note="The rig mirror-ball.")
    drawn, axes = new_figure(height_in=HEIGHT_IN)
    drawn.set_layout_engine("none")
    axes.set_position([0.0, 0.0, 1.0, 1.0])
    draw_scene(axes, scene)
    back = [camera.project_facet(at[None], k).valid[0] for k, at in ends.items()]
    return Drawing(
        drawn,
        columns(HEAD, rows),
        "The ball of flat mirrors of Fig. 3.18, the monitor beside the camera, and in "
        "orange the piece of the monitor that each facet shows whole. Between the "
        "pieces the camera sees nothing of it.",
        Check(all(back), "the middle of each piece is projected into its facet"),
        scene,
    )


def pieces_shown(camera, T_camera_monitor, size):
    """The corners (4, 2) mm on the monitor of each facet that shows it whole."""
    T_facets, found = camera.T_viewer_facets, {}
    for k, (T, outline) in enumerate(zip(T_facets, camera.outlines, strict=True)):
        corners = transform(T, on_plane(0.98 * np.asarray(outline)))
        seen = camera.viewer.project(corners).pixels
        if not camera.in_image(seen).all():
            continue
        rays = camera.rays(seen)
        if not rays.valid.all() or (camera.facet_of(seen) != k).any():
            continue
        met = intersect_rays_plane(rays.origins, rays.directions, T_camera_monitor)
        facing = (rays.directions @ T_camera_monitor[:3, 2] > 0).all()
        if (
            facing
            and met.valid.all()
            and np.all((met.points > 0) & (met.points < size))
        ):
            found[k] = met.points
    return found
