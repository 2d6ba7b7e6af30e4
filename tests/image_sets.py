"""Small rendered image sets on disk, for tests of everything that reads sets."""

import cv2
import numpy as np
import yaml

from tests.chessboards import Board

WIDTH, HEIGHT, FOCAL = 320, 240, 300.0
COLUMNS, ROWS = 7, 5
BEND = 0.15
TILTS_DEG = ((0, 0), (25, 0), (-25, 5), (0, 28), (5, -28), (20, 20))
SHIFTS = ((0, 0), (-0.6, -0.4), (0.6, 0.4), (-0.6, 0.4), (0.6, -0.4), (0, 0.2))


def boards(tilts=TILTS_DEG):
    """One Board per tilt, before a pinhole of focal length FOCAL px with BEND."""
    K = np.array([[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1]])
    middle = np.array([(COLUMNS - 1) / 2, (ROWS - 1) / 2, 0])
    for tilt, shift in zip(tilts, SHIFTS, strict=False):
        R = cv2.Rodrigues(np.radians([*tilt, 0.0]))[0]
        t = np.array([*shift, 9.5]) - R @ middle
        homography = K @ np.column_stack((R[:, 0], R[:, 1], t))
        yield Board(COLUMNS, ROWS, homography, WIDTH, HEIGHT, BEND)


def description(count, **changes):
    """The content of set.yaml for `count` rendered boards."""
    return {
        "raxel_set": 1,
        "name": "drawn",
        "resolution": [WIDTH, HEIGHT],
        "target": {
            "kind": "chessboard",
            "columns": COLUMNS,
            "rows": ROWS,
            "pitch_mm": 20.0,
        },
        "views": [{"image": f"view{i}.png"} for i in range(count)],
        **changes,
    }


def write_description(folder, data):
    """Write set.yaml as it is, right or wrong."""
    (folder / "set.yaml").write_text(yaml.safe_dump(data, sort_keys=False), "utf-8")


def write_drawn_set(folder, tilts=TILTS_DEG, **changes):
    """A set of rendered boards in `folder`; returns its Boards."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = list(boards(tilts))
    for index, board in enumerate(drawn):
        blurred = cv2.GaussianBlur(board.image(), (0, 0), 0.7)
        cv2.imwrite(str(folder / f"view{index}.png"), blurred)
    write_description(folder, description(len(drawn), **changes))
    return drawn
