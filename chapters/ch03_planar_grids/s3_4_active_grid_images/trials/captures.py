"""Rendered sets of section 3.3.4, opened and decoded like recorded ones."""

import numpy as np

from raxel.features.active_grid import decode
from raxel.lab import load_rig
from raxel.sets import load_set, read_image
from repro.run.rendered import CHECKOUT, rendered_set


def rig_of(name):
    """Return the rig of a file of data/rigs."""
    return load_rig(CHECKOUT / f"data/rigs/{name}.yaml")


def capture_of(rig, seed, pose=0):
    """Return (set, view) of one pose of a rendered set."""
    image_set = load_set(rendered_set(rig, seed))
    return image_set, image_set.views[pose]


def pictures_of(image_set, view):
    """Return patterns (n, H, W), and white, black and chessboard by name."""
    patterns = np.array(
        [read_image(image_set, pattern.image) for pattern in view.patterns]
    )
    others = {
        name: read_image(image_set, getattr(view, name))
        for name in ("white", "black", "chessboard")
        if getattr(view, name)
    }
    return patterns, others


def decoded(image_set, view, prepare=lambda picture: picture, **options):
    """Return (Decoded, chessboard or None) of a view.

    prepare: applied to every image first; options: of `decode`.
    """
    patterns, others = pictures_of(image_set, view)
    others = {name: prepare(picture) for name, picture in others.items()}
    chessboard = others.pop("chessboard", None)
    found = decode(
        np.array([prepare(picture) for picture in patterns]),
        view.patterns,
        image_set.target,
        linear=True,
        **others,
        **options,
    )
    return found, chessboard
