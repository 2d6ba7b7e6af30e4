# %% [markdown]
# # 5.1 A camera before a mirror that bends: what its rays say about its shape
#
# **Question.** A camera looks into a mirror that bends. The general model of
# chapter 2 would have to measure the ray of every pixel anew after each
# bending. The thesis describes the mirror's shape instead, by few numbers.
# Which shapes can a bent mirror have, what do the directions of rays say
# about them, and what do they leave open?

# %%
from chapters.ch05_flexible_mirror.s1_model.exercises import (
    defect_task,
    double_task,
    pairs_task,
)
from chapters.ch05_flexible_mirror.s1_model.results import name_values
from chapters.ch05_flexible_mirror.s1_model.trials.edges import (
    ON_EDGE_SD_PX,
    PICK_SD_PX,
    edge_trial,
)
from chapters.ch05_flexible_mirror.s1_model.trials.plane import (
    DEFECT_DEPTHS_MM,
    FAR,
    SLOPES2,
    anchored,
    beam_trial,
    defect_trial,
    far_trial,
    shapes_trial,
)
from chapters.ch05_flexible_mirror.s1_model.trials.splines import (
    PAIRS,
    depth_trial,
    ends_trial,
    fixed_trial,
    pairs_trial,
)
from raxel.calibration.mirror.linear import orthogonality_rows, shape_with_clamp
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_5_2")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Directions alone give a mirror up to its size. Scene points in place of
#   scene directions leave a family of mirrors, one for every distance of its
#   first point, and they are no copies of each other: 10 % nearer or farther,
#   the shape differs by {glue:text}`shapes.off:.1f` mm (RMS) after the best
#   scaling. No residual tells: the points lie on the scene rays of each.
# - One fixed point takes away both. Without noise a spline mirror is then
#   found to {glue:text}`fixed.linear:.0e` mm by the linear equations.
# - For the 21 coefficients of the thesis {glue:text}`pairs` pairs of rays are
#   enough if they are well spread. At random so few give a rank of
#   {glue:text}`pairs.random:g` in place of {glue:text}`pairs.full` (median).
# - A beam's cubic is {glue:text}`beam.usual:.2f` % off the exact curve at the
#   thesis's usual deflection, and {glue:text}`beam.end:.1f` % at the steepest
#   slope that it states.

# %% [markdown]
# ## What the thesis claims
#
# - A thin plate, clamped at one edge and bent a little, is a cubic (5.1).
# - The shape follows from viewing and scene rays by linear equations, up to
#   scale. About half as many pairs of rays as coefficients are enough, and
#   features are needed in the first and last knot intervals.
# - Two ambiguities arise, of depth and of shape (Fig. 5.2). A fixed point, such
#   as the clamp, removes both.
# - The directions in which distant points are seen do not change with the
#   mirror's shape (5.28). Defects of the mirror do more harm the farther away
#   the scene is (5.3.2).

# %% [markdown]
# ## Model
#
# A *viewing ray* $V_l$, a unit vector, leaves the camera's centre and meets the
# mirror at $S$. There it is reflected and goes on as *scene ray* $V_r$. With
# the unit normal $N$ the law of reflection is
#
# $$ V_r = V_l - 2\,(V_l\cdot N)\,N, \qquad
# N = \frac{V_l - V_r}{\lVert V_l - V_r\rVert}. \tag{5.8} $$

# %% tags=["active-ipynb"]
# show("fig_5_1")

# %% [markdown]
# The *full model* gives the distance of the mirror along each viewing ray, as
# a spline of the image coordinates $u$ and $v$:
#
# $$ S(u, v) = D(u, v)\,V_l(u, v), \qquad
# D(u,v) = \sum_{i=1}^{K_f}\sum_{j=1}^{K_g} c_{ij}\,f_i(u)\,g_j(v), \tag{5.3, 5.4} $$
#
# with $K_f$ basis functions $f_i$ along $u$ and $K_g$ functions $g_j$ along
# $v$. They are quadratic B-splines here, as in the thesis, and the numbers
# $c_{ij}$ are all that has to be found: 21 of them for 7 x 3 functions. The
# normal is at right angles to both tangents, $\partial S/\partial u \cdot N =
# \partial S/\partial v \cdot N = 0$ (5.9, 5.10). Every pair of rays gives one
# equation of each kind, linear in $c_{ij}$ {cite}`halstead1996`. Two prints
# need mending: a transpose is missing in (5.16), and (5.25) stacks the
# coefficients in another order (E-5.04, E-5.05).

# %% tags=["active-ipynb"]
# show_code(orthogonality_rows)

# %% [markdown]
# **What is left open.** The equations have no right side: with $D$ every
# multiple of it is a solution. That is the ambiguity of depth, panel (a).
#
# The other one is of the situation after bending, where the scene points are
# known and not the scene rays. Take a viewing ray and any place on it. The
# way from there to the scene point is the scene ray, and both rays together
# give the normal. So the slope of the mirror follows from its distance: a
# differential equation of first order, which has one solution for every
# distance at its start, panel (b).

# %% tags=["active-ipynb"]
# show_code(anchored)

# %% [markdown]
# **What closes it.** At the clamp the mirror does not move. If its distance
# there is known, coefficients are written as one solution of that equation and
# a combination of those directions that leave it as it is (5.21). All that
# remains is an ordinary least-squares problem.

# %% tags=["active-ipynb"]
# show_code(shape_with_clamp)

# %% [markdown]
# ## Experiment
#
# Each statement has an experiment of its own, without noise: mirrors that are
# splines exactly, and a beam in the plane of its bending. 20 mirrors are drawn
# where anything is drawn.

# %%
DRAWS = {"quick": 3, "full": 20}


@experiment("exp_c5_beam_cubic", artefact="sec_5_1_1")
def beams(effort):
    """Cubic and elastica at rising slopes."""
    return Plan(beam_trial, crossed(slope2=SLOPES2), 1)


@experiment("exp_c5_depth_ambiguity", artefact="fig_5_2")
def depths(effort):
    """What directions leave open."""
    return Plan(depth_trial, [{}], DRAWS[effort])


@experiment("exp_c5_shape_ambiguity", artefact="fig_5_2")
def shapes(effort):
    """Mirrors through several places that show the same points."""
    return Plan(shapes_trial, [{}], 1)


@experiment("exp_c5_fix_removes", artefact="sec_5_1_3")
def fixed(effort):
    """One fixed point: is anything open, and is the truth found?"""
    return Plan(fixed_trial, [{}], DRAWS[effort])


@experiment(
    "exp_c5_edge_refine",
    artefact="sec_5_1_3",
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
)
def picked_edges(effort):
    """Fixed points picked by hand, as they are and refined to a line."""
    settings = {"pick_sd_px": PICK_SD_PX, "on_edge_sd_px": ON_EDGE_SD_PX}
    return Plan(edge_trial, [{}], {"quick": 3, "full": 50}[effort], settings)


@experiment("exp_c5_min_pairs", artefact="sec_5_1_2")
def pairs(effort):
    """Rank over the number of pairs of rays."""
    return Plan(pairs_trial, crossed(pairs=PAIRS), DRAWS[effort])


@experiment("exp_c5_end_knots", artefact="sec_5_2_2")
def ends(effort):
    """Rank without the features of an end interval."""
    cases = [((7, 3), "u"), ((7, 5), "u"), ((7, 5), "v")]
    conditions = [
        {"shape": list(shape), "axis": axis, "end": end}
        for shape, axis in cases
        for end in ("first", "last")
    ]
    return Plan(ends_trial, conditions, DRAWS[effort])


@experiment("exp_c5_lin_ok_far", artefact="sec_5_2_2")
def far(effort):
    """Scene rays of distant points before and after bending."""
    return Plan(far_trial, crossed(depth=FAR), 1)


@experiment("exp_c5_aberr_depth", artefact="fig_5_6")
def defects(effort):
    """A defect of fixed slope, seen at rising depths."""
    return Plan(defect_trial, crossed(depth=DEFECT_DEPTHS_MM), 1)


# %% [markdown]
# ## How far a cubic is right

# %% tags=["active-ipynb"]
# show("ext_beam_cubic")

# %% [markdown]
# The beam's formula takes the bending moment at $x$ for the curvature times the
# stiffness, and the curvature for $d^2v/dx^2$. The second holds for small
# slopes only. The *elastica* keeps the curvature as it is, and the length of
# the sheet. Compared at the same deflection, the two stay within 2 % up to
# a squared slope of {glue:text}`beam.largest:g` in this list, the largest that
# the thesis's simulations have. By the same force they are closer still.

# %% [markdown]
# ## Reading and limits
#
# **Counting pairs.** Each pair has two equations and the scale stays open, so
# that $\lceil (K_f K_g - 1)/2\rceil$ pairs can be enough, 10 for 21
# coefficients, not 10.5 (E-5.07). But each function is zero over most of the
# mirror, and a pair says nothing about functions that are zero where it is. So
# it counts where the pairs lie, and with real features far more of them are
# needed.
#
# **Ends.** The first and the last function along each axis live in one
# interval alone. Without features there nothing says what they do, and the
# rank falls. Inside, a neighbour's functions reach over an empty interval.
#
# **Picked points.** The fixed points are picked by hand, and the thesis moves
# them onto a line, since small errors there would do much harm. On the rig of
# geometry A, with picks 1 px off, the deflection is wrong by
# {glue:text}`edge.pick.picked:.3f` mm as picked and by
# {glue:text}`edge.pick.refined:.3f` mm refined (medians), where the value that is
# kept is read at the pick (5.19): a point beside the clamp hardly moves. Where
# the value belongs to the true point and the pick puts it elsewhere, the
# refined line leaves {glue:text}`edge.point.refined:.3f` mm, and of the picks as
# they are {glue:text}`edge.refused:.0f` % are refused: features and clamp do not
# fit each other.
#
# **Far scenes.** The angle by which a scene ray turns falls as one over the
# depth (log-log slope {glue:text}`far.slope:.3f` from 10 to
# {glue:text}`far.most:g` camera distances). Nearer by, the camera's own
# distance counts; see [5.3.1](s3_1_simulated.ipynb). A defect of 1 mrad turns
# the scene ray by 2 mrad at any depth: {glue:text}`defect.250:.1f` mm at
# 250 mm, {glue:text}`defect.5000:.0f` mm at the 5 m of the thesis's Fig. 5.6.
# That sets how far away a grid may be.
#
# **Limits.** No noise here, and mirrors from the spline's own space: what is
# shown is what the equations can tell at best. A physical mirror is none of
# these splines; how much that costs is the subject of the sections on
# experiments.

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
# **1.** A mirror has 9 x 4 spline coefficients. How many pairs of viewing and
# scene rays are enough for its shape, if they are well spread?

# %% tags=["active-ipynb"]
# check(None, **pairs_task())

# %% [markdown]
# **2.** A defect turns the mirror by 1 mrad. How many mm off is what one sees
# there, on a wall 3 m from the mirror?

# %% tags=["active-ipynb"]
# check(None, **defect_task())

# %% [markdown]
# **3.** Two mirrors have the same viewing and scene rays. One is
# `curve(16.7).distances([0.0])` mm away at the middle of the picture; the
# other is twice as far away at the clamp. How far away is it at the middle,
# in mm? (`from chapters.ch05_flexible_mirror.s1_model.trials.plane import
# curve`)

# %% tags=["active-ipynb"]
# check(None, **double_task())
