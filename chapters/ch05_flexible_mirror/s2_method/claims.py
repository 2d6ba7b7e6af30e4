"""The claim of section 5.2.2 that hangs on a run."""

import numpy as np

from chapters.ch05_flexible_mirror.s2_method.results import BOTH, SAME, Starts
from chapters.shared.mirror_sweep import READINGS, over_the_sweep
from repro.judge.statistics import proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import Case

LEAST_SHARE = 0.95


@claim("c5_linear_enough", needs=BOTH, evidence="rendered", readings=("mirror_bench",))
def judge_linear_enough(results, options):
    """Cost and deflection from the linear estimate and from the true surface."""

    def reading_at(bench):
        starts = Starts.on(results, bench)
        share = proportion(starts.same().astype(float))
        return Reading.of(
            share.above(np.nextafter(LEAST_SHARE, 0)),
            share.times(100),
            "%",
            f"of {len(starts.same())} deflections with cost and deflection of the tip "
            f"within {100 * SAME:g} % of those from the true surface; largest "
            f"difference {starts.most_off('linear', 'cost_mm2'):.2g} % of the cost, "
            f"{starts.most_off('linear', 'deflection_mm'):.2g} % of the deflection; "
            f"{starts.refused} refused",
        )

    def side_at(bench):
        return bool(np.mean(Starts.on(results, bench).same()) >= LEAST_SHARE)

    return over_the_sweep(Case(READINGS, options), reading_at, side_at)
