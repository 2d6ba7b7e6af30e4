# %% [markdown]
# # 2.2 Camera distortions: a collection of models
#
# **Question.** Many parametric models describe how a camera distorts the
# image. Given are the models that section 2.2 of the thesis names, each
# implemented as one camera. Which cameras can each model describe, which not,
# and with how many parameters?

# %%
from chapters.ch02_general_camera_model.s2_camera_models.exercises import (
    cubics_task,
    edge_task,
    omega_task,
    sphere_task,
)
from chapters.ch02_general_camera_model.s2_camera_models.experiment import (
    ROOM,
    plane_trial,
    room_trial,
)
from chapters.ch02_general_camera_model.s2_camera_models.report import name_values
from raxel.cameras import (
    DivisionCamera,
    KannalaBrandtCamera,
    QuadricMirrorCamera,
    ScaramuzzaCamera,
    UnifiedSphereCamera,
)
from repro.page import check, compared, open_results, show, show_code
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("ext_zoo_room")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **All models work in both directions.** The collection has
#    {glue:text}`cameras` cameras, one for each implemented model. Each maps
#    pixels to rays and points to pixels.
# 2. **Image-plane models end before 90° from the axis**, as the thesis states.
#    This follows from geometry and does not depend on a fit.
# 3. **{glue:text}`not_central` cameras are non-central**: mirrors off their
#    focus, a ball, plane and bent mirrors, X-slits, pushbroom, and a lens with
#    entrance-pupil shift.

# %% [markdown]
# | question | thesis | here |
# |---|---|---|
# | plane for all rays | below 180° | {glue:text}`plane_fov:.0f`° yes, 180° no |
# | rational cubic model, parameters | 80 | {glue:text}`cubic`, central cameras only |
# | Kannala-Brandt, parameters | 6 to 23 | {glue:text}`kb`, three of them redundant |
# | ray table, parameters | – | {glue:text}`table_size`, two for each ray |

# %% [markdown]
# ## Terms
#
# - *Image-plane model*: displaces points of the image plane (radial, division,
#   rational cubic). *Projection law*: maps the angle from the axis to an image
#   radius.
# - $\mathbf{p}$, $\check{\mathbf{p}}$: undistorted and distorted image point;
#   $r$ or $|\mathbf{p}|$: image radius.
# - $\theta$, $\varphi$: angle from the optical axis and around it; $f$: focal
#   length.
# - $k_i$, $a_i$: radial and polynomial coefficients; $\Delta_r$, $\Delta_t$:
#   radial and tangential displacement.
# - *FOV*: the full field of view. *FOV model*: the published one-parameter
#   model of that name.
# - *Central*: all rays pass through one point (single viewpoint).

# %% [markdown]
# ## What the thesis claims
#
# - Radial distortion dominates in an ordinary lens, and (2.4) with one or two
#   coefficients describes it. Other image-plane models are the division model,
#   with one parameter, and the rational cubics of Hartley and Saxena, with "80
#   parameters".
# - A fisheye needs a projection law, (2.5) to (2.9). Displacement in the image
#   plane "will fail for fisheye cameras with FOVs greater than or equal to
#   180°", since no single plane intersects all the camera rays. The complete
#   model of Kannala and Brandt {cite}`kannala2006` has 6 to 23 parameters.
# - Mirrors have central models by shape, one sphere for all of them, and a
#   polynomial (2.10). Mirrors off their focus, flat mirrors and exotic cameras
#   (X-slits, pushbroom, axial) are not central.
# - Each model fits its own cameras; section 2.3 replaces them by one model.

# %% [markdown]
# ## Model
#
# **Displacement in the image plane**, with $r = |\mathbf{p}|$:
#
# $$\check{\mathbf{p}} = \mathbf{p} + \mathbf{p}(k_1 r^2 + k_2 r^4 + \dots).
# \tag{2.4}$$
#
# **Projection laws:**
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
# **A ray for an image point.** A polynomial in the radius gives the third
# coordinate of the ray:
#
# $$\begin{aligned}
# \mathbf{r} \simeq (&\check{\mathbf{p}}';\; a_0 + a_2
# |\check{\mathbf{p}}'|^2 \\
# &+ \dots + a_n |\check{\mathbf{p}}'|^n).
# \end{aligned} \tag{2.10}$$
#
# **Mirrors.** The library reflects the camera's ray in the quadric.
#
# Each model is one class with `rays` (pixels to rays) and `project` (points
# to pixels). Its documentation states its limits.

# %% tags=["active-ipynb"]
# show_code(DivisionCamera, ScaramuzzaCamera, UnifiedSphereCamera)

# %% [markdown]
# ## Experiment
#
# Each camera of the collection has an image of 200 × 200 pixels. Eight of
# them render one room. A separate experiment, `experiment.py`, tests the
# claim about 180°: a linear programme searches for a plane normal with which
# all rays of a bundle make an acute angle.

# %%
SAMPLES = {"quick": 16, "full": 64}


@experiment("exp_zoo_room", artefact="sec_2_2")
def room_images(effort):
    """One room through eight cameras, without lens blur or noise."""
    return Plan(room_trial, crossed(model=ROOM, samples=[SAMPLES[effort]]), 1)


# %% tags=["active-ipynb"]
# show_code(plane_trial)

# %% [markdown]
# ## Discussion
#
# - **Limits of image-plane models.** The linear programme finds a plane for
#   every bundle below 180° and for none from 180° on. The division model and
#   the FOV model see less than 90° from the axis. The *formula* of the FOV
#   model continues, but as published it displaces points of the image plane,
#   and the library does the same.
# - **Parameter counts.** The "80" of Hartley and Saxena are four cubics of
#   three coordinates with 20 coefficients each. Two are scales that cancel.
#   Most of these cameras are non-central; the library has the central ones. In
#   the complete model of Kannala and Brandt three scales cancel, too. The
#   look-up table has two numbers for every pixel with a ray.
# - **Signs.** A negative $a_0$ in (2.10), as in the published toolbox, means
#   that the image centre looks along $-z$.
# - **Shah and Aggarwal.** The section gives the order of the two polynomials
#   of this 10-parameter model, not the formula. The collection has one
#   polynomial for the radius and one for the rotation about the axis, with
#   five terms each.
# - **Not implemented.** Barreto's sphere with division, circular panoramas,
#   and networks of cameras.

# %% tags=["active-ipynb"]
# show_code(KannalaBrandtCamera, QuadricMirrorCamera.rays)

# %% [markdown]
# ## Summary
#
# Every implemented model of the section maps pixels to rays and points to
# pixels, and each describes its own class of cameras only. The claim that no
# plane meets all rays from 180° on is a geometric fact and holds. The number
# of parameters depends on how redundant scales are counted.

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
# **2.** The hyperboloid of the collection has the semi-axes 30 mm (along its
# axis) and 20 mm. Which $\xi$ has the equivalent unified sphere?

# %% tags=["active-ipynb"]
# check(None, **sphere_task())

# %% [markdown]
# **3.** The division model of the collection has $f = 130$ px and
# $\lambda_1 = -0.25$. At which radius in the image, in pixels, would it reach
# 90°?

# %% tags=["active-ipynb"]
# check(None, **edge_task())

# %% [markdown]
# **4.** How many free parameters have two ratios of cubic polynomials of
# $(X/Z, Y/Z)$, if a common factor of numerator and denominator does not
# count?

# %% tags=["active-ipynb"]
# check(None, **cubics_task())
