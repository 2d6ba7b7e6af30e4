# %% [markdown]
# # {glue:text}`title` (active grid)
#
# **Question.** A monitor displays coded patterns, an *active grid* (phase-shift
# structured light), and every pixel decodes the screen position that it sees. Given
# the images of a set, how many pixels can be decoded, with what uncertainty, and
# which are excluded?
#
# {glue:text}`about` {glue:text}`shown`

# %%
from functools import partial

from chapters.photographs.active_grid.exercises import cell_task, spread_task
from chapters.photographs.active_grid.experiment import (
    calibration_part,
    settings_of,
    view_part,
)
from chapters.photographs.active_grid.report import (
    GridStudy,
    about,
    camera,
    doubted,
    exercise,
    found,
    left_out,
    mirrored,
    noise_of,
    precision,
    shown,
)
from chapters.shared.images.notes import origin, title
from raxel.sets import load_set
from repro.page import check, open_results, show, show_code, show_table, value
from repro.run import Plan, experiment

PICTURE_PX = {"quick": 320, "full": 480}


# %%
def grid_trial(folder, width_px, condition, rng):
    """A view decoded, or a camera from all of them."""
    if condition["part"] == "view":
        return view_part(folder, condition["view"], width_px)
    return calibration_part(folder)


@experiment("active_grid_study", artefact="ext_grid_places", per_set=("active_grid",))
def active_grid_study(effort, folder):
    """Every view decoded, and a camera where there are enough."""
    image_set = load_set(folder)
    views = [{"part": "view", "view": k} for k in range(len(image_set.views))]
    return Plan(
        partial(grid_trial, folder, PICTURE_PX[effort]),
        [*views, {"part": "camera"}],
        1,
        settings_of(image_set),
    )


# %% tags=["active-ipynb", "remove-input"]
# study = GridStudy(open_results("active_grid_study"))

# %% tags=["active-ipynb"]
# value("title", title(study))

# %% tags=["active-ipynb"]
# value("about", about(study))

# %% tags=["active-ipynb"]
# value("shown", shown(study))

# %% tags=["active-ipynb"]
# value("found", found(study))

# %% tags=["active-ipynb"]
# value("left_out", left_out(study))

# %% tags=["active-ipynb"]
# value("precision", precision(study))

# %% tags=["active-ipynb"]
# value("doubted", doubted(study))

# %% tags=["active-ipynb"]
# value("mirrored", mirrored(study))

# %% tags=["active-ipynb"]
# value("camera", camera(study))

# %% tags=["active-ipynb"]
# value("origin", origin(study))

# %% tags=["active-ipynb"]
# value("exercise", exercise(study))

# %% tags=["active-ipynb"]
# value("noise", noise_of(study))

# %% tags=["active-ipynb"]
# show("ext_grid_places")

# %% [markdown]
# ## Findings
#
# 1. {glue:text}`found`
# 2. {glue:text}`left_out`
# 3. {glue:text}`precision`
# 4. {glue:text}`doubted`

# %% [markdown]
# ## Method
#
# 1. **Cell.** A Gray code numbers the cells of the monitor. Each pattern is shown
#    with its inverse. A bit is 1 where the pattern is brighter than its inverse, so a
#    uniform change of light has no effect.
# 2. **Position in the cell.** Sinusoidal patterns with equal phase steps give the
#    phase, and with it the position inside the cell. Without them the position is the
#    middle of the cell.
# 3. **Standard deviation.** The noise of a grey value, measured in these images, is
#    divided by the contrast of the pixel. This part does not include a nonlinear
#    response of the monitor.
# 4. **Mask.** A pixel is decoded if it is lit, not overexposed, has a valid code, and
#    agrees with at least one neighbour. Nothing is interpolated across surface
#    boundaries.
#
# [Section 3.2.2](../ch03_planar_grids/s2_2_active_grids.ipynb) derives the method.

# %% tags=["active-ipynb"]
# show_code(view_part)

# %% [markdown]
# ## Decoded and excluded pixels

# %% tags=["active-ipynb"]
# show_table("ext_grid_views", digits=3)

# %% [markdown]
# {glue:text}`origin` {glue:text}`mirrored`
#
# ## Calibration from these positions
#
# {glue:text}`camera`

# %% tags=["active-ipynb"]
# show_table("ext_grid_camera", digits=3)

# %% [markdown]
# ## Limits
#
# - The predicted standard deviation includes noise, surface bending, and the
#   remaining error of the response. Harmonics of monitor and camera shift positions
#   in a periodic ripple. The ripple is measured where surfaces are smooth, and
#   corrected. If it exceeds the standard deviation, use six phase steps or more.
# - A pixel that receives light from two positions, by a reflection or across a
#   blurred edge, decodes one of them or a position between.
# - Positions refer to the lit plane. The images do not show whether this plane is
#   flat and has the stated size.
# - Contradictory images are rejected. A common fault of all images, such as a
#   reversed axis, looks like a mirror.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of `None`,
# and run the cell.
#
# **1.** A pixel has the bits 1, 1, 0, the most significant first. Which cell does it
# see, counted from 0?

# %% tags=["active-ipynb"]
# check(None, **cell_task())

# %% [markdown]
# **2.** A grey value has a standard deviation of {glue:text}`noise:.3f`.
# {glue:text}`exercise` The sinusoids have a modulation of 60 grey values and a period
# of 40 mm, with four phase steps. What is the standard deviation of a position, in
# mm, for a single pixel?

# %% tags=["active-ipynb"]
# check(None, **spread_task(noise_of(study)))
