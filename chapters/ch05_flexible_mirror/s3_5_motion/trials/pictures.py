"""The moved cylinder photographed in the bent mirror, and its marks found.

Discs are printed on the cylinder, five by five. Six pictures are rendered through the
laboratory, with a quarter of the pixels each way. Dark patches are found by OpenCV's
connected components, and the place of one is the middle of its darkness. Which mark a
patch is, the truth says, as a person would by looking. Places are given in pixels of
the whole camera, which is what is calibrated.
"""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.calibrated import LAST, calibrated
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import motion_and_shape
from chapters.ch05_flexible_mirror.s3_5_motion.trials.run import EVERY_WAY, bundled
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    MOST_TRIES,
    RADIUS_MM,
    MovedCylinder,
    placed_cylinder,
    seen_in_all,
)
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED
from raxel.geometry import pose
from raxel.lab import Cylinder, ImageTexture, TexturedScene
from raxel.lab.windowed import window_around, windowed

# Where discs are: radians around, from what faces the mirror, and mm up; their radius.
TURNS = np.radians(np.linspace(-56, 56, 5))
HEIGHTS_MM = np.linspace(-60, 60, 5)
DISC_MM = 4.0
# Of the cylinder and its print: mm; radiances of marks, paper and the wall behind.
TALL_MM, PRINT_MM = 240.0, 0.25
INK, PAPER, WALL = 0.06, 0.85, 0.6
# A patch is darker than this share of white, has so many px, and lies so near to its
# mark. The room beyond the mirror is dark as well, but larger.
DARK, LEAST_PX, MOST_PX, NEAR_PX = 0.45, 20, 600, 4.0
SOFT_PX = 2  # around a patch, over which its edge is blurred
# Px of the whole camera for one of the pictures', and what a mark is off by, of the
# whole camera, along an axis: a fifteenth of a px of the picture's.
COARSE, MARK_PX = 4, 0.25
# The later place that is set beside the first one: 100 mm away.
BESIDE = (4,)


class TakenPictures(NamedTuple):
    """scene: the MovedCylinder, its marks those that are printed, 25; pixels
    (6, 25, 2): where they were found, NaN where not; pictures: six (h, w)
    uint8, of what is around the marks."""

    scene: MovedCylinder
    pixels: np.ndarray
    pictures: list

    def scores(self):
        """How many marks were found in all places, and how far they are off, px of
        the whole camera along an axis."""
        off = self.pixels - self.scene.pixels
        return {
            "found": int(np.isfinite(off).all(axis=(0, 2)).sum()),
            "mark_px": float(np.sqrt(np.nanmean(off**2))),
        }


def photographed(small, seen, true, rng):
    """TakenPictures of a cylinder before a mirror.

    small: MirrorRig with a quarter of the pixels; seen: its camera; true: that of the
    whole rig, of the same mirror. RuntimeError where no place shows all marks.
    """
    turn, height = (one.ravel() for one in np.meshgrid(TURNS, HEIGHTS_MM))
    for _ in range(MOST_TRIES):
        placed = placed_cylinder(true, rng)
        points, T = placed.points(turn, height), placed.motions()
        pixels, visible = seen_in_all(true, points, T)
        if visible.all():
            break
    else:
        raise RuntimeError("pictures: no place shows all marks in all six pictures")
    paper = ImageTexture(printed(turn, height), PRINT_MM)
    mantle = frame_of(placed)
    pictures, found = [], []
    for one, where in zip(T, small_px(pixels), strict=True):
        window = window_around(seen, where)
        taken = windowed(replace(small.rig, camera=seen), window).laboratory()
        scene = scene_of(one @ mantle, paper)
        pictures.append(taken.photograph(scene, np.eye(4), rng))
        first = np.array([window.u, window.v], float)
        found.append(whole_px(first + marks_in(pictures[-1], where - first)))
    scene = MovedCylinder(points, T, pixels, placed.axis)
    return TakenPictures(scene, np.array(found), pictures)


def whole_px(pixels):
    """Pixels of the whole camera, whose pixels are a quarter as large."""
    return COARSE * pixels + (COARSE - 1) / 2


def small_px(pixels):
    """The other way."""
    return (pixels - (COARSE - 1) / 2) / COARSE


def frame_of(placed):
    """T_camera_mantle (4, 4): z along the axis, y towards the mirror, at its foot."""
    x, z = placed.axes[:, 0], placed.axes[:, 1]
    foot = placed.middle - TALL_MM / 2 * z
    return pose(np.column_stack([x, -placed.axes[:, 2], z]), foot)


def printed(turn, height):
    """Paper (rows, columns) with discs: along it the mantle's half, up its height."""
    u = (np.arange(int(np.pi * RADIUS_MM / PRINT_MM)) + 0.5) * PRINT_MM
    v = (np.arange(int(TALL_MM / PRINT_MM)) + 0.5) * PRINT_MM
    paper = np.full((len(v), len(u)), PAPER)
    for t, h in zip(turn, height, strict=True):
        away = np.hypot(u - RADIUS_MM * (np.pi / 2 - t), v[:, None] - (h + TALL_MM / 2))
        share = np.clip((DISC_MM - away) / PRINT_MM + 0.5, 0, 1)
        paper += share * (INK - PAPER)
    return paper


def scene_of(T_camera_mantle, paper):
    """The TexturedScene of the cylinder before an even wall."""
    mantle = Cylinder(T_camera_mantle, RADIUS_MM, TALL_MM)
    return TexturedScene(((mantle, paper),), WALL)


def marks_in(picture, near):
    """Places (N, 2) px of dark patches next to `near` (N, 2), NaN where there is none.

    The middle of a patch's darkness, over its own box and a little around it.
    """
    white = np.quantile(picture, 0.99)
    dark = (picture < DARK * white).astype(np.uint8)
    _, _, boxes, middles = cv2.connectedComponentsWithStats(dark, connectivity=8)
    size = boxes[:, cv2.CC_STAT_AREA]
    right = (size >= LEAST_PX) & (size <= MOST_PX)
    found = np.full(near.shape, np.nan)
    if not right.any():
        return found
    boxes, middles = boxes[right], middles[right]
    for k, place in enumerate(near):
        away = np.linalg.norm(middles - place, axis=1)
        if away.min() < NEAR_PX:
            found[k] = _middle_of_darkness(picture, boxes[away.argmin()])
    return found


def _middle_of_darkness(picture, box):
    x, y, width, height = (int(n) for n in box[:4])
    x0, y0 = max(x - SOFT_PX, 0), max(y - SOFT_PX, 0)
    part = picture[y0 : y + height + SOFT_PX, x0 : x + width + SOFT_PX].astype(float)
    rim = np.concatenate([part[0], part[-1], part[:, 0], part[:, -1]])
    weight = np.maximum(np.median(rim) - part, 0)
    rows, columns = np.indices(part.shape)
    return np.array(
        [(weight * columns).sum(), (weight * rows).sum()]
    ) / weight.sum() + [x0, y0]


def pictures_trial(condition, rng, errors, benches, ways=EVERY_WAY):
    """The motion from pictures on each of some benches, by some cameras."""
    geometry, seed = condition["geometry"], int(rng.integers(2**32))
    rig, small = mirror_rig(geometry), mirror_rig(geometry, small=True)
    out = {}
    for name, bench in benches.items():
        own = errors[geometry]._replace(factor=bench.factor)
        mirror = {"aberration_um": bench.aberration_um, "seed": seed}
        cameras = rig.stages(**mirror)
        seen = small.camera(STAGES_MM[LAST], **mirror)
        drawn = np.random.default_rng([seed, LAST])
        taken = photographed(small, seen, cameras[LAST], drawn)
        out[name] = taken.scores() | {
            "first": taken.pictures[0],
            "last": taken.pictures[-1],
        }
        seers = {"true": (cameras[LAST], "")}
        if "published" in ways:
            found, refusal = calibrated(rig, cameras, own, seed, PUBLISHED)
            seers["published"] = found.last, refusal
        if "bundle" in ways:
            seers["bundle"] = bundled(rig, cameras, own, seed)
        for way, (camera, refusal) in seers.items():
            out[name][way] = {"refused": refusal}
            if camera is not None:
                drawn = np.random.default_rng([seed, LAST + 1])
                out[name][way] = motion_and_shape(
                    camera, taken.scene, taken.pixels, drawn, BESIDE, MARK_PX
                )
    return out
