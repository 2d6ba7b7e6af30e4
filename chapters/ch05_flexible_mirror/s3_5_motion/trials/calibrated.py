"""A mirror calibrated stage by stage as published, after three pushes."""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.errors import InputError

LAST = len(STAGES_MM) - 1


def calibrated(rig, true, errors, seed):
    """(cameras of the stages that were reached, code of the error that ended it or "").

    true: the true cameras; seed: draws the errors.
    """
    rng = np.random.default_rng(seed)
    try:
        first = primary(rig, true[0], PUBLISHED, errors, rng)
    except InputError as refusal:
        return [], refusal.code
    found, points = [first.camera], rig.board.points()
    for k in range(1, LAST + 1):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = [seen_board(rig, c, T, errors, rng) for c in true[k - 1 : k + 1]]
        try:
            stage = deflected(found[-1], true[k], pair, points, first.clamp, PUBLISHED)
        except InputError as refusal:
            return found, refusal.code
        found.append(stage.camera)
    return found, ""
