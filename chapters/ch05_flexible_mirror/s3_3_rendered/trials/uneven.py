"""A mirror that is uneven by 10 µm, calibrated from pictures as aimed at.

The targets have rows for it. Decoding errors are those of the laboratory.
"""

from chapters.ch05_flexible_mirror.s3_3_rendered.trials.pictures import (
    drawn_scene,
    read_pictures,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.trials.run import (
    by_stages,
    scoring_boards,
)
from chapters.shared.mirror_bench import Bench
from chapters.shared.mirror_bundle import AIMED
from chapters.shared.mirror_rigs import mirror_rig
from raxel.errors import InputError

UNEVEN = Bench(aberration_um=10.0)


def uneven_trial(condition, rng, sizes):
    """Every measure of the stages; `refused` or `aimed.refused` says where a run ended,
    if early.

    sizes: RunSizes.
    """
    rig = mirror_rig(condition["geometry"], small=sizes.small)
    scene = drawn_scene(rig, UNEVEN, sizes.steps, rng)
    try:
        read = read_pictures(scene, sizes, rng)
    except InputError as refusal:
        return {"refused": str(refusal)}
    held_out = scoring_boards(scene, rng)
    return {"aimed": by_stages(scene, read, held_out, AIMED)}
