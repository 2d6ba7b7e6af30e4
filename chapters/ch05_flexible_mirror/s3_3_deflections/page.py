# %% [markdown]
# # 5.3.3 Three deflections: is the mirror found where it went?
#
# **Question.** A mirror is pushed three times by 5 mm, and calibrated after
# each push from two pictures of a chessboard. How far does the calibration say
# that it went, and how far are the camera's rays off after that?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_deflections.trials.run import deflections_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SEEDS = {"quick": 3, "full": 100}
FEWER = {"quick": 2, "full": 20}


# %%
@experiment(
    "table_5_1_runs",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches."""
    return _plan(results, "A", BENCHES, SEEDS[effort])


@experiment(
    "table_5_1_swept",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers."""
    return _plan(results, "A", SWEPT, FEWER[effort])


@experiment(
    "table_5_1_other",
    artefact="table_5_1",
    inputs=(
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    return _plan(results, "B", BENCHES, FEWER[effort])


def _plan(results, geometry, benches, seeds):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(deflections_trial, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)
