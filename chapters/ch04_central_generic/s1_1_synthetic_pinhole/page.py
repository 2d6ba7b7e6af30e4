# %% [markdown]
# # 4.1.1 Base grid as the image plane of a synthetic pinhole camera
#
# **Question.** Pinhole calibration cannot use the distorted images of a fisheye or a
# mirror camera. The rays of a central camera are straight, however, and meet in one
# point. If a grid takes the role of the image plane, can any pinhole method calibrate
# any central camera?

# %%
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.exercises import (
    focal_task,
    image_task,
    radius_task,
)
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.experiment import (
    CAMERAS,
    SOLVERS,
    TRIALS,
    board_trial,
    camera_of,
    centre_error,
    draw_points,
    interpolated,
    no_lens,
)
from chapters.ch04_central_generic.s1_1_synthetic_pinhole.report import name_values
from chapters.shared.central import SETTINGS, draw_poses
from raxel.calibration import circle, circle_of
from repro.page import check, compared, open_results, show, show_code
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("fig_4_1")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **The image on the base grid is a pinhole image.** A homography fits every pair of
#    grids to {glue:text}`residual:.0e` of the image size. This includes random rays
#    through one point.
# 2. **Two pinhole methods find the true centre.** Without noise their error is at most
#    {glue:text}`exact_mm:.0e` mm. With noise the median ratio of their errors is at
#    most {glue:text}`ratio_most:.3f`.
# 3. **A chessboard as base grid biases the centre only a little.** Squares of 20 mm
#    cause an error of {glue:text}`board.base_mm:.2g` mm. Noise of 0.1 px on per-pixel
#    data causes {glue:text}`board.noise_mm:.2g` mm (medians).

# %% [markdown]
# | question or quantity | thesis | here |
# |---|---|---|
# | image on the base grid | free of distortion | reproduced, also for random rays |
# | centre, any pinhole method | any central camera | reproduced with two methods |
# | grids required | 3 | 3: two give no centre |
# | Sturm-Maybank or Wang-Liu | the former is better | not comparable |
# | chessboard as base grid | biases the centre | yes, by less than 0.1 px noise does |

# %% [markdown]
# ## Terms
#
# - *Central camera*: all rays pass through one point, the *centre* $\mathbf{C}$
#   (single-viewpoint camera).
# - *Base grid*: the calibration target that serves as image plane. It is the plane
#   $z = 0$ of the world frame.
# - *Synthetic pinhole camera*: centre $\mathbf{C}$ with the base grid as image plane.
#   *CGSP*: Central Generic Synthetic Pinhole calibration.
# - *Active grid*: phase-shift structured-light target on a monitor. Each pixel decodes
#   the point that it views.
# - $H$: homography from a grid to the base grid. $K$: camera matrix. $\simeq$: equal up
#   to a factor.
# - *Sturm-Maybank*: calibration from planes with the image of the absolute conic
#   ([4.1.2](s1_2_linear_stage.ipynb)). *Circles*: the second method here, see *Model*.

# %% [markdown]
# ## What the thesis claims
#
# - An additional grid in front of a central camera forms a perspective image without
#   distortion. *Any* pinhole calibration then finds the centre of *any* central camera.
#   Two further grids suffice.
# - The method of Sturm and Maybank {cite}`sturm1999` is more accurate and robust here
#   than that of Wang and Liu (2006).
# - Interpolation on a chessboard would bias the synthetic camera. Active grids need no
#   interpolation.

# %% [markdown]
# ## Model
#
# A ray through $\mathbf{C} = (C_x, C_y, C_z)$ meets the base grid in $(x, y)$ and
# another grid in $\mathbf{q}$. Projection through one point maps lines to lines, so a
# homography relates the two:
#
# $$\begin{bmatrix} x \\ y \\ 1 \end{bmatrix} \simeq
# H \begin{bmatrix} q_x \\ q_y \\ 1 \end{bmatrix}, \qquad
# H \simeq K \,[\,\mathbf{r}_1 \;\; \mathbf{r}_2 \;\;
# \mathbf{t} - \mathbf{C}\,] . \tag{4.4}$$
#
# Here $\mathbf{r}_1$ and $\mathbf{r}_2$ are the directions of the grid's axes and
# $\mathbf{t}$ is its origin. The matrix $K$ contains only the centre:
#
# $$K = \begin{bmatrix} -C_z & 0 & C_x \\ 0 & -C_z & C_y \\ 0 & 0 & 1
# \end{bmatrix} .$$
#
# The principal point is $(C_x, C_y)$, the focal length is $-C_z$, and pixels are
# square. (The thesis prints $+C_z$, which rotates the poses by 180°: erratum E-4.03.)
#
# **Circles.** The plane through $\mathbf{C}$ parallel to a grid cuts the base plane in
# the grid's *vanishing line*. Two orthogonal directions of the grid have vanishing
# points there, which $\mathbf{C}$ views at a right angle. By Thales, $\mathbf{C}$ is on
# a circle, the same for every such pair. Its middle $\mathbf{v}_0$ is on the vanishing
# line, and its plane is orthogonal to that line. Two circles meet in $\mathbf{C}$ and
# in its reflection in the base plane.

# %% tags=["active-ipynb"]
# show_code(circle_of, circle)

# %% [markdown]
# ## Experiment
#
# The 999 rays of a scene start in $\mathbf{C} = (0, 0, 600)$ mm. They meet the base
# grid and two grids, rotated by up to 30° about each axis and shifted by up to 150 mm.
# There is no noise. There are four sources: the radial lens of section 4.1.5 (100°), an
# equidistance fisheye of 183°, a hyperboloid mirror, and random directions without a
# lens.

# %% tags=["active-ipynb"]
# show_code(no_lens, draw_points)


# %%
def exact_trial(condition, rng):
    """The centre's error of both solvers, without noise."""
    points = draw_points(camera_of(condition["camera"]), draw_poses(rng), rng)
    return {solver: centre_error(solver, points) for solver in SOLVERS}


@experiment("exp_c4_any_pinhole", artefact="sec_4_1_1")
def exact_centres(effort):
    """Two solvers on the same exact points, for cameras of every kind."""
    return Plan(exact_trial, crossed(camera=CAMERAS), TRIALS[effort], SETTINGS)


# %% [markdown]
# **Chessboard as base grid.** Squares of 20 mm fill the image of the radial lens. A
# homography for each square interpolates the board point of a pixel. The other two
# grids are exact.

# %% tags=["active-ipynb"]
# show_code(interpolated, board_trial)

# %% [markdown]
# ## A chessboard as the base

# %% tags=["active-ipynb"]
# show("ext_board_as_base")

# %% [markdown]
# ## Discussion
#
# - **Side of the camera.** The reflection of the scene in the base plane fits the same
#   points. The user has to state the camera's side.
# - **Wang and Liu.** The thesis does not describe this method, and the paper was not
#   available. The claim is therefore not comparable. The circles use the same
#   orthogonality differently.
# - **Chessboard.** The claim's test requires an error above 0.1 mm and above the effect
#   of 0.1 px noise. Neither holds for squares of 20 mm. The bias grows with the
#   squares.
#
# ## Summary
#
# The base grid turns every central camera into a pinhole camera, and two different
# pinhole methods find its centre. Wang-Liu is not described and cannot be compared.
# Interpolation between chessboard corners biases the centre, but squares of 20 mm cost
# less than 0.1 px of noise.
#
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again.
#
# **1.** The centre of a camera is $\mathbf{C} = (0, 0, 500)$ mm. What is the $x$
# coordinate of the image of the point $(120, -80, -250)$ on the base grid, in mm?

# %% tags=["active-ipynb"]
# check(None, **image_task())

# %% [markdown]
# **2.** What is the focal length in the matrix $K$ of this synthetic camera, in mm and
# with its sign?

# %% tags=["active-ipynb"]
# check(None, **focal_task())

# %% [markdown]
# **3.** A grid is tilted by 30° against the base grid. What is the radius of the circle
# on which it puts the same centre, in mm?

# %% tags=["active-ipynb"]
# check(None, **radius_task())
