"""Cameras in space: rays, field of view, mirror and caustic as parts of a scene.

Everything is in the camera's frame; `moved` brings parts into another one.
"""

from dataclasses import replace

import numpy as np

from raxel.cameras import caustic_points, centrality, closest_point
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.show.boards import polygon
from raxel.show.scene import Arrows, Labels, Points, Polyline, Segments, Surface
from raxel.show.view import INK, framed

BLUE, ORANGE, GREEN, SILVER = "#0072b2", "#d55e00", "#009e73", "#9fb4c7"
FAINT, SKY = "#8a939e", "#56b4e9"
AXES = {"x": "#c0392b", "y": "#2e8b57", "z": "#2457a6"}
# Directions in which the edge of the field is looked for, places tried in each, and
# bisections after that.
AROUND, OUTWARD, HALVINGS = 144, 100, 30
# Rings and spokes of a mirror of revolution, and lines of a sheet.
RINGS, SPOKES, SHEET = 16, 64, 24
# Pixels whose rays are drawn, and those by which a camera is called central.
RAY_GRID, MEASURED = (13, 9), (64, 48)
CAUSTIC_PX = 30
# How long rays are drawn: in spans of their origins, and without one in mm.
REACH, REACH_MM = 1.1, 100.0
PYRAMID = ((-0.6, -0.45, 1), (0.6, -0.45, 1), (0.6, 0.45, 1), (-0.6, 0.45, 1))
# Rays closer together than this share of the drawn length come from one place.
ONE_POINT = 1e-6


def rays(camera, reach, grid=RAY_GRID, colour=BLUE, label="ray"):
    """Rays of a grid of pixels as Segments of length `reach`.

    grid: (columns, rows) of pixels, spread over the image.
    """
    seen = camera.rays(spread_pixels(camera, grid))
    ends = seen.origins + reach * seen.directions
    return Segments(seen.origins, ends, colour, label, 1.3)


def spread_pixels(camera, grid):
    """Pixels (N, 2), row by row, at the middles of a grid (columns, rows) of cells."""
    u, v = (
        (np.arange(count) + 0.5) * side / count - 0.5
        for count, side in zip(grid, (camera.width, camera.height), strict=True)
    )
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def field_edge(camera):
    """Pixels (N, 2) around the part of the image that has rays, the last the first.

    Outward from mid-image, in even directions: the farthest pixel with a ray, which is
    the image's border or the edge of the field of view. NaN where there is none.
    """
    size = np.array([camera.width, camera.height])
    turn = np.linspace(0, 2 * np.pi, AROUND + 1)
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    # To the border's pixel centres: a rectangle, not a circle.
    with np.errstate(divide="ignore"):
        out *= ((size - 1) / 2 / np.abs(out)).min(axis=1)[:, None]

    def pixels(share):
        return (size - 1) / 2 + share[:, None] * out

    found = np.full(len(out), np.nan)
    for share in np.linspace(0, 1, OUTWARD):
        seen = camera.rays(pixels(np.full(len(out), share))).valid
        found[seen] = share
    beyond = np.minimum(found + 1 / (OUTWARD - 1), 1.0)
    for _ in range(HALVINGS):
        middle = (found + beyond) / 2
        seen = camera.rays(pixels(middle)).valid
        found, beyond = np.where(seen, middle, found), np.where(seen, beyond, middle)
    return pixels(found)


def field_of_view(camera, reach, colour=SKY, label="edge of the field of view"):
    """The rays' ends around the field of view, and a few rays along it: two parts."""
    seen = camera.rays(field_edge(camera))
    ends = seen.origins + reach * seen.directions
    few = slice(AROUND // 16, None, AROUND // 8)
    return [
        Polyline(ends, colour, label, 2.5),
        Segments(seen.origins[few], ends[few], colour, label, 1.3),
    ]


def frustum(camera, reach, colour=INK, label="camera"):
    """A small pyramid that stands for a camera which sees less than a half space.

    Its edges go along the rays of the image's corners to the depth `reach`, mm; a
    peak marks the upper side of the picture. Where the corners have no rays, or
    sideways ones, the pyramid is the same for every camera.
    """
    w, h = camera.width - 1, camera.height - 1
    seen = camera.rays(np.array([[0, 0], [w, 0], [w, h], [0, h]], float))
    depth = seen.directions[:, 2:]
    if not (seen.valid.all() and (depth > 0.3).all()):
        side = np.array(PYRAMID)
        origin, ring = np.zeros((4, 3)), reach * side
    else:
        origin, ring = seen.origins, seen.origins + reach * seen.directions / depth
    top = ring[:2].mean(axis=0) + 0.25 * (ring[0] - ring[3])
    starts = np.concatenate([origin, ring, ring[:2]])
    ends = np.concatenate([ring, np.roll(ring, -1, axis=0), [top, top]])
    return Segments(starts, ends, colour, label, 2.0)


def axes(length, T_frame_axes=None, labelled=True):
    """Arrows x, y, z of a frame, `length` mm long, with their names."""
    T = np.eye(4) if T_frame_axes is None else np.asarray(T_frame_axes, float)
    tips = transform(T, length * np.eye(3))
    parts = [
        Arrows(T[None, :3, 3], tip[None], colour, width=2.5)
        for tip, colour in zip(tips, AXES.values(), strict=True)
    ]
    if labelled:
        beyond = transform(T, 1.15 * length * np.eye(3))
        parts += [
            Labels(place[None], [name], colour)
            for place, (name, colour) in zip(beyond, AXES.items(), strict=True)
        ]
    return parts


def mirrors(camera, label="mirror", colour=SILVER, opacity=0.35):
    """The mirrors of a camera as Surfaces; none of a camera without one."""
    if hasattr(camera, "outlines"):
        rings = [
            transform(T, on_plane(outline))
            for T, outline in zip(camera.T_viewer_facets, camera.outlines, strict=True)
        ]
        return [
            polygon(ring, colour=colour, opacity=opacity, label=label) for ring in rings
        ]
    if not hasattr(camera, "mirror"):
        return []
    mirror = camera.mirror
    if hasattr(mirror, "nodes"):
        p = mirror.nodes()
    elif hasattr(mirror, "grid"):
        u, v = (np.linspace(b[0], b[-1], SHEET) for b in mirror.grid.breaks)
        sight = mirror.grid.unturned(np.stack(np.meshgrid(u, v), -1).reshape(-1, 2))
        sight = np.column_stack([sight, np.ones(len(sight))])
        p = mirror.chart(sight).reshape(SHEET, SHEET, 2)
    elif hasattr(mirror, "half"):
        x, y = (np.linspace(-h, h, SHEET) / mirror.radius for h in mirror.half)
        p = np.stack(np.meshgrid(x, y), axis=-1)
    else:
        r, turn = np.meshgrid(
            mirror.chart_extent * np.linspace(0, 1, RINGS),
            np.linspace(0, 2 * np.pi, SPOKES + 1),
            indexing="ij",
        )
        p = np.stack([r * np.cos(turn), r * np.sin(turn)], axis=-1)
    points = mirror.point(p.reshape(-1, 2))[0].reshape(*p.shape[:2], 3)
    points = transform(camera.T_viewer_mirror, points)
    return [Surface(points, colour, opacity, label)]


def viewing_rays(camera, count=(7, 5)):
    """From the viewer of a mirror to where its rays are reflected; none without one."""
    if not hasattr(camera, "viewer"):
        return []
    pixels = spread_pixels(camera, count)
    seen, met = camera.viewer.rays(pixels), camera.rays(pixels)
    return [Segments(seen.origins, met.origins, FAINT, "sight of the mirror", 1.0)]


def caustics(camera, within, grid=(CAUSTIC_PX, CAUSTIC_PX)):
    """The two caustic sheets of a camera that is not central, as Points.

    Points farther than `within` mm from the middle of the rays' origins are left out.
    """
    pixels = spread_pixels(camera, grid)
    found = caustic_points(camera, pixels)
    middle = _middle(camera.rays(pixels).origins)
    parts = []
    for sheet, colour in enumerate((ORANGE, GREEN)):
        points = found[:, sheet]
        with np.errstate(invalid="ignore"):
            near = np.linalg.norm(points - middle, axis=1) < within
        if near.any():
            name = f"caustic, sheet {sheet + 1}"
            parts.append(Points(points[near], colour, name, 3.5))
    return parts


def moved(parts, T_target_source, unlabelled=False, scale=1.0):
    """Parts in another frame: scaled, then posed by (4, 4); without their labels."""
    T = np.asarray(T_target_source, float)
    out = []
    for part in parts:
        names = ("starts", "ends") if hasattr(part, "starts") else ("points",)
        new = {n: transform(T, scale * np.asarray(getattr(part, n))) for n in names}
        if unlabelled:
            new["label"] = ""
        out.append(replace(part, **new))
    return out


def camera_scene(camera, name="camera"):
    """A camera by itself: its rays, where they meet or do not, its mirror, its field.

    camera: any of `raxel.cameras`. A central camera has no length of its own, so its
    rays are drawn 100 mm long.
    """
    seen = camera.rays(spread_pixels(camera, RAY_GRID))
    origins = seen.origins[seen.valid]
    reach = drawn_reach(camera)
    parts = [rays(camera, reach), *field_of_view(camera, reach)]
    parts += mirrors(camera) + viewing_rays(camera)
    parts.append(Points(origins, INK, "start of a ray", 4.0))
    measured = camera.rays(spread_pixels(camera, MEASURED))
    gap, nearest = centrality(measured), closest_point(measured)
    if gap > ONE_POINT * reach:
        parts += caustics(camera, 1.5 * reach)
        parts.append(Points(nearest[None], "#c76ea3", "nearest to all rays", 12.0))
        found = f"not central: no point is nearer to all rays than {gap:.2g} mm (RMS)"
    else:
        parts.append(Points(nearest[None], ORANGE, "centre", 12.0))
        found = "central: all rays meet in one point"
    parts += axes(0.35 * reach)
    note = (
        f"{name}: {camera.kind}, {camera.width} x {camera.height} px; {found}. Every "
        f"ray is drawn {reach:.3g} mm long."
    )
    return framed(parts, note=note)


def drawn_reach(camera):
    """A length for rays, mm, in proportion to where they start."""
    seen = camera.rays(spread_pixels(camera, RAY_GRID))
    origins = seen.origins[seen.valid]
    if hasattr(camera, "viewer"):
        return REACH * np.linalg.norm(np.ptp(origins, axis=0))
    span = np.linalg.norm(np.ptp(origins, axis=0))
    return max(REACH * span, REACH_MM)


def _middle(points):
    points = points[np.isfinite(points).all(axis=1)]
    return (points.min(axis=0) + points.max(axis=0)) / 2
