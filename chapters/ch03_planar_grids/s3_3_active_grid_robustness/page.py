# %% [markdown]
# # 3.3.3 Active grids against chessboards
#
# **Question.** A monitor can show a chessboard, or patterns that give every
# pixel of the camera its point. Which of the two tells better where a corner
# is, when the monitor is near or far, turned, out of focus, or photographed
# with noise? The thesis measures this with a second active grid; this page
# does it again in front of a virtual monitor, where the truth is known too.

# %%
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.exercises import (
    floor_task,
    lens_task,
    noise_task,
)
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.results import name_values
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials import (
    sweeps,
    viewing,
)
from raxel.features.active_grid.lookup import pixels_of, points_at
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("fig_3_15")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - The active grid matches or beats both other methods in
#   {glue:text}`won:.0f` % of the conditions, and in {glue:text}`won.least:.0f` %
#   with the worst of {glue:text}`sets` sets of pictures, where the claim asks
#   for 80 % with each; with overexposed pictures it is
#   {glue:text}`over.won:.0f` %.
# - The measure hides most of the difference: true corners, which have no
#   error, leave {glue:text}`floor:.3f` mm at 200 mm, the second grid's own.
#   What is less apart than this floor spreads from set to set,
#   {glue:text}`floor.spread:.4f` mm there, counts as a tie.
# - So each method's own error stands beside its residual here, as the
#   distance to the true corners. By it the active grid is
#   {glue:text}`off.active:.3f` px off, the
#   derivative method {glue:text}`off.derivative:.3f` px, the saddle point
#   {glue:text}`off.saddle:.3f` px.
# - With noise of {glue:text}`most_noise:.0f` grey levels the active grid is
#   {glue:text}`noisy.active:.2f` px off and the derivative method
#   {glue:text}`noisy.derivative:.2f` px: a sine is a much flatter slope than an
#   edge.
# - With a fifth more light than the wells hold, the derivative method is
#   {glue:text}`over.off.derivative:.2f` px off and the active grid
#   {glue:text}`over.off.active:.3f` px, as the thesis says of blooming.
# - Turned by {glue:text}`turned:.0f`°, the monitor is still decoded on
#   {glue:text}`share.turned:.0f` % of what is seen of it: its light falls
#   off, but not so far that it could not be read.

# %% [markdown]
# ## What the thesis claims
#
# A monitor shows a chessboard with 15 × 15 corners, 301.5 mm wide, 200 mm in
# front of a camera. Two methods of [3.1.3](s1_3_localisation.ipynb) localise
# its corners. Then it shows an active grid in the same place, and the decoded
# grid is searched for the points where the corners are. Last, a second
# active grid stands in front of the camera, which has not moved: it tells
# at which of its points each localised corner looks. A homography from
# these points to the known chessboard leaves a residual, and its RMS is drawn
# over distance, orientation, blur and noise (Fig. 3.15). Section 3.3.3 says:
#
# - active grids are superior under almost all conditions;
# - they stand distance, orientation, blur and additive noise;
# - one reason is that they stand blooming, which moves the edges of a
#   chessboard and not the phase of a sine;
# - their weakness is the monitor: seen at an angle it is darker, which
#   limits the area that can be used.

# %% [markdown]
# ## Model
#
# **A corner in the grid.** A decoded pixel $\mathbf{p}$ has a point
# $\mathbf{l}(\mathbf{p})$ of the monitor, in mm (3.24). A corner at the point
# $\mathbf{x}$ is between the four pixels whose points are nearest to
# $\mathbf{x}$, no three of them on a line: the homography from these points
# to their pixels takes $\mathbf{x}$ to the sub-pixel place.
#
# **A corner in the second grid.** The other way round: at a sub-pixel place
# $\mathbf{q}$ the second grid's point is bilinear between the four pixels
# around it.

# %% tags=["active-ipynb"]
# show_code(pixels_of, points_at)

# %% [markdown]
# **What is measured.** If a method puts corner $i$ at $\mathbf{q}_i$, the
# second grid sees $\mathbf{l}_2(\mathbf{q}_i)$ there, and
#
# $$r = \sqrt{\frac{1}{n} \sum_{i=1}^{n} \left\| H\,\mathbf{l}_2(\mathbf{q}_i) -
# \mathbf{x}_i \right\|^2},$$
#
# where $H$ is the homography with the least residual $r$ and $n$ the number
# of corners. Both grids are planes and the camera's rays have one centre,
# so that $H$ is exact whatever the lens does: distortion does not enter. But
# $\mathbf{l}_2$ has errors of its own. They add to those of every method, and
# what true corners leave is a floor that no method can get below for long.

# %% tags=["active-ipynb"]
# show_code(sweeps.residual_mm)

# %% [markdown]
# **Noise.** Four steps of a sine with the swing $B$ (grey levels) and noise of
# the standard deviation $\sigma$ give a phase with
#
# $$\sigma_\varphi = \sqrt{\tfrac{2}{4}}\,\frac{\sigma}{B}, \qquad
# \sigma_l = \frac{w}{2\pi}\,\frac{\sigma_\varphi}{7}$$
#
# for a cell of the width $w$, after the average over 7 × 7 pixels. With cells of
# 37.7 mm the whole swing lies in half a cell, while an edge of the chessboard
# has it within two pixels.

# %% [markdown]
# ## Experiment
#
# The rig is `monitor-d200` (*Rigs* shows it). What the thesis leaves open was
# chosen in the ledger (`grid_active_eval`), with its reasons:
#
# - **Lens.** A grid of 301.5 mm is 74° high at 200 mm. The D200's sensor is
#   15.8 mm high, and no lens of Nikon's without distortion shows that much on
#   it; the 10.5 mm fisheye of 3.3.4 does.
# - **Pixels.** One of ours is 3 × 3 of the camera's, with their wells taken
#   together. A condition takes 45 pictures.
# - **Windows.** 15 px for both localisers, and half a square as a reading.
# - **Ranges.** The thesis's are lost. Ours end where the chessboard leaves the
#   picture, or with blur and noise beyond what the camera can do wrong.
# - **Exposure.** White in the middle fills 0.9 of a well. A fifth above a full
#   well is a reading: the charges behind the same files, times 4/3, overflow
#   along their columns.
#
# - **Filter.** The thesis filters the pictures of the sines. The library
#   averages the phases as unit vectors over the same 7 × 7 pixels, which
#   damps the ripple of the response a little more. The floor is thus a
#   little lower than with the thesis's filter.
#
# Blur and noise are added to the finished files, in whole numbers. Sets
# differ in noise and in how the monitor was set up, by hand.

# %% tags=["active-ipynb"]
# show_code(sweeps.robustness_trial, sweeps.brighter)


# %%
@experiment(
    "fig_3_15_sweeps", artefact="fig_3_15", shards={"full": 3}, rendered=sweeps.SETS
)
def all_sweeps(effort):
    """Fig. 3.15: distance, orientation, blur and noise, on every set."""
    return Plan(sweeps.robustness_trial, sweeps.conditions(effort), 1, sweeps.SETTINGS)


@experiment("exp_c3_active_viewing_angle", artefact="fig_3_15", inputs=viewing.FILES)
def viewing_angles(effort):
    """How much of a turned monitor is decoded, with other fall-offs."""
    return Plan(viewing.viewing_trial, viewing.conditions(effort), 1, viewing.SETTINGS)


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show("ext_active_errors")

# %% [markdown]
# ## Reading and limits
#
# **The floor.** True corners leave nearly as much as any method. Four phase
# steps keep the third harmonic of the sine that monitor, black level and camera
# make of the pattern. At the corners of the *first* grid it does no harm: they
# lie where $\varphi = k\pi$. The second grid stands elsewhere, and shows it in
# full. So Fig. 3.15 can tell methods apart only where one of them errs by as
# much as the second grid. How high the floor is depends on where the monitors
# stand, and that is another place in every set of pictures: residuals that are
# less apart than the dotted band is wide are a tie. Against the true corners
# there is no floor. That is a reading of its own, in which nothing ties.
#
# **Noise.** The active grid is first beaten at a noise of
# {glue:text}`first_lost_noise` grey levels. The thesis's range is lost; with
# one that ends before, the claim holds. More cells make steeper sines. Our
# pixels are 3 × 3 of the camera's, and that is in the active grid's favour: its
# filter has 49 pixels at any resolution, while an edge crosses more of the
# smaller ones.
#
# **Blur.** It is even about a corner as well as along a sine, and takes the
# contrast, not the place. The derivative method, whose model has a width for
# each edge, stands it as well as the active grid does. The saddle point does
# not; its error is larger the nearer the board, as is the bend of the lens
# within its window. From no blur to the strongest, the active grid's own
# error, which is small, becomes {glue:text}`blurred.active:.2f` times as
# large and the derivative method's {glue:text}`blurred.derivative:.2f` times,
# by the true corners. In the residual the floor hides both.
#
# **Blooming.** Below a full well it does not exist. Above, white squares grow
# along their columns, and corners move with them. Sines are clipped at their
# crests; corners lie half way up. The decoder that this repository recommends
# would leave clipped pixels out; here it does not, as the thesis masks nothing.
# The margin within the rim of the monitor is fixed at what it is in sharp
# pictures, as overflow at edges of the Gray code is no blur. The test of
# blooming in [3.2.2](s2_2_active_grids.ipynb) asks at corners too, in smaller
# pictures and with overflow that all runs on; there, masking is a reading.
#
# **Viewing angle.** At {glue:text}`largest_angle:.0f`°, the largest angle to
# the monitor's normal, {glue:text}`light_there:.0f` % of the light is left. In
# a file for monitors (gamma 2.2) that is {glue:text}`grey_there:.0f` % of the
# grey levels, and enough. Without the rim the share falls, but on a monitor
# without fall-off it does so too: the rim of 6 px is more of a narrower image.
# What fall-off costs is precision: the SD that the decoder states goes from
# {glue:text}`sigma.straight:.1f` to {glue:text}`sigma.turned:.1f` µm. Real
# panels of that time also lose contrast at an angle, and some invert it. The
# rig's does not: only darkness could have made an area unreadable here, and
# this monitor does not get dark enough for this camera. Another might.
#
# **Limits.** One camera, one monitor, no lines of pixels on it. The
# camera's rays meet in one point; those of a real fisheye nearly do, and
# what they miss would be in the residual of every method.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A grid 301.5 mm high stands 200 mm in front of a sensor 15.8 mm
# high. Which focal length in mm, at most, may a lens without distortion have
# to show all of it?

# %% tags=["active-ipynb"]
# check(None, **lens_task())

# %% [markdown]
# **2.** Sines have a swing of 80 grey levels, the noise has an SD of 4. Four
# steps, cells of 37.7 mm, a filter of 7 × 7 pixels: what is the SD of a
# decoded coordinate, in mm?

# %% tags=["active-ipynb"]
# check(None, **noise_task())

# %% [markdown]
# **3.** A method's corners are 0.010 mm off, and the second grid errs by
# 0.050 mm, independently. Which residual is seen, in mm?

# %% tags=["active-ipynb"]
# check(None, **floor_task())
