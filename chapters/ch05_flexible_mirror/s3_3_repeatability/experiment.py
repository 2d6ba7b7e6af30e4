"""Trials of this page, their conditions and constants."""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.spatial import ConvexHull

from chapters.shared.mirror import (
    ABERRATION_UM,
    BACK_PROJECTION_MM,
    BENCHES,
    CLAMP_PICKS,
    CLAMP_SD_PX,
    COMPARED_PX,
    CORNER_PX,
    DECODED_MM,
    LEVEL,
    PUBLISHED,
    STAGES_MM,
    GaussianErrors,
    back_projection,
    board_image,
    calibrated_viewer,
    decoded,
    deflected,
    lattice,
    lengths,
    load_height,
    mirror_rig,
    outline,
    poses_in_platter,
    primary,
    ray_angles,
    seen_board,
    shape_name,
)
from chapters.shared.run_times import timed
from raxel.calibration import (
    MirrorSettings,
    MirrorTracker,
    VideoTracker,
    clamp_line,
    clamped,
    fixed_line,
    normalised,
    orthogonality_rows,
    pose_from_non_central_rays,
    primary_from_points,
    refine_shape,
    reflection_normals,
    update_from_scene,
)
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import intersect_rays_plane, inverse_pose, on_plane, transform
from raxel.sets import Chessboard

# Three deflections out and three back, and one step all the way back (Table 5.5).
#
# On the way out, the board has another pose at each deflection. On the way back it is
# fixed, so that the same images also calibrate from stage 3 to stage 0 in one step.


# Stages that the mirror goes through.
LOOP = (0, 1, 2, 3, 2, 1, 0)
OUT = 3  # steps of the loop that go out


def loop(rig, bench, errors, seed):
    """Six steps and the single one; `refused` is the code of a rejection."""
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    boards, stay = boards_of_loop(rig, rng)
    scored = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[:1])

    def step(before, start, end, T):
        """MirrorUpdate of one step, and how far it was found to go."""
        images = [seen_board(rig, cameras[k], T, errors, rng) for k in (start, end)]
        stage = deflected(
            before, cameras[end], images, rig.board.points(), first.clamp, PUBLISHED
        )
        return stage, travelled(rig, before, stage, cameras[start], cameras[end])

    def back(camera, k):
        T = scored
        if k:
            T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels = seen_board(rig, cameras[k], T, errors, rng)
        own = back_projection(camera, pixels, rig.board.points())
        true = back_projection(camera, pixels, rig.board.points(), T)
        off = ray_angles(camera, cameras[k], lattice(cameras[k], COMPARED_PX))
        return {
            "angle_deg": float(np.nanmean(off)),
            "back_mm": float(lengths(own).mean()),
            "back_sd_mm": float(lengths(own).std(ddof=1)),
            "back_true_mm": float(lengths(true).mean()),
            "own": own,
        }

    out = {"board_mm": rig.board.points(), "start": back(first.camera, 0)}
    camera, reached = first.camera, {}
    for number, T in enumerate([*boards, *(stay,) * OUT]):
        start, end = LOOP[number : number + 2]
        try:
            stage, found = step(camera, start, end, T)
            out[f"step{number + 1}"] = found | back(stage.camera, end)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}
        camera = reached[number + 1] = stage.camera
    try:
        stage, found = step(reached[OUT], LOOP[OUT], LOOP[-1], stay)
        return out | {"single": found | back(stage.camera, LOOP[-1])}
    except CalibrationError as refusal:
        return out | {"single_refused": refusal.code}


def boards_of_loop(rig, rng):
    """Boards of the three steps out, and the one that stays on the way back."""
    out = [rig.board_pose(rng, deflections=STAGES_MM[k : k + 2]) for k in range(OUT)]
    return out, rig.board_pose(rng, deflections=STAGES_MM)


def travelled(rig, before, stage, start, end):
    """How far the load was found to go, mm, linearly and finally, without sign."""
    height = load_height(rig, before, start)
    residuals = stage.residuals[np.isfinite(stage.residuals)]
    return {
        "linear_mm": abs(load_height(rig, stage.linear, end) - height),
        "deflection_mm": abs(load_height(rig, stage.camera, end) - height),
        "residual_mm": float(residuals.mean()),
        "residual_sd_mm": float(residuals.std(ddof=1)),
        "swing_deg": stage.swing_deg,
        "common": len(residuals),
    }


# Covered mirror and condition of the data matrix at each step of the loop.
#
# The loop is that of Table 5.5: a board in another pose at each step out, one fixed
# board on the way back. The boards are the same at each error level.


def conditioning_trial(condition, rng, errors, benches):
    """Both measures of every step, at each of some error levels."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    out, stay = boards_of_loop(rig, rng)
    of_rig, boards = errors[condition["geometry"]], [*out, *(stay,) * OUT]
    return {
        name: visible_in_steps(rig, bench, of_rig.on(bench), boards, seed)
        for name, bench in benches.items()
    }


def visible_in_steps(rig, bench, errors, boards, seed):
    """{step: {covered, reciprocal}} of a loop; `refused` is the code of a rejection.

    covered: share of the sheet within the convex hull of the common corners, where they
    are seen after the step; reciprocal: smallest over largest singular value of the
    equilibrated data matrix of the linear stage (5.22, 5.23).
    """
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    before, found = first.camera, {}
    for number, T in enumerate(boards, 1):
        ends = [cameras[stage] for stage in LOOP[number - 1 : number + 1]]
        images = [seen_board(rig, camera, T, errors, rng) for camera in ends]
        try:
            stage = deflected(
                before, ends[1], images, rig.board.points(), first.clamp, PUBLISHED
            )
        except CalibrationError as refusal:
            return found | {"refused": refusal.code}
        common = [pixels[stage.used] for pixels in images]
        found[f"step{number}"] = {
            "swing_deg": stage.swing_deg,
            "covered": covered_share(ends[1], common[1]),
            "reciprocal": reciprocal_condition(
                before, stage.linear, common, first.clamp
            ),
        }
        before = stage.camera
    return found


def covered_share(true, pixels):
    """Share of a true camera's sheet that the hull of what pixels (N, 2) see covers."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    mirror = true.mirror
    # In two dimensions `volume` is the hull's area.
    return float(
        ConvexHull(points[:, :2]).volume / (2 * mirror.half_width * mirror.end)
    )


def reciprocal_condition(before, linear, common, clamp):
    """Of the matrix that a linear stage solved, in the clamp's subspace.

    before: the camera before the step; linear: what the stage gave; common: pixels
    (N, 2) of the common corners before and after.
    """
    p = normalised(linear.viewer, common[1])
    viewing = np.column_stack([p, np.ones(len(p))])
    normals = reflection_normals(viewing, before.rays(common[0]).directions)
    rows = orthogonality_rows(p, normals, linear.grid, linear.quantity)
    rows = rows @ clamped(linear.grid, clamp).directions
    size = np.linalg.svd(rows / np.linalg.norm(rows, axis=0), compute_uv=False)
    return float(size[-1] / size[0])


# A film of a mirror that bends and returns, and a calibration that follows it.
#
# The rig is A with a quarter of the pixels in each direction, so that all images can be
# rendered. Camera and first shape are calibrated as in 5.3.3, with Gaussian errors. The
# board is fixed.


COARSER = 4  # a pixel of the small rig is as wide as four of the camera's
# px between the pixels of the first shape, and between those whose rays are compared.
DECODED_STEP_PX, FILM_COMPARED_PX = 16, 24
ERRORS = GaussianErrors(CORNER_PX / COARSER, DECODED_MM)
METHOD = MirrorSettings(noise_px=CORNER_PX / COARSER, prior_sd=0.1)
# Places along and across the sheet at which a found shape is kept to be drawn.
ALONG, ACROSS = 33, 9
KEPT = 0.5  # images are stored at half the size
TIMED_MM = 0.5


class FilmedMirror(NamedTuple):
    """rig: MirrorRig; deflections (n,) mm; cameras: the true ones, an image each;
    T_camera_board (4, 4); first: SplineMirrorCamera of the first shape; clamp:
    FixedLine."""

    rig: object
    deflections: np.ndarray
    cameras: list
    T_camera_board: np.ndarray
    first: object
    clamp: object


def film_trial(condition, rng):
    """Render each image, detect its corners from those before, and track the shape.

    In the first image corners are searched for at their true positions, as if picked by
    hand; in all others where optical flow predicts them.
    """
    film = drawn_film(**condition, rng=rng)
    rig, board = film.rig, film.rig.board
    taken = [
        board_image(rig, camera, film.T_camera_board, rng) for camera in film.cameras
    ]
    picked, seen = rig.corners(film.cameras[0], film.T_camera_board)
    first = taken[0].corners(np.where(seen[:, None], picked, np.nan))
    images = [whole_image(rig, one) for one in taken]
    tracker = tracker_of(film, first)
    following = VideoTracker(tracker, images[0], first, board.columns, board.rows)
    frames = [frame(film, 0, tracker, images[0], first, tracker.follow(first))]
    for k in range(1, len(images)):
        corners, shape = following.follow(images[k])
        frames.append(frame(film, k, tracker, images[k], corners.corners, shape))
    found = {name: np.stack([frame[name] for frame in frames]) for name in frames[0]}
    start = load_height(rig, film.first, film.cameras[0])
    return found | {
        "true_mm": film.deflections,
        "found_mm": found.pop("height_mm") - start,
        "T_camera_board": film.T_camera_board,
    }


def drawn_film(steps, peak_mm, rng):
    """The FilmedMirror of a load that goes out to `peak_mm` in so many steps, and back.

    It starts, reverses and stops smoothly, like a crank.
    """
    rig = mirror_rig("A", small=True)
    deflections = peak_mm * np.sin(np.pi / 2 * np.linspace(0, 2, 2 * steps + 1)) ** 2
    cameras = [rig.camera(float(deflection)) for deflection in deflections]
    T = rig.board_pose(rng, deflections=STAGES_MM)
    return FilmedMirror(
        rig, deflections, cameras, T, *first_shape(rig, cameras[0], rng)
    )


def first_shape(rig, camera, rng):
    """(SplineMirrorCamera, FixedLine) of the mirror before the film.

    Its knots span the mirror's outline: flat, it fills more of the image than bent.
    """
    viewer = calibrated_viewer(rig, ERRORS, rng)
    monitor = rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, monitor, ERRORS, rng)
    picks = rig.clamp_pixels(camera, CLAMP_PICKS, rng, CLAMP_SD_PX / COARSER)
    line = clamp_line(viewer, picks)
    found = primary_from_points(
        viewer,
        *decoded(rig, camera, monitor, ERRORS, rng, DECODED_STEP_PX),
        poses,
        shape=METHOD.shape,
        angle=line.angle,
        quantity="inverse depth",
        span=np.vstack([line.points(CLAMP_PICKS), normalised(viewer, outline(camera))]),
    )
    return found.camera, fixed_line(found.camera, line)


def tracker_of(film, pixels):
    """A MirrorTracker whose board's pose comes from the first shape and the first
    image's corners (N, 2)."""
    points = film.rig.board.points()
    pose = pose_from_non_central_rays(film.first.rays(pixels), points)
    placed = transform(pose.T_camera_grid, on_plane(points))
    return MirrorTracker(film.first, placed, film.clamp, METHOD)


def frame(film, k, tracker, image, corners, followed):
    """Stored values of image k: its errors, and what is drawn."""
    camera, found = film.cameras[k], tracker.camera_now()
    off = ray_angles(found, camera, lattice(camera, FILM_COMPARED_PX))
    return {
        "height_mm": load_height(film.rig, found, camera),
        "angle_deg": np.nanmean(off),
        "used": np.count_nonzero(followed.used),
        "picture": cv2.resize(
            image, None, fx=KEPT, fy=KEPT, interpolation=cv2.INTER_AREA
        ),
        "corners": np.where(followed.used[:, None], corners, np.nan),
        **mirror_shape(camera, found),
    }


def whole_image(rig, taken):
    """The camera's whole image of a MirroredBoard; outside the mirror it is dark."""
    whole = np.zeros((rig.viewer.height, rig.viewer.width), np.uint8)
    (height, width), window = taken.image.shape, taken.window
    whole[window.v : window.v + height, window.u : window.u + width] = taken.image
    return whole


def mirror_shape(true, found):
    """Points (ACROSS, ALONG, 3) of the found mirror, viewer's frame, on the viewing
    rays of places all over the true one, and the directions of their scene rays; and
    the profile (ALONG, 2), mm along the flat sheet and above it."""
    x, y = np.meshgrid(
        true.mirror.end * np.linspace(0.005, 0.995, ALONG),
        true.mirror.half_width * np.linspace(-0.99, 0.99, ACROSS),
    )
    z = true.mirror.height(x.ravel(), y.ravel())[0]
    sheet = np.column_stack([x.ravel(), y.ravel(), z])
    places = transform(true.T_viewer_mirror, sheet)
    rays = found.rays(true.viewer.project(places).pixels)
    flat = transform(inverse_pose(true.T_viewer_mirror), rays.origins)
    return {
        "mirror": rays.origins.reshape(ACROSS, ALONG, 3),
        "directions": rays.directions.reshape(ACROSS, ALONG, 3),
        "profile": flat.reshape(ACROSS, ALONG, 3)[ACROSS // 2][:, [0, 2]],
    }


def update_seconds():
    """Seconds of one update of the shape from the corners of an image, timed now."""
    rng = np.random.default_rng(0)
    film = drawn_film(1, TIMED_MM, rng)
    first, second = (
        seen_board(film.rig, camera, film.T_camera_board, ERRORS, rng)
        for camera in film.cameras[:2]
    )
    tracker = tracker_of(film, first)
    return timed(lambda: tracker.follow(second))


# Number of corners that both images of a deflection show.


# How far the mirror goes, mm: back from stage 3, as in the thesis's large deflection,
# and out from stage 0.
DEFLECTIONS_MM = (2.5, 5.0, 7.5, 10.0, 12.5, 15.0)


def losses_trial(condition, rng):
    """Corners (deflections,) that are visible before and after, of a board in a random
    pose that the mirror shows before the deflection: `back` and `out`."""
    rig = mirror_rig(condition["geometry"])
    ways = {
        "back": (STAGES_MM[-1], [STAGES_MM[-1] - mm for mm in DEFLECTIONS_MM]),
        "out": (STAGES_MM[0], [STAGES_MM[0] + mm for mm in DEFLECTIONS_MM]),
    }
    found = {}
    for way, (start, ends) in ways.items():
        T = rig.board_pose(rng, deflections=(start,))
        _, before = rig.corners(rig.camera(start), T)
        after = [rig.corners(rig.camera(end), T)[1] for end in ends]
        found[way] = np.array([np.count_nonzero(before & seen) for seen in after])
    return found


# The loop with the board's known metric, and without it (5.3.3).
#
# The pose of the board comes from the camera before each step. With the metric its
# corners are those of a board in that pose. Without it each corner is where the
# camera's own ray meets the board's plane: then the next shape inherits all errors of
# the camera, not only those that a rigid board can follow. Nothing else differs:
# images, clamp, linear stage and refinement are the same.


ARMS = ("metric", "without")


def metric_trial(condition, rng, errors):
    """Errors after each of six steps, with the metric and without."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    bench = BENCHES[LEVEL]
    errors = errors[condition["geometry"]].on(bench)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    out, stay = boards_of_loop(rig, rng)
    images = [
        [
            seen_board(rig, cameras[stage], T, errors, rng)
            for stage in LOOP[number : number + 2]
        ]
        for number, T in enumerate([*out, *(stay,) * OUT])
    ]
    scored = []
    for camera, deflection in zip(cameras, STAGES_MM, strict=True):
        T = rig.board_pose(rng, BACK_PROJECTION_MM, (deflection,))
        scored.append(seen_board(rig, camera, T, errors, rng))
    return {arm: steps_of(rig, cameras, first, images, scored, arm) for arm in ARMS}


def steps_of(rig, cameras, first, images, scored, arm):
    """{step: errors} of one arm; `refused` is the code of a rejection."""
    camera, board, found = first.camera, rig.board.points(), {}
    for number, (before, after) in enumerate(images, 1):
        stage, true = LOOP[number], cameras[LOOP[number]]
        try:
            scene = scene_points(camera, before, board, arm)
            camera = update_from_scene(
                camera, after, scene, first.clamp, PUBLISHED.settings,
                outline=outline(true),
            ).camera  # fmt: skip
            pixels = scored[stage]
            own = back_projection(camera, pixels, board)
        except CalibrationError as refusal:
            return found | {"refused": refusal.code}
        off = ray_angles(camera, true, lattice(true, COMPARED_PX))
        found[f"step{number}"] = {
            "back_mm": float(lengths(own).mean()),
            "angle_deg": float(np.nanmean(off)),
        }
    return found


def scene_points(camera, pixels, board, arm):
    """Corners (N, 3), viewer's frame, mm, estimated by a camera, NaN if not visible.

    pixels: (N, 2) before the step; board: (N, 2) mm; arm: one of ARMS.
    """
    rays = camera.rays(pixels)
    pose = pose_from_non_central_rays(rays, board)
    T = pose.T_camera_grid
    if arm == "metric":
        flat = board
    else:
        flat = intersect_rays_plane(rays.origins, rays.directions, T).points
    placed = transform(T, on_plane(flat))
    return np.where(pose.inliers[:, None], placed, np.nan)


# What the place of the board does to a deflection, at two pitches.
#
# The mirror, its primary calibration and the error of every corner stay; the board is
# held elsewhere, time after time. The board of half the pitch has the other's corners
# among its own, with the same errors.


PLACES = 5
# Stages before and after: the first step of Table 5.5.
BEFORE, AFTER = 0, 1


def in_all_places(rig, bench, errors, seed):
    """{pitch: deflections (PLACES,) mm}, NaN where rejected, and their number."""
    rng = np.random.default_rng(seed)
    ends = STAGES_MM[BEFORE], STAGES_MM[AFTER]
    cameras = [
        rig.camera(mm, aberration_um=bench.aberration_um, seed=seed) for mm in ends
    ]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    boards = boards_of_pitches(rig.board)
    every = len(boards["dense"][0])
    off = [errors.corners(np.zeros((every, 2)), rng) for _ in cameras]
    poses = [rig.board_pose(rng, deflections=ends) for _ in range(PLACES)]

    def deflection(T, points, kept):
        images = [
            visible_points(camera, T, points) + shift[kept]
            for camera, shift in zip(cameras, off, strict=True)
        ]
        try:
            stage = deflected(
                first.camera, cameras[1], images, points, first.clamp, PUBLISHED
            )
        except CalibrationError:
            return np.nan
        return travelled(rig, first.camera, stage, *cameras)["deflection_mm"]

    found = {
        pitch: np.array([deflection(T, *board) for T in poses])
        for pitch, board in boards.items()
    }
    rejected = {
        f"refused_{pitch}": int(np.isnan(mm).sum()) for pitch, mm in found.items()
    }
    return found | rejected


def boards_of_pitches(board):
    """{pitch: (points (N, 2) mm, which (N,) of the dense board's they are)}."""
    columns, rows = 2 * board.columns - 1, 2 * board.rows - 1
    points = Chessboard(columns, rows, board.pitch_mm / 2).points()
    coarse = np.arange(columns * rows).reshape(rows, columns)[::2, ::2].ravel()
    return {"coarse": (points[coarse], coarse), "dense": (points, slice(None))}


def visible_points(camera, T_camera_board, points):
    """Pixels (N, 2) of points (N, 2) mm of a board, exact; NaN where not seen."""
    pixels, valid = camera.project(transform(T_camera_board, on_plane(points)))
    return np.where((valid & camera.in_image(pixels))[:, None], pixels, np.nan)


# Errors of relief that a spline cannot represent, at stage 0, and more knots.
#
# The same viewer, monitor, platter and errors with a smooth mirror and with one with
# relief; the primary stage alone, with several numbers of knots.


FEW, MANY = (7, 3), (14, 9)  # basis functions along u and v
# Four waves of 45 to 110 mm: relief of the first solved level, and none.
RELIEFS_UM = {"smooth": 0.0, "relief": ABERRATION_UM}
RELIEF_COMPARED_PX = 168


def relief_trial(condition, rng, errors):
    """Residuals of the primary stage, back-projection and rays, by mirror and shape."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    errors = errors[condition["geometry"]]
    viewer, true = calibrated_viewer(rig, errors, rng), rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, true, errors, rng)
    T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[:1])
    drawn, found = int(rng.integers(2**32)), {}
    for name, height_um in RELIEFS_UM.items():
        # The same draws before either mirror.
        again = np.random.default_rng(drawn)
        camera = rig.camera(STAGES_MM[0], height_um, seed)
        line = clamp_line(viewer, rig.clamp_pixels(camera, CLAMP_PICKS, again,
                                                   CLAMP_SD_PX))  # fmt: skip
        seen = decoded(rig, camera, true, errors, again)
        corners = seen_board(rig, camera, T, errors, again)
        for shape in (FEW, MANY):
            try:
                calibration = primary_from_points(
                    viewer, *seen, poses, shape=shape, angle=line.angle,
                    quantity=PUBLISHED.quantity, span=line.points(CLAMP_PICKS),
                )  # fmt: skip
            except CalibrationError as refusal:
                found[f"{name}.{shape_name(shape)}"] = {"refused": refusal.code}
                continue
            off = ray_angles(
                calibration.camera, camera, lattice(camera, RELIEF_COMPARED_PX)
            )
            own = back_projection(calibration.camera, corners, rig.board.points())
            found[f"{name}.{shape_name(shape)}"] = {
                "residual_mm": float(calibration.residuals.mean()),
                "back_mm": float(lengths(own).mean()),
                "angle_deg": float(np.nanmean(off)),
            }
    return found


# Refinement started from mirrors that are bent too little or too much.
#
# A stage is calibrated; its linear estimate is then bent more or less, evenly from half
# of the deflection less to half of it more, twisted besides, and refined again with the
# same corners.


STARTS = 6
MAX_BEND = 0.5  # of the deflection, that a start is bent more or less
# Stages before and after: the first step of Table 5.5, and the way back at a stroke.
STEPS = {"5": (0, 1), "15": (3, 0)}
STEPS_MM = {
    name: abs(STAGES_MM[end] - STAGES_MM[start]) for name, (start, end) in STEPS.items()
}


def both_steps(rig, bench, errors, seed):
    """{step: its starts and their ends}; `refused` where there is no stage."""
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    out = {}
    for name, ends in STEPS.items():
        pair = [cameras[k] for k in ends]
        first = primary(rig, pair[0], PUBLISHED, errors, rng)
        T = rig.board_pose(rng, deflections=[STAGES_MM[k] for k in ends])
        images = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        further = STEPS_MM[name] * shares(rng)
        try:
            stage = deflected(
                first.camera, pair[1], images, rig.board.points(), first.clamp,
                PUBLISHED,
            )  # fmt: skip
        except CalibrationError as refusal:
            out[name] = {"refused": refusal.code}
            continue
        once = travelled(rig, first.camera, stage, *pair)
        out[name] = {"deflection_mm": once["deflection_mm"]} | from_starts(
            rig, pair, first, stage, images[1], further
        )
    return out


def shares(rng):
    """How much more each start is bent at the three columns of coefficients across the
    mirror, (STARTS, 3) shares of the deflection, none beyond MAX_BEND."""
    even = np.linspace(-MAX_BEND, MAX_BEND, STARTS)[:, None]
    twist = rng.uniform(-MAX_BEND, MAX_BEND, (STARTS, 1)) * [-1, 0, 1]
    return np.clip(even + twist, -MAX_BEND, MAX_BEND)


def from_starts(rig, pair, first, stage, pixels, further_mm):
    """SD, mm, of the deflections at the ends; NaN where one was rejected.

    pair: true cameras before and after; pixels: (N, 2) of the board after.
    """
    before = load_height(rig, first.camera, pair[0])
    used = stage.used
    p = normalised(stage.camera.viewer, pixels)[used]
    points = transform(stage.pose.T_camera_grid, on_plane(rig.board.points()))[used]
    grid, quantity = stage.camera.grid, stage.camera.quantity
    bent = bending(rig, pair[1], grid, first.clamp)

    def travel(coefficients):
        viewer = stage.camera.viewer
        camera = SplineMirrorCamera.on_grid(viewer, grid, coefficients, quantity)
        return abs(load_height(rig, camera, pair[1]) - before)

    ends = np.full(len(further_mm), np.nan)
    for number, mm in enumerate(further_mm):
        start = np.ravel(stage.linear.coefficients + bent * mm, order="F")
        try:
            fit = refine_shape(
                p, points, grid, quantity, start, noise=1.0, clamp=first.clamp
            )
        except CalibrationError:
            continue
        ends[number] = travel(fit.coefficients)
    return {"sd_mm": float(ends.std(ddof=1))}


def bending(rig, true, grid, clamp):
    """Change (Kf, Kg) of the distances that lifts the free edge by 1 mm along the load.

    It rises with the square of the distance from the clamp, in the image.
    """
    u = grid.knots_u
    degree = grid.degree[0]
    # Where along u a coefficient acts: the mean of the knots inside its support.
    places = np.array([u[i + 1 : i + 1 + degree].mean() for i in range(grid.shape[0])])
    way = np.abs(places - np.median(grid.turned(clamp.points)[:, 0]))
    place = rig.load_point(true)
    along = rig.deflection_direction() @ place / np.linalg.norm(place)
    rise = (way / way.max()) ** 2 / along
    return np.repeat(rise[:, None], grid.shape[1], axis=1)
