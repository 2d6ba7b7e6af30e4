"""A drawing in pixel coordinates of an image, independent of its displayed size."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np

WIDTH = 960  # of a drawing, px
MAX_SCALE = 4.0
FRACTION = 4  # bits behind the point in OpenCV's coordinates
FONT = 0  # cv2.FONT_HERSHEY_SIMPLEX
# Blue, green, red.
INK, PAPER, QUIET = (40, 32, 24), (255, 255, 255), (150, 150, 150)
MISSING = (40, 40, 220)
# A PNG begins with its signature and the chunk IHDR; the chunk of its software follows.
HEADER_BYTES = 33
SOFTWARE = b"Software\0raxel undistort"
STRIP = 34  # height of the strip with the legend below a drawing, px


class Canvas:
    """A drawing (h, w, 3) uint8 on an image of width x height px.

    Points are (u, v) in pixels of the image, pixel centres at integers.
    """

    def __init__(self, width, height, image=None, paleness=0.0):
        """image: (height, width) uint8, or None for white; paleness: from 0, unchanged,
        to 1, white."""
        self.scale = min(WIDTH / width, MAX_SCALE)
        size = round(width * self.scale), max(1, round(height * self.scale))
        if image is None:
            self.image = np.full((size[1], size[0], 3), 255, np.uint8)
        else:
            how = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
            grey = cv2.resize(image, size, interpolation=how)
            grey = np.rint(255 - (1 - paleness) * (255.0 - grey)).astype(np.uint8)
            self.image = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)

    def place(self, points):
        """Positions of points (..., 2) of the image in the drawing, px."""
        return (np.asarray(points, float) + 0.5) * self.scale - 0.5

    def line(self, points, colour, thickness=1):
        """Draw a line through points (N, 2), with gaps at NaN."""
        points = self.place(points)
        whole = np.isfinite(points).all(axis=1)
        for k in np.flatnonzero(whole[:-1] & whole[1:]):
            ends = _fixed(points[k]), _fixed(points[k + 1])
            cv2.line(self.image, *ends, colour, thickness, cv2.LINE_AA, FRACTION)

    def ring(self, point, colour, radius=4, thickness=1):
        """Draw a ring around a point; radius: px of the drawing."""
        cv2.circle(
            self.image, _fixed(self.place(point)), radius << FRACTION, colour,
            thickness, cv2.LINE_AA, FRACTION,
        )  # fmt: skip

    def cross(self, point, colour, reach=5, thickness=1):
        """Draw a cross with arms of `reach` px of the drawing."""
        arms = np.array([[-1, -1], [1, 1], [-1, 1], [1, -1]]) * (reach / self.scale)
        for ends in (point + arms[:2], point + arms[2:]):
            self.line(ends, colour, thickness)

    def arrow(self, point, vector, colour, thickness=1):
        """Draw an arrow from a point along a vector, both in pixels of the image."""
        start, end = self.place(point), self.place(np.add(point, vector))
        length = np.linalg.norm(end - start)
        tip = min(0.35, 6 / max(length, 1e-9)) if length else 0
        cv2.arrowedLine(
            self.image, _fixed(start), _fixed(end), colour, thickness, cv2.LINE_AA,
            FRACTION, tip,
        )  # fmt: skip

    def text(self, point, text, colour=INK, size=0.4):
        """Draw text next to a point, on a white patch."""
        x, y = np.rint(self.place(point)).astype(int) + [6, -6]
        (wide, high), under = cv2.getTextSize(text, FONT, size, 1)
        low, high = (x - 1, y - high - 1), (x + wide, y + under - 2)
        cv2.rectangle(self.image, _plain(low), _plain(high), PAPER, -1)
        _write(self.image, (x, y), text, colour, size)

    def with_legend(self, entries):
        """Return the framed drawing above a strip with a legend: [(mark, text)].

        mark: a colour, shown as a square, or the length in px of an arrow. Entries that
        do not fit in a strip continue on another one.
        """
        h, w = self.image.shape[:2]
        cv2.rectangle(self.image, (0, 0), (w - 1, h - 1), QUIET, 1)
        strips, x = [], w
        for mark, words in entries:
            (wide, _), _ = cv2.getTextSize(words, FONT, 0.45, 1)
            arrow = not isinstance(mark, tuple)
            first = round(mark) + 8 if arrow else 22
            if x + first + wide > w:
                strips.append(np.full((STRIP, w, 3), 255, np.uint8))
                x = 10
            strip, y = strips[-1], STRIP // 2
            if arrow:
                length = round(mark)
                tip = min(0.35, 6 / max(length, 1))
                cv2.arrowedLine(
                    strip, (x, y), (x + length, y), INK, 1, cv2.LINE_AA, 0, tip
                )
            else:
                cv2.rectangle(strip, (x, y - 7), (x + 14, y + 7), mark, -1)
                cv2.rectangle(strip, (x, y - 7), (x + 14, y + 7), QUIET, 1)
            _write(strip, (x + first, y + 5), words, INK, 0.45)
            x += first + wide + 24
        return np.vstack([self.image, *strips])


def encoded(image, suffix):
    """The bytes of an image as a file of this suffix, .png or .jpg."""
    return cv2.imencode(suffix, image)[1].tobytes()


def _write(image, place, text, colour, size):
    cv2.putText(image, text, _plain(place), FONT, size, colour, 1, cv2.LINE_AA)


def _plain(point):
    return tuple(int(x) for x in point)


def _fixed(point):
    """A point in the fixed-point numbers that OpenCV takes, near the drawing."""
    near = np.clip(point, -30000, 30000)
    return tuple(int(x) for x in np.rint(near * (1 << FRACTION)))


def is_undistorted_png(path: Path) -> bool:
    """Return whether `raxel undistort` wrote the file."""
    with path.open("rb") as stream:
        return SOFTWARE in stream.read(HEADER_BYTES + 12 + len(SOFTWARE))


def write_undistorted_png(path: Path, image: np.ndarray) -> None:
    """Write an image as PNG that names `raxel undistort` as its software."""
    path.parent.mkdir(parents=True, exist_ok=True)
    data, chunk = encoded(image, ".png"), b"tEXt" + SOFTWARE
    length, checksum = len(SOFTWARE), zlib.crc32(chunk)
    chunk = struct.pack(">I", length) + chunk + struct.pack(">I", checksum)
    path.write_bytes(data[:HEADER_BYTES] + chunk + data[HEADER_BYTES:])
