"""Table 3.8 at the camera's own pixels, which resolve the raster of the monitor.

The simulator renders a monitor as a continuous image. Here each of its pixels has a
bright opening and a dark frame. Only patches around the corners are rendered: the whole
image would have 10 million pixels.
"""

from dataclasses import dataclass, replace

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import rig_of
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.corners import (
    best_of,
    sweep,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.metric_search import (
    at_four_pixels,
    by_local_fit,
)
from raxel.features.active_grid import decode
from raxel.geometry import on_plane, transform
from raxel.geometry.homography import apply_homography
from raxel.sets import chessboard_picture, pattern_picture, patterns_of

RIG = "d200-lens"
NATIVE_RIGS = ("data/rigs/d200-lens.yaml",)
BINNED = 3  # pixels of the camera per rig pixel, each way
# Bright share of a monitor's pixel, each way: 64 % of its area.
APERTURE = 0.8
# Share of a full well: the raster's peaks exceed its mean and must not clip.
WHITE_WELLS = 0.75
FINENESS = 3  # samples each way for a pixel, before the blur
# Full widths and SDs, px of the camera; step between the corners used along a row.
WINDOWS = {"quick": (5, 21), "full": (5, 9, 13, 17, 21, 25, 33, 41, 49, 57, 73, 89)}
BLURS = {"quick": (2.0,), "full": (0.5, 1.0, 2.0, 3.0, 4.0, 6.0)}
STRIDE = {"quick": 7, "full": 1}
SEEDS = (1, 2, 3)
NO_RASTER = "no raster"
HALF_DECODED = 20  # half-width of a decoded patch, px


def native_conditions(effort):
    """Return a condition for each seed, named as those of Table 3.8.

    One more condition has no raster, to isolate its effect.
    """
    seeds = SEEDS[:1] if effort == "quick" else SEEDS
    return [
        {
            "case": case,
            "seed": seed,
            "stride": STRIDE[effort],
            "windows": list(WINDOWS[effort]),
            "blurs": list(BLURS[effort]),
        }
        for case, of_case in (("near", seeds), (NO_RASTER, seeds[:1]))
        for seed in of_case
    ]


@dataclass(frozen=True)
class NativeCamera:
    """The rig's camera with its own pixels and no distortion, in front of its monitor.

    K: (3, 3) px; T_camera_target: (4, 4) mm; blur_sd_px, size: as in the rig, in
    the camera's pixels.
    """

    rig: object
    T_camera_target: np.ndarray

    @property
    def size(self):
        """Width and height, px."""
        return BINNED * self.rig.camera.width, BINNED * self.rig.camera.height

    @property
    def K(self):
        """The rig's, in pixels of which BINNED share the centre of its pixel."""
        finer = np.diag([BINNED, BINNED, 1.0])
        finer[:2, 2] = (BINNED - 1) / 2
        return finer @ self.rig.camera.K

    @property
    def H_px_mm(self):
        """Points of the monitor (mm) to pixels."""
        return self.K @ self.T_camera_target[:3, [0, 1, 3]]

    @property
    def sensor(self):
        """The rig's for one pixel, with slightly less exposure."""
        well = self.rig.sensor.full_well_e / BINNED**2
        read = self.rig.sensor.read_noise_e / BINNED
        return replace(
            self.rig.sensor,
            white_e=WHITE_WELLS * well,
            full_well_e=well,
            read_noise_e=read,
        )

    @property
    def middle(self):
        """The centre (u, v) of the image."""
        return (np.array(self.size) - 1) / 2

    def vignetting(self, u, v):
        """Return the share of light at pixels (u, v): cos^4 at the exit pupil."""
        pupil = BINNED * self.rig.optics.exit_pupil_px
        square = (u - self.middle[0]) ** 2 + (v - self.middle[1]) ** 2
        return 1 / (1 + square / pupil**2) ** 2

    def blur_sd(self, pixel):
        """Return the SD (px) of the point spread at a pixel (2,).

        The rig's blur in its larger pixels is used as the lens's blur on these.
        """
        away = pixel - self.middle
        share = 4 * away @ away / np.sum(np.square(self.size))
        low, high = np.square(self.rig.optics.blur_sd_px)
        return float(np.sqrt(low + (high - low) * share))


def opened(place, width):
    """Return the mean brightness of the raster over samples along one axis.

    place: (...) of their centres, width: of a sample, both in pixels of the
    monitor. A sample is narrower than the dark frame, so it covers one opening at
    most.
    """

    def until(x):
        whole = np.floor(x)
        return whole * APERTURE + np.clip(x - whole - (1 - APERTURE) / 2, 0, APERTURE)

    return (until(place + width / 2) - until(place - width / 2)) / (width * APERTURE)


def rastered(shown, place):
    """Return light (n, ...) of the monitor at samples, each pixel in its dark frame.

    shown: (n, height, width), light of the monitor's pixels; place: (rows, columns,
    2) of the samples' centres, in pixels of the monitor.
    """
    x, y = place[..., 0], place[..., 1]
    column, row = np.floor(place).astype(int).transpose(2, 0, 1)
    across, down = sample_widths(place)
    return shown[:, row, column] * opened(x, across) * opened(y, down)


def without_raster(shown, place):
    """Return the same for pixels without dark frames: means over the samples."""
    border = np.rint(place).astype(int)
    beyond = np.clip((place - border) / sample_widths(place) + 0.5, 0, 1)
    (column, row), (right, low) = border.transpose(2, 0, 1), beyond.transpose(2, 0, 1)

    def along(row):
        return (1 - right) * shown[:, row, column - 1] + right * shown[:, row, column]

    return (1 - low) * along(row - 1) + low * along(row)


def sample_widths(place):
    """Return width and height (2,) of samples at positions (rows, columns, 2)."""
    across = np.diff(place[..., 0], axis=1).mean()
    down = np.diff(place[..., 1], axis=0).mean()
    return np.array([across, down])


def light_of_patch(camera, shown, pixel, half, drawn=rastered):
    """Return light (n, side, side) on the sensor around a pixel, of n monitor images.

    shown: (n, height, width) uint8, input of the monitor; pixel: (2,) whole; drawn:
    appearance of its pixels.
    """
    from scipy.ndimage import gaussian_filter

    side = 2 * half + 1
    offsets = (np.arange(side * FINENESS) + 0.5) / FINENESS - half - 0.5
    v, u = np.meshgrid(pixel[1] + offsets, pixel[0] + offsets, indexing="ij")
    seen = np.column_stack([u.ravel(), v.ravel()])
    target, monitor = camera.rig.target, camera.rig.monitor
    pitch_mm = np.divide(target.monitor_mm, target.monitor_px)
    mm = apply_homography(np.linalg.inv(camera.H_px_mm), seen)
    place = (mm / pitch_mm).reshape(*u.shape, 2)
    points = transform(camera.T_camera_target, on_plane(mm))
    normal = camera.T_camera_target[:3, 2]
    cosine = (points @ normal / np.linalg.norm(points, axis=1)).reshape(u.shape)
    levels = monitor.light(np.arange(256) / 255)
    radiance = drawn(levels[shown], place) * monitor.falloff(cosine)
    spread = FINENESS * camera.blur_sd(pixel)
    soft = gaussian_filter(radiance, (0, spread, spread), mode="nearest")
    binned = soft.reshape(len(shown), side, FINENESS, side, FINENESS).mean(axis=(2, 4))
    away = np.arange(-half, half + 1)
    return binned * camera.vignetting(pixel[0] + away, pixel[1] + away[:, None])


def native_trial(condition, rng):
    """Return residuals of corners by every method and setting, like `corner_trial`.

    condition: case (NO_RASTER: the chessboard alone, on a monitor without raster),
    stride (of the corners used along rows and columns), windows, blurs. Pixels are
    the camera's. The lens has no distortion, so the errors are the localisers' own.
    """
    rig = rig_of(RIG)
    camera = NativeCamera(rig, rig.draw_poses(rng, 1)[0])
    board = rig.target.chessboard
    points = rig.target.chessboard_points().reshape(board.rows, board.columns, 2)
    stride = condition["stride"]
    metric = points[::stride, ::stride].reshape(-1, 2)
    truth = apply_homography(camera.H_px_mm, metric)
    start = np.rint(truth).astype(int)
    found = localised_in_patches(camera, start, condition, rng)
    if condition["case"] != NO_RASTER:
        found |= decoded_in_patches(camera, start, metric, rng)
    out = {name: best_of(corners, metric) for name, corners in found.items()}
    off = {
        name: corners.reshape(-1, *metric.shape)[out[name]["best"]] - truth
        for name, corners in found.items()
    }
    for name, error in off.items():
        out[name]["rms_true_px"] = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
    return out | {"metric": metric, "middle": camera.K[:2, 2]}


def localised_in_patches(camera, start, condition, rng):
    """Return {method: corners (settings..., n, 2) px} of the chessboard, by `sweep`.

    The patches are tiled in one image, each with its start in its centre.
    """
    windows, blurs = condition["windows"], condition["blurs"]
    half = max(windows) // 2 + int(np.ceil(3 * max(blurs)))
    side = 2 * half + 1
    target = camera.rig.target
    shown = chessboard_picture(target.chessboard, target.monitor_px)[None]
    drawn = without_raster if condition["case"] == NO_RASTER else rastered
    light = [light_of_patch(camera, shown, pixel, half, drawn)[0] for pixel in start]
    across = int(np.ceil(np.sqrt(len(start))))
    tiles = np.zeros((across, across, side, side))
    tiles.reshape(-1, side, side)[: len(start)] = light
    picture = tiles.swapaxes(1, 2).reshape(across * side, across * side)
    taken = camera.sensor.expose(picture, rng)
    row, column = np.divmod(np.arange(len(start)), across)
    middle = np.column_stack([column, row]) * side + half
    found = sweep(taken, middle.astype(float), windows, blurs)
    # Half-windows of this size reach into the next patch.
    del found["OpenCV half"]
    return {name: corners + (start - middle) for name, corners in found.items()}


def decoded_in_patches(camera, start, metric, rng):
    """Return {search: corners (1, n, 2) px} in the decoded data of each patch."""
    rig = camera.rig
    patterns = patterns_of(rig.patterns)
    size = rig.target.monitor_px
    even = [np.full(size[::-1], value, np.uint8) for value in (255, 0)]
    shown = np.array([*(pattern_picture(p, size) for p in patterns), *even])
    searches = {"four nearest pixels": at_four_pixels, "local fit": by_local_fit}
    found = {name: [] for name in searches}
    for pixel, place in zip(start, metric, strict=True):
        light = light_of_patch(camera, shown, pixel, HALF_DECODED)
        side = light.shape[-1]
        taken = camera.sensor.expose(light.reshape(-1, side), rng)
        *pictures, white, black = taken.reshape(-1, side, side)
        grid = decode(
            np.array(pictures), patterns, rig.target, white=white, black=black,
            neighbours=True, fill=True, blur_px=camera.blur_sd(pixel), linear=True,
            threads=1,
        )  # fmt: skip
        for name, search in searches.items():
            found[name].append(search(grid, place[None])[0] + pixel - HALF_DECODED)
    return {name: np.array(corners)[None] for name, corners in found.items()}
