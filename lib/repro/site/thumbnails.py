"""Small pictures of the figures, for pages that show many of them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2

from repro.run.results import write_atomic

SIZE_PX = (400, 300)
QUALITY = 75


def thumbnails(pictures: Iterable[Path], folder: Path) -> dict[str, Path]:
    """Small pictures in ``folder``, by the name of their file without its ending.

    One that is newer than its picture is kept as it is.
    """
    made = {}
    for picture in pictures:
        small = folder / f"{picture.stem}.webp"
        if not small.is_file() or _changed(small) <= _changed(picture):
            write_atomic(small, _reduced(picture))
        made[picture.stem] = small
    return made


def _changed(path: Path) -> int:
    return path.stat().st_mtime_ns


def _reduced(picture: Path) -> bytes:
    """The whole picture, within `SIZE_PX`, as WebP."""
    image = cv2.imread(str(picture))
    scale = min(
        1.0,
        *(most / size for most, size in zip(SIZE_PX, image.shape[1::-1], strict=True)),
    )
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".webp", small, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])[
        1
    ].tobytes()
