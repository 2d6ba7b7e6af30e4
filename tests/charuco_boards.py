"""ChArUco boards drawn with known corners, under a homography."""

import cv2
import numpy as np

from raxel.sets import Charuco

SQUARE_PX, FINER = 60, 3
TARGET = Charuco(7, 5, 40.0, "4X4_50", 29.0)
WIDTH, HEIGHT, FOCAL = 480, 360, 420.0
TILTS_DEG = ((30, 0, 10), (-25, 20, 0), (5, -35, 100), (25, 25, 190))


def opencv_board(target):
    """The same board as OpenCV has it."""
    dictionary = getattr(cv2.aruco, f"DICT_{target.dictionary}")
    board = cv2.aruco.CharucoBoard(
        (target.columns + 1, target.rows + 1),
        target.pitch_mm,
        target.marker_mm,
        cv2.aruco.getPredefinedDictionary(dictionary),
    )
    board.setLegacyPattern(target.legacy)
    return board


def sheet(target=TARGET):
    """The board's print, SQUARE_PX a square, with a white margin of a square."""
    size = SQUARE_PX * np.array([target.columns + 1, target.rows + 1])
    rim = SQUARE_PX
    print_ = opencv_board(target).generateImage(tuple(map(int, size)))
    return cv2.copyMakeBorder(
        print_, rim, rim, rim, rim, cv2.BORDER_CONSTANT, value=255
    )


def board_image(tilt_deg, target=TARGET, noise=1.0, seed=0, print_=None):
    """(image (HEIGHT, WIDTH) uint8, corners (rows * columns, 2) px) of a tilted board.

    A pinhole of focal length FOCAL px, with the principal point in the middle. print_:
    of another target, in place of the board's.
    """
    K = np.array([[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1]])
    out_of_plane = cv2.Rodrigues(np.radians([*tilt_deg[:2], 0.0]))[0]
    R = out_of_plane @ cv2.Rodrigues(np.radians([0.0, 0.0, tilt_deg[2]]))[0]
    middle = np.array([(target.columns - 1) / 2, (target.rows - 1) / 2, 0])
    H = K @ np.column_stack([R[:, 0], R[:, 1], [0, 0, 13.0] - R @ middle])
    image = _warped(sheet(target) if print_ is None else print_, H) * 0.7 + 30
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image += np.random.default_rng(seed).normal(0, noise, image.shape)
    corners = cv2.perspectiveTransform(
        Charuco.points(target)[None] / target.pitch_mm, H
    )[0]
    return np.clip(np.rint(image), 0, 255).astype(np.uint8), corners


def _warped(print_, H):
    """The print (white around) as float, each pixel the mean of FINER x FINER."""
    board_from_print = np.array(
        [
            [1 / SQUARE_PX, 0, 0.5 / SQUARE_PX - 2],
            [0, 1 / SQUARE_PX, 0.5 / SQUARE_PX - 2],
            [0, 0, 1],
        ]
    )
    shift = (FINER - 1) / 2
    finer = np.array([[FINER, 0, shift], [0, FINER, shift], [0, 0, 1.0]])
    size = FINER * WIDTH, FINER * HEIGHT
    big = cv2.warpPerspective(
        print_, finer @ H @ board_from_print, size, borderValue=90
    )
    small = cv2.resize(big, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    return small.astype(np.float32)
