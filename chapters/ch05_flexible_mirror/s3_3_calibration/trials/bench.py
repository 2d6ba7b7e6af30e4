"""What decoding errors and an uneven mirror do to what levels are solved from.

Geometry A, the method as published. From this the two solved error levels have their
factors and amplitudes, with the two printed numbers that each may see (settings.yaml,
mirror_bench). Nothing is judged here.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_bench import BENCHES, FIRST, SECOND
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    PUBLISHED,
    deflected,
    measured_rays,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import back_projection, lengths
from raxel.errors import CalibrationError

SEEDS = {"quick": 1, "full": 36}
# Of each level: what is swept, with the other number as it is.
FACTORS = {FIRST: (1.0, 4.0, 8.0, 12.0, 16.0), SECOND: (1.0, 2.0, 3.0, 4.0, 5.0)}
AMPLITUDES_UM = {
    FIRST: (0.0, 10.0, 20.0, 30.0, 45.0, 60.0),
    SECOND: (0.0, 5.0, 10.0, 15.0, 20.0),
}


class WithoutPlatter(MirrorErrors):
    """Errors as the first level was solved with: none of the platter is drawn."""

    def mounted(self, platter, rng, positions):
        """The `Platter` at each of the monitor's positions, as given by its board."""
        return [platter] * positions


def first_trial(condition, rng, errors):
    """miss_mm: mean distance of mirror points from their rays, for each of FACTORS on a
    smooth mirror, and with the factor chosen; residual_mm: mean residual of stage 1 for
    each of AMPLITUDES_UM with the factor chosen, and with both numbers chosen; NaN
    where a stage is rejected."""
    seed, level = int(rng.integers(2**32)), BENCHES[FIRST]
    errors = WithoutPlatter(*errors)

    def miss(factor):
        found = _primary(level._replace(factor=factor, aberration_um=0), errors, seed)
        return float(np.nanmean(found.first.calibration.mirror.misses))

    def residual(amplitude_um):
        found = _primary(level._replace(aberration_um=amplitude_um), errors, seed)
        rig, drawn, these = found.rig, found.drawn, found.errors
        bent = rig.camera(STAGES_MM[1], amplitude_um, seed)
        T = rig.board_pose(drawn, deflections=STAGES_MM[:2])
        pictures = [seen_board(rig, c, T, these, drawn) for c in (found.flat, bent)]
        points, first = rig.board.points(), found.first
        try:
            stage = deflected(
                first.camera, bent, pictures, points, first.clamp, PUBLISHED
            )
        except CalibrationError:
            return np.nan
        return float(np.nanmean(stage.residuals))

    return {
        "miss_mm": np.array([miss(factor) for factor in FACTORS[FIRST]]),
        "chosen_miss_mm": miss(level.factor),
        "residual_mm": np.array([residual(um) for um in AMPLITUDES_UM[FIRST]]),
        "chosen_residual_mm": residual(level.aberration_um),
    }


def second_trial(condition, rng, errors):
    """angle_deg: mean angle to the rays that the primary's own grids give, for each of
    FACTORS; back_mm: mean back-projection error at stage 0, for each of AMPLITUDES_UM;
    the other number as chosen, and both with both chosen."""
    seed, level = int(rng.integers(2**32)), BENCHES[SECOND]

    def by(factor):
        return stage_0(level._replace(factor=factor), errors, seed)[0]

    def of(amplitude_um):
        return stage_0(level._replace(aberration_um=amplitude_um), errors, seed)[1]

    angle, back = stage_0(level, errors, seed)
    return {
        "angle_deg": np.array([by(factor) for factor in FACTORS[SECOND]]),
        "chosen_angle_deg": angle,
        "back_mm": np.array([of(um) for um in AMPLITUDES_UM[SECOND]]),
        "chosen_back_mm": back,
    }


def stage_0(level, errors, seed):
    """Mean angle to the rays of the primary's own grids, degrees, and mean
    back-projection error in the pose that is found, mm, at an error level."""
    found = _primary(level, errors, seed)
    rig, first, drawn = found.rig, found.first, found.drawn
    camera, given = first.camera, (found.errors, drawn)
    own = measured_rays(rig, found.flat, camera.viewer, *given, first)
    T = rig.board_pose(drawn, BACK_PROJECTION_MM, STAGES_MM[:1])
    pixels = seen_board(rig, found.flat, T, *given)
    back = lengths(back_projection(camera, pixels, rig.board.points())).mean()
    return own.against(camera)["measured_deg"], float(back)


def solved(values, levels, target):
    """The level at which the median over runs of values (seeds, levels) is the target,
    interpolated linearly between levels; None where no level reaches it."""
    medians = np.nanmedian(values, axis=0)
    if not medians[0] <= target <= medians[-1]:
        return None
    return float(np.interp(target, medians, levels))


class _Started(NamedTuple):
    """A MirrorRig, its true camera at stage 0, the Primary found of it, and the errors
    and the generator that go on from there."""

    rig: object
    flat: object
    first: object
    errors: object
    drawn: object


def _primary(level, errors, seed):
    rig, drawn, these = mirror_rig("A"), np.random.default_rng(seed), errors.on(level)
    flat = rig.camera(STAGES_MM[0], level.aberration_um, seed)
    first = primary(rig, flat, PUBLISHED, these, drawn)
    return _Started(rig, flat, first, these, drawn)
