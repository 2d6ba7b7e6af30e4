"""A tin in the mirror: a box of three printed faces, seen from two positions.

The positions are 100 mm apart. Its faces meet at the angles of the thesis's laser scan
(Table 5.8), so that the reference is the same. The corner where all three meet points
to the mirror. In the camera's frame the tin moves by the inverse motion.

Frame of the tin: origin at that corner; axes nearly along the outward normals of top,
left and right face; mm. Left and right as from the mirror, top is up.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from raxel.geometry import pose, rotation_from_vector, transform
from raxel.geometry.planes import on_plane
from raxel.lab import ImageTexture, Rectangle, TexturedScene

FACES = ("top", "left", "right")
PAIRS = {"top_left": (0, 1), "top_right": (0, 2), "left_right": (1, 2)}
# Degrees, inside the tin, of PAIRS: laser scan of Table 5.8.
ANGLES_DEG = np.array([90.28, 89.15, 89.17])
# Width of the right face, of the left face, and height, mm.
RIGHT_MM, LEFT_MM, HEIGHT_MM = 70.0, 70.0, 90.0
# Between the two images (5.3.5).
SHIFT_MM = 100.0
# Distance from the mirror to the tin's middle; its tilt towards the mirror, to show the
# top; errors of placing by hand, mm and radians.
DISTANCE_MM, LEAN = 300.0, np.radians(30.0)
BY_HAND_MM, BY_HAND = 5.0, np.radians(3.0)
# Print: mm per pixel, sizes of its blots (mm), grey levels, and the room behind.
PRINT_MM, BLOTS_MM, INK, PAPER, ROOM = 0.2, (0.8, 1.6, 3.2, 6.4), 0.06, 0.85, 0.3
WORDS = ("CAFE", "RAXEL", "MOKKA")


class TinFace(NamedTuple):
    """One face: pose and printed rectangle.

    T_tin_face (4, 4): x to the right and y down on the face, z into the tin; low, high:
    (2,) mm, corners of the rectangle.
    """

    T_tin_face: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def corners(self):
        """Points (4, 3) at its corners, the tin's frame."""
        ends = np.stack([self.low, self.high])
        grid = np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 2)
        return transform(self.T_tin_face, on_plane(grid))

    def points(self, rng, count):
        """Random points (count, 3) on the face, the tin's frame."""
        return transform(
            self.T_tin_face, on_plane(rng.uniform(self.low, self.high, (count, 2)))
        )


def outward_normals():
    """Unit (3, 3), a row for each face, that meet at ANGLES_DEG."""
    products = np.eye(3)
    for (a, b), degrees in zip(PAIRS.values(), ANGLES_DEG, strict=True):
        products[a, b] = products[b, a] = -np.cos(np.radians(degrees))
    return np.linalg.cholesky(products)


@lru_cache(maxsize=1)
def faces():
    """The three TinFaces. Left and right share their upright edge to the last digit."""
    top, left, right = outward_normals()
    upright = np.cross(right, left)
    return (
        _face(top, np.cross(top, right), (0.0, -LEFT_MM), (RIGHT_MM, 0.0)),
        _face(left, np.cross(upright, -left), (-LEFT_MM, 0.0), (0.0, HEIGHT_MM)),
        _face(right, np.cross(upright, -right), (0.0, 0.0), (RIGHT_MM, HEIGHT_MM)),
    )


def _face(normal, across, low, high):
    x = across / np.linalg.norm(across)
    R = np.column_stack([x, np.cross(-normal, x), -normal])
    return TinFace(pose(R, np.zeros(3)), np.array(low), np.array(high))


def middle_ray(camera):
    """Origin (3,) and direction (3,) of the scene ray at the mirror's middle."""
    mirror = camera.mirror
    x = np.array([mirror.end / 2])
    z = mirror.height(x, 0 * x)[0]
    place = transform(camera.T_viewer_mirror, np.column_stack([x, 0 * x, z]))
    rays = camera.rays(camera.viewer.project(place).pixels)
    return rays.origins[0], rays.directions[0]


def two_places(camera, rng):
    """T_camera_tin (2, 4, 4) before and after the camera moves by SHIFT_MM.

    The camera moves horizontally, perpendicular to the mirror's middle ray; the tin is
    on that ray half way. Errors of placing by hand are drawn from `rng`.
    """
    origin, z = middle_ray(camera)
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x)
    view = np.column_stack([x, np.cross(z, x), z])
    s = np.sqrt(0.5)
    facing = np.array([[0, -s, s], [-1, 0, 0], [0, -s, -s]])
    turn = rotation_from_vector(rng.normal(0, BY_HAND, 3))
    lean = rotation_from_vector([LEAN, 0, 0])
    R = view @ turn @ lean @ facing
    middle = R @ (-np.array([HEIGHT_MM, RIGHT_MM, LEFT_MM]) / 2)
    at = origin + DISTANCE_MM * z + rng.normal(0, BY_HAND_MM, 3) - middle
    half = SHIFT_MM / 2 * x
    return np.stack([pose(R, at - half), pose(R, at + half)])


def tin_points(rng, count):
    """(points (count, 3), face (count,)) at random on the tin, by area."""
    size = [np.prod(face.high - face.low) for face in faces()]
    which = np.sort(rng.choice(3, count, p=np.array(size) / sum(size)))
    points = [
        face.points(rng, int(n))
        for face, n in zip(faces(), np.bincount(which, minlength=3), strict=True)
    ]
    return np.concatenate(points), which


def tin_scene(T_camera_tin):
    """The TexturedScene of the tin in front of a uniform wall."""
    parts = []
    for face, texture in zip(faces(), prints(), strict=True):
        # A texture begins at uv = (0, 0): the rectangle's own corner.
        T = T_camera_tin @ face.T_tin_face @ pose(np.eye(3), [*face.low, 0.0])
        parts.append((Rectangle(T, *(face.high - face.low)), texture))
    return TexturedScene(tuple(parts), ROOM)


@lru_cache(maxsize=1)
def prints():
    """ImageTextures of the three faces: blots of several sizes, a frame and a word."""
    rng = np.random.default_rng(58)
    return [
        ImageTexture(_print(face, word, rng), PRINT_MM)
        for face, word in zip(faces(), WORDS, strict=True)
    ]


def _print(face, word, rng):
    width, height = np.rint((face.high - face.low) / PRINT_MM).astype(int)
    image = np.zeros((height, width))
    for size in BLOTS_MM:
        blots = rng.normal(size=image.shape)
        blots = cv2.GaussianBlur(blots, (0, 0), size / PRINT_MM / 2)
        image += blots / blots.std()
    image = np.rint(255 / (1 + np.exp(-1.5 * image))).astype(np.uint8)
    edge = int(2 / PRINT_MM)
    cv2.rectangle(image, (edge, edge), (width - edge, height - edge), 0, edge // 2)
    font, scale, thick = cv2.FONT_HERSHEY_SIMPLEX, 0.45 / PRINT_MM, int(2.6 / PRINT_MM)
    (wide, tall), _ = cv2.getTextSize(word, font, scale, thick)
    low = int((width - wide) / 2), int((height + tall) / 2)
    # A white label behind the word.
    margin = (np.array([3, 5]) / PRINT_MM).astype(int)
    box = np.array(low) - [0, tall] - margin, np.array(low) + [wide, 0] + margin
    cv2.rectangle(image, *(tuple(map(int, at)) for at in box), 255, cv2.FILLED)
    cv2.putText(image, word, low, font, scale, 0, thick)
    return INK + (PAPER - INK) * image / 255
