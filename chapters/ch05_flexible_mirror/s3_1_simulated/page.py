# %% [markdown]
# # 5.3.1 Simulated experiments with the reduced model

# %%
from chapters.ch05_flexible_mirror.s3_1_simulated.results import name_values
from chapters.ch05_flexible_mirror.s3_1_simulated.trials.sweeps import (
    BASE,
    SETTINGS,
    TRIALS,
    conditions,
    draw,
    drawn_example,
    each_level,
)
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
def trial(condition, rng):
    """One draw of grid and noise, calibrated at every level of a sweep."""
    return each_level(condition, draw(condition, rng))


@experiment("fig_5_5_sweeps", artefact="fig_5_5", shards={"full": 2})
def sweeps(effort):
    """Fig. 5.5: noise, depth and curvature, in every set-up that is a reading."""
    return Plan(trial, conditions(), TRIALS[effort], SETTINGS)


@experiment("fig_5_5_example", artefact="ext_fig_5_5_scene")
def example(effort):
    """One trial at the default levels, with the arrays that a drawing needs."""
    return Plan(drawn_example, [BASE], 1, SETTINGS)
