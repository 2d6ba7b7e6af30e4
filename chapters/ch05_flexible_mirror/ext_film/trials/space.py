"""What stands in space in a frame of the film, seen from one place in all of them."""

import numpy as np

from raxel.geometry import intersect_rays_plane
from raxel.show import Polyline, Scene, Segments, Surface, framed
from raxel.show.boards import board
from raxel.show.cameras import frustum

SILVER, SIGHT_COLOUR, RAY, EDGE = "#9fb4c7", "#aeb6c0", "#0072b2", "#d55e00"
# From above, behind the mirror: the board shows its face, the mirror its bend.
SIGHT, UP, BODY_MM, ASPECT = (-0.55, 0.75, -0.4), (0.0, -1.0, 0.0), 45.0, 1.4
# Places across and along the sheet whose rays are drawn.
ACROSS, ALONG = (0, 4, 8), (1, 11, 21, 31)


class FilmView:
    """Scenes of a film's frames, all seen from one place."""

    def __init__(self, rig, frames):
        self._rig, self._frames = rig, frames
        whole = [part for k in (0, frames.peak) for part in self.parts(k)]
        self._seen = framed([*self._standing(), *whole], SIGHT, UP, aspect=ASPECT)

    def scene(self, k):
        """The Scene of frame k."""
        return self._scene([*self._standing(), *self.parts(k)])

    def together(self, chosen, colours, note):
        """A Scene of several frames, each with a label of its own."""
        parts = self._standing()
        for k, colour in zip(chosen, colours, strict=True):
            label = f"{self._frames.true_mm[k]:g} mm"
            parts += self.parts(k, colour, label)
        return self._scene(parts, note)

    def parts(self, k, colour=None, label=""):
        """Mirror, rays and outline on the board of frame k; in one colour, if given."""
        frames = self._frames
        mirror, ways = frames.mirror[k], frames.directions[k]
        met = self._on_board(mirror, ways)
        some = np.ix_(ACROSS, ALONG)
        starts, ends = mirror[some].reshape(-1, 3), met[some].reshape(-1, 3)
        return [
            Surface(mirror, colour or SILVER, 0.8, label),
            Segments(np.zeros_like(starts), starts, SIGHT_COLOUR, label, 1.0),
            Segments(starts, ends, colour or RAY, label, 1.4),
            Polyline(_rim(met), colour or EDGE, label, 3.0),
        ]

    def _standing(self):
        T = self._frames.T_camera_board
        return [
            frustum(self._rig.viewer, BODY_MM, label=""),
            *board(self._rig.board, T),
        ]

    def _scene(self, parts, note=""):
        seen = self._seen
        return Scene(parts, seen.view_from, seen.look_at, UP, note, ASPECT)

    def _on_board(self, origins, directions):
        T = self._frames.T_camera_board
        met = intersect_rays_plane(
            origins.reshape(-1, 3), directions.reshape(-1, 3), T
        ).points
        places = np.column_stack([met, np.zeros(len(met)), np.ones(len(met))])
        return (places @ T.T)[:, :3].reshape(origins.shape)


def _rim(points):
    """The outer ring (n, 3) of points (a, b, 3), closed."""
    return np.concatenate(
        [points[0], points[1:, -1], points[-1, -2::-1], points[-2::-1, 0]]
    )
