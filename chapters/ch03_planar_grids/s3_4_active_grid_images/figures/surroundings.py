"""A room or a building front in three dimensions, with the camera before it."""

import numpy as np

from raxel.geometry import rotate, transform
from raxel.show.cameras import field_edge
from raxel.show.surroundings import SIGHT, surroundings_scene
from repro.page.space import scene_figure
from repro.run.outcomes import Check, Drawing

HEAD = (
    "u_px", "v_px", "start_x_mm", "start_y_mm", "start_z_mm",
    "direction_x", "direction_y", "direction_z",
)  # fmt: skip
# A pixel at the edge of the field may have no ray on its other side.
FOUND_PX = 1e-3


def drawn_surroundings(laboratory, camera, T_world_camera, caption, sight=SIGHT):
    """The figure of a camera in a scene of the laboratory, world frame.

    Its numbers are the rays at the edge of the field of view.
    """
    scene = surroundings_scene(laboratory, camera, T_world_camera, sight=sight)
    pixels = field_edge(camera)
    seen = camera.rays(pixels)
    starts = transform(T_world_camera, seen.origins)
    directions = rotate(T_world_camera, seen.directions)
    back = camera.project(seen.origins + 1e3 * seen.directions).pixels
    gap = float(np.nanmax(np.linalg.norm(back - pixels, axis=1)))
    return Drawing(
        scene_figure(scene, height_in=4.6),
        dict(zip(HEAD, np.column_stack([pixels, starts, directions]).T, strict=True)),
        caption,
        Check(
            gap < FOUND_PX,
            "points on the drawn rays, a metre away, are projected to the "
            f"pixels at the edge of the field, to {gap:.0e} px",
        ),
        scene,
    )
