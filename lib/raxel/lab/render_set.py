"""A rig becomes an image set on disk, with the truth beside it.

The set has the form of a recorded one (`raxel.sets`). In its folder `truth`, opened by
evaluation alone, are the camera, the poses and what detectors and decoders ought to
find.
"""

import os
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from raxel.errors import InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.io.files import check_can_be_written, write_json
from raxel.lab.board_photograph import photograph_board
from raxel.lab.monitor_views import (
    photograph_chessboard,
    photograph_patterns,
    points_seen,
)
from raxel.sets.image_set import load_set, write_set
from raxel.sets.model import ActiveGrid, ImageSet, View
from raxel.sets.patterns import CHESSBOARD

TRUTH = "truth"
# Streams of random numbers, so that no draw depends on how many came before.
POSES, NOISE, SPECIMEN = 0, 1, 2


def render_set(rig, out, seed, say=None):
    """Photograph the rig's target in poses drawn from `seed`; the ImageSet in `out`.

    rig: Rig; out: a folder that is not there yet; seed: whole number, 0 or more; the
    same seed gives the same bytes. say: a callable told one line per view. The folder
    appears when all is in it, or not at all. Raises InputError for a folder that
    exists or cannot be made, and as `Rig.draw_poses`.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already; name a new folder")
    check_can_be_written(out)
    views = rig.count + rig.evaluate
    poses = rig.draw_poses(np.random.default_rng([seed, POSES]), views)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "set"
        (folder / TRUTH).mkdir(parents=True)
        is_monitor = isinstance(rig.target, ActiveGrid)
        photograph = _monitor_view if is_monitor else _board_view
        taken = []
        for index, T in enumerate(poses):
            use = "calibrate" if index < rig.count else "evaluate"
            taken.append(photograph(rig.at_view(index), T, index, use, folder, seed))
            if say:
                say(f"{index + 1}/{views} {taken[-1].label}")
        _write_truth(rig, poses, taken, folder / TRUTH)
        write_set(_described(rig, taken, folder, seed))
        os.rename(folder, out)
    return load_set(out)


def write_picture(path, picture):
    """A picture (H, W) or (H, W, 3), red, green, blue, as PNG."""
    import cv2

    if picture.ndim == 3:
        picture = picture[..., ::-1]
    path.write_bytes(cv2.imencode(".png", np.ascontiguousarray(picture))[1].tobytes())


def _board_view(rig, T_camera_target, index, use, folder, seed):
    rng = np.random.default_rng([seed, NOISE, index])
    specimen = np.random.default_rng([seed, SPECIMEN])
    picture = photograph_board(rig, T_camera_target, rng, specimen)
    name = f"view-{index:03d}.png"
    write_picture(folder / name, picture)
    return View(image=name, use=use)


def _monitor_view(rig, T_camera_target, index, use, folder, seed):
    name = rig.view_name(index)
    (folder / name).mkdir()
    pictures = photograph_patterns(rig, T_camera_target, [seed, NOISE, index])
    files, patterns = {}, []
    if rig.shows_chessboard(index):
        picture = photograph_chessboard(rig, T_camera_target, [seed, NOISE, index])
        files["chessboard"] = f"{name}/{CHESSBOARD}"
        write_picture(folder / files["chessboard"], picture)
    for key, picture in pictures:
        label = key if isinstance(key, str) else key.image
        write_picture(folder / name / label, picture)
        if isinstance(key, str):
            files[key.removesuffix(".png")] = f"{name}/{label}"
        else:
            patterns.append(replace(key, image=f"{name}/{label}"))
    return View(name=name, patterns=tuple(patterns), use=use, **files)


def _described(rig, views, folder, seed):
    note = f"rendered by raxel's virtual laboratory: rig {rig.name}, seed {seed}"
    return ImageSet(
        name=rig.name,
        width=rig.camera.width,
        height=rig.camera.height,
        target=rig.target,
        views=tuple(views),
        folder=folder,
        camera=rig.summary,
        origin={"source": "rendered", "note": note},
        truth=f"{TRUTH}/",
    )


def _write_truth(rig, poses, views, folder):
    rig.camera.save(folder / "camera.npz")
    labels = [view.label for view in views]
    matrices = {label: T.tolist() for label, T in zip(labels, poses, strict=True)}
    write_json(folder / "poses.json", {"unit": "mm", "T_camera_target": matrices})
    if isinstance(rig.target, ActiveGrid):
        for index, (label, T) in enumerate(zip(labels, poses, strict=True)):
            camera = rig.at_view(index).camera
            points = points_seen(camera, T, rig.target.monitor_mm)
            np.savez(folder / f"{label}.npz", points_mm=points)
        if rig.target.chessboard and rig.camera.continuous:
            shown = [view.chessboard for view in views]
            write_json(folder / "corners.json", _corners_of_views(rig, shown, poses))
    else:
        write_json(folder / "corners.json", _corners_of_views(rig, labels, poses))


def _corners_of_views(rig, labels, poses):
    """`true_corners` of views, each with its own lens; label None: without a board."""
    parts = [
        true_corners(rig.at_view(index), {label: T})
        for index, (label, T) in enumerate(zip(labels, poses, strict=True))
        if label
    ]
    images = {label: at for part in parts for label, at in part["images"].items()}
    return parts[0] | {"images": images}


def true_corners(rig, poses):
    """The projected corners in the form of a set's reference corners (corners.json).

    poses: {label of the picture: T_camera_target (4, 4)}.
    """
    is_monitor = isinstance(rig.target, ActiveGrid)
    board = rig.target.chessboard if is_monitor else rig.target
    points = rig.target.chessboard_points() if is_monitor else board.points()
    flat = on_plane(points)
    images = {
        label: {
            "corners": rig.camera.project(transform(T, flat)).pixels.tolist(),
            "sd": 0.0,
        }
        for label, T in poses.items()
    }
    note = "true projections of the board's corners; the first is the frame's origin"
    counts = {"columns": board.columns, "rows": board.rows}
    return counts | {"note": note, "images": images}
