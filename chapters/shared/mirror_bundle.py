"""All stages of a bending mirror calibrated at once, from what each step was given."""

import numpy as np

from chapters.shared.mirror_runs import MirrorMethod
from raxel.calibration import BoardView, StageView, bundle_stages

# Inverse depth, the clamp's slope too, and a prior. Its SD, mm, has the least ray error
# at stage 3 among 1, 0.3, 0.1, 0.03, 0.01 and none, on eight seeds of either geometry,
# smooth and uneven by 10 µm, that no other run has.
AIMED = MirrorMethod("inverse depth", slope=True, prior_sd=0.1)


def bundled(rig, first, clamp, pictures, updates, errors):
    """StageBundle of all stages and boards together, with the prior of AIMED.

    first: the camera of stage 0; clamp: what is held in all stages; pictures: pixels
    (182, 2) of the board of each step, before and after it; updates: their
    MirrorUpdates, whose wrong corners are left out. Corners are known to what they
    scatter (errors, MirrorErrors).
    """
    points, board = rig.board.points(), rig.board
    sd = np.full(len(points), np.sqrt(np.mean(errors.corner**2)))
    size = board.columns, board.rows
    views = [
        StageView(
            k + after, k, BoardView(right_ones(pixels, update), points, *size, sd=sd)
        )
        for k, (pair, update) in enumerate(zip(pictures, updates, strict=True))
        for after, pixels in enumerate(pair)
    ]
    cameras = [first, *(update.camera for update in updates)]
    poses = np.stack([update.pose.T_camera_grid for update in updates])
    return bundle_stages(cameras, views, poses, clamp=clamp, prior_sd=AIMED.prior_sd)


def right_ones(pixels, update):
    """Pixels (N, 2) of a step's board, NaN where the step took a corner for wrong."""
    return np.where(update.wrong[:, None], np.nan, pixels)
