"""Fig. 4.5: the camera, its mirror and three grids."""

from chapters.shared.central_sets import LINEAR_GRIDS
from chapters.shared.rigs import rig_named
from raxel.show import Labels, Polyline, framed
from raxel.show.boards import plate
from raxel.show.cameras import axes as axes_parts
from raxel.show.cameras import field_of_view, frustum, mirrors
from raxel.show.rigs import drawn_poses
from repro.page.space import scene_figure
from repro.page.style import INK, series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SEED = 0
GRIDS = tuple(series(k)["color"] for k in (0, 1, 2))
# The mirror above its camera, as in the room, and both before the grids.
SIGHT, UP = (0.8, -0.5, -0.4), (0.0, 0.0, 1.0)
# Of the camera's pyramid and axes, and of the rays at the edge of the field of view.
BODY_MM, AXIS_MM, FIELD_MM = 25.0, 50.0, 110.0


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
