# %% [markdown]
# # {glue:text}`title`
#
# **Question.** A camera looks into a mirror that was bent, step by step. What
# shape did it have at each step, and how far can that be trusted?
#
# {glue:text}`about`

# %%
from functools import partial

from chapters.photographs.mirror import results
from chapters.photographs.mirror.exercises import end_task
from chapters.photographs.mirror.trials import calibration_of, settings_of
from chapters.shared.photographs.notes import origin, title
from raxel.sets import load_mirror_set
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

PICTURE_PX = {"quick": 240, "full": 480}


# %%
def mirror_trial(folder, width_px, condition, rng):
    """The whole calibration of a mirror set."""
    return calibration_of(load_mirror_set(folder), width_px)


@experiment("mirror_study", artefact="ext_mirror_profiles", per_set=("mirror",))
def mirror_study(effort, folder):
    """First shape, deflections, and all stages at once."""
    trial = partial(mirror_trial, folder, PICTURE_PX[effort])
    return Plan(trial, [{}], 1, settings_of(load_mirror_set(folder)))


# %% tags=["active-ipynb", "remove-input"]
# study = results.MirrorStudy(open_results("mirror_study"))

# %% tags=["active-ipynb"]
# value("title", title(study))

# %% tags=["active-ipynb"]
# value("about", results.about(study))

# %% tags=["active-ipynb"]
# value("found", results.found(study))

# %% tags=["active-ipynb"]
# value("flagged", results.flagged(study))

# %% tags=["active-ipynb"]
# value("origin", origin(study))

# %% tags=["active-ipynb"]
# show("ext_mirror_profiles")

# %% [markdown]
# ## Findings
#
# - {glue:text}`found`
# - {glue:text}`flagged`

# %% tags=["active-ipynb"]
# show_table("ext_mirror_found", digits=3)

# %% [markdown]
# ## Method
#
# 1. **The camera** is calibrated by itself, without the mirror.
# 2. **The monitor's places** are seen in a flat mirror that lies on a board.
# 3. **The first shape** is where each pixel's viewing ray meets the line
#    through the two points of the monitor that it sees.
# 4. **Each deflection.** The board's pose comes from the shape before; the new
#    shape is the spline that casts the corners' rays onto their corners.
# 5. **All at once.** Shapes and boards are adjusted together.
#
# Pages 5.2 and 5.3.3 derive it.

# %% tags=["active-ipynb"]
# show_code(calibration_of)

# %% [markdown]
# ## Stage by stage

# %% tags=["active-ipynb"]
# show("ext_mirror_stages")

# %% [markdown]
# {glue:text}`origin`
#
# ## Reading and limits
#
# - Profiles end where corners do. What lies beyond has no shape, and no rays.
# - A board that was touched between two pictures gives a shape that is wrong
#   with small residuals: a millimetre is taken for a bend.
# - The prediction is of noise and of what residuals tell. It takes the
#   monitor's size and the board's pitch for true.
# - Residuals that agree over a part of the mirror are what the spline cannot
#   follow.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell.
#
# **1.** A sheet is pushed by 5 mm at 150 mm from its clamp, and corners are
# seen up to 120 mm. By (5.1), how many mm does the end of the profile move?

# %% tags=["active-ipynb"]
# check(None, **end_task())
