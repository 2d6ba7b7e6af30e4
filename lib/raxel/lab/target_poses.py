"""Poses of a target in view of a camera: a list, or a seeded random distribution.

Only poses that keep the target in view count. This is tested geometrically, without
rendering or detection.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera
from raxel.errors import InputError
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import (
    inverse_pose,
    pose,
    rotate,
    rotation_from_vector,
    transform,
)

MAX_TRIES_PER_POSE = 1000
# If none of so many poses shows the target, the ranges are wrong.
MAX_TRIES_FOR_FIRST = 1000
OUTLINE_POINTS = 25
IN_VIEW = ""
OUT_OF_VIEW = "outside the field of view"
# Lines of sight from a viewer to its mirror that a target must leave free, each way.
SIGHT_LINES = 24
# Pixels along each axis, of which one must view a partly visible target.
PIECE_LINES = 100
# Bisection of the distance, as shares of the target's diagonal.
MIN_DISTANCE_RATIO, MAX_DISTANCE_RATIO, N_HALVINGS = 0.02, 100.0, 60


@dataclass(frozen=True)
class Visibility:
    """Conditions under which a target counts as visible.

    Attributes
    ----------
    margin_px : float
        Least distance of the whole outline from the image's border, px.
    least_spacing_px : float
        Least distance between neighbours of its lattice in the image, px.
    whole : bool
        False where a piece of the target is enough.
    """

    margin_px: float = 0.0
    least_spacing_px: float = 0.0
    whole: bool = True

    def fault(
        self,
        camera: Camera,
        T_camera_target: NDArray[np.float64],
        outline: NDArray[np.float64],
        lattice: NDArray[np.float64],
    ) -> str:
        """Return why the target is not visible at a pose; '' where it is.

        The target's face is the side its z axis points away from. A discontinuous
        camera sees a target in pieces, and at least one is required.

        Parameters
        ----------
        camera : Camera
            Any camera.
        T_camera_target : (4, 4) array
            Pose of the target, mm.
        outline : (N, 2) array
            Points around the target in its plane, mm.
        lattice : (rows, columns, 2) array
            Points on the target in its plane, mm.

        Returns
        -------
        str
            The reason, such as 'outside the field of view'.
        """
        if _hides_mirror(camera, T_camera_target, outline):
            return "between viewer and mirror"
        if not (self.whole and camera.continuous):
            seen = _shows_a_piece(camera, T_camera_target, outline)
            return IN_VIEW if seen else OUT_OF_VIEW
        # The four corners first, then the last rows: they reject most invalid poses,
        # while a whole lattice has up to a million points.
        corners = outline[:: max(1, len(outline) // 4)]
        _, reason = self._seen(camera, T_camera_target, corners)
        for rows in (lattice[:2], lattice[-2:]):
            reason = reason or self._lattice_fault(camera, T_camera_target, rows)
        if reason:
            return reason
        flat = np.concatenate([outline, lattice.reshape(-1, 2)])
        pixels, reason = self._seen(camera, T_camera_target, flat)
        if reason:
            return reason
        normal = rotate(T_camera_target, np.array([0.0, 0.0, 1.0]))
        if not np.all(camera.rays(pixels).directions @ normal > 0):
            return "visible from behind"
        return self._spacing_fault(pixels[len(outline) :].reshape(lattice.shape))

    def _lattice_fault(self, camera, T_camera_target, lattice):
        pixels, reason = self._seen(camera, T_camera_target, lattice.reshape(-1, 2))
        return reason or self._spacing_fault(pixels.reshape(lattice.shape))

    def _spacing_fault(self, seen):
        """Return the fault of neighbours in the image, `seen` (rows, columns, 2)."""
        steps = [np.linalg.norm(np.diff(seen, axis=k), axis=2).min() for k in (0, 1)]
        return IN_VIEW if min(steps) >= self.least_spacing_px else "too small"

    def _seen(self, camera, T_camera_target, flat):
        """(pixels, fault) of points (N, 2) of the target's plane."""
        points = transform(T_camera_target, on_plane(flat))
        pixels, valid = camera.project(points)
        if not valid.all():
            return pixels, OUT_OF_VIEW
        low, high = self.margin_px - 0.5, np.array([camera.width, camera.height]) - 0.5
        if not np.all((pixels >= low) & (pixels <= high - self.margin_px)):
            return pixels, "too near the image's border"
        return pixels, IN_VIEW


def _shows_a_piece(camera, T_camera_target, outline):
    """Whether one of some pixels spread over the image views the face of a target."""
    u, v = (np.linspace(0, n - 1, PIECE_LINES) for n in (camera.width, camera.height))
    rays = camera.rays(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_target)
    low, high = outline.min(axis=0), outline.max(axis=0)
    with np.errstate(invalid="ignore"):
        on = np.all((met.points >= low) & (met.points <= high), axis=1)
        facing = rays.directions @ T_camera_target[:3, 2] > 0
    return bool(np.any(on & facing & met.valid))


@lru_cache(maxsize=8)
def _mirror_points(camera):
    """Return points (N, 3) spread over the mirror, in the viewer's frame, or None."""
    u, v = np.meshgrid(
        np.linspace(0, camera.width - 1, SIGHT_LINES),
        np.linspace(0, camera.height - 1, SIGHT_LINES),
    )
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]))
    points = rays.origins[rays.valid]
    return points if points.any() else np.empty((0, 3))


def _hides_mirror(camera, T_camera_target, outline):
    """Whether a target is between a viewer at the origin and its mirror."""
    T = inverse_pose(T_camera_target)
    eye, ends = T[:3, 3], transform(T, _mirror_points(camera))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = eye[2] / (eye[2] - ends[:, 2])
        met = eye[:2] + share[:, None] * (ends[:, :2] - eye[:2])
        within = (met >= outline.min(axis=0)) & (met <= outline.max(axis=0))
        return bool(np.any((share > 0) & (share < 1) & within.all(axis=1)))


@dataclass(frozen=True)
class ListedPoses:
    """Hold poses T_camera_target (n, 4, 4), in the order of use.

    names: of their views, None for a number; patterns_only: views without a monitor's
    chessboard; lens_shifts: (n, 2) px, shift of the image on the sensor in each view.
    shift_mm, turn: precision of a manual setup, standard deviations of the target's
    centre along each axis and of its orientation about each (radians).
    """

    poses: np.ndarray
    names: tuple[str | None, ...]
    patterns_only: tuple[bool, ...]
    lens_shifts: tuple[tuple[float, float], ...] = ()
    shift_mm: float = 0.0
    turn: float = 0.0

    def draw(self, rng, count, extent, fault):
        """The first `count` poses; InputError where one is missing or not in view."""
        if count > len(self.poses):
            raise InputError(
                f"field 'list': {len(self.poses)} poses; give {count} or more"
            )
        poses = np.stack([self._set_up(T, rng, extent) for T in self.poses[:count]])
        for index, T in enumerate(poses):
            reason = fault(T)
            if reason:
                raise InputError(
                    f"field 'list[{index}]': the target is {reason}; correct the pose"
                )
        return poses

    def _set_up(self, T, rng, extent):
        if not self.shift_mm and not self.turn:
            return T
        shift, turn = rng.normal(size=(2, 3)) * [[self.shift_mm], [self.turn]]
        middle = np.array([*(extent[0] + extent[1] / 2), 0])
        R = rotation_from_vector(turn) @ T[:3, :3]
        return pose(R, transform(T, middle) + shift - R @ middle)


class _RandomPoses:
    """Poses drawn one by one until enough of them show the target."""

    def draw(self, rng, count, extent, fault):
        """Return poses (count, 4, 4) with the target in view.

        extent: (corner (2,), size (2,)) of the whole target, mm; fault: pose -> why it
        is not in view, or ''. Raises InputError with the number of tries and the
        reasons if there are too few.
        """
        poses, reasons = [], Counter()
        for tries in range(1, MAX_TRIES_PER_POSE * count + 1):
            T = self._one(rng, *extent)
            reason = fault(T)
            reasons[reason] += 1
            if not reason:
                poses.append(T)
            if len(poses) == count:
                return np.stack(poses)
            if tries == MAX_TRIES_FOR_FIRST and not poses:
                break
        del reasons[IN_VIEW]
        listed = ", ".join(f"{n} times {why}" for why, n in reasons.most_common())
        raise InputError(
            f"{len(poses)} of {count} poses show the target, in {tries} tries "
            f"({listed}); give other ranges"
        )


@dataclass(frozen=True)
class DrawnPoses(_RandomPoses):
    """Independent, uniform draws; each of the four is (least, greatest).

    distance_mm: from the camera's origin to the target's middle; off_axis: angle of
    the middle from the camera's z axis, in any azimuth; tilt: angle between the line
    to the middle and the target's normal, about any axis in its plane; turn: in its
    plane. Angles in radians.
    """

    distance_mm: tuple[float, float]
    off_axis: tuple[float, float]
    tilt: tuple[float, float]
    turn: tuple[float, float]

    def _one(self, rng, corner, size):
        distance, off_axis, tilt, turn = (
            rng.uniform(*limits)
            for limits in (self.distance_mm, self.off_axis, self.tilt, self.turn)
        )
        towards, R = _orientation(rng, off_axis, tilt, turn)
        return pose(R, distance * towards[:, 2] - R @ [*(corner + size / 2), 0])


@dataclass(frozen=True)
class AroundPoses(_RandomPoses):
    """Draw independent, uniform values of a target's apparent size and direction.

    centre: (3,) mm and axis: (3,), where angles are measured, camera frame; polar:
    angle of the target's centre from the axis, in any azimuth; subtense: the largest
    angle between two of the target's four corners, which fixes its distance; tilt and
    turn: as in DrawnPoses. Angles in radians, each (minimum, maximum).
    """

    centre: tuple[float, float, float]
    axis: tuple[float, float, float]
    polar: tuple[float, float]
    tilt: tuple[float, float]
    subtense: tuple[float, float]
    turn: tuple[float, float]

    def _one(self, rng, corner, size):
        polar, tilt, subtense, turn = (
            rng.uniform(*limits)
            for limits in (self.polar, self.tilt, self.subtense, self.turn)
        )
        towards, R = _orientation(rng, polar, tilt, turn)
        forward = _turned_to(self.axis)
        towards, R = forward @ towards, forward @ R
        arms = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size / 2
        arms = on_plane(arms) @ R.T
        distance = _distance_for(subtense, arms, towards[:, 2])
        middle = np.array(self.centre) + distance * towards[:, 2]
        return pose(R, middle - R @ [*(corner + size / 2), 0])


def _orientation(rng, off_axis, tilt, turn):
    """Rotations (3, 3): of the line to the middle, and of the target; any azimuths."""
    azimuth, axis = rng.uniform(0, 2 * np.pi, 2)
    towards = rotation_from_vector(
        off_axis * np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    )
    tilted = rotation_from_vector(tilt * np.array([np.cos(axis), np.sin(axis), 0]))
    return towards, towards @ tilted @ rotation_from_vector(np.array([0, 0, turn]))


def _turned_to(axis):
    """Return the smallest rotation that maps the z axis to `axis` (3,)."""
    axis = np.array(axis, float) / np.linalg.norm(axis)
    across = np.cross([0, 0, 1], axis)
    if not across.any():
        return np.diag([1.0, np.sign(axis[2]), np.sign(axis[2])])
    angle = np.arctan2(np.linalg.norm(across), axis[2])
    return rotation_from_vector(angle * across / np.linalg.norm(across))


def _distance_for(subtense, arms, towards):
    """Distance at which corners `arms` (4, 3) about the middle subtend an angle.

    The angle falls from 180 degrees next to the middle to 0 far away.
    """
    near, far = np.array([MIN_DISTANCE_RATIO, MAX_DISTANCE_RATIO]) * np.linalg.norm(
        arms[0] - arms[2]
    )
    for _ in range(N_HALVINGS):
        distance = np.sqrt(near * far)
        lines = arms + distance * towards
        lines /= np.linalg.norm(lines, axis=1, keepdims=True)
        too_wide = (lines @ lines.T).min() < np.cos(subtense)
        near, far = (distance, far) if too_wide else (near, distance)
    return np.sqrt(near * far)


def outline_of(corner: ArrayLike, size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points around a rectangle.

    Parameters
    ----------
    corner : (2,) array_like
        Corner of the least x and y, mm.
    size : (2,) array
        Width and height, mm.

    Returns
    -------
    (4 n, 2) array
        Points in the rectangle's plane, n = 25 from each corner on, mm.
    """
    along = np.linspace(0, 1, OUTLINE_POINTS, endpoint=False)
    zero, one = np.zeros_like(along), np.ones_like(along)
    x = np.concatenate([along, one, 1 - along, zero])
    y = np.concatenate([zero, along, one, 1 - along])
    return np.asarray(corner) + np.column_stack([x, y]) * size
