# %% [markdown]
# # 4.3.2 Pictures corrected with both calibrations
#
# **Question.** A calibration is good for something: it straightens
# pictures. Does a picture corrected with CGSP's rays come out better than
# one corrected with those of the standard method? The thesis says yes for
# the mirror, and sees no difference for the fisheye.

# %%
from chapters.ch04_central_generic.s3_3_correction.exercises import (
    radius_task,
    stretch_task,
)
from chapters.ch04_central_generic.s3_3_correction.results import name_values
from chapters.ch04_central_generic.s3_3_correction.trials.boards import (
    corner_residuals,
    cut_across,
)
from chapters.ch04_central_generic.s3_3_correction.trials.calibrations import (
    by_protocol,
)
from chapters.ch04_central_generic.s3_3_correction.trials.scenes import straightness
from raxel.calibration import calibrate_central
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table

# %% tags=["active-ipynb"]
# show("fig_4_9")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - With decoding errors as large as the bench's
#   ([the page before](s3_2_results.ipynb) says how large) there is nothing to
#   choose. Chessboards before the mirror leave {glue:text}`omni.printed.mean:.2f`
#   mm after correction by the standard method as printed and adjusted,
#   {glue:text}`omni.conditioned.mean:.2f` mm well conditioned and
#   {glue:text}`omni.cgsp.mean:.2f` mm by CGSP; before the fisheye
#   {glue:text}`fish.printed.mean:.2f`, {glue:text}`fish.conditioned.mean:.2f` and
#   {glue:text}`fish.cgsp.mean:.2f` mm. What is left is the noise of each pixel's
#   own ray. The thesis's bench left many times as much (Table 4.4).
# - With the laboratory's own errors the methods can be told apart. Before the
#   mirror the standard method as printed leaves
#   {glue:text}`lab.omni.printed.mean:.3f` mm, well conditioned
#   {glue:text}`lab.omni.conditioned.mean:.3f` mm, CGSP
#   {glue:text}`lab.omni.cgsp.mean:.3f` mm. Before the fisheye CGSP is the worst
#   of the three, with {glue:text}`lab.fish.cgsp.mean:.3f` mm beside
#   {glue:text}`lab.fish.printed.mean:.3f` and
#   {glue:text}`lab.fish.conditioned.mean:.3f` mm: its poses are not adjusted, those
#   of the others are.
# - Edges in the mirror come out straight: in the median calibration the worst
#   one leaves its line by {glue:text}`omni.printed.worst:.2f` % of its length as
#   printed, and by {glue:text}`omni.cgsp.worst:.2f` % with CGSP. In the fisheye
#   each method bends at least one edge, by {glue:text}`fish.printed.worst:.1f` % as
#   printed and {glue:text}`fish.cgsp.worst:.1f` % with CGSP.

# %% tags=["active-ipynb"]
# show_table("table_4_4")

# %% [markdown]
# ## What the thesis claims
#
# Section 4.3.2 corrects pictures of real scenes and of chessboards. With
# the omnidirectional camera both methods make upright edges straight, but
# the standard one leaves aberrations where two badly placed grids meet, and
# shows less of the scene from top to bottom, as its centre has another
# depth. The residuals of chessboards are half as large with CGSP. With the
# fisheye there is nothing to choose, and its residuals grow to the left and
# right, where rays meet the plane at a slant.

# %% [markdown]
# ## Model
#
# **Calibration.** Both methods get the same decoded grids, by the protocol
# of 4.3.1. Three grids make the linear stage. The standard method adjusts
# their poses, CGSP does not. The other grids are placed from the rays that
# are known so far.

# %% tags=["active-ipynb"]
# show_code(by_protocol, calibrate_central)

# %% [markdown]
# **Residuals of a board.** The corners of a chessboard are found in a
# photograph. Their rays meet the plane that is most nearly at right angles
# to them (4.24). A homography carries these points onto the corners' known
# places on the board, and the rest is the residual, in mm.

# %% tags=["active-ipynb"]
# show_code(cut_across, corner_residuals)

# %% [markdown]
# **Edges of a room.** The true picture of each straight edge of a virtual
# room is known. Its pixels are turned into rays, and the rays into places on
# an upright cylinder (mirror: upright edges) or on the plane across the
# edge (fisheye). The largest distance from the best line is taken as a share
# of the edge's length.

# %% tags=["active-ipynb"]
# show_code(straightness)

# %% [markdown]
# ## Experiment
#
# The two cameras are rigs of the laboratory: see [their
# page](s3_1_setup.ipynb). Their monitors and boards are photographed,
# decoded and detected as anybody's. Three seeds go through pictures from end
# to end, at the bench's noise and at the laboratory's own. For the edges,
# {glue:text}`trials` calibrations of each camera have decoding errors drawn
# again, as they were measured in those pictures.

# %% [markdown]
# ## Corrected pictures

# %% tags=["active-ipynb"]
# show("fig_4_7")

# %% tags=["active-ipynb"]
# show("fig_4_8")

# %% [markdown]
# ## Reading and limits
#
# **Which standard method.** As printed and adjusted is what the thesis
# used. The well-conditioned one solves the same equations without their
# weak points, and stands beside it everywhere.
#
# **Field of view.** The calibrated part of the mirror's picture spans
# {glue:text}`vertical.printed:.2f`° from top to bottom with the standard
# method and {glue:text}`vertical.cgsp:.2f`° with CGSP; with the laboratory's
# errors it is {glue:text}`lab.vertical.printed:.2f`° and
# {glue:text}`lab.vertical.cgsp:.2f`°. At the bench's noise the difference goes
# either way, and giving both centres the same depth does not take it away.
#
# **Seams.** A seam is where corners within two columns of each other got
# their rays from other grids. Beside seams of the mirror, residuals are
# {glue:text}`seam.printed:.2f` times those elsewhere with the standard
# method as printed, and {glue:text}`seam.cgsp:.2f` times with CGSP; with the
# laboratory's errors, {glue:text}`lab.seam.printed:.2f` and
# {glue:text}`lab.seam.cgsp:.2f` times. Wrong poses show there, and at the
# bench's noise they drown in that of the rays.
#
# **Skew.** Residuals of the fisheye do not grow with the angle between ray
# and normal: the rank correlation is {glue:text}`skew.printed:.2f` as
# printed and {glue:text}`skew.cgsp:.2f` with CGSP.
#
# **Up is known.** The cylinder's axis and the frames of the pictures are
# set by the true pose of the base grid, as a photographer would set them by
# a plumb line. It is the same for all methods.
#
# **Limits.** The mirror is misaligned by as much as its rig says, and the
# fisheye's pupil moves; no central calibration takes that away. Of the
# {glue:text}`omni.boards` boards found with the mirror and the
# {glue:text}`fish.boards` with the fisheye, corners that have a ray are
# scored.

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
# **1.** By what factor does the plane stretch a short step along the radius,
# 40° from its normal, compared with its middle?

# %% tags=["active-ipynb"]
# check(None, **stretch_task())

# %% [markdown]
# **2.** An unwrapped picture is 720 px wide and shows 200°. What is the
# radius of its cylinder, in px?

# %% tags=["active-ipynb"]
# check(None, **radius_task())
