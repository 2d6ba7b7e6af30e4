# %% [markdown]
# # Why it fails
#
# **Question.** CELECT goes along an edge from window to window, collects
# corners on the way, and merges them. When a board is lost, which of these
# steps lost it? And does each condition of 3.1.2 matter as the thesis says?

# %% tags=["hide-cell"]
from chapters.ch03_planar_grids.ordering_trials import (
    bends,
    ordering_trial,
)
from chapters.ch03_planar_grids.robustness_trials import DEFAULTS
from chapters.ch03_planar_grids.why_cases import (
    CORNER_SD_PX,
    SWEEP_LEVELS,
    SWEEP_QUICK,
    VARIATION,
    levels_of,
)
from chapters.ch03_planar_grids.why_trials import sweep_trial, why_trial
from repro.experiment import experiment
from repro.outcomes import Plan

# %% [markdown]
# ## Experiment

# %%
TRIALS = {"quick": 1, "full": 20}
SWEEP_TRIALS = {"quick": 1, "full": 6}


def plan_of(case, effort):
    """The plan of one case: all its levels in one trial."""
    condition = {"case": case, "levels": levels_of(case, effort)}
    return Plan(why_trial, [condition], TRIALS[effort], VARIATION)


@experiment(
    "ext_why_clearance",
    artefact="ext_why_clearance",
    shards={"quick": 1, "full": 1},
)
def clearance(effort):
    """How far the sheet goes on beyond the outermost corners."""
    return plan_of("clearance", effort)


@experiment(
    "ext_why_first_corner",
    artefact="ext_why_first_corner",
    shards={"quick": 1, "full": 1},
)
def first_corner(effort):
    """The right contour of the first corner comes within t4 of L4."""
    return plan_of("first_corner", effort)


@experiment(
    "ext_why_wrong_contour",
    artefact="ext_why_wrong_contour",
    shards={"quick": 1, "full": 1},
)
def wrong_contour(effort):
    """The wrong contour of the first corner leaves t4 of L4, closer to L1."""
    return plan_of("wrong_contour", effort)


@experiment(
    "ext_why_direction",
    artefact="ext_why_direction",
    shards={"quick": 1, "full": 1},
)
def direction(effort):
    """Eight ways to click one picture."""
    return plan_of("direction", effort)


@experiment(
    "ext_why_split_peaks",
    artefact="ext_why_split_peaks",
    shards={"quick": 1, "full": 1},
)
def split_peaks(effort):
    """The same board in smaller pictures: a contour becomes two Hough peaks."""
    return plan_of("split_peaks", effort)


@experiment(
    "ext_why_window",
    artefact="ext_why_window",
    shards={"quick": 1, "full": 1},
)
def window(effort):
    """The window's radius, times a factor."""
    return plan_of("window", effort)


@experiment(
    "ext_why_curvature",
    artefact="ext_why_curvature",
    shards={"quick": 1, "full": 1},
)
def curvature(effort):
    """The same bend with fewer and larger squares."""
    return plan_of("curvature", effort)


@experiment(
    "ext_why_size_variation",
    artefact="ext_why_size_variation",
    shards={"quick": 1, "full": 1},
)
def size_variation(effort):
    """Squares that grow along a contour."""
    return plan_of("size_variation", effort)


@experiment(
    "ext_why_blur_noise",
    artefact="ext_why_blur_noise",
    shards={"quick": 1, "full": 1},
)
def blur_noise(effort):
    """Blur, and noise."""
    return plan_of("blur_noise", effort)


@experiment(
    "ext_why_sweeps",
    artefact="ext_why_sweeps",
    shards={"quick": 1, "full": 2},
)
def sweeps(effort):
    """The levels of Fig. 3.11 at which trials are lost."""
    levels = SWEEP_QUICK if effort == "quick" else SWEEP_LEVELS
    conditions = [DEFAULTS | level for level in levels]
    return Plan(sweep_trial, conditions, SWEEP_TRIALS[effort])


@experiment(
    "ext_why_orderings",
    artefact="ext_why_orderings",
    shards={"quick": 1, "full": 1},
)
def orderings(effort):
    """The two orderings of 1.2.1 on corners of boards that bend more and more."""
    settings = {"corner_sd_px": CORNER_SD_PX}
    trials = TRIALS[effort]
    return Plan(ordering_trial, bends(effort), trials, settings)
