# %% [markdown]
# # 5.3.3 There and back: does the error grow?
#
# **Question.** A calibration that is updated from the one before it may carry
# its errors on. A mirror is pushed three times by 5 mm and let back, and once
# by 15 mm at a stroke. Does the camera come back to where it was?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.placements import (
    placements_trial,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import repeated_trial
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.starts import starts_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SEEDS = {"quick": 3, "full": 100}
FEWER = {"quick": 2, "full": 20}
PLACED = {"quick": 2, "full": 15}
STARTED = {"quick": 2, "full": 12}


# %%
@experiment(
    "table_5_5_runs",
    artefact="table_5_5",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches."""
    return _plan(results, repeated_trial, "A", BENCHES, SEEDS[effort])


@experiment(
    "table_5_5_swept",
    artefact="table_5_5",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers."""
    return _plan(results, repeated_trial, "A", SWEPT, FEWER[effort])


@experiment(
    "table_5_5_other",
    artefact="table_5_5",
    inputs=(
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    return _plan(results, repeated_trial, "B", BENCHES, FEWER[effort])


@experiment(
    "exp_c5_dense_grid",
    artefact="table_5_5",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def placed(effort, results):
    """The first step, with the board elsewhere and all else the same."""
    return _plan(results, placements_trial, "A", BENCHES | SWEPT, PLACED[effort])


@experiment(
    "exp_c5_not_sensitive_init",
    artefact="table_5_5",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def started(effort, results):
    """Steps of 5 and of 15 mm, refined from perturbed starts."""
    return _plan(results, starts_trial, "A", BENCHES | SWEPT, STARTED[effort])


def _plan(results, run, geometry, benches, seeds):
    """The Plan of a trial of one geometry, with what pictures have shown."""
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(run, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)
