"""The target of 5.3.4, a chessboard with a circle over it, and its image.

The circle is a dark line; the middle between its two edges is measured. Its errors are
measured once in rendered images (`edges_trial`) and drawn again from there.
"""

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from raxel.features.edge_points import edge_points
from raxel.lab.ringed_board import BoardRing, ringed_board_scene
from raxel.lab.windowed import bands, mirror_window, windowed
from raxel.multiview.plane_points import circle_outline, points_on_plane

RADIUS_MM = 87.21
# Points along the circle, the same in all images; and where errors are measured.
PLACES, DENSE = 90, 360
# Random stream of a seed: boards of the steps.
STEPS_OF_SEED = 8
# Corners closer than this to the ring's paper have it in their window.
CLEAR_MM = 2.0
# Rendered bands of an image, and what is fitted on either side of an edge.
BANDS, BAND_PX, ACROSS_PX = 4, 48, 6.0


def ring_on(board):
    """The BoardRing about the middle of a board's corners."""
    return BoardRing(tuple(board.points().mean(axis=0)), RADIUS_MM)


def off_ring(board):
    """Which corners (N,) of a board are clear of the ring."""
    ring = ring_on(board)
    apart = np.linalg.norm(board.points() - ring.centre, axis=1)
    reach = ring.line / 2 + ring.margin + CLEAR_MM
    return np.abs(apart - ring.radius) > reach


@lru_cache(maxsize=64)
def held(rig, deflection, seed):
    """T_camera_board (4, 4) of the target in front of the mirror, read-only.

    Held anew at each stage, where the mirror then looks. Tilt, rotation and shift from
    there depend on the seed alone, and not on the error level.
    """
    rng = np.random.default_rng(seed)
    T = rig.board_pose(rng, BACK_PROJECTION_MM, (deflection,))
    T.setflags(write=False)
    return T


@lru_cache(maxsize=16)
def boards(rig, deflections, seed):
    """T_camera_board (4, 4) of the board of each step of a calibration, read-only.

    deflections: of the stages, mm. As `held`, drawn once for all levels of a seed.
    """
    rng = np.random.default_rng([seed, STEPS_OF_SEED])
    found = np.array(
        [rig.board_pose(rng, deflections=d) for d in pairwise(deflections)]
    )
    found.setflags(write=False)
    return found


def photographed(rig, camera, T_camera_board, rng, window):
    """Image (h, w) of the target in a window of a camera's image."""
    taken = windowed(replace(rig.rig, camera=camera), window)
    light = taken.light.draw(rng, taken.extent)
    scene = ringed_board_scene(
        rig.board,
        ring_on(rig.board),
        T_camera_board,
        rig.rig.border_mm,
        light=light,
        **taken.radiances,
    )
    return taken.laboratory().photograph(scene, np.eye(4), rng)


class RingEdges(NamedTuple):
    """pixels: (2, N, 2) of the line's inner and outer edge, NaN where none was found;
    scale: (N,) px across the line per mm on the board."""

    pixels: np.ndarray
    scale: np.ndarray


def ring_outlines(rig, camera, T_camera_board, count):
    """True image of the line's inner and outer edge.

    Pixels, normals and scale of each, as `circle_outline`.
    """
    ring = ring_on(rig.board)
    return [
        circle_outline(camera, T_camera_board, ring.centre, radius, count)
        for radius in ring.edges
    ]


def ring_edges(rig, outlines, picture, window, across_px):
    """RingEdges in a window's image, searched for at the `ring_outlines`."""
    light = (picture / picture.max()) ** rig.rig.sensor.gamma
    first = np.array([window.u, window.v], float)
    found = [
        edge_points(light, places - first, normals, across_px).pixels + first
        for places, normals, _ in outlines
    ]
    scale = np.mean([scale for _, _, scale in outlines], axis=0)
    return RingEdges(np.array(found), scale)


def middle_of_line(camera, edges, T_camera_plane):
    """Points (N, 2) mm of a plane half way between a line's edges, NaN if hidden."""
    seen = [points_on_plane(camera, p, T_camera_plane).points for p in edges.pixels]
    return np.mean(seen, axis=0)


def line_errors(result, geometry):
    """Errors (n,) px of the line's middle on a geometry, of the Result of the edges."""
    return np.concatenate(result.select(geometry=geometry).arrays("line_px"))


def edges_trial(condition, rng, small=False):
    """Errors of the line's middle in rendered images, px, outwards.

    small: in a part of an image of the small rig, for quick builds.
    """
    rig, off = mirror_rig(condition["geometry"], small), []
    centre = ring_on(rig.board).centre
    deflections, count = (STAGES_MM[:1], 1) if small else (STAGES_MM[::3], BANDS)
    for deflection in deflections:
        camera = rig.camera(deflection)
        T = held(rig, deflection, int(rng.integers(2**32)))
        outlines = ring_outlines(rig, camera, T, DENSE)
        for window in bands(mirror_window(camera), count, BAND_PX):
            picture = photographed(rig, camera, T, rng, window)
            edges = ring_edges(rig, outlines, picture, window, ACROSS_PX)
            points = middle_of_line(camera, edges, T)
            apart = np.linalg.norm(points - centre, axis=1) - RADIUS_MM
            off.append(apart * edges.scale)
    off = np.concatenate(off)
    return {"line_px": off[np.isfinite(off)]}
