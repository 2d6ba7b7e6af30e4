"""Fig. 5.3: pose of a monitor that the camera sees in a reference mirror."""

import numpy as np

from chapters.shared.mirror_pictures import platter_camera
from chapters.shared.mirror_rigs import mirror_rig
from raxel.calibration.mirror.platter import platter_plane, reflected_pose
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.show import Labels, Points, Polyline, Segments, Surface, framed
from raxel.show.boards import board, plate
from raxel.show.cameras import frustum, mirrors
from repro.page.space import draw_scene
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

# From above, from behind the camera and its right, where the monitor shows its face.
SIGHT, BODY_MM, RIM = (-0.45, 0.5, 0.85), 45.0, 96
SILVER, GREY = "#9fb4c7", "#6b7785"
NEAR, FAR, IMAGE = (series(k)["color"] for k in (0, 2, 1))
ON_BOARD, RAY = "platter on its board", "rays"
SEEN, EXACT_PX = 3, 1e-6
NOTE = (
    "Grey lines run from the camera over the platter to the monitor; orange ones go on "
    "behind the platter to the mirror image, where the camera sees the monitor."
)


@figure("fig_5_3", needs=("fig_5_3_platter",), evidence="rendered", scene=True)
def fig_5_3(results):
    """Camera, platter on its board, flexible mirror, monitor and its image."""
    rig = mirror_rig("A")
    platter, poses = rig.platter(), rig.monitor_poses()
    plane = platter_plane(platter.T_camera_board, platter.thickness_mm)
    virtual = [reflected_pose(T, plane) for T in poses]
    seen = points_in_platter(rig, platter, virtual[0])
    parts = setup_parts(rig, platter, poses, virtual[0], seen)
    scene = framed(parts, SIGHT, aspect=1.2, note=NOTE)
    drawn, (space, photograph) = new_figure(1, 2, height_in=4.0)
    drawn.set_layout_engine("none")
    space.set_position([0.0, 0.0, 0.6, 0.94])
    photograph.set_position([0.62, 0.12, 0.37, 0.8])
    photograph.imshow(
        results["fig_5_3_platter"].arrays("picture")[0], cmap="gray", vmin=0, vmax=255
    )
    photograph.set_axis_off()
    for panel, letter in ((space, "(a)"), (photograph, "(b)")):
        drawn.text(panel.get_position().x0 + 0.01, 0.94, letter, fontsize=9)
    draw_scene(space, scene)
    off = _off_by_tracing(rig, platter, poses[0], virtual[0], seen)
    named = {
        "platter": platter.T_camera_mirror,
        "monitor, first position": poses[0],
        "monitor, second position": poses[1],
        "mirror image, first position": virtual[0],
        "mirror image, second position": virtual[1],
    }
    rows = [(name, *T[:3, 3]) for name, T in named.items()]
    return Drawing(
        drawn,
        columns(("what", "x_mm", "y_mm", "z_mm"), rows),
        "Set-up for the pose of the monitor. (a) Rig A in the camera's frame: a hard "
        "disk's platter on a chessboard is between camera and flexible mirror. The "
        "camera sees the board and, in the platter, the monitor's mirror image "
        "(orange). Reflected in the plane of the platter, the image's pose is the "
        "monitor's (blue; green: second position). (b) Rendered image of the platter "
        "on its board, reflecting a sinusoidal pattern.",
        Check(
            bool(off < EXACT_PX),
            "straight lines from the camera to the mirror image meet the image where "
            f"rays traced over the platter do, to {off:.0e} px",
        ),
        scene,
    )


def points_in_platter(rig, platter, T_virtual):
    """Points (SEEN, 2), mm, on the monitor that the camera sees in the platter."""
    corner, size = rig.monitor.extent
    shares = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 61)]), axis=-1).reshape(-1, 2)
    points = corner + size * shares
    _, met = _over_the_platter(platter, transform(T_virtual, on_plane(points)))
    wanted = 0.75 * platter.radius_mm * _around(SEEN)
    return points[[np.argmin(np.linalg.norm(met - at, axis=1)) for at in wanted]]


def setup_parts(rig, platter, poses, T_virtual, seen):
    """Objects in the camera's frame; seen: (n, 2) mm of the near monitor."""
    image, there = (transform(T, on_plane(seen)) for T in (T_virtual, poses[0]))
    met, _ = _over_the_platter(platter, image)
    parts = [
        frustum(rig.viewer, BODY_MM, label=""),
        *mirrors(rig.rig.camera, "flexible mirror", opacity=0.7),
    ]
    parts += board(platter.board, platter.T_camera_board, label=ON_BOARD)
    parts += [_ring(platter)]
    parts += board(rig.monitor.target, poses[0], label="monitor", colour=NEAR)
    parts += [
        *_outline(rig, poses[1], FAR, "second position"),
        *_outline(rig, T_virtual, IMAGE, "its mirror image"),
        Segments(np.zeros_like(met), met, GREY, RAY, 1.4),
        Segments(met, there, GREY, RAY, 1.4),
        Segments(met, image, IMAGE, RAY, 1.4),
        Points(met, INK, RAY, 5.0),
    ]
    return parts + _names(rig, platter, poses, T_virtual)


def _ring(platter):
    rim = _around(RIM, closed=True)
    flat = np.concatenate([platter.radius_mm * rim, platter.hub_mm * rim])
    points = transform(platter.T_camera_mirror, on_plane(flat))
    return Surface(points.reshape(2, RIM, 3), SILVER, 1.0, ON_BOARD)


def _outline(rig, T, colour, label):
    sheet = plate(T, *rig.monitor.extent, colour=colour, opacity=0.18, label=label)
    rim = sheet.points[[0, 0, 1, 1, 0], [0, 1, 1, 0, 0]]
    return [sheet, Polyline(rim, colour, label, 2.0)]


def _names(rig, platter, poses, T_virtual):
    corner, size = rig.monitor.extent
    above = on_plane((corner + size * [0.5, -0.08])[None])
    mirror = rig.rig.camera
    named = {
        "camera": np.array([0.0, -BODY_MM, 0.0]),
        "monitor": transform(poses[0], above)[0],
        "mirror image": transform(T_virtual, above)[0],
        "platter": platter.T_camera_mirror[:3, 3] + [0, platter.radius_mm + 22, 0],
        "flexible mirror": mirror.T_viewer_mirror[:3, 3]
        + mirror.T_viewer_mirror[:3, :2] @ [mirror.mirror.end / 2, 75.0],
    }
    return [Labels(at[None], [name], INK) for name, at in named.items()]


def _over_the_platter(platter, points):
    """Where lines from the camera to points (N, 3) meet the platter's face: (N, 3) in
    the camera's frame, and (N, 2) from its middle in its plane."""
    T = platter.T_camera_mirror
    normal = T[:3, 2]
    met = points * (normal @ T[:3, 3] / (points @ normal))[:, None]
    return met, (met - T[:3, 3]) @ T[:3, :2]


def _off_by_tracing(rig, platter, T, T_virtual, seen):
    """Distance (px) between the direct image and the one traced over the platter."""
    straight = rig.viewer.project(transform(T_virtual, on_plane(seen))).pixels
    traced = platter_camera(rig, platter).project(transform(T, on_plane(seen))).pixels
    return float(np.abs(straight - traced).max())


def _around(count, closed=False):
    turn = np.linspace(0, 2 * np.pi, count, endpoint=closed) + np.pi / 2
    return np.column_stack([np.cos(turn), np.sin(turn)])
