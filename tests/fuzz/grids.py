"""Active grids for `tests.fuzz.readers`: sets that are decoded, and decoded points."""

import io
import json
import shutil

import cv2
import numpy as np

from raxel.calibration.views.dense import dense_view
from raxel.errors import CalibrationError
from raxel.evaluation.benchmark import score_points
from raxel.features.active_grid.view import decode_view
from raxel.features.grids import read_grids
from raxel.sets import ImageSet, View, load_set
from raxel.sets.image_set import _plain
from tests.active_grids import drawn
from tests.image_sets import description, write_description

NAMES = ("pose-a", "pose-b")
WIDTH, HEIGHT = 48, 40
DECODED = 3  # one mutant in so many is decoded, where it is read


def _scene():
    return drawn(
        size=(WIDTH, HEIGHT), monitor=(64, 48), cells=2, steps=3, noise=1.0, share=0.9
    )


def grid_sets():
    """What set.yaml says of a small grid: whole, one axis, and with white and black."""
    scene = _scene()
    every = tuple(scene.patterns)
    upright = tuple(p for p in every if not p.inverse)
    one = tuple(p for p in every if p.axis == "x")
    levels = {"white": "white.png", "black": "black.png"}
    views = [
        View(name="pose", patterns=every),
        View(name="pose", patterns=upright, **levels),
        View(name="pose", patterns=one),
    ]
    return [
        _plain(ImageSet("drawn", WIDTH, HEIGHT, scene.grid, (view,), None))
        for view in views
    ]


def grid_pictures(folder):
    """The pictures of that grid."""
    scene = _scene()
    for pattern, image in zip(scene.patterns, scene.images, strict=True):
        cv2.imwrite(str(folder / pattern.image), image)
    cv2.imwrite(str(folder / "white.png"), scene.white)
    cv2.imwrite(str(folder / "black.png"), scene.black)


def use_grid_set(folder, number):
    """Read the set, and decode its first view."""
    image_set = load_set(folder)
    if number % DECODED or not hasattr(image_set.target, "monitor_px"):
        return
    found = decode_view(image_set, image_set.views[0])
    known = np.isfinite(found.decoded.location).any(axis=2)
    assert not known[~found.decoded.mask].any()


def points():
    """Files of decoded points: with mask and sigma, and of points alone."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    place = np.stack([u / 2.0, v / 2.0], axis=-1)
    place[:9] = np.nan
    more = {
        "sigma_mm": np.full(place.shape, 0.1, np.float32),
        "mask": np.isfinite(place[..., 0]),
        "status": np.zeros(place.shape[:2], np.uint8),
    }
    found = []
    for array in (place, place.astype(np.float32), np.asfortranarray(place)):
        for beside in ({}, more):
            stream = io.BytesIO()
            np.savez_compressed(stream, points_mm=array, **beside)
            found.append((stream.getvalue(), None))
    return found


def points_set(folder):
    """A set with truth that such points are of."""
    (folder / "truth").mkdir(exist_ok=True)
    code = {"axis": "x", "kind": "gray", "bit": 0, "of": 1}
    views = []
    for name in NAMES:
        cv2.imwrite(str(folder / f"{name}.png"), np.zeros((HEIGHT, WIDTH), np.uint8))
        views.append({"name": name, "patterns": [code | {"image": f"{name}.png"}]})
    target = {"kind": "active_grid", "monitor_px": [64, 48], "monitor_mm": [30, 20]}
    data = description(0, resolution=[WIDTH, HEIGHT], target=target, views=views)
    write_description(folder, data | {"truth": "truth"})
    for place in (folder, folder / "truth"):
        for name in NAMES:
            (place / f"{name}.npz").write_bytes(points()[0][0])


def use_points(folder, number):
    """Score them against the truth, and take them for a calibration."""
    shutil.copy(folder / "points.npz", folder / f"{NAMES[number % 2]}.npz")
    image_set = load_set(folder)
    scored = score_points(image_set, folder)
    json.dumps(scored, allow_nan=False)
    for grid in read_grids(folder, image_set):
        try:
            dense_view(grid.location, grid.sigma, grid.mask, grid.view.label)
        except CalibrationError:
            continue
