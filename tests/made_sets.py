"""Sets whose corners come from a camera, with grey images, for tests of `calibrate`."""

import json

import cv2
import numpy as np

from raxel.calibration.views.correspondence import BoardShape
from raxel.cameras import FisheyeCamera, PerspectiveCamera, Projection
from raxel.geometry.poses import pose, rotation_from_vector, transform
from raxel.sets.model import Chessboard
from tests.image_sets import write_description

WIDTH, HEIGHT, COLUMNS, ROWS = 320, 240, 9, 7
BOARD = Chessboard(COLUMNS, ROWS, 20.0)
CENTRE = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
K = np.array([[300.0, 0, CENTRE[0]], [0, 300.0, CENTRE[1]], [0, 0, 1]])
PINHOLE = PerspectiveCamera(K, [-0.2, 0.05], WIDTH, HEIGHT)
FISHEYE = FisheyeCamera("equisolid", 90.0, CENTRE, WIDTH, HEIGHT, np.pi / 2)


class WavyCamera:
    """The pinhole with its centre 9 mm to and fro across the image: not central."""

    def project(self, points):
        pixels = PINHOLE.project(points).pixels
        for _ in range(30):
            aside = np.zeros_like(points)
            aside[:, 0] = 9 * np.sin(4 * np.pi * pixels[:, 1] / HEIGHT)
            pixels = PINHOLE.project(points - aside).pixels
        return Projection(pixels, np.isfinite(pixels[:, 0]))


def board_poses(seed, count, distance, spread, tilt=0.5):
    """Poses (count, 4, 4) of boards in front of a camera, tilted all ways."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, count, endpoint=False) + rng.uniform(0, 1)
    across = tilt * np.column_stack([np.cos(around), np.sin(around)])
    R = rotation_from_vector(np.column_stack([across, rng.uniform(-0.3, 0.3, count)]))
    reach = np.array([spread, 0.7 * spread])
    low, high = [*-reach, distance[0]], [*reach, distance[1]]
    t = rng.uniform(low, high, (count, 3))
    return pose(R, t - R @ [*BOARD.points().mean(axis=0), 0.0])


def boards_of(camera, seed=0, count=6, noise=0.05, bend=0.0, row=0.0):
    """Corners (N, 2) of each of `count` boards in the image, with noise in px; bend:
    how far the ends of the board's x lie behind its middle; row: how far its third row
    is printed along x from where it should be, in mm."""
    distance, spread = ((120, 180), 110) if camera is FISHEYE else ((330, 480), 40)
    rng = np.random.default_rng(seed)
    flat = BOARD.points()
    half = np.ptp(flat, axis=0) / 2
    shape = BoardShape(flat.mean(axis=0), half, np.array([bend, 0.0, 0.0, 0.0]))
    solid, found = shape.points(flat), []
    solid[flat[:, 1] == 2 * BOARD.pitch_mm, 0] += row
    for T in board_poses(seed, 10 * count, distance, spread):
        pixels = camera.project(transform(T, solid)).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        if np.all((pixels >= 0) & (pixels <= [WIDTH - 1, HEIGHT - 1])):
            found.append(pixels)
    assert len(found) >= count
    return found[:count]


def write_made_set(folder, boards, names=None):
    """A set of grey images, and a file with its corners; None: no board.

    Returns both paths. The file is next to the folder.
    """
    folder.mkdir()
    names = names or [f"{k}.png" for k in range(len(boards))]
    grey = np.full((HEIGHT, WIDTH), 90, np.uint8)
    entries = []
    for name, corners in zip(names, boards, strict=True):
        (folder / name).write_bytes(cv2.imencode(".png", grey)[1].tobytes())
        entry = {"file": name, "found": corners is not None, "reason": "too dark"}
        if corners is not None:
            entry |= {"columns": COLUMNS, "rows": ROWS, "reason": ""}
            entry["corners"] = corners.tolist()
        entries.append(entry)
    target = {"kind": "chessboard", "columns": COLUMNS, "rows": ROWS, "pitch_mm": 20.0}
    description = {"raxel_set": 1, "name": "made", "resolution": [WIDTH, HEIGHT]}
    description |= {"target": target, "views": [{"image": name} for name in names]}
    write_description(folder, description)
    corners = folder.parent / f"{folder.name}.json"
    corners.write_text(json.dumps({"set": "made", "images": entries}))
    return folder, corners


def of_more_than_the_rim(warnings):
    """Without the warning of extrapolated areas: boards of made sets are central."""
    return [text for text in warnings if "% of the image is outside" not in text]
