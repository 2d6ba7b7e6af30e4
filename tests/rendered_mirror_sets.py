"""A mirror set on disk, rendered: images of a flexible mirror as a user takes them.

`write_mirror_set` makes the folder that `raxel.sets.load_mirror_set` reads, with the
true cameras and poses in its folder `truth`, for scoring alone.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from chapters.shared.mirror.images import platter_camera, platter_image
from chapters.shared.mirror.rigs import BACK_PROJECTION_MM, DYNAMIC_MM
from raxel.io.files import write_json, write_whole
from raxel.lab.set_rendering import render_board, render_set, write_image
from raxel.lab.target_poses import DrawnPoses, Visibility
from raxel.sets import Chessboard, ImageSet, View, write_set
from raxel.sets.mirror_set import DESCRIPTION

# The board that calibrates the viewer: number of images, and its width relative to the
# image at the mean distance.
VIEWER_BOARD, VIEWER_VIEWS, VIEWER_SHARE = Chessboard(10, 7, 10.0), 8, 0.5
# The board of the steps: as large as the mirror shows whole at 260 mm before and after
# 5 mm, since a board whose end is not seen on every side is counted wrongly.
STEP_BOARD = Chessboard(14, 10, 13.0)
# How exactly a person picks points on the clamp's edge, px.
PICKED_PX = 0.5
# Streams of random numbers of a seed. What `render_set` draws itself has the first
# three, a number for each view behind them; numpy takes trailing zeros for nothing.
POSES, NOISE, PICKED, PLATE, STEPS = range(5)


def write_mirror_set(rig, folder, seed, deflections, board=STEP_BOARD, **optional):
    """Render a mirror set of a `MirrorRig` into `folder`, which is not there yet.

    seed: whole number; deflections: (k + 1,) mm, stage 0 first: k steps, each with a
    board before and after it and another, farther off, to score it; board: the
    Chessboard of the steps, all of whose corners are visible in every image; optional:
    as for `rig.camera` (aberration_um and its seed, strain_um, holder_mm). Raises
    RuntimeError, as `rig.board_pose`, where a step is too large for the board.
    """
    folder = Path(folder)
    folder.mkdir()
    rig = replace(rig, rig=replace(rig.rig, target=board))
    cameras = [rig.camera(one, **optional) for one in deflections]
    render_set(_viewer_rig(rig), folder / "viewer", seed)
    render_set(replace(rig.monitor, camera=cameras[0]), folder / "grids", seed + 2)
    platter = rig.platter(np.random.default_rng([seed, POSES]))
    seen_flat = replace(rig.monitor, camera=platter_camera(rig, platter))
    render_set(seen_flat, folder / "platter", seed + 1)
    _write_plate(rig, platter, folder / "plate", seed)
    steps, poses = _write_stages(rig, cameras, deflections, folder / "stages", seed)
    _write_truth(folder / "truth", cameras, poses)
    picked = np.random.default_rng([seed, PICKED])
    line = rig.clamp_pixels(cameras[0], 5, picked, PICKED_PX)
    hidden = cameras[0].mirror.holder
    clamp = {"points": line.round(2).tolist(), "sd_px": PICKED_PX}
    sets = {name: name for name in ("grids", "platter", "plate")}
    description = {
        "raxel_mirror_set": 1,
        "name": rig.rig.name,
        "viewer": "viewer",
        "primary": sets | {"thickness_mm": platter.thickness_mm},
        "clamp": clamp | ({"hidden_mm": hidden} if hidden else {}),
        "stages": {"set": "stages", "steps": steps},
    }
    write_whole(folder / DESCRIPTION, yaml.safe_dump(description, sort_keys=False))


def _viewer_rig(rig):
    """The rig whose camera looks at a board directly."""
    viewer = rig.viewer
    board = VIEWER_BOARD.pitch_mm * (VIEWER_BOARD.columns + 1)
    middle = board * viewer.K[0, 0] / (VIEWER_SHARE * viewer.width)
    poses = DrawnPoses(
        (0.8 * middle, 1.2 * middle), *np.radians([[0, 6], [20, 45], [0, 360]])
    )
    return replace(
        rig.rig,
        camera=viewer,
        target=VIEWER_BOARD,
        border_mm=VIEWER_BOARD.pitch_mm,
        poses=poses,
        visibility=Visibility(4, 10),
        count=VIEWER_VIEWS,
        evaluate=0,
    )


def _write_plate(rig, platter, folder, seed):
    folder.mkdir()
    names = [f"{name}.png" for name in rig.monitor.poses.names]
    for k, name in enumerate(names):
        rng = np.random.default_rng([seed, PLATE, k])
        write_image(folder / name, platter_image(rig, platter, rng))
    _write_boards(rig, "plate", platter.board, names, folder)


def _write_stages(rig, cameras, deflections, folder, seed):
    """(steps for mirror.yaml, true poses by image)"""
    folder.mkdir()
    rng = np.random.default_rng([seed, POSES, 1])
    steps, poses, least = [], {}, rig.board.columns * rig.board.rows
    for k in range(1, len(cameras)):
        pair = tuple(deflections[k - 1 : k + 1])
        held = rig.board_pose(rng, DYNAMIC_MM, pair, least)
        beyond = rig.board_pose(rng, BACK_PROJECTION_MM, pair[1:], least)
        taken = {
            f"s{k}-before.png": (cameras[k - 1], held),
            f"s{k}-after.png": (cameras[k], held),
            f"s{k}-else.png": (cameras[k], beyond),
        }
        for name, (camera, T) in taken.items():
            noise = np.random.default_rng([seed, STEPS, len(poses)])
            image = render_board(replace(rig.rig, camera=camera), T, noise, noise)
            write_image(folder / name, image)
            poses[name] = T.tolist()
        before, after, evaluate = taken
        moved = float(pair[1] - pair[0])
        steps.append(
            {
                "before": before,
                "after": after,
                "evaluate": [evaluate],
                "deflection_mm": moved,
            }
        )
    _write_boards(rig, "stages", rig.board, list(poses), folder)
    return steps, poses


def _write_boards(rig, name, board, images, folder):
    camera = rig.rig.camera
    views = tuple(View(image=image) for image in images)
    origin = {"source": "rendered", "note": f"rig {rig.rig.name}"}
    described = ImageSet(
        name, camera.width, camera.height, board, views, folder, origin=origin
    )
    write_set(described)


def _write_truth(folder, cameras, poses):
    folder.mkdir()
    for k, camera in enumerate(cameras):
        camera.save(folder / f"stage-{k}.npz")
    write_json(folder / "poses.json", {"unit": "mm", "T_camera_target": poses})
