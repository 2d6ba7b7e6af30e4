# %% [markdown]
# # {glue:text}`title`
#
# **Question.** A monitor shows coded patterns, and every pixel of the
# camera reads where on the monitor it looks. How much of these pictures can
# be read, how sure is each place, and what was left out?
#
# {glue:text}`about` {glue:text}`shown`

# %%
from functools import partial

from chapters.photographs.active_grid import results
from chapters.photographs.active_grid.exercises import cell_task, spread_task
from chapters.photographs.active_grid.trials import (
    calibration_part,
    settings_of,
    view_part,
)
from chapters.shared.photographs.notes import origin, title
from raxel.sets import load_set
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

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
# study = results.GridStudy(open_results("active_grid_study"))

# %% tags=["active-ipynb"]
# value("title", title(study))

# %% tags=["active-ipynb"]
# value("about", results.about(study))

# %% tags=["active-ipynb"]
# value("shown", results.shown(study))

# %% tags=["active-ipynb"]
# value("found", results.found(study))

# %% tags=["active-ipynb"]
# value("left_out", results.left_out(study))

# %% tags=["active-ipynb"]
# value("precision", results.precision(study))

# %% tags=["active-ipynb"]
# value("doubted", results.doubted(study))

# %% tags=["active-ipynb"]
# value("mirrored", results.mirrored(study))

# %% tags=["active-ipynb"]
# value("camera", results.camera(study))

# %% tags=["active-ipynb"]
# value("origin", origin(study))

# %% tags=["active-ipynb"]
# value("exercise", results.exercise(study))

# %% tags=["active-ipynb"]
# value("noise", results.noise_of(study))

# %% tags=["active-ipynb"]
# show("ext_grid_places")

# %% [markdown]
# ## Findings
#
# - {glue:text}`found`
# - {glue:text}`left_out`
# - {glue:text}`precision`
# - {glue:text}`doubted`

# %% [markdown]
# ## Method
#
# 1. **The cell.** A Gray code numbers the cells of the monitor. Each of its
#    patterns is shown with its inverse, and a pixel's bit says in which of
#    the two it is brighter. What dims both does not matter.
# 2. **The place in the cell.** Sines that are moved on by equal steps tell
#    the phase, and with it the place between the edges of the cell. Without
#    sines the middle of the cell is the best guess.
# 3. **The standard deviation.** The noise of a grey value, measured in these
#    pictures, over the contrast of the pixel: this is what noise does to its
#    place. It does not know of a monitor whose answer is not linear.
# 4. **The mask.** A pixel keeps its place only if it is lit, not
#    overexposed, reads a code that can exist, and agrees with one of its
#    neighbours at least. Nothing is carried over a break between surfaces.
#
# [Section 3.2.2](../ch03_planar_grids/s2_2_active_grids.ipynb) derives it.

# %% tags=["active-ipynb"]
# show_code(view_part)

# %% [markdown]
# ## What became of each pixel

# %% tags=["active-ipynb"]
# show_table("ext_grid_views", digits=3)

# %% [markdown]
# {glue:text}`origin` {glue:text}`mirrored`
#
# ## A camera from these places
#
# {glue:text}`camera`

# %% tags=["active-ipynb"]
# show_table("ext_grid_camera", digits=3)

# %% [markdown]
# ## Reading and limits
#
# - The standard deviation is of noise, of bending, and of what is left of the
#   response: harmonics of monitor and camera shift places in a ripple that comes
#   again with each step. It is measured where surfaces are smooth, and taken off;
#   where it is larger than the standard deviation, six steps and more have less.
# - A pixel whose light comes from two places, by a reflection or through a
#   blurred edge, reads one of them or a place between.
# - Places are on the lit plane. That this plane is flat, and that its size
#   is the stated one, cannot be seen in the pictures.
# - Pictures that contradict each other are refused. What they all share,
#   such as an axis that is reversed throughout, looks like a mirror.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell.
#
# **1.** A pixel reads the bits 1, 1, 0, the most significant first. In which
# cell is the place that it sees, counted from 0?

# %% tags=["active-ipynb"]
# check(None, **cell_task())

# %% [markdown]
# **2.** A grey value has a standard deviation of {glue:text}`noise:.3f`.
# {glue:text}`exercise` The sines have a modulation of 60 grey values and
# periods of 40 mm, and there are four steps. What is the standard deviation
# of a place, in mm, for a pixel by itself?

# %% tags=["active-ipynb"]
# check(None, **spread_task(results.noise_of(study)))
