"""Rendered images of a flexible mirror's calibration, and what is detected in them.

All inputs of a calibration come from images: partly visible boards by the detector, the
monitor by decoding, the mirror's outline by its brightness. Only the clamp's points are
picked by hand, with a given error. The truth is used for rendering and for the noise of
the error level; detection does not use it.
"""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.mirror_pictures import (
    board_picture,
    platter_camera,
    platter_picture,
    platter_window,
)
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import CLAMP_PICKS, CLAMP_SD_PX
from raxel.calibration import BoardView
from raxel.calibration.mirror.flat_views import flat_view
from raxel.calibration.mirror.partial_boards import (
    labelled_like,
    lattice_of,
    on_one_lattice,
)
from raxel.calibration.mirror.platter import PlatterPicture
from raxel.calibration.mirror.stages import ClampPicks, MirrorViews, StepViews
from raxel.calibration.parametric.zhang import calibrate_zhang
from raxel.calibration.views.dense import dense_view
from raxel.errors import CalibrationError
from raxel.features import find_board
from raxel.features.active_grid import decode
from raxel.geometry import pose, rotation_from_vector, transform
from raxel.geometry.planes import on_plane
from raxel.lab.board_photograph import photograph_board
from raxel.lab.monitor_views import photograph_patterns, points_seen
from raxel.lab.target_poses import outline_of
from raxel.lab.windowed import bands as bands_of
from raxel.lab.windowed import mirror_window, window_around, windowed
from raxel.sets import Chessboard
from raxel.sets.patterns import BLACK, WHITE

# The board that the camera sees directly: its width as a share of the picture's at its
# middle distance, how far that varies, and how it is tilted.
VIEWER_BOARD, VIEWER_SHARE = Chessboard(10, 7, 10.0), 0.4
VIEWER_NEARER, VIEWER_TILT, TRIES = 0.2, np.radians((20, 40)), 500
# Rows of a band of a window that is rendered of the monitor. Of each band the middle
# row counts, where all windows of the decoder are whole, and so many places along it.
BAND_PX, PLACES = 16, 40
# What is lit in a picture of the mirror: brighter than this share of its white. Black
# squares are; what lies beside the mirror is not.
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


class ReadPictures(NamedTuple):
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


def read_pictures(scene, sizes, rng):
    """ReadPictures of a MirrorRun with RunSizes. Raises CalibrationError where an
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
    seen_flat = platter_pictures(scene, viewer, platter, sizes.bands, rng)
    clamp, thickness = ClampPicks(picks, CLAMP_SD_PX), platter.thickness_mm
    views = MirrorViews(viewer, tuple(grids), seen_flat, thickness, clamp, tuple(steps))
    return ReadPictures(views, outlines)


def calibrated_viewer(rig, boards, rng):
    """The perspective camera by Zhang's method, from boards that it sees directly."""
    views = [
        whole_board(*viewer_picture(rig, rng), VIEWER_BOARD, f"viewer {k}")
        for k in range(boards)
    ]
    return calibrate_zhang(views, rig.viewer.width, rig.viewer.height).camera


def viewer_picture(rig, rng):
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
            return photograph_board(windowed(taken, window), T, rng, rng), window
    raise RuntimeError(f"geometry {rig.name}: no pose of {TRIES} shows the board")


def whole_board(picture, window, board, name):
    """BoardView of a board that is wholly visible in a window of the image."""
    found = find_board(picture, board.columns, board.rows)
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
        pictures = dict(photograph_patterns(taken, T, [seed, part]))
        levels = {"white": pictures.pop(WHITE), "black": pictures.pop(BLACK)}
        images = np.array(list(pictures.values()))
        found = decode(images, list(pictures), taken.target, linear=True, **levels)
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


def platter_pictures(scene, viewer, platter, bands, rng):
    """PlatterPictures of the monitor in its positions. The platter is fixed, so one
    image shows its board."""
    rig = scene.rig
    taken = replace(rig.rig, camera=rig.viewer, target=platter.board)
    outline = transform(platter.T_camera_board, on_plane(outline_of(*taken.extent)))
    window = window_around(rig.viewer, rig.viewer.project(outline).pixels)
    part = windowed(taken, window)
    picture = platter_picture(PartOfRig(part), platter, rng)
    board = whole_board(picture, window, platter.board, "platter")
    camera, window = platter_camera(rig, platter), platter_window(rig, platter)
    grids = [
        flat_view(viewer, decoded(scene, camera, window, bands, k, rng))
        for k in range(len(scene.places))
    ]
    return tuple(PlatterPicture(board, grid, 0, k) for k, grid in enumerate(grids))


class PartOfRig(NamedTuple):
    """A part of a rig's image, as `platter_picture` uses it."""

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
        picture, window = board_picture(rig, camera, scene.boards[k], rng)
        found = lattice_of(find_board(picture, rig.board.columns, rig.board.rows))
        if found is None:
            raise CalibrationError(f"{name}: no board in the mirror", code="no-board")
        lattices.append(found._replace(corners=found.corners + [window.u, window.v]))
        outline = lit_outline(picture) + [window.u, window.v]
    lattices[1] = labelled_like(*lattices, picks, name)
    names = f"{name} before", f"{name} after"
    views = on_one_lattice(lattices, rig.board, names)
    moved = float(STAGES_MM[k + 1] - STAGES_MM[k])
    return StepViews(*views, moved), outline


def lit_outline(picture):
    """Pixels (M, 2) around the bright part of an image (h, w): the mirror's edges."""
    soft = cv2.GaussianBlur(picture, (0, 0), 2.0)
    lit = (soft > LIT * np.quantile(soft, 0.99)).astype(np.uint8)
    around = cv2.findContours(lit, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    largest = max(around, key=cv2.contourArea)
    return cv2.convexHull(largest)[:, 0].astype(float)
