"""Pictures of chessboards drawn by a formula, whose corners are known.

It shares no code with the library or its laboratory: every pixel is divided, each part
asks where its ray meets the board, and an edge crosses a part as a ramp. Blur is laid
over the parts in linear light; response, noise, rounding and coding follow.
"""

from typing import NamedTuple

import cv2
import numpy as np

PARTS = 2
MARGIN = 1.0


class Lens(NamedTuple):
    """Rays of pixels about the middle of an image: a law and its focal length, px.

    law: perspective, barrel, equidistant, stereographic, or mirror (the unified model
    with a parabola's parameter).
    """

    law: str
    focal: float
    width: int = 640
    height: int = 480

    @property
    def middle(self):
        return np.array([(self.width - 1) / 2, (self.height - 1) / 2])

    def rays(self, u, v):
        """Directions (..., 3) of pixels."""
        x, y = (u - self.middle[0]) / self.focal, (v - self.middle[1]) / self.focal
        r = np.hypot(x, y)
        if self.law == "mirror":
            z = (1 - r**2) / 2
            return np.stack([x, y, z], axis=-1)
        angle = _ANGLES[self.law](r)
        side = np.sin(angle) / np.maximum(r, 1e-12)
        return np.stack([x * side, y * side, np.cos(angle)], axis=-1)

    def pixels(self, points):
        """Pixels (..., 2) of points (..., 3)."""
        across = np.hypot(points[..., 0], points[..., 1])
        angle = np.arctan2(across, points[..., 2])
        radius = _RADII[self.law](angle) * self.focal
        to = points[..., :2] / np.maximum(across, 1e-12)[..., None]
        return self.middle + radius[..., None] * to


BARREL = -0.28


def _barrel_radius(angle):
    t = np.tan(angle)
    return t * (1 + BARREL * t**2 + 0.06 * t**4)


_BARREL_ANGLES = np.linspace(0, 0.85, 4001)
_RADII = {
    "perspective": np.tan,
    "barrel": _barrel_radius,
    "equidistant": lambda angle: angle,
    "stereographic": lambda angle: 2 * np.tan(angle / 2),
    "mirror": lambda angle: np.tan(angle / 2),
}
_ANGLES = {
    "perspective": np.arctan,
    "barrel": lambda r: np.interp(
        r, _barrel_radius(_BARREL_ANGLES), _BARREL_ANGLES, right=1.5
    ),
    "equidistant": lambda r: r,
    "stereographic": lambda r: 2 * np.arctan(r / 2),
}


class Board(NamedTuple):
    """columns x rows interior corners, unit squares, the first at (0, 0)."""

    columns: int
    rows: int
    R: np.ndarray
    t: np.ndarray

    def points(self):
        y, x = np.mgrid[0 : self.rows, 0 : self.columns].astype(float)
        flat = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
        return flat @ self.R.T + self.t


class Photo(NamedTuple):
    """What becomes of the light. blur: its kernel over parts of pixels, or None; light:
    (du, dv, fall) slope over the image and fall towards its corners; grey: of black
    and white; gamma: of the response; noise: SD in grey levels; shot: share of it that
    grows with the root of the light; mosaic: whether every pixel sees one colour only;
    sharpened: so many times what a Gaussian of 1 px takes off is added; quality: of the
    coding, None for none."""

    blur: np.ndarray = None
    light: tuple = (0.0, 0.0, 0.0)
    grey: tuple = (40.0, 210.0)
    gamma: float = 1.0
    noise: float = 1.0
    shot: float = 0.0
    mosaic: bool = False
    sharpened: float = 0.0
    quality: int = None


def drawn(lens, board, photo, rng):
    """(image (height, width) uint8, corners (N, 2))."""
    light = _light(lens, board)
    if photo.blur is not None:
        light = cv2.filter2D(light, -1, photo.blur, borderType=cv2.BORDER_REPLICATE)
    size = lens.width, lens.height
    light = cv2.resize(light, size, interpolation=cv2.INTER_AREA)
    v, u = np.mgrid[0 : lens.height, 0 : lens.width]
    x, y = (u - lens.middle[0]) / size[0], (v - lens.middle[1]) / size[0]
    du, dv, fall = photo.light
    black, white = (g / 255 for g in photo.grey)
    light = (black + (white - black) * light) * (1 + du * x + dv * y)
    light *= 1 - fall * (x**2 + y**2)
    grey = 255 * np.maximum(light, 0) ** (1 / photo.gamma)
    own = np.sqrt(1 - photo.shot + photo.shot * np.clip(grey, 0, 255) / 128)
    grey = grey + photo.noise * own * rng.standard_normal(grey.shape)
    image = _eight_bits(grey)
    if photo.mosaic:
        colour = cv2.cvtColor(image, cv2.COLOR_BayerBG2BGR)
        image = cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    if photo.sharpened:
        grey = image.astype(np.float32)
        grey += photo.sharpened * (grey - cv2.GaussianBlur(grey, (0, 0), 1.0))
        image = _eight_bits(grey)
    if photo.quality:
        options = [cv2.IMWRITE_JPEG_QUALITY, photo.quality]
        coded = cv2.imencode(".jpg", image, options)[1]
        image = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)
    return image, lens.pixels(board.points())


def _eight_bits(grey):
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _light(lens, board):
    """Share of the white paper's light in each part of a pixel, float32."""
    step = 1 / PARTS
    u = np.arange(lens.width * PARTS) * step + (step - 1) / 2
    v = np.arange(lens.height * PARTS) * step + (step - 1) / 2
    rays = lens.rays(*np.meshgrid(u, v))
    normal = board.R[:, 2]
    toward = rays @ normal
    far = (board.t @ normal) / np.where(np.abs(toward) > 1e-9, toward, np.inf)
    hit = far > 1e-6
    at = rays * np.where(hit, far, 0)[..., None] - board.t
    x, y = at @ board.R[:, 0], at @ board.R[:, 1]
    checks = _wave(x, board.columns) * _wave(y, board.rows)
    inside = _within(x, -1, board.columns) * _within(y, -1, board.rows)
    paper = _within(x, -1 - MARGIN, board.columns + MARGIN)
    paper *= _within(y, -1 - MARGIN, board.rows + MARGIN)
    light = 1 - inside * (1 - (1 + checks) / 2)
    return np.where(hit, paper * light + (1 - paper) * 0.45, 0.45).astype(np.float32)


def _change(x):
    """How far x goes across a part, along its gradient."""
    down, across = np.gradient(x)
    return np.clip(np.hypot(down, across), 1e-9, 1.0)


def _wave(x, count):
    edge = np.clip(np.rint(x), 0, count - 1)
    side = np.where(edge % 2 == 0, 2.0, -2.0)
    return side * np.clip((x - edge) / _change(x), -0.5, 0.5)


def _within(x, low, high):
    change = _change(x)
    return np.clip((x - low) / change + 0.5, 0, 1) * np.clip(
        (high - x) / change + 0.5, 0, 1
    )


def gaussian(sd):
    """Kernel over parts of a Gaussian of this SD, px."""
    reach = int(np.ceil(4 * sd * PARTS))
    line = cv2.getGaussianKernel(2 * reach + 1, sd * PARTS)
    return line @ line.T


def disk(radius):
    """Kernel over parts of a disk, px."""
    reach = int(np.ceil(radius * PARTS)) + 1
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    shape = np.clip(radius * PARTS - np.hypot(x, y) + 0.5, 0, 1)
    return shape / shape.sum()


def motion(length, angle, sd=0.4):
    """Kernel over parts of a straight motion of this length, px, and a Gaussian."""
    reach = int(np.ceil((length / 2 + 4 * sd) * PARTS))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1] / PARTS
    shape = np.zeros_like(x)
    for share in np.linspace(-0.5, 0.5, 41):
        a, b = share * length * np.cos(angle), share * length * np.sin(angle)
        shape += np.exp(-((x - a) ** 2 + (y - b) ** 2) / (2 * sd**2))
    return shape / shape.sum()


def board_in_view(lens, columns, rows, square, rng, tilt=0.5, off=0.6):
    """A Board whose squares are about `square` px, wholly inside the image.

    tilt: most of its tilt, radians; off: how far towards the image's border its
    middle lies at most, as a share. None where none fits.
    """
    inside = np.array([lens.width, lens.height]) - 4.0
    for _ in range(400):
        middle = lens.middle * (1 + off * rng.uniform(-1, 1, 2))
        ray = lens.rays(*middle)
        ray /= np.linalg.norm(ray)
        neighbours = np.stack([lens.rays(*(middle + d)) for d in ((1, 0), (0, 1))])
        neighbours /= np.linalg.norm(neighbours, axis=1, keepdims=True)
        scale = np.linalg.norm(np.cross(*(neighbours - ray))) ** 0.5
        distance = 1 / (scale * square)
        z = ray
        x = np.array([1.0, 0, 0]) - z[0] * z
        x /= np.linalg.norm(x)
        frame = np.column_stack([x, np.cross(z, x), z])
        turn = rng.uniform(-np.pi, np.pi) * np.array([0, 0, 1.0])
        lean = rng.uniform(0, tilt) * np.append(_unit(rng.uniform(0, 2 * np.pi)), 0)
        R = frame @ cv2.Rodrigues(lean)[0] @ cv2.Rodrigues(turn)[0]
        centre = np.array([(columns - 1) / 2, (rows - 1) / 2, 0])
        board = Board(columns, rows, R, distance * ray - R @ centre)
        outer = board._replace(columns=columns + 3, rows=rows + 3)
        outer = outer.points() - R @ np.array([2.0, 2.0, 0])
        if lens.law in ("perspective", "barrel") and (outer[:, 2] < 0.2).any():
            continue
        pixels = lens.pixels(outer)
        if np.all((pixels > 4) & (pixels < inside)):
            return board
    return None


def _unit(angle):
    return np.array([np.cos(angle), np.sin(angle)])
