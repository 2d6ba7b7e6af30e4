# %% [markdown]
# # What CGSP really buys
#
# **Question.** In [Fig. 4.2](s1_5_simulated.ipynb) CGSP leaves the standard
# linear stage far behind, although both solve for the same centre from the
# same rays. Where does the difference come from? This page goes from one to
# the other in steps, and changes one thing at a time.

# %%
from chapters.ch04_central_generic.ext_what_cgsp_buys.exercises import (
    coefficients_task,
    rays_task,
)
from chapters.ch04_central_generic.ext_what_cgsp_buys.results import name_values
from chapters.ch04_central_generic.ext_what_cgsp_buys.trials import (
    NOISE_PX,
    STEPS,
    TRIALS,
    centre_errors,
    in_normalised_coordinates,
    one_scale,
)
from chapters.shared.wide_angle import SETTINGS, draw_scene, radial_lens
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_what_cgsp_buys_figure")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Normalised coordinates make the error of the centre smaller by a factor
#   of {glue:text}`gain.normalised`, one scale by least squares by
#   {glue:text}`gain.one_scale`, and divisors that cannot vanish by
#   {glue:text}`gain.well_conditioned`.
# - Then nothing of the difference is left: from the well-conditioned
#   standard method to CGSP the factor is {glue:text}`gain.cgsp`.
# - Weighting the rays, which CGSP does not do, and adjusting the centre
#   after that show no certain gain with the three grids of this scene:
#   factors of {glue:text}`gain.cgsp_weighted` and
#   {glue:text}`gain.consistent`.
# - The standard method bears wrong points as well as CGSP does, when it is
#   given the rays that CGSP's RANSAC kept: with 5 % wrong points it leaves
#   {glue:text}`outliers.well_conditioned_robust:.2f` mm, CGSP
#   {glue:text}`outliers.cgsp_robust:.2f` mm.

# %% [markdown]
# ## What the thesis claims
#
# Sections 4.1 and 4.4 explain the advantage of CGSP by its simpler
# equations: it needs none of the steps from (2.14) to (2.25), can reject
# outliers while it estimates, and takes any pinhole calibration for its
# core. The accuracy of Fig. 4.2 is credited to the method as a whole.

# %% [markdown]
# ## Model
#
# Both methods begin with the same fact: a ray meets the base grid in
# $\mathbf{Q}^1$ and another grid in $\mathbf{Q}^2$, and the two are related
# by a homography $H$. The standard method finds the rows of $H$ in two
# pieces, the vectors $V$ and $W$, each up to a factor of its own. CGSP
# finds $H$ at once. The centre then follows from the fact that a grid's
# axes are orthogonal and of one length.
#
# - *As printed*: equations 2.15 to 2.25 in mm; the ratio $V_4/W_1$ sets the
#   scale between $V$ and $W$.
# - *Normalised coordinates*: every grid's points are shifted to their
#   middle and scaled.
# - *One scale by least squares*: all three entries that $V$ and $W$ share
#   set the scale.
# - *No vanishing divisors*: $C_z$ comes from $\lvert\mathbf{C}\rvert^2$, and
#   not from a quotient by $V_4 V_5$.
# - *CGSP*: $V$ and $W$ are estimated together, as one homography.
# - *Weighted*: each ray counts by what noise in the image does to its
#   equations.
# - *Adjusted*: centre, poses and rays are adjusted together.

# %% tags=["active-ipynb"]
# show_code(in_normalised_coordinates, one_scale)

# %% [markdown]
# ## Experiment
#
# The scene is that of [section 4.1.5](s1_5_simulated.ipynb) at a noise of
# 0.5 px. All steps get the same trials.


# %%
def trial(condition, rng):
    """One scene, and the error of the centre after every step."""
    return centre_errors(draw_scene(radial_lens(), NOISE_PX, rng).noisy, STEPS)


@experiment("ext_cgsp_steps", artefact="ext_what_cgsp_buys_figure")
def steps(effort):
    """All steps, three grids, 0.5 px."""
    return Plan(trial, [{"noise": NOISE_PX}], TRIALS[effort], SETTINGS)


# %% [markdown]
# ## Step by step

# %% tags=["active-ipynb"]
# show_table("ext_cgsp_steps_table")

# %% [markdown]
# ## What the error depends on

# %% tags=["active-ipynb"]
# show("ext_cgsp_sensitivity_figure")

# %% [markdown]
# ## Wrong points

# %% tags=["active-ipynb"]
# show_table("ext_cgsp_outliers_table")

# %% [markdown]
# ## Reading and limits
#
# **Numerics.** As printed, the scale between $V$ and $W$ hangs on one entry
# of the rotation, $R_{31}$, and the depth of the centre on a product of two.
# A grid that is hardly tilted about one axis makes them small, and the noise
# in them large. Any tilt will do once all entries are used together. That is
# a matter of how the equations are solved.
#
# **Robustness.** RANSAC on the homographies is part of CGSP in the thesis.
# But the homography between two grids is there whatever method follows, so
# the standard method can use it as well.
#
# **More grids.** The printed equations take three grids. Well conditioned,
# they take any number, as CGSP does: from three to ten grids CGSP's error
# falls from {glue:text}`grids.cgsp.3:.2f` to {glue:text}`grids.cgsp.10:.2f`
# mm, and with the adjustment from {glue:text}`grids.consistent.3:.2f` to
# {glue:text}`grids.consistent.10:.2f` mm.
#
# **What CGSP does buy** is simplicity: one homography, four unknowns, one
# singular value decomposition, a pose by a known recipe, and no step in
# which something may vanish. That is worth having: what the method as
# printed loses here, it loses at these places.
#
# **Limits.** One camera, one kind of scene, and noise that is Gaussian but
# for the wrong points.

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis prints no numbers for these steps. Its claims about the two
# methods are judged in [section 4.1.5](s1_5_simulated.ipynb).

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** From 100 to 3000 rays, by what factor should the error of the centre
# change? Compare with the figure.

# %% tags=["active-ipynb"]
# check(None, **rays_task())

# %% [markdown]
# **2.** By how many free numbers do $V$ and $W$, found apart with six
# entries each, outnumber one homography?

# %% tags=["active-ipynb"]
# check(None, **coefficients_task())
