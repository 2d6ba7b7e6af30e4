# %% [markdown]
# # 2.2 Camera distortions: a zoo of models
#
# **Question.** There are many formulas for how a camera bends the picture.
# Which cameras can each of them describe, which not, and with how many
# numbers?

# %%
from chapters.ch02_general_camera_model.s2_camera_models.exercises import (
    cubics_task,
    edge_task,
    omega_task,
    sphere_task,
)
from chapters.ch02_general_camera_model.s2_camera_models.results import name_values
from chapters.ch02_general_camera_model.s2_camera_models.trials.planes import (
    plane_trial,
)
from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import (
    ROOM,
    room_trial,
)
from raxel.cameras import (
    DivisionCamera,
    KannalaBrandtCamera,
    QuadricMirrorCamera,
    ScaramuzzaCamera,
    UnifiedSphereCamera,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("ext_zoo_room")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - The zoo has {glue:text}`cameras` cameras, one for every model that the
#   section names and the library has. All of them turn pixels into rays and
#   points into pixels.
# - Models that displace points of the image plane end before 90° from the
#   axis, as the thesis says. That is geometry and has nothing to do with
#   fitting.
# - {glue:text}`not_central` of the cameras have no single centre: mirrors off
#   their focus, a ball, plane and bent mirrors, X-slits, the pushbroom camera
#   and a lens whose pupil moves.

# %% [markdown]
# ## What the thesis claims
#
# - Radial distortion is the largest distortion of an ordinary lens, and
#   (2.4) with one or two coefficients describes it. Other models of the
#   image plane are the division model, with one number, and the rational
#   cubics of Hartley and Saxena, with "80 parameters".
# - A fisheye needs a projection law from rays to points, (2.5) to (2.9).
#   "The image displacement approach will fail for fisheye cameras with FOVs
#   greater than or equal to 180°, since in these cases there is no single
#   plane with which all the camera rays can intersect." The complete model
#   of Kannala and Brandt {cite}`kannala2006` has 6 to 23 parameters.
# - Mirrors: central models by shape, one sphere for all of them, and a
#   polynomial (2.10). Mirrors off their focus, flat mirrors and exotic
#   cameras (X-slits, pushbroom, axial) are not central.
# - So there are many models, each for its own cameras; section 2.3 replaces
#   them by one that fits all.

# %% [markdown]
# ## Model
#
# **Displacement in the image plane.** With $\mathbf{p}$ the undistorted
# point and $r = |\mathbf{p}|$,
#
# $$\check{\mathbf{p}} = \mathbf{p} + \mathbf{p}(k_1 r^2 + k_2 r^4 + \dots).
# \tag{2.4}$$
#
# **A law of the angle.** With $\theta$ from the axis and $\varphi$ around
# it,
#
# $$\mathbf{p} = r(\theta)\,(\cos\varphi, \sin\varphi)^T, \tag{2.5}$$
#
# $$r = f\theta, \tag{2.6}$$
#
# $$r = 2f \sin(\theta/2), \tag{2.7}$$
#
# $$r = 2f \tan(\theta/2), \tag{2.8}$$
#
# $$\check{\mathbf{p}} = \mathbf{p} + \Delta_r(\theta, \varphi) +
# \Delta_t(\theta, \varphi). \tag{2.9}$$
#
# **A ray for a point.** A polynomial in the radius gives the third
# coordinate of the ray:
#
# $$\begin{aligned}
# \mathbf{r} \simeq (&\check{\mathbf{p}}';\; a_0 + a_2
# |\check{\mathbf{p}}'|^2 \\
# &+ \dots + a_n |\check{\mathbf{p}}'|^n).
# \end{aligned} \tag{2.10}$$
#
# **A mirror.** The library does not fit a formula to a mirror. It reflects
# the viewer's ray in the quadric.
#
# Each model is one class with `rays` (pixels to rays) and `project` (points
# to pixels). Its text says what ends where.

# %% tags=["active-ipynb"]
# show_code(DivisionCamera, ScaramuzzaCamera, UnifiedSphereCamera)

# %% [markdown]
# ## Experiment
#
# One camera of every model, {glue:text}`cameras` in all, has an image of
# 200 × 200 pixels. Eight of them photograph one room. The claim that no plane is
# met by all rays from 180° on has an experiment of its own, in
# `trials/planes.py` beside this page: a linear programme looks for a normal that
# all rays of a bundle have in front.

# %%
SAMPLES = {"quick": 16, "full": 64}


@experiment("exp_zoo_room", artefact="sec_2_2")
def pictures(effort):
    """One room through eight cameras, without lens blur or noise."""
    return Plan(room_trial, crossed(model=ROOM, samples=[SAMPLES[effort]]), 1)


# %% tags=["active-ipynb"]
# show_code(plane_trial)

# %% [markdown]
# ## Reading and limits
#
# - **Where plane models end.** The linear programme finds a plane for
#   every bundle up to {glue:text}`plane_fov:.0f`° and for none from 180°
#   on. The claim is geometry and does not depend on a fit. The division
#   model and the FOV model see less than 90° from the axis. The *formula*
#   of the FOV model goes on beyond, but as published it displaces points
#   of the image plane, and the library keeps to that.
# - **Counting.** Parameters are counted in different ways. Hartley and
#   Saxena's "80" are four cubics of the three coordinates of a point, 20
#   coefficients each; two of them are scales that cancel. Most of the
#   cameras that these describe are not central. The library has the central
#   ones, with {glue:text}`cubic` parameters. Of the {glue:text}`kb` of Kannala
#   and Brandt three are scales that cancel, too. The look-up table of
#   section 2.3 has two numbers for every pixel with a ray,
#   {glue:text}`table_size` here.
# - **Signs.** A negative $a_0$ in (2.10), the sign of the published
#   toolbox, means that the middle of the image looks along $-z$.
# - **Two coefficients of a form.** Of the 10-parameter model of Shah and
#   Aggarwal the section gives the order of its two polynomials, not the
#   formula. The zoo has a form with both: one polynomial for the radius, one
#   for the turn about the axis, five terms each.
# - **Not built.** Barreto's sphere with division, circular panoramas, and
#   networks of cameras.

# %% tags=["active-ipynb"]
# show_code(KannalaBrandtCamera, QuadricMirrorCamera.rays)

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
# **1.** The FOV model is $r = \arctan(2 \tan\theta \tan(\omega/2)) /
# \omega$. For which $\omega$, in degrees, is it the law of equidistance?

# %% tags=["active-ipynb"]
# check(None, **omega_task())

# %% [markdown]
# **2.** The zoo's hyperboloid has the semi-axes 30 mm (along its axis) and
# 20 mm. Which $\xi$ has the unified sphere that equals it?

# %% tags=["active-ipynb"]
# check(None, **sphere_task())

# %% [markdown]
# **3.** The zoo's division model has $f = 130$ px and $\lambda_1 = -0.25$. At
# which radius in the image, in pixels, would it reach 90°?

# %% tags=["active-ipynb"]
# check(None, **edge_task())

# %% [markdown]
# **4.** How many free numbers have two ratios of cubic polynomials of
# $(X/Z, Y/Z)$, if a common factor of numerator and denominator does not
# count?

# %% tags=["active-ipynb"]
# check(None, **cubics_task())
