"""Meshes of pyvista for a scene: tubes, balls, cones and sheets.

All parts are geometry, so that image and page have the same occlusions. Widths and
sizes, px, become lengths at the distance of `look_at`. Positions are relative to it, so
that single precision is sufficient.
"""

import functools
from typing import NamedTuple

import numpy as np

from raxel.show.scene import (
    CLEAR,
    SAME,
    Arrows,
    Labels,
    Points,
    Polyline,
    SceneError,
    Segments,
    Surface,
    finite_pairs,
    finite_points,
)
from raxel.show.view import mm_per_px

# Sides of a tube: many if there are few tubes, few if there are many. Sides and rings
# of a ball by their number; many balls are octahedra, smoothly shaded.
FINE, COARSE, MANY = 12, 5, 400
BALLS = ((40, (FINE, FINE)), (MANY, (8, 6)), (np.inf, (4, 3)))
# Length and radius of an arrow's head, in widths of its shaft.
HEAD_LENGTH, HEAD_RADIUS = 4.5, 1.7


class Drawn(NamedTuple):
    """Hold one mesh, relative to `look_at`, and its appearance.

    culled: 'front', 'back' or None, the side of its faces that is not drawn.
    """

    mesh: object
    colour: str
    opacity: float
    texture: np.ndarray | None
    label: str
    culled: str | None


@functools.lru_cache(maxsize=1)
def drawn_parts(scene):
    """Return the meshes of a scene, `Drawn`, one for all parts of equal appearance.

    They are in the order of the parts; labels have none. Those of the last scene are
    cached: its image and its page are usually made in turn.

    Raises SceneError if no part has anything to draw.
    """
    centre = np.asarray(scene.look_at, float)
    unit = mm_per_px(scene)
    found = [
        drawn
        for part in scene.parts
        if not isinstance(part, Labels)
        for drawn in _drawn(part, centre, unit)
        if drawn.mesh.n_points
    ]
    if not found:
        raise SceneError("Scene: no part has a finite point; check the parts")
    return _joined(found)


def _joined(found):
    """Merge meshes of equal appearance, since time grows with the number of meshes."""
    alike = {}
    for drawn in found:
        shaded = drawn.mesh.point_data.active_normals is not None
        paint = (*drawn._replace(mesh=shaded, texture=id(drawn.texture)),)
        alike.setdefault(paint, []).append(drawn)
    return [
        group[0]._replace(
            mesh=group[0].mesh.append_polydata(*(drawn.mesh for drawn in group[1:]))
        )
        if len(group) > 1
        else group[0]
        for group in alike.values()
    ]


def _drawn(part, centre, unit):
    if isinstance(part, Surface):
        return _sheet(part, centre)
    if isinstance(part, Points):
        mesh = _balls(finite_points(part) - centre, part.size * unit / 2)
    elif isinstance(part, Arrows):
        mesh = _arrows(finite_pairs(part) - centre, part.width * unit)
    elif isinstance(part, Polyline):
        mesh = _tubes(_runs(np.asarray(part.points, float) - centre), part.width * unit)
    elif isinstance(part, Segments):
        mesh = _tubes(list(finite_pairs(part) - centre), part.width * unit)
    return [Drawn(mesh, part.colour, 1.0, None, part.label, None)]


def _runs(points):
    """The stretches (n, 3), n >= 2, of a line between its rows that are not finite."""
    gaps = np.flatnonzero(~np.isfinite(points).all(axis=1))
    runs = np.split(points, gaps)
    runs = [runs[0], *(run[1:] for run in runs[1:])]
    return [run for run in runs if len(run) > 1]


def _tubes(lines, width):
    """Return tubes of a diameter around lines [(n, 3)] without gaps."""
    import pyvista as pv

    lines = [line for line in lines if np.ptp(line, axis=0).any()]
    if not lines:
        return pv.PolyData()
    starts = np.cumsum([0, *map(len, lines)])
    cells = [
        [len(line), *range(start, start + len(line))]
        for start, line in zip(starts[:-1], lines, strict=True)
    ]
    mesh = pv.PolyData()
    mesh.points = np.concatenate(lines).astype(np.float32)
    mesh.lines = np.concatenate(cells)
    # A given axis replaces VTK's search for one, which fails on sharp bends.
    n_sides = FINE if len(mesh.points) <= MANY else COARSE
    return mesh.tube(radius=width / 2, n_sides=n_sides, capping=True)


def _balls(points, radius):
    import pyvista as pv

    if not len(points):
        return pv.PolyData()
    around, rings = next(shape for most, shape in BALLS if len(points) <= most)
    ball = pv.Sphere(radius=radius, theta_resolution=around, phi_resolution=rings)
    return _copies(ball, points)


def _arrows(pairs, width):
    """Return shafts with a cone at the end; an arrow of length 0 has neither."""
    import pyvista as pv

    run = pairs[:, 1] - pairs[:, 0]
    length = np.linalg.norm(run, axis=1)
    pairs, run = pairs[length > 0], run[length > 0] / length[length > 0, None]
    if not len(pairs):
        return pv.PolyData()
    head = np.minimum(HEAD_LENGTH * width, length[length > 0])[:, None] * run
    necks = pairs[:, 1] - head
    cones = [
        pv.Cone(
            center=neck + part / 2,
            direction=part,
            height=np.linalg.norm(part),
            radius=HEAD_RADIUS * width,
            resolution=2 * FINE,
        )
        for neck, part in zip(necks, head, strict=True)
    ]
    shafts = _tubes(list(np.stack([pairs[:, 0], necks], axis=1)), width)
    return pv.merge([shafts, *cones], merge_points=False).extract_surface(
        algorithm="dataset_surface"
    )


def _copies(shape, points):
    """A mesh with normals repeated at points (N, 3)."""
    import pyvista as pv

    corners, normals = np.asarray(shape.points), np.asarray(shape.point_normals)
    faces = shape.regular_faces
    steps = len(corners) * np.arange(len(points))
    placed = (points[:, None] + corners).reshape(-1, 3).astype(np.float32)
    mesh = pv.PolyData.from_regular_faces(
        placed, (steps[:, None, None] + faces).reshape(-1, 3)
    )
    mesh.point_data.active_normals = np.tile(normals, (len(points), 1))
    return mesh


def _sheet(part, centre):
    """Return front and back of a sheet; cells with a nonfinite corner are excluded.

    Faces are counterclockwise in front view.
    """
    import pyvista as pv

    lattice = np.asarray(part.points, float) - centre
    rows, columns, _ = lattice.shape
    finite = np.isfinite(lattice).all(axis=2)
    index = np.arange(rows * columns).reshape(rows, columns)
    cells = np.stack(
        [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1
    ).reshape(-1, 4)
    cells = cells[finite.ravel()[cells].all(axis=1)]
    if not len(cells):
        return []
    points = np.where(finite[..., None], lattice, 0.0).reshape(-1, 3)
    mesh = pv.PolyData.from_regular_faces(points.astype(np.float32), cells)
    v, u = np.mgrid[0 : 1 : rows * 1j, 0 : 1 : columns * 1j]
    mesh.active_texture_coordinates = np.column_stack(
        [u.ravel(), 1 - v.ravel()]
    ).astype(np.float32)
    if rows > 2 or columns > 2:
        mesh = mesh.compute_normals(
            cell_normals=False, consistent_normals=False, split_vertices=False
        )
    one_sided = "back" if part.back != SAME else None
    front = Drawn(mesh, part.colour, part.opacity, part.texture, part.label, one_sided)
    if part.back in (SAME, CLEAR):
        return [front]
    return [front, Drawn(mesh, part.back, part.opacity, None, part.label, "front")]
