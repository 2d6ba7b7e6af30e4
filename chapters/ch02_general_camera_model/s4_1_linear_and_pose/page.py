# %% [markdown]
# # 2.4.1 and 2.4.2 Algorithm 1: its linear stage, and pose estimation
#
# **Question.** Three pictures of a flat grid, taken from the hand: is that
# enough for the ray of every pixel? The thesis says yes, in six steps.
# Which equations carry them, do they hold as printed, and what comes out?

# %% tags=["hide-cell"]
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.exercises import (
    depth_of_triangle,
    freedom_of_a,
    nearer_depth,
    solutions_of_triangle,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.results import (
    name_values,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.quadrics import (
    real_solutions,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.steps import (
    first_three,
    largest_shift,
    locating,
    overlap,
    scored_table,
    view_board,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.systems import (
    matrix_a,
    matrix_d,
)
from chapters.shared.algorithm_1 import (
    BOARDS,
    COLUMNS,
    PITCH_MM,
    ROWS,
    SIZE_PX,
    draw_poses,
)
from chapters.shared.general_cameras import CAMERAS
from raxel.calibration import calibrate_generic
from raxel.geometry import inverse_pose
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% [markdown]
# ## What the thesis claims
#
# - Three grids in *unknown* poses are enough to calibrate a camera
#   {cite}`sturm2004`; no motion control is needed. Algorithm 1 lists the
#   six steps.
# - The linear stage (2.4.1) has two systems. The first has 14 unknowns and
#   rank 12, so its solution has two free numbers $l_1, l_2$. The second has
#   rank 5, and certain entries of its null vectors are always zero, "by
#   simulation", which gives $l_1$ and $l_2$. Centre and poses follow in
#   closed form (2.23).
# - The pose of a further grid follows from three rays, up to eight
#   solutions in four pairs of opposite sign (2.4.2).

# %% [markdown]
# ## Model
#
# **The first system.** Put in the four vectors of Table 2.1, at a common
# scale, and every row of the first system has three terms. With $u$ the 14
# unknowns $C_x$, $C_y$ and products like $\lambda_1 C_z R^2_{11}$, the
# first row for grid 2 reads
#
# $$u_7 - V'_4\, u_2 = V'_7 ,$$
#
# and so on for twelve rows (2.24). The print has 13 columns for 14
# unknowns, and entries in wrong places (errata E-2.10); the rows below are
# the corrected ones. The code builds them from a list, one line per row:

# %% tags=["active-ipynb"]
# show_code(matrix_a)

# %% [markdown]
# Columns 3 to 14 hold one 1 in each row and in each column. So the rank is
# 12 whatever the other two columns hold, and the free numbers are $C_x$ and
# $C_y$: they fix everything else.
#
# **The second system.** A rotation has columns of equal length at right
# angles. For each of the two grids that is three equations, quadratic in
# $u$. With $u = a + l_1 b + l_2 c$ (2.20), and with all products counted as
# unknowns of their own, they are linear (2.25; the print is garbled, see
# E-2.13):
#
# $$\begin{aligned}
# v = (&l_1,\; l_2,\; l_1 l_2,\; l_1^2,\; l_2^2, \\
# &C_z^2,\; \lambda_1^2 C_z^2,\; \lambda_2^2 C_z^2)^T .
# \end{aligned} \tag{2.25}$$

# %% tags=["active-ipynb"]
# show_code(matrix_d)

# %% [markdown]
# **Why the null vectors have zeros.** The thesis found them by simulation.
# There is a reason. Each of the six equations contains
# $C_x^2 + C_y^2 + C_z^2$, with one coefficient of its own, and the other
# terms are linear in $C_x, C_y$. Along $l_1, l_2$ the products
# $l_1 l_2, l_1^2, l_2^2$ enter through $C_x^2 + C_y^2$ only. So the columns
# of the three products and of $C_z^2$ are multiples of one column: of eight
# columns five are independent, and a null vector can touch only these four.
# That holds for any basis of the null space of $A$, orthonormal or not.
#
# **Three points.** The distances of three grid points are known. With rays
# $\mathbf{A}_i + \lambda_i \mathbf{r}_i$,
#
# $$\begin{aligned}
# \|(&\mathbf{A}_i + \lambda_i \mathbf{r}_i) \\
# &- (\mathbf{A}_j + \lambda_j \mathbf{r}_j)\|^2 = d_{ij}^2 ,
# \end{aligned} \tag{2.26}$$
#
# three quadrics in three depths, hence eight solutions at most (counted in
# complex numbers). With a common anchor point no term is of odd degree, so
# with $\lambda$ also $-\lambda$ is a solution. The library uses Grunert's
# formulas {cite}`haralick1994`, which write the pairs down from the start.
# A test must not assume what it tests: the experiment solves (2.26) by
# elimination, for any anchor points, and knows nothing of pairs.

# %% tags=["active-ipynb"]
# show_code(real_solutions)

# %% [markdown]
# ## Experiment
#
# **Algorithm 1, one run.** A camera looks at chessboards. The corners are
# projected, not detected: there is no noise, only what the method itself
# leaves. The library gets corners and nothing else. The run is made for a
# pinhole and for a fisheye, because step 2 finds what a pixel between the
# corners sees by a homography, which is exact for a pinhole only.

# %% tags=["active-ipynb"]
# show_code(first_three)


# %%
def run_trial(condition, rng):
    """One run of the six steps, and what each of them gave."""
    camera = CAMERAS[condition["camera"]](SIZE_PX, SIZE_PX)
    grids = draw_poses(rng)
    views = [view_board(camera, T) for T in grids]
    found = calibrate_generic(
        views, SIZE_PX, SIZE_PX, rng=rng, interpolation="homographic"
    )
    truth = inverse_pose(grids[found.used[0]]) @ grids[found.used]
    return {
        "overlap": overlap(views),
        "locate": locating(camera, views, grids),
        **first_three(views, found.used, truth),
        "others": {
            "boards": len(found.used) - 3,
            "left_out": len(found.left_out),
            "pose_mm": largest_shift(found.T_base_grid, truth),
        },
        "table": scored_table(camera, found.camera),
    }


@experiment("alg_1_run", artefact="alg_1", shards={"quick": 2, "full": 2})
def algorithm_run(effort):
    """The six steps of Algorithm 1 on synthetic boards, for two cameras."""
    settings = {
        "image_px": [SIZE_PX, SIZE_PX],
        "boards": BOARDS,
        "corners": [COLUMNS, ROWS],
        "pitch_mm": PITCH_MM,
    }
    conditions = [{"camera": "pinhole"}, {"camera": "fisheye"}]
    return Plan(run_trial, conditions, 1, settings)


# %% [markdown]
# **The claims** have experiments of their own, beside this page: random
# scenes without noise (`trials/stage.py`), and random triplets of rays with
# a common anchor point and with distinct ones (`trials/quadrics.py`).

# %% [markdown]
# ## Table

# %% tags=["active-ipynb"]
# show_table("alg_1")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# ## Reading and limits
#
# - **Algorithm 1** reproduces the rays of the pinhole to rounding. With the
#   fisheye, {glue:text}`fisheye_deg:.2g`° are left, although there is no
#   noise: step 2 maps a pixel onto the board by the homography of its cell,
#   and a fisheye bends the cell ({glue:text}`locate_mm:.2f` mm, median).
#   Smaller cells, or an active grid, make that error smaller. This is a
#   limit of chessboards, not of the rays.
# - **No motion control.** From the intersections alone the two poses come
#   out to {glue:text}`pose_mm:.0e` mm in all {glue:text}`scenes` scenes.
#   The two-pose method, told a $T_1$ that is wrong by 1 mm, has rays that
#   are wrong by {glue:text}`wrong_deg:.2f`° (median) on the same data. That
#   is more than [section 2.3](s3_general_camera.ipynb) finds for a
#   millimetre: there the second grid is 200 to 400 mm behind the first,
#   here the two points of a ray lie about 110 mm apart, and the same shift
#   turns a shorter join by more. The price of doing without $T_1$ is a
#   reflection: the data do not tell on which side of the base grid the
#   camera is (E-2.14), and the user has to say it.
# - **Ranks.** $A$ has rank 12 by its form. $D$ has rank 5: the fifth
#   singular value is at least {glue:text}`fifth:.2g` of the first, the
#   sixth at most {glue:text}`sixth:.0e` (columns at unit norm). The null
#   vectors vanish where the thesis says, to {glue:text}`null_entry:.0e`,
#   and to {glue:text}`null_any:.0e` in bases that are not orthonormal. In
#   an orthonormal basis the column of $l_1 l_2$ is zero as well
#   ({glue:text}`column_zero:.0e` of that of $l_1^2$). What the thesis saw
#   in simulation is a theorem.
# - **Exactness.** With the corrected formulas the centre is exact to
#   {glue:text}`corrected:.0e` mm, and to {glue:text}`conditioned:.0e` mm in
#   the well-conditioned form. The digits between the two are the price of
#   $C_z$ through the product $V'_4 V'_5$, which is small when a grid is
#   tilted about one of its axes only. $t_z$ is taken as $C_z + V'_6/\lambda$ here; the
#   printed form divides by $C_y$ (E-2.12).
# - **As printed, $C_z$ fails**: the numerator $u_6 u_6 + u_7 u_8$ gives a
#   negative square in {glue:text}`negative` of {glue:text}`scenes` scenes,
#   and elsewhere a depth that is off by {glue:text}`wrong_mm:.0f` mm
#   (median). With $u_5 u_6$ in place of $u_6 u_6$ it is right (E-2.11).
# - **Eight solutions.** Of {glue:text}`triplets` triplets with a common
#   anchor point {glue:text}`four` have four real solutions and
#   {glue:text}`eight` have eight, always in pairs of opposite sign; the
#   most is {glue:text}`most`. Grunert's formulas give the same sets in
#   {glue:text}`grunert` of them. With distinct anchor points the most is
#   {glue:text}`distinct_most`, {glue:text}`distinct_two` triplets have only
#   two, and {glue:text}`distinct_paired` have a pair: the thesis's words
#   hold for central cameras (E-2.15).
#   A count is as good as the solver. Real solutions come in an even number,
#   so an odd one betrays a lost root. A first version eliminated along one
#   ray only and lost some where two roots nearly coincide; elimination
#   along each of the three rays in turn finds them.
# - **Limits.** All of this is without noise; section 2.5.1 adds it. The
#   library's pose from three rays is for central cameras, like the rest of
#   its generic method.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell.
#
# **1.** How many free numbers has the solution of the first system,
# $A\mathbf{u} = \mathbf{x}$?

# %% tags=["active-ipynb"]
# check(None, expected=freedom_of_a, hint="unknowns less rank")

# %% [markdown]
# **2.** An equilateral triangle with sides of 100 mm lies at right angles
# to the axis of a camera 300 mm above its middle. What is the depth of each
# corner along its ray?

# %% tags=["active-ipynb"]
# check(None, expected=depth_of_triangle, hint="half of it: circumradius")

# %% [markdown]
# **3.** How many real solutions has (2.26) for that triangle? Count those
# behind the camera too. The upright one and its mirror image are two.

# %% tags=["active-ipynb"]
# check(None, expected=solutions_of_triangle, hint="which corner sticks out?")

# %% [markdown]
# **4.** In three of the four solutions ahead of the camera, one corner is
# nearer than the other two. What is its depth?

# %% tags=["active-ipynb"]
# check(None, expected=nearer_depth, hint="a circle about a corner cuts a ray twice")
