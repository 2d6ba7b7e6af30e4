# %% [markdown]
# # Smooth rays
#
# **Question.** A table gives every pixel a ray of its own, and every ray has
# the noise of the few points that were seen on it. A lens bends rays
# smoothly, whatever its formula. How much less noise is left when rays are
# smoothed over the image, and does the camera remain as general as a table?

# %%
from chapters.ch04_central_generic.ext_smooth_rays.exercises import controls_task
from chapters.ch04_central_generic.ext_smooth_rays.results import name_values
from chapters.ch04_central_generic.ext_smooth_rays.trials import (
    CONDITIONS,
    LENSES,
    SMOOTH_SETTINGS,
    TRIALS,
    bent_lens,
    calibrate,
    scores,
)
from chapters.shared.wide_angle import draw_scene
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_smooth_rays_figure")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - A bent lens, three grids and 0.5 px of noise: the residual falls from
#   {glue:text}`usual.table.left_px:.2f` px for the table to
#   {glue:text}`usual.smooth.left_px:.2f` px for smooth rays; of the radial
#   law alone {glue:text}`usual.formula.left_px:.2f` px are left.
# - Where a radial law is all there is to the lens, the field stays away:
#   {glue:text}`radial.smooth.left_px:.3f` px, the law's own
#   {glue:text}`radial.formula.left_px:.3f` px.
# - What all rays have in common, errors of centre and grid poses, no
#   smoothing takes away: in the image, one rotation apart,
#   {glue:text}`usual.smooth.off_px:.2f` px are left with three grids and
#   {glue:text}`many.smooth.off_px:.2f` px with ten.
# - Only the direct adjustment allows for such errors, and for more than there
#   are: its squared errors are {glue:text}`usual.direct.normalised:.1f` times
#   those it states, for the smooth table
#   {glue:text}`usual.smooth.normalised:.0f` times (medians).

# %% [markdown]
# ## What the thesis claims
#
# Nothing: its general cameras are tables, in which every pixel stands for
# itself. Section 4.1.3 fits each ray to its own points. Section 4.4 names
# the number of pictures that a table needs as the price of generality.

# %% [markdown]
# ## Model
#
# A *trend*, any central camera, takes care of what is large. A pixel
# $\mathbf{p}$ gets the ray that the trend has for
#
# $$\mathbf{p} + \mathbf{s}(\mathbf{p}), \qquad
# \mathbf{s}(\mathbf{p}) = \sum_{i,j} b_i(v)\, b_j(u)\, \mathbf{c}_{ij},$$
#
# where $\mathbf{s}$ is a smooth field in px: cubic splines $b$ on a lattice
# of cells, with control values $\mathbf{c}_{ij}$. With small cells this is
# as good as any central camera. As $\mathbf{s}$ changes by much less than a
# pixel per pixel, each ray has exactly one pixel.
#
# Measuring in px pays: noise of corners and decoded points is about the
# same all over the image, whatever the lens does there.
#
# *Fit to a table.* Each ray of a table tells a value of $\mathbf{s}$: where
# the trend sees it, less its pixel. Least squares, plus a penalty on second
# differences of the control values. Cells and penalty are chosen so that
# squares of the image which are kept out are predicted best.
#
# *Adjusted directly.* A point of a grid is imaged by the trend at
# $\mathbf{q}$, and by the camera at the $\mathbf{p}$ with
# $\mathbf{p} + \mathbf{s}(\mathbf{p}) = \mathbf{q}$. Control values and grid
# poses are adjusted together, so that these places come close to where the
# points were seen. A rotation of all rays is the same as one of all poses;
# the field gets no part of it. Here whole grids are kept out, and only
# their poses are fitted.
#
# **Uncertainty.** The covariance of the control values gives each ray its
# own, in px. Polynomials to the third degree count as unknown in it: the
# trend comes from the same noisy data.
#
# **Where there is no target** a weak penalty draws the field to zero. With
# corners of boards it is as soft as the field is smooth: a firm one would bend
# the field among the corners, too. The cells without data are reported.

# %% tags=["active-ipynb"]
# show_code(bent_lens, calibrate)

# %% [markdown]
# ## Experiment
#
# The scene is that of [section 4.1.5](s1_5_simulated.ipynb) at a field of
# view of 90 degrees: 999 rays, planes in random poses, noise drawn anew for
# every plane. The *radial* lens is the one of that section. The *bent* lens
# is the same, and its image is pushed about by waves of one pixel, about half
# as long as the image. CGSP, adjusted with its centre, makes the table.


# %%
def trial(condition, rng):
    """One scene, calibrated in every way, and what is left."""
    camera = LENSES[condition["lens"]]()
    scene = draw_scene(camera, condition["noise"], rng, grids=condition["grids"])
    return scores(scene, *calibrate(scene))


@experiment(
    "ext_smooth_rays_runs", artefact="ext_smooth_rays_figure", shards={"full": 2}
)
def runs(effort):
    """Noise, lenses and numbers of grids."""
    return Plan(trial, list(CONDITIONS), TRIALS[effort], SMOOTH_SETTINGS)


# %% [markdown]
# ## In numbers

# %% tags=["active-ipynb"]
# show_table("ext_smooth_rays_honest_table")

# %% [markdown]
# ## Reading and limits
#
# **Two measures.** After a homography only the shape of the corrected view
# counts; this is how the thesis scores distortion correction. After a
# rotation also errors count that a homography takes up: a centre or a focal
# length that is off. These do not shrink by smoothing, since all rays share
# them; they shrink with more grids.
#
# **What a table cannot tell.** Errors of the poses that went into a table
# are smooth over the image. From the table alone they look like the lens.
# The smooth table's stated errors are those of its noise, no more.
#
# **Smoothness is an assumption.** Cameras that break the view, such as
# mirrors in facets, need a table. A scratch or a single bad pixel does not
# appear in a field.
#
# **Few boards.** Scale and depths are hardly told apart by a handful of
# boards with little tilt, and a free field tells them apart less well than
# a formula does. The stated errors show it. When the field predicts boards
# that were kept out no better than the formula alone, it stays zero.
#
# **Central.** One centre for all rays; a pupil that moves is no matter of
# smooth rays.

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis has no such experiment, and prints no number for it.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A square image is cut into 8 x 8 cells. How many numbers make up
# the field?

# %% tags=["active-ipynb"]
# check(None, **controls_task())
