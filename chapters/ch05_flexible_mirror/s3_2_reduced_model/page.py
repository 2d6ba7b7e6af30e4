# %% [markdown]
# # 5.3.2 Real experiments with the reduced model
#
# **Question.** A mirror of inexpensive plastic is bent by some 8 mm. A curve
# with four coefficients is to follow it, found from one board seen before and
# after. How near does it come to what a laser scanner finds, and what keeps it
# from coming nearer: the last step, or the first?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials import picture, run
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SEEDS = {"quick": 3, "full": 100}
FEWER = {"quick": 2, "full": 20}


# %%
@experiment(
    "fig_5_7_runs",
    artefact="fig_5_7",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A on both benches, calibrated in every way that is a reading."""
    return _plan(results, "A", BENCHES, SEEDS[effort], run.OTHER_WAYS)


@experiment(
    "fig_5_7_swept",
    artefact="fig_5_7",
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
    "fig_5_7_other",
    artefact="fig_5_7",
    inputs=(
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    return _plan(results, "B", BENCHES, FEWER[effort])


def _plan(results, geometry, benches, seeds, ways=()):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(run.reduced_trial, errors=errors, benches=benches, ways=ways)
    settings = run.SETTINGS | {name: b._asdict() for name, b in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)


@experiment(
    "fig_5_7_curves",
    artefact="fig_5_7",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def curves(effort, results):
    """The curves of one seed on the bench, for a drawing."""
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    trial = partial(run.curves_trial, errors=errors)
    return Plan(trial, [{"geometry": "A"}], 1, run.SETTINGS)


@experiment(
    "fig_5_6_pictures",
    artefact="fig_5_6",
    inputs=(
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
    ),
)
def pictures(effort):
    """Fig. 5.6: a chessboard 5 m away, in an even mirror and in an uneven one."""
    return Plan(picture.picture_trial, [{"geometry": "A"}], 1, picture.SETTINGS)
