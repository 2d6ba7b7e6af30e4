"""Frames of the film of the bending mirror, from its rendered run."""

from typing import NamedTuple

import numpy as np

FILM = "ext_mirror_film_pictures"
UM = 1000.0


class Frames(NamedTuple):
    """A row for each of n frames.

    true_mm, found_mm, angle_deg (n,); used (n,) corners; picture (n, h, w) uint8;
    corners (n, N, 2) px of the whole image; mirror, directions (n, a, b, 3); profile
    (n, b, 2) mm; T_camera_board (4, 4).
    """

    true_mm: np.ndarray
    found_mm: np.ndarray
    angle_deg: np.ndarray
    used: np.ndarray
    picture: np.ndarray
    corners: np.ndarray
    mirror: np.ndarray
    directions: np.ndarray
    profile: np.ndarray
    T_camera_board: np.ndarray

    @classmethod
    def of(cls, result):
        """Return the frames of the film's only trial."""
        return cls(**{name: result.arrays(name)[0] for name in cls._fields})

    @property
    def error_um(self):
        """Found minus true deflection (n,), um."""
        return UM * (self.found_mm - self.true_mm)

    @property
    def peak(self):
        """Number of the frame with the largest deflection."""
        return int(np.argmax(self.true_mm))
