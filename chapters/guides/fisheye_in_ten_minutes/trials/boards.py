"""The lens, the board, and its poses by a plan."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.cameras.registry import camera_from
from raxel.geometry import pose, rotation_from_vector
from raxel.lab.board_photograph import photograph_board
from raxel.lab.target_poses import Visibility
from raxel.sets import Chessboard

LENS = "coolpix-fce8-zoom-3"
BORDER_MM = 7.5
# The detector rejects corners less than 7.5 px apart; the limit here is larger.
VISIBLE = Visibility(margin_px=4.0, least_spacing_px=8.0)
# Largest deviation of a hand-held board from its planned pose, to either side.
POLAR_DEG, AZIMUTH_DEG, TILT_DEG, NEARER = 2.0, 5.0, 5.0, 0.05


class Ring(NamedTuple):
    """Boards at one angle from the optical axis, all around it.

    A positive tilt turns the outer edge of a board towards the camera.
    """

    boards: int
    polar_deg: float
    distance_mm: float
    tilt_deg: float
    first_deg: float


class Walk(NamedTuple):
    """Size of the example calibration.

    Width and height as shares of the lens's own image, blur as a share of its own; the
    board; the plan, ring by ring; and the number of held-out boards."""

    scale: float
    blur: float
    columns: int
    rows: int
    pitch_mm: float
    plan: tuple[Ring, ...]
    kept_out: int


SIZES = {
    "quick": Walk(
        0.4, 0.0, 7, 5, 33.0,
        (
            Ring(1, 8.0, 150.0, 25.0, 30.0),
            Ring(3, 35.0, 150.0, 15.0, 10.0),
            Ring(4, 62.0, 220.0, -20.0, 0.0),
        ),
        1,
    ),
    "full": Walk(
        1.0, 1.0, 17, 12, 15.0,
        (
            Ring(1, 8.0, 150.0, 25.0, 30.0),
            Ring(5, 35.0, 150.0, 15.0, 10.0),
            Ring(5, 75.0, 280.0, -20.0, 0.0),
            Ring(5, 75.0, 280.0, -20.0, 36.0),
        ),
        4,
    ),
}  # fmt: skip
RIM_DEG = 60.0  # rings farther out than this are outer rings


def rig_of(size):
    """Return the rig of the lens with the board of this size."""
    rig = rig_named(LENS)
    lens, scale = rig.camera, size.scale
    camera = camera_from(
        lens.kind,
        {
            "k": lens.k.tolist(),
            "pixels_per_unit": [scale * x for x in lens.pixels_per_unit],
            "principal_point": [scale * (x + 0.5) - 0.5 for x in lens.principal_point],
            "max_angle": lens.max_angle,
            "width": round(scale * lens.width),
            "height": round(scale * lens.height),
        },
    )
    blur = tuple(size.blur * sd for sd in rig.optics.blur_sd_px)
    return replace(
        rig,
        camera=camera,
        optics=replace(rig.optics, blur_sd_px=blur),
        target=Chessboard(size.columns, size.rows, size.pitch_mm),
        border_mm=BORDER_MM,
        visibility=VISIBLE,
    )


def places_of(plan):
    """Return the plan board by board: (polar, azimuth, distance, tilt), deg and mm."""
    return [
        (ring.polar_deg, ring.first_deg + k * 360 / ring.boards, *ring[2:4])
        for ring in plan
        for k in range(ring.boards)
    ]


def inner_boards(plan):
    """Return the number of boards in the inner rings, which come first."""
    return sum(ring.boards for ring in plan if ring.polar_deg < RIM_DEG)


def held_at(rig, place, rng):
    """Return the pose (4, 4) of a hand-held board near its place, fully visible."""
    polar, azimuth, distance, tilt = place
    while True:
        T = placed(
            rig,
            polar + rng.uniform(-POLAR_DEG, POLAR_DEG),
            azimuth + rng.uniform(-AZIMUTH_DEG, AZIMUTH_DEG),
            distance * (1 + rng.uniform(-NEARER, NEARER)),
            tilt + rng.uniform(-TILT_DEG, TILT_DEG),
        )
        if rig.shows(T):
            return T


def placed(rig, polar_deg, azimuth_deg, distance_mm, tilt_deg):
    """Return the pose (4, 4) of a board with rows along a circle about the axis."""
    polar, azimuth = np.radians([polar_deg, azimuth_deg])
    around = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    ahead = np.array(
        [
            np.sin(polar) * np.cos(azimuth),
            np.sin(polar) * np.sin(azimuth),
            np.cos(polar),
        ]
    )
    facing = np.column_stack([around, np.cross(ahead, around), ahead])
    R = facing @ rotation_from_vector([np.radians(tilt_deg), 0.0, 0.0])
    corner, extent = rig.extent
    return pose(R, distance_mm * ahead - R @ [*(corner + extent / 2), 0.0])


def photograph(size, view, rng):
    """Return one image, a PNG file as bytes (uint8).

    The boards of the plan come first, then the held-out ones. The latter repeat
    positions of the plan, spread over its rings.
    """
    import cv2

    rig, places = rig_of(size), places_of(size.plan)
    again = [k * len(places) // size.kept_out for k in range(size.kept_out)]
    place = [*places, *(places[k] for k in again)][view]
    T = held_at(rig, place, rng)
    picture = photograph_board(rig, T, rng, np.random.default_rng(0))
    return {"png": cv2.imencode(".png", picture)[1].ravel()}
