"""6.3.1: which part of a coded grid a bent picture shows, from one picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.lattices import outer, steps_between
from chapters.shared.scoring import LOST_PX
from chapters.shared.synthetic_board import SIZE_PX, SyntheticBoard, clicks
from raxel.features.celect import celect
from raxel.features.coded_grid import coded_grid, locate, read_squares
from raxel.geometry.poses import pose, rotation_from_vector, transform
from raxel.lab import Rectangle, TexturedScene, render
from raxel.lab.coded_texture import CodedTexture

SQUARES = 20
SQUARES_TO_FOCAL = 3
BLOCK = 6
LEAST_SPACING_PX = 15.0
MOST_TILT_DEG = 20.0
MOST_SHIFT = 2.5
POSES = 4
BLUR_PX = 1.0
SEEDS = {"coded": 631, "another code": 632}

# Faint marks have less contrast than an edge needs to be one (Canny's 0.3).
MARKS = {"full": 1.0, "faint": 0.25}
FOV_DEG = (120, 134, 146, 152)
NOISE_SD = (10, 30, 50, 70)
FALSE_GRIDS = ("another code", "no marks")
DEFAULT = {"grid": "coded", "marks": "full", "fov_deg": 134, "noise_sd": 10}
PICTURES = 4
TRIALS = {"quick": 1, "full": 40}
OUTCOMES = (
    "right",
    "a corner off",
    "refused by CELECT",
    "refused by the decoder",
    "wrong place",
)
SETTINGS = {
    "image_px": SIZE_PX,
    "squares": [SQUARES, SQUARES],
    "squares_to_a_focal_length": SQUARES_TO_FOCAL,
    "block_corners": [BLOCK, BLOCK],
    "least_spacing_px": LEAST_SPACING_PX,
    "most_tilt_deg": MOST_TILT_DEG,
    "most_shift_squares": MOST_SHIFT,
    "poses": POSES,
    "blur_px": BLUR_PX,
    "clicks": {"sd_px": 2.0, "cap_px": 4.0},
    "lost_px": LOST_PX,
    "contrast_of_marks": MARKS,
}


def conditions(effort):
    """Fields of view, noise, and grids that are not the one looked for."""
    fields, levels = FOV_DEG, NOISE_SD
    if effort == "quick":
        fields, levels = (134,), (10,)
    changes = [{"fov_deg": f} for f in fields]
    changes += [{"noise_sd": n} for n in levels if n != DEFAULT["noise_sd"]]
    swept = [DEFAULT | {"marks": m} | change for m in MARKS for change in changes]
    faint = DEFAULT | {"marks": "faint"}
    return swept + [faint | {"grid": name} for name in FALSE_GRIDS]


@lru_cache
def code_of(name):
    """The code of a grid; the one that is looked for is called 'coded'."""
    return coded_grid(SQUARES, SQUARES, np.random.default_rng(SEEDS[name]))


@dataclass(frozen=True)
class CodedView:
    """A coded grid, larger than the picture, before the fisheye of 3.3.1.

    number: which of the poses, turned and shifted at random, tilted by up to 20 deg.
    """

    grid: str
    marks: str
    fov_deg: float
    number: int

    @property
    def board(self):
        """The board whose camera takes the picture."""
        return SyntheticBoard(fov_deg=self.fov_deg)

    @property
    def square_px(self):
        """Side of a square in pixels of the picture before it is bent."""
        return self.board.focal_px / SQUARES_TO_FOCAL

    @cached_property
    def T_camera_grid(self):
        """Pose (4, 4); the grid's origin is the outer corner of square (0, 0)."""
        rng = np.random.default_rng([SEEDS["coded"], self.number])
        turn = rng.uniform(0, 2 * math.pi)
        about, tilt = rng.uniform(0, 2 * math.pi), rng.uniform(0, 1)
        tilt = math.radians(MOST_TILT_DEG * tilt)
        axis = [tilt * math.cos(about), tilt * math.sin(about), 0.0]
        R = rotation_from_vector(np.array(axis)) @ rotation_from_vector(
            np.array([0.0, 0.0, turn])
        )
        shift = rng.uniform(-MOST_SHIFT, MOST_SHIFT, 2)
        middle = np.append((SQUARES / 2 + shift) * self.square_px, 0.0)
        return pose(R, [0, 0, self.board.focal_px] - R @ middle)

    @cached_property
    def corners(self):
        """True corners (21, 21, 2) px by (row, column); NaN where out of sight."""
        numbers = np.indices((SQUARES + 1, SQUARES + 1)).reshape(2, -1)
        points = np.zeros((numbers.shape[1], 3))
        points[:, :2] = self.square_px * numbers[::-1].T
        seen = self.board.camera.project(transform(self.T_camera_grid, points)).pixels
        seen = np.where(
            ((seen >= 0) & (seen <= SIZE_PX - 1)).all(axis=1)[:, None], seen, np.nan
        )
        return seen.reshape(SQUARES + 1, SQUARES + 1, 2)

    def image(self, noise_sd, rng):
        """The picture, uint8 (1000, 1000)."""
        grey = 255 * _blurred(self)
        grey = grey + rng.normal(0.0, noise_sd, grey.shape)
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)

    def blocks(self):
        """First corners (n, 2), (row, column), of blocks that a user would click.

        6 x 6 corners with one more ring of corners in the picture, none nearer to the
        next than 15 px.
        """
        whole = BLOCK + 2
        last = SQUARES + 1 - whole
        found = []
        for row, column in np.ndindex(last + 1, last + 1):
            block = self.corners[row : row + whole, column : column + whole]
            if steps_between(block).min() >= LEAST_SPACING_PX:
                found.append((row + 1, column + 1))
        return np.array(found)


@lru_cache(maxsize=POSES)
def _blurred(view):
    if view.grid == "no marks":
        bits = np.zeros((SQUARES, SQUARES), bool)
    else:
        bits = code_of(view.grid).bits
    texture = CodedTexture(
        bits, view.square_px, contrast=MARKS[view.marks], black=0.0, white=1.0
    )
    corner, size = texture.extent
    sheet = Rectangle(view.T_camera_grid, *size, corner)
    picture = render(view.board.camera, np.eye(4), TexturedScene(((sheet, texture),)))
    return cv2.GaussianBlur(picture, (0, 0), BLUR_PX)


def picture_trial(condition, rng):
    """A picture whose block is found: its clicks, corners, and their numbers."""
    block = clicked_block(condition, rng)
    found = celect(block.image, block.clicks, BLOCK, BLOCK)
    values, location = decoded(block, found, condition)
    if location is None or not location.found:
        return values
    return values | {
        "picture": block.image,
        "clicks": block.clicks,
        "corners": found.corners,
        "numbers": location.indices,
    }


class Block(NamedTuple):
    """A clicked block: image, clicks (4, 2), true corners (6, 6, 2) px.

    numbers: (6, 6, 2), the corners' (row, column) on the grid.
    """

    image: np.ndarray
    clicks: np.ndarray
    true: np.ndarray
    numbers: np.ndarray


def clicked_block(condition, rng):
    """A Block that a user might click: any of a view's, from any corner on."""
    pose_number = int(rng.integers(POSES))
    view = CodedView(
        condition["grid"], condition["marks"], condition["fov_deg"], pose_number
    )
    row, column = rng.choice(view.blocks())
    numbers = np.indices((BLOCK, BLOCK)).transpose(1, 2, 0) + (row, column)
    numbers = np.rot90(numbers, int(rng.integers(4)))
    true = view.corners[numbers[..., 0], numbers[..., 1]]
    where = clicks(outer(true), rng)
    return Block(view.image(condition["noise_sd"], rng), where, true, numbers)


def decoded(block, found, condition):
    """(values, Location or None) of CELECT's result `found`, judged by the truth.

    A place on a grid that is not the coded one is wrong whatever it is.
    """
    if not found.found:
        return {"outcome": "refused by CELECT"}, None
    contrast = MARKS[condition["marks"]]
    squares = read_squares(block.image, found.corners, contrast)
    location = locate(squares, code_of("coded"))
    off = np.linalg.norm(found.corners - block.true, axis=2).max()
    values = {
        "off_px": float(off),
        "ordered": bool(off <= LOST_PX),
        "errors": location.errors,
        "unclear": location.unclear,
    }
    place = (location.indices == block.numbers).all()
    if not location.found:
        outcome = "refused by the decoder"
        values["reason"] = location.reason
    elif condition["grid"] != "coded" or not place:
        outcome = "wrong place"
    else:
        outcome = "right" if off <= LOST_PX else "a corner off"
    return values | {"outcome": outcome}, location
