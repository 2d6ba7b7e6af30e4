# %% [markdown]
# # 5.4 Self-calibration: can the target be left out?
#
# **Question.** A mirror is bent before a scene that nobody measured. Can the camera be
# calibrated from the pictures before and after alone, and can a scene be told in three
# dimensions by bending the mirror?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import course_trial
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.known import known_trial
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.ways import ways_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

SEEDS = {"quick": 1, "full": 20}
FEWER = {"quick": 1, "full": 4}


@experiment(
    "table_5_9_runs",
    artefact="table_5_9",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches."""
    return _plan(results, "A", BENCHES, SEEDS[effort])


@experiment(
    "table_5_9_swept",
    artefact="table_5_9",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers."""
    return _plan(results, "A", SWEPT, FEWER[effort])


@experiment(
    "table_5_9_other",
    artefact="table_5_9",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    return _plan(results, "B", BENCHES, FEWER[effort])


def _plan(results, geometry, benches, seeds):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(course_trial, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)


@experiment("ext_self_ways_runs", artefact="ext_self_ways", inputs=GEOMETRY_A)
def ways(effort):
    """One step without a target, by every way, before two scenes."""
    conditions = crossed(geometry=["A"], depth_mm=[0.0, 800.0])
    return Plan(ways_trial, conditions, SEEDS[effort])


@experiment("exp_c5_known_scene", artefact="sec_5_5", inputs=GEOMETRY_A)
def known(effort):
    """Eight steps before a scene that is known, and before boards."""
    return Plan(known_trial, [{"geometry": "A"}], 2 * SEEDS[effort])
