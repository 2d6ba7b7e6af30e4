"""Where a target stands before a camera: a list of poses, or a seeded distribution.

Only poses that keep the target in view count. Whether they do is a matter of geometry:
no picture is rendered and no detector asked.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import (
    pose,
    rotate,
    rotation_from_vector,
    transform,
)

TRIES_PER_POSE = 1000
OUTLINE_POINTS = 25
IN_VIEW = ""


@dataclass(frozen=True)
class View:
    """When a target counts as seen.

    margin_px: least distance of its whole outline from the image's border;
    least_spacing_px: least distance between neighbours of its lattice in the image.
    """

    margin_px: float = 0.0
    least_spacing_px: float = 0.0

    def fault(self, camera, T_camera_target, outline, lattice):
        """Why the target is not seen whole at this pose; '' where it is.

        outline: (N, 2) points around the target, lattice: (rows, columns, 2) points on
        it, in its plane, mm. Its face is the side its z axis points away from.
        """
        shape = lattice.shape[:2]
        flat = np.concatenate([outline, lattice.reshape(-1, 2)])
        points = transform(T_camera_target, np.pad(flat, ((0, 0), (0, 1))))
        pixels, valid = camera.project(points)
        if not valid.all():
            return "outside the field of view"
        low, high = self.margin_px - 0.5, np.array([camera.width, camera.height]) - 0.5
        if not np.all((pixels >= low) & (pixels <= high - self.margin_px)):
            return "too near the image's border"
        normal = rotate(T_camera_target, np.array([0.0, 0.0, 1.0]))
        if not np.all(camera.rays(pixels).directions @ normal > 0):
            return "seen from behind"
        seen = pixels[len(outline) :].reshape(*shape, 2)
        steps = [np.linalg.norm(np.diff(seen, axis=k), axis=2).min() for k in (0, 1)]
        return IN_VIEW if min(steps) >= self.least_spacing_px else "too small"


@dataclass(frozen=True)
class ListedPoses:
    """Poses T_camera_target (n, 4, 4), in the order they are used."""

    poses: np.ndarray

    def draw(self, rng, count, middle, fault):
        """The first `count` poses; InputError where one is missing or not in view."""
        if count > len(self.poses):
            raise InputError(
                f"field 'list': {len(self.poses)} poses found, {count} needed; add some"
            )
        for index, T in enumerate(self.poses[:count]):
            reason = fault(T)
            if reason:
                raise InputError(
                    f"field 'list[{index}]': the target is {reason}; mend the pose"
                )
        return self.poses[:count].copy()


@dataclass(frozen=True)
class DrawnPoses:
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

    def draw(self, rng, count, middle, fault):
        """Poses (count, 4, 4) that show the target.

        middle: (2,) of the target, mm; fault: pose -> why it is not in view, or ''.
        Raises InputError with the count of tries and the reasons where there are none.
        """
        poses, reasons = [], Counter()
        for _ in range(TRIES_PER_POSE * count):
            T = self._one(rng, middle)
            reason = fault(T)
            reasons[reason] += 1
            if not reason:
                poses.append(T)
            if len(poses) == count:
                return np.stack(poses)
        del reasons[IN_VIEW]
        told = ", ".join(f"{n} times {why}" for why, n in reasons.most_common())
        raise InputError(
            f"{len(poses)} of {count} poses found that show the target, in "
            f"{TRIES_PER_POSE * count} tries ({told}); give other ranges"
        )

    def _one(self, rng, middle):
        distance, off_axis, tilt, turn = (
            rng.uniform(*limits)
            for limits in (self.distance_mm, self.off_axis, self.tilt, self.turn)
        )
        azimuth, axis = rng.uniform(0, 2 * np.pi, 2)
        towards = rotation_from_vector(
            off_axis * np.array([-np.sin(azimuth), np.cos(azimuth), 0])
        )
        tilted = rotation_from_vector(tilt * np.array([np.cos(axis), np.sin(axis), 0]))
        R = towards @ tilted @ rotation_from_vector(np.array([0, 0, turn]))
        return pose(R, distance * towards[:, 2] - R @ [*middle, 0])


def outline_of(corner, size):
    """Points (4 n, 2) around a rectangle from `corner` (2,) of `size` (2,), mm."""
    along = np.linspace(0, 1, OUTLINE_POINTS, endpoint=False)
    zero, one = np.zeros_like(along), np.ones_like(along)
    x = np.concatenate([along, one, 1 - along, zero])
    y = np.concatenate([zero, along, one, 1 - along])
    return np.asarray(corner) + np.column_stack([x, y]) * size
