# %% [markdown]
# # 5.1 The flexible mirror camera model
#
# **Question.** A general camera model would have to measure the ray of each pixel anew
# whenever a mirror bends. The thesis models the shape of the mirror with few
# coefficients. Which shapes agree with given viewing rays and scene rays, or scene
# points, and what removes the ambiguity?

# %%
from chapters.ch05_flexible_mirror.s1_model.exercises import (
    defect_task,
    double_task,
    pairs_task,
)
from chapters.ch05_flexible_mirror.s1_model.experiment import (
    DEFECT_DEPTHS_MM,
    FAR_DEPTHS,
    ON_EDGE_SD_PX,
    PAIRS,
    PICK_SD_PX,
    SLOPES2,
    anchored,
    beam_trial,
    defect_trial,
    depth_trial,
    edge_trial,
    ends_trial,
    far_trial,
    fixed_trial,
    pairs_trial,
    shapes_trial,
)
from chapters.ch05_flexible_mirror.s1_model.report import name_values
from raxel.calibration import orthogonality_rows, shape_with_clamp
from repro.page import check, compared, open_results, show, show_code
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("fig_5_2")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Ray directions determine the mirror up to scale.** A mirror and its scaled copies
#    have the same directions.
# 2. **Scene points leave a family of shapes.** A mirror that is 10 % nearer or farther
#    differs by {glue:text}`shapes.off:.1f` mm (RMS) after the best scaling. Residuals
#    do not show the difference.
# 3. **One fixed point removes both ambiguities.** Without noise the linear equations
#    then find a spline mirror exactly.
# 4. **Ten pairs of rays suffice for 21 coefficients if well spread.** Ten random pairs
#    have a median rank of {glue:text}`pairs.random:g` in place of 20.

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | pairs of rays for 21 coefficients | about half as many | 10, well spread |
# | cubic beam, usual deflection | accurate | error {glue:text}`beam.usual:.2f` % |
# | cubic beam, steepest stated slope | accurate | error {glue:text}`beam.end:.1f` % |
# | deflection error, points as picked | large | {glue:text}`edge.pick.picked:.3f` mm |
# | deflection error, points on a line | small | {glue:text}`edge.pick.refined:.3f` mm |

# %% [markdown]
# ## Terms
#
# - *Viewing ray* $V_l$: unit vector from the camera to the mirror point $S$. *Scene
#   ray* $V_r$: unit vector from there to the scene. $N$: unit normal.
# - $u$, $v$: image coordinates; as indices, derivatives. $D(u,v)$: distance of the
#   mirror along the viewing ray.
# - $f_i$, $g_j$: quadratic B-splines. $c_{ij}$: coefficients. *Knot interval*: piece
#   between two knots.
# - *Fixed point*: point of the mirror whose position is known, here at the clamp.
# - *Elastica*: exact shape of a thin bent sheet. *Squared slope*: largest $(dv/dx)^2$
#   of the height $v$ over the position $x$.
# - *Rank*: number of independent equations. For 21 coefficients up to scale it is 20.
# - *Rig A*: the primary simulated set-up ([5.3.3a](s3_3_calibration.ipynb)).

# %% [markdown]
# ## What the thesis claims
#
# - A thin plate, clamped at one edge and bent slightly, is a cubic (5.1).
# - The shape follows from viewing and scene rays by linear equations, up to scale.
#   About half as many pairs as coefficients suffice. The first and last knot intervals
#   need features (points seen in the mirror).
# - A fixed point removes the ambiguities of depth and of shape (Fig. 5.2).
# - Directions to distant points do not change with the shape (5.28). Mirror defects
#   have more effect at larger depths (5.3.2).

# %% [markdown]
# ## Model
#
# The law of reflection is
#
# $$ V_r = V_l - 2\,(V_l\cdot N)\,N, \qquad
# N = \frac{V_l - V_r}{\lVert V_l - V_r\rVert}. \tag{5.8} $$

# %% tags=["active-ipynb"]
# show("fig_5_1")

# %% [markdown]
# The *full model* is a spline of the distance:
#
# $$ S(u, v) = D(u, v)\,V_l(u, v), \qquad
# D(u,v) = \sum_{i=1}^{K_f}\sum_{j=1}^{K_g} c_{ij}\,f_i(u)\,g_j(v), \tag{5.3, 5.4} $$
#
# with $K_fK_g=7\times3=21$ coefficients. The normal is orthogonal to both tangents,
# $S_u\cdot N=S_v\cdot N=0$ (5.9, 5.10). Each pair of rays gives two linear equations in
# $c_{ij}$ {cite}`halstead1996`. Misprints of (5.16) and (5.25) are corrected (E-5.04,
# E-5.05).

# %% tags=["active-ipynb"]
# show_code(orthogonality_rows)

# %% [markdown]
# **Ambiguity of depth**, Fig. 5.2a. Every multiple of a solution $D$ is a solution.
#
# **Ambiguity of shape**, Fig. 5.2b. After a deflection only the scene points are known.
# The normal halves the angle between the viewing ray and the direction to the scene
# point, so the slope follows from the distance. This differential equation of first
# order has one solution for each initial distance.

# %% tags=["active-ipynb"]
# show_code(anchored)

# %% [markdown]
# **Constraint.** The mirror does not move at the clamp. With the known distance there,
# the coefficients are one particular solution plus the directions that leave it
# unchanged (5.21). An ordinary least-squares problem remains.

# %% tags=["active-ipynb"]
# show_code(shape_with_clamp)

# %% [markdown]
# ## Experiment
#
# Each statement has its own experiment without noise, on 20 random spline mirrors or on
# a beam in its plane of bending. Only the test of fixed points has noise: points are
# picked on rig A with an error of 1 px.


# %%
DRAWS = {"quick": 3, "full": 20}


@experiment("exp_c5_beam_cubic", artefact="sec_5_1_1")
def beams(effort):
    """Cubic and elastica at rising slopes."""
    return Plan(beam_trial, crossed(slope2=SLOPES2), 1)


@experiment("exp_c5_depth_ambiguity", artefact="fig_5_2")
def depths(effort):
    """Ambiguity of ray directions."""
    return Plan(depth_trial, [{}], DRAWS[effort])


@experiment("exp_c5_shape_ambiguity", artefact="fig_5_2")
def shapes(effort):
    """Mirrors at several distances that show the same points."""
    return Plan(shapes_trial, [{}], 1)


@experiment("exp_c5_fix_removes", artefact="sec_5_1_3")
def fixed(effort):
    """One fixed point: remaining ambiguity, and recovery of the truth."""
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
    """Fixed points picked by hand, unchanged and refined to a line."""
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
    return Plan(far_trial, crossed(depth=FAR_DEPTHS), 1)


@experiment("exp_c5_aberr_depth", artefact="fig_5_6")
def defects(effort):
    """A defect of fixed slope, at rising depths."""
    return Plan(defect_trial, crossed(depth=DEFECT_DEPTHS_MM), 1)


# %% [markdown]
# ## Validity of the cubic beam

# %% tags=["active-ipynb"]
# show("ext_beam_cubic")

# %% [markdown]
# The cubic replaces the curvature by $d^2v/dx^2$, which holds for small slopes only.

# %% [markdown]
# ## Discussion
#
# **Number of pairs.** $\lceil (K_f K_g - 1)/2\rceil$ pairs can suffice: 10 for 21
# coefficients (E-5.07). But each spline function is zero over most of the mirror. Real
# features are not optimally spread, and many more are needed.
#
# **Ends.** The first and last functions along each axis extend over one interval alone.
# Without features there the rank falls.
#
# **Picked points.** The thesis moves hand-picked fixed points onto a line, because
# small errors would have large effects. The method reads the fixed distance at the pick
# (5.19), so the refinement makes no difference. If the distance belongs to the true
# point, the error is larger without refinement, and some runs are rejected.
#
# **Distant scenes.** The rotation of a scene ray falls as one over a large depth
# ([5.3.1](s3_1_simulated.ipynb) has small ones). A defect displaces the visible point
# in proportion to the depth.
#
# **Limits.** Exact splines without noise are the best case.

# %% [markdown]
# ## Summary
#
# Rays or scene points alone do not determine a mirror's shape. With one fixed point,
# few pairs of rays suffice if they cover the end intervals. The fixed points need no
# refinement under the method's own convention.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Run all cells of this notebook (`make lab`). Put an answer in place of `None`, and run
# that cell again.
#
# **1.** A mirror has 9 x 4 spline coefficients. How many well spread pairs of viewing
# and scene rays are enough for its shape?

# %% tags=["active-ipynb"]
# check(None, **pairs_task())

# %% [markdown]
# **2.** A defect rotates the mirror by 1 mrad. By how many mm does it displace the
# visible point on a wall 3 m away?

# %% tags=["active-ipynb"]
# check(None, **defect_task())

# %% [markdown]
# **3.** Two mirrors have the same viewing and scene rays. One is
# `curve(16.7).distances([0.0])` mm away at the middle of the image, the other is twice
# as far away at the clamp. How far away is the other at the middle, in mm?
# (`from chapters.ch05_flexible_mirror.s1_model.experiment import curve`)

# %% tags=["active-ipynb"]
# check(None, **double_task())
