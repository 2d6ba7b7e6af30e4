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
# The mirror above its camera, as in the room, and both in front of the grids.
SIGHT, UP = (0.8, -0.5, -0.4), (0.0, 0.0, 1.0)
# Of the camera's pyramid and axes, and of the rays at the edge of the field of view.
BODY_MM, AXIS_MM, FIELD_MM = 25.0, 50.0, 110.0


@figure("fig_4_5", needs=(), evidence="analytic", scene=True)
def fig_4_5(results):
    """Draw the camera below its mirror, and the three grids of the linear stage."""
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
        "The omnidirectional camera (rig onevr-d70) and three grids in the camera "
        "frame: the z axis points from the camera to the mirror (in the room: up). "
        "Sheets 1 to 3: successive positions of one monitor for the linear stage, "
        "which may therefore cross. Light blue: edge of the field of view. The "
        "bracket, which misaligns the mirror by 1 mm, is not drawn.",
        Check(seen == len(poses), f"{seen} of {len(poses)} grids are in view"),
        scene,
    )


def setup_parts(camera, poses, corner, size):
    """Return camera, mirror and numbered monitor sheets in the camera frame.

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
