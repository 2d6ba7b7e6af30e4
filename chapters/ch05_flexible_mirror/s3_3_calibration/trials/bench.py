"""What decoding errors and an uneven mirror do to the two numbers of the bench.

Geometry A, the method as published. From this the bench's factor and amplitude are
solved, with the two printed numbers that they may see (settings.yaml, mirror_bench).
Nothing is judged here.
"""

import numpy as np

from chapters.shared.mirror_bench import ABERRATION_UM, FACTOR
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.errors import CalibrationError

SEEDS = {"quick": 1, "full": 36}
FACTORS = (1.0, 4.0, 8.0, 12.0, 16.0)
AMPLITUDES_UM = (0.0, 10.0, 20.0, 30.0, 45.0, 60.0)


def bench_trial(condition, rng, errors):
    """miss_mm: mean distance of mirror points from their rays, for each of FACTORS on a
    smooth mirror, and with the factor chosen; residual_mm: mean residual of stage 1 for
    each of AMPLITUDES_UM with the factor chosen, and with both numbers chosen; NaN
    where a stage is refused."""
    rig, seed = mirror_rig("A"), int(rng.integers(2**32))

    def first(factor, amplitude_um):
        drawn = np.random.default_rng(seed)
        flat = rig.camera(STAGES_MM[0], amplitude_um, seed)
        these = errors._replace(factor=factor)
        return primary(rig, flat, PUBLISHED, these, drawn), flat, these, drawn

    def miss(factor):
        found = first(factor, 0.0)[0]
        return float(np.nanmean(found.calibration.mirror.misses))

    def residual(amplitude_um):
        found, flat, these, drawn = first(FACTOR, amplitude_um)
        bent = rig.camera(STAGES_MM[1], amplitude_um, seed)
        T = rig.board_pose(drawn, deflections=STAGES_MM[:2])
        pictures = [seen_board(rig, c, T, these, drawn) for c in (flat, bent)]
        points = rig.board.points()
        try:
            stage = deflected(
                found.camera, bent, pictures, points, found.clamp, PUBLISHED
            )
        except CalibrationError:
            return np.nan
        return float(np.nanmean(stage.residuals))

    return {
        "miss_mm": np.array([miss(factor) for factor in FACTORS]),
        "chosen_miss_mm": miss(FACTOR),
        "residual_mm": np.array([residual(um) for um in AMPLITUDES_UM]),
        "chosen_residual_mm": residual(ABERRATION_UM),
    }


def solved(values, levels, target):
    """The level at which the median over seeds of values (seeds, levels) is the target,
    between levels in a straight line; None where no level reaches it."""
    medians = np.nanmedian(values, axis=0)
    if not medians[0] <= target <= medians[-1]:
        return None
    return float(np.interp(target, medians, levels))
