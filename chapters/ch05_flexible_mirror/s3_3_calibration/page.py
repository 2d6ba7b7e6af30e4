# %% [markdown]
# # 5.3.3 The full model: primary calibration, and the bench
#
# **Question.** Before a mirror is bent, its shape has to be known. How well is
# it found from two places of a monitor, and how much worse was the thesis's
# bench than a laboratory without dust, vibration and a wavy mirror?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_calibration.trials.bench import (
    AMPLITUDES_UM,
    FACTORS,
    SEEDS,
    bench_trial,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.trials.errors import (
    GEOMETRIES,
    RENDERED,
    SMALL,
    errors_trial,
)
from chapters.shared.mirror_errors import MirrorErrors
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed


# %%
@experiment(
    "sec_5_3_3_errors",
    artefact="sec_5_3_3",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
        "data/rigs/flexible-mirror-b-small.yaml",
        "data/rigs/flexible-mirror-b-monitor-small.yaml",
    ),
)
def picture_errors(effort):
    """Errors of corners and decoded points in rendered pictures."""
    conditions = crossed(geometry=GEOMETRIES, small=[SMALL[effort]])
    return Plan(errors_trial, conditions, RENDERED[effort], {})


@experiment(
    "bench_mirror",
    artefact="ext_mirror_bench",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    needs=("sec_5_3_3_errors",),
)
def bench(effort, results):
    """How factor and amplitude act on the two numbers that they are solved from."""
    errors = MirrorErrors.read(results["sec_5_3_3_errors"], "A")
    settings = {"factors": FACTORS, "amplitudes_um": AMPLITUDES_UM}
    return Plan(partial(bench_trial, errors=errors), [{}], SEEDS[effort], settings)
