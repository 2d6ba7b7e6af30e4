"""Rendering of an image set from a rig, with its ground truth.

The set has the format of recorded ones (`raxel.sets`). Its folder `truth`, which only
the evaluation reads, contains the camera, the poses and the ideal output of detectors
and decoders.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import cast

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from raxel.cameras.core.base import Camera
from raxel.cameras.core.smooth_rays import smooth_rays
from raxel.errors import InputError
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import transform
from raxel.io.files import check_can_be_written, write_json
from raxel.lab.lighting import Blemishes, Lighting
from raxel.lab.optics import Crop
from raxel.lab.rendering import lit_pixels, trace
from raxel.lab.rig import Rig
from raxel.lab.scenes import (
    MonitorBoard,
    MonitorLevel,
    MonitorPattern,
    board_scene,
    monitor_scene,
    odd_share,
)
from raxel.lab.target_poses import outline_of
from raxel.sets.image_files import write_png
from raxel.sets.image_set import load_set, write_set
from raxel.sets.model import ActiveGrid, ImageSet, Pattern, View
from raxel.sets.patterns import (
    BLACK,
    CHESSBOARD,
    WHITE,
    PatternPlan,
    advance,
    patterns_of,
)

# Image of a board by a rig: its light, its blemishes, and its rays. The surroundings of
# a board are an even background, so rays are traced where the board is, and the rest of
# the image is filled in.


# Around the board's outline: blur and its repeated border pixels reach less far.
MARGIN_PX = 16
# For the background, every n-th pixel along each axis is tested for a ray.
RAY_STEP = 8


def render_board(
    rig: Rig,
    T_camera_board: NDArray[np.float64],
    rng: np.random.Generator,
    specimen: np.random.Generator,
) -> np.ndarray:
    """Return an image of the rig's chessboard as its camera saves it.

    Parameters
    ----------
    rig : Rig
        A rig with a chessboard.
    T_camera_board : (4, 4) array
        Pose of the board, mm; the whole board is in view.
    rng : numpy.random.Generator
        Of this image: light, glare, noise.
    specimen : numpy.random.Generator
        Of the rig's own spots.

    Returns
    -------
    (H, W) or (H, W, 3) uint8 or uint16 array
        Red, green, blue where the rig is coloured, else grey.
    """
    if rig.light == Lighting() and rig.blemishes == Blemishes():
        return _render_plain(rig, T_camera_board, rng)
    return saved(rig, light_of_board(rig, T_camera_board, rng), rng, specimen)


def light_of_board(
    rig: Rig, T_camera_board: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return the light on the rig's sensor through clean mirror and glass.

    Parameters
    ----------
    rig : Rig
        A rig with a chessboard.
    T_camera_board : (4, 4) array
        Pose of the board, mm.
    rng : numpy.random.Generator
        Draws the light on the board.

    Returns
    -------
    (H, W) or (H, W, 3) float32 array
        Irradiance.
    """
    light = rig.light.draw(rng, rig.extent)
    scene = board_scene(
        rig.target,  # type: ignore[arg-type]
        T_camera_board,
        rig.border_mm,
        light=light,
        **rig.radiances,
    )
    window = window_of(rig, T_camera_board)
    mosaic = rig.sensor.bayer is not None
    part = rig.laboratory().irradiance(scene, np.eye(4), colour=mosaic, window=window)
    around, whole = light_of_room(rig)
    if mosaic:
        around, whole = (np.repeat(x[..., None], 3, axis=2) for x in (around, whole))
    whole[window.place] = around[window.place] + part
    return whole


def light_of_room(rig: Rig) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the light on the sensor without a board.

    Parameters
    ----------
    rig : Rig
        Gives mirror, lens and background.

    Returns
    -------
    around, everywhere : (H, W) float32 arrays
        Irradiance outside the mirror alone, and of the whole image.
    """
    mirror = mirror_in_view(rig.camera)
    shade = rig.optics.vignetting(rig.camera.width, rig.camera.height)
    around = rig.light.surround * (1 - mirror) * shade
    return around, around + rig.radiances["background"] * mirror * shade


def saved(
    rig: Rig,
    irradiance: NDArray[np.float32],
    rng: np.random.Generator,
    specimen: np.random.Generator,
) -> np.ndarray:
    """Return the image that light on the sensor leaves in the file.

    Parameters
    ----------
    rig : Rig
        Gives blemishes, tint and sensor.
    irradiance : (H, W) or (H, W, 3) array
        Light on the sensor.
    rng, specimen : numpy.random.Generator
        As in `render_board`.

    Returns
    -------
    (H, W) or (H, W, 3) uint8 or uint16 array
        As from `render_board`.
    """
    mirror = mirror_in_view(rig.camera)
    whole = rig.blemishes.apply(irradiance, mirror, specimen, rng)
    if rig.light.coloured:
        whole = rig.light.tinted(whole)
    return rig.sensor.expose(whole, rng, colour=whole.ndim == 3)


def _render_plain(rig, T_camera_board, rng):
    """An image in even light through clean glass, with every ray traced."""
    scene = board_scene(rig.target, T_camera_board, rig.border_mm, **rig.radiances)
    colour = rig.sensor.bayer is not None
    return rig.laboratory().render(scene, np.eye(4), rng, colour=colour)


def grey_of(image: np.ndarray) -> np.ndarray:
    """Return an image (H, W) or (H, W, 3) in grey, (H, W), as OpenCV converts it."""
    return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def window_of(rig: Rig, T_camera_board: NDArray[np.float64]) -> Crop:
    """Return the `Crop` of the rig's image that holds the whole board.

    Parameters
    ----------
    rig : Rig
        Gives camera and board.
    T_camera_board : (4, 4) array
        Pose of the board, mm.

    Returns
    -------
    Crop
        With a margin of 16 px.
    """
    camera = rig.camera
    outline = on_plane(outline_of(*rig.extent))
    seen = camera.project(transform(T_camera_board, outline)).pixels
    full = np.array([camera.width, camera.height])
    low = np.clip(np.floor(seen.min(axis=0)) - MARGIN_PX, 0, full).astype(int)
    high = np.clip(np.ceil(seen.max(axis=0)) + MARGIN_PX, 0, full).astype(int)
    return Crop(*map(int, (*low, *(high - low), *full)))


@lru_cache(maxsize=8)
def mirror_in_view(camera: Camera) -> NDArray[np.float32]:
    """Return 1 where a pixel has a ray, else 0.

    A coarse grid of pixels is tested first, then those between unlike neighbours.

    Parameters
    ----------
    camera : Camera
        Any camera with rays.

    Returns
    -------
    (H, W) float32 array
        The result is kept and shared: do not write to it.
    """
    size = camera.width, camera.height
    u, v = (np.arange(0, n + RAY_STEP, RAY_STEP) for n in size)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2).astype(float)
    coarse = camera.rays(grid).valid.reshape(len(v), len(u)).astype(np.float32)
    # warpAffine puts node (i, j) at pixel RAY_STEP (i, j), which resize would not.
    onto = np.array([[RAY_STEP, 0, 0], [0, RAY_STEP, 0]], float)
    seen = cv2.warpAffine(coarse, onto, size)
    rows, columns = np.nonzero((seen > 0) & (seen < 1))
    rays = camera.rays(np.column_stack([columns, rows]).astype(float))
    seen[rows, columns] = rays.valid
    return seen  # type: ignore[return-value]


# What each pixel of a view sees of a monitor, kept to show one pattern after another.
# The means over pixels are those of `raxel.lab.rendering`, in a tenth of the time:
# almost all pixels of the lit area see nothing else, and of these a pattern needs
# only where they look along its axis.


LIT = 0  # the part of the scene


class MonitorSight:
    """Hold a rig's camera and its monitor at one pose, T_camera_target (4, 4), mm."""

    def __init__(self, rig, T_camera_target):
        self.rig, monitor = rig, rig.monitor
        scene = monitor_scene(rig.target, T_camera_target, **rig.radiances)
        traced = trace(rig.camera, np.eye(4), scene)
        self._lit, uv, across, down, cosine = lit_pixels(traced, LIT)
        self._axes = [(uv[:, k], across[:, k], down[:, k]) for k in (0, 1)]
        self._falloff = monitor.falloff(cosine).astype(np.float32)
        self._surround = traced.shade({LIT: MonitorLevel(1.0, monitor.radiance)})
        self._mixed = traced.mixed_pixels(LIT, self._lit)
        self._waves = {}

    def level(self, value):
        """Radiance (H, W) of the monitor at one value, float32."""
        texture = MonitorLevel(value, self.rig.monitor.radiance)
        return self._picture(np.float32(self.rig.monitor.light(value)), texture)

    def pattern(self, pattern):
        """Radiance (H, W) of the monitor with a `raxel.sets.Pattern`, float32."""
        target, monitor = self.rig.target, self.rig.monitor
        size = target.monitor_px, target.monitor_mm
        texture = MonitorPattern(*size, pattern, monitor.radiance)
        show = self._gray if pattern.kind == "gray" else self._sine
        return self._picture(show(texture), texture)

    def _picture(self, light, texture):
        image = self._surround.copy()
        image.reshape(-1)[self._lit] = light * self._falloff
        for pixels, mean in self._mixed:
            image.reshape(-1)[pixels] = mean(texture)
        return image

    def _gray(self, texture):
        monitor, inverse = self.rig.monitor, texture.pattern.inverse
        x, across, down = self._axes[texture.axis]
        low, high = monitor.light(np.float32([inverse, not inverse]))
        light, crossed = _stripes(x, across, down, texture.frequency, low, high)
        crossed = np.flatnonzero(crossed)
        edge = (part[crossed] * texture.frequency for part in (x, across, down))
        light[crossed] = low + odd_share(*edge).astype(np.float32) * (high - low)
        return light

    def _sine(self, texture):
        key = texture.axis, texture.frequency
        if key not in self._waves:
            x, across, down = (part * texture.frequency for part in self._axes[key[0]])
            swing = 0.5 * np.sinc(across) * np.sinc(down)
            turn = 2 * np.pi * x
            waves = swing * np.sin(turn), swing * np.cos(turn)
            self._waves[key] = tuple(wave.astype(np.float32) for wave in waves)
        sine, cosine = self._waves[key]
        angle = 2 * np.pi * advance(texture.pattern)
        value = np.float32(np.cos(angle)) * sine + np.float32(np.sin(angle)) * cosine
        return self.rig.monitor.light(value + np.float32(0.5))


@numba.njit(cache=True)
def _stripes(x, across, down, frequency, low, high):
    """Return light (N,) where no edge of a Gray code is near, and where one may be."""
    light, crossed = np.empty(len(x), np.float32), np.empty(len(x), np.bool_)
    for n in range(len(x)):
        at = x[n] * frequency + 0.5
        reach = (abs(across[n]) + abs(down[n])) * frequency / 2
        whole = np.floor(at)
        light[n] = high if whole % 2 else low
        crossed[n] = min(at - whole, whole + 1 - at) <= reach
    return light, crossed


# Images of an active grid: one view, all its patterns, and the point of each pixel.
# Rays and intersections are computed once for a view; each pattern is then only
# shaded.


PIXELS_PER_BLOCK = 1 << 16
# Smooth rays are closer to a camera's own than this share of the monitor.
RAY_TOL = 1e-3
# Stream of random numbers of the chessboard, after those of any patterns.
BOARD = 1 << 16


def render_patterns(
    rig: Rig, T_camera_target: NDArray[np.float64], seed: Sequence[int]
) -> Iterator[tuple[str | Pattern, np.ndarray]]:
    """Yield all images of an active grid for one pose of the monitor.

    Parameters
    ----------
    rig : Rig
        A rig with a monitor.
    T_camera_target : (4, 4) array
        Pose of the monitor, mm.
    seed : sequence of int
        Whole numbers; each image has a noise of its own.

    Yields
    ------
    (str or Pattern, array)
        WHITE, BLACK or the pattern shown, and its image.
    """
    laboratory, sight = rig.laboratory(), MonitorSight(rig, T_camera_target)
    shown: list[str | Pattern] = [
        *(WHITE, BLACK),
        *patterns_of(cast(PatternPlan, rig.patterns)),
    ]
    for number, what in enumerate(shown):
        rng = np.random.default_rng([*seed, number])
        if isinstance(what, str):
            radiance = sight.level(float(what == WHITE))
        else:
            radiance = sight.pattern(what)
        yield what, laboratory.develop(radiance, rng)


def render_chessboard(rig, T_camera_target, seed):
    """The image of the chessboard that the rig's monitor shows in the same pose."""
    target, size = rig.target, (rig.target.monitor_px, rig.target.monitor_mm)
    board = MonitorBoard(*size, target.chessboard, rig.monitor.radiance)
    scene = monitor_scene(target, T_camera_target, board, **rig.radiances)
    rng = np.random.default_rng([*seed, BOARD])
    return rig.laboratory().render(scene, np.eye(4), rng)


def points_seen(
    camera: Camera, T_camera_target: NDArray[np.float64], size_mm: Sequence[float]
) -> NDArray[np.float32]:
    """Return where each pixel's ray meets the monitor.

    Smooth rays determine which pixels come near the monitor. The points of these pixels
    come from the camera's own rays.

    Parameters
    ----------
    camera : Camera
        Any camera with rays.
    T_camera_target : (4, 4) array
        Pose of the lit area, mm; its upper left corner is the origin.
    size_mm : (float, float)
        Width and height of the lit area, mm.

    Returns
    -------
    (height, width, 2) float32 array
        Points on the monitor, mm; NaN outside it.
    """
    points = np.full((camera.height, camera.width, 2), np.nan, np.float32)
    size, smooth = np.array(size_mm, float), smooth_rays(camera)
    u, step = np.arange(float(camera.width)), max(1, PIXELS_PER_BLOCK // camera.width)
    for first in range(0, camera.height, step):
        v = np.arange(first, min(first + step, camera.height), dtype=float)
        rays = smooth.grid(u, v)
        _, near = _met(rays, T_camera_target, size, RAY_TOL * size.max())
        near = np.flatnonzero(near)
        exact = smooth.exact_on_grid(u, v, rays, near)
        met, on = _met(exact, T_camera_target, size, 0.0)
        points[first : first + step].reshape(-1, 2)[near[on]] = met[on]
    return points


def _met(rays, T_camera_target, size, margin):
    """Return points (N, 2) mm of the monitor's plane on rays, and a mask (N,).

    The mask is True on the monitor's face and within `beyond` mm of it.
    """
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_target)
    with np.errstate(invalid="ignore"):
        within = (met.points >= -margin) & (met.points <= size + margin)
    facing = rays.directions @ T_camera_target[:3, 2] > 0
    return met.points, within.all(axis=1) & facing & met.valid & rays.valid


TRUTH = "truth"
# Streams of random numbers, so that no draw depends on the number of draws before.
POSES, NOISE, SPECIMEN = 0, 1, 2


def render_set(
    rig: Rig, out: str | Path, seed: int, say: Callable[[str], object] | None = None
) -> ImageSet:
    """Render the rig's target in poses drawn from a seed, as an image set on disk.

    The same seed gives the same bytes. The folder appears when it is complete, or not
    at all.

    Parameters
    ----------
    rig : Rig
        What to render.
    out : str or Path
        A folder that does not exist yet.
    seed : int
        Whole number, 0 or more.
    say : callable or None
        Called with one line of text per view.

    Returns
    -------
    ImageSet
        The set in `out`; its folder `truth` holds camera, poses and true positions.

    Raises
    ------
    InputError
        For a folder that exists or cannot be made, and as `Rig.draw_poses`.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already; name a new folder")
    check_can_be_written(out)
    views = rig.count + rig.evaluate
    poses = rig.draw_poses(np.random.default_rng([seed, POSES]), views)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "set"
        (folder / TRUTH).mkdir(parents=True)
        is_monitor = isinstance(rig.target, ActiveGrid)
        render_view = _monitor_view if is_monitor else _board_view
        taken = []
        for index, T in enumerate(poses):
            use = "calibrate" if index < rig.count else "evaluate"
            taken.append(render_view(rig.at_view(index), T, index, use, folder, seed))
            if say:
                say(f"{index + 1}/{views} {taken[-1].label}")
        _write_truth(rig, poses, taken, folder / TRUTH)
        write_set(_described(rig, taken, folder, seed))
        os.rename(folder, out)
    return load_set(out)


def write_image(path, image):
    """An image (H, W) or (H, W, 3), red, green, blue, as PNG."""
    write_png(path, image if image.ndim == 2 else image[..., ::-1])


def _board_view(rig, T_camera_target, index, use, folder, seed):
    rng = np.random.default_rng([seed, NOISE, index])
    specimen = np.random.default_rng([seed, SPECIMEN])
    image = render_board(rig, T_camera_target, rng, specimen)
    name = f"view-{index:03d}.png"
    write_image(folder / name, image)
    return View(image=name, use=use)


def _monitor_view(rig, T_camera_target, index, use, folder, seed):
    name = rig.view_name(index)
    (folder / name).mkdir()
    images = render_patterns(rig, T_camera_target, [seed, NOISE, index])
    files, patterns = {}, []
    if rig.shows_chessboard(index):
        image = render_chessboard(rig, T_camera_target, [seed, NOISE, index])
        files["chessboard"] = f"{name}/{CHESSBOARD}"
        write_image(folder / files["chessboard"], image)
    for key, image in images:
        label = key if isinstance(key, str) else key.image
        write_image(folder / name / label, image)
        if isinstance(key, str):
            files[key.removesuffix(".png")] = f"{name}/{label}"
        else:
            patterns.append(replace(key, image=f"{name}/{label}"))
    return View(name=name, patterns=tuple(patterns), use=use, **files)


def _described(rig, views, folder, seed):
    note = f"rendered by raxel's simulator: rig {rig.name}, seed {seed}"
    return ImageSet(
        name=rig.name,
        width=rig.camera.width,
        height=rig.camera.height,
        target=rig.target,
        views=tuple(views),
        folder=folder,
        camera=rig.summary,
        origin={"source": "rendered", "note": note},
        truth=f"{TRUTH}/",
    )


def _write_truth(rig, poses, views, folder):
    rig.camera.save(folder / "camera.npz")
    labels = [view.label for view in views]
    matrices = {label: T.tolist() for label, T in zip(labels, poses, strict=True)}
    write_json(folder / "poses.json", {"unit": "mm", "T_camera_target": matrices})
    if isinstance(rig.target, ActiveGrid):
        for index, (label, T) in enumerate(zip(labels, poses, strict=True)):
            camera = rig.at_view(index).camera
            points = points_seen(camera, T, rig.target.monitor_mm)
            np.savez(folder / f"{label}.npz", points_mm=points)
        if rig.target.chessboard and rig.camera.continuous:
            shown = [view.chessboard for view in views]
            write_json(folder / "corners.json", _corners_of_views(rig, shown, poses))
    else:
        write_json(folder / "corners.json", _corners_of_views(rig, labels, poses))


def _corners_of_views(rig, labels, poses):
    """Return `true_corners` of views, each with its lens; label None: no board."""
    parts = [
        true_corners(rig.at_view(index), {label: T})
        for index, (label, T) in enumerate(zip(labels, poses, strict=True))
        if label
    ]
    images = {label: at for part in parts for label, at in part["images"].items()}
    return parts[0] | {"images": images}


def true_corners(rig, poses):
    """The projected corners in the form of a set's reference corners (corners.json).

    poses: {label of the image: T_camera_target (4, 4)}.
    """
    is_monitor = isinstance(rig.target, ActiveGrid)
    board = rig.target.chessboard if is_monitor else rig.target
    points = rig.target.chessboard_points() if is_monitor else board.points()
    flat = on_plane(points)
    images = {
        label: {
            "corners": rig.camera.project(transform(T, flat)).pixels.tolist(),
            "sd": 0.0,
        }
        for label, T in poses.items()
    }
    note = "true projections of the board's corners; the first is the frame's origin"
    counts = {"columns": board.columns, "rows": board.rows}
    return counts | {"note": note, "images": images}
