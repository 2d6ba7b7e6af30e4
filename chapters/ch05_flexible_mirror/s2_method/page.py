# %% [markdown]
# # 5.2 SPFC2: calibrating a mirror from scene points, and again after it was bent
#
# **Question.** A mirror bends, and with it every ray of the camera. What has
# to be photographed once, what after every bending, and is a linear estimate
# that takes the scene to be infinitely far away near enough to start from?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s2_method.trials.pictures import platter_trial
from chapters.ch05_flexible_mirror.s2_method.trials.run import watched_trial
from chapters.ch05_flexible_mirror.s2_method.trials.starts import starts_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SEEDS = {"quick": 3, "full": 100}
FEWER = {"quick": 2, "full": 20}


# %%
@experiment(
    "exp_c5_linear_enough",
    artefact="sec_5_2_2",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def starts(effort, results):
    """Three starts on both benches."""
    return _plan(results, BENCHES, SEEDS[effort])


@experiment(
    "exp_c5_linear_enough_swept",
    artefact="sec_5_2_2",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def starts_swept(effort, results):
    """The same at half and twice each of the bench's numbers."""
    return _plan(results, SWEPT, FEWER[effort])


def _plan(results, benches, seeds):
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    trial = partial(starts_trial, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": "A"}], seeds, settings)


@experiment(
    "fig_5_3_platter",
    artefact="fig_5_3",
    inputs=(
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
    ),
)
def pictured(effort):
    """One picture of the platter."""
    return Plan(platter_trial, [{}], 1)


@experiment(
    "fig_5_4_run",
    artefact="fig_5_4",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def watched(effort, results):
    """One run, with the stages of the code counted."""
    errors = MirrorErrors.read(results["sec_5_3_3_errors"], "A")
    return Plan(partial(watched_trial, errors=errors), [{"seed": 0}], 1)
