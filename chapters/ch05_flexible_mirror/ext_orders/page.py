# %% [markdown]
# # How many knots does a mirror need?
#
# **Question.** A spline with few knots cannot follow a mirror's relief, one
# with many is guessed where no corner lies. Can the residuals say when there
# are enough?

# %%
from functools import partial

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.trials.knots import STEPS_MM, knots_trial
from chapters.ch05_flexible_mirror.ext_orders.trials.orders import (
    CORNER_PX,
    DECODED_MM,
    KEPT_OUT,
    MOST,
    orders_trial,
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


@experiment(
    "ext_orders_runs",
    artefact="ext_orders",
    shards={"full": 2},
    inputs=RIG,
    needs=("sec_5_3_3_errors",),
)
def orders(effort, results):
    """Orders raised step by step, beyond where residuals are white."""
    least = {"quick": 16, "full": np.inf}[effort]
    conditions = [
        GEOMETRY | {"case": case, "most": min(most, least)}
        for case, most in MOST.items()
    ]
    settings = {"corner_px": CORNER_PX, "decoded_mm": DECODED_MM, "kept_out": KEPT_OUT}
    seeds = {"quick": 1, "full": 4}[effort]
    return Plan(_on_errors(orders_trial, results), conditions, seeds, settings)


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
