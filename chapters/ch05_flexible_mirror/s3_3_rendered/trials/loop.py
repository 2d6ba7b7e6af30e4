"""Out, back and at a stroke from pictures: the loop of Table 5.5, rendered.

One board stays before the mirror at all stages, so that four renders do: on the way
back, and after the single step, the light on the sensor is that of the way out, and is
exposed again with new noise.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.trials.pictures import (
    MirrorRun,
    lit_outline,
    read_pictures,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.trials.run import (
    WAYS,
    primary,
    scored,
    scoring_boards,
)
from chapters.shared.mirror_bench import BENCHES
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_scores import load_height
from raxel.calibration.mirror.partial_boards import (
    labelled_like,
    lattice_of,
    on_one_lattice,
)
from raxel.calibration.mirror.platter import grid_poses_in_platter
from raxel.calibration.mirror.update import update_mirror
from raxel.errors import CalibrationError, InputError
from raxel.features import find_board
from raxel.lab import board_scene
from raxel.lab.windowed import mirror_window, windowed


class LoopPicture(NamedTuple):
    """What was read out of a picture of the board. stage: at which it was taken;
    lattice: the Partial found, pixels of the whole picture; outline: (M, 2) px around
    the mirror."""

    stage: int
    lattice: object
    outline: np.ndarray


class BoardLoop(NamedTuple):
    """scene: a MirrorRun with the board that stays; pictures: LoopPictures in the order
    in which they were taken; held_out: boards that score each stage; picks: (L, 2) px
    at the clamp."""

    scene: MirrorRun
    pictures: list
    held_out: list
    picks: np.ndarray


def rendered_loop_trial(condition, rng, sizes):
    """Steps out, as many back, and the single one, by each way of WAYS.

    sizes: RunSizes. `refused`, of the run or of a way, says where it ended, if early,
    and `single_refused` that the single step was refused.
    """
    rig = mirror_rig(condition["geometry"], small=sizes.small)
    scene = scene_of_loop(rig, BENCHES[condition["bench"]], sizes.steps, rng)
    try:
        # Without boards: what the primary stage needs, and no step.
        read = read_pictures(scene._replace(boards=[]), sizes, rng).views
        pictures = loop_pictures(scene, rng)
    except InputError as refusal:
        return {"refused": str(refusal)}
    loop = BoardLoop(scene, pictures, scoring_boards(scene, rng), read.clamp.points)
    return {name: by_way(loop, read, way) for name, way in WAYS.items()}


def scene_of_loop(rig, bench, steps, rng):
    """A MirrorRun whose board stays in one place at all stages."""
    cameras = rig.stages(
        aberration_um=bench.aberration_um, seed=int(rng.integers(2**32))
    )
    stay = rig.board_pose(rng, deflections=STAGES_MM[: steps + 1])
    return MirrorRun(rig, bench, cameras, rig.monitor_poses(rng), [stay] * steps)


def stages_of(steps):
    """Stages in the order in which the mirror goes through them: 0, 1, ..., 1, 0."""
    return [*range(steps), *range(steps, -1, -1)]


def loop_pictures(scene, rng):
    """LoopPictures of the whole loop. Raises CalibrationError where one shows no
    board."""
    steps = len(scene.boards)
    lights = [light_at(scene, stage) for stage in range(steps + 1)]
    return [
        read_picture(scene, stage, lights[stage], number, rng)
        for number, stage in enumerate(stages_of(steps))
    ]


def light_at(scene, stage):
    """Light (h, w) on the sensor in the window that the mirror fills at a stage."""
    taken = taken_at(scene, stage)
    board = board_scene(
        taken.target, scene.boards[0], taken.border_mm, **taken.radiances
    )
    return taken.laboratory().irradiance(board, np.eye(4))


def taken_at(scene, stage):
    """The rig with the true camera of a stage, in the window that its mirror fills."""
    camera = scene.cameras[stage]
    return windowed(replace(scene.rig.rig, camera=camera), mirror_window(camera))


def read_picture(scene, stage, light, number, rng):
    """LoopPicture of light on the sensor, exposed with noise of its own."""
    window, board = mirror_window(scene.cameras[stage]), scene.rig.board
    picture = scene.rig.rig.sensor.expose(light, rng, colour=False)
    found = lattice_of(find_board(picture, board.columns, board.rows))
    if found is None:
        raise CalibrationError(f"picture {number}: no board is seen in the mirror")
    first = [window.u, window.v]
    lattice = found._replace(corners=found.corners + first)
    return LoopPicture(stage, lattice, lit_outline(picture) + first)


def by_way(loop, read, way):
    """All steps by a MirrorMethod, each from the camera that the one before it left."""
    steps, out = len(loop.scene.boards), {}
    last = 2 * steps
    try:
        poses = grid_poses_in_platter(read.viewer, read.platter, read.thickness)
        calibration, held = primary(read, poses, way)
        cameras = [calibration.camera]
        out["start"] = scored(loop.scene, 0, cameras[0], loop.held_out)
        for number in range(1, last + 1):
            camera, found = stepped(
                loop, cameras[-1], (number - 1, number), held, way, f"step {number}"
            )
            cameras.append(camera)
            out[f"step{number}"] = found
    except InputError as refusal:
        return out | {"refused": str(refusal)}
    try:
        single = stepped(loop, cameras[steps], (steps, last), held, way, "single step")
        return out | {"single": single[1]}
    except InputError as refusal:
        return out | {"single_refused": str(refusal)}


def stepped(loop, before, pair, held, way, name):
    """(camera after, its scores) of the step between two pictures, by their numbers."""
    scene = loop.scene
    start, end = (loop.pictures[number] for number in pair)
    like = labelled_like(start.lattice, end.lattice, loop.picks, name)
    names = f"{name} before", f"{name} after"
    views = on_one_lattice([start.lattice, like], scene.rig.board, names)
    stage = update_mirror(
        before, views[0].pixels, views[1].pixels, views[0].points, held, way.settings,
        outline=end.outline,
    )  # fmt: skip
    residuals = stage.residuals[np.isfinite(stage.residuals)]
    heights = [
        load_height(scene.rig, camera, scene.cameras[picture.stage])
        for camera, picture in zip((before, stage.camera), (start, end), strict=True)
    ]
    return stage.camera, {
        "deflection_mm": abs(heights[1] - heights[0]),
        "residual_mm": float(residuals.mean()),
        "common": len(residuals),
        "wrong": int(np.count_nonzero(stage.wrong)),
        **scored(scene, end.stage, stage.camera, loop.held_out),
    }
