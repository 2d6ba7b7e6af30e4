"""Fig. 4.5, and what of each picture is calibrated."""

import numpy as np
from matplotlib.colors import ListedColormap

from chapters.ch04_central_generic.s3_1_setup.results import CAMERAS, FIELD
from chapters.shared.central_sets import LINEAR_GRIDS
from chapters.shared.rigs import rig_named
from raxel.show import Labels, Polyline, framed
from raxel.show.boards import plate
from raxel.show.cameras import axes as axes_parts
from raxel.show.cameras import field_of_view, frustum, mirrors
from raxel.show.rigs import drawn_poses
from repro.page.space import scene_figure
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SEED = 0
GRIDS = tuple(series(k)["color"] for k in (0, 1, 2))
# The mirror above its camera, as in the room, and both before the grids.
SIGHT, UP = (0.8, -0.5, -0.4), (0.0, 0.0, 1.0)
# Of the camera's pyramid and axes, and of the rays at the edge of the field of view.
BODY_MM, AXIS_MM, FIELD_MM = 25.0, 50.0, 110.0
SHADES = ("#d5d9de", "#56b4e9", "#0072b2", "#e69f00", "#d55e00", "#7a3b00")


@figure("fig_4_5", needs=(), evidence="analytic", scene=True)
def fig_4_5(results):
    """The camera below its mirror, and the three grids of the linear stage."""
    rig = rig_named("onevr-d70")
    poses = drawn_poses(rig, SEED)[:LINEAR_GRIDS]
    corner, size = rig.extent
    parts = setup_parts(rig.camera, poses, corner, size)
    scene = framed(parts, SIGHT, up=UP, note=rig.summary)
    middles = poses[:, :3] @ [*(corner + size / 2), 0, 1]
    data = {"grid": list(range(1, len(poses) + 1))} | {
        f"{axis}_mm": middles[:, k].tolist() for k, axis in enumerate("xyz")
    }
    seen = sum(bool(rig.shows(T)) for T in poses)
    return Drawing(
        scene_figure(scene, height_in=4.6),
        data,
        "The omnidirectional camera of the rig onevr-d70 in its own frame: the z "
        "axis leads from a D70-like camera ahead to the mirror (in the room: up). "
        "Sheets 1 to 3: the one monitor in the places of the three grids of the "
        "linear stage, one after the other, so that they may cross. Light blue: the "
        "edge of the field of view. The bracket between camera and mirror is not "
        "drawn; it holds the mirror 1 mm off its place.",
        Check(seen == len(poses), f"{seen} of {len(poses)} grids are in view"),
        scene,
    )


def setup_parts(camera, poses, corner, size):
    """Camera, mirror and numbered sheets of the monitor in the camera's frame.

    poses: T_camera_grid (n, 4, 4); corner, size: (2,) of the monitor in its plane, mm.
    """
    parts = [*field_of_view(camera, FIELD_MM), *mirrors(camera, opacity=1.0)]
    parts += [frustum(camera.viewer, BODY_MM), *axes_parts(AXIS_MM)]
    for number, (T, colour) in enumerate(zip(poses, GRIDS, strict=True), 1):
        name = f"grid {number}"
        sheet = plate(T, corner, size, colour=colour, opacity=0.4, label=name)
        rim = sheet.points[[0, 0, 1, 1, 0], [0, 1, 1, 0, 0]]
        parts += [sheet, Polyline(rim, colour, name, 2.5)]
        parts.append(Labels(rim[:1], [str(number)], INK, size=16.0))
    return parts


@figure("ext_fig_4_5_coverage", needs=("sec_4_3_1_field",), evidence="rendered")
def ext_fig_4_5_coverage(results):
    """How many grids each pixel has seen, of the first set of each camera."""
    result = results[FIELD]
    drawn, axes = new_figure(1, 2, height_in=3.4)
    rows = []
    shades = ListedColormap(["#ffffff", *SHADES])
    most = len(SHADES) - 1
    for panel, camera in zip(axes, CAMERAS.values(), strict=True):
        count = result.select(camera=camera).arrays("count")[0]
        shown = panel.imshow(
            np.minimum(count, most), cmap=shades, vmin=-1.5, vmax=most + 0.5,
            interpolation="nearest",
        )  # fmt: skip
        panel.set(title=camera, xticks=[], yticks=[])
        inside = count[count >= 0]
        rows += [
            (camera, grids, float(np.mean(inside == grids)))
            for grids in range(inside.max() + 1)
        ]
    bar = drawn.colorbar(shown, ax=axes, shrink=0.8, ticks=range(most + 1))
    bar.ax.set_ylim(-0.5, most + 0.5)
    bar.ax.set_yticklabels([*range(most), f"{most} or more"])
    bar.set_label("grids (1)")
    return Drawing(
        drawn,
        columns(("camera", "grids", "share_of_pixels"), rows),
        "How many grids were decoded in each pixel, of the first rendered set. "
        "White: no ray, beside the mirror or the fisheye's circle. The CSV has the "
        "shares of the pixels that have a ray.",
    )
