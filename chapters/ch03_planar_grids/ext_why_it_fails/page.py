# %% [markdown]
# # Why it fails
#
# **Question.** CELECT goes along an edge from window to window, collects
# corners on the way, and merges them. When a board is lost, which of these
# steps lost it? And does each condition of 3.1.2 matter as the thesis says?

# %%
import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.exercises import (
    arc_task,
    square_task,
    tangent_task,
)
from chapters.ch03_planar_grids.ext_why_it_fails.results import name_values
from chapters.ch03_planar_grids.ext_why_it_fails.trials import runs, stages
from chapters.ch03_planar_grids.ext_why_it_fails.trials.sector_board import SectorBoard
from chapters.shared.robustness import DEFAULTS, LEVELS, board_of
from chapters.shared.scoring import LOST_PX
from chapters.shared.synthetic_board import clicks
from raxel.features.celect import celect
from raxel.features.celect.baselines import (
    order_by_homography,
    order_by_joining_line,
    row_margin,
)
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show_table("ext_why_stages")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - The conditions matter: {glue:text}`pairs_broken` boards are right where
#   one is broken, {glue:text}`pairs_kept` where it is kept.
# - Of {glue:text}`pairs_lost` boards that are lost, tracing loses
#   {glue:text}`pairs_traced`, the processing of corners
#   {glue:text}`pairs_processed`, and a wrong outer corner
#   {glue:text}`pairs_clicked`.
# - Two sentences of 3.1.2 are too short. Half a window of clearance has to be
#   its radius, not half of that, and more where a window grows. And the
#   straightest side 4 is good advice, but no guarantee.
# - At hard levels of the sweeps of 3.3.1, in fewer trials of their own, the
#   commonest first error is {glue:text}`sweep_all`. 3.3.1 counts where
#   CELECT gave up, which can be later.

# %% [markdown]
# ## What the thesis claims
#
# [CELECT](s1_2_celect.ipynb) asks for something in return for needing no model
# of the camera. Section 3.1.2 ("Prerequisites and Limitations") says:
#
# - around the outermost contours, over half a window, there is no edge but
#   those of the board;
# - at the first corner the right contour is not within $t_4$ = 15° of $L_4$,
#   the line from the fourth corner to the first; and the wrong contour is
#   not both more than $t_4$ from $L_4$ and closer to $L_1$ than the right
#   one. So one should start where side 4 is the straightest;
# - squares are not large where contours bend strongly, or the arc in a
#   window is no line any more;
# - squares do not vary much along a side, or $t_8$ merges corners that are
#   two;
# - the picture is sharp.
#
# It says as well that a window must be neither too small nor too large, and
# 3.3.2 that the direction of the clicks matters. Section 1.2.1 explains why
# older orderings fail: the corners "no longer lie on straight lines joining
# corners on opposite sides".

# %% [markdown]
# ## Model
#
# Each condition is broken and kept on boards that are drawn for it: the
# sector of a ring, as a curved mirror shows a board. How far it reaches
# around, how much its squares grow and how much its columns bow are free,
# and its corners are known exactly.

# %% tags=["active-ipynb"]
# show_code(SectorBoard.place, SectorBoard.image)

# %% [markdown]
# **Which stage lost it.** CELECT says which contour failed, and whether it
# had too few corners or too many. That is where it noticed. Here the truth
# is known, so the first wrong thing on that contour can be named:
#
# | stage | what it means |
# |---|---|
# | outer corner | a click was snapped to something else |
# | no edge found | on the right contour, but no window showed where to go |
# | end not reached | on the right contour, but out of steps: 6 a square |
# | wrong edge | an anchor is off the contour that was to be followed |
# | corner not detected | no candidate near a true corner |
# | corner thrown out | there was one, and $t_7$ refused it |
# | corners merged | it was kept, and then merged with another |
# | false corner kept | more corners than there are |
#
# Two anchors in a row that are off the contour by more than 8 % of a square,
# and by more than 3 px, are a wrong edge; a corner is found within a quarter
# of a square. CELECT sees nothing of this.

# %% tags=["active-ipynb"]
# show_code(stages.lost_at)

# %% [markdown]
# The condition on the first corner can be computed from the true contours,
# so failure can be foretold:

# %% tags=["active-ipynb"]
# show_code(runs.wrong_first_line)

# %% [markdown]
# ## Experiment
#
# A trial turns and shifts the board at random, makes its arc up to 3 %
# longer or shorter, and moves every click by about a pixel. Then it runs
# all levels of a case with this one variation, so that levels differ in
# one thing only. The boards are made to show a failure, so their levels were
# found by trying. A first set of boards was half as large; its half ring
# failed even where every condition was kept, because our first suppression
# in Hough space found a contour twice. That has been mended since
# (`celect_thresholds`). Several levels of curvature were tried before these were
# kept, the drawn level of size variation went from 1:9 to 1:6, the sweep of
# blur was lengthened because 8 px mostly passed, and the thresholds that
# name a stage were set after looking at such runs. So the page shows *that*
# and *where* these conditions break a run, not how often they do.

# %%
# Levels of Fig. 3.11 at which trials are lost: its failures, traced here.
LOSING = {
    "noise_sd": (80, 100),
    "blur_px": (4, 6, 8),
    "squares_across": (25, 30, 40),
    "fov_deg": (152, 158, 164),
    "yaw_deg": (40, 44, 48),
}
FEW = {"blur_px": (8,), "fov_deg": (158,)}
TRIALS = {"quick": 1, "full": 6}


def sweep_trial(condition, rng):
    """A trial of the sweeps of 3.3.1, with the stage that lost it."""
    board = board_of(condition)
    if np.isnan(board.corners).any():
        return {"stage": stages.UNSEEN, "contour": "", "returned": False}
    image = board.image(
        condition["blur_px"], condition["noise_sd"], rng, LEVELS[condition["levels"]]
    )
    outer = clicks(board.outer_corners, rng)
    run = celect(image, outer, board.columns, board.rows)
    lost = stages.lost_at(run, board.coordinates, board.place, LOST_PX)
    return {"stage": lost.stage, "contour": lost.contour, "returned": run.found}


@experiment("ext_why_sweeps", artefact="ext_why_sweeps", shards={"full": 2})
def sweeps(effort):
    """The levels of Fig. 3.11 at which trials are lost."""
    levels = FEW if effort == "quick" else LOSING
    conditions = [DEFAULTS | {name: value} for name in levels for value in levels[name]]
    return Plan(sweep_trial, conditions, TRIALS[effort])


# %% [markdown]
# ## Case by case
#
# Each figure shows one variation of a drawn pair: above, the whole board
# with the anchors of every contour; below, the window that decided it, and
# the window at the same place where all went well. The bars count the
# random variations of all levels.
#
# **Clearance.** The sheet ends too soon beyond the outermost corners, and
# its edge runs beside the contour. Right with too little clearance:
# {glue:text}`clearance_broken`; with enough: {glue:text}`clearance_kept`.

# %% tags=["active-ipynb"]
# show("ext_why_clearance")

# %% [markdown]
# Two parallel edges in one window make two Hough peaks that are close, and
# their mean lies between them, on no edge at all; or the trace changes from
# the one to the other. "Half a window" can be read in two ways. If a window
# is 2 r wide, half of it is r, almost half a square here. If r is its size,
# half of it is a quarter of a square, and an edge farther away than that is
# still in the window: right with 0.3 squares of clearance,
# {glue:text}`clearance_0.3`. At 0.05 the two edges are one for the detector:
# {glue:text}`clearance_0.05`.
#
# **First corner, (a).** A half ring. If the user starts at its second
# corner, side 4 is the long arc, and its chord $L_4$ points almost the way
# that the right contour goes. The threshold that should remove the wrong
# contour removes the right one. Right from there:
# {glue:text}`first_corner_broken`; from c1, where side 4 is straight:
# {glue:text}`first_corner_kept`.

# %% tags=["active-ipynb"]
# show("ext_why_first_corner")

# %% [markdown]
# **First corner, (b).** Here the columns bow. At c1 the wrong contour is
# more than 15° from $L_4$, so it is not removed, and it is closer to $L_1$
# than the right one, because side 1 is a long arc. Right from c1:
# {glue:text}`wrong_contour_broken`; from c2:
# {glue:text}`wrong_contour_kept`. Note that side 4 of c1 is the *straighter*
# one. The advice to start where side 4 is straightest is not the condition;
# the condition is about both contours.

# %% tags=["active-ipynb"]
# show("ext_why_wrong_contour")

# %% [markdown]
# **Direction.** One half ring, clicked in all eight ways. From c1 clockwise,
# side 4 is straight; counterclockwise it is the arc. Right:
# {glue:text}`direction_kept` and {glue:text}`direction_broken`. It is not
# the direction that counts, but which side comes last.

# %% tags=["active-ipynb"]
# show("ext_why_direction")

# %% [markdown]
# In these three cases the condition of 3.1.2 foretells the outcome of
# {glue:text}`foretold` runs: lost on side 1 where it is broken, and not lost
# there where it is kept.

# %% [markdown]
# **Window.** Right with the published radius: {glue:text}`window_kept`; with
# 0.3 of it: {glue:text}`window_broken`; with three times as much:
# {glue:text}`window_other`.

# %% tags=["active-ipynb"]
# show("ext_why_window")

# %% [markdown]
# A small window takes small steps, and turns about with every jagged edge.
# With 0.3 of the radius the commonest end is
# "{glue:text}`window_broken_stage`". ("End not reached" means that the steps,
# six for every square, are used up; this limit is ours.) A large one holds
# several contours, each bent: the peaks are smeared, and a line across two
# contours may win. How much room there is between: right with 0.7 of the
# published radius {glue:text}`window_0.7`, with 1.5 times as much
# {glue:text}`window_1.5`.
#
# **Curvature.** One bend, divided into fewer or more squares, its arcs
# clicked as columns. Right with large squares:
# {glue:text}`curvature_broken`; with small ones:
# {glue:text}`curvature_kept`.

# %% tags=["active-ipynb"]
# show("ext_why_curvature")

# %% [markdown]
# The window is about half a square, so it grows with the squares. In a large
# one several bent edges lie side by side. None of them is a line; what the
# Hough transform finds instead touches an outer one, too far from the
# centre to be taken ($t_3$). Growing the window makes it worse.
#
# **Variation of size.** Right with squares of 1 : 6 along a side:
# {glue:text}`size_variation_broken`; with 1 : 3:
# {glue:text}`size_variation_kept`.

# %% tags=["active-ipynb"]
# show("ext_why_size_variation")

# %% [markdown]
# $t_8$ is 0.8 of half the *mean* square. The smallest squares are smaller,
# and two corners become one. It begins before the smallest square is as
# small as $t_8$: a corner is often detected more than once, some pixels
# apart, and these stand between. With still more variation the window no
# longer fits at all: along the short side it reaches over several small
# squares and the trace changes the row.
#
# **Blur and noise.** Right with a blur of 14 px: {glue:text}`blur_noise_broken`;
# with 1 px: {glue:text}`blur_noise_kept`; with noise of 80 grey levels:
# {glue:text}`blur_noise_other`.

# %% tags=["active-ipynb"]
# show("ext_why_blur_noise")

# %% [markdown]
# They fail differently. Blur leaves no steep gradient, so a little noise
# counts as edges too, and the trace wanders. Noise leaves the long edges,
# and makes corners where there are none.
#
# ### The failures of 3.3.1
#
# The same diagnosis at levels of [Fig. 3.11](#fig_3_11) where trials are
# lost. These are other trials and fewer. A corner counts as
# found within 8 px there, and never beyond half a square.

# %% tags=["active-ipynb"]
# show("ext_why_sweeps")

# %% [markdown]
# The stage that loses the most trials: under noise
# {glue:text}`sweep_noise_sd`; blur {glue:text}`sweep_blur_px`; small squares
# {glue:text}`sweep_squares_across`; a wide field {glue:text}`sweep_fov_deg`;
# yaw {glue:text}`sweep_yaw_deg`. "Outer corner" is the very first step: near
# the click, at the rim where squares are smallest, there is no detected
# corner, or another one. The thesis blames the tracing for the wide field;
# a board lost at its outer corner does not get that far.
#
# ### The orderings of 1.2.1
#
# Two older ways to order corners, on true corners with an error of 0.5 px.
# The first takes the corners nearest to the line between the ends of a row.
# The second places the board by the homography of four clicks, and takes
# the corner nearest to each place.

# %% tags=["active-ipynb"]
# show_code(order_by_joining_line, order_by_homography, row_margin)

# %% tags=["active-ipynb"]
# show("ext_why_orderings")

# %% [markdown]
# On a sector the first fails in a trial from an arc of
# {glue:text}`line_arc` on, the second from {glue:text}`homography_arc`. Seen
# by the fisheye of 3.3.1, from fields of view of {glue:text}`line_fov` and
# {glue:text}`homography_fov`. The criterion of 1.2.1 as a number is the
# margin: how much farther the nearest corner of another row is from the
# line than the row's own farthest. Its sign tells the outcome of the first
# ordering in {glue:text}`line_criterion` of the trials. The second fails when
# a corner is more than about half a square from its place. The default board
# of 3.3.1, against which these may be held, has 134°.
#
# ## Reading and limits
#
# The boards are constructed to break one thing alone; in a
# photograph several break at once. The stage is the *first* that went wrong
# and need not be the only one. What a stage is called depends on two
# thresholds, those of the table above. Clicks have an error of a
# pixel; worse clicks lose outer corners. Suppression, Canny and Harris
# values are ours where the thesis has none (`celect_thresholds`).

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis gives no number for any of this; its claims are judged in
# [3.1.2](s1_2_celect.ipynb) and [3.3.2](s3_2_grid_sets.ipynb).

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** Side 1 is 400 px long and has 9 corners, so $s_1$ is 400 / (1.9 · 9)
# px, and $t_8 = 0.8\,s_1$. How small may its smallest square be, in px,
# before $t_8$ merges its two corners?

# %% tags=["active-ipynb"]
# check(None, **square_task())

# %% [markdown]
# **2.** Side 4 is an arc of a circle, and the right contour leaves the first
# corner along the radius. $L_4$ is the chord of side 4. From which arc on,
# in degrees, is the contour within $t_4$ = 15° of $L_4$?

# %% tags=["active-ipynb"]
# check(None, **arc_task())

# %% [markdown]
# **3.** A contour is an arc with a radius of 470 px. How large may the window
# be, in px, so that the arc stays within $t_5 = 0.1\,r$ of its tangent?

# %% tags=["active-ipynb"]
# check(None, **tangent_task())
