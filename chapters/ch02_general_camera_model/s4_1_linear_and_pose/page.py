# %% [markdown]
# # 2.4.1 and 2.4.2 Algorithm 1: linear stage and pose estimation
#
# **Question.** Generic calibration obtains the ray of every pixel from three
# images of a planar grid in unknown poses. Given are Algorithm 1, two linear
# systems and a pose equation. Do they hold as printed, and what do they return?

# %%
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.exercises import (
    depth_task,
    freedom_task,
    nearer_task,
    solutions_task,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.experiment import (
    BOARDS,
    COLUMNS,
    PITCH_MM,
    ROWS,
    SIZE_PX,
    draw_poses,
    first_three,
    largest_shift,
    locating,
    matrix_a,
    matrix_d,
    overlap,
    real_solutions,
    rows_of_one_grid,
    scored_table,
    view_board,
)
from chapters.ch02_general_camera_model.s4_1_linear_and_pose.report import name_values
from chapters.shared.general import CAMERAS
from raxel.calibration import calibrate_generic
from raxel.geometry import inverse_pose
from repro.page import check, compared, open_results, show_code, show_table, values
from repro.run import Plan, experiment

# %% tags=["active-ipynb"]
# show_table("alg_1")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% tags=["active-ipynb"]
# values()

# %% [markdown]
# **Findings.**
#
# 1. **Algorithm 1 works with unknown poses.** Without noise the poses are
#    recovered to {glue:text}`pose_mm:.0e` mm. The rays of a pinhole are exact
#    to rounding, those of a fisheye to {glue:text}`fisheye_deg:.2g`° (median).
# 2. **The stated ranks are theorems**, and so are the zeros in the null vectors.
# 3. **The printed formula for $C_z$ is wrong.** It gives a negative square in
#    {glue:text}`negative` of {glue:text}`scenes` scenes. With one index
#    corrected it is right, up to rounding.
# 4. **Three points have up to eight pose solutions** in pairs of opposite
#    sign, as stated, if all rays share one origin (E-2.15).

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | rank of the first system | 12 | {glue:text}`s2_4_1_rankA:.0f`, proved |
# | rank of the second system | 5 | {glue:text}`s2_4_1_rankD:.0f`, proved |
# | zeros in its null vectors | simulated | proved |
# | linear stage, no noise | exact | exact if corrected |
# | pose solutions | 8, in pairs | {glue:text}`s2_4_2_solutions:.0f`, pairs if central |

# %% [markdown]
# ## Terms
#
# - *Base grid*: the grid whose frame is the world frame, with plane $z = 0$.
# - $\mathbf{C} = (C_x, C_y, C_z)$: the *centre* of projection in that frame.
# - $R^n$, $\mathbf{t}^n$: rotation and translation of grid $n$ = 2, 3.
# - $V, W$ (grid 2) and $M, N$ (grid 3): the coefficient vectors of
#   [Table 2.1](s4_generic_calibration.ipynb). A prime marks what the data give:
#   $V', W' = \lambda_1 (V, W)$ and $M', N' = \lambda_2 (M, N)$, with unknown
#   $\lambda_1$, $\lambda_2$.
# - *Two-pose method*: two grids with known relative pose
#   ([section 2.3](s3_general_camera.ipynb)).
# - *Well conditioned*: our solution of the same equations with normalised
#   coordinates and least squares.
# - *Central*: all rays pass through one point (single viewpoint).

# %% [markdown]
# ## What the thesis claims
#
# - Three grids in *unknown* poses are enough to calibrate a camera
#   {cite}`sturm2004`, in the six steps of Algorithm 1.
# - The linear stage (2.4.1) solves two systems, of ranks 12 and 5. Entries of
#   the second one's null vectors are zero, "by simulation". Centre and poses
#   follow in closed form (2.23).
# - A further grid's pose follows from three points, with up to eight solutions
#   in pairs of opposite sign (2.4.2).

# %% [markdown]
# ## Model
#
# **Coefficients.** The centre and the points that a pixel sees on three grids
# are on one line. Therefore sums with the coefficients of Table 2.1 vanish for
# every pixel. Two examples are
#
# $$\begin{aligned}
# V_4 &= R^2_{31}, \\
# V_7 &= C_z R^2_{21} - C_y R^2_{31} .
# \end{aligned}$$
#
# The data determine the vectors up to $\lambda_1$ and $\lambda_2$. $V$ and $W$
# share three entries, which fix their common factor.
#
# **The first system.** $C_x$ and $C_y$ are unknowns 1 and 2. The others are
# products, for grid 2
#
# $$\begin{aligned}
# (u_3, u_4) &= \lambda_1 C_z\, (t^2_x - C_x,\; t^2_y - C_y) , \\
# (u_5, u_6, u_7, u_8) &= \lambda_1 C_z\, (R^2_{11}, R^2_{12}, R^2_{21},
# R^2_{22})
# \end{aligned}$$
#
# and for grid 3 likewise $u_9$ to $u_{14}$, with $\lambda_2$.
#
# Every entry of the four vectors then becomes a linear equation. For $V_7$:
#
# $$\begin{aligned}
# V'_7 &= \lambda_1 C_z R^2_{21} - \lambda_1 R^2_{31}\, C_y \\
#      &= u_7 - V'_4\, u_2 .
# \end{aligned}$$
#
# Twelve such rows make the first system, $A \mathbf{u} = \mathbf{x}$ (2.24). The
# print misses a column and misplaces entries (errata E-2.10). In the code,
# `(7, 4, 2, "first", 7)` is the row above: unknown 7 has the factor 1, entry 4
# of $V'$ multiplies unknown 2, and entry 7 is on the right. With `"second"` the
# right side comes from $W'$ or $N'$.

# %% tags=["active-ipynb"]
# show_code(rows_of_one_grid, matrix_a)

# %% [markdown]
# Columns 3 to 14 hold one 1 in each row and column, so the rank is 12 and two
# numbers $l_1$, $l_2$ stay free:
#
# $$\mathbf{u} = \mathbf{a} + l_1 \mathbf{b} + l_2 \mathbf{c} .
# \tag{2.20}$$
#
# Here $\mathbf{a}$ is the shortest solution; $\mathbf{b}$ and $\mathbf{c}$ span
# the null space of $A$.
#
# **The second system** finds $l_1$ and $l_2$. The columns of a rotation are
# orthonormal: three equations for each grid, quadratic in $l_1$ and $l_2$. With
# every product as an unknown they are linear, $D\mathbf{v} = \mathbf{y}$, with
# six rows (garbled in print, E-2.13) and
#
# $$\begin{aligned}
# \mathbf{v} = (&l_1,\; l_2,\; l_1 l_2,\; l_1^2,\; l_2^2, \\
# &C_z^2,\; \lambda_1^2 C_z^2,\; \lambda_2^2 C_z^2)^T .
# \end{aligned} \tag{2.25}$$

# %% tags=["active-ipynb"]
# show_code(matrix_d)

# %% [markdown]
# **Zeros in the null vectors.** $D$ has rank 5, and yet $l_1$ and $l_2$ are
# fixed. Each equation is linear in $C_x$ and $C_y$ except for a multiple of
# $C_x^2 + C_y^2 + C_z^2$. So $l_1 l_2$, $l_1^2$, $l_2^2$ and $C_z^2$ have columns
# that are multiples of one column. Five of eight columns are independent, and a
# null vector can be non-zero at these four only.
#
# **The pose of a further grid** (2.4.2). Ray $i$ starts in $\mathbf{A}_i$ with
# direction $\mathbf{r}_i$ and meets the grid at an unknown depth $\lambda_i$ (not
# a factor above). The distances $d_{ij}$ of three of its points are known:
#
# $$\begin{aligned}
# \|(&\mathbf{A}_i + \lambda_i \mathbf{r}_i) \\
# &- (\mathbf{A}_j + \lambda_j \mathbf{r}_j)\|^2 = d_{ij}^2 .
# \end{aligned} \tag{2.26}$$
#
# These quadratic equations have at most eight complex solutions. If all rays
# start in one point, no term has odd degree, so the negative of a solution is a
# solution. Grunert's formulas {cite}`haralick1994` assume these pairs. The
# experiment solves (2.26) by elimination instead.

# %% tags=["active-ipynb"]
# show_code(real_solutions)

# %% [markdown]
# ## Experiment
#
# **Algorithm 1.** A camera views chessboards whose corners are
# projected without noise. Step 2 interpolates between corners by a homography,
# which is exact for a pinhole only, so the run uses a pinhole and a fisheye.

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


@experiment("alg_1_run", artefact="alg_1")
def algorithm_run(effort):
    """The six steps of Algorithm 1 on synthetic boards, for two cameras."""
    settings = {
        "image_px": [SIZE_PX, SIZE_PX],
        "boards": BOARDS,
        "corners": [COLUMNS, ROWS],
        "pitch_mm": PITCH_MM,
    }
    return Plan(run_trial, [{"camera": "pinhole"}, {"camera": "fisheye"}], 1, settings)


# %% [markdown]
# **The claims** are tested in random scenes without noise, and on random triplets
# of rays with common or distinct anchor points (the $\mathbf{A}_i$ of (2.26)).

# %% [markdown]
# ## Discussion
#
# **Algorithm 1.** A fisheye distorts the cells between corners, so its rays have
# an error without noise. The median interpolation error on the board is
# {glue:text}`locate_mm:.2f` mm.
#
# **No known motion.** With a known motion that is wrong by 1 mm, the two-pose
# method has a median ray error of {glue:text}`wrong_deg:.2f`°. Unknown poses
# leave one ambiguity: the user specifies on which side of the base grid the
# camera is (E-2.14).
#
# **Exactness.** The numerator of $C_z$ is printed as $u_6 u_6 + u_7 u_8$ and
# must be $u_5 u_6 + u_7 u_8$ (E-2.11). The corrected formulas divide by
# $V'_4 V'_5$, which is small if a grid is tilted about one axis only, and lose
# digits. In the worst scene they miss the tolerance of $10^{-6}$ mm, so the
# claim of exactness *differs*; the well-conditioned form meets it. The printed
# $t_z$ divides by $C_y$, which may be zero (E-2.12).
#
# Section 2.5.1 adds noise.

# %% [markdown]
# ## Summary
#
# Algorithm 1 calibrates a central camera from three grids in unknown poses.
# Its ranks and pairs of solutions can be proved. Several printed equations are
# wrong. Corrected and well conditioned, the linear stage is exact up to
# rounding.

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
# **1.** One of the twelve rows of $A\mathbf{u} = \mathbf{x}$ is lost. How
# many free numbers has the solution now?

# %% tags=["active-ipynb"]
# check(None, **freedom_task())

# %% [markdown]
# **2.** A camera is 300 mm above the centre of a horizontal equilateral triangle
# with sides of 100 mm. What is the depth of each corner along its ray, in mm?

# %% tags=["active-ipynb"]
# check(None, **depth_task())

# %% [markdown]
# **3.** How many real solutions has (2.26) for that triangle? Count those
# behind the camera too. The upright one and its mirror image are two.

# %% tags=["active-ipynb"]
# check(None, **solutions_task())

# %% [markdown]
# **4.** In some solutions in front of the camera, one corner is nearer than
# the other two. What is its depth, in mm?

# %% tags=["active-ipynb"]
# check(None, **nearer_task())
