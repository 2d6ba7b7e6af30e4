# %% [markdown]
# # 5.3.5 Motion and shape from a bent mirror

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_5_motion.trials.pictures import pictures_trial
from chapters.ch05_flexible_mirror.s3_5_motion.trials.run import SETTINGS, motion_trial
from chapters.shared.mirror_bench import BENCH, BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %%
SEEDS = {"quick": 1, "full": 20}
FEWER = {"quick": 1, "full": 10}
PICTURES = {"quick": 1, "full": 3}


@experiment(
    "table_5_7_runs",
    artefact="table_5_7",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches, with all cameras."""
    return _plan(results, "A", _first(BENCH, effort), SEEDS[effort])


@experiment(
    "table_5_7_swept",
    artefact="table_5_7",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers, as published."""
    benches = _first("half the factor", effort)
    return _plan(results, "A", benches, FEWER[effort], whole=False)


@experiment(
    "table_5_7_other",
    artefact="table_5_7",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches, as published."""
    return _plan(results, "B", BENCHES, FEWER[effort], whole=False)


def _first(name, effort):
    """All benches of a kind, at quick the one of a name."""
    every = SWEPT if name in SWEPT else BENCHES
    return every if effort == "full" else {name: every[name]}


def _plan(results, geometry, benches, seeds, whole=True):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(motion_trial, errors=errors, benches=benches, whole=whole)
    settings = SETTINGS | {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)


# %%
@experiment(
    "fig_5_21_pictures",
    artefact="fig_5_21",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def pictures(effort, results):
    """Six rendered pictures of the cylinder, its marks found, on both benches."""
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    benches = _first(BENCH, effort)
    trial = partial(pictures_trial, errors=errors, benches=benches)
    return Plan(trial, [{"geometry": "A"}], PICTURES[effort], SETTINGS)
