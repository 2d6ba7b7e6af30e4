# %% [markdown]
# # 4.1.1 Any camera as a pinhole: the base grid as image plane
#
# **Question.** A fisheye bends straight lines, and methods for ordinary
# cameras cannot use its pictures. The rays themselves are straight. If one
# grid takes the picture instead of the sensor, can the old methods calibrate
# every camera that has a single centre?

# %%
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.exercises import (
    focal_task,
    picture_task,
    radius_task,
)
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.results import name_values
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.trials import (
    CAMERAS,
    SOLVERS,
    TRIALS,
    board_trial,
    camera_of,
    centre_off,
    draw_points,
    interpolated,
    no_lens,
)
from chapters.shared.wide_angle import SETTINGS, draw_poses
from raxel.calibration.linear.synthetic_pinhole import circle, circle_of
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_4_1")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - The picture on the base grid is a pinhole's, whatever the lens does: all
#   pairs of points lie on one homography, to {glue:text}`residual:.0e` of
#   the picture's size. Even rays without any lens, at random, give one.
# - Two different pinhole methods find the true centre from it, to
#   {glue:text}`exact_mm:.0e` mm, for a fisheye of 183° and for a mirror too.
# - With noise the two differ little: the median ratio of their errors lies
#   between {glue:text}`ratio_least:.3f` and {glue:text}`ratio_most:.3f`. The
#   method that the thesis found worse is not described there.
# - A chessboard as the base does bias the centre, but with squares of 20 mm
#   before the lens of 4.1.5 by {glue:text}`board.base_mm:.2g` mm only; 0.1 px
#   of noise on grids read at every pixel does
#   {glue:text}`board.noise_mm:.2g` mm (medians).

# %% [markdown]
# ## What the thesis claims
#
# - Put an additional grid, the **base grid**, before the camera. Where the
#   rays meet it is a picture. Since the rays come from one point, the
#   picture is a perspective one, free of all distortion.
# - So the base grid is the image plane of a **synthetic** pinhole camera. Its
#   centre is the centre of the real camera, and *any* pinhole calibration
#   finds it for *any* central camera. Two further grids suffice. The method
#   is called *Central Generic Synthetic Pinhole* calibration, CGSP.
# - Of two such methods, that of Sturm and Maybank {cite}`sturm1999` is more
#   accurate and robust here than that of Wang and Liu (2006).
# - A chessboard could be the base grid, but interpolation between its
#   corners would bias the synthetic camera; active grids do not need it.

# %% [markdown]
# ## Model
#
# The frame of the base grid is the world: the grid is the plane $z = 0$. The
# camera's centre is $\mathbf{C} = (C_x, C_y, C_z)$. A ray through
# $\mathbf{C}$ meets the base grid in $(x, y)$ and another grid in
# $\mathbf{q}$. A projection through one point keeps straight lines straight,
# so a homography $H$, a $3 \times 3$ matrix, maps the grid to the base:
#
# $$\begin{bmatrix} x \\ y \\ 1 \end{bmatrix} \simeq
# H \begin{bmatrix} q_x \\ q_y \\ 1 \end{bmatrix}, \qquad
# H \simeq K \,[\,\mathbf{r}_1 \;\; \mathbf{r}_2 \;\;
# \mathbf{t} - \mathbf{C}\,] . \tag{4.4}$$
#
# $\simeq$ means equal up to a factor; $\mathbf{r}_1$ and $\mathbf{r}_2$ are
# the directions of the grid's axes, and $\mathbf{t}$ is its origin. The
# matrix $K$ of the synthetic camera holds nothing but the centre:
#
# $$K = \begin{bmatrix} -C_z & 0 & C_x \\ 0 & -C_z & C_y \\ 0 & 0 & 1
# \end{bmatrix} .$$
#
# (The thesis prints $+C_z$, which turns poses by 180°, E-4.03.) In other
# words: principal point $(C_x, C_y)$, focal length $-C_z$, no skew, square
# pixels. [Section 4.1.2](s1_2_linear_stage.ipynb) solves it by the method of
# Sturm and Maybank.
#
# **Another way: circles.** A plane through $\mathbf{C}$, parallel to the
# grid, cuts the base plane in the *vanishing line* of the grid. Two
# directions of the grid at right angles have their vanishing points on it,
# and from $\mathbf{C}$ these two are seen at right angles. So
# $\mathbf{C}$ lies on a circle (Thales), for every such pair of directions
# on the same one. Its middle $\mathbf{v}_0$ lies on the vanishing line, and
# its plane stands at right angles to that line. Each grid gives one circle;
# two meet in $\mathbf{C}$ and in its mirror image behind the base plane.

# %% tags=["active-ipynb"]
# show_code(circle_of, circle)

# %% [markdown]
# ## Experiment
#
# Rays start in $\mathbf{C} = (0, 0, 600)$ mm and meet three grids: the base,
# and two that are turned by up to 30° about each axis and shifted by up to
# 150 mm. There are 999 of them, and no noise. Four kinds of camera send them:
# the radial lens of section 4.1.5 (100°), an equidistance fisheye of 183°, a
# hyperboloid mirror that looks sideways at the grids, and no lens at all:

# %% tags=["active-ipynb"]
# show_code(no_lens, draw_points)


# %%
def exact_trial(condition, rng):
    """The centre's error of both solvers, without noise."""
    points = draw_points(camera_of(condition["camera"]), draw_poses(rng), rng)
    return {solver: centre_off(solver, points) for solver in SOLVERS}


@experiment("exp_c4_any_pinhole", artefact="sec_4_1_1")
def exact_centres(effort):
    """Two solvers on the same exact points, for cameras of every kind."""
    return Plan(exact_trial, crossed(camera=CAMERAS), TRIALS[effort], SETTINGS)


# %% [markdown]
# **A chessboard as the base.** Squares of 20 mm fill the picture of the radial
# lens. A pixel's point on the board comes from the four corners of its cell,
# by a homography. The other two grids are read exactly, so that all of the
# centre's error is due to the base.

# %% tags=["active-ipynb"]
# show_code(interpolated, board_trial)

# %% [markdown]
# ## A chessboard as the base

# %% tags=["active-ipynb"]
# show("ext_board_as_base")

# %% [markdown]
# ## Reading and limits
#
# - **Which side?** The reflection of everything in the base plane fits the
#   same points. The user has to say on which side of the base grid the camera
#   is; the simulations put it at $C_z > 0$.
# - **Sturm-Maybank or another.** The thesis says how Wang and Liu's method
#   did, not what it does, and the paper could not be had. So its claim is not
#   decided. The circles stand in: they use the same facts about right angles
#   in another way, and are neither better nor worse by much.
# - **How much a chessboard costs.** On the board of the claim the median point
#   is off by {glue:text}`board.gap_mm:.2f` mm. With all three grids
#   interpolated, the centre is off by {glue:text}`board.all_mm:.2g` mm. Before
#   a fisheye of 150°, a base of such squares moves its centre by
#   {glue:text}`fisheye.base_mm:.2g` mm, 0.1 px of noise by
#   {glue:text}`fisheye.noise_mm:.2g` mm. So there is a bias, as the thesis says,
#   but squares of 20 mm are small at this distance. It grows with the squares
#   (see the figure), and no number of rays makes it smaller.
# - **No lens at all** is a case of its own: neighbouring pixels may look
#   anywhere. Interpolation would be meaningless there; a grid that is read at
#   every pixel does not care.

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
# **1.** A camera stands at $\mathbf{C} = (0, 0, 500)$ mm. What is the $x$ of
# the picture of the point $(120, -80, -250)$ on the base grid, in mm?

# %% tags=["active-ipynb"]
# check(None, **picture_task())

# %% [markdown]
# **2.** What is the focal length in the matrix $K$ of this synthetic camera,
# in mm and with its sign?

# %% tags=["active-ipynb"]
# check(None, **focal_task())

# %% [markdown]
# **3.** A grid is tilted against the base by 30°. What is the radius of the
# circle on which it puts the same centre, in mm?

# %% tags=["active-ipynb"]
# check(None, **radius_task())
