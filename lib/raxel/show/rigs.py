"""A rig of the laboratory as a scene: camera, mirror, field of view, target poses."""

import numpy as np

from raxel.lab.render_set import POSES
from raxel.sets.model import ActiveGrid
from raxel.show.boards import BACK, board
from raxel.show.cameras import axes, field_of_view, frustum, mirrors, viewing_rays
from raxel.show.scene import Labels, Points, finite_points
from raxel.show.view import INK, framed

EVALUATE = "#d9b38c"
# The camera's pyramid, and its axes, as shares of the farthest target's distance.
BODY, AXIS = 0.1, 0.25


def rig_scene(rig, seed=0):
    """Where a rig's camera, mirror and targets stand, in the camera's frame.

    rig: `raxel.lab.Rig`; seed: whole number; the poses are those that `raxel render`
    draws from the same seed. Raises InputError as `Rig.draw_poses`.
    """
    poses = rig.draw_poses(
        np.random.default_rng([seed, POSES]), rig.count + rig.evaluate
    )
    what = "monitor" if isinstance(rig.target, ActiveGrid) else "chessboard"
    boards = [
        board(
            rig.target, T, rig.border_mm,
            f"{what} to calibrate with" if k < rig.count else f"{what} to evaluate with",
            BACK if k < rig.count else EVALUATE,
        )
        for k, T in enumerate(poses)
    ]  # fmt: skip
    parts = boards + camera_parts(rig.camera, boards)
    count = f"{rig.count} poses" + (f" and {rig.evaluate} more" if rig.evaluate else "")
    note = f"{rig.name}: {rig.summary}. {count}, drawn from seed {seed}."
    return framed(parts, note=note)


def camera_parts(camera, boards):
    """The camera that sees `boards`, in their frame, drawn to their size."""
    corners = np.concatenate([finite_points(part) for part in boards])
    far = np.linalg.norm(corners, axis=1).max()
    parts = field_of_view(camera, 0.6 * far)
    parts += mirrors(camera) + viewing_rays(camera)
    parts.append(frustum(getattr(camera, "viewer", camera), BODY * far))
    parts += axes(AXIS * far)
    return parts
