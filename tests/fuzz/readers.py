"""Every reader of files from outside: whole samples, their mutations, what reads them.

What is read is also used as the next step would use it: rays of a camera, a small
picture of a rig, a calibration on corners.
"""

import dataclasses
import io
import json
import shutil
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import yaml

from raxel.calibration.parametric.zhang import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.cameras import load_camera
from raxel.errors import InputError
from raxel.evaluation.benchmark import score_corners
from raxel.features.boards import read_boards
from raxel.features.detector import Detection
from raxel.lab.render_set import render_set
from raxel.lab.rig import load_rig
from raxel.sets import load_reference, load_set, read_colour, read_image
from tests.fuzz.archive_mutations import mutated_archive
from tests.fuzz.byte_mutations import mutated_bytes
from tests.fuzz.document_mutations import mutated_json, mutated_yaml
from tests.fuzz.grids import (
    grid_pictures,
    grid_sets,
    points,
    points_set,
    use_grid_set,
    use_points,
)
from tests.fuzz.image_mutations import HEIGHT, WIDTH, mutated_picture, pictures
from tests.fuzz.rigs import rigs
from tests.image_sets import COLUMNS, ROWS, boards, description, write_description
from tests.lab_cameras import EVERY, SIZE

# Of mutants that are read: one in so many goes on to the slow step.
CALIBRATED, RENDERED = 5, 4
# No larger pictures are rendered here.
MOST_PIXELS = 200_000
CLICKS = [[10, 20], [200, 25], [190, 200], [15, 210]]


class Reader(NamedTuple):
    """samples: () -> list of (bytes, plain data or None); prepare: what must stand in
    the folder beside the file `name`; mutate: (rng, bytes, others); say: (rng, data,
    others) for documents; read: (folder, number of the mutant)."""

    name: str
    samples: callable
    prepare: callable
    mutate: callable
    say: callable
    read: callable

    def mutant(self, rng, samples):
        """Bytes of one mutant."""
        content, data = samples[rng.integers(len(samples))]
        others = [one for one, _ in samples]
        if data is not None and rng.random() < 0.75:
            return self.say(rng, data, others)
        return self.mutate(rng, content, others)


def _documents(plain, write):
    return lambda: [(write(data).encode(), data) for data in plain()]


def _sets():
    board = description(2, camera="drawn", origin={"source": "tests", "licence": "MIT"})
    board["truth"] = "truth"
    board["views"][0] |= {"outer_corners": CLICKS, "use": "evaluate"}
    board["views"][1]["motion"] = {"translation_mm": [25, 0, 0]}
    gray = {"axis": "x", "kind": "gray", "of": 2}
    phase = {"axis": "y", "kind": "phase", "of": 3, "periods": 4}
    codes = [gray | {"image": f"view{bit}.png", "bit": bit} for bit in range(2)]
    codes += [phase | {"image": f"view{2 + k}.png", "step": k} for k in range(3)]
    monitor = {"kind": "active_grid", "monitor_px": [64, 48], "monitor_mm": [30, 20]}
    pose = {"name": "pose", "white": "view5.png", "patterns": codes}
    return [board, description(0, target=monitor, views=[pose])]


def _six_pictures(folder):
    for number in range(6):
        picture = np.zeros((240, 320), np.uint8)
        cv2.imwrite(str(folder / f"view{number}.png"), picture)


def _read_set(folder, number):
    image_set = load_set(folder)
    for view in image_set.views[:2]:
        for name in view.files[:2]:
            read_image(image_set, name)
    if hasattr(image_set.target, "points") and image_set.target.columns:
        image_set.target.points()


def _small_set(folder):
    view = {"image": "picture"}
    data = description(0, resolution=[WIDTH, HEIGHT], views=[view])
    (folder / "picture").touch()
    write_description(folder, data)


def _read_picture(folder, number):
    image_set = load_set(folder)
    assert read_image(image_set, image_set.views[0]).shape == (HEIGHT, WIDTH)
    assert read_colour(image_set, "picture").shape[:2] == (HEIGHT, WIDTH)


def _cameras():
    found = []
    for camera, _ in EVERY.values():
        if camera.kind != "general":
            found.append((_saved(camera), None))
    general = EVERY["general"][0]
    part = slice(60, 80), slice(90, 120)
    own = type(general)(general.directions[part], general.mask[part])
    far = type(general)(own.directions, own.mask, 3 * own.directions, "pitch")
    return [*found, (_saved(own), None), (_saved(far), None)]


def _saved(camera):
    stream = io.BytesIO()
    size = {"width": camera.width, "height": camera.height}
    np.savez_compressed(stream, kind=camera.kind, **size, **camera._fields())
    return stream.getvalue()


def _use_camera(folder, number):
    camera = load_camera(folder / "camera.npz")
    rng = np.random.default_rng(number)
    pixels = rng.uniform(-20, [SIZE["width"] + 20, SIZE["height"] + 20], (40, 2))
    rays = camera.rays(np.vstack([pixels, [[np.nan, 0], [np.inf, 0], [1e300, 1]]]))
    assert np.isfinite(rays.directions[rays.valid]).all()
    points = rays.origins + 300 * rays.directions
    strange = [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 1], [1e300, 0, 1], [0, 0, -1]]
    if camera.projects:
        seen = camera.project(np.vstack([points, strange]))
        assert np.isfinite(seen.pixels[seen.valid]).all()
    camera.save(folder / "again.npz")
    load_camera(folder / "again.npz")


def _use_rig(folder, number):
    rig = load_rig(folder / "rig.yaml")
    rig = dataclasses.replace(rig, count=min(rig.count, 2), evaluate=0)
    rig.draw_poses(np.random.default_rng(number), rig.count)
    pixels = rig.camera.width * rig.camera.height
    if number % RENDERED == 0 and pixels < MOST_PIXELS and _shows_little(rig):
        rig = dataclasses.replace(rig, count=1)
        shutil.rmtree(folder / "set", ignore_errors=True)
        render_set(rig, folder / "set", number)


def _shows_little(rig):
    plan = rig.patterns
    return plan is None or plan.phase_steps <= 10


def _views(folder):
    folder.mkdir(exist_ok=True)
    _six_pictures(folder)
    write_description(folder, description(4))


def _boards():
    images = [
        {
            "file": f"view{index}.png",
            "found": True,
            "columns": COLUMNS,
            "rows": ROWS,
            "corners": board.corners().tolist(),
            "sd": [0.1] * (COLUMNS * ROWS),
            "milliseconds": 3.0,
            "partial": None,
            "reason": "",
        }
        for index, board in enumerate(boards())
        if index < 4
    ]
    lost = dict(images[0], found=False, corners=[], reason="no board")
    few = [dict(images[3], file="view0.png"), *images[1:3]]
    holes = [dict(image, missing=2) for image in images]
    for image in holes:
        image["corners"] = [None, *image["corners"][1:-1], None]
        image["sd"] = [None, *image["sd"][1:-1], None]
    found = {"set": "drawn", "detector": "raxel"}
    return [
        found | {"images": images},
        found | {"images": [lost, *few[1:]]},
        found | {"images": holes},
    ]


def _use_boards(folder, number):
    image_set = load_set(folder)
    found = read_boards(folder / "corners.json", image_set)
    if number % CALIBRATED == 0:
        views = board_views(image_set, found)
        try:
            calibrate_zhang(views, image_set.width, image_set.height)
        except InputError as fault:
            raise InputError(f"{image_set.description}: views: {fault}") from fault


def _reference():
    corners = next(iter(boards())).corners().tolist()
    entry = {"corners": corners, "uncertain": [3], "missing": [], "spread_max_px": 0.6}
    images = {"view0.png": entry | {"sd": 0.1}, "view1.png": {"corners": corners}}
    return [{"columns": COLUMNS, "rows": ROWS, "note": "x", "images": images}]


def _reference_set(folder):
    _six_pictures(folder)
    (folder / "truth").mkdir(exist_ok=True)
    (folder / "corners.json").touch()
    data = description(2, reference="corners.json", truth="truth")
    write_description(folder, data)


def _use_reference(folder, number):
    image_set = load_set(folder)
    load_reference(image_set)
    shutil.copy(folder / "corners.json", folder / "truth" / "corners.json")
    corners = next(iter(boards())).corners()
    detection = Detection(True, corners, COLUMNS, ROWS)
    found = [_Found(view, detection) for view in image_set.views]
    json.dumps(score_corners(image_set, found), allow_nan=False)


class _Found(NamedTuple):
    view: object
    detection: Detection


def _nothing(folder):
    pass


READERS = {
    "set.yaml": Reader(
        *("set.yaml", _documents(_sets, yaml.safe_dump), _six_pictures),
        *(mutated_bytes, mutated_yaml, _read_set),
    ),
    "images": Reader(
        *("picture", lambda: [(one, None) for one in pictures()], _small_set),
        *(mutated_picture, None, _read_picture),
    ),
    "camera.npz": Reader(
        *("camera.npz", _cameras, _nothing),
        *(lambda *given: _either(mutated_archive, *given), None, _use_camera),
    ),
    "rig": Reader(
        *("rig.yaml", _documents(rigs, yaml.safe_dump), _nothing),
        *(mutated_bytes, mutated_yaml, _use_rig),
    ),
    "corners.json": Reader(
        *("corners.json", _documents(_boards, json.dumps), _views),
        *(mutated_bytes, mutated_json, _use_boards),
    ),
    "reference": Reader(
        *("corners.json", _documents(_reference, json.dumps), _reference_set),
        *(mutated_bytes, mutated_json, _use_reference),
    ),
    "points": Reader(
        *("points.npz", points, points_set),
        *(lambda *given: _either(mutated_archive, *given), None, use_points),
    ),
    "grid set": Reader(
        *("set.yaml", _documents(grid_sets, yaml.safe_dump), grid_pictures),
        *(mutated_bytes, mutated_yaml, use_grid_set),
    ),
}


def _either(by_form, rng, content, others):
    """Damage by the file's form, or to its bytes one time in four."""
    mutate = mutated_bytes if rng.random() < 0.25 else by_form
    return mutate(rng, content, others)


def write_mutant(reader, folder, seed, number, samples):
    """Put mutant `number` into a prepared folder; its bytes."""
    rng = np.random.default_rng([seed, sum(map(ord, reader.name)), number])
    content = reader.mutant(rng, samples)
    (Path(folder) / reader.name).write_bytes(content)
    return content
