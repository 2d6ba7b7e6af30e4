"""Targets before a camera as a scene: the rigs of the laboratory, and posed boards."""

import numpy as np

from raxel.lab.render_set import POSES
from raxel.sets.model import ActiveGrid
from raxel.show.boards import board
from raxel.show.cameras import axes, field_of_view, frustum, mirrors, viewing_rays
from raxel.show.scene import Labels, finite_points
from raxel.show.view import INK, SIGHT, framed

CALIBRATE, EVALUATE = "#6b7785", "#d55e00"
# The camera's pyramid, and its axes, as shares of the farthest target's distance.
BODY, AXIS, FIELD = 0.1, 0.25, 0.6
# A mirror that is nearer than this share of it has one name with the camera.
APART = 0.25


def drawn_poses(rig, seed):
    """T_camera_target (n, 4, 4) of all views that `raxel render` takes with a seed.

    rig: `raxel.lab.Rig`; seed: whole number. Raises InputError as `Rig.draw_poses`.
    """
    rng = np.random.default_rng([seed, POSES])
    return rig.draw_poses(rng, rig.count + rig.evaluate)


def rig_scene(rig, seed=0, poses=None):
    """Where a rig's camera, mirror and targets stand, in the camera's frame.

    rig: `raxel.lab.Rig`; seed: whole number; poses: what `drawn_poses` gives for them,
    where that is known. Raises InputError as `Rig.draw_poses`.
    """
    poses = drawn_poses(rig, seed) if poses is None else poses
    uses = ["calibrate"] * rig.count + ["evaluate"] * rig.evaluate
    count = f"{rig.count} poses" + (f" and {rig.evaluate} more" if rig.evaluate else "")
    note = f"{rig.name}: {rig.summary}. {count}, drawn from seed {seed}."
    targets = [rig.target] * len(poses)
    return posed_targets(rig.camera, targets, poses, uses, note, rig.border_mm)


def posed_targets(camera, targets, poses, uses, note, border_mm=None):
    """A camera and targets in poses T_camera_target (n, 4, 4), one of each for each.

    uses: 'calibrate' or 'evaluate' for each; border_mm: as in `board`.
    """
    what = "monitor" if isinstance(targets[0], ActiveGrid) else "chessboard"
    known = what == "monitor" or targets[0].pitch_mm is not None
    unit = "mm" if known else "pitches"
    parts = []
    for target, T, use in zip(targets, poses, uses, strict=True):
        label, colour = f"{what} to {use} with", EVALUATE
        if use == "calibrate":
            label, colour = (label if "evaluate" in uses else what), CALIBRATE
        parts += board(target, T, border_mm, label, colour)
    parts += _camera_for(camera, parts)
    return framed(parts, facing_sight(np.asarray(poses)), note=note, scale=unit)


def facing_sight(poses):
    """Of the usual view and its mirror images the one that sees most fronts (3,)."""
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, 1, -1], [-1, 1, -1]])
    views = signs * np.array(SIGHT)
    return views[np.argmax((poses[:, :3, 2] @ views.T > 0).sum(axis=0))]


def _camera_for(camera, boards):
    """The camera that sees `boards`, drawn to their size."""
    corners = np.concatenate([finite_points(part) for part in boards])
    far = np.linalg.norm(corners, axis=1).max()
    parts = field_of_view(camera, FIELD * far)
    parts.append(frustum(getattr(camera, "viewer", camera), BODY * far))
    parts += axes(AXIS * far)
    named = {"camera": np.zeros((1, 3))}
    silvered = mirrors(camera)
    if silvered:
        surface = np.concatenate([finite_points(part) for part in silvered])
        parts += silvered + viewing_rays(camera)
        if np.linalg.norm(surface.mean(axis=0)) > APART * far:
            named["mirror"] = surface
        else:
            named = {"camera, mirror": named["camera"]}
    return parts + [_name(text, at, BODY * far) for text, at in named.items()]


def _name(text, points, gap):
    """A word above the middle of points (N, 3); up is negative y."""
    place = (points.min(axis=0) + points.max(axis=0)) / 2
    place[1] = points[:, 1].min() - gap
    return Labels(place[None], [text], INK)
