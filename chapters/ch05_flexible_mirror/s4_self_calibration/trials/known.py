"""Many steps of a mirror in front of a known static scene, and of boards."""

import numpy as np

from chapters.shared.gaussian_errors import GaussianErrors
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, lattice, outline, seen_board
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration.mirror.clamp import clamp_of_camera
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.update import update_from_scene, update_mirror
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.geometry.spline_grid import spline_grid

# The mirror moves back and forth, so that all steps are equally hard.
TO_AND_FRO_MM, STEPS = (5.0, 7.5), 8
COMPARED_PX = 168


def known_trial(condition, rng):
    """Mean ray angles (STEPS,), degrees, after each step.

    `known`: with the true points of a static board; `boards`: with estimated poses.
    """
    rig, errors = mirror_rig(condition["geometry"]), GaussianErrors()
    true = [rig.camera(mm) for mm in TO_AND_FRO_MM]
    start = nearest_spline(true[0])
    clamp = clamp_of_camera(start, rig.clamp_pixels(true[0]), slope=False)
    poses = [rig.board_pose(rng, deflections=TO_AND_FRO_MM) for _ in range(2)]
    board = rig.board.points()
    points = transform(poses[0], on_plane(board))
    exact = [
        [seen_board(rig, camera, T, _Exact, rng) for camera in true] for T in poses
    ]
    pixels = [lattice(camera, COMPARED_PX) for camera in true]
    edges = [outline(camera) for camera in true]

    def noisy(place, at):
        return errors.corners(exact[place][at], rng)

    def by_scene(before, step, at):
        return update_from_scene(
            before, noisy(0, at), points, clamp, PUBLISHED.settings, outline=edges[at]
        )

    def by_boards(before, step, at):
        place = step % len(poses)
        return update_mirror(
            before, noisy(place, 1 - at), noisy(place, at), board, clamp,
            PUBLISHED.settings, outline=edges[at],
        )  # fmt: skip

    out = {}
    for name, way in (("known", by_scene), ("boards", by_boards)):
        camera, angles = start, np.full(STEPS, np.nan)
        for step in range(STEPS):
            at = (step + 1) % 2
            try:
                camera = way(camera, step, at).camera
            except CalibrationError as refusal:
                out[f"{name}_refused"] = refusal.code
                break
            off = ray_angles(camera, true[at], pixels[at])
            angles[step] = np.nanmean(off)
        out[name] = {f"step{k}": float(a) for k, a in enumerate(angles, 1)}
    return out


def nearest_spline(true):
    """The 7 x 3 spline nearest to a true mirror, over its whole image."""
    viewer, pixels = true.viewer, lattice(true, 48)
    span = normalised(viewer, np.vstack([pixels, outline(true)]))
    grid = spline_grid(span, (7, 3))
    return SplineMirrorCamera.fitted(
        viewer, grid, true.rays(pixels).origins, "distance"
    )


class _Exact:
    """No errors: they are drawn anew at each step."""

    @staticmethod
    def corners(pixels, rng):
        return pixels
