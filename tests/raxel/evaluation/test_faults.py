"""What is reported of faults in a set of boards: camera x fault x finding.

As `raxel calibrate` does it: a camera is fitted, wrong corners are left out, and the
boards' corners, halves of the images and single images are tested.
"""

import numpy as np
import pytest

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.cli.calibrate import Fitting, _calibrated
from raxel.cli.models import FITS
from raxel.evaluation.board_corners import board_corners, without_wrong_corners
from raxel.evaluation.split_half import split_half
from raxel.geometry.planes import on_plane
from raxel.sets.model import BOARDS
from tests.board_scenes import BOARD
from tests.raxel.evaluation.test_split_half import (
    CAMERA,
    COUNT,
    OTHER,
    SIZE,
    lens,
    views_of,
)

FLAT = on_plane(BOARD)
X, Y = ((BOARD - BOARD.mean(axis=0)) / (np.ptp(BOARD, axis=0) / 2)).T
WAVE = FLAT + 0.5 * np.sin(np.pi * X)[:, None] * [0, 0, 1]
MIXED = [CAMERA, CAMERA, OTHER, CAMERA, OTHER, OTHER, OTHER]
WRONG = ((2, 17), (5, 40), (9, 8))  # image, corner


def sound(seed):
    return views_of(COUNT * [CAMERA], seed)


def shuttered(seed):
    ways = np.random.default_rng(seed).normal(size=(COUNT, 3))
    ways *= 2 / np.linalg.norm(ways, axis=1)[:, None]
    return views_of(COUNT * [CAMERA], seed, shift=ways)


def changed(seed, change):
    """One image of which pixels were moved by `change`, as a program does."""
    views = sound(seed)
    views[6] = views[6]._replace(pixels=change(views[6].pixels))
    return views


def halved(seed):
    """Half of the images in half their size, as a program that saves previews."""
    views = sound(seed)
    pixels = [
        view.pixels / 2 - 0.25 if k % 2 else view.pixels for k, view in enumerate(views)
    ]
    return [v._replace(pixels=p) for v, p in zip(views, pixels, strict=True)]


def with_wrong_corners(seed):
    views = sound(seed)
    for image, corner in WRONG:
        views[image].pixels[corner] += [6.0, -5.0]
    return views


def copied(seed):
    views = sound(seed)
    return [*views, *(views[k]._replace(name=f"copy-{k}.png") for k in (0, 0, 3))]


FAULTS = {
    "none": (sound, set()),
    "copies": (copied, set()),
    "wrong corners": (with_wrong_corners, {"wrong corners"}),
    "two cameras": (
        lambda seed: views_of(7 * [CAMERA] + 7 * [OTHER], seed),
        {"camera"},
    ),
    "two cameras, mixed": (
        lambda seed: views_of(MIXED + MIXED[::-1], seed),
        {"camera"},
    ),
    "zoom": (
        lambda seed: views_of([lens(f) for f in np.linspace(346, 354, COUNT)], seed),
        {"camera"},
    ),
    "board stretched one way": (
        lambda seed: views_of(
            COUNT * [CAMERA], seed, solid=on_plane(BOARD * [1.005, 1])
        ),
        {"camera"},
    ),
    "bent board": (
        lambda seed: views_of(COUNT * [CAMERA], seed, solid=WAVE),
        {"board"},
    ),
    "rolling shutter": (shuttered, {"camera"}),
    "mirrored image": (
        lambda seed: changed(seed, lambda p: [SIZE[0] - 1, 0] + p * [-1, 1]),
        {"camera"},
    ),
    "halved images": (halved, {"camera"}),
    "one image by another zoom": (
        lambda seed: views_of(4 * [CAMERA] + [lens(371)] + 9 * [CAMERA], seed),
        {"camera"},
    ),
}


def findings(views):
    camera = calibrate_zhang(views, *SIZE).camera
    right = without_wrong_corners(camera, views)
    corners = board_corners(camera, right.whole.images, views)
    halves = split_half(camera, right.evaluation.images, right.views)
    found = set()
    if right.wrong:
        found.add("wrong corners")
    if not corners.as_stated:
        found.add("board")
    if not halves.stable:
        found.add("camera")
    if halves.outlier:
        found.add(halves.outlier.name)
    return found


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("fault", FAULTS)
def test_only_faults_are_reported(fault, seed):
    make, expected = FAULTS[fault]
    found = findings(make(40 + seed))
    if expected:
        assert expected <= found
    else:
        assert found == set()


def test_inconsistent_image_is_no_evidence_about_the_board():
    """Displaced corners would absorb a part of it, and hide it."""
    views = FAULTS["mirrored image"][0](41)
    task = Fitting(FITS, views, SIZE, "mm", BOARDS, lambda text: None)
    result, warnings, *_ = _calibrated("", task, "zhang", [])
    assert [(each.code, each.values["file"]) for each in warnings] == [
        ("outlier-image", "6.png")
    ]
    assert not result["board_corners"]["used"]
