"""Cameras in space: rays, field of view, mirror and caustic as parts of a scene.

Everything is in the camera's frame; `moved` brings parts into another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.cameras import centrality, closest_point
from raxel.cameras.core.base import Camera
from raxel.cameras.core.caustic import caustic_points
from raxel.cameras.registry import load_camera
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.features.boards import check_chessboard, detect_boards
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.io.files import read_json
from raxel.lab.rig import Rig
from raxel.lab.set_rendering import POSES
from raxel.sets.model import ActiveGrid, AprilGrid, Chessboard, CircleGrid
from raxel.show.scene import (
    Arrows,
    Labels,
    Part,
    Points,
    Polyline,
    Scene,
    Segments,
    Surface,
    finite_points,
)
from raxel.show.view import INK, VIEW_DIRECTION, board, framed, polygon

BLUE, ORANGE, GREEN, SILVER = "#0072b2", "#d55e00", "#009e73", "#9fb4c7"
FAINT, SKY = "#8a939e", "#56b4e9"
AXES = {"x": "#c0392b", "y": "#2e8b57", "z": "#2457a6"}
# Directions in which the edge of the field is searched, positions tested in each, and
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
# Rays within this share of the drawn length start at one point.
POINT_TOL = 1e-6


# Steps of predicted SDs; colour and label of rays up to each, above and unknown.
ERROR_STEPS_PX = (0.1, 0.3, 1.0)
ERROR_RAYS = (
    (BLUE, "ray, SD up to 0.1 px"),
    ("#009e73", "up to 0.3 px"),
    (ORANGE, "up to 1 px"),
    ("#6b7785", "above 1 px, or unknown"),
)


def rays(
    camera: Camera,
    reach: float,
    grid: tuple[int, int] = RAY_GRID,
    colour: str = BLUE,
    label: str = "ray",
) -> Segments:
    """Return rays of a grid of pixels as segments.

    Parameters
    ----------
    camera : Camera
        Any camera.
    reach : float
        Length of the rays, mm.
    grid : tuple of int
        Columns and rows of pixels, spread over the image.
    colour, label : str
        Colour (hexadecimal) and label of the part.

    Returns
    -------
    Segments
        Rays in the camera frame.
    """
    seen = camera.rays(spread_pixels(camera, grid))
    ends = seen.origins + reach * seen.directions
    return Segments(seen.origins, ends, colour, label, 1.3)


def rays_by_error(camera, reach):
    """Segments of rays, one for each step of their predicted SD in the image; all rays
    alike where no errors are known."""
    pixels = spread_pixels(camera, RAY_GRID)
    sd = np.sqrt(np.trace(camera.pixel_covariance(pixels), axis1=1, axis2=2))
    if np.isnan(sd).all():
        return [rays(camera, reach)]
    step = np.searchsorted(ERROR_STEPS_PX, sd)
    return [
        replace(
            part,
            starts=np.where((step == k)[:, None], part.starts, np.nan),
            ends=np.where((step == k)[:, None], part.ends, np.nan),
        )
        for k, (colour, label) in enumerate(ERROR_RAYS)
        for part in [rays(camera, reach, colour=colour, label=label)]
        if (step == k).any()
    ]


def spread_pixels(camera, grid):
    """Pixels (N, 2), row by row, at the middles of a grid (columns, rows) of cells."""
    u, v = (
        (np.arange(count) + 0.5) * side / count - 0.5
        for count, side in zip(grid, (camera.width, camera.height), strict=True)
    )
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def field_edge(camera):
    """Return pixels (N, 2) around the part of the image that has rays, a closed line.

    In evenly spaced directions from the image centre: the farthest pixel with a ray, at
    the image's border or the edge of the field of view. NaN without any.
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


def field_of_view(
    camera: Camera,
    reach: float,
    colour: str = SKY,
    label: str = "edge of the field of view",
) -> list[Polyline | Segments]:
    """Return the ends of the rays around the field of view, and a few of these rays.

    Parameters
    ----------
    camera : Camera
        Any camera.
    reach : float
        Length of the rays, mm.
    colour, label : str
        Colour (hexadecimal) and label of the part.

    Returns
    -------
    list
        A Polyline and Segments in the camera frame.
    """
    seen = camera.rays(field_edge(camera))
    ends = seen.origins + reach * seen.directions
    few = slice(AROUND // 16, None, AROUND // 8)
    return [
        Polyline(ends, colour, label, 2.5),
        Segments(seen.origins[few], ends[few], colour, label, 1.3),
    ]


def frustum(
    camera: Camera, reach: float, colour: str = INK, label: str = "camera"
) -> Segments:
    """Return a small pyramid that represents a camera.

    The camera sees less than a half space. The edges follow the rays of the image
    corners. A peak marks the upper side of the image. If the corners have no rays, or
    sideways ones, the pyramid is the same for every camera.

    Parameters
    ----------
    camera : Camera
        Any camera.
    reach : float
        Depth of the pyramid, mm.
    colour, label : str
        Colour (hexadecimal) and label of the part.

    Returns
    -------
    Segments
        Edges in the camera frame.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.show import frustum
    >>> K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1.0]])
    >>> np.shape(frustum(PerspectiveCamera(K, [], 640, 480), 50.0).starts)
    (10, 3)
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


def axes(
    length: float, T_frame_axes: ArrayLike | None = None, labelled: bool = True
) -> list[Arrows | Labels]:
    """Return arrows x, y, z of a frame, with their names.

    Parameters
    ----------
    length : float
        Length of the arrows, mm.
    T_frame_axes : array_like of shape (4, 4), optional
        Pose of the axes. None: the axes of the frame itself.
    labelled : bool
        Whether to add the names.

    Returns
    -------
    list
        Three Arrows, and three Labels if `labelled`.

    Examples
    --------
    >>> from raxel.show import axes
    >>> [type(part).__name__ for part in axes(100.0, labelled=False)]
    ['Arrows', 'Arrows', 'Arrows']
    """
    T = np.eye(4) if T_frame_axes is None else np.asarray(T_frame_axes, float)
    tips = transform(T, length * np.eye(3))
    parts: list[Arrows | Labels] = [
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


def mirrors(
    camera: Camera, label: str = "mirror", colour: str = SILVER, opacity: float = 0.35
) -> list[Surface]:
    """Return the mirrors of a camera.

    Parameters
    ----------
    camera : Camera
        Any camera.
    label, colour : str
        Label and colour (hexadecimal) of the part.
    opacity : float
        Opacity, above 0 and at most 1.

    Returns
    -------
    list of Surface
        Mirrors in the camera frame; empty for a camera without one.
    """
    if hasattr(camera, "outlines") and hasattr(camera, "T_viewer_facets"):
        rings = [
            transform(T, on_plane(outline))
            for T, outline in zip(camera.T_viewer_facets, camera.outlines, strict=True)
        ]
        return [
            polygon(ring, colour=colour, opacity=opacity, label=label) for ring in rings
        ]
    if not (hasattr(camera, "mirror") and hasattr(camera, "T_viewer_mirror")):
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


def viewing_rays(camera: Camera, count: tuple[int, int] = (7, 5)) -> list[Segments]:
    """Return rays from the camera that views a mirror to their reflections.

    Parameters
    ----------
    camera : Camera
        Any camera.
    count : tuple of int
        Columns and rows of pixels.

    Returns
    -------
    list of Segments
        Rays in the camera frame; empty for a camera without a mirror.
    """
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


def moved(
    parts: Sequence[Part],
    T_target_source: ArrayLike,
    unlabelled: bool = False,
    scale: float = 1.0,
) -> list[Part]:
    """Return parts in another frame: scaled, then posed.

    Parameters
    ----------
    parts : sequence of parts
        Parts in the source frame.
    T_target_source : array_like of shape (4, 4)
        Pose of the source frame in the target frame.
    unlabelled : bool
        Whether to remove the labels.
    scale : float
        Factor of all lengths.

    Returns
    -------
    list
        Parts in the target frame.
    """
    T = np.asarray(T_target_source, float)
    out = []
    for part in parts:
        names = ("starts", "ends") if hasattr(part, "starts") else ("points",)
        new: dict[str, Any] = {
            n: transform(T, scale * np.asarray(getattr(part, n))) for n in names
        }
        if unlabelled:
            new["label"] = ""
        out.append(replace(part, **new))
    return out


def camera_scene(camera: Camera, name: str = "camera") -> Scene:
    """Return a scene of a camera: rays, centre or caustics, mirror and field of view.

    A central camera has no length of its own, so its rays are drawn 100 mm long.

    Parameters
    ----------
    camera : Camera
        Any camera.
    name : str
        Name of the camera in the note.

    Returns
    -------
    Scene
        Scene in the camera frame.
    """
    seen = camera.rays(spread_pixels(camera, RAY_GRID))
    origins = seen.origins[seen.valid]
    reach = drawn_reach(camera)
    parts: list[Part] = [*rays_by_error(camera, reach), *field_of_view(camera, reach)]
    parts += [*mirrors(camera), *viewing_rays(camera)]
    parts.append(Points(origins, INK, "start of a ray", 4.0))
    measured = camera.rays(spread_pixels(camera, MEASURED))
    gap, nearest = centrality(measured), closest_point(measured)
    if gap > POINT_TOL * reach:
        parts += caustics(camera, 1.5 * reach)
        parts.append(Points(nearest[None], "#c76ea3", "nearest to all rays", 12.0))
        found = f"non-central: RMS distance of the rays from a point is {gap:.2g} mm"
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


# Scenes of targets in front of a camera: rigs of the simulator, and posed boards.


CALIBRATE, EVALUATE = "#6b7785", "#d55e00"
# The camera's pyramid, and its axes, as shares of the farthest target's distance.
BODY, AXIS, FIELD = 0.1, 0.25, 0.6
# A mirror that is nearer than this share of it has one name with the camera.
MAX_LABEL_DISTANCE = 0.25


def drawn_poses(rig: Rig, seed: int) -> np.ndarray:
    """Return the poses of all views that `raxel render` takes with a seed.

    Parameters
    ----------
    rig : raxel.lab.Rig
        Rig of the simulator.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    ndarray of shape (n, 4, 4)
        Poses T_camera_target, mm.

    Raises
    ------
    InputError
        As `Rig.draw_poses`.
    """
    rng = np.random.default_rng([seed, POSES])
    return rig.draw_poses(rng, rig.count + rig.evaluate)


def rig_scene(rig: Rig, seed: int = 0, poses: np.ndarray | None = None) -> Scene:
    """Return a scene of a rig: its camera, mirror and targets.

    Parameters
    ----------
    rig : raxel.lab.Rig
        Rig of the simulator.
    seed : int
        Seed of the random numbers.
    poses : ndarray of shape (n, 4, 4), optional
        Result of `drawn_poses` for rig and seed if it is known.

    Returns
    -------
    Scene
        Scene in the camera frame.

    Raises
    ------
    InputError
        As `Rig.draw_poses`.
    """
    poses = drawn_poses(rig, seed) if poses is None else poses
    uses = ["calibrate"] * rig.count + ["evaluate"] * rig.evaluate
    count = f"{rig.count} poses" + (f" and {rig.evaluate} more" if rig.evaluate else "")
    note = f"{rig.name}: {rig.summary}. {count}, drawn from seed {seed}."
    targets = [rig.target] * len(poses)
    return posed_targets(rig.camera, targets, poses, uses, note, rig.border_mm)


def posed_targets(camera, targets, poses, uses, note, border_mm=None):
    """A camera and targets in poses T_camera_target (n, 4, 4), one of each for each.

    uses: 'calibrate' or 'evaluate' for each; border_mm: as in `board`.
    """
    what = "monitor" if isinstance(targets[0], ActiveGrid) else "chessboard"
    known = what == "monitor" or targets[0].pitch_mm is not None
    unit = "mm" if known else "pitches"
    parts = []
    for target, T, use in zip(targets, poses, uses, strict=True):
        label, colour = f"{what} to {use} with", EVALUATE
        if use == "calibrate":
            label, colour = (label if "evaluate" in uses else what), CALIBRATE
        parts += board(target, T, border_mm, label, colour)
    parts += _camera_for(camera, parts)
    return framed(parts, facing_sight(np.asarray(poses)), note=note, scale=unit)


def facing_sight(poses):
    """Return the standard view (3,) or the reflection of it that shows most fronts."""
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, 1, -1], [-1, 1, -1]])
    views = signs * np.array(VIEW_DIRECTION)
    return views[np.argmax((poses[:, :3, 2] @ views.T > 0).sum(axis=0))]


def _camera_for(camera, boards):
    """Return the camera of `boards`, scaled to their size."""
    corners = np.concatenate([finite_points(part) for part in boards])
    far = np.linalg.norm(corners, axis=1).max()
    parts = field_of_view(camera, FIELD * far)
    parts.append(frustum(getattr(camera, "viewer", camera), BODY * far))
    parts += axes(AXIS * far)
    named = {"camera": np.zeros((1, 3))}
    silvered = mirrors(camera)
    if silvered:
        surface = np.concatenate([finite_points(part) for part in silvered])
        parts += silvered + viewing_rays(camera)
        if np.linalg.norm(surface.mean(axis=0)) > MAX_LABEL_DISTANCE * far:
            named["mirror"] = surface
        else:
            named = {"camera, mirror": named["camera"]}
    return parts + [_name(text, at, BODY * far) for text, at in named.items()]


def _name(text, points, gap):
    """Return a label above the centre of points (N, 3); up is negative y."""
    place = (points.min(axis=0) + points.max(axis=0)) / 2
    place[1] = points[:, 1].min() - gap
    return Labels(place[None], [text], INK)


# An image set as a scene: its camera, and targets where their images put them.


MIN_N_VIEWS = 2
# Residual, px, of a camera that fits its set.
MAX_RESIDUAL_PX = 2.0
OTHER_CAMERA = (
    "for another camera run raxel calibrate, then raxel show SET --camera CAMERA"
)


def set_scene(image_set, camera=None, say=None, boards=None):
    """Return a scene of the poses of a set's targets, in the camera's frame.

    camera: any of `raxel.cameras`; the boards detected in the images are posed to fit
    its rays. Without one, the truth of a rendered set is shown. A set with neither is
    calibrated by Zhang's method, which is fast and fits an ordinary lens. The note
    states the source of the poses, and their error. say: callable for one line per
    image. boards: Boards of the set that are known already; they replace detection and
    truth. Raises InputError, one line, if no pose can be determined.
    """
    if camera is None and boards is None and image_set.truth is not None:
        return _true_scene(image_set)
    if isinstance(image_set.target, ActiveGrid):
        raise InputError(
            f"{image_set.description}: target.kind: active_grid without ground truth "
            "has no poses; run raxel calibrate and raxel show CAMERA, or raxel show "
            "RIG for a rig"
        )
    check_chessboard(image_set)
    if boards is None:
        boards = detect_boards(image_set, say=say)
    views = board_views(image_set, boards)
    if len(views) < (MIN_N_VIEWS if camera is None else 1):
        raise InputError(
            f"{image_set.description}: views: board found in {len(views)} of "
            f"{len(boards)} images; check target.columns and target.rows"
        )
    how = "poses fitted to the camera given"
    if camera is None:
        how = f"camera by Zhang's method, quick and for ordinary lenses; {OTHER_CAMERA}"
        camera = _quick_camera(image_set, views)
    return _posed_scene(image_set, camera, views, how)


def _true_scene(image_set):
    folder = image_set.folder / image_set.truth
    found = read_json(folder / "poses.json")
    try:
        named = found["T_camera_target"]
        poses = np.array([named[view.label] for view in image_set.views], float)
        if poses.shape[1:] != (4, 4):
            raise ValueError(f"poses of shape {poses.shape[1:]}")
    except (KeyError, TypeError, ValueError) as fault:
        raise InputError(
            f"{folder / 'poses.json'}: T_camera_target: invalid ({fault}); render the "
            "set again"
        ) from fault
    uses = [view.use for view in image_set.views]
    note = f"{image_set.name}: {len(poses)} targets in their true poses."
    camera = load_camera(folder / "camera.npz")
    return posed_targets(camera, [image_set.target] * len(poses), poses, uses, note)


def _quick_camera(image_set, views):
    try:
        return calibrate_zhang(views, image_set.width, image_set.height).camera
    except CalibrationError as fault:
        raise InputError(
            f"{image_set.description}: views: {fault}; {OTHER_CAMERA}"
        ) from fault


def _squares(target, view):
    """A chessboard with about the extent of a target, to draw it."""
    if isinstance(target, AprilGrid):
        return Chessboard(view.columns, view.rows, target.pitch_mm / 2)
    staggered = isinstance(target, CircleGrid) and target.staggered
    return Chessboard(view.columns * (1 + staggered), view.rows, target.pitch_mm)


def _posed_scene(image_set, camera, views, how):
    scores = evaluate_camera(camera, views)
    posed = [
        (score, view)
        for score, view in zip(scores.images, views, strict=True)
        if score.T_camera_grid is not None
    ]
    if not posed:
        raise InputError(
            f"{image_set.description}: views: no board has a pose that fits the "
            f"camera ({scores.images[0].reason}); is it the camera of this set?"
        )
    uses = {view.label: view.use for view in image_set.views}
    note = (
        f"{image_set.name}: {len(posed)} of {len(image_set.views)} boards; {how}. "
        f"Median distance of corners from where this puts them: {scores.median_px:.2g} "
        "px."
    )
    if scores.median_px > MAX_RESIDUAL_PX:
        note += " The error is large: these poses are unreliable."
    return posed_targets(
        camera,
        [_squares(image_set.target, view) for _, view in posed],
        np.stack([score.T_camera_grid for score, _ in posed]),
        [uses[view.name] for _, view in posed],
        note,
    )
