"""A mirror rig becomes a mirror set on disk, with the truth beside it.

The set has the form of a recorded one (`raxel.sets.mirror_set`). In folders `truth`,
opened by evaluation alone, are the cameras of the stages, the boards' poses, and what
detectors and decoders ought to find. Without these folders nothing is lost but scores.
"""

import itertools
import os
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from raxel.errors import InputError
from raxel.io.files import check_can_be_written, write_json, write_whole
from raxel.lab.board_photograph import photograph_board
from raxel.lab.platter_views import camera_in_platter, photograph_plate
from raxel.lab.render_set import TRUTH, render_set, write_picture
from raxel.lab.target_poses import ListedPoses
from raxel.sets.image_set import write_set
from raxel.sets.mirror_set import DESCRIPTION, load_mirror_set
from raxel.sets.model import ImageSet, View

# Streams of random numbers, so that no draw depends on how many came before. Pictures
# of one are counted from 1: a stream that ends in 0 is the same as without it.
VIEWER, GRIDS, PLATTER, PLATE, STEPS, CLAMP, SPECIMEN = range(7)


def render_mirror_set(rig, out, seed, level=None, say=None):
    """Photograph all of a MirrorSetRig; the MirrorSet in `out`, new or not at all.

    level: of the noise, by name, default the first; the set's name ends in level and
    seed. seed: whole number, 0 or more; it draws poses, noise and the mirror's
    aberration, and the same seed gives the same bytes. say: a callable told one line
    for each part. Raises InputError for a folder that exists or cannot be made, and as
    the rigs' poses.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already; name a new folder")
    check_can_be_written(out)
    say = say or (lambda line: None)
    rig = rig.darker(level)
    cameras = rig.cameras(seed)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "set"
        folder.mkdir()
        say("boards before the camera")
        render_set(rig.viewer, folder / "viewer", _seed(seed, VIEWER))
        _write_primary(rig, cameras[0], folder, seed, say)
        steps, poses = _write_steps(rig, cameras, folder / "stages", seed, say)
        _write_truth(folder / TRUTH, cameras, poses)
        picked = rig.clamp_pixels(cameras[0], np.random.default_rng([seed, CLAMP]))
        text = yaml.safe_dump(_described(rig, picked, steps, seed), sort_keys=False)
        write_whole(folder / DESCRIPTION, text)
        load_mirror_set(folder)
        os.rename(folder, out)
    return load_mirror_set(out)


def _seed(seed, stream):
    """A seed of its own for one of the image sets."""
    return int(np.random.SeedSequence([seed, stream]).generate_state(1)[0])


def _write_primary(rig, camera, folder, seed, say):
    """The active grid in the mirror, the same in the platter, and the plate's board."""
    drawn = rig.grids.draw_poses(np.random.default_rng([seed, GRIDS]), rig.grids.count)
    names = tuple(rig.grids.view_name(k) for k in range(len(drawn)))
    poses = ListedPoses(drawn, names, (False,) * len(names))
    grids = replace(rig.grids, poses=poses, evaluate=0)
    say("the active grid in the mirror")
    render_set(replace(grids, camera=camera), folder / "grids", _seed(seed, GRIDS))
    say("the active grid in the platter")
    T = rig.plate.draw_poses(np.random.default_rng([seed, PLATE]), 1)[0]
    seen = camera_in_platter(rig.plate.camera, rig.ring, T)
    shown = replace(grids, camera=seen)
    render_set(shown, folder / "platter", _seed(seed, PLATTER))
    plate = folder / "plate"
    plate.mkdir()
    files = [f"{name}.png" for name in names]
    for k, name in enumerate(files, 1):
        rng = np.random.default_rng([seed, PLATE, k])
        write_picture(plate / name, photograph_plate(rig.plate, rig.ring, T, rng))
    _write_boards(rig.plate, files, plate)


def _write_steps(rig, cameras, folder, seed, say):
    """(steps for mirror.yaml, true poses by picture)"""
    folder.mkdir()
    steps, poses = [], {}
    for k, pair in enumerate(itertools.pairwise(cameras), 1):
        say(f"step {k}")
        T = rig.step_pose(np.random.default_rng([seed, STEPS, k]), *pair)
        names = {key: f"s{k}-{key}.png" for key in ("before", "after")}
        for name, camera in zip(names.values(), pair, strict=True):
            noise = np.random.default_rng([seed, STEPS, k, len(poses) + 1])
            specimen = np.random.default_rng([seed, SPECIMEN])
            taken = replace(rig.steps, camera=camera)
            write_picture(folder / name, photograph_board(taken, T, noise, specimen))
            poses[name] = T.tolist()
        moved = np.subtract(rig.stages[k], rig.stages[k - 1])
        # Of several loads no one number says how far the mirror was moved.
        stated = {"deflection_mm": float(moved[0])} if len(moved) == 1 else {}
        steps.append(names | stated)
    _write_boards(rig.steps, list(poses), folder)
    return steps, poses


def _write_boards(rig, images, folder):
    described = ImageSet(
        name=folder.name,
        width=rig.camera.width,
        height=rig.camera.height,
        target=rig.target,
        views=tuple(View(image=image) for image in images),
        folder=folder,
        camera=rig.summary,
        origin={"source": "rendered", "note": f"by raxel's laboratory: {rig.name}"},
    )
    write_set(described)


def _write_truth(folder, cameras, poses):
    folder.mkdir()
    for k, camera in enumerate(cameras):
        camera.save(folder / f"stage-{k}.npz")
    write_json(folder / "poses.json", {"unit": "mm", "T_camera_target": poses})


def _described(rig, picked, steps, seed):
    """The content of mirror.yaml."""
    (level,) = rig.light
    hidden = float(rig.changes.get("holder", rig.grids.camera.mirror.holder))
    clamp = {"points": picked.round(2).tolist(), "sd_px": rig.pick_sd_px}
    sets = {name: name for name in ("grids", "platter", "plate")}
    return {
        "raxel_mirror_set": 1,
        "name": f"{rig.name}-{level}-{seed}",
        "viewer": "viewer",
        "primary": sets | {"thickness_mm": rig.ring.thickness_mm},
        "clamp": clamp | ({"hidden_mm": hidden} if hidden else {}),
        "stages": {"set": "stages", "steps": steps},
    }
