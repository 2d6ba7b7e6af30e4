"""Frames of a video for a calibration: sharp ones that differ from each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from raxel.errors import InputError
from raxel.io.files import check_file
from raxel.sets.image_files import words_of_decoders

# Width at which frames are compared, px; a frame differs if it does so by this fraction
# of the standard deviation of its grey levels, as after a motion of one such pixel.
COMPARED_WIDTH, MIN_DIFFERENCE = 80, 0.2


def save_frames(
    video: str | Path,
    folder: str | Path,
    every: int,
    say: Callable[[str], object] | None = None,
) -> list[str]:
    """Save frames of a video as PNG files in a folder.

    Of each `every` consecutive frames the sharpest is taken, if it differs from the
    frame that was taken before. Sharpness is the variance of the image's Laplacian.

    Parameters
    ----------
    video : str or Path
        A file that OpenCV reads.
    folder : str or Path
        Existing folder.
    every : int
        Number of consecutive frames.
    say : callable, optional
        Called with one line of text per saved frame.

    Returns
    -------
    list of str
        Names of the files, with the numbers of their frames from 0.

    Raises
    ------
    InputError
        If the file is no video, or has no two frames that differ.
    """
    names, last = [], None
    for number, frame in _sharpest(video, every):
        grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        height = max(1, COMPARED_WIDTH * grey.shape[0] // grey.shape[1])
        small = cv2.resize(grey, (COMPARED_WIDTH, height), interpolation=cv2.INTER_AREA)
        small = small.astype(float)
        change = np.inf if last is None else np.sqrt(np.mean((small - last) ** 2))
        if change <= MIN_DIFFERENCE * small.std():
            continue
        last = small
        names.append(f"frame-{number:06d}.png")
        cv2.imwrite(str(Path(folder) / names[-1]), frame)
        if say:
            say(f"{names[-1]} of {video}")
    if len(names) < 2:
        raise InputError(
            f"{video}: frames: {len(names)} differ from the one before; give a video "
            "in which the board or the camera moves"
        )
    return names


def _sharpest(video, every) -> Iterator[tuple[int, np.ndarray]]:
    """Yield the number and the pixels of the sharpest of each `every` frames."""
    check_file(video, what="video")
    with words_of_decoders():
        capture = cv2.VideoCapture(str(video))
    best, number = None, -1
    try:
        while True:
            with words_of_decoders():
                read, frame = capture.read()
            if read:
                number += 1
                grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
                sharpness = cv2.Laplacian(grey, cv2.CV_32F).var()
                if best is None or sharpness > best[0]:
                    best = sharpness, number, frame
            if best and (not read or number % every == every - 1):
                yield best[1:]
                best = None
            if not read:
                break
    finally:
        capture.release()
    if number < 0:
        raise InputError(
            f"{video}: no frame can be read; convert the video to MP4 (H.264) or AVI"
        )
