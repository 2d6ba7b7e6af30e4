"""Claims of 5.3 about the thesis's flexible mirror: no verdict that the bench decides.

The two numbers of `mirror_bench` are known about as well as the printed ones that they
are solved from. A verdict whose point estimate is on the other side of its bound at
half or twice one of them is left open.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chapters.shared.mirror_bench import BENCH, SWEPT
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.run.outcomes import Reading
from repro.run.readings import Case, counterpart

# What the trials call the options of the ledger's question `mirror_bench`.
READINGS = {"mirror_bench": {BENCH: BENCH, "laboratory": "laboratory"}}


class BenchRuns(Case):
    """Every seed on one bench: the one of the reading, or an end of a sweep.

    EXPERIMENTS: those of a kind of run, on geometry A, on A from half to twice the
    bench's numbers, and on B if it was run there. Where a seed was refused, it has no
    values from there on: nan.
    """

    EXPERIMENTS: tuple[str, ...]

    def __init__(self, results, options=None, bench=None, geometry="A"):
        super().__init__(READINGS, options)
        runs, swept, *other = self.EXPERIMENTS
        self.bench = bench or self["mirror_bench"]
        name = swept if self.bench in SWEPT else runs
        self.result = results[name if geometry == "A" else other[0]]

    @property
    def seeds(self):
        """How many were run."""
        return self.result.trials_per_condition

    @classmethod
    def judged_by_seed(cls, results, options, predicate) -> Reading:
        """The Reading of a predicate of such runs, over the sweeps of the bench."""
        return counterpart_over_the_sweep(
            Case(READINGS, options),
            lambda bench: predicate(cls(results, options, bench)),
        )


def over_the_sweep(case: Case, reading_at, side_at) -> Reading:
    """The Reading of a claim in one case, undecided where the bench's numbers do.

    reading_at(bench): the Reading on a bench, by the name that trials have for it;
    side_at(bench): whether its point estimate is on the claim's side. What is swept is
    the primary case alone, so only that one is held against it.
    """
    reading = reading_at(case["mirror_bench"])
    if not case.is_primary:
        return reading
    side = side_at(BENCH)
    turned = [name for name in SWEPT if side_at(name) != side]
    if not turned:
        return reading
    reason = f"{reading.reason}; the estimate changes side at {', '.join(turned)}"
    return replace(reading, verdict="undecided", reason=reason)


def counterpart_over_the_sweep(case: Case, found_at) -> Reading:
    """As `over_the_sweep`, for a claim that is judged seed by seed.

    found_at(bench): whether it is true (seeds,), what was measured (seeds,), its unit
    and the reason, as `counterpart` takes them.
    """

    def most(bench):
        return bool(np.mean(found_at(bench)[0]) >= SHARE_OF_SEEDS)

    return over_the_sweep(case, lambda bench: counterpart(*found_at(bench)), most)
