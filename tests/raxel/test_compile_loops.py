"""What is compiled ahead is what an image and two detectors run through."""

import sys

import cv2
import numpy as np
from numba.core.dispatcher import Dispatcher

from raxel.compile_loops import BOARD, CAMERA, DISTANCE_MM, compile_loops
from raxel.features import find_board
from raxel.features.celect import celect
from raxel.geometry import on_plane


def test_compile_loops_detects_rendered_board():
    points = on_plane(BOARD.points() - BOARD.points().mean(axis=0))
    true = CAMERA.project(points + [0, 0, DISTANCE_MM]).pixels
    found = compile_loops()
    nearest = np.linalg.norm(true[:, None] - found, axis=2).min(axis=1)
    assert nearest.max() < 0.3


def compiled():
    """How many forms of its arguments each loop of the library is compiled for."""
    modules = [m for name, m in sys.modules.items() if name.startswith("raxel.")]
    return {
        f"{module.__name__}.{name}": len(loop.signatures)
        for module in modules
        for name, loop in vars(module).items()
        if isinstance(loop, Dispatcher)
    }


def test_larger_board_needs_no_compilation():
    compile_loops()
    before = compiled()
    assert sum(before.values()) > 10
    squares = np.kron(np.indices((9, 11)).sum(axis=0) % 2, np.ones((40, 40)))
    image = np.pad(40 + 170 * squares, 60, constant_values=210)
    image = cv2.GaussianBlur(image, (0, 0), 1.2).astype(np.uint8)
    u, v = 99.5 + 40 * np.array([0, 9]), 99.5 + 40 * np.array([0, 7])
    clicks = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]]
    assert find_board(image, 10, 8).found
    assert celect(image, clicks, 10, 8).found
    assert {name: n for name, n in compiled().items() if n != before.get(name)} == {}
