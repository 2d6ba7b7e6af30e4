# %% [markdown]
# # How many knots does a mirror need?
#
# **Question.** A spline with few knots cannot follow a mirror's relief, one
# with many is guessed where no corner lies. Can the residuals say when there
# are enough?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.ext_orders.trials.knots import (
    CORNER_PX,
    STEPS_MM,
    knots_trial,
)
from chapters.ch05_flexible_mirror.ext_orders.trials.relief import (
    RELIEFS_UM,
    relief_trial,
)
from chapters.shared.mirror_errors import MirrorErrors
from repro.page.reader import compared, show
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_knot_tradeoff")

# %% [markdown]
# ## What the thesis claims
#
# ## Model
#
# ## Experiment

# %%
RIG = ("data/rigs/flexible-mirror-a.yaml", "data/rigs/flexible-mirror-a-monitor.yaml")
GEOMETRY = {"geometry": "A"}


@experiment(
    "exp_c5_knot_tradeoff",
    artefact="sec_5_2_2",
    inputs=RIG,
    needs=("sec_5_3_3_errors",),
)
def knots(effort, results):
    """Steps of several sizes with several numbers of knots."""
    settings = {"steps_mm": list(STEPS_MM), "corner_px": CORNER_PX}
    seeds = {"quick": 1, "full": 16}[effort]
    return Plan(_on_errors(knots_trial, results), [GEOMETRY], seeds, settings)


@experiment(
    "exp_c5_high_order", artefact="fig_5_13", inputs=RIG, needs=("sec_5_3_3_errors",)
)
def relief(effort, results):
    """Stage 0 before a smooth mirror and before one with relief."""
    settings = {"reliefs_um": RELIEFS_UM}
    seeds = {"quick": 1, "full": 16}[effort]
    return Plan(_on_errors(relief_trial, results), [GEOMETRY], seeds, settings)


def _on_errors(trial, results):
    """The trial, with the errors of rendered pictures."""
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    return partial(trial, errors=errors)


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show("ext_high_order")

# %% [markdown]
# ## Reading and limits
#
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
