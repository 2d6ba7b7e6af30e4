"""Trials of this page, their conditions and constants."""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from scipy.spatial import Delaunay

from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    BENCHES,
    CLAMP_PICKS,
    CLAMP_SD_PX,
    COMPARED_PX,
    PUBLISHED,
    STAGES_MM,
    back_projection,
    board_image,
    deflected,
    lengths,
    linearly_deflected,
    load_height,
    measured_rays,
    mirror_rig,
    platter_camera,
    platter_image,
    platter_window,
    primary,
    ray_angles,
    seen_board,
)
from chapters.shared.mirror import lattice as pixel_lattice
from raxel.calibration import (
    BoardView,
    ClampPicks,
    FlatMirrorImage,
    MirrorViews,
    StepViews,
    calibrate_mirror,
    calibrate_primary,
    calibrate_zhang,
    clamp_line,
    dense_view,
    fixed_line,
    flat_view,
    grid_poses_in_platter,
    labelled_like,
    lattice_of,
    on_one_lattice,
    update_mirror,
)
from raxel.errors import CalibrationError, InputError
from raxel.features import find_board
from raxel.features.active_grid import decode
from raxel.geometry import inverse_pose, on_plane, pose, rotation_from_vector, transform
from raxel.lab import bands as bands_of
from raxel.lab import (
    mirror_window,
    outline_of,
    points_seen,
    render_board,
    render_patterns,
    window_around,
    windowed,
)
from raxel.sets import BLACK, WHITE, Chessboard

# Rendered images of a flexible mirror's calibration, and what is detected in them.
#
# All inputs of a calibration come from images: partly visible boards by the detector,
# the monitor by decoding, the mirror's outline by its brightness. Only the clamp's
# points are picked by hand, with a given error. The truth is used for rendering and for
# the noise of the error level; detection does not use it.


# The board that the camera sees directly: its width as a share of the image's at its
# middle distance, how far that varies, and how it is tilted.
VIEWER_BOARD, VIEWER_SHARE = Chessboard(10, 7, 10.0), 0.4
VIEWER_NEARER, VIEWER_TILT, TRIES = 0.2, np.radians((20, 40)), 500
# Rows of a band of a window that is rendered of the monitor. Of each band the middle
# row counts, where all windows of the decoder are whole, and so many places along it.
BAND_PX, PLACES = 16, 40
# What is lit in an image of the mirror: brighter than this share of its white. Black
# squares are; what lies outside the mirror is not.
LIT, OUTLINE_STEP = 0.15, 40


class MirrorRun(NamedTuple):
    """A rig at an error level. cameras: the true ones of its stages; places: (2, 4, 4),
    true poses of the monitor; boards: (k, 4, 4), of the board at each step."""

    rig: object
    bench: object
    cameras: list
    places: np.ndarray
    boards: list


class RunSizes(NamedTuple):
    """steps: of deflection; boards: images that calibrate the viewer; bands: of the
    mirror and of the platter that show the monitor; small: with the small images of
    the rigs."""

    steps: int
    boards: int
    bands: int
    small: bool


class ReadImages(NamedTuple):
    """views: MirrorViews, all a calibration gets; outlines: for each step, pixels
    (M, 2) around the mirror after it."""

    views: MirrorViews
    outlines: list


def drawn_scene(rig, bench, steps, rng):
    """A MirrorRun with so many steps of deflection."""
    cameras = rig.stages(
        aberration_um=bench.aberration_um, seed=int(rng.integers(2**32))
    )
    boards = [
        rig.board_pose(rng, deflections=STAGES_MM[k : k + 2]) for k in range(steps)
    ]
    return MirrorRun(rig, bench, cameras, rig.monitor_poses(rng), boards)


def read_images(scene, sizes, rng):
    """ReadImages of a MirrorRun with RunSizes. Raises CalibrationError where an
    image shows no board."""
    rig, camera = scene.rig, scene.cameras[0]
    viewer = calibrated_viewer(rig, sizes.boards, rng)
    grids = [
        decoded(scene, camera, mirror_window(camera), sizes.bands, k, rng)
        for k in range(len(scene.places))
    ]
    picks = rig.clamp_pixels(camera, CLAMP_PICKS, rng, CLAMP_SD_PX)
    steps, outlines = [], []
    for k in range(len(scene.boards)):
        step, outline = step_views(scene, k, picks, rng)
        steps.append(step)
        outlines.append(outline)
    platter = rig.platter(rng)
    seen_flat = platter_images(scene, viewer, platter, sizes.bands, rng)
    clamp, thickness = ClampPicks(picks, CLAMP_SD_PX), platter.thickness_mm
    views = MirrorViews(viewer, tuple(grids), seen_flat, thickness, clamp, tuple(steps))
    return ReadImages(views, outlines)


def calibrated_viewer(rig, boards, rng):
    """The perspective camera by Zhang's method, from boards that it sees directly."""
    views = [
        whole_board(*viewer_image(rig, rng), VIEWER_BOARD, f"viewer {k}")
        for k in range(boards)
    ]
    return calibrate_zhang(views, rig.viewer.width, rig.viewer.height).camera


def viewer_image(rig, rng):
    """(image, its `Crop`) of VIEWER_BOARD, wholly visible, at a random position."""
    viewer, board = rig.viewer, VIEWER_BOARD
    taken = replace(rig.rig, camera=viewer, target=board, border_mm=board.pitch_mm)
    size, full = board.pitch_mm * (board.columns + 1), [viewer.width, viewer.height]
    middle = size * viewer.K[0, 0] / (VIEWER_SHARE * viewer.width)
    for _ in range(TRIES):
        depth = middle * rng.uniform(1 - VIEWER_NEARER, 1 + VIEWER_NEARER)
        azimuth, tilt = rng.uniform(0, 2 * np.pi), rng.uniform(*VIEWER_TILT)
        R = rotation_from_vector(
            tilt * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        ) @ rotation_from_vector([0, 0, rng.uniform(0, 2 * np.pi)])
        ray = viewer.rays(rng.uniform(0, full, (1, 2))).directions[0]
        at = depth * ray / ray[2]
        T = pose(R, at - R @ [*board.points().mean(axis=0), 0])
        outline = transform(T, on_plane(outline_of(*taken.extent)))
        pixels, valid = viewer.project(outline)
        if np.all(valid & viewer.in_image(pixels)):
            window = window_around(viewer, pixels)
            return render_board(windowed(taken, window), T, rng, rng), window
    raise RuntimeError(f"geometry {rig.name}: no pose of {TRIES} shows the board")


def whole_board(image, window, board, name):
    """BoardView of a board that is wholly visible in a window of the image."""
    found = find_board(image, board.columns, board.rows)
    if not found.found:
        raise CalibrationError(f"{name}: {found.reason}", code="no-board")
    corners = found.corners + [window.u, window.v]
    size = found.columns, found.rows
    return BoardView(corners, board.points(*size), *size, name, found.sd)


def decoded(scene, camera, window, count, place, rng):
    """DenseView of the monitor in a position, by a camera that sees it in a mirror.

    `count` bands of the window are rendered and decoded one after another. Noise of the
    error level: errors and standard deviations times its factor, where a pixel's own
    ray meets the monitor; other decoded points stay unchanged.
    """
    rig, T, factor = scene.rig, scene.places[place], scene.bench.factor
    location = np.full((camera.height, camera.width, 2), np.nan, np.float32)
    sigma, seed = location.copy(), int(rng.integers(2**32))
    parts = bands_of(window, count, BAND_PX)
    for part, band in enumerate(parts):
        taken = windowed(replace(rig.monitor, camera=camera), band)
        exposures = dict(render_patterns(taken, T, [seed, part]))
        levels = {"white": exposures.pop(WHITE), "black": exposures.pop(BLACK)}
        images = np.array(list(exposures.values()))
        found = decode(images, list(exposures), taken.target, linear=True, **levels)
        true = points_seen(taken.camera, T, taken.target.monitor_mm)
        more = np.where(np.isfinite(true), (factor - 1) * (found.location - true), 0)
        location[band.place] = found.location + more
        sigma[band.place] = factor * found.sigma
    view = dense_view(location, sigma, name=f"monitor {place}")
    rows = [band.v + BAND_PX // 2 for band in parts]
    return thinned(view, rows, max(1, window.width // PLACES))


def thinned(view, rows, step):
    """The DenseView with every step-th pixel of some rows alone."""
    location = np.full_like(view.location, np.nan)
    location[rows, ::step] = view.location[rows, ::step]
    v, u = np.nonzero(np.isfinite(location[..., 0]))
    return view._replace(
        pixels=np.column_stack([u, v]).astype(float),
        points=location[v, u].astype(float),
        columns=len(u), rows=1, sd=None, location=location,
    )  # fmt: skip


def platter_images(scene, viewer, platter, bands, rng):
    """PlatterPictures of the monitor in its positions. The platter is fixed, so one
    image shows its board."""
    rig = scene.rig
    taken = replace(rig.rig, camera=rig.viewer, target=platter.board)
    outline = transform(platter.T_camera_board, on_plane(outline_of(*taken.extent)))
    window = window_around(rig.viewer, rig.viewer.project(outline).pixels)
    part = windowed(taken, window)
    image = platter_image(PartOfRig(part), platter, rng)
    board = whole_board(image, window, platter.board, "platter")
    camera, window = platter_camera(rig, platter), platter_window(rig, platter)
    grids = [
        flat_view(viewer, decoded(scene, camera, window, bands, k, rng))
        for k in range(len(scene.places))
    ]
    return tuple(FlatMirrorImage(board, grid, 0, k) for k, grid in enumerate(grids))


class PartOfRig(NamedTuple):
    """A part of a rig's image, as `platter_image` uses it."""

    rig: object

    @property
    def viewer(self):
        """The camera of that part."""
        return self.rig.camera


def step_views(scene, k, picks, rng):
    """(StepViews, outline after) of step k, from 0."""
    rig, name = scene.rig, f"step {k + 1}"
    lattices = []
    for camera in scene.cameras[k : k + 2]:
        image, window = board_image(rig, camera, scene.boards[k], rng)
        found = lattice_of(find_board(image, rig.board.columns, rig.board.rows))
        if found is None:
            raise CalibrationError(f"{name}: no board in the mirror", code="no-board")
        lattices.append(found._replace(corners=found.corners + [window.u, window.v]))
        outline = lit_outline(image) + [window.u, window.v]
    lattices[1] = labelled_like(*lattices, picks, name)
    names = f"{name} before", f"{name} after"
    views = on_one_lattice(lattices, rig.board, names)
    moved = float(STAGES_MM[k + 1] - STAGES_MM[k])
    return StepViews(*views, moved), outline


def lit_outline(image):
    """Pixels (M, 2) around the bright part of an image (h, w): the mirror's edges."""
    soft = cv2.GaussianBlur(image, (0, 0), 2.0)
    lit = (soft > LIT * np.quantile(soft, 0.99)).astype(np.uint8)
    around = cv2.findContours(lit, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    largest = max(around, key=cv2.contourArea)
    return cv2.convexHull(largest)[:, 0].astype(float)


# A run from images to rays: calibration in two ways, and its errors.
#
# As published, and as `raxel calibrate` does with a user's own images. Both have the
# same views.


RENDERED_COMPARED_PX = 96  # px between the pixels whose rays are compared
FALSE_PX = 2.0  # a corner farther than this from all true ones is false


def rendered_trial(condition, rng, sizes):
    """All measures of one run; `refused`, of the run or of a way, is the code of its
    rejection.

    sizes: RunSizes.
    """
    rig = mirror_rig(condition["geometry"], small=sizes.small)
    scene = drawn_scene(rig, BENCHES[condition["bench"]], sizes.steps, rng)
    try:
        read = read_images(scene, sizes, rng)
    except InputError as refusal:
        return {"refused": refusal.code}
    held_out = scoring_boards(scene, rng)
    return corner_errors(scene, read) | {
        "published": as_published(scene, read, held_out),
        "own": as_a_reader(scene, read, held_out),
    }


def corner_errors(scene, read):
    """Median distance, px, of corners from the nearest true one, and how many are
    false."""
    off = []
    for k, step in enumerate(read.views.steps):
        cameras = scene.cameras[k : k + 2]
        for view, camera in zip((step.before, step.after), cameras, strict=True):
            true, _ = scene.rig.corners(camera, scene.boards[k])
            found = view.pixels[np.isfinite(view.pixels[:, 0])]
            apart = np.linalg.norm(found[:, None] - true[None], axis=2)
            off.append(np.nanmin(apart, axis=1))
    off = np.concatenate(off)
    return {
        "corner_px": float(np.median(off)),
        "false": int(np.count_nonzero(off > FALSE_PX)),
    }


def as_published(scene, read, held_out):
    """Primary stage and each deflection from the one before."""
    views, cameras, out = read.views, [], {}
    try:
        first, held = primary_of_rendered(views)
        cameras.append(first)
        for k, step in enumerate(views.steps, 1):
            stage = update_mirror(
                cameras[-1], step.before.pixels, step.after.pixels, step.before.points,
                held, PUBLISHED.settings, outline=read.outlines[k - 1],
            )  # fmt: skip
            cameras.append(stage.camera)
            residual = {"residual_mm": float(np.nanmean(stage.residuals))}
            out[f"stage{k}"] = residual | scored(scene, k, cameras, held_out)
    except InputError as refusal:
        out["refused"] = refusal.code
    return out


def primary_of_rendered(views):
    """(camera of stage 0, what the clamp holds)"""
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
    line = clamp_line(views.viewer, views.clamp.points)
    found = calibrate_primary(
        views.viewer, views.grids, poses,
        shape=PUBLISHED.shape, angle=line.angle, quantity=PUBLISHED.quantity,
        span=line.points(CLAMP_PICKS),
    )  # fmt: skip
    return found.camera, fixed_line(found.camera, line)._replace(slopes=None)


def as_a_reader(scene, read, held_out):
    """The same as `raxel calibrate` makes of a reader's own set."""
    try:
        found = calibrate_mirror(read.views)
    except InputError as refusal:
        return {"refused": refusal.code}
    return {
        f"stage{k}": {"residual_mm": float(found.residuals_mm(k).mean())}
        | scored(scene, k, found.cameras, held_out)
        for k in range(1, len(found.cameras))
    }


def scoring_boards(scene, rng):
    """(T_camera_board, exact pixels (182, 2)) at 400 mm, for each stage."""
    found = []
    for k in range(len(scene.boards) + 1):
        T = scene.rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels, seen = scene.rig.corners(scene.cameras[k], T)
        found.append((T, np.where(seen[:, None], pixels, np.nan)))
    return found


def scored(scene, k, cameras, held_out):
    """The deflection from stage k - 1 to k, and how far camera k is off the truth."""
    camera, true, (T, pixels) = cameras[k], scene.cameras[k], held_out[k]
    points, rays = scene.rig.board.points(), pixel_lattice(true, RENDERED_COMPARED_PX)
    before, after = (
        load_height(scene.rig, cameras[j], scene.cameras[j]) for j in (k - 1, k)
    )
    own, of_true = (
        lengths(back_projection(camera, pixels, points, where)) for where in (None, T)
    )
    return {
        "deflection_mm": after - before,
        "angle_deg": float(np.nanmean(ray_angles(camera, true, rays))),
        "back_mm": float(own.mean()),
        "back_true_mm": float(of_true.mean()),
    }


# Three deflections of 5 mm, each calibrated from the one before (Tables 5.1 to 5.4).
#
# A board is in front of the mirror, in another pose for each deflection. After each, an
# active grid is decoded in two positions for reference, and a board at 400 mm is used
# for back-projection.


def three_stages(rig, bench, errors, seed):
    """Primary stage and three deflections; `refused` is the code of a rejection.

    A rejected stage keeps its linear estimate, if there is one. The monitor's travel is
    estimated at all stages, since it does not depend on the mirror's shape.
    """
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    misses = first.calibration.mirror.misses
    scene = StageScene(rig, cameras, errors)
    viewer = first.camera.viewer
    anew = [measured_rays(rig, true, viewer, errors, rng) for true in cameras]
    own = measured_rays(rig, cameras[0], viewer, errors, rng, first)
    before, height = first.camera, load_height(rig, first.camera, cameras[0])
    out = {
        "miss_mm": float(np.nanmean(misses)),
        "miss_sd_mm": float(np.nanstd(misses, ddof=1)),
        "points": int(np.count_nonzero(np.isfinite(misses))),
        "stage0": scene.scored(0, before, rng)
        | own.against(before)
        | {f"anew_{name}": found for name, found in anew[0].against(before).items()},
    }
    for k in (1, 2, 3):
        out[f"stage{k}"] = anew[k].travel()
        if "refused" in out:
            continue
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = cameras[k - 1 : k + 1]
        images = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        given = before, cameras[k], images, rig.board.points(), first.clamp, PUBLISHED
        try:
            stage = deflected(*given)
            found = of_deflection(rig, stage, height, cameras[k])
            found |= scene.scored(k, stage.camera, rng, stale=before)
        except CalibrationError as refusal:
            out["refused"] = refusal.code
            found = linear_alone(rig, given, height, cameras[k])
        else:
            found |= anew[k].against(stage.camera)
            before, height = stage.camera, found["height_mm"]
        out[f"stage{k}"] |= found
    return out


def linear_alone(rig, given, height, true):
    """Linear estimate of a rejected deflection, mm; nothing if it is missing. given:
    as for `deflected`."""
    try:
        linear = linearly_deflected(*given)
    except CalibrationError:
        return {}
    return {"linear_mm": load_height(rig, linear, true) - height}


def of_deflection(rig, stage, height, true):
    """Estimated deflection of the mirror, and residuals of the refinement."""
    residuals = stage.residuals[np.isfinite(stage.residuals)]
    final = load_height(rig, stage.camera, true)
    return {
        "height_mm": final,
        "deflection_mm": final - height,
        "linear_mm": load_height(rig, stage.linear, true) - height,
        "residual_mm": float(residuals.mean()),
        "residual_sd_mm": float(residuals.std(ddof=1)),
        "swing_deg": stage.swing_deg,
        "common": len(residuals),
        "wrong": int(np.count_nonzero(stage.wrong)),
    }


class StageScene(NamedTuple):
    """The true cameras of stages 0 to 3 of a rig, and the errors of its images."""

    rig: object
    cameras: list
    errors: object

    def scored(self, k, camera, rng, stale=None):
        """Errors of a calibrated camera of stage k.

        stale: the camera before the deflection, on the same image.
        """
        true = self.cameras[k]
        pixels = pixel_lattice(true, COMPARED_PX)
        off = ray_angles(camera, true, pixels)
        moved = ray_angles(true, self.cameras[0], pixels)
        return {
            "angle_deg": float(np.nanmean(off)),
            "angle_sd_deg": float(np.nanstd(off, ddof=1)),
            "moved_deg": float(np.nanmax(moved)),
            "pixels": pixels,
            "off_deg": off,
            "sheet": sheet_places(true, pixels),
            **self._back_projected(k, camera, rng, stale),
        }

    def _back_projected(self, k, camera, rng, stale):
        """Errors on a board at 400 mm (Table 5.4)."""
        rig, points = self.rig, self.rig.board.points()
        T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels = seen_board(rig, self.cameras[k], T, self.errors, rng)
        own = back_projection(camera, pixels, points)
        out = {
            "back_mm": float(lengths(own).mean()),
            "back_sd_mm": float(lengths(own).std(ddof=1)),
            "back_true_mm": float(
                lengths(back_projection(camera, pixels, points, T)).mean()
            ),
            "corners": len(lengths(own)),
            "board_mm": points,
            "own": own,
            "seen_at": sheet_places(self.cameras[k], pixels),
        }
        if stale is not None:
            was = back_projection(stale, pixels, points)
            out |= {"stale_mm": float(lengths(was).mean()), "stale": was}
        return out


def sheet_places(true, pixels):
    """Points of the sheet that pixels (N, 2) see: shares (N, 2) of its length from the
    clamp and of its width, 0 to 1."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    half = true.mirror.half_width
    return np.column_stack(
        [points[:, 0] / true.mirror.end, (points[:, 1] + half) / (2 * half)]
    )


# Scatter of an estimated deflection at the load and among the corners.
#
# One push, calibrated as for Table 5.1. How far the mirror was found to go is held
# against how far it went: at the load, and at places that lie among the corners.


STEP_MM = STAGES_MM[:2]
# Places of the sheet, along and across, and the share of its width that they cover.
TIP_PLACES, ACROSS = (33, 11), 0.9
NEWTON_STEPS, ARRIVED_MM = 20, 1e-9


def one_push(rig, bench, errors, seed):
    """Errors of the mirror's movement, mm: `tip_mm` at the load, and mean and mean
    square of points in the convex hull of the common corners; the same for the position
    after the push, `surface`. `beyond_mm`: from the last corner to the load. `refused`:
    the code of the rejection of a run without a value.
    """
    rng = np.random.default_rng(seed)
    cameras = [rig.camera(mm, bench.aberration_um, seed) for mm in STEP_MM]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    T = rig.board_pose(rng, deflections=STEP_MM)
    images = [seen_board(rig, camera, T, errors, rng) for camera in cameras]
    try:
        stage = deflected(
            first.camera, cameras[1], images, rig.board.points(), first.clamp, PUBLISHED
        )
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    corners = sheet_mm(cameras[1], images[1][stage.used])
    inside = places_among(corners, cameras[1])
    places = {
        "load": [rig.load_point(true)[None] for true in cameras],
        "among": [on_mirror(true, inside) for true in cameras],
    }
    pair = first.camera, stage.camera
    off = {
        name: [beyond(rig, one, at) for one, at in zip(pair, points, strict=True)]
        for name, points in places.items()
    }
    went = {name: after - before for name, (before, after) in off.items()}
    last = corners[:, 0].max()
    return {
        "beyond_mm": float(cameras[1].mirror.profile.places[0] - last),
        "places": len(inside),
        **spread("", went["load"][0], went["among"]),
        **spread("surface.", off["load"][1][0], off["among"][1]),
    }


def spread(prefix, tip, among):
    """The error at the load, and mean and mean square of those among the corners."""
    return {
        f"{prefix}tip_mm": float(tip),
        f"{prefix}mean_mm": float(np.mean(among)),
        f"{prefix}square_mm2": float(np.mean(among**2)),
    }


def sheet_mm(true, pixels):
    """Points of the sheet that pixels (N, 2) see, (N, 2) mm in the mirror's frame."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    return points[:, :2]


def places_among(corners, true):
    """Places (n, 2) mm of a lattice over the sheet in the hull of corners (N, 2)."""
    mirror = true.mirror
    half = ACROSS * mirror.half_width
    x = np.linspace(0, mirror.end, TIP_PLACES[0])
    y = np.linspace(-half, half, TIP_PLACES[1])
    lattice = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return lattice[Delaunay(corners).find_simplex(lattice) >= 0]


def on_mirror(true, places):
    """Points (n, 3) of a true mirror over places (n, 2) mm, viewer's frame."""
    x, y = np.transpose(places)
    return transform(
        true.T_viewer_mirror, np.column_stack([x, y, true.mirror.height(x, y)[0]])
    )


def beyond(rig, found, points):
    """How far (n,) mm a calibrated mirror lies beyond points (n, 3), along the push."""
    along = rig.deflection_direction()
    shift = np.zeros(len(points))
    for _ in range(NEWTON_STEPS):
        P = points + shift[:, None] * along
        # The mirror's point on the same viewing ray, and its tangent plane there.
        S = found.mirror.points(P[:, :2] / P[:, 2:])
        n = found.mirror.normals(S)
        step = np.sum(n * (S - P), axis=1) / (n @ along)
        shift += step
        if not np.nanmax(np.abs(step)) > ARRIVED_MM:
            break
    return shift
