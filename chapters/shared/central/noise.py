"""Decoding errors as large as those of the thesis's bench.

The laboratory decodes its monitors more cleanly than the bench of 4.2 and 4.3 did. Its
own error, decoded less true, is therefore multiplied by one factor, the same for every
camera, after decoding and before any calibration. The factor is solved from one printed
number by CGSP alone (`ext_bench_factor`) and stands in settings.yaml, decoding_noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raxel.features.active_grid import Decoded
from repro.run import SHARE_OF_SEEDS, Case, Reading, counterpart

# Solved by `ext_bench_factor`; their origin stands in settings.yaml, cam_d70_onevr.
FACTOR, WHITE_FACTOR = 5.26, 5.22
# Of the factor, over which a verdict must not change.
MULTIPLES = (0.5, 0.7, 1.0, 1.4, 2.0)


class DecodingNoise(NamedTuple):
    """What becomes of the laboratory's decoding errors.

    factor: they are multiplied by it; white: each has a sign drawn for it alone, so
    that errors are as large as they were in their place, and those of neighbours are
    not correlated. As they come, they are alike over the 7 x 7 pixels of the decoder's
    filter (3.2.2), and their bias repeats with the sines.
    """

    factor: float = 1.0
    white: bool = False

    def points(self, decoded, true, rng):
        """Points (..., 2) mm as they are decoded with these errors.

        decoded, true: (..., 2), NaN where there is none. A point whose truth is not
        known, beside the monitor, stays as it is.
        """
        if self == DecodingNoise():
            return decoded
        known = np.isfinite(decoded[..., 0]) & np.isfinite(true[..., 0])
        errors = decoded[known] - true[known]
        if self.white:
            errors = errors * rng.choice((-1.0, 1.0), errors.shape)
        out = decoded.copy()
        out[known] = true[known] + self.factor * errors
        return out

    def decoded(self, grid, rng) -> Decoded:
        """What is decoded of a `ScoredGrid` with these errors; sigma follows."""
        found = grid.decoded
        location = np.where(found.mask[..., None], found.location, np.nan)
        points = self.points(location, grid.points, rng)
        return replace(found, location=points, sigma=self.factor * found.sigma)


# What the trials call the options of the ledger's question `decoding_noise`.
OPTIONS = {"bench, 7 x 7": "bench", "bench, white": "white", "laboratory": "laboratory"}
BENCH = "bench"
NOISES = {
    "laboratory": DecodingNoise(),
    BENCH: DecodingNoise(FACTOR),
    "white": DecodingNoise(WHITE_FACTOR, white=True),
}
# The rest of the sweep from half to twice the factor: what trials call it, its noise.
SWEPT = {m: f"bench_x{m:g}".replace(".", "_") for m in MULTIPLES if m != 1.0}
SWEPT_NOISES = {name: DecodingNoise(m * FACTOR) for m, name in SWEPT.items()}


# Claims at the bench's noise: no verdict that the factor decides.


def over_the_sweep(case: Case, reading_at, side_at) -> Reading:
    """The Reading of a claim in one case, undecided where the factor decides it.

    reading_at(noise): the Reading at a decoding noise, by the name that trials have for
    it; side_at(noise): whether its point estimate is on the claim's side. The sweep is
    run in the primary case alone, so only that one is held against it.
    """
    reading = reading_at(case["decoding_noise"])
    if not case.is_primary:
        return reading
    side = side_at(BENCH)
    turned = [m for m, noise in SWEPT.items() if side_at(noise) != side]
    if not turned:
        return reading
    where = ", ".join(f"{m:g}" for m in turned)
    reason = f"{reading.reason}; the estimate changes side at {where} times the factor"
    return replace(reading, verdict="undecided", reason=reason)


def counterpart_over_the_sweep(case: Case, found_at) -> Reading:
    """As `over_the_sweep`, for a claim that is judged seed by seed.

    found_at(noise): whether it is true (seeds,), what was measured (seeds,), its unit
    and the reason, as `counterpart` takes them.
    """

    def most(noise):
        holds = found_at(noise)[0]
        return bool(np.mean(holds) >= SHARE_OF_SEEDS)

    return over_the_sweep(case, lambda noise: counterpart(*found_at(noise)), most)


def judged_by_seed(case_of):
    """Decorate a predicate of the seeds of a reading as the test of a claim.

    case_of(results, options[, noise]): the `Case` that the predicate takes; the bench's
    noise if none is given. The predicate returns what `counterpart` takes.
    """

    def decorate(predicate):
        def judge(results, options):
            return counterpart_over_the_sweep(
                case_of(results, options),
                lambda noise: predicate(case_of(results, options, noise)),
            )

        return judge

    return decorate
