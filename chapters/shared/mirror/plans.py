"""Plans of runs at the error levels of chapter 5, with errors from rendered images."""

from functools import partial

from chapters.shared.mirror.errors import MirrorErrors
from chapters.shared.mirror.levels import BENCHES, LEVEL, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from repro.run import Plan

# The first trial of what was run again under the tests of 2026: no earlier run of these
# experiments has drawn from here on.
UNSEEN = 1000


# A quick build runs the sweep at the primary level alone.
SWEEP = {"quick": dict.fromkeys(SWEPT, BENCHES[LEVEL]), "full": SWEPT}


def bench_plan(results, trial, benches, seeds, geometry="A"):
    """The Plan of a trial (condition, rng, errors, benches) of one geometry.

    results: with those of `sec_5_3_3_errors`; benches: {name: Bench}.
    """
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(
        partial(trial, errors=errors, benches=benches),
        [{"geometry": geometry}],
        seeds,
        settings,
        UNSEEN,
    )


def on_each(run):
    """The trial that gives each level's name its run (rig, level, errors, seed).

    A run draws the same random numbers at all levels. Equal levels are run once.
    """
    return partial(_on_each, run)


def _on_each(run, condition, rng, errors, benches):
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    found = {
        bench: run(rig, bench, of_rig.on(bench), seed)
        for bench in dict.fromkeys(benches.values())
    }
    return {name: found[bench] for name, bench in benches.items()}
