"""A picture to draw on in pixels of the photograph, whatever size it is shown at."""

import numpy as np

WIDTH = 960  # of a picture, px
LARGEST_SCALE = 4.0
FRACTION = 4  # bits behind the point in OpenCV's coordinates
FONT = 0  # cv2.FONT_HERSHEY_SIMPLEX
# Blue, green, red.
INK, PAPER, QUIET = (40, 32, 24), (255, 255, 255), (150, 150, 150)
MISSING = (40, 40, 220)
STRIP = 34  # height of the strip with the legend below a picture, px


class Canvas:
    """A picture (h, w, 3) uint8 of an image of width x height px, with drawing on it.

    Points are (u, v) in pixels of the image, pixel centres at integers.
    """

    def __init__(self, width, height, image=None, paleness=0.0):
        """image: (height, width) uint8, or None for paper; paleness: 0 as it is, to 1,
        paper."""
        import cv2

        self.scale = min(WIDTH / width, LARGEST_SCALE)
        size = round(width * self.scale), max(1, round(height * self.scale))
        if image is None:
            self.picture = np.full((size[1], size[0], 3), 255, np.uint8)
        else:
            how = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
            grey = cv2.resize(image, size, interpolation=how)
            grey = np.rint(255 - (1 - paleness) * (255.0 - grey)).astype(np.uint8)
            self.picture = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)

    def place(self, points):
        """Where points (..., 2) of the image are in the picture, px."""
        return (np.asarray(points, float) + 0.5) * self.scale - 0.5

    def line(self, points, colour, thickness=1):
        """A line through points (N, 2); gaps where one is NaN."""
        import cv2

        points = self.place(points)
        whole = np.isfinite(points).all(axis=1)
        for k in np.flatnonzero(whole[:-1] & whole[1:]):
            ends = _fixed(points[k]), _fixed(points[k + 1])
            cv2.line(self.picture, *ends, colour, thickness, cv2.LINE_AA, FRACTION)

    def ring(self, point, colour, radius=4, thickness=1):
        """A ring of a radius in px of the picture around a point."""
        import cv2

        cv2.circle(
            self.picture, _fixed(self.place(point)), radius << FRACTION, colour,
            thickness, cv2.LINE_AA, FRACTION,
        )  # fmt: skip

    def cross(self, point, colour, reach=5, thickness=1):
        """A cross of arms of `reach` px of the picture."""
        arms = np.array([[-1, -1], [1, 1], [-1, 1], [1, -1]]) * (reach / self.scale)
        for ends in (point + arms[:2], point + arms[2:]):
            self.line(ends, colour, thickness)

    def arrow(self, point, vector, colour, thickness=1):
        """An arrow from a point along a vector, both in pixels of the image."""
        import cv2

        start, end = self.place(point), self.place(np.add(point, vector))
        length = np.linalg.norm(end - start)
        tip = min(0.35, 6 / max(length, 1e-9)) if length else 0
        cv2.arrowedLine(
            self.picture, _fixed(start), _fixed(end), colour, thickness, cv2.LINE_AA,
            FRACTION, tip,
        )  # fmt: skip

    def text(self, point, text, colour=INK, size=0.4):
        """Words beside a point, on a patch of paper."""
        import cv2

        x, y = np.rint(self.place(point)).astype(int) + [6, -6]
        (wide, high), under = cv2.getTextSize(text, FONT, size, 1)
        low, high = (x - 1, y - high - 1), (x + wide, y + under - 2)
        cv2.rectangle(self.picture, _plain(low), _plain(high), PAPER, -1)
        _write(self.picture, (x, y), text, colour, size)

    def with_legend(self, entries):
        """The picture, framed, above a strip with marks: [(mark, words)].

        mark: a colour, shown as a square, or the length in px of an arrow. What does
        not fit beside the others begins another strip.
        """
        import cv2

        h, w = self.picture.shape[:2]
        cv2.rectangle(self.picture, (0, 0), (w - 1, h - 1), QUIET, 1)
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
        return np.vstack([self.picture, *strips])


def encoded(picture, suffix):
    """The bytes of a picture as a file of this suffix, .png or .jpg."""
    import cv2

    return cv2.imencode(suffix, picture)[1].tobytes()


def _write(picture, place, text, colour, size):
    import cv2

    cv2.putText(picture, text, _plain(place), FONT, size, colour, 1, cv2.LINE_AA)


def _plain(point):
    return tuple(int(x) for x in point)


def _fixed(point):
    """A point in the fixed-point numbers that OpenCV takes, near the picture."""
    near = np.clip(point, -30000, 30000)
    return tuple(int(x) for x in np.rint(near * (1 << FRACTION)))
