# %% [markdown]
# # 5.3.5 Motion and shape from a bent mirror

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_5_motion.trials.run import motion_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %%
SEEDS = {"quick": 1, "full": 20}
FEWER = {"quick": 1, "full": 5}


@experiment(
    "table_5_7_runs",
    artefact="table_5_7",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches, with all cameras."""
    return _plan(results, "A", BENCHES, SEEDS[effort])


@experiment(
    "table_5_7_swept",
    artefact="table_5_7",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers, as published."""
    return _plan(results, "A", SWEPT, FEWER[effort], whole=False)


@experiment(
    "table_5_7_other",
    artefact="table_5_7",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches, as published."""
    return _plan(results, "B", BENCHES, FEWER[effort], whole=False)


def _plan(results, geometry, benches, seeds, whole=True):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(motion_trial, errors=errors, benches=benches, whole=whole)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)
