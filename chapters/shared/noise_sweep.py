"""Claims at the bench's noise: no verdict that the factor decides.

The factor of `bench_noise` is known about as well as the printed number that it is
solved from. A verdict whose point estimate is on the other side of its bound somewhere
between half and twice the factor is left open.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chapters.shared.bench_noise import BENCH, SWEPT
from repro.run import SHARE_OF_SEEDS, Case, Reading, counterpart


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
