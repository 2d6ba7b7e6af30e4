# %% [markdown]
# # 3.1.3 Localisation
#
# **Question.** A corner that is known to a pixel or two has to be found to
# a few hundredths. How large a window, and how much blur, does that take,
# and does it depend on how close the next corner is?

# %% tags=["hide-cell"]
from chapters.ch03_planar_grids.localisation_trials import (
    BLUR_PX,
    NOISE_SD,
    SQUARES_PX,
    START_SD_PX,
    derivative_trial,
    saddle_trial,
    spread_trial,
)
from chapters.ch03_planar_grids.synthetic_board import SIZE_PX
from raxel.features.localise import (
    corner_subpix,
    derivative,
    saddle_point,
)
from repro.experiment import experiment
from repro.outcomes import Plan

# %% [markdown]
# ## Experiment

# %%
IMAGES = {"quick": 1, "full": 4}
WINDOWS = {
    "quick": list(range(5, 34, 14)),
    "full": list(range(5, 62, 2)),
}
BLURS = {
    "quick": [0.5, 4.25, 8.0],
    "full": [0.5 + 0.75 * k for k in range(11)],
}
SETTINGS = {
    "image_px": SIZE_PX,
    "squares_px": list(SQUARES_PX),
    "blur_px": BLUR_PX,
    "noise_sd": NOISE_SD,
    "start_sd_px": START_SD_PX,
    "fov_deg": 134,
}


# %%
@experiment(
    "fig_3_5_derivative", artefact="fig_3_5", shards={"quick": 1, "full": 4}
)
def derivative_sweep(effort):
    """The derivative method with every window, on boards of four scales."""
    conditions = [
        {"square_px": square, "windows": WINDOWS[effort]}
        for square in SQUARES_PX
    ]
    return Plan(derivative_trial, conditions, IMAGES[effort], SETTINGS)


@experiment(
    "fig_3_5_saddle", artefact="fig_3_5", shards={"quick": 1, "full": 1}
)
def saddle_sweep(effort):
    """The saddle point method with every window and blur."""
    conditions = [
        {
            "square_px": square,
            "windows": WINDOWS[effort],
            "blurs": BLURS[effort],
        }
        for square in SQUARES_PX
    ]
    return Plan(saddle_trial, conditions, IMAGES[effort], SETTINGS)


@experiment(
    "ext_localiser_spread",
    artefact="ext_localisers",
    shards={"quick": 1, "full": 1},
)
def spreads(effort):
    """Errors of three localisers beside the SD that they state."""
    conditions = [{"square_px": square} for square in SQUARES_PX]
    return Plan(spread_trial, conditions, IMAGES[effort], SETTINGS)
