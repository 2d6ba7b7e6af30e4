"""A mirror calibrated after three pushes: stage by stage, or all stages at once."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_bundle import bundled
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import deflected, primary, seen_board
from raxel.errors import InputError

LAST = len(STAGES_MM) - 1


class StagesFound(NamedTuple):
    """cameras: of the stages that were reached; clamp: what is held in all of them;
    updates: MirrorUpdates of stages 1 to 3; pictures: pixels (182, 2) of the board of
    each step, before and after it, NaN where a corner is not seen."""

    cameras: list
    clamp: object
    updates: list
    pictures: list

    @property
    def last(self):
        """The camera of stage 3, None where it was not reached."""
        return self.cameras[LAST] if len(self.cameras) > LAST else None


def calibrated(rig, true, errors, seed, method):
    """(StagesFound, why it ends before stage 3 or ""), stage by stage.

    true: the true cameras; seed: draws the errors, the same for all methods.
    """
    rng = np.random.default_rng(seed)
    try:
        first = primary(rig, true[0], method, errors, rng)
    except InputError as refusal:
        return StagesFound([], None, [], []), f"stage 0: {refusal}"
    found = StagesFound([first.camera], first.clamp, [], [])
    points = rig.board.points()
    for k in range(1, LAST + 1):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = [seen_board(rig, c, T, errors, rng) for c in true[k - 1 : k + 1]]
        before = found.cameras[-1]
        try:
            stage = deflected(before, true[k], pair, points, first.clamp, method)
        except InputError as refusal:
            return found, f"stage {k}: {refusal}"
        found.cameras.append(stage.camera)
        found.updates.append(stage)
        found.pictures.append(pair)
    return found, ""


def all_stages(rig, found, errors):
    """(camera of stage 3 or None, why not or ""), of all stages and boards at once,
    from StagesFound that reach it by AIMED."""
    try:
        bundle = bundled(
            rig, found.cameras[0], found.clamp, found.pictures, found.updates, errors
        )
    except InputError as refusal:
        return None, str(refusal)
    return bundle.cameras[LAST], ""
