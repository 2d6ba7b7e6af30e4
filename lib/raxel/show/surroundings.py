"""Rooms and building fronts of the laboratory as a scene, and a camera in them."""

import numpy as np

from raxel.geometry.poses import inverse_pose, transform
from raxel.lab.surfaces import Cylinder, Rectangle
from raxel.show.boards import surface_texture
from raxel.show.cameras import axes, field_of_view, frustum, mirrors, moved
from raxel.show.scene import CLEAR, SAME, Labels, SceneError, Surface
from raxel.show.view import INK, framed

# Pixels along the longer side of a wall, and corners around a cylinder.
TEXTURE_PX, AROUND = 320, 33
# What lies this much behind a wall, as a share of its size, still counts as in it.
SLACK = 1e-3
# Steeply down, so that one looks over a room's near walls.
SIGHT = (0.42, 0.72, 0.55)
# The edge of the field of view, body and axes, as shares of the longest wall.
FIELD, BODY, AXIS = 0.3, 0.05, 0.1


def surroundings_scene(laboratory, camera, T_world_camera, note="", sight=SIGHT):
    """What a camera in a laboratory scene sees, and where it stands; world frame.

    laboratory: `raxel.lab.Scene`; T_world_camera: (4, 4). Walls that have everything
    on one side are looked through from the other. The camera is drawn larger than it
    is, its mirror in its true size.
    """
    parts = surroundings(laboratory)
    points = np.concatenate([part.points.reshape(-1, 3) for part in parts])
    long = np.ptp(points, axis=0).max()
    seen = field_of_view(camera, FIELD * long) + axes(AXIS * long)
    seen.append(frustum(getattr(camera, "viewer", camera), BODY * long))
    seen += mirrors(camera)
    # Behind it nothing else is drawn.
    seen.append(Labels([[0, 0, -2 * BODY * long]], ["camera"], INK))
    return framed([*parts, *moved(seen, T_world_camera)], sight, note=note)


def surroundings(laboratory):
    """The surfaces of a `raxel.lab.Scene` as Surfaces with their textures.

    Raises SceneError for a surface that is neither a rectangle nor a cylinder.
    """
    sheets = [_lattice(surface) for surface in laboratory.surfaces]
    parts = []
    for number, (surface, texture) in enumerate(laboratory.parts):
        points, corner, size = sheets[number]
        shown = surface_texture(texture, corner, size, max(size) / TEXTURE_PX)
        back = SAME
        if isinstance(surface, Rectangle):
            others = [s[0] for k, s in enumerate(sheets) if k != number]
            side = _side_of_rest(surface, others, max(size))
            if side > 0:
                points, shown = points[:, ::-1], shown[:, ::-1]
            back = CLEAR if side else SAME
        parts.append(Surface(points, texture=np.ascontiguousarray(shown), back=back))
    return parts


def _side_of_rest(surface, others, size):
    """-1 or 1 where all others lie on that side of z = 0 of the surface, else 0."""
    if not others:
        return 0
    flat = np.concatenate([points.reshape(-1, 3) for points in others])
    z = transform(inverse_pose(surface.T_world_surface), flat)[:, 2]
    if z.max() <= SLACK * size:
        return -1
    return 1 if z.min() >= -SLACK * size else 0


def _lattice(surface):
    """(points (rows, columns, 3) in the world, corner (2,), size (2,)) of a surface."""
    if isinstance(surface, Rectangle):
        u, v = np.stack([surface.low, surface.high], axis=1)
        u, v = np.meshgrid(u, v)
        flat = np.stack([u, v, np.zeros_like(u)], axis=-1)
        corner, size = surface.low, surface.high - surface.low
    elif isinstance(surface, Cylinder):
        turn, z = np.meshgrid(np.linspace(-np.pi, np.pi, AROUND), [0.0, surface.height])
        r = surface.radius
        flat = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1)
        corner, size = (
            np.array([-np.pi * r, 0]),
            np.array([2 * np.pi * r, surface.height]),
        )
    else:
        raise SceneError(
            f"{type(surface).__name__}: found among the surroundings; rectangles and "
            "cylinders can be shown"
        )
    return transform(surface.T_world_surface, flat), corner, size
