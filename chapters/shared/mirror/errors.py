"""Errors of corners and of decoded points in the rigs of chapter 5, drawn again.

They are measured in rendered images (`measured`) and drawn again for many runs. A
decoding error has a bias, which repeats with the sines of the monitor, and a rest; a
corner's error is any of those that were measured. An error level multiplies decoding
errors by one factor, after decoding and before any calibration, and lays the platter a
little off its place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror.images import (
    MirroredBoard,
    board_image,
    grid_image,
    platter_camera,
    platter_image,
    platter_window,
)
from chapters.shared.mirror.levels import Bench
from chapters.shared.mirror.rigs import STAGES_MM
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import Crop, bands, mirror_window

PHASES = 48  # cells of the bias along a period
# Rows of the mirror's window that are decoded: as many pixels as the errors need.
BANDS, BAND_PX = 3, 24
MAX_ERRORS = 4000  # errors that are kept to be drawn
OUTLYING = 6.0  # robust deviations: no bias is made of these


class DecodingPool(NamedTuple):
    """Decoding errors in one place: bias (2, PHASES) mm, by the place in a period of x
    and of y; rest (n, 2) mm; period_mm (2,)."""

    bias: np.ndarray
    rest: np.ndarray
    period_mm: np.ndarray

    @property
    def sd_mm(self):
        """Root mean square of an error along an axis, mm, bias and rest."""
        return float(np.sqrt(np.mean(self.bias**2) + np.mean(self.rest**2)))

    def drawn(self, points, rng, factor):
        """Points (..., 2) mm as they are decoded, errors times `factor`."""
        cell = (points / self.period_mm % 1 * PHASES).astype(int) % PHASES
        bias = np.stack([self.bias[k][cell[..., k]] for k in (0, 1)], axis=-1)
        rest = self.rest[rng.integers(len(self.rest), size=points.shape[:-1])]
        return points + factor * (bias + rest)


class MirrorErrors(NamedTuple):
    """Errors of a rig, measured in its rendered images.

    corner, plate: (n, 2) px, of corners of the board in the mirror, and of the board of
    the platter; mirror, platter: DecodingPools of the monitor in the mirror and in the
    platter; level: a `Bench`.
    """

    corner: np.ndarray
    plate: np.ndarray
    mirror: DecodingPool
    platter: DecodingPool
    level: Bench = Bench()

    @classmethod
    def read(cls, result, geometry):
        """Those of a geometry, all runs together, of the Result of `measured`.

        Rig C has the camera of A at the same distances, and its errors.
        """
        trials = result.select(geometry="A" if geometry == "C" else geometry)
        pools = {
            name: pool_of(
                np.concatenate(trials.arrays(f"{name}.error")),
                np.concatenate(trials.arrays(f"{name}.true")),
                trials.arrays("period_mm")[0],
            )
            for name in ("mirror", "platter")
        }
        corners = {
            name: np.concatenate(trials.arrays(name)) for name in ("corner", "plate")
        }
        return cls(**corners, **pools)

    def on(self, level):
        """The same at an error level."""
        return self._replace(level=level)

    def corners(self, pixels, rng):
        """Pixels (N, 2) of corners in the mirror with errors."""
        return pixels + self.corner[rng.integers(len(self.corner), size=len(pixels))]

    def plate_corners(self, pixels, rng):
        """Pixels (N, 2) of corners of the platter's board with errors."""
        return pixels + self.plate[rng.integers(len(self.plate), size=len(pixels))]

    def in_mirror(self, points, rng):
        """Points (N, 2) mm of the monitor, decoded in the flexible mirror."""
        return self.mirror.drawn(points, rng, self.level.factor)

    def in_platter(self, points, rng):
        """Points (N, 2) mm of the monitor, decoded in the platter."""
        return self.platter.drawn(points, rng, self.level.factor)

    @property
    def plate_sd_px(self):
        """Standard deviation of a corner of the platter's board along an axis, px."""
        return float(np.sqrt(np.mean(self.plate**2)))

    @property
    def platter_sd_mm(self):
        """Standard deviation of a point decoded in the platter along an axis, mm."""
        return self.level.factor * self.platter.sd_mm

    def mounted(self, platter, rng, positions):
        """The `Platter` as it lies at each of the monitor's positions, a list.

        What is off at its placing is the same at all; all levels draw alike.
        """
        level = self.level
        placed = _off(rng, level.placing_mm, level.placing_deg)
        return [
            platter._replace(
                T_board_off=placed @ _off(rng, level.position_mm, level.position_deg)
            )
            for _ in range(positions)
        ]


def _off(rng, mm, degrees):
    """A pose (4, 4) that is off by standard deviations along and about each axis."""
    shift, turn = rng.normal(size=(2, 3))
    return pose(rotation_from_vector(np.radians(degrees) * turn), mm * shift)


def pool_of(error, true, period_mm):
    """The DecodingPool of errors (N, 2) mm at true points (N, 2) mm."""
    spread = 1.4826 * np.median(np.abs(error - np.median(error, axis=0)), axis=0)
    usual = np.all(np.abs(error) <= OUTLYING * spread, axis=1)
    cell = (true / period_mm % 1 * PHASES).astype(int) % PHASES
    bias = np.zeros((2, PHASES))
    for k in (0, 1):
        count = np.bincount(cell[usual, k], minlength=PHASES)
        total = np.bincount(cell[usual, k], error[usual, k], PHASES)
        bias[k] = total / np.maximum(count, 1)
    rest = error - np.stack([bias[k][cell[:, k]] for k in (0, 1)], axis=1)
    return DecodingPool(bias, rest, np.asarray(period_mm, float))


def measured(rig, rng):
    """Errors in the rendered images of a MirrorRig, as a trial keeps them.

    At the first and the last stage: a board in dynamic calibration's place, and the
    monitor's two positions, in bands of the mirror's window. The platter on its board,
    with both positions.
    """
    corners, seed, ends = [], int(rng.integers(2**32)), (STAGES_MM[0], STAGES_MM[-1])
    for deflection in ends:
        camera = rig.camera(deflection)
        T = rig.board_pose(rng, deflections=(deflection,))
        true, seen = rig.corners(camera, T)
        found = board_image(rig, camera, T, rng).corners(true[seen])
        corners.append(found - true[seen])
    poses = rig.monitor_poses(rng)
    grids = [
        grid_image(rig, camera, T, [seed, number, place, part], window)
        for number, camera in enumerate(map(rig.camera, ends))
        for place, T in enumerate(poses)
        for part, window in enumerate(bands(mirror_window(camera), BANDS, BAND_PX))
    ]
    platter = rig.platter(rng)
    window = platter_window(rig, platter)
    reflected = [
        grid_image(rig, platter_camera(rig, platter), T, [seed, 9, place], window)
        for place, T in enumerate(poses)
    ]
    found = {
        "corner": _finite(np.concatenate(corners)),
        "plate": _plate_errors(rig, platter, rng),
        "period_mm": np.divide(
            rig.monitor.target.monitor_mm, rig.monitor.patterns.phase_periods
        ),
    }
    for name, images in (("mirror", grids), ("platter", reflected)):
        true = np.concatenate([image.truth_mm for image in images])
        points = np.concatenate([image.points_mm for image in images])
        kept = rng.permutation(len(true))[:MAX_ERRORS]
        found |= {f"{name}.true": true[kept], f"{name}.error": (points - true)[kept]}
    return found


def _plate_errors(rig, platter, rng):
    """Errors (n, 2) px of the corners of the platter's board."""
    image = platter_image(rig, platter, rng)
    height, width = image.shape
    points = transform(platter.T_camera_board, on_plane(platter.board.points()))
    true = rig.viewer.project(points).pixels
    whole = MirroredBoard(image, Crop(0, 0, width, height, width, height))
    return _finite(whole.corners(true) - true)


def _finite(errors):
    return errors[np.isfinite(errors).all(axis=1)]


# Gaussian errors for the rigs of chapter 5, where no measured ones are required.


# Standard deviations of a corner, px, and of a decoded point, mm, along each axis.
CORNER_PX, DECODED_MM = 0.2, 0.01


class GaussianErrors(NamedTuple):
    """Independent errors, for a rig in place of `MirrorErrors`."""

    corner_px: float = CORNER_PX
    decoded_mm: float = DECODED_MM

    def corners(self, pixels, rng):
        """Pixels (N, 2) of corners in the mirror with errors."""
        return pixels + rng.normal(0, self.corner_px, pixels.shape)

    plate_corners = corners

    def in_mirror(self, points, rng):
        """Points (N, 2) mm of the monitor, decoded in the flexible mirror."""
        return points + rng.normal(0, self.decoded_mm, points.shape)

    in_platter = in_mirror

    def mounted(self, platter, rng, positions):
        """The `Platter` at each of the monitor's positions, exactly on its board."""
        return [platter] * positions

    @property
    def plate_sd_px(self):
        """Standard deviation of a corner of the platter's board along an axis, px."""
        return self.corner_px

    @property
    def platter_sd_mm(self):
        """Standard deviation of a point decoded in the platter along an axis, mm."""
        return self.decoded_mm
