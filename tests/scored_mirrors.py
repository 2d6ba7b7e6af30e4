"""A mirror set whose pictures show nothing, with the truth of a mirror that bends.

What scores results opens the truth alone, so that nothing need be rendered.
"""

import numpy as np

from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera
from raxel.evaluation.mirror_benchmark import scored_pixels
from raxel.evaluation.mirror_result import sampled_result
from raxel.sets import load_mirror_set
from tests.image_sets import HEIGHT, WIDTH
from tests.mirror_sets import write_mirror_set

# Deflections of the two loads at each stage of `mirror_sets.mirror_description`, mm.
LOADS = (80.0, 150.0)
STAGES = ((0.0, 0.0), (3.0, 5.0), (3.0, 10.0))


def true_mirror(deflections):
    """Geometry A of chapter 5 in a picture of 320 x 240 px."""
    K = [[790, 0, 160.3], [0, 790, 118.6], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [-0.11], WIDTH, HEIGHT)
    return FlexibleMirrorCamera(
        viewer,
        size=(160, 100),
        loads=LOADS,
        deflections=deflections,
        rulings=np.radians(1),
        aberration=0.02,
        offset=(66, 0, 370),
        rotation=np.radians([-46.29, -0.48, -172.75]),
    )


def write_scored_set(folder):
    """The MirrorSet in `folder`, written there with its truth."""
    write_mirror_set(folder)
    (folder / "truth").mkdir()
    for k, deflections in enumerate(STAGES):
        true_mirror(deflections).save(folder / "truth" / f"stage-{k}.npz")
    return load_mirror_set(folder)


def true_result(mirror_set):
    """The MirrorResult that says what is true."""
    cameras = [true_mirror(deflections) for deflections in STAGES]
    pixels = scored_pixels(mirror_set.size)
    return sampled_result(mirror_set, cameras, pixels, 1.5, "the truth")
