"""Trials of this page, their conditions and constants."""

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.scenes import Bust
from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    BENCHES,
    LEVEL,
    PUBLISHED,
    STAGES_MM,
    MirrorRig,
    deflected,
    lattice,
    mirror_rig,
    primary,
    ray_angles,
    seen_board,
)
from raxel.calibration import pose_from_non_central_rays
from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera, SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.features import edge_points
from raxel.features.localise import saddle_point
from raxel.geometry import (
    apply_homography,
    homography_dlt,
    pose,
    refine_homography,
    rotation_from_vector,
    transform,
)
from raxel.lab import BoardRing, bands, mirror_window, ringed_board_scene, windowed
from raxel.multiview import (
    algebraic_conic,
    circle_outline,
    conic_distances,
    facing_plane,
    fit_circle,
    plane_image,
    points_on_plane,
    shown_in_view,
    view_of_plane,
    view_over_plane,
    view_pixels,
)

# The target of 5.3.4, a chessboard with a circle over it, and its image.
#
# The circle is a dark line; the middle between its two edges is measured. Its errors
# are measured once in rendered images (`edges_trial`) and drawn again from there.


RADIUS_MM = 87.21
# Points along the circle, the same in all images; and where errors are measured.
PLACES, DENSE = 90, 360
# Random stream of a seed: boards of the steps.
STEPS_OF_SEED = 8
# Corners closer than this to the ring's paper have it in their window.
CLEAR_MM = 2.0
# Rendered bands of an image, and what is fitted on either side of an edge.
BANDS, BAND_PX, ACROSS_PX = 4, 48, 6.0


def ring_on(board):
    """The BoardRing about the middle of a board's corners."""
    return BoardRing(tuple(board.points().mean(axis=0)), RADIUS_MM)


def off_ring(board):
    """Which corners (N,) of a board are clear of the ring."""
    ring = ring_on(board)
    apart = np.linalg.norm(board.points() - ring.centre, axis=1)
    reach = ring.line / 2 + ring.margin + CLEAR_MM
    return np.abs(apart - ring.radius) > reach


@lru_cache(maxsize=64)
def held(rig, deflection, seed):
    """T_camera_board (4, 4) of the target in front of the mirror, read-only.

    Held anew at each stage, where the mirror then looks. Tilt, rotation and shift from
    there depend on the seed alone, and not on the error level.
    """
    rng = np.random.default_rng(seed)
    T = rig.board_pose(rng, BACK_PROJECTION_MM, (deflection,))
    T.setflags(write=False)
    return T


@lru_cache(maxsize=16)
def boards(rig, deflections, seed):
    """T_camera_board (4, 4) of the board of each step of a calibration, read-only.

    deflections: of the stages, mm. As `held`, drawn once for all levels of a seed.
    """
    rng = np.random.default_rng([seed, STEPS_OF_SEED])
    found = np.array(
        [rig.board_pose(rng, deflections=d) for d in pairwise(deflections)]
    )
    found.setflags(write=False)
    return found


def photographed(rig, camera, T_camera_board, rng, window):
    """Image (h, w) of the target in a window of a camera's image."""
    taken = windowed(replace(rig.rig, camera=camera), window)
    light = taken.light.draw(rng, taken.extent)
    scene = ringed_board_scene(
        rig.board,
        ring_on(rig.board),
        T_camera_board,
        rig.rig.border_mm,
        light=light,
        **taken.radiances,
    )
    return taken.laboratory().render(scene, np.eye(4), rng)


class RingEdges(NamedTuple):
    """pixels: (2, N, 2) of the line's inner and outer edge, NaN where none was found;
    scale: (N,) px across the line per mm on the board."""

    pixels: np.ndarray
    scale: np.ndarray


def ring_outlines(rig, camera, T_camera_board, count):
    """True image of the line's inner and outer edge.

    Pixels, normals and scale of each, as `circle_outline`.
    """
    ring = ring_on(rig.board)
    return [
        circle_outline(camera, T_camera_board, ring.centre, radius, count)
        for radius in ring.edges
    ]


def ring_edges(rig, outlines, image, window, across_px):
    """RingEdges in a window's image, searched for at the `ring_outlines`."""
    light = (image / image.max()) ** rig.rig.sensor.gamma
    first = np.array([window.u, window.v], float)
    found = [
        edge_points(light, places - first, normals, across_px).pixels + first
        for places, normals, _ in outlines
    ]
    scale = np.mean([scale for _, _, scale in outlines], axis=0)
    return RingEdges(np.array(found), scale)


def middle_of_line(camera, edges, T_camera_plane):
    """Points (N, 2) mm of a plane half way between a line's edges, NaN if hidden."""
    seen = [points_on_plane(camera, p, T_camera_plane).points for p in edges.pixels]
    return np.mean(seen, axis=0)


def line_errors(result, geometry):
    """Errors (n,) px of the line's middle on a geometry, of the Result of the edges."""
    return np.concatenate(result.select(geometry=geometry).arrays("line_px"))


def edges_trial(condition, rng, small=False):
    """Errors of the line's middle in rendered images, px, outwards.

    small: in a part of an image of the small rig, for quick builds.
    """
    rig, off = mirror_rig(condition["geometry"], small), []
    centre = ring_on(rig.board).centre
    deflections, count = (STAGES_MM[:1], 1) if small else (STAGES_MM[::3], BANDS)
    for deflection in deflections:
        camera = rig.camera(deflection)
        T = held(rig, deflection, int(rng.integers(2**32)))
        outlines = ring_outlines(rig, camera, T, DENSE)
        for window in bands(mirror_window(camera), count, BAND_PX):
            image = photographed(rig, camera, T, rng, window)
            edges = ring_edges(rig, outlines, image, window, ACROSS_PX)
            points = middle_of_line(camera, edges, T)
            apart = np.linalg.norm(points - centre, axis=1) - RADIUS_MM
            off.append(apart * edges.scale)
    off = np.concatenate(off)
    return {"line_px": off[np.isfinite(off)]}


# A face in low relief, corrected as a plane (Fig. 5.19).
#
# A relief bust represents the face. The mirror is pushed by 12 mm, in three steps that
# are calibrated as in 5.3.3. After a single step of 12 mm no corner at the clamp is
# visible both before and after.


STEPS_MM = (0.0, 4.0, 8.0, 12.0)
DEFLECTION_MM = STEPS_MM[-1]
# Relief of 5 % of the depth.
BUST = Bust(width=160.0, relief=0.05 * BACK_PROJECTION_MM)
# Errors of the assumed plane along each axis (standard deviations).
PLANE_MM, PLANE_TURN = 5.0, np.radians(2)
# Random streams of a seed: errors of the push, and poses of bust and plane.
FACE_OF_SEED, BUST_OF_SEED = 9, 10
PER_PX = 0.25  # mm on the plane per px of the corrected image
MIN_N_LANDMARKS = 8  # visible landmarks


def face_scores(rig, cameras, first, errors, seed):
    """Distortion of a face that a plane leaves, by the calibrated and the true camera.

    `refused`: code of the error that ended the run.

    cameras: the true ones of the steps, that of stage 0 first; first: the `Primary`.
    """
    rng, true = np.random.default_rng([seed, FACE_OF_SEED]), cameras[-1]
    T_bust, T_plane = placed_bust(rig, seed)
    try:
        found = pushed_to_face(rig, cameras, first, errors, seed, rng)
        return {
            "calibrated": left_by_plane(found, true, T_bust, T_plane),
            "true": left_by_plane(true, true, T_bust, T_plane),
        }
    except InputError as refusal:
        return {"refused": refusal.code}


def pushed_to_face(rig, cameras, first, errors, seed, rng):
    """SplineMirrorCamera after the push, found step by step from that of stage 0."""
    found, points = first.camera, rig.board.points()
    for k, T in enumerate(boards(rig, STEPS_MM, seed)):
        pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k : k + 2]]
        found = deflected(
            found, cameras[k + 1], pair, points, first.clamp, PUBLISHED
        ).camera
    return found


@lru_cache(maxsize=16)
def placed_bust(rig, seed):
    """(T_camera_bust, T_camera_plane), each (4, 4) and read-only.

    The bust is held like a board, with its middle where a board's is. The plane is half
    way into the relief, with errors of placing by hand.
    """
    rng = np.random.default_rng([seed, BUST_OF_SEED])
    T = rig.board_pose(rng, BACK_PROJECTION_MM, (DEFLECTION_MM,))
    T_bust = T @ pose(np.eye(3), [*np.ptp(rig.board.points(), axis=0) / 2, 0])
    viewpoint = transform(T_bust, np.array([[0.0, 0.0, -1.0]]))[0]
    facing = facing_plane(T_bust, viewpoint, BUST.relief / 2)
    turn = rotation_from_vector(rng.normal(0, PLANE_TURN, 3))
    T_plane = facing @ pose(turn, rng.normal(0, PLANE_MM, 3))
    for placed in (T_bust, T_plane):
        placed.setflags(write=False)
    return T_bust, T_plane


def left_by_plane(camera, true, T_bust, T_plane):
    """Distortion of landmarks in the image and in the view over the plane.

    camera: the one that corrects; true: the one that took the image. Either image is
    mapped to the view's own pinhole image of the face by the least-squares homography.
    raw_px and corrected_px: RMS of the remainder, px of that image.
    """
    _, points = BUST.landmarks()
    points = transform(T_bust, points)
    pixels, seen = true.project(points)
    seen &= true.in_image(pixels)
    size = np.array(BUST.size)
    view = view_of_plane(camera, T_plane, PER_PX, -size / 2, size)
    shown = shown_in_view(
        camera, view, np.where(seen[:, None], pixels, np.nan), T_plane
    )
    seen &= np.isfinite(shown).all(axis=1)
    if np.count_nonzero(seen) < MIN_N_LANDMARKS:
        raise InputError(f"face: {np.count_nonzero(seen)} landmarks are visible")
    ideal = view_pixels(view, points[seen])
    return {
        "raw_px": off_homography(pixels[seen], ideal),
        "corrected_px": off_homography(shown[seen], ideal),
    }


def off_homography(image, ideal):
    """RMS, px of `ideal`, that the best homography from an image leaves."""
    H = refine_homography(homography_dlt(image, ideal), image, ideal)
    off = apply_homography(H, image) - ideal
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


# Distortion correction of a circle on a board at four stages (Table 5.6).
#
# The mirror is calibrated as in 5.3.3. At each stage the target is held at 400 mm. The
# tested camera estimates its pose from the corners. The circle's points are where rays
# meet the plane in that pose.


# Spacing of the pixels whose rays are compared, as a fraction of the image's width:
# 168 px of 3072, about as many rays as the thesis's 168 (Table 5.3).
COMPARED = 168 / 3072


class CircleScope(NamedTuple):
    """Extent of a run: number of deflections, whether the face and the true mirror."""

    steps: int = len(STAGES_MM) - 1
    face: bool = True
    true: bool = True


class RingSight(NamedTuple):
    """Image of the target at a stage.

    T_camera_board: (4, 4), true; corners: (182, 2) px with errors, NaN where hidden or
    under the ring; line: (PLACES, 2) px of the circle, with errors.
    """

    T_camera_board: np.ndarray
    corners: np.ndarray
    line: np.ndarray


def correction_trial(condition, rng, errors, line_px, benches, scope):
    """Every measure of a run at each of some error levels, with the same draws.

    errors: MirrorErrors, line_px: (n,) px, by geometry; scope: CircleScope. Equal
    levels are run once.
    """
    geometry, seed = condition["geometry"], int(rng.integers(2**32))
    rig = mirror_rig(geometry)
    found = {
        bench: corrected(
            rig, bench, errors[geometry].on(bench), line_px[geometry], seed, scope
        )
        for bench in dict.fromkeys(benches.values())
    }
    return {name: found[bench] for name, bench in benches.items()}


def corrected(rig, bench, errors, line_px, seed, scope):
    """Circle and face at one level; `refused`: code of the error that ended it."""
    rng = np.random.default_rng(seed)
    uneven = {"aberration_um": bench.aberration_um, "seed": seed}
    stages = STAGES_MM[: scope.steps + 1]
    cameras = [rig.camera(deflection, **uneven) for deflection in stages]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    sights = [
        sight(rig, camera, k, errors, line_px, seed) for k, camera in enumerate(cameras)
    ]
    out = {
        "picture": {
            f"stage{k}": of_image(cameras[k], seen) for k, seen in enumerate(sights)
        }
    }
    if scope.face:
        pushes = [cameras[0], *(rig.camera(d, **uneven) for d in STEPS_MM[1:])]
        out["face"] = face_scores(rig, pushes, first, errors, seed)
    if scope.true:
        out["true"] = by_stage(rig, cameras, cameras, sights)
    found, published = first.camera, {}
    out["published"] = published
    try:
        published |= by_stage(rig, [found], cameras, sights)
        for k, T in enumerate(boards(rig, stages, seed), start=1):
            pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
            found = deflected(
                found, cameras[k], pair, rig.board.points(), first.clamp, PUBLISHED
            ).camera
            published[f"stage{k}"] = scored(rig, found, cameras[k], sights[k])
    except InputError as refusal:
        out["refused"] = refusal.code
    return out


def by_stage(rig, cameras, true, sights):
    """{stage: scores}, for as many stages as there are cameras."""
    return {
        f"stage{k}": scored(rig, camera, true[k], sights[k])
        for k, camera in enumerate(cameras)
    }


def sight(rig, camera, k, errors, line_px, seed):
    """RingSight of the target in a true camera at stage k."""
    rng = np.random.default_rng([seed, k])
    ring = ring_on(rig.board)
    T = held(rig, STAGES_MM[k], seed)
    corners = seen_board(rig, camera, T, errors, rng)
    corners[~off_ring(rig.board)] = np.nan
    exact, normals, _ = circle_outline(camera, T, ring.centre, RADIUS_MM, PLACES)
    off = line_px[rng.integers(len(line_px), size=PLACES)]
    return RingSight(T, corners, exact + off[:, None] * normals)


class CircleOnBoard(NamedTuple):
    """The corrected circle on the board, in the estimated pose.

    T_camera_board: (4, 4), estimated; points: (PLACES, 2) mm, NaN without a ray;
    used: (PLACES,); fit: the best circle of the points used.
    """

    T_camera_board: np.ndarray
    points: np.ndarray
    used: np.ndarray
    fit: object


def on_board(rig, camera, sight):
    """The CircleOnBoard of a RingSight."""
    corners = camera.rays(sight.corners)
    T = pose_from_non_central_rays(corners, rig.board.points()).T_camera_grid
    points = points_on_plane(camera, sight.line, T).points
    used = np.isfinite(points).all(axis=1)
    if np.count_nonzero(used) < PLACES / 4:
        raise CalibrationError(
            f"circle: {np.count_nonzero(used)} of {PLACES} points have rays"
        )
    return CircleOnBoard(T, points, used, fit_circle(points[used]))


def scored(rig, camera, true, sight):
    """Scores of the corrected circle, of the pose and of the rays."""
    found, points = on_board(rig, camera, sight), rig.board.points()
    used, circle = found.used, found.fit
    placed = points_on_plane(camera, sight.line, sight.T_camera_board).points
    of_pose = fit_circle(placed[used])
    profile = np.full(PLACES, np.nan)
    profile[used] = circle.residuals
    middle = [*points.mean(axis=0), 0, 1]
    moved = (found.T_camera_board - sight.T_camera_board) @ middle
    size = np.abs(circle.residuals)
    scores = {
        "radius_mm": circle.radius,
        "residual_mm": float(size.mean()),
        "residual_sd_mm": float(size.std(ddof=1)),
        "true_pose_radius_mm": of_pose.radius,
        "pose_mm": float(np.linalg.norm(moved)),
        "profile": profile,
    }
    if camera is true:
        return scores
    compared = lattice(true, round(COMPARED * true.width))
    angles = ray_angles(camera, true, compared)
    return scores | {"angle_deg": float(np.nanmean(angles))}


def of_image(true, sight):
    """Mean distance of the circle from a conic in the image.

    The conic of least algebraic error, as in 5.3.4, and distances from it; also in an
    image without the lens's distortion, by the true viewer.
    """
    out = {}
    seen = sight.line[np.isfinite(sight.line).all(axis=1)]
    viewer = true.viewer
    central = viewer.rays(seen).directions
    ideal = central[:, :2] / central[:, 2:] * viewer.K[0, 0]
    for name, pixels in (("conic_px", seen), ("conic_no_lens_px", ideal)):
        off, _ = conic_distances(algebraic_conic(pixels), pixels)
        out[name] = float(np.abs(off).mean())
    return out


# Images of the target and of the face in the mirror (Figs. 5.14 to 5.19).
#
# They have 768 x 576 px and are rendered by the simulator. Corners and both edges of
# the circle are measured in them. The mirror is that of the primary level, calibrated
# as published with errors drawn as for the tables.


# A pixel of the small rig is as wide as four of the camera's.
COARSER = 4
# px about a corner that are fitted.
CORNER_WINDOW = 9


class ImageSizes(NamedTuple):
    """Sizes of the images.

    coarser: width of a px in px of the small rig; across_px: fitted on either side of
    an edge; px_mm: mm per px of corrected images; calibrated: whether the mirror is
    that of the primary level and calibrated, or smooth with the true one correcting.
    """

    coarser: int = 1
    across_px: float = 3.0
    px_mm: float = 0.5
    calibrated: bool = True


class ImageScene(NamedTuple):
    """Rigs and random draws of a run.

    rig, small: the MirrorRig that calibrates and the one that takes images; uneven: of
    `MirrorRig.camera`; seed: integer, of waves and poses; coarser: width of an image's
    px in px of the camera.
    """

    rig: MirrorRig
    small: MirrorRig
    uneven: dict
    seed: int
    coarser: int


def scene_of(rng, sizes):
    """The ImageScene at the primary level."""
    seed = int(rng.integers(2**32))
    height = BENCHES[LEVEL].aberration_um if sizes.calibrated else 0.0
    uneven = {"aberration_um": height, "seed": seed}
    small = with_wider_pixels(mirror_rig("A", small=True), sizes.coarser)
    return ImageScene(mirror_rig("A"), small, uneven, seed, COARSER * sizes.coarser)


def with_wider_pixels(rig, times):
    """A MirrorRig whose camera has fewer pixels, `times` as wide."""
    if times == 1:
        return rig
    camera = rig.rig.camera
    viewer = coarser_viewer(camera.viewer, times)
    camera = FlexibleMirrorCamera(**camera.arguments() | {"viewer": viewer})
    return replace(rig, rig=replace(rig.rig, camera=camera))


def coarser_viewer(viewer, times):
    """A PerspectiveCamera whose pixels are `times` as wide."""
    K = viewer.K / times
    K[:2, 2] = (viewer.K[:2, 2] - (times - 1) / 2) / times
    K[2, 2] = 1
    size = viewer.width // times, viewer.height // times
    return PerspectiveCamera(K, viewer.radial, *size)


def coarser(camera, times):
    """A SplineMirrorCamera for images whose pixels are `times` as wide."""
    return SplineMirrorCamera.on_grid(
        coarser_viewer(camera.viewer, times),
        camera.grid,
        camera.coefficients.ravel("F"),
        camera.quantity,
    )


def ring_images_trial(condition, rng, errors, sizes):
    """Render, measure and correct the target at each stage, at the primary level.

    Corrected by the true mirror and as published; `refused`: code of the error that
    ended the run.
    """
    scene = scene_of(rng, sizes)
    cameras = [scene.small.camera(d, **scene.uneven) for d in STAGES_MM]
    seen = [
        rendered_sight(scene, camera, deflection, sizes, rng)
        for camera, deflection in zip(cameras, STAGES_MM, strict=True)
    ]
    out = {
        "picture": {
            f"stage{k}": of_image(cameras[k], sight) | {"grey": image}
            for k, (sight, image) in enumerate(seen)
        },
        "true": {
            f"stage{k}": pictured(scene.rig, camera, camera, seen[k][0])
            for k, camera in enumerate(cameras)
        },
    }
    published, found = [], []
    try:
        for camera in as_published(scene, errors, rng, sizes):
            k = len(published)
            published.append(pictured(scene.rig, camera, cameras[k], seen[k][0]))
            found.append(camera)
    except InputError as refusal:
        out["refused"] = refusal.code
    out["published"] = {f"stage{k}": of_stage for k, of_stage in enumerate(published)}
    # The last stage's image, by the true mirror where no calibration reached it.
    corrects = found[-1] if len(found) == len(cameras) else cameras[-1]
    return {LEVEL: out | {"corrected": laid_out(scene, corrects, *seen[-1], sizes)}}


def rendered_sight(scene, camera, deflection, sizes, rng):
    """(RingSight, image (h, w)) of the target at a stage, measured in the image.

    Its line is the middle of both edges in the image, on the board within 0.03 mm of
    the circle.
    """
    rig, T = scene.small, held(scene.rig, deflection, scene.seed)
    window = mirror_window(camera)
    image = np.zeros((camera.height, camera.width), np.uint8)
    image[window.place] = photographed(rig, camera, T, rng, window)
    outlines = ring_outlines(rig, camera, T, PLACES)
    edges = ring_edges(rig, outlines, image[window.place], window, sizes.across_px)
    # Two unused numbers keep the random draws of later stages.
    rng.random(2)
    corners = corners_in(rig, camera, T, image)
    return RingSight(T, corners, edges.pixels.mean(axis=0)), image


def corners_in(rig, true, T_camera_board, image):
    """Pixels (N, 2) of the corners clear of the ring, NaN where none was found."""
    near, seen = rig.corners(true, T_camera_board)
    rows = np.flatnonzero(seen & off_ring(rig.board))
    found = np.full(near.shape, np.nan)
    got = saddle_point(image, near[rows], window=CORNER_WINDOW)
    found[rows[got.converged]] = got.corners[got.converged]
    return found


def as_published(scene, errors, rng, sizes):
    """Yield the calibrated cameras of stages 0, 1, ..., for the small images."""
    if not sizes.calibrated:
        return
    rig = scene.rig
    cameras = rig.stages(**scene.uneven)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    found, points = first.camera, rig.board.points()
    yield coarser(found, scene.coarser)
    for k, T in enumerate(boards(rig, STAGES_MM, scene.seed), start=1):
        pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
        found = deflected(
            found, cameras[k], pair, points, first.clamp, PUBLISHED
        ).camera
        yield coarser(found, scene.coarser)


def pictured(rig, camera, true, sight):
    """Scores of the circle in an image, and data of Figs. 5.14 to 5.17."""
    found = on_board(rig, camera, sight)
    return scored(rig, camera, true, sight) | {
        "line_px": sight.line[found.used],
        "points_mm": found.points[found.used],
        "residuals_mm": found.fit.residuals,
        "centre_mm": found.fit.centre,
    }


def laid_out(scene, camera, sight, image, sizes):
    """An image rectified to the board, in the pose that the camera estimates."""
    board, pitch = scene.rig.board.points(), scene.rig.board.pitch_mm
    T = on_board(scene.rig, camera, sight).T_camera_board
    corner, size = board.min(axis=0) - pitch, np.ptp(board, axis=0) + 2 * pitch
    return plane_image(camera, image, T, corner, size, sizes.px_mm)[0]


def face_image_trial(condition, rng, errors, sizes):
    """The bust in the mirror and the view over a plane, with its landmarks in both.

    Where the mirror is not calibrated the true one corrects.
    """
    scene = scene_of(rng, sizes)
    camera = scene.small.camera(STEPS_MM[-1], **scene.uneven)
    T_bust, T_plane = placed_bust(scene.rig, scene.seed)
    laboratory = replace(scene.small.rig, camera=camera).laboratory()
    image = laboratory.render(BUST.scene(T_bust), np.eye(4), rng)
    found = camera
    if sizes.calibrated:
        try:
            found = coarser(pushed_as_published(scene, errors, rng), scene.coarser)
        except InputError:
            found = camera
    size = np.array(BUST.size)
    view = view_of_plane(found, T_plane, sizes.px_mm, -size / 2, size)
    shown, _ = view_over_plane(found, image, view, T_plane)
    _, landmarks = BUST.landmarks()
    landmarks = transform(T_bust, landmarks)
    return {
        "picture": image,
        "corrected": shown,
        "ideal_px": view_pixels(view, landmarks),
        "calibrated": found is not camera,
    }


def pushed_as_published(scene, errors, rng):
    """The calibrated SplineMirrorCamera after the push."""
    rig = scene.rig
    cameras = [rig.camera(deflection, **scene.uneven) for deflection in STEPS_MM]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    return pushed_to_face(rig, cameras, first, errors, scene.seed, rng)
